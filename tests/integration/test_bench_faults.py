"""Faults through `tumble bench`: exit 3, one line that names the reason, the table at rest, the evidence kept."""

import json
import os

import pytest
from test_bench import wrapper

FAULTS = {  # lines added to the scenario; the reason that must be named
    "DRIVE_FAULT": ["fault = drive_fault at=1.3 phase=move value=0x7500"],
    "STAND_HEARTBEAT": ["fault = drive_silent at=1.4 phase=average"],
    "TARGET_NOT_REACHED": ["fault = never_reached at=1.5 phase=move value=1"],
    "HOMING": ["fault = homing_fails time=0"],
    "BLOCK_HEARTBEAT": ["fault = block_silent at=2.2 phase=average"],
    "NO_SAMPLES": ["fault = no_samples at=2.3 phase=average"],
    "SATURATED": ["fault = saturated at=1.6 phase=average channels=y"],
    "STUCK": ["fault = stuck at=1.7 phase=average channels=z"],
    "UNCERTAIN": ["procedure.error_budget_v = 1e-6"],
    "NOT_STILL": ["fault = noisy at=1.8 phase=average channels=x value=0.05"],
    "SWAPPED_CHANNELS": ["fault = swapped at=1.1 phase=mount channels=xy"],
    "WRONG_MOUNTING": ["operator.wrong_mounting = 2", "operator.mounted_instead = 1"],
    "MOUNTING_NOT_CONFIRMED": ["operator.mount_s = -1"],
}


@pytest.mark.parametrize("reason", FAULTS)
def test_faults(reason, tumble, tmp_path):
    lines = "\\n".join(FAULTS[reason])
    script = f'cat "$1" > {tmp_path}/s; printf "{lines}\\n" >> {tmp_path}/s; shift; exec "$REAL" {tmp_path}/s "$@"'
    done = tumble("bench", "--json", "--out", tmp_path / "run", TUMBLE_BENCH=wrapper(tmp_path, script))
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
    line = FAULTS["DRIVE_FAULT"][0]
    script = f'cat "$1" > {tmp_path}/s; echo "{line}" >> {tmp_path}/s; shift; exec "$REAL" {tmp_path}/s "$@"'
    done = tumble("bench", "--out", tmp_path / "run", TUMBLE_BENCH=wrapper(tmp_path, script))
    assert "drive error 0x7500)" in done.stderr
