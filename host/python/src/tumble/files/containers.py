"""Binary recordings: TDMS, HDF5, ULog, DataFlash, ROS bags, MCAP, Parquet, NPZ and MAT.

Which of them a file is, shows in its beginning. Each reader gives tables, a name for each: of a group of channels, of a
topic, of one of several sensors. The one that has the outputs, or that `--rows source=NAME` chooses, goes on as text,
bit by bit as it was: so columns, units, clocks and labels are found as those of CSV. A library is loaded when such a
file is read.
"""

from __future__ import annotations

import csv
import io
import logging
import os
import pickle
import re
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from tumble.errors import BadInput, NotInstalled, Remedy, UsageError, file_name, needing, quoted
from tumble.files import frames, run_layout
from tumble.files.disk import bounded, opened
from tumble.files.run_layout import LayoutOptions

SOURCE = "source"  # --rows source=NAME
ROS_2, METADATA = "ROS 2 bag", "metadata.yaml"  # in the folder of one
SI = "m/s^2"
_FEWEST_COLUMNS, _MOST_ACROSS = 3, 16  # of a table; of an array in it
_LONGEST_CAUSE = 100
_LONGEST_LIST = 400  # characters
_BEGINNING = 1 << 10  # bytes that show what a file is


@dataclass(frozen=True)
class Table:
    """Columns of one length by name, with their units in brackets."""

    source: str
    columns: dict[str, Any]

    @property
    def text(self) -> bytes:
        """As CSV, numbers with all their digits; a name that would make the header a comment or numbers gets a sign."""
        out = io.StringIO()
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(re.sub(r"^(?=#|[-+\d\s.]*$)", "_", name) for name in self.columns)
        rows.writerows(zip(*(column.tolist() for column in self.columns.values())))
        return out.getvalue().encode("utf-8", "replace")


def read(file: str, kind: str) -> list[Table]:
    """The tables of a file of this kind (`kind_of`), of those of ULog, DataFlash and ROS the ones of accelerometers.
    Raises BadInput, NotInstalled."""
    wanted, reader = _KINDS[kind][1:]
    try:
        with bounded(file), redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            tables = [table for source, columns in reader(file) for table in _tables(source, columns)]
    except (BadInput, NotInstalled):
        raise
    except Exception as error:  # each library has classes of its own for what it does not know
        why = quoted(error, _LONGEST_CAUSE) if str(error) else type(error).__name__
        raise BadInput(f"cannot be read as {kind}: {why}", file) from None
    if not (tables := [table for table in tables if len(table.columns) >= _FEWEST_COLUMNS]):
        raise BadInput(f"{kind} without {wanted}", file)
    return tables


def chosen(tables: list[Table], kind: str, source: str | None, options: LayoutOptions, file: str) -> Table:
    """The table of the source that the user names, else the only one, or the only one that has the outputs. Raises
    UsageError, BadInput."""
    if source is not None:
        found = next((table for table in tables if table.source == source), None)
        if found is None:
            raise UsageError(f"--rows {SOURCE}={source}: there is no such source; there are: {_names(tables)}")
        return found
    fitting = [table for table in tables if _has_outputs(table, options)]
    if len(tables) == 1 or len(fitting) == 1:
        return (fitting or tables)[0]
    if fitting:
        refusal = BadInput(
            f"{len(fitting)} sources have outputs, {_names(fitting)}: --rows {SOURCE}=NAME takes one", file
        )
    else:
        columns = quoted("; ".join(f"{table.source}: {','.join(table.columns)}" for table in tables), _LONGEST_LIST)
        said = f"no source has columns ux, uy and uz, of {columns}"
        refusal = BadInput(f"{said}: --rows {SOURCE}=NAME takes one, --columns names them", file)
    refusal.assumed = (f"{kind}, {len(tables)} sources",)
    condition = "the first source is meant" if fitting else "this source is meant"
    raise refusal.advising(
        *(Remedy({"rows": f"{SOURCE}={table.source}"}, condition) for table in fitting[:1] or tables)
    )


def _names(tables: list[Table]) -> str:
    return quoted(", ".join(table.source for table in tables), _LONGEST_LIST)


def _has_outputs(table: Table, options: LayoutOptions) -> bool:
    try:
        run_layout.find_all(list(table.columns), options)
    except ValueError:
        return False
    return True


Column = tuple[str, str, Any]  # name, unit (empty: none is told), values


def _tables(source: str, columns: Iterable[Column]) -> Iterator[Table]:
    """Of a source, one for each length that its columns have; of arrays each column."""
    by_length = defaultdict[int, dict[str, Any]](dict)
    for name, unit, values in columns:
        for own, column in _flat(name, np.asarray(values)):
            if column.dtype.kind == "M":
                column, unit = (column - np.nanmin(column)) / np.timedelta64(1, "s"), "s"
            label = f"{own} [{unit}]" if unit and not run_layout.unit_in(own)[1] else own
            by_length[len(column)][_word(label)] = _of_texts(column) if column.dtype.kind in "SUO" else column
    for rows, found in by_length.items():
        yield Table(source if len(by_length) == 1 else f"{source} ({rows} rows)".strip(), found)


def _flat(name: str, values: Any) -> Iterator[tuple[str, Any]]:
    """Columns of two and more rows; what is no column, or no number, time or text, has none."""
    if values.dtype.names is not None:
        for own in values.dtype.names:
            yield from _flat(own, values[own])
    elif values.ndim == 2 and 1 < min(values.shape) <= _MOST_ACROSS:
        across = values if values.shape[0] > values.shape[1] else values.T
        axes = "xyz" if across.shape[1] == 3 else range(1, across.shape[1] + 1)
        yield from ((f"{name}_{axis}", column) for axis, column in zip(axes, across.T))
    elif values.size == max(values.shape, default=0) > 1 and values.dtype.kind in "biufMSUO":
        yield name, values.ravel().astype(int) if values.dtype.kind == "b" else values.ravel()


def _of_texts(column: Any) -> Any:
    """Each on one line; empty where there is none."""
    return np.array(["" if one is None else _word(one) for one in column.tolist()], dtype=object)


def _word(text: Any) -> str:
    """On one line, without signs that cannot be seen."""
    text = text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
    return " ".join("".join(sign if sign.isprintable() else " " for sign in text).split())


# Readers: a source and its columns, one after another.

Source = tuple[str, Iterable[Column]]


def _tdms(file: str) -> Iterator[Source]:
    """The channels of each group; the time of waveforms by their increment."""
    with needing(f"{file_name(file)}: TDMS", "nptdms", extra="tdms"):
        from nptdms import TdmsFile
        from nptdms.log import log_manager
    log_manager.set_level(logging.CRITICAL)  # else its remarks would stand among ours
    with open(file, "rb") as stream:  # not by its name: an index file beside it may be another's
        for group in TdmsFile.read(stream).groups():
            channels = [one for one in group.channels() if len(one)]
            waves = [one for one in channels if one.properties.get("wf_increment")]
            columns = [("time", "s", np.arange(len(one)) * one.properties["wf_increment"]) for one in waves[:1]]
            columns += [(one.name, _word(one.properties.get("unit_string", "")), one[:]) for one in channels]
            yield group.name, columns


def _hdf5(file: str) -> Iterator[Source]:
    """The datasets of each group, by a process of its own: of some damaged files the library dies."""
    import subprocess

    child = "import sys; sys.path[:] = sys.argv[2:]; from tumble.files import containers as c; c.hand_over(sys.argv[1])"
    command = [sys.executable, "-c", child, file, *sys.path]  # so that it finds what this one finds, and no more
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True)
    if done.returncode != 0:
        raise BadInput("is damaged: the library of HDF5 dies of it", file)
    found = pickle.loads(done.stdout)
    if isinstance(found, Exception):
        raise found
    yield from found


def hand_over(file: str) -> None:
    """What that process does: the groups, or what went wrong, to standard output."""
    found: list[Source] | Exception
    try:
        found = _groups(file)
    except Exception as error:
        found = error
    pickle.dump(found, sys.stdout.buffer)


def _groups(file: str) -> list[Source]:
    """MATLAB 7.3 and netCDF-4 have them too. What lies in other files is not read."""
    with needing(f"{file_name(file)}: HDF5", "h5py", extra="hdf5"):
        import h5py
    groups = defaultdict[str, list[Column]](list)

    def take(path: str, found: Any) -> None:
        if not isinstance(found, h5py.Dataset) or found.is_virtual or found.external or found.shape is None:
            return
        is_text = h5py.check_string_dtype(found.dtype) is not None
        if is_text or not found.dtype.hasobject:
            group, _, name = path.rpartition("/")
            unit = next((_word(found.attrs[key]) for key in ("units", "unit") if key in found.attrs), "")
            values = found.asstr(errors="replace")[()] if is_text else found[()]
            groups[f"/{group}"].append((name, unit.partition(" since ")[0], values))

    with h5py.File(file, "r") as opened:
        opened.visititems(take)  # not along links to other files
    return list(groups.items())


def _ulog(file: str) -> Iterator[Source]:
    """The accelerometers of PX4, by instance."""
    with needing(f"{file_name(file)}: ULog", "pyulog", extra="ulog"):
        from pyulog import ULog
    topics = {"sensor_accel": ("x", "y", "z"), "sensor_combined": [f"accelerometer_m_s2[{axis}]" for axis in range(3)]}
    for topic in ULog(file, list(topics)).data_list:
        units = {"timestamp": "us"} | dict.fromkeys(topics[topic.name], SI)
        names = dict(zip(topics[topic.name], ("ax", "ay", "az")))
        yield (
            f"{topic.name}_{topic.multi_id}",
            [(names.get(name, name), units.get(name, ""), values) for name, values in topic.data.items()],
        )


# A message FMT that tells another of no length.
_NO_LENGTH = re.compile(rb"\xa3\x95\x80[\0-\xff][\0-\2][A-Z][A-Z0-9\0]{3}[a-zA-Z\0]{16}")


def _dataflash(file: str) -> Iterator[Source]:
    """The accelerometers of ArduPilot, by instance: messages with AccX, AccY and AccZ."""
    with needing(f"{file_name(file)}: DataFlash", "pymavlink", extra="dataflash"):
        from pymavlink import DFReader
    if _NO_LENGTH.search(Path(file).read_bytes()):  # where the library stays for ever
        raise BadInput("is damaged: DataFlash with a message of no length", file)
    DFReader.dfindexer.available = False  # in C, it complains on standard error
    rows = defaultdict[tuple[str, Any], list[dict[str, Any]]](list)
    with DFReader.DFReader_binary(file) as log:
        formats = {one.name: one for one in log.formats.values() if {"AccX", "AccY", "AccZ"} <= set(one.columns)}
        while (message := log.recv_match(type=list(formats))) is not None:
            fields = message.to_dict()
            name = fields.pop("mavpackettype")
            rows[name, fields.get(formats[name].instance_field or "I", 0)].append(fields)
    for (name, instance), found in sorted(rows.items()):
        columns = formats[name].columns
        units = {column: formats[name].get_unit(column) for column in columns}
        units |= {column: units[column] or SI for column in ("AccX", "AccY", "AccZ")}
        named = {one: "temperature" if one == "T" else one for one in columns}
        yield f"{name}_{instance}", [(named[one], units[one], [fields[one] for fields in found]) for one in columns]


# ROS. Types are those of the library: no definition of a file is made code.

_TOPICS = "messages of sensor_msgs/Imu, geometry_msgs/AccelStamped and Vector3Stamped"

_VECTORS = {  # of messages with a header: what they measure, and its unit
    "sensor_msgs/msg/Imu": ("linear_acceleration", SI),
    "geometry_msgs/msg/AccelStamped": ("accel.linear", SI),
    "geometry_msgs/msg/Vector3Stamped": ("vector", ""),
}
Message = tuple[str, str, int, Any]  # topic, type, ns of the log, the message


def _topics(messages: Iterable[Message]) -> Iterator[Source]:
    """Vectors by topic, with the time of their headers; with that of the log, where they have none."""
    rows = defaultdict[tuple[str, str], list[tuple[Any, ...]]](list)
    for topic, kind, logged, message in messages:
        header, vector = message.header, attrgetter(_VECTORS[kind][0])(message)
        stamp = header.stamp.sec * 10**9 + header.stamp.nanosec
        rows[topic, kind].append((stamp, logged, vector.x, vector.y, vector.z, header.frame_id))
    for (topic, kind), found in rows.items():
        stamps, logs, *vectors, frames_of = zip(*found)
        times = np.array(logs if len(set(stamps)) == 1 else stamps)
        columns = [(name, _VECTORS[kind][1], values) for name, values in zip(("ax", "ay", "az"), vectors)]
        yield topic, [("time", "s", (times - times[0]) / 1e9), *columns, ("frame_id", "", frames_of)]


def _needing_rosbags(file: str) -> Any:
    return needing(f"{file_name(file)}: a recording of ROS", "rosbags", extra="ros")


def _ros1(file: str) -> Iterator[Source]:
    with _needing_rosbags(file):
        from rosbags.rosbag1 import Reader
    with Reader(file) as bag:
        raw = ((one.topic, one.msgtype, time, "ros1", data) for one, time, data in bag.messages())
        yield from _topics(_decoded(file, raw))


def _ros2(file: str) -> Iterator[Source]:
    """A folder with metadata.yaml, or the storage alone."""
    with _needing_rosbags(file):
        from rosbags.rosbag2 import Reader
    bag = Reader.STORAGE_PLUGINS["dir" if os.path.isdir(file) else ".db3"](Path(file))  # whatever its name is
    bag.open()
    try:
        raw = ((one.topic, one.msgtype, time, "cdr", data) for one, time, data in bag.messages(bag.connections))
        yield from _topics(_decoded(file, raw))
    finally:
        bag.close()


def _mcap(file: str) -> Iterator[Source]:
    """Of ROS 1 or 2, with or without an index."""
    with needing(f"{file_name(file)}: MCAP", "mcap", extra="ros"):
        from mcap.exceptions import EndOfFile
        from mcap.reader import NonSeekingReader
    with open(file, "rb") as stream:
        messages = NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False)
        raw = (
            (channel.topic, schema.name, message.log_time, channel.message_encoding, message.data)
            for schema, channel, message in messages
            if schema is not None
        )
        try:
            yield from _topics(_decoded(file, raw))
        except EndOfFile:
            raise BadInput("MCAP that ends too early: mcap recover saves what is whole", file) from None


def _decoded(file: str, raw: Iterable[tuple[str, str, int, str, bytes]]) -> Iterator[Message]:
    """Those of _VECTORS."""
    with _needing_rosbags(file):
        from rosbags.typesys import Stores, get_typestore
    types = {"ros1": get_typestore(Stores.ROS1_NOETIC), "cdr": get_typestore(Stores.ROS2_HUMBLE)}
    decode = {"ros1": types["ros1"].deserialize_ros1, "cdr": types["cdr"].deserialize_cdr}
    for topic, kind, time, encoding, data in raw:
        name = kind if "/msg/" in kind else kind.replace("/", "/msg/")  # of ROS 1
        if name in _VECTORS and encoding in decode:
            yield topic, name, time, decode[encoding](data, name)


# Tables.


def _table_file(suffix: str, file: str) -> Iterator[Source]:
    table = frames.read_table_file(file, suffix)
    yield "", [(name, "", table[name]) for name in frames.names_of(table)]


_TABLE = "three columns of numbers, of one length"
_KINDS: dict[str, tuple[bytes, str, Callable[[str], Iterator[Source]]]] = {  # how each begins, what it lacks if empty
    "TDMS": (rb"TDSm", _TABLE, _tdms),
    "HDF5": (rb"\x89HDF\r\n\x1a\n|MATLAB 7\.3 MAT-file", _TABLE, _hdf5),
    "ULog": (rb"ULog\x01\x12\x35", "sensor_accel and sensor_combined", _ulog),
    "DataFlash": (rb"\xa3\x95\x80", "messages with AccX, AccY and AccZ", _dataflash),
    "ROS 1 bag": (rb"#ROSBAG V2\.0\n", _TOPICS, _ros1),
    ROS_2: (rb"SQLite format 3\0", _TOPICS, _ros2),
    "MCAP": (rb"\x89MCAP0\r\n", _TOPICS, _mcap),
    "Parquet": (rb"PAR1", _TABLE, partial(_table_file, frames.PARQUET[0])),
    "NPZ": (rb"(?s)PK\x03\x04.{26}[^/]{1,200}?\.npy", _TABLE, partial(_table_file, frames.NPZ)),
    "MAT": (rb"MATLAB 5\.0 MAT-file", _TABLE, partial(_table_file, frames.MAT)),
}
_OF_SUFFIX = {".parquet": "Parquet", ".pq": "Parquet", ".npz": "NPZ", ".mat": "MAT"}  # where the beginning is no sign


OF_AUTOPILOTS = ("ULog", "DataFlash")  # whose sources end in the number of the instance, from 0
CAUTIONS = {
    "DataFlash": "ArduPilot logs IMU after its own calibration: record with INS_ACC*OFFS 0, INS_ACC*SCAL 1 and"
    " INS_TCAL*_ENABLE 0"
}


def kind_of(file: str, beginning: bytes) -> str | None:
    """What this is, as messages call it; None: none of these."""
    found = next((kind for kind, (magic, *_) in _KINDS.items() if re.match(magic, beginning)), None)
    is_text = beginning and b"\0" not in beginning  # as MATLAB's save -ascii, whose files end in .mat
    return found or (None if is_text else _OF_SUFFIX.get(frames.suffix_of(file)))


def kind_in(file: str) -> str | None:
    """The same of what this file or folder has; None as well for one that cannot be read."""
    if os.path.isfile(os.path.join(file, METADATA)):
        return ROS_2
    try:
        with opened(file) as stream:
            return kind_of(file, stream.read(_BEGINNING))
    except (BadInput, OSError):
        return None


def refuse(data: bytes, file: str) -> None:
    """Raises BadInput for one of them that no ending makes a run file, where one is wanted."""
    kind = kind_of(file, data)
    if kind is not None and kind not in _OF_SUFFIX.values():
        advice = f"tumble import {file_name(file)} --out RUN.csv finds them by the rests"
        raise BadInput(f"is a recording ({kind}), which has no positions: {advice}", file)
