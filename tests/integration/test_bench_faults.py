"""Faults through `tumble bench`: exit 3, one line that names the reason, the table at rest, the evidence kept."""

import json
import os

import pytest

FAULTS = {  # lines added to the scenario; the reason that must be named
    "DRIVE_FAULT": ["fault = drive_fault at=1.3 phase=move value=0x7500"],
    "STAND_HEARTBEAT": ["fault = drive_silent at=1.4 phase=average"],
    "TARGET_NOT_REACHED": ["fault = never_reached at=1.5 phase=move value=1"],
    "HOMING": ["fault = homing_fails time=0"],
    "BLOCK_HEARTBEAT": ["fault = block_silent at=2.2 phase=average"],
    "NO_SAMPLES": ["fault = no_samples at=2.3 phase=average"],
    "SATURATED": ["fault = saturated at=1.6 phase=average channels=y"],
    "STUCK": ["fault = stuck at=1.7 phase=average channels=z"],
    "UNCERTAIN": [],
    "NOT_STILL": ["fault = noisy at=1.8 phase=average channels=x value=0.05"],
    "SWAPPED_CHANNELS": ["fault = swapped at=1.1 phase=mount channels=xy"],
    "WRONG_MOUNTING": ["operator.wrong_mounting = 2", "operator.mounted_instead = 1"],
    "MOUNTING_NOT_CONFIRMED": ["operator.mount_s = -1"],
}
OPTIONS = {"UNCERTAIN": ["--error-budget", "1e-6"]}
SAME = "position = 1 4 fit 135.0 0.7071067811865476 -0.7071067811865476\nprocedure.samples = 50\n"


@pytest.mark.parametrize("reason", FAULTS)
def test_faults(reason, tumble, tmp_path):
    scenario = tmp_path / "scenario.txt"
    scenario.write_text("\n".join(FAULTS[reason]))
    done = tumble("bench", "--json", *OPTIONS.get(reason, ()), "--scenario", scenario, "--out", tmp_path / "run")
    assert (done.returncode, done.stdout) == (3, ""), done.stderr
    line = done.stderr.splitlines()[-1]
    assert line.startswith("tumble: the run failed: ") and f"({reason}, in state " in line, line
    assert "THE TABLE" not in line
    assert sorted(os.listdir(tmp_path / "run")) == ["bus.log", "fault.json", "inputs", "run.csv"]
    fault = json.loads((tmp_path / "run/fault.json").read_text())
    assert fault["reason"] == f"TUMBLE_REASON_{reason}" and fault["table"]["at_rest"] is True
    assert all(entry["times"] > 0 for entry in fault["faults"])
    assert len((tmp_path / "run/bus.log").read_text()) > 100


def test_a_drive_s_error_code_is_told(tumble, tmp_path):
    scenario = tmp_path / "scenario.txt"
    scenario.write_text(FAULTS["DRIVE_FAULT"][0])
    done = tumble("bench", "--scenario", scenario, "--out", tmp_path / "run")
    assert done.returncode == 3 and "drive error 0x7500)" in done.stderr


def test_the_true_travel_stands_in_the_result_and_in_what_a_fault_leaves(tumble, tmp_path):
    scenario = tmp_path / "scenario.txt"
    for name, line, code, highest_deg in (("sound", "", 0, 360.0), ("stopped", FAULTS["DRIVE_FAULT"][0], 3, 45.0)):
        scenario.write_text(line)
        done = tumble("bench", "--json", "--scenario", scenario, "--out", tmp_path / name)
        assert done.returncode == code, done.stderr
        kept = json.loads((tmp_path / name / ("fault.json" if code else "result.json")).read_text())
        assert done.stdout == "" if code == 3 else json.loads(done.stdout) == kept
        assert set(kept["table"]) == {"lowest_deg", "highest_deg", "at_rest"} and kept["table"]["at_rest"] is True
        assert abs(kept["table"]["highest_deg"] - highest_deg) < 0.1


def test_a_scenario_wins_over_the_stand_file(tumble, tmp_path):
    """What it says as the setup would is no contradiction: the scenario of an earlier run can be taken as it is."""
    scenario = tmp_path / "scenario.txt"
    scenario.write_text(f"# Prüfstand\nmotion.speed_deg_s = 45\n{SAME}")
    for name, given in (("one", scenario), ("two", tmp_path / "one/inputs/scenario.txt")):
        done = tumble("bench", "--scenario", given, "--out", tmp_path / name)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "one/run.csv").read_bytes() == (tmp_path / "two/run.csv").read_bytes()
    assert (tmp_path / "one/inputs/scenario.txt").read_text().count("motion.speed_deg_s") == 1


@pytest.mark.parametrize(
    "line, said",
    [
        ("position = 1 4 fit 90 1 0", "{}: row 3: position is given by --schedule"),
        ("procedure.samples = 10", "{}: row 3: procedure.samples is given by --samples"),
        ("fault = smoke time=1", "{}:3: no such fault"),
        ("drive.wrap_count = 1", "{}:3: no such key: drive.wrap_count"),
        ("fault = dérive time=1", "{}: row 3: is not ASCII text"),
    ],
)
def test_a_wrong_line_is_named_by_file_and_number(line, said, refused, tmp_path):
    scenario = tmp_path / "my.txt"
    scenario.write_text(f"# first\n\n{line}\n")
    assert said.format(scenario) in refused("bench", "--scenario", scenario)
