"""tools/fixture: every check on a played table, good and with the fault that it is there to find."""

import pkgutil
import subprocess
import sys
from importlib import import_module
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT
from fixture_table import FAULT, LIMITS, U0, K, PlayedTable, PlayedTime, limits, read_limits
from validation import harmonic, judge, report, runs, samples, session
from validation.judge import Verdict
from validation.limits import CHECKS

from tumble.client import CommunicationError
from tumble.errors import BadInput

pytestmark = pytest.mark.python
LIVE = ("link", "homing", "positions", "backlash", "settling", "closure", "noise")
DATA = ("level", "remounting", "support")


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    """The time of every module of the scripts."""
    played = PlayedTime()
    for module in pkgutil.iter_modules(import_module("validation").__path__, "validation."):
        if not module.name.endswith("__main__") and hasattr(import_module(module.name), "time"):
            monkeypatch.setattr(f"{module.name}.time", played)
    return played


def checked(tmp_path, names, runs=(), keys=None, **faults):
    """The outcomes of some checks on a played table."""
    table = PlayedTable(**faults)
    asked = read_limits(str(limits(tmp_path, **(keys or {}))))
    with session.opened(table, asked, list(map(str, runs)), None, table.sampler) as context:
        return [session.run(name, context) for name in names]


@pytest.mark.parametrize("seed", range(3))
def test_a_good_fixture_meets_every_limit(tmp_path, seed):
    run = EXAMPLES / "paper_stand.csv"
    outcomes = checked(tmp_path, CHECKS, [run], seed=seed)
    assert {outcome.check: outcome.verdict for outcome in outcomes} == dict.fromkeys(CHECKS, Verdict.MEETS)
    assert report.supports(outcomes)
    assert report.sentence(outcomes, 3e-4).startswith("This fixture does support a calibration to 3e-4 g: ")


@pytest.mark.parametrize(
    ("name", "faults", "said"),
    [
        ("link", {"identity": {"Identity object: Product code": 0x54420002}}, "product code is 0x54420002"),
        ("link", {"stays": FAULT}, "link: the stand is in fault"),
        ("homing", {"home_deg": 0.2}, "homing repeatability .* deg exceeds 0.02 deg"),
        ("positions", {"alpha4_rad": 1e-3}, "set angle, std dev .* rad exceeds 1.5e-4 rad"),
        ("positions", {"read_back_deg": 0.02}, "read-back, worst 0.02 deg exceeds 0.005 deg"),
        ("backlash", {"backlash_deg": 0.1}, "backlash 0.1 deg exceeds 0.01 deg"),
        ("closure", {"slip_deg": 0.3}, "closure of a turn .* g exceeds 5e-4 g"),
        ("noise", {"noise_v": 2e-3}, "noise of a sample .* V exceeds 5e-4 V"),
        ("positions", {"stays": 1}, "positions: homing ended with the stand not homed"),
    ],
)
def test_each_fault_fails_the_check_that_names_it(tmp_path, name, faults, said):
    import re

    [outcome] = checked(tmp_path, [name], **faults)
    assert outcome.verdict == Verdict.FAILS
    sentence = report.sentence([outcome], 3e-4)
    assert re.match(f"This fixture does not support a calibration to 3e-4 g: {said}", sentence), sentence


def test_a_backlash_alone_fails_no_other_check(tmp_path):
    outcomes = checked(tmp_path, LIVE, backlash_deg=0.1)
    assert [one.check for one in outcomes if one.verdict == Verdict.FAILS] == ["backlash"]


def test_slow_settling(tmp_path, monkeypatch, clock):
    """The encoder swings for 1.5 s."""
    good = PlayedTable._read

    def swinging(self, name):
        value = good(self, name)
        if name == "Progress: Actual angle" and clock.now - self.moved < 1.5:
            return value + 0.01
        return value

    def moving(self, angle, move=PlayedTable.move):
        move(self, angle)
        self.moved = clock.now

    monkeypatch.setattr(PlayedTable, "_read", swinging)
    monkeypatch.setattr(PlayedTable, "move", moving)
    keys = {"table__settling_moves": 2, "settling__settling_s": 0.6}
    [outcome] = checked(tmp_path, ["settling"], keys=keys)
    [line] = outcome.lines
    assert outcome.verdict == Verdict.FAILS and line.value == pytest.approx(1.5, abs=0.05)
    [outcome] = checked(tmp_path, ["settling"], keys={**keys, "settling__settling_s": 1.7})
    assert outcome.verdict == Verdict.MEETS


@pytest.mark.parametrize("name", DATA)
def test_a_stand_with_large_angles_fails_by_its_run(tmp_path, name):
    keys = {"level__axis_tilt_rad": 1e-5, "level__level_yaw_rad": 1e-5, "remounting__yaw_change_rad": 1e-5,
            "limit_g": 1e-5}
    [outcome] = checked(tmp_path, [name], [EXAMPLES / "lab_stand.csv"], keys)
    assert outcome.verdict == Verdict.FAILS, report.table([outcome])


def test_what_runs_show_is_the_truth(tmp_path):
    """Of the examples, whose errors are written beside them: within four standard uncertainties."""
    import json

    for name in ("paper_stand", "angle_stand", "lab_stand"):
        truth = json.loads((EXAMPLES / f"{name}.truth.json").read_text())
        [seen] = runs.read_files([str(EXAMPLES / f"{name}.csv")], None, "refined", 3e-4)
        stand = truth.get("stand", truth)
        found = seen.angles["alpha1"]
        assert abs(found.value - stand["alpha1_rad"]) < 4.0 * found.u, (name, found, stand)
        assert np.allclose(seen.k, truth["K"], atol=5e-3)


def test_without_runs_it_cannot_be_told_and_that_counts_as_does_not(tmp_path):
    outcomes = checked(tmp_path, CHECKS)
    assert {one.verdict for one in outcomes if one.check in DATA} == {Verdict.CANNOT_TELL}
    assert not report.passed(outcomes) and not report.supports(outcomes)
    said = report.sentence(outcomes, 3e-4)
    assert said == ("This fixture does not support a calibration to 3e-4 g, as far as can be told: no axis tilt,"
                    " level + yaw, yaw change and gravity error (no run: give --run FILE, or let node 1 keep one).")


def test_without_the_blocks_samples_gravity_cannot_tell(tmp_path):
    """As over Modbus with a node without memory: the encoder's figures stay, noise and closure come from the runs."""
    outcomes = checked(tmp_path, CHECKS, [EXAMPLES / "paper_stand.csv"], gravity=False)
    found = {one.check: one.verdict for one in outcomes}
    assert {name for name in CHECKS if found[name] != Verdict.MEETS} == {"homing", "positions", "backlash"}
    assert outcomes[CHECKS.index("positions")].lines[0].verdict == Verdict.MEETS
    lines = [line for one in outcomes for line in one.lines if isinstance(line, judge.Figure)]
    assert all("it has no memory" in line.note for line in lines if line.value is None)


def test_a_silent_node_ends_everything(tmp_path):
    with pytest.raises(CommunicationError, match="node 1 does not answer"):
        checked(tmp_path, ["link"], silent=True)


def test_an_endless_motion_is_stopped(tmp_path):
    table = PlayedTable(endless=True)
    asked = read_limits(str(limits(tmp_path, table__move_timeout_s=0.1)))
    with session.opened(table, asked, [], None, table.sampler) as context:
        outcome = session.run("positions", context)
    assert outcome.verdict == Verdict.FAILS and outcome.fault == "homing takes longer than 0.1 s"
    assert table.commands[-1] == 2


def test_an_interruption_stops_the_table(tmp_path):
    table, asked = PlayedTable(), read_limits(str(limits(tmp_path)))
    with pytest.raises(KeyboardInterrupt), session.opened(table, asked, [], None, table.sampler) as context:
        context.instrument.turn(90.0)
        raise KeyboardInterrupt
    assert table.commands[-1] == 2


def test_the_summary_fits_80_columns_and_states_everything(tmp_path):
    outcomes = checked(tmp_path, CHECKS, [EXAMPLES / "paper_stand.csv"], stays=1)
    outcomes += checked(tmp_path, CHECKS, [EXAMPLES / "paper_stand.csv"], alpha4_rad=0.3, noise_v=9.0)
    outcomes += checked(tmp_path, CHECKS)
    rows = report.table(outcomes).splitlines()
    assert max(map(len, rows)) <= 80 and len(rows) > 60
    figures = [(one.check, line) for one in outcomes for line in one.lines if isinstance(line, judge.Figure)]
    assert all(line.unit and line.limit is not None for _check, line in figures)
    told = [line for check, line in figures if line.value is not None and check != "support"]
    assert all(line.u is not None and line.resolves is not None for line in told)


def test_junit_says_the_same(tmp_path):
    outcomes = checked(tmp_path, CHECKS, [EXAMPLES / "paper_stand.csv"], backlash_deg=0.1)
    suite = ElementTree.fromstring(report.junit(outcomes, "One sentence."))
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == (str(len(CHECKS)), "1", "0")
    failed = [case for case in suite.iter("testcase") if case.find("failure") is not None]
    assert [case.get("name") for case in failed] == ["backlash"]
    assert failed[0].find("failure").get("message").startswith("backlash 0.1 deg exceeds 0.01 deg")


def test_a_verdict_heeds_the_uncertainty():
    from fractions import Fraction

    at = judge.Judge(0.95)
    k = 1.959963984540054
    high, low, bit = 1.0 + k * 0.1, 1.0 - k * 0.1, 1e-9
    untold = "can't tell"
    for limit, said in [(high + bit, "meets"), (high - bit, untold), (low + bit, untold), (low - bit, "fails")]:
        assert at.normal("b", "g", limit, 1.0, 0.1).verdict.value == said
    # Chi-squared with 2 degrees of freedom has the quantile -2 ln(1 - p), Student with 1 tan(pi p / 2).
    found = at.deviation("b", "V", 1.0, 1.0, 2)
    assert found.low == pytest.approx(np.sqrt(2.0 / (-2.0 * np.log(0.025))), rel=1e-9)
    assert found.high == pytest.approx(np.sqrt(2.0 / (-2.0 * np.log(0.975))), rel=1e-9)
    found = at.student("b", "rad", 1.0, -3.0, float(Fraction(1, 10)), 1)
    assert found.value == 3.0 and found.high == pytest.approx(3.0 + 0.1 * np.tan(0.475 * np.pi), rel=1e-9)


def turned(random, alpha4, noise_v):
    """A turn with these errors: where the means are drawn, not the samples."""
    angles = np.array([45.0 * n for n in range(9)])
    real = np.radians(angles) + random.normal(0.0, 1.0, 9) * alpha4
    a = np.stack([np.full(9, 0.02), np.cos(real), np.sin(real)])
    values = (K @ a).T + U0 + random.normal(0.0, 1.0, (9, 3)) * noise_v
    u = np.full(3, noise_v)
    return harmonic.Harmonic(angles, angles, [samples.Mean(value, u, u, 2) for value in values])


@pytest.mark.toolchain
@pytest.mark.parametrize(("alpha4", "noise_v"), [(1e-4, 0.0), (1e-4, 1e-4), (1e-3, 3e-5)])
def test_the_set_angle_found_is_the_one_drawn(fresh_seed, alpha4, noise_v):
    """Its mean square over 2000 turns within 8 %, and the interval of 95 % holds it in 92.5 to 97.5 % of them."""
    random, at, squares, held = np.random.default_rng(fresh_seed), judge.Judge(0.95), [], 0
    for _ in range(2000):
        value, freedom, _floor = turned(random, alpha4, noise_v).set_angle()
        line = at.deviation("", "rad", 1.0, value, freedom)
        squares.append(value**2)
        held += line.low <= alpha4 <= line.high
    assert np.mean(squares) == pytest.approx(alpha4**2, rel=0.08)
    assert 0.925 <= held / 2000 <= 0.975, held


def test_a_deviation_by_gravity_is_the_angle(fresh_seed):
    """Without noise, from 1e-4 to 0.1 deg, at any angle."""
    level = turned(np.random.default_rng(fresh_seed), 0.0, 0.0)
    for angle in (0.0, 17.0, 90.0, 200.0, 315.0):
        for away in (1e-4, -1e-2, 0.1):
            real = np.radians(angle + away)
            value = K @ [0.02, np.cos(real), np.sin(real)] + U0
            found, _ = level.deviation(angle, samples.Mean(value, np.full(3, 1e-9), np.full(3, 1e-9), 2))
            assert found == pytest.approx(away, rel=2e-3)


def test_samples_are_paired_checked_and_scaled():
    sampler = samples.Sampler(lambda: (24, 10.0))
    counts = [(2**23 - 1, -(2**23), 12345), (-1, 0, 1)]

    def frames(number, x, y, z):
        one = x.to_bytes(3, "little", signed=True) + y.to_bytes(3, "little", signed=True) + bytes([number])
        other = z.to_bytes(3, "little", signed=True) + bytes([(2 * number + 1) % 256, 0, 0, 50])
        return [one + bytes([samples.checksum(0x683, one)]), other + bytes([samples.checksum(0x693, other)])]

    assert samples.checksum(0x683, bytes.fromhex("00000000000000")) == bus_log_checksum()
    sampler._kept = []
    for number, (x, y, z) in enumerate(counts):
        for identifier, data in zip(samples.FRAMES, frames(number, x, y, z)):
            sampler.take(identifier, data, 0.0)
    broken = frames(7, 1, 2, 3)
    sampler.take(0x683, broken[0][:7] + b"\x00", 0.0)
    sampler.take(0x693, broken[1], 0.0)  # the other half of nothing
    assert sampler._kept == counts and sampler.refused == 1
    assert sampler.v_per_count == 10.0 / 2**23


def bus_log_checksum():
    """By long division, of 0x83 and seven zero bytes, as docs/bus/block.dbc has it."""
    crc = 0xFF
    for byte in b"\x83" + bytes(7):
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x2F if crc & 0x80 else 0)) & 0xFF
    return crc ^ 0xFF


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"limit_g": "0"}, "limit_g must be 1e-09 to 1, not '0'"),
        ({"limit_g": "nan"}, "limit_g must be"),
        ({"limit_g": '"3e-4"'}, "limit_g must be a number"),
        ({"limit_g": None}, "no limit_g"),
        ({"noise__noise_v": "-1"}, r"\[noise\] noise_v must be 1e-09 to 10"),
        ({"closure__closure_g": None}, r"\[closure\] has no closure_g"),
        ({"table__samples": "1"}, r"\[table\] samples must be 2 to 65535"),
        ({"table__converter_step_v": "0"}, r"\[table\] converter_step_v must be"),
        ({"table__samples": "2.5"}, r"\[table\] samples must be a whole number"),
        ({"identity__vendor_id": "-1"}, r"\[identity\] vendor_id must be"),
        ({"estimator": '"optimal"'}, 'estimator must be "averaged" or "refined" or "least_squares"'),
    ],
)
def test_bad_limits(tmp_path, changes, message):
    with pytest.raises(BadInput, match=message) as refusal:
        read_limits(str(limits(tmp_path, **changes)))
    assert "limits.toml" in str(refusal.value)


def test_limits_with_a_wrong_unit_or_a_missing_table(tmp_path):
    text = LIMITS.read_text()
    path = tmp_path / "limits.toml"
    path.write_text(text.replace("noise_v =", "noise_mv ="))
    with pytest.raises(BadInput, match=r"unknown key 'noise_mv' in \[noise\]; is noise_v meant\? \(a name states its"):
        read_limits(str(path))
    path.write_text(text.replace("[closure]\nclosure_g = 5e-4\n", ""))
    with pytest.raises(BadInput, match=r"no table \[closure\]"):
        read_limits(str(path))
    assert "closure" not in read_limits(str(path), ("noise",)).of


def validate(*arguments):
    return subprocess.run([sys.executable, "-B", ROOT / "tools/fixture/launch.py", *map(str, arguments)],
                          capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["can:vcan0", "--limits", "nowhere.toml"], 2, "nowhere.toml: no such file or folder"),
        (["serial:x", "--limits", LIMITS], 2, "the link 'serial:x' is not can:INTERFACE"),
        (["modbus:localhost", "--limits", LIMITS], 2, "has no HOST:PORT"),
        (["modbus-rtu:/dev/tty,9600,X", "--limits", LIMITS], 2, "is not DEVICE"),
        (["can:vcan0"], 2, "the following arguments are required: --limits"),
        (["can:vcan0", "--limits", LIMITS, "warmth"], 2, "there is no check 'warmth'"),
        (["can:vcan0", "--limits", LIMITS, "--run", "gone.csv"], 2, "gone.csv: no such file or folder"),
        (["can:vcan0", "--limits", LIMITS, "--junit", LIMITS], 2, "--junit"),
        (["modbus:127.0.0.1:1", "--limits", LIMITS], 3, "the gateway cannot be reached"),
    ],
)
def test_the_command_says_in_one_line_what_is_wrong(arguments, code, message):
    done = validate(*arguments)
    assert (done.returncode, done.stdout) == (code, ""), done.stderr
    assert done.stderr.startswith("validate: ") and done.stderr.count("\n") == 1 and message in done.stderr


def test_where_there_is_no_can_all_is_skipped():
    """77 without CAN in the kernel; where it has CAN, an interface that does not exist is bad input."""
    done = validate("can:novcan9", "--limits", LIMITS)
    assert done.returncode in (2, 77) and done.stderr.count("\n") == 1, done.stderr
    assert ("no CAN" if done.returncode == 77 else "no CAN interface of this name") in done.stderr


def test_help_names_every_check_and_exit_code():
    done = validate("--help")
    assert done.returncode == 0 and all(name in done.stdout for name in (*CHECKS, "130", "77", "LINK"))
