"""tools/fixture over CAN: the firmware itself, simulated drive and block, in virtual time (can:tumble@SCENARIO)."""

import re
import shlex
import signal
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from conftest import ROOT
from fixture_table import limits
from simulated_bench import scenario
from validation import command

from tumble import client, interruption
from tumble.client import can_link

pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytestmark = [pytest.mark.slow, pytest.mark.python]

PAGE = (ROOT / "docs/schedules.md").read_text()
HASTE = {
    "motion__speed_deg_s": 720,
    "motion__acceleration_deg_s2": 7200,
    "profile__homing_fast_deg_s": 720,
    "profile__homing_slow_deg_s": 90,
}
SLIPS = [f"slip time={13 + 0.5 * n} value=0.3" for n in range(16)]  # while it homes again and again
EXCEEDS = r"does not support a calibration to 3e-4 g: {} [-.e0-9]+ \w+ exceeds"
FAULTS = {  # checks, keys of the scenario, exit code, what is said in the end
    "homing": ("homing", {"fault": SLIPS}, 1, EXCEEDS.format("homing repeatability")),
    "positions": ("positions", {"stand__angle_rad": 3e-3}, 1, EXCEEDS.format("set angle, std dev")),
    "settling": ("settling", {"motion__settling_s": 6}, 1, EXCEEDS.format("settling time, worst")),
    "closure": ("closure", {"fault": "slip time=8 value=0.3"}, 1, EXCEEDS.format("closure of a turn")),
    "noise": ("noise", {"block__noise_v": "2e-3 2e-3 2e-3"}, 1, EXCEEDS.format("noise of a sample")),
    "an encoder that stops within the drive's window":
        ("positions", {"fault": "never_reached time=1 value=0.008"}, 1, r"read-back, worst +0\.008 deg .* fails"),
    "a drive without power": ("positions", {"fault": "drive_silent time=3"}, 1, r"positions: .*in fault"),
    "a node that is silent": ("link", {"present__navcomp": "no"}, 3, r"^validate: node 1 does not answer: "),
    "a block that is silent": ("noise", {"fault": "no_samples time=0"}, 3, "^validate: the block sends no samples"),
}  # fmt: skip


@pytest.fixture
def validate(monkeypatch, capsys):
    """The command, in this process: (exit code, what it printed, what it complained of). `validate.buses`: those that
    it has opened."""
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)
    monkeypatch.setattr(interruption, "_watched", [])
    monkeypatch.setattr(interruption, "_received", [])
    monkeypatch.setattr(can_link, "_TIMES_SILENT", 1)

    def run(*words):
        code = command.main([*map(str, words)])
        return code, *capsys.readouterr()

    def opened(where, really=client.open_bus):
        run.buses.append(really(where))
        return run.buses[-1]

    run.buses = []
    monkeypatch.setattr(client, "open_bus", opened)
    yield run
    for number, handler in handlers.items():
        signal.signal(number, handler)


def link(folder, **keys):
    return f"can:tumble@{scenario(folder, **{**HASTE, **keys})}"


def test_a_good_stand_meets_all_as_the_page_shows(validate, tumble, tmp_path, monkeypatch):
    """Live and by a run of the same stand, made before."""
    commands = re.findall(r"^    tools/\S+ (bench --out run|can:tumble@paper .*)$", PAGE, re.MULTILINE)
    bench, check = map(shlex.split, commands)
    assert tumble(*bench, cwd=tmp_path).returncode == 0
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tools").symlink_to(ROOT / "tools")
    code, out, err = validate(*check, "--junit", "fixture.xml")
    assert (code, err) == (0, ""), out + err
    assert "".join(f"    {line}\n" if line else "\n" for line in out.splitlines()) in PAGE, out
    assert max(map(len, out.splitlines())) <= 80
    assert validate.buses[0].end()["table"]["at_rest"]
    suite = ElementTree.parse(tmp_path / "fixture.xml").getroot()
    assert (suite.get("tests"), suite.get("failures")) == ("10", "0")


@pytest.mark.parametrize(("checks", "keys", "exit_code", "says"), FAULTS.values(), ids=FAULTS)
def test_a_fault_is_found_by_its_check(validate, tmp_path, checks, keys, exit_code, says):
    code, out, err = validate(link(tmp_path, **keys), checks, "--limits", limits(tmp_path))
    said = " ".join((err if code == 3 else out).split())
    assert code == exit_code and (out if code == 3 else err) == "" and re.search(says, said), out + err


def test_backlash_is_measured_and_seen_by_nothing_else(validate, tmp_path):
    """0.2 deg behind the encoder: found within four standard uncertainties; positions, all from below, stay good."""
    stand = link(tmp_path, motion__backlash_deg=0.2)
    code, out, _ = validate(stand, "positions", "backlash", "--limits", limits(tmp_path))
    rows = {line[2:26].strip(): line[26:].split() for line in out.splitlines() if line.startswith("  ")}
    assert code == 1 and rows["set angle, std dev"][-1] == rows["read-back, worst"][-1] == "meets", out
    assert abs(float(rows["backlash"][0]) - 0.2) < 4.0 * float(rows["backlash"][2]) + 0.005, out


def test_a_wrong_node(validate, tmp_path):
    asked = limits(tmp_path, identity__product_code="0x54420009")
    code, out, _ = validate(link(tmp_path), "link", "--limits", asked)
    assert code == 1 and "product code is 0x54420001 and not 0x54420009" in " ".join(out.split()), out


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_stops_the_table(validate, tmp_path, number, monkeypatch):
    """In the middle of a slow turn to 45 deg: at rest far from it, and soon."""
    told = []

    def opened(where, really=client.open_bus):
        bus = really(where)
        sleep = bus.sleep

        def interrupted(seconds):
            sleep(seconds)
            if not told and bus.now_s > 3.0:
                told.append(bus.now_s)
                signal.raise_signal(number)

        bus.sleep = interrupted
        return bus

    monkeypatch.setattr(client, "open_bus", opened)
    stand = link(tmp_path, motion__speed_deg_s=15, motion__acceleration_deg_s2=200)
    found = validate(stand, "settling", "--limits", limits(tmp_path))
    assert found == (128 + number, "", "validate: interrupted; the table was told to stop\n")
    table = validate.buses[0].end()["table"]
    assert table["at_rest"] and 20.0 < table["highest_deg"] < 25.0 and validate.buses[0].now_s < told[0] + 0.5, table


def test_as_tests_of_pytest(tmp_path):
    """`pytest tools/fixture --fixture LINK --limits FILE`: a test for each check, the sentence in the end."""
    pytest_command = [sys.executable, "-B", "-m", "pytest", "-p", "no:cacheprovider", "tools/fixture", "-q"]
    stand = "--fixture", link(tmp_path, motion__backlash_deg=0.2), "--limits", limits(tmp_path)
    done, without = (
        subprocess.run([*pytest_command, *map(str, given)], cwd=ROOT, capture_output=True, text=True, timeout=120)
        for given in (stand, ())
    )
    assert done.returncode == 1, done.stdout + done.stderr
    failed = set(re.findall(r"FAILED .*test_fixture\[(\w+)\]", done.stdout))
    assert failed == {"backlash", "level", "remounting", "support"}, done.stdout
    assert "not support a calibration to 3e-4 g: backlash 0.2 deg exceeds 0.01 deg" in " ".join(done.stdout.split())
    assert without.returncode == 0 and "10 skipped" in without.stdout
