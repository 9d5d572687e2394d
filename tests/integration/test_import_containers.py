"""`tumble import` of binary recordings: the run file is that of the same numbers in CSV, to the last bit.

Files are written by nptdms, h5py, rosbags, mcap, pyarrow, numpy and scipy; those of autopilots here, as PX4 and
ArduPilot publish their formats (docs.px4.io/main/en/dev_log/ulog_file_format; libraries/AP_Logger/LogStructure.h).
"""

import functools
import os
import re
import shlex
import struct
import subprocess
import sys

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import ROOT
from recordings import Habits, recording

from tumble.model import built_in

pytestmark = [pytest.mark.python, pytest.mark.toolchain]

GRAVITY = 9.80665
EPOCH_NS = 1_760_000_000_000_000_000
QUIET = Habits(rate_hz=50.0, rest_s=(2.0, 3.0), noise_g=1e-4, angle=1e-5, seat=1e-5, bench=0.0, pause=0.0, gap=0.0)
SI = "m/s^2"


@functools.cache
def recorded():
    """Microseconds (rows,) and outputs in m/s^2 (rows, 3), the latter as a logger of single precision has them."""
    schedule = built_in("paper")
    k, u0 = np.asarray(NOMINAL_K) * GRAVITY / 2.0, np.array([0.1, 0.2, 0.3])
    made = recording(schedule, range(18), k, u0, QUIET, np.random.default_rng(1))
    return np.round(made.time_s * 1e6).astype(np.int64), made.outputs.astype(np.float32)


def write_csv(path, unit=SI):
    times, outputs = recorded()
    marks = f" [{unit}]" if unit else ""
    rows = [",".join([repr(time / 1e6), *map(repr, row)]) for time, row in zip(times.tolist(), outputs.tolist())]
    path.write_text("\n".join([f"time [s],ax{marks},ay{marks},az{marks}", *rows, ""]))


def others():
    """Of a second sensor: turned, and of another scale."""
    return np.ascontiguousarray(recorded()[1][:, ::-1] * np.float32(-2))


# Writers: outputs by the name of their source, in single precision where a format has it.


def write_tdms(path, sources, unit=SI):
    nptdms = pytest.importorskip("nptdms", reason="nptdms is not installed")
    told = {"unit_string": unit} if unit else {}
    with nptdms.TdmsWriter(path) as writer:
        for name, outputs in sources.items():
            channels = [nptdms.ChannelObject(name, "time", recorded()[0] / 1e6, {"unit_string": "s"})]
            channels += [nptdms.ChannelObject(name, f"a{axis}", outputs[:, i], told) for i, axis in enumerate("xyz")]
            writer.write_segment(channels)


def write_hdf5(path, sources, unit=SI):
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    with h5py.File(path, "w") as file:
        for name, outputs in sources.items():
            file[f"{name}/time"] = recorded()[0] / 1e6
            file[f"{name}/time"].attrs["units"] = "s"
            file[f"{name}/accel"] = outputs
            if unit:
                file[f"{name}/accel"].attrs["units"] = unit


def write_parquet(path, sources, unit=SI):
    pa = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from pyarrow import parquet

    parquet.write_table(pa.table(table_of(sources, unit)), path)


def write_npz(path, sources, unit=SI):
    np.savez(path, **table_of(sources, unit))


def write_mat(path, sources, unit=""):
    savemat = pytest.importorskip("scipy.io", reason="scipy is not installed").savemat
    savemat(path, {"time": recorded()[0] / 1e6, "accel": next(iter(sources.values()))})


def table_of(sources, unit):
    (outputs,) = sources.values()
    marks = f" [{unit}]" if unit else ""
    return {"time [s]": recorded()[0] / 1e6} | {f"a{axis}{marks}": outputs[:, i] for i, axis in enumerate("xyz")}


def write_ros1(path, sources, unit=SI):
    pytest.importorskip("rosbags", reason="rosbags is not installed")
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer(path) as bag:
        write_bag(bag, store, sources, unit, {}, store.serialize_ros1)


def write_ros2(path, sources, unit=SI, storage="SQLITE3"):
    pytest.importorskip("rosbags", reason="rosbags is not installed")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(path, version=9, storage_plugin=StoragePlugin[storage]) as bag:
        write_bag(bag, store, sources, unit, {"typestore": store}, store.serialize_cdr)


def write_bag(bag, store, sources, unit, options, serialized):
    kind = "sensor_msgs/msg/Imu" if unit else "geometry_msgs/msg/Vector3Stamped"
    options = options or {"typestore": store}
    topics = {name: bag.add_connection(f"/{name}", kind, **options) for name in sources}
    for row, time in enumerate(recorded()[0].tolist()):
        for name, outputs in sources.items():
            message = ros_message(store, kind, EPOCH_NS + 1000 * time, outputs[row].tolist())
            bag.write(topics[name], EPOCH_NS + 1000 * time + 777, serialized(message, kind))


def ros_message(store, kind, time, output):
    types = store.types
    stamp = types["builtin_interfaces/msg/Time"](time // 10**9, time % 10**9)
    header = types["std_msgs/msg/Header"]
    own = header(stamp=stamp, frame_id="imu", **({"seq": 0} if "seq" in header.__dataclass_fields__ else {}))
    vector = types["geometry_msgs/msg/Vector3"]
    if kind != "sensor_msgs/msg/Imu":
        return types[kind](own, vector(*output))
    turned, zeros = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0), np.zeros(9)
    return types[kind](own, turned, zeros, vector(0.1, 0.2, 0.3), zeros, vector(*output), zeros)


def write_mcap(path, sources, unit=SI, encoding="cdr", stamped=True):
    """As recorders that are none of ROS do it: without a profile."""
    pytest.importorskip("rosbags", reason="rosbags is not installed")
    mcap = pytest.importorskip("mcap.writer", reason="mcap is not installed")
    from rosbags.typesys import Stores, get_typestore

    store, kind = get_typestore(Stores.ROS2_HUMBLE if encoding == "cdr" else Stores.ROS1_NOETIC), "sensor_msgs/msg/Imu"
    serialized = store.serialize_cdr if encoding == "cdr" else store.serialize_ros1
    with open(path, "wb") as stream:
        writer = mcap.Writer(stream)
        writer.start(profile="")
        schema = (kind, "ros2msg") if encoding == "cdr" else ("sensor_msgs/Imu", "ros1msg")
        number = writer.register_schema(*schema, b"")
        channels = {name: writer.register_channel(f"/{name}", encoding, number) for name in sources}
        for row, time in enumerate(recorded()[0].tolist()):
            for name, outputs in sources.items():
                at = EPOCH_NS + 1000 * time
                message = ros_message(store, kind, at if stamped else 0, outputs[row].tolist())
                writer.add_message(channels[name], at + 777, bytes(serialized(message, kind)), at + 777)
        writer.finish()


def write_ulog(path, sources, unit=SI):
    """Header, definitions, subscriptions, data."""
    pytest.importorskip("pyulog", reason="pyulog is not installed")

    def message(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    fields = b"uint64_t timestamp;uint32_t device_id;float x;float y;float z;float temperature;"
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 5)]
    parts += [message("B", bytes(40)), message("F", b"sensor_accel:" + fields), message("F", b"sensor_gyro:" + fields)]
    parts += [message("A", struct.pack("<BH", number, number) + b"sensor_accel") for number in range(len(sources))]
    parts += [message("A", struct.pack("<BH", 0, 9) + b"sensor_gyro")]
    for row, time in enumerate(recorded()[0].tolist()):
        for number, outputs in enumerate(sources.values()):
            parts.append(message("D", struct.pack("<HQI4f", number, 123 + time, 7, *outputs[row].tolist(), 25.5)))
        parts.append(message("D", struct.pack("<HQI4f", 9, 123 + time, 7, 0.1, 0.2, 0.3, 25.5)))
    path.write_bytes(b"".join(parts))


def write_dataflash(path, sources, unit=SI):
    """FMT, UNIT, MULT and FMTU, then messages IMU of each instance."""
    pytest.importorskip("pymavlink", reason="pymavlink is not installed")
    layouts = {  # type: name, format of its fields, their names
        0x80: ("FMT", "BBnNZ", "Type,Length,Name,Format,Columns"),
        0x81: ("UNIT", "QbZ", "TimeUS,Id,Label"),
        0x82: ("MULT", "Qbd", "TimeUS,Id,Mult"),
        0x83: ("FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds"),
        0x84: ("IMU", "QBfff", "TimeUS,I,AccX,AccY,AccZ"),
        0x85: ("BARO", "Qf", "TimeUS,Alt"),
    }
    sizes = {"B": "B", "b": "b", "Q": "Q", "f": "f", "d": "d", "n": "4s", "N": "16s", "Z": "64s"}

    def message(kind, *values):
        packed = "<" + "".join(sizes[one] for one in layouts[kind][1])
        return b"\xa3\x95" + bytes([kind]) + struct.pack(packed, *values)

    def length(fields):
        return 3 + struct.calcsize("<" + "".join(sizes[one] for one in fields))

    parts = [
        message(0x80, kind, length(fields), *(text.encode() for text in (name, fields, columns)))
        for kind, (name, fields, columns) in layouts.items()
    ]
    parts += [message(0x81, 0, ord(key), label) for key, label in (("s", b"s"), ("o", b"m/s/s"), ("#", b"instance"))]
    parts += [message(0x82, 0, ord(key), factor) for key, factor in (("F", 1e-6), ("-", 0.0), ("0", 1.0))]
    parts += [message(0x83, 0, 0x84, b"s#ooo" if unit else b"s#---", b"F-000")] if unit is not None else []
    for row, time in enumerate(recorded()[0].tolist()):
        parts += [message(0x84, 123 + time, number, *one[row].tolist()) for number, one in enumerate(sources.values())]
        parts += [message(0x85, 123 + time, 1.5)]
    path.write_bytes(b"".join(parts))


FORMATS = {  # name of a file: how messages call the format, its writer, the source of the first sensor and the second
    "a.tdms": ("TDMS", write_tdms, "one", "two"),
    "a.h5": ("HDF5", write_hdf5, "/one", "/two"),
    "a.ulg": ("ULog", write_ulog, "sensor_accel_0", "sensor_accel_1"),
    "a.bin": ("DataFlash", write_dataflash, "IMU_0", "IMU_1"),
    "a.bag": ("ROS 1 bag", write_ros1, "/one", "/two"),
    "folder": ("ROS 2 bag", write_ros2, "/one", "/two"),
    "a.mcap": ("MCAP", write_mcap, "/one", "/two"),
}
FILES = [name for name in FORMATS if name != "folder"]
FACES = ("mounting,position", *(f"{number},1" for number in (1, 3, 5, 2, 4, 6)))  # +x, +y, +z, -x, -y, -z
TABLES = {"a.parquet": ("Parquet", write_parquet), "a.npz": ("NPZ", write_npz), "a.mat": ("MAT", write_mat)}


@pytest.fixture(scope="module")
def run_of_csv(tmp_path_factory):
    """Its rows."""
    from tumble.cli.main import main

    folder = tmp_path_factory.mktemp("csv")
    write_csv(folder / "a.csv")
    assert main(["import", str(folder / "a.csv"), "--out", str(folder / "run.csv")]) == 0
    return rows_of(folder / "run.csv")


@pytest.mark.parametrize("name", ["a.ulg", "a.bin"])
def test_the_second_sensor_of_an_autopilot_says_which_parameters_are_its(name, tumble, tmp_path):
    _, write, first, second = FORMATS[name]
    write(tmp_path / name, {"one": recorded()[1], "two": others()})
    for source, number in ((first, None), (second, 2)):
        done = tumble(
            "import", tmp_path / name, "--rows", f"source={source}", "--signs=---" if number else "--signs=+++"
        )
        told = " ".join((done.stdout + done.stderr).split())
        assert f"source {source!r} of 2" in told
        assert ("--accelerometer" in told) == (number is not None)
        assert (
            number is None or f"the autopilot's accelerometer {number}: export it with --accelerometer {number}" in told
        )


@pytest.mark.parametrize("name", FORMATS)
def test_apply_takes_the_same_outputs(name, tumble, tmp_path):
    """They become CSV, beside every other column."""
    from tumble.files.run_layout import LayoutOptions
    from tumble.importing.recording import Timing, read

    run, file = tmp_path / "faces.csv", tmp_path / name
    np.savetxt(run, GRAVITY * np.vstack([np.eye(3), -np.eye(3)]), delimiter=",", header="ux,uy,uz", comments="")
    run.write_text("\n".join(f"{row},{text}" for row, text in zip(FACES, run.read_text().splitlines())))
    result = tmp_path / "result.json"
    solved = tumble("solve", run, "--schedule", "hand_laid", "--unit", SI, "--out", result)
    assert solved.returncode == 0, solved.stderr
    FORMATS[name][1](file, {FORMATS[name][2].strip("/").split("_")[0]: recorded()[1]})
    done = tumble("apply", result, file, "--out", tmp_path / "out.csv")
    assert done.returncode == 0, done.stderr
    found = np.genfromtxt(tmp_path / "out.csv", delimiter=",", skip_header=1)[:, -3:]
    outputs = read(str(file), LayoutOptions(), Timing()).outputs
    assert found == pytest.approx(outputs / GRAVITY, abs=1e-8)


def rows_of(run):
    """Of a run file: its header, and all rows as they stand but for the temperature, which few formats have."""
    header, *rows = [line.split(",") for line in run.read_text().splitlines() if not line.startswith("#")]
    at = header.index("temperature") if "temperature" in header else len(header)
    return [",".join(row[:at] + row[at + 1 :]) for row in [header, *rows]]


@pytest.mark.parametrize("name", [*FORMATS, *TABLES])
def test_the_run_file_is_that_of_csv(name, run_of_csv, tumble, tmp_path):
    kind, write = {**FORMATS, **TABLES}[name][:2]
    write(tmp_path / name, {"one": recorded()[1]})
    unit = ("--unit", SI) if name == "a.mat" else ()  # which tells none
    done = tumble("import", tmp_path / name, "--out", tmp_path / "run.csv", *unit)
    assert (done.returncode, done.stderr) == (0, "")
    assert rows_of(tmp_path / "run.csv") == run_of_csv
    assert f"- {kind}: source '{FORMATS[name][2]}'\n" if name in FORMATS else f"- {kind}\n" in done.stdout
    assert "the run file names none" not in done.stdout


def test_text_is_text_whatever_its_name_ends_in(run_of_csv, tumble, tmp_path):
    """As what MATLAB saves with -ascii, in a file NAME.mat."""
    write_csv(tmp_path / "a.mat")
    done = tumble("import", tmp_path / "a.mat", "--out", tmp_path / "run.csv")
    assert (done.returncode, rows_of(tmp_path / "run.csv")) == (0, run_of_csv), done.stderr


def test_a_temperature_goes_along(tumble, tmp_path):
    write_ulog(tmp_path / "a.ulg", {"one": recorded()[1]})
    assert tumble("import", tmp_path / "a.ulg", "--out", tmp_path / "run.csv").returncode == 0
    assert ",25.5\n" in (tmp_path / "run.csv").read_text()


@pytest.mark.parametrize("name", ["a.db3", "a.mcap"])
def test_the_storage_of_a_ros_2_bag_alone(name, run_of_csv, tumble, tmp_path):
    write_ros2(tmp_path / "bag", {"one": recorded()[1]}, storage={"a.db3": "SQLITE3", "a.mcap": "MCAP"}[name])
    (storage,) = (tmp_path / "bag").glob(f"*{os.path.splitext(name)[1]}")
    for log in (storage, tmp_path / "bag"):
        assert tumble("import", log, "--out", tmp_path / "run.csv").returncode == 0
        assert rows_of(tmp_path / "run.csv") == run_of_csv


@pytest.mark.parametrize("options", [{"encoding": "ros1"}, {"stamped": False}])
def test_mcap_of_ros_1_and_without_times_in_headers(options, run_of_csv, tumble, tmp_path):
    write_mcap(tmp_path / "a.mcap", {"one": recorded()[1]}, **options)
    assert tumble("import", tmp_path / "a.mcap", "--out", tmp_path / "run.csv").returncode == 0
    assert rows_of(tmp_path / "run.csv") == run_of_csv


@pytest.mark.parametrize("name", [*FILES, *TABLES])
def test_what_a_file_is_shows_in_its_beginning(name, run_of_csv, tumble, tmp_path):
    """Whatever its name."""
    {**FORMATS, **TABLES}[name][1](tmp_path / name, {"one": recorded()[1]})
    (tmp_path / name).rename(tmp_path / "recording")
    done = tumble("import", tmp_path / "recording", "--out", tmp_path / "run.csv", "--unit", SI)
    assert (done.returncode, done.stderr) == (0, "")
    assert rows_of(tmp_path / "run.csv") == run_of_csv


def write_matlab(path, h5py):
    """As save -v7.3 does: rows and columns exchanged, below 512 bytes of its own."""
    with h5py.File(path, "w", userblock_size=512) as file:
        file["time"] = recorded()[0][np.newaxis] / 1e6
        file["acc"] = recorded()[1].T
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")


def write_netcdf(path, h5py):
    """As netCDF-4 does: dimensions are datasets too."""
    with h5py.File(path, "w") as file:
        file["time"] = recorded()[0] / 1e6
        file["time"].attrs["units"] = "seconds since 2026-01-01"
        file["time"].make_scale("time")
        for place, axis in enumerate("xyz"):
            file[f"a{axis}"] = recorded()[1][:, place]
            file[f"a{axis}"].dims[0].attach_scale(file["time"])


@pytest.mark.parametrize("write", [write_matlab, write_netcdf])
def test_formats_that_are_hdf5(write, run_of_csv, tumble, tmp_path):
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    write(tmp_path / "a.dat", h5py)
    done = tumble("import", tmp_path / "a.dat", "--unit", SI, "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "")
    assert rows_of(tmp_path / "run.csv") == run_of_csv


# Units.


@pytest.mark.parametrize("name", ["a.tdms", "a.h5", "folder", "a.parquet", "a.npz", "a.mat"])
def test_a_unit_that_nobody_says(name, tumble, tmp_path):
    {**FORMATS, **TABLES}[name][1](tmp_path / name, {"one": recorded()[1]}, unit="")
    done = tumble("import", tmp_path / name)
    assert done.returncode == 0
    assert "- unit: not given, and the run file names none either (1 g is 9.803 of it" in " ".join(done.stdout.split())


@pytest.mark.parametrize(("unit", "said"), [("mV", "mV"), ("m/s2", "m/s^2"), ("g", "g")])
@pytest.mark.parametrize("name", ["a.tdms", "a.h5"])
def test_the_unit_is_that_of_the_file(name, unit, said, tumble, refused, tmp_path):
    FORMATS[name][1](tmp_path / name, {"one": recorded()[1]}, unit=unit)
    assert tumble("import", tmp_path / name, "--out", tmp_path / "run.csv").returncode == 0
    assert f"ux [{said}],uy [{said}],uz [{said}]" in (tmp_path / "run.csv").read_text()
    assert "but --unit says V; no number is converted" in refused("import", tmp_path / name, "--unit", "V")


@pytest.mark.parametrize("unit", ["", None])
def test_accelerations_of_dataflash_without_units_are_si(unit, run_of_csv, tumble, tmp_path):
    write_dataflash(tmp_path / "a.bin", {"one": recorded()[1]}, unit=unit)
    assert tumble("import", tmp_path / "a.bin", "--out", tmp_path / "run.csv").returncode == 0
    assert rows_of(tmp_path / "run.csv") == run_of_csv


# Several sources.


@pytest.mark.parametrize("name", FORMATS)
def test_of_two_sensors_one_is_chosen(name, run_of_csv, tumble, tmp_path):
    kind, write, first, second = FORMATS[name]
    write(tmp_path / name, {"one": recorded()[1], "two": others()})
    done = tumble("import", tmp_path / name, "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stdout) == (2, "")
    took, said, heading, *command = done.stderr.splitlines()
    assert took == f"took: {kind}, 2 sources"
    names = f"'{first}, {second}'"
    assert said == f"tumble: {tmp_path / name}: 2 sources have outputs, {names}: --rows source=NAME takes one"
    assert heading == "remedy, if the first source is meant:"
    words = " ".join(" ".join(command).replace("\\", " ").split())
    assert words == f"tumble import {tmp_path / name} --out {tmp_path / 'run.csv'} --rows source={first}"
    assert tumble(*words.split()[1:]).returncode == 0
    assert rows_of(tmp_path / "run.csv") == run_of_csv
    swapped = ("--rows", f"source={second}", "--columns", COLUMNS[name], "--unit", SI, "--signs=---")
    done = tumble("import", tmp_path / name, *swapped, "--out", tmp_path / "other.csv")
    assert (done.returncode, done.stderr) == (0, "")
    assert f"- {kind}: source '{second}' of 2" in done.stdout
    values = [row.split(",")[2:5] for row in rows_of(tmp_path / "other.csv")[1:]]
    assert [[float(one) / -2 for one in row] for row in values] == [
        list(map(float, row.split(",")[2:5])) for row in run_of_csv[1:]
    ]


def swapped_columns(x, z):
    return f"ux={z},uz={x}"


COLUMNS = dict.fromkeys(FORMATS, swapped_columns("ax", "az")) | {
    "a.h5": swapped_columns("accel_x", "accel_z"),
    "a.bin": swapped_columns("AccX", "AccZ"),
}


@pytest.mark.parametrize("name", FORMATS)
def test_a_source_that_is_not_there(name, refused, tmp_path):
    _, write, first, second = FORMATS[name]
    write(tmp_path / name, {"one": recorded()[1], "two": others()})
    said = refused("import", tmp_path / name, "--rows", "source=three")
    assert said == f"tumble: --rows source=three: there is no such source; there are: '{first}, {second}'\n"


def test_of_several_groups_the_one_with_outputs_is_taken(run_of_csv, tumble, tmp_path):
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    write_hdf5(tmp_path / "a.h5", {"one": recorded()[1]})
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file["gyro/rate"] = recorded()[1]
        file["one/serial"] = 17
        file["one/short"] = np.arange(5.0)
        file["link"] = h5py.ExternalLink("b.h5", "/one")
    done = tumble("import", tmp_path / "a.h5", "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "")
    assert "- HDF5: source '/one (4243 rows)' of 2" in done.stdout
    assert rows_of(tmp_path / "run.csv") == run_of_csv


def test_outputs_of_other_names_are_named(run_of_csv, tumble, tmp_path):
    nptdms = pytest.importorskip("nptdms", reason="nptdms is not installed")
    step = {"wf_increment": 0.02}
    with nptdms.TdmsWriter(tmp_path / "a.tdms") as writer:
        for group, names in (("Log", ("P", "Q", "R")), ("Info", ("S", "T", "U"))):
            told = {**step, "unit_string": "m/s^2"}
            channels = [nptdms.ChannelObject(group, name, recorded()[1][:, i], told) for i, name in enumerate(names)]
            writer.write_segment(channels)
    done = tumble("import", tmp_path / "a.tdms")
    columns = "'Log: time [s],P [m/s^2],Q [m/s^2],R [m/s^2]; Info: time [s],S [m/s^2],T [m/s^2],U [m/s^2]'"
    said = f"no source has columns ux, uy and uz, of {columns}: --rows source=NAME takes one, --columns names them"
    assert done.stderr.splitlines()[1] == f"tumble: {tmp_path / 'a.tdms'}: {said}"
    condition = "this source is meant and the outputs are P [m/s^2], Q [m/s^2] and R [m/s^2]"
    assert done.stderr.splitlines()[2] == f"remedy, if {condition}:"
    command = shlex.split(done.stderr.partition("]:\n")[2].replace("\\\n", " "))
    assert command[3:] == ["--columns", "ux=P [m/s^2],uy=Q [m/s^2],uz=R [m/s^2]", "--rows", "source=Log"]
    assert tumble(*command[1:], "--out", tmp_path / "run.csv").returncode == 0
    found = [row.split(",")[:5] for row in rows_of(tmp_path / "run.csv")]
    assert found == [row.split(",")[:5] for row in run_of_csv]  # times differ: the logger's began elsewhere


def test_no_accelerometer(refused, tmp_path):
    for name, lacks in {
        "a.ulg": "ULog without sensor_accel and sensor_combined",
        "a.bin": "DataFlash without messages with AccX, AccY and AccZ",
        "a.bag": "ROS 1 bag without messages of sensor_msgs/Imu, geometry_msgs/AccelStamped and Vector3Stamped",
    }.items():
        FORMATS[name][1](tmp_path / name, {})
        assert refused("import", tmp_path / name) == f"tumble: {tmp_path / name}: {lacks}\n"


@pytest.mark.parametrize("name", FILES)
def test_solve_sends_them_to_import(name, refused, tmp_path):
    kind, write = FORMATS[name][:2]
    write(tmp_path / name, {"one": recorded()[1]})
    advice = f"tumble import {tmp_path / name} --out RUN.csv finds them by the rests"
    said = f"is a recording ({kind}), which has no positions: {advice}"
    assert refused("solve", tmp_path / name) == f"tumble: {tmp_path / name}: {said}\n"


# Files that are damaged, and packages that are missing.


CUTS = (1, 7, 100, 1000)


@pytest.mark.parametrize("name", [*FILES, *TABLES, "a.db3"])
def test_a_file_that_was_cut_is_one_line(name, tumble, tmp_path):
    """Or what is left of it is imported; wherever it was cut, and where bytes of it are others."""
    if name == "a.db3":
        write_ros2(tmp_path / "bag", {"one": recorded()[1]})
        (whole,) = ((one.read_bytes()) for one in (tmp_path / "bag").glob("*.db3"))
    else:
        {**FORMATS, **TABLES}[name][1](tmp_path / name, {"one": recorded()[1]})
        whole = (tmp_path / name).read_bytes()
    rng = np.random.default_rng(3)
    sizes = [*CUTS, *rng.integers(0, len(whole), 8).tolist(), *(len(whole) - cut for cut in CUTS)]
    damaged = [whole[:size] for size in sizes]
    for _ in range(8):
        bytes_of = bytearray(whole)
        for place in rng.integers(0, min(len(whole), 4000), 6):
            bytes_of[place] = rng.integers(0, 256)
        damaged.append(bytes(bytes_of))
    for data in [b"", *damaged]:
        (tmp_path / name).write_bytes(data)
        done = tumble("import", tmp_path / name, "--schedule", "any_pose")
        assert done.returncode in (0, 2) and "Traceback" not in done.stderr
        if done.returncode == 2:
            lines = [line for line in done.stderr.splitlines() if line.startswith("tumble: ")]
            assert len(lines) == 1 and lines[0].startswith(f"tumble: {tmp_path / name}: "), done.stderr
            assert "fault in tumble itself" not in done.stderr


def test_mcap_that_was_cut_is_sent_to_its_own_tool(refused, tmp_path):
    write_mcap(tmp_path / "a.mcap", {"one": recorded()[1]})
    (tmp_path / "a.mcap").write_bytes((tmp_path / "a.mcap").read_bytes()[:50_000])
    said = "MCAP that ends too early: mcap recover saves what is whole"
    assert refused("import", tmp_path / "a.mcap") == f"tumble: {tmp_path / 'a.mcap'}: {said}\n"


def test_a_message_of_no_length_is_no_loop(refused, tmp_path):
    write_dataflash(tmp_path / "a.bin", {"one": recorded()[1]})
    data = (tmp_path / "a.bin").read_bytes()
    (tmp_path / "a.bin").write_bytes(re.sub(rb"(\xa3\x95\x80\x84)[\0-\xff]", rb"\1\0", data, count=1))
    said = "is damaged: DataFlash with a message of no length"
    assert refused("import", tmp_path / "a.bin") == f"tumble: {tmp_path / 'a.bin'}: {said}\n"


def test_a_library_that_dies_is_one_line(tumble, tmp_path):
    """As that of HDF5 does of some files."""
    (tmp_path / "h5py.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    (tmp_path / "a.h5").write_bytes(PACKAGES["h5py"][0])
    path = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("import", tmp_path / "a.h5", PYTHONPATH=path)
    said = f"tumble: {tmp_path}/a.h5: is damaged: the library of HDF5 dies of it\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


def test_modules_beside_the_file_are_not_loaded(run_of_csv, tmp_path):
    """That process is the only one of a command that Python begins by itself."""
    write_hdf5(tmp_path / "a.h5", {"one": recorded()[1]})
    for name in ("numpy", "h5py", "pickle"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('loaded')\n")
    command = [sys.executable, ROOT / "host/python/launch.py", "import", "a.h5", "--out", "run.csv"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert rows_of(tmp_path / "run.csv") == run_of_csv


def test_objects_of_python_are_not_loaded(refused, tmp_path):
    np.savez(tmp_path / "a.npz", ax=np.array([print, 1.0, 2.0], dtype=object))
    said = refused("import", tmp_path / "a.npz")
    assert "not a npz file that can be read: 'Object arrays cannot be loaded when" in said


def test_what_is_only_for_other_recordings(refused, tmp_path):
    write_npz(tmp_path / "a.npz", {"one": recorded()[1]})
    said = refused("import", tmp_path / "a.npz", "--can-id", "0x683")
    assert said == "tumble: --can-id applies to CAN logs, and none is given\n"
    (tmp_path / "empty").mkdir()
    assert refused("import", tmp_path / "empty") == f"tumble: {tmp_path / 'empty'}: a folder, not a file\n"


PACKAGES = {
    "nptdms": (b"TDSm", "TDMS", "nptdms"),
    "h5py": (b"\x89HDF\r\n\x1a\n", "HDF5", "h5py"),
    "pyulog": (b"ULog\x01\x12\x35", "ULog", "pyulog"),
    "pymavlink": (b"\xa3\x95\x80", "DataFlash", "pymavlink"),
    "rosbags": (b"#ROSBAG V2.0\n", "a recording of ROS", "rosbags mcap"),
    "mcap": (b"\x89MCAP0\r\n", "MCAP", "rosbags mcap"),
}


@pytest.mark.parametrize("package", PACKAGES)
def test_without_the_package_a_line_says_what_to_install(package, tumble, tmp_path):
    beginning, what, brought = PACKAGES[package]
    (tmp_path / f"{package}.py").write_text("raise ImportError('none')\n")
    (tmp_path / "log").write_bytes(beginning + bytes(100))
    path = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("import", tmp_path / "log", PYTHONPATH=path)
    assert (done.returncode, done.stdout) == (77, "")
    assert done.stderr == f"tumble: {tmp_path}/log: {what} needs {package}: .venv/bin/pip install {brought}\n"
