"""Runs on one's own stand: by functions, and by simulated instruments on a socket, a pseudo-terminal and pyvisa-sim."""

import sys

import numpy as np
import pytest
from simulated_instruments import NOISE, U0, K, Rig, on_terminal, over_tcp

import tumble
from tumble import errors
from tumble.acquisition.run import Acquisition, AcquisitionPlan
from tumble.cli.main import main

LIMITS = (-1.0, 361.0)
SIMULATED_TABLE = """
spec: "1.1"
devices:
  table:
    eom:
      TCPIP INSTR: {q: "\\n", r: "\\n"}
    error: ERROR
    dialogues:
      - {q: "STOP"}
    properties:
      position:
        default: 0.0
        getter: {q: "POS?", r: "{:.4f}"}
        setter: {q: "POS {:.4f}"}
resources:
  TCPIP0::192.0.2.7::inst0::INSTR: {device: table}
"""


def acquire(rig, out, **more):
    """On the paper's schedule by functions, of which `more` replaces some."""
    drive = {"move": rig.turn, "stop": lambda: None, "limits_deg": LIMITS}
    return tumble.acquire(**{"read": rig.read, "mount": rig.mount, "out": out, **drive, **more})


def rows_of(file):
    return np.loadtxt(file, delimiter=",", skiprows=1)


def test_the_run_is_solved_and_its_rows_are_at_rest(tmp_path):
    rig, stopped, lines = Rig(), [], []
    result = acquire(rig, tmp_path / "run.csv", stop=lambda: stopped.append(1), report=lines.append)
    assert result.passed and stopped == []
    assert len(lines) == 18 and lines[-1].startswith("2.9 at 360 deg: 100 samples in ")
    assert "18 of 18 positions; largest gravity error so far " in lines[-1]
    rows = rows_of(tmp_path / "run.csv")
    assert len(rows) == 18 * 100
    # by least squares in numpy, of the rows alone
    places = [(one.mounting, one.number) for one in rig.schedule.positions]
    means = np.array([rows[(rows[:, 0] == m) & (rows[:, 1] == n), 2:5].mean(axis=0) for m, n in places])
    scatter = np.array([rows[(rows[:, 0] == m) & (rows[:, 1] == n), 2:5].std(axis=0) for m, n in places])
    from tumble.model.geometry import Geometry

    design = np.column_stack([Geometry(rig.schedule).force(), np.ones(18)])
    found = np.linalg.lstsq(design, means, rcond=None)[0]
    assert np.abs(found[:3].T - K).max() < 5 * NOISE / 10 and np.abs(found[3] - U0).max() < 5 * NOISE / 10
    assert np.abs(result.K - found[:3].T).max() < 5 * NOISE / 10
    assert scatter.max() < 1.5 * NOISE  # no swing of 0.3 V is in them


def test_what_interrupts_it_stops_the_table_and_it_goes_on_from_there(tmp_path):
    rig, stopped, out = Rig(), [], tmp_path / "run.csv"

    def until_the_sixth(angle_deg):
        if angle_deg == 225.0:
            raise KeyboardInterrupt
        rig.turn(angle_deg)

    with pytest.raises(KeyboardInterrupt):
        acquire(rig, out, move=until_the_sixth, stop=lambda: stopped.append(1))
    assert stopped == [1]
    begun = out.read_bytes()
    assert len(rows_of(out)) == 5 * 100
    with pytest.raises(errors.BadInput, match=r"is there already; .* \(resume=True\)"):
        acquire(rig, out)
    lines = []
    result = acquire(rig, out, resume=True, report=lines.append)
    assert lines[0] == "5 of 18 positions are there already" and len(lines) == 14
    assert lines[1].startswith("1.6 at 225 deg: ")
    assert out.read_bytes().startswith(begun) and len(rows_of(out)) == 18 * 100 and result.passed


@pytest.mark.parametrize("limits", [(0.0, 359.0), (1.0, 361.0), (90.0, 0.0), (0.0, float("inf"))])
def test_nothing_moves_where_the_schedule_is_beyond_the_limits(tmp_path, limits):
    rig, moved = Rig(), []
    with pytest.raises(errors.UsageError, match=r"beyond the limits|no range"):
        acquire(rig, tmp_path / "run.csv", move=moved.append, limits_deg=limits)
    assert not moved and rig.samples == 0 and not (tmp_path / "run.csv").exists()


@pytest.mark.parametrize("missing", ["stop", "limits_deg"])
def test_no_motion_without_limits_and_a_stop(tmp_path, missing):
    with pytest.raises(errors.UsageError, match=f"^{missing}: .* needed with move"):
        acquire(Rig(), tmp_path / "run.csv", **{missing: None})


def test_a_table_that_cannot_be_stopped_is_the_greater_fault(tmp_path):
    def fails(*_):
        raise OSError("no answer")

    with pytest.raises(errors.BenchFault, match=r"^THE TABLE MAY STILL TURN: .*'no answer'.* after: OSError$"):
        acquire(Rig(), tmp_path / "run.csv", move=fails, stop=fails)


def test_a_block_that_never_rests_ends_the_run(tmp_path):
    rig, stopped, out = Rig(), [], tmp_path / "run.csv"

    def read():
        return rig.read() + (np.sin(rig.samples / 3.0) if rig.angle_deg == 90.0 else 0.0)

    with pytest.raises(
        errors.BenchFault, match=r"^position 1\.3: not at rest within 0\.2 s, \d+ samples, of which 100"
    ):
        acquire(rig, out, read=read, stop=lambda: stopped.append(1), rest_timeout_s=0.2)
    assert stopped == [1] and len(rows_of(out)) == 2 * 100


def test_a_first_position_that_swung_is_measured_again(tmp_path):
    """Its swing is all that is known of noise by then."""
    rig, lines, visits, out = Rig(swing=0.0), [], [], tmp_path / "run.csv"

    def read():
        shaken = 0.05 * np.random.default_rng(rig.samples).standard_normal(3) if len(visits) == 1 else 0.0
        return rig.read() + shaken

    def move(angle_deg):
        visits.append(angle_deg)
        rig.turn(angle_deg)

    acquire(rig, out, read=read, move=move, report=lines.append)
    assert visits[-1] == 0.0 and len(visits) == 19
    assert "not at rest, as the noise of the whole run shows: 1.1; once more" in lines
    assert rows_of(out)[:100, 2:5].std(axis=0).max() < 2 * NOISE


@pytest.mark.parametrize("step", [1e-9, 2e-4, 1e-3])
def test_honest_noise_is_at_rest(step):
    """Of the fewest samples, also of a converter that is coarser than the noise: 300 runs."""
    rig, rng = Rig(), np.random.default_rng(5)
    nobody = AcquisitionPlan(rig.schedule, 50, "V", "run.csv", rig.read, rig.mount, None, rig.turn)
    for _ in range(300):
        outputs = NOISE * rng.standard_normal((18, 50, 3)) + rng.standard_normal((18, 1, 3))
        rows = np.concatenate([step * np.round(outputs / step), np.zeros((18, 50, 1))], axis=2)
        assert Acquisition(nobody, dict(enumerate(rows)), print)._not_at_rest() == []


def test_a_table_that_turns_the_other_way_in_one_mounting_is_seen_at_once(tmp_path):
    rig, lines = Rig(), []

    def move(angle_deg):
        rig.turn(angle_deg if rig.mounting == 1 else (360.0 - angle_deg))

    acquire(rig, tmp_path / "run.csv", move=move, report=lines.append)
    sizes = [abs(float(line.split("so far ")[1].split()[0])) for line in lines if "so far" in line]
    assert max(sizes[2:]) > 0.1


def test_a_block_that_is_bolted_on_once(tmp_path):
    result = acquire(Rig("inclined"), tmp_path / "run.csv", schedule="inclined")
    assert result.passed and result.estimator == "inclined"


@pytest.mark.parametrize("given", [(1.0, 2.0), "text", (1.0, 2.0, float("nan")), None])
def test_what_is_no_sample_is_a_fault(tmp_path, given):
    with pytest.raises(errors.BenchFault, match="is no sample of three finite outputs"):
        acquire(Rig(), tmp_path / "run.csv", read=lambda: given)


# The command.


class Hands:
    """Standard input: whoever is asked does it and presses Enter, `todo` times, then gives up. Turns the table, too, if
    nothing else does."""

    def __init__(self, rig, turns_too, todo):
        self._rig, self._todo = rig, []
        for number in dict.fromkeys(one.mounting for one in rig.schedule.positions):
            self._todo.append(("mounting", number))
            angles = [one.angle_deg for one in rig.schedule.positions if one.mounting == number]
            self._todo += [("angle_deg", angle) for angle in angles] if turns_too else []
        self._todo = self._todo[:todo]

    def isatty(self):
        return False

    def readline(self):
        if not self._todo:
            return "abort\n"
        name, value = self._todo.pop(0)
        setattr(self._rig, name, value)
        self._rig.since = 0
        return "\n"


@pytest.fixture
def bench(tmp_path, monkeypatch, capsys):
    """Run `tumble acquire` in this process: exit code, output, errors."""

    def run(text, rig, *options, turns_too=False, todo=99):
        (tmp_path / "bench.toml").write_text(text)
        monkeypatch.setattr(sys, "stdin", Hands(rig, turns_too, todo))
        code = main(["acquire", str(tmp_path / "bench.toml"), "--out", str(tmp_path / "run"), *options])
        return code, *capsys.readouterr()

    return run


def table_toml(port, more=""):
    return f"""[table]
port = "{port}"
limits_deg = [-1, 361]
move = "POS {{angle_deg:.4f}}"
stop = "STOP"
angle = "POS?"
poll_s = 0.0
timeout_s = 0.2
{more}
"""


def on_socket(socket):
    """A table and a block that are one instrument."""
    port = f"socket://127.0.0.1:{socket}"
    return f'samples = 50\n{table_toml(port)}\n[block]\nport = "{port}"\nask = "READ?"\nunit = "V"\n'


@pytest.mark.parametrize(
    ("kind", "questions"),
    [
        ("socket://127.0.0.1:{}", '"READ?"'),
        ("TCPIP0::127.0.0.1::{}::SOCKET", '["MEAS:VOLT:DC? (@101)", "MEAS:VOLT:DC? (@102)", "MEAS:VOLT:DC? (@103)"]'),
    ],
)
def test_a_scpi_table_and_a_multimeter(bench, tmp_path, kind, questions):
    pytest.importorskip("pyvisa_py")
    rig = Rig(swing=0.0)
    with over_tcp(rig) as port:
        port = kind.format(port)
        text = f'samples = 50\n{table_toml(port)}\n[block]\nport = "{port}"\nask = {questions}\nunit = "V"\n'
        code, out, err = bench(text, rig)
    assert code == 0, err
    assert out.startswith("PASS") and "K_xx" in out
    assert "Mount the block as mounting 2 says" in err and "18 of 18 positions" in err
    assert {"result.json", "run.csv"} <= {one.name for one in (tmp_path / "run").iterdir()}
    assert [one for one in rig.commands if one.startswith("POS ")][:3] == ["POS 0.0000", "POS 45.0000", "POS 90.0000"]


def test_a_serial_unit_turned_by_hand(bench):
    rig = Rig(swing=0.0)
    with on_terminal(rig) as port:
        text = f'samples = 50\n[block]\nport = "{port}"\nunit = "V"\nvalues = [2, 3, 4]\n'
        code, out, err = bench(text, rig, turns_too=True)
    assert code == 0, err
    assert out.startswith("PASS") and "Turn the table to 315 degrees." in err


def test_a_table_of_pyvisa_sim(bench, tmp_path):
    pytest.importorskip("pyvisa_sim")
    import pyvisa

    (tmp_path / "table.yaml").write_text(SIMULATED_TABLE)
    library = f"{tmp_path}/table.yaml@sim"
    port = "TCPIP0::192.0.2.7::inst0::INSTR"
    asked = pyvisa.ResourceManager(library).open_resource(port, read_termination="\n", write_termination="\n")

    class Follower(Rig):
        def read(self):
            self.angle_deg = float(asked.query("POS?"))
            return super().read()

    rig = Follower(swing=0.0)
    with over_tcp(rig) as socket:
        block = f'[block]\nport = "socket://127.0.0.1:{socket}"\nask = "READ?"\nunit = "V"\n'
        code, out, err = bench(f"samples = 50\n{table_toml(port, f'visa = {library!r}')}\n{block}", rig)
    assert code == 0, err
    assert out.startswith("PASS")
    assert float(asked.query("POS?")) == 360.0


def test_a_table_beyond_its_limits_is_stopped(bench, tmp_path):
    rig = Rig(swing=0.0)
    normal = rig.turn

    def runs_away(angle_deg):
        normal(angle_deg)
        rig.angle_deg = -20.0 if angle_deg == 90.0 else angle_deg

    rig.turn = runs_away
    with over_tcp(rig) as socket:
        text, port = on_socket(socket), f"socket://127.0.0.1:{socket}"
        code, out, err = bench(text, rig)
        assert (code, out) == (3, "")
        assert f"{port}: the table is at -20 deg, beyond its limits, -1 to 361 deg; what was measured is in" in err
        assert rig.commands[-1] == "STOP" and len(rows_of(tmp_path / "run/run.csv")) == 2 * 50
        rig.turn = normal
        code, out, err = bench(text, rig, "--resume")
        assert code == 0 and "2 of 18 positions are there already" in err


def test_a_table_that_does_not_come_is_stopped(bench):
    rig = Rig(swing=0.0)
    rig.turn = lambda angle_deg: None
    with over_tcp(rig) as socket:
        text, port = on_socket(socket), f"socket://127.0.0.1:{socket}"
        code, out, err = bench(text, rig)
    assert (code, out) == (3, "")
    assert f"{port}: the table is at 0 deg after 0.2 s, and should be at 45 deg" in err
    assert rig.commands[-1] == "STOP"


def test_the_operator_may_stop(bench, tmp_path):
    rig = Rig(swing=0.0)
    with over_tcp(rig) as socket:
        code, out, err = bench(on_socket(socket), rig, todo=1)
    assert (code, out) == (130, "")
    assert "tumble: stopped by the operator; the table is stopped; what was measured is in " in err
    assert rig.commands[-1] == "STOP" and len(rows_of(tmp_path / "run/run.csv")) == 9 * 50


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("samples = 50\n", "bench.toml: no [block], which says how its outputs are read"),
        ('[block]\nport = "X"\n', "bench.toml: row 1: [block] has no unit"),
        ('[block]\nport = "X"\nunit = "V"\nvalues = [0, 1, 2]\n', "row 4: [block] values must be three places, from 1"),
        ('[block]\nport = "X"\nunit = "V"\nask = ["A", "B"]\n', "row 4: [block] ask must be a question or three"),
        ('[block]\nport = "A::B"\nunit = "V"\n', "row 1: [block] ask is missing: only a serial port may send"),
        ('samples = 10\n[block]\nport = "X"\nunit = "V"\n', "row 1: samples must be 50 to 100000"),
        ('[block]\nprot = "X"\n', "row 2: unknown key 'prot' in [block]; is port meant?"),
    ],
)
def test_a_bad_file_is_one_line(bench, tmp_path, text, said):
    code, out, err = bench(text, Rig())
    assert (code, out) == (2, "") and said in err and err.count("\n") == 1 and not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ('move = "POS"', 'move must say where to, such as "POS {angle_deg:.4f}"'),
        ('move = "POS {angle}"', 'move must say where to, such as "POS {angle_deg:.4f}"'),
        ("limits_deg = [10, 5]", "limits_deg must be the lowest and the highest angle"),
    ],
)
def test_a_bad_table_is_one_line(bench, key, said):
    rig = Rig()
    with over_tcp(rig) as socket:
        lines = table_toml("X").splitlines()
        name = key.partition(" ")[0]
        text = "\n".join(key if line.startswith(name) else line for line in lines)
        block = f'\n[block]\nport = "socket://127.0.0.1:{socket}"\nask = "READ?"\nunit = "V"\n'
        code, out, err = bench(text + block, rig)
    assert (code, out) == (2, "") and said in err and not rig.commands


def test_an_instrument_that_is_not_there_is_a_fault(bench):
    code, out, err = bench('[block]\nport = "/dev/no-such-port"\nunit = "V"\n', Rig())
    assert (code, out) == (3, "") and "tumble: /dev/no-such-port: " in err


def test_a_package_that_is_not_there_is_named(bench, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvisa", None)
    code, out, err = bench('[block]\nport = "GPIB0::5::INSTR"\nask = "READ?"\nunit = "V"\n', Rig())
    assert (code, out) == (77, "") and "GPIB0::5::INSTR: a VISA resource needs pyvisa or pyvisa-py: " in err
