"""`tumble.World`: the same bits as in campaigns and on the command line; and what its holder can do to it."""

import json
import re
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT
from simulated_bench import runs

import tumble
from tumble.world.border import Border

HOUR_S = 3600


def lines_of(world):
    return [f"{frame.time_s:.6f} {frame.id:03X}#{frame.data.hex().upper()}" for frame in world.frames()]


def test_the_same_bits_as_in_a_campaign():
    """Coefficients, verdict, truth, travel, frames; what they are, the goldens hold (tests/golden/sessions)."""
    for line in runs({}, 20):
        found = tumble.World(line["seed"]).run().document
        for key in ("exit", "state", "reason", "virtual_s", "table"):
            assert found[key] == line[key], (line["seed"], key)
        assert np.ravel(found["K"]).tolist() == line["K"] and found["U0"] == line["U0"]
        assert np.ravel(found["truth"]["K"]).tolist() == line["truth"]["K"]
        assert found["counters"]["bus_frames"] == line["frames"]


def test_the_result_is_that_of_the_command_line(tumble_run):
    world = tumble.World(5, stand=EXAMPLES / "lab_stand.toml", schedule="three_mountings").run()
    written = tumble_run("--seed", 5, "--stand", EXAMPLES / "lab_stand.toml", "--schedule", "three_mountings")
    assert world.result.document == written
    assert world.truth["K"] == written["truth"]["K"] and world.end == "done"
    assert world.truth["alpha3_rad"] == written["truth"]["alpha3_rad"]  # a list, too


@pytest.fixture
def tumble_run(tmp_path):
    """result.json of `tumble bench`."""

    def run(*options):
        from tumble.cli.main import main

        assert main(["bench", *map(str, options), "--no-report", "--out", str(tmp_path / "run")]) in (0, 1)
        return json.loads((tmp_path / "run/result.json").read_text())

    return run


def test_time_goes_on_as_far_as_it_is_told():
    """In pieces as in one go."""
    world = tumble.World(3)
    assert (world.now_s, world.state, world.end) == (0.0, "IDLE", "running")
    assert world.advance(0.5) and world.now_s == 0.5
    assert world.advance(until="AVERAGE") and world.state == "AVERAGE"
    began_s = world.now_s
    assert world.advance(2 * HOUR_S, until="SETTLE") and world.now_s > began_s and world.state == "SETTLE"
    while world.advance(0.25):
        pass
    assert world.end == "done" and not world.advance(1) and not world.advance()
    assert lines_of(world) == lines_of(tumble.World(3).run())
    assert world.document == tumble.World(3).run().document


def test_until_it_moves_on():
    world, states = tumble.World(3), Counter()
    while world.advance():
        states[world.state] += 1
    assert states["AVERAGE"] == states["SETTLE"] == 18 and states["WAIT_MOUNTING"] == 2


def test_a_state_that_never_comes_ends_with_the_run():
    world = tumble.World(3)
    assert not world.advance(until="FAULT") and world.end == "done"


def test_stopped_it_comes_to_rest():
    world = tumble.World(3)
    world.advance(until="MOVE")
    world.advance(0.2)
    assert not world.table["at_rest"]
    assert world.stop().table["at_rest"] and (world.end, world.state) == ("interrupted", "ABORT")
    with pytest.raises(tumble.TumbleError, match="the run failed: aborted by command"):
        _ = world.result


def test_its_holder_answers():
    world = tumble.World(3, operator="asked")
    assert world.question is None and world.advance(until="WAIT_MOUNTING")
    world.advance(HOUR_S / 60)
    assert world.question == {"kind": "mounting", "mounting": 1} and world.state == "WAIT_MOUNTING"
    for wrong in ("yes", "repeat position", "repeat position 256", "repeat mounting x"):
        with pytest.raises(tumble.UsageError, match="an answer is done, abort, leave, repeat position INDEX or repeat"):
            world.answer(wrong)
    with pytest.raises(tumble.UsageError):
        world.answer("repeat position 3")  # not now
    world.answer("done")
    assert world.advance(until="WAIT_MOUNTING") and world.question["mounting"] == 2
    world.answer("done")
    assert world.run().end == "done" and world.result.passed


def test_frames_of_its_own():
    """An SDO read of the state, answered on the bus; it is among the frames, and so is the answer."""
    world = tumble.World(3)
    world.advance(1)
    world.send(0x601, bytes([0x40, 0x00, 0x20, 1, 0, 0, 0, 0]))
    world.advance(0.1)
    asked = [frame for frame in world.frames() if frame.id in (0x601, 0x581) and frame.time_s > 1.0]
    assert [(frame.id, frame.sender) for frame in asked] == [(0x601, "guest"), (0x581, "navcomp")]
    for identifier, data in ((0x800, b""), (0x123, bytes(9))):
        with pytest.raises(tumble.UsageError, match="no classic data frame with an 11-bit identifier"):
            world.send(identifier, data)


def test_as_a_bus_of_python_can():
    """Its time passes in recv; python-can's own messages; the world goes on afterwards."""
    can = pytest.importorskip("can", reason="python-can is not installed")
    world = tumble.World(3)
    with world.bus(can_filters=[{"can_id": 0x701, "can_mask": 0x7FF}]) as bus:
        beats = [bus.recv(1.0) for _ in range(5)]
        assert {beat.arbitration_id for beat in beats} == {0x701} and beats[-1].timestamp > 0.3
        assert world.now_s == pytest.approx(beats[-1].timestamp)
        bus.send(can.Message(arbitration_id=0x601, data=[0x40, 0, 0x20, 1, 0, 0, 0, 0], is_extended_id=False))
        assert any(frame.id == 0x581 for frame in world.frames())
    with pytest.raises(can.CanOperationError, match="the bus has been shut down"):
        bus.recv(1.0)
    assert world.run().end == "done" and world.result.passed
    with world.bus() as bus, pytest.raises(can.CanOperationError, match="the simulated run has come to its end"):
        bus.sleep(1.0)


def test_the_memory_outlives_power():
    """A set of coefficients is there when the computer has power again, and the run that it missed is none."""
    world = tumble.World(3, memory=True, **{"keeper.serial": "B-17", "keeper.first": True})
    world.run()
    assert world.end == "done" and b"B-17" in bytes(world.memory)
    kept = bytes(world.memory)
    world.cut_power()
    world.restore_power()
    assert world.advance(1.0) and world.state == "IDLE" and bytes(world.memory) == kept
    world.start()
    with pytest.raises(tumble.UsageError):
        world.start()
    assert world.run().end == "done" and bytes(world.memory) != kept
    without = tumble.World(3)
    assert len(without.memory) == 0


def test_without_power_nothing_is_sent():
    world = tumble.World(3)
    world.advance(until="AVERAGE")
    world.cut_power()
    cut_s = world.now_s
    world.advance(2.0)
    mute = [frame for frame in world.frames() if frame.sender == "navcomp" and frame.time_s > cut_s]
    assert mute == [] and world.now_s == pytest.approx(cut_s + 2.0, abs=1e-9)
    world.restore_power()
    world.advance(1.0)
    assert any(frame.id == 0x701 and frame.time_s > cut_s + 2.0 for frame in world.frames())


REFUSED = {
    "no such key": ({"no.such": 1}, "this cannot be simulated: no such key: no.such"),
    "out of range": ({"motion.settling_s": -1}, "motion.settling_s must be"),
    "not a number": ({"motion.settling_s": "soon"}, "motion.settling_s must be"),
    "too many": ({"block.bias_v": [1, 2]}, "block.bias_v must be"),
    "a fault of no place": ({"fault": "stall at=9.9"}, "a fault names a position that the schedule does not have"),
    "operator": ({"operator": "me"}, "operator: 'me' is not one of by-itself, on-confirm, never, asked"),
    "estimator": ({"procedure.estimator": "best"}, "procedure.estimator: 'best' is not one of"),
    "a converter beside its stand": ({"block.range_v": 5}, "block.range_v: give it by [block] of the stand"),
    "a position beside its schedule": ({"position": "1 1 fit 0 0 1"}, "position: give it by schedule"),
    "memory of nobody": ({"memory": True}, "keeper.serial is missing"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name):
    given, words = REFUSED[name]
    with pytest.raises(tumble.UsageError) as refused:
        tumble.World(1, **given)
    assert words in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize("seed", [-1, 2**64, 1.0, "1", True, None])
def test_seeds_that_are_none(seed):
    with pytest.raises(tumble.UsageError, match="is not a whole number from 0 to 2"):
        tumble.World(seed)


def test_values_as_python_has_them():
    """Lists for values, texts with blanks as they are, yes and no."""
    one = tumble.World(4, samples=20, **{"block.bias_v": [0.01, 0.02, 0.03], "drive.instant_homing": True})
    given = {"procedure.samples": 20, "block.bias_v": "0.01 0.02 0.03", "drive.instant_homing": "yes"}
    other = tumble.World(4, **given)
    assert lines_of(one.run()) == lines_of(other.run()) != []
    assert one.document["means"][0]["samples"] == 20


def test_the_keys_are_those_of_the_table():
    known = tumble.World.keys()
    assert len(known) > 100 and {"firmware.loop_us", "motion.settling_s", "keeper.serial"} <= known.keys()
    assert known["block.noise_v"].values == 3 and "V" in known["block.noise_v"].about


def test_two_worlds_share_nothing():
    one, other = tumble.World(3), tumble.World(4)
    while one.advance(1.0) | other.advance(1.0):
        pass
    assert lines_of(one) == lines_of(tumble.World(3).run()) and lines_of(other) == lines_of(tumble.World(4).run())


def test_the_check_of_the_result_knows_of_an_error_budget():
    """Which ends averaging early: the uncertainties are those of the samples that were taken."""
    world = tumble.World(4, samples=200, **{"procedure.error_budget_v": 1e-4}).run()
    assert world.result.passed and {mean["samples"] for mean in world.document["means"]} < set(range(200))


@pytest.mark.toolchain
def test_the_page_s_script(tmp_path):
    """Ten calibrations with a fault, frames, and a picture of the angle: as printed, and no longer than 15 lines."""
    pytest.importorskip("matplotlib")
    page = (ROOT / "docs/bench.md").read_text(encoding="utf-8").partition("## A world in Python")[2]
    code = page.partition("```python\n")[2].partition("```")[0]
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert len(lines) == 10 and all(" done True " in line for line in lines) and len(code.splitlines()) <= 15
    assert (tmp_path / "angles.png").read_bytes().startswith(b"\x89PNG")


WRONG_CALLS = [
    (lambda world: world.advance(-1), "seconds: '-1' is not a number from 0 to 1e+09"),
    (lambda world: world.advance(float("nan")), "is not a number from 0 to"),
    (lambda world: world.advance("AVERAGE"), "is not a number from 0 to"),
    (lambda world: world.advance(until="NOWHERE"), "until: 'NOWHERE' is none of IDLE, PREFLIGHT, "),
    (lambda world: world.answer(3), "of the wrong type, or too large: '3'"),
    (lambda world: world.send(0x80, "abc"), "of the wrong type"),
    (lambda world: world.send(0x10000, b""), "no classic data frame with an 11-bit identifier"),
    (lambda world: world.send(1, bytes(300)), "no classic data frame with an 11-bit identifier"),
    (lambda world: world.turn_table("a", 1.0), "of the wrong type"),
]


@pytest.mark.parametrize("case", range(len(WRONG_CALLS)))
def test_what_cannot_be_done_is_told_by_an_error_of_ours(case):
    call, words = WRONG_CALLS[case]
    with pytest.raises(tumble.UsageError, match=re.escape(words)):
        call(tumble.World(1))


def test_numbers_may_be_texts_and_there_is_no_result_before_the_end():
    world = tumble.World(1, **{"procedure.samples": "10", "procedure.gravity_limit_g": "1e-3"})
    with pytest.raises(tumble.errors.BenchFault, match="has not come to its end"):
        _ = world.result
    assert world.run().result.passed and world.document["verification"]["limit_g"] == 1e-3


def test_setting_keys_in_two_threads_mixes_nothing():
    """A line is cut into its words without any memory that worlds share."""
    line = "block.noise_v = " + " " * 900 + "1e-4 2e-4 3e-4"

    def make(number):
        return [Border(number, [line], None) for _ in range(300)]

    with ThreadPoolExecutor(2) as pool:
        assert sum(map(len, pool.map(make, range(2)))) == 600


def test_the_stand_of_the_keys_confirms_the_result():
    keys = {"stand.axis_tilt_rad": 1e-5, "stand.platform_rad": 1e-4, "block.noise_limits": "sigma3"}
    found = tumble.World(3, **keys).run().result
    declared = found.document["stand"]
    assert declared["platform_rad"] == 1e-4 and declared["noise_v"] == pytest.approx(1e-4, rel=1e-15)
