"""Signals of a user's DBC file in a CAN log: found by name, paired by time, refused where they are not there."""

import csv

import numpy as np
import pytest

pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("cantools", reason="cantools is not installed")

from can_logs import DBC, bench, read_text  # noqa: F401

from tumble.errors import BadInput
from tumble.files.run_layout import LayoutOptions
from tumble.importing import can_bus

pytestmark = pytest.mark.python

OTHER = """VERSION ""
BU_: SENSOR
BO_ 256 ACC: 6 SENSOR
 SG_ AccX : 0|16@1- (0.001,0) [0|0] "m/s^2" SENSOR
 SG_ AccY : 16|16@1- (0.001,0) [0|0] "m/s^2" SENSOR
 SG_ AccZ : 32|16@1- (0.001,0) [0|0] "m/s^2" SENSOR
BO_ 2566869221 FIRST: 4 SENSOR
 SG_ Left : 7|16@0- (0.5,1) [0|0] "mV" SENSOR
 SG_ Same : 23|16@0- (0.5,1) [0|0] "mV" SENSOR
BO_ 258 SECOND: 4 SENSOR
 SG_ Same : 0|16@1- (0.5,1) [0|0] "mV" SENSOR
 SG_ Time : 16|16@1+ (0.5,1) [0|0] "s" SENSOR
"""


@pytest.fixture
def other(tmp_path):
    (tmp_path / "other.dbc").write_text(OTHER)
    return tmp_path / "other.dbc"


def test_signals_by_their_own_names(other):
    rows = [(n, -n, 9807 - n) for n in range(60)]
    lines = [f"({n / 50:.6f}) can0 100#" + b"".join(v.to_bytes(2, "little", signed=True) for v in row).hex()
             for n, row in enumerate(rows)]
    lines[20:21] = [lines[20], lines[20], "(0.405000) can0 100#0000"]
    found = read_text(lines, dbc=str(other))
    assert np.abs(found.outputs - 1e-3 * np.array(rows)).max() < 1e-12 and found.unit == "m/s^2"
    assert found.seconds.tolist() == [n / 50 for n in range(60)] and found.temperature is None
    assert found.notes == (
        "CAN log (candump): 62 frames",
        f"signals of {other}: ux AccX, uy AccY, uz AccZ; 60 samples; checksums are not verified",
        "left out: 1 frames that are too short, 1 repeated frames",
    )


TOLD = {"ux": "Left", "uy": "FIRST.Same", "uz": "SECOND.Same"}


def two_messages(count=60, drop=()):
    """Of each sample an extended frame, big endian, and 2 ms later one of another message."""
    for n in range(count):
        yield f"({n / 50:.6f}) can0 18FF50E5#" + (n.to_bytes(2, "big", signed=True) * 2).hex()
        yield f"({n / 50 + 2e-3:.6f}) can0 102#" + (-n).to_bytes(2, "little", signed=True).hex() + "1234"


def test_signals_of_two_messages_are_paired_by_time(other):
    lines = list(two_messages())
    expected = [[0.5 * n + 1, 0.5 * n + 1, -0.5 * n + 1] for n in range(60)]
    found = read_text(lines, LayoutOptions(columns=TOLD), dbc=str(other))
    assert found.outputs.tolist() == expected and found.unit == "mV" and len(found.notes) == 2
    del lines[21], lines[40], lines[0]  # a second half, a first one, and the log begins with a second one
    found = read_text(lines, LayoutOptions(columns=TOLD), dbc=str(other))
    gone = (0, 10, 20)
    assert found.outputs.tolist() == [row for n, row in enumerate(expected) if n not in gone]
    assert found.notes[2] == "left out: 3 frames without matching frames of the other messages"


def test_a_users_dbc_on_the_command_line(bench, other, tumble, refused, tmp_path):
    """The bench's frames by a copy of the product's DBC file, as if it were somebody else's."""
    copy = tmp_path / "copy.dbc"
    copy.write_text(DBC.read_text())
    options = ("--dbc", copy, "--columns", "ux=x,uy=y,uz=BLOCK_Z.z", "--recipe", tmp_path / "can.toml")
    done = tumble("import", bench.log, *options, "--stand", bench.stand, "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "")
    own = tumble("import", bench.log, "--stand", bench.stand, "--out", tmp_path / "own.csv")
    assert own.returncode == 0
    outputs = [[row[:5] for row in csv.reader((tmp_path / name).read_text().splitlines()[1:])]
               for name in ("run.csv", "own.csv")]
    assert outputs[0] == outputs[1]
    assert f"-signalsof{copy}:uxx,uyy,uzz;" in "".join(done.stdout.split())  # lines are broken within the path too
    assert "is an input of this command" in refused("import", bench.log, *options[:4], "--out", copy)
    assert f'[can]\ndbc = "{copy}"\n' in (tmp_path / "can.toml").read_text()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--dbc", "none.dbc"), "none.dbc: no such file or folder"),
        (("--dbc", "prose.dbc"), "prose.dbc: cannot read this DBC file: "),
        (("--dbc", "empty.dbc"), "empty.dbc: describes no signal of a CAN message"),
        (("--dbc", "other.dbc"), "bus.log: fewer than 2 good frames of ACC among "),
        (("--dbc", "other.dbc", "--columns", "ux=AccQ"), "other.dbc: no column 'AccQ' (for ux) among 'AccX,AccY,AccZ,"),
        (("--dbc", "other.dbc", "--columns", "ux=Same"), "other.dbc: no column 'Same' (for ux) among "),
        (("--dbc", "other.dbc", "--can-id", "0x683"), "--can-id selects a Tumble block; with --dbc"),
        (("--columns", "ux=AccX"), "no column 'AccX' (for ux) among 'x,y,z'"),
        (("--columns", "time=Time"), "--columns time=: of a CAN log ux, uy and uz can be named"),
    ],
)
def test_dbc_files_and_names_that_are_not_there(options, said, bench, other, refused, tmp_path):
    (tmp_path / "prose.dbc").write_text("Dear reader\n")
    (tmp_path / "empty.dbc").write_text('VERSION ""\n')
    assert said in refused("import", bench.log, *options, cwd=tmp_path)


def test_units_that_differ_are_refused(other):
    with pytest.raises(BadInput, match=r"outputs in different units: .*; --unit says which"):
        read_text(list(two_messages()), LayoutOptions(columns={**TOLD, "uz": "Time"}), dbc=str(other))
    found = read_text(list(two_messages()), LayoutOptions(columns={**TOLD, "uz": "Time"}, unit="mV"), dbc=str(other))
    assert found.unit == "mV"


def test_a_pair_is_nearest_by_brute_force():
    """Each frame with the one that is nearest, at most half an interval off, none twice."""
    draw = np.random.default_rng(5)
    for _ in range(200):
        times = np.arange(40.0) + draw.uniform(-0.2, 0.2, 40)
        first, second = (np.sort(times[draw.random(40) < 0.8] + shift) for shift in (0.0, draw.uniform(-0.2, 0.2)))
        found = can_bus.nearest(first, second)
        interval = np.median(np.diff(second))
        for at, place in enumerate(found.tolist()):
            nearest = int(np.argmin(np.abs(second - first[at])))
            rivals = [np.abs(second[nearest] - one) for one in first if np.argmin(np.abs(second - one)) == nearest]
            near = abs(second[nearest] - first[at])
            assert place == (nearest if near <= interval / 2 and near == min(rivals) else -1)
