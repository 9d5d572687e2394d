"""`tumble bench`: the run folder, the result with truth, the same bytes from the same seed, interruption, questions."""

import json
import os
import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import paper_stand, valid
from test_terminal import on_terminal, without_styles

from tumble.core import paper_schedule
from tumble.files.stand_file import read_stand
from tumble.prompts import mounting_text
from tumble.stand import PAPER_STAND

BENCH = [sys.executable, "-m", "tumble", "bench"]
PACED = """
import runpy
from tumble.world import in_process
real = in_process.Run
in_process.Run = lambda border, on_event, pace: real(border, on_event, {})
runpy.run_module("tumble", run_name="__main__", alter_sys=True)
"""


def paced(pace):
    """`tumble bench` with so many virtual seconds per second."""
    return [sys.executable, "-c", PACED.format(pace), "bench"]


def result_of(folder):
    """result.json, valid by its schema."""
    return valid((folder / "result.json").read_text())


def test_passes_out_of_the_box(tumble, tmp_path):
    """No options: the paper's stand. The coefficients lie within four standard uncertainties of the truth."""
    done = tumble("bench", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    folder = next((tmp_path / "runs").iterdir())
    assert folder.name.endswith("Z-1")
    assert sorted(path.name for path in folder.iterdir()) == ["bus.log", "inputs", "result.json", "run.csv"]
    result = result_of(folder)
    assert (result["seed"], result["bus"], result["firmware"]) == (1, "inprocess", "host")
    errors = np.array(result["K"]) - result["truth"]["K"], np.array(result["U0"]) - result["truth"]["U0"]
    assert np.abs(errors[0] / result["u_K"]).max() < 4.0 and np.abs(errors[1] / result["u_U0"]).max() < 4.0
    assert np.abs(errors[0]).max() > 0.0  # measured, not copied
    assert len(result["truth"]["alpha3_rad"]) == 2 and len(result["truth"]["alpha4_rad"]) == 18
    assert result["counters"]["samples_averaged"] == 900 and result["counters"]["rows"] == 900
    assert "numpy agrees" in done.stdout and "truth" in done.stdout and "error/u" in done.stdout
    assert max(map(len, done.stdout.splitlines())) <= 80


@pytest.mark.parametrize("stand", ["paper_stand", "angle_stand", "lab_stand"])
def test_the_example_stands(stand, tumble, tmp_path):
    file = EXAMPLES / f"{stand}.toml"
    done = tumble("bench", "--stand", file, "--seed", 2**64 - 1, "--out", tmp_path / "run", "--json")
    assert done.returncode in (0, 1), done.stderr
    result = json.loads(done.stdout)
    assert result == result_of(tmp_path / "run")
    assert result["truth"]["K"] == [list(row) for row in read_stand(str(file)).truth["K"]]
    assert result["seed"] == 2**64 - 1
    assert (tmp_path / "run/inputs" / file.name).read_bytes() == file.read_bytes()


def test_the_default_stand_is_the_paper_s():
    assert PAPER_STAND == read_stand(str(EXAMPLES / "paper_stand.toml")).stand


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--estimator", "averaged", "--samples", "1"],
        ["--schedule", str(EXAMPLES / "with_checks.toml"), "--stand", str(EXAMPLES / "lab_stand.toml")],
        ["--schedule", str(EXAMPLES / "six_faces.toml"), "--estimator", "least_squares", "--limit", "1e-3"],
    ],
)
def test_the_same_seed_gives_the_same_bytes(options, tumble, tmp_path):
    """All of the folder, not only result.json and bus.log; another seed gives other ones."""
    for name, seed in (("a", 9), ("b", 9), ("c", 10)):
        done = tumble("bench", "--seed", seed, *options, "--out", tmp_path / name)
        assert done.returncode in (0, 1), done.stderr
    for name in ("result.json", "bus.log", "run.csv", "inputs/scenario.txt"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    for name in ("result.json", "bus.log", "run.csv"):
        assert (tmp_path / "a" / name).read_bytes() != (tmp_path / "c" / name).read_bytes(), name


def test_solve_makes_the_same_of_the_run_file(tumble, tmp_path):
    """run.csv has volts of 17 digits and raw counts: solved from it alone, the coefficients agree to rounding."""
    tumble("bench", "--out", tmp_path / "run", "--seed", 3)
    done = tumble("solve", tmp_path / "run/run.csv", "--json")
    assert done.returncode == 0, done.stderr
    ours, again = result_of(tmp_path / "run"), json.loads(done.stdout)
    assert np.abs(np.array(ours["K"]) - again["K"]).max() < 1e-12 * 2
    columns = (tmp_path / "run/run.csv").read_text().splitlines()[0]
    assert columns == "mounting,position,ux,uy,uz,cx,cy,cz,counter,timestamp,temperature,time_s"


def test_a_limit_that_is_not_met_is_exit_1_with_the_full_result(tumble, tmp_path):
    done = tumble("bench", "--limit", "1e-6", "--out", tmp_path / "run")
    assert done.returncode == 1 and "FAIL" in done.stdout
    assert result_of(tmp_path / "run")["verification"]["pass"] is False


def test_a_block_file_overrides_the_stand_s(tumble, tmp_path):
    block = tmp_path / "block.toml"
    block.write_text("[block]\nscale_v_per_g = -0.5\nmisalignment_rad = 0.001\nconverter_bits = 20\nrange_v = 2.5\n")
    options = ["--stand", EXAMPLES / "paper_stand.toml", "--block", block, "--out", tmp_path / "run"]
    assert tumble("bench", *options, "--limit", "1e-2").returncode == 0
    result = result_of(tmp_path / "run")
    assert np.allclose(np.diag(result["truth"]["K"]), -0.5, rtol=0.02)
    inputs = sorted(os.listdir(tmp_path / "run/inputs"))
    assert inputs == ["block.toml", "paper_stand.toml", "scenario.txt"]


@pytest.mark.parametrize("scale", [-1e-3, 0.1, 40.0])
def test_the_bias_that_is_drawn_is_in_proportion_to_the_scale(scale, tumble, tmp_path):
    """So that a block of small or large sensitivity is as good a block as any."""
    block = tmp_path / "block.toml"
    block.write_text(f"[block]\nscale_v_per_g = {scale}\nmisalignment_rad = 0.02\nrange_v = {4 * abs(scale)}\n")
    stand = tmp_path / "stand.toml"
    text = (EXAMPLES / "paper_stand.toml").read_text()
    stand.write_text(re.sub("noise_v = .*", f"noise_v = {1e-4 * abs(scale)}", text).split("[block]")[0])
    for seed in range(1, 4):
        done = tumble("bench", "--stand", stand, "--block", block, "--seed", seed, "--out", tmp_path / str(seed))
        assert done.returncode == 0, done.stderr
        truth = result_of(tmp_path / str(seed))["truth"]
        assert 0.001 < np.abs(truth["U0"]).max() / abs(scale) <= 0.05


def test_motion_and_wide_schedules_are_heeded(tumble, tmp_path):
    """A slow table takes longer in virtual time; the cable is long enough for the schedule's angles."""
    schedule = tmp_path / "wide.toml"
    motion = "\n[motion]\nvelocity_deg_per_s = 2\nacceleration_deg_per_s2 = 1\nsettling_s = 3\n"
    slow = paper_stand(tmp_path, motion)
    schedule.write_text((EXAMPLES / "with_checks.toml").read_text().replace("angle_deg = 360", "angle_deg = 720"))
    options = ["--schedule", schedule, "--estimator", "least_squares", "--limit", "1e-3"]
    done = tumble("bench", "--stand", slow, *options, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    last = (tmp_path / "run/bus.log").read_text().splitlines()[-1]
    assert float(last[1:18]) > 700.0


def test_progress_goes_to_stderr_one_line_a_mounting(tumble, tmp_path):
    done = tumble("bench", "--json", "--out", tmp_path / "run")
    lines = done.stderr.splitlines()
    assert [line.split(",")[0] for line in lines[:2]] == [
        "mounting 1: position 1 of 18",
        "mounting 2: position 10 of 18",
    ]
    assert lines[2:] == [f"run folder: {tmp_path / 'run'}"]
    assert json.loads(done.stdout)["seed"] == 1


@pytest.mark.real_time
def test_live_progress_on_a_terminal(tmp_path):
    """Slowed down, so that there is something to see."""
    shown = without_styles(on_terminal([*paced(10), "--out", str(tmp_path / "run")], columns=120))
    for words in (r"position \d+ of 18, mounting 1", r"position \d+ of 18, mounting 2", "ETA 0:", "PASS", "K_xx"):
        assert re.search(words, shown), words
    assert re.search(r"x [+-]\d\.\d{5}\(\de-0[3456]\)", shown)  # the running mean and its error


def test_interactive_asks_for_both_mountings(tmp_path):
    command = [*BENCH, "--interactive", "--out", str(tmp_path / "run")]
    done = subprocess.run(command, input="\nnonsense\ndone\n", capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert "mounting 1 says: x along +h" in done.stderr and "mounting 2 says: x along -h" in done.stderr
    assert "not accepted: an answer is" in done.stderr
    lines = done.stderr.replace(str(tmp_path), "").splitlines()
    assert max(len(line) for line in lines if not line.startswith("not accepted")) <= 80
    assert lines.count("[Enter or done: it is done; leave: do nothing; abort: stop here]") == 2


def test_interactive_with_nobody_there_gives_up(tmp_path):
    command = [*BENCH, "--interactive", "--out", str(tmp_path / "run")]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.splitlines()[-1].startswith("tumble: the run failed: aborted by command (COMMAND,")
    assert done.stderr.splitlines()[-2] == f"run folder: {tmp_path / 'run'}"
    assert (tmp_path / "run" / "fault.json").is_file()


def test_a_run_folder_in_runs_needs_no_folder_first(tumble, tmp_path):
    assert tumble("bench", "--out", "runs/mine", cwd=tmp_path).returncode == 0
    assert (tmp_path / "runs/mine/result.json").is_file()


def test_mountings_are_described_by_the_axes_of_the_table():
    one, two = map(mounting_text, paper_schedule().mountings)
    assert one.startswith("x along +h (") and "; z along +v (" in one
    assert two.startswith("x along -h (") and "; y along +v (" in two


@pytest.mark.real_time
@pytest.mark.parametrize("interactive", [False, True])
def test_interruption_stops_the_table_first(interactive, tmp_path):
    """While the table turns in real time, and while a question waits. Nothing is left."""
    options = ["--interactive"] if interactive else []
    child = subprocess.Popen(
        [*paced(3), "--out", str(tmp_path / "run"), *options],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    first = child.stderr.readline()
    assert ("Mount the block" if interactive else "mounting 1") in first
    time.sleep(0.1 if interactive else 0.6)
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=30)
    assert (child.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "tumble: interrupted; the table is at rest"
    assert os.listdir(tmp_path) == []


def test_keys_win_over_the_stand_file_and_the_scenario(tumble, tmp_path):
    (tmp_path / "faults.txt").write_text("motion.settling_s = 1\nfault = stall at=1.3 phase=move duration=2\n")
    options = ("--scenario", "faults.txt", "--set", "motion.settling_s=0.25", "--set", "operator.mends=1")
    options += ("--set", "operator.mend_s = 5", "--set", "fault=stall at=2.3 phase=move duration=2")
    done = tumble("bench", *options, "--out", "run", cwd=tmp_path)
    assert done.returncode == 3 and "(STALL, in state move, positions finished: 11" in done.stderr  # mends one of two
    lines = (tmp_path / "run/inputs/scenario.txt").read_text().splitlines()
    assert [line for line in lines if line.startswith("motion.settling_s")] == ["motion.settling_s=0.25"]
    assert sum(line.startswith("fault") for line in lines) == 2


def test_the_stand_of_the_keys_is_that_of_a_file(tumble, tmp_path):
    """A result is confirmed by the stand that the firmware was told of, wherever that was declared."""
    of_file = other = (EXAMPLES / "angle_stand.toml").read_text()
    for line, instead in {
        "angle_rad = 2e-4\n": "angle_rad = 3e-5\nencoder_rad = 6e-5\ndrift_v = [1e-5, 2e-5, 3e-5]\n",
        "noise_v = 1.5e-4 ": "noise_v = 4.5e-4 ",
        'limits = "sigma1"\n': 'limits = "sigma3"\n',
    }.items():
        assert other.count(line) == 1
        other = other.replace(line, instead)
    (tmp_path / "angle.toml").write_text(of_file)
    (tmp_path / "other.toml").write_text(other)
    keys = ("angle_rad=3e-5", "encoder_rad=6e-5", "drift_v=1e-5 2e-5 3e-5", "limits=sigma3")
    told = [word for key in keys for word in ("--set", f"stand.{key}")]
    for folder, options in {"file": ("other.toml",), "keys": ("angle.toml", *told)}.items():
        done = tumble("bench", "--stand", *options, "--out", folder, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    by_file, by_keys = (result_of(tmp_path / folder) for folder in ("file", "keys"))
    assert by_keys["K"] == by_file["K"] and by_keys["stand"].keys() == by_file["stand"].keys()
    for name in ("u_K", "u_U0", "covariance"):
        np.testing.assert_allclose(by_keys[name], by_file[name], rtol=1e-12)


def test_many_runs_are_those_of_their_seeds(tumble, tmp_path):
    given = ("--stand", EXAMPLES / "lab_stand.toml", "--estimator", "optimal", "--samples", "20")
    done = tumble("bench", *given, "--runs", "3", "--jobs", "2", "--seed", "8", cwd=tmp_path)
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == max(line["exit"] for line in lines) and list(tmp_path.iterdir()) == []
    for line in lines:
        folder = tmp_path / str(line["seed"])
        tumble("bench", *given, "--seed", line["seed"], "--out", folder)
        result = result_of(folder)
        assert line["K"] == np.ravel(result["K"]).tolist() and line["truth"]["U0"] == result["truth"]["U0"]
    assert [line["seed"] for line in lines] == [8, 9, 10]
