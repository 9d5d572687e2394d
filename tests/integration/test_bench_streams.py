"""`tumble bench` where something it reads from or writes to is closed, full, gone, or can be read only once."""

import json
import os
import subprocess

import pytest
from conftest import EXAMPLES
from simulated_bench import scenario
from test_bench import BENCH, result_of


def in_shell(line, folder):
    """A line of shell; "$@" is `tumble bench`."""
    return subprocess.run(["bash", "-c", line, "bash", *BENCH], cwd=folder, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("redirection", ["2>&-", "2>/dev/full", "2>&- <&-"])
def test_without_a_standard_error_the_result_comes_all_the_same(redirection, tmp_path):
    done = in_shell(f'"$@" --json --out run {redirection}', tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == result_of(tmp_path / "run")
    assert sorted(os.listdir(tmp_path / "run")) == ["bus.log", "inputs", "result.json", "run.csv"]


@pytest.mark.parametrize("redirection", ["2>&-", "2>/dev/full"])
def test_without_a_standard_error_faults_keep_their_exit_code(redirection, tmp_path):
    assert in_shell(f'"$@" --seed x {redirection}', tmp_path).returncode == 2
    assert in_shell(f'"$@" --interactive --out run {redirection} </dev/null', tmp_path).returncode == 3


@pytest.mark.parametrize("redirection", ["<&-", "<<< $'\\xff'"])
def test_an_input_that_cannot_be_read_has_ended(redirection, tmp_path):
    done = in_shell(f'"$@" --interactive --out run {redirection}', tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.splitlines()[-1].startswith("tumble: the run failed: aborted by command (COMMAND,")


@pytest.mark.parametrize("limit_kb", [1, 30, 300])
def test_a_full_disk_is_told_with_the_folder_that_was_asked_for(limit_kb, tmp_path):
    """A limit on the size of files stands for it: the scenario, run.csv, or bus.log does not fit."""
    done = in_shell(f'ulimit -f {limit_kb}; "$@" --out run', tmp_path)
    assert (done.returncode, done.stdout) == (2, ""), done.stderr
    assert done.stderr.splitlines()[-1].startswith("tumble: run: cannot be written")
    assert ".part" not in done.stderr and os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ["stand", "block", "schedule"])
def test_an_input_that_can_be_read_only_once_is_kept_as_it_was_read(name, tmp_path):
    files = {"stand": EXAMPLES / "lab_stand.toml", "schedule": EXAMPLES / "with_checks.toml", "block": tmp_path / "b"}
    files["block"].write_text("[block]\nscale_v_per_g = 1.5\nmisalignment_rad = 0.01\n")
    done = in_shell(f'"$@" --out run --{name} <(cat {files[name]})', tmp_path)
    assert done.returncode in (0, 1), done.stderr
    kept = [path for path in (tmp_path / "run/inputs").iterdir() if path.name != "scenario.txt"]
    assert [path.read_bytes() for path in kept] == [files[name].read_bytes()]


def test_a_working_folder_that_is_gone(tmp_path):
    done = in_shell('mkdir gone; cd gone; rmdir ../gone; "$@" --out run', tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[-1] == "tumble: run: the folder cannot be made: no such file or folder"


def test_a_folder_s_name_stays_on_its_line(tumble, tmp_path):
    done = tumble("bench", "--out", "a\nb", cwd=tmp_path)
    assert done.returncode == 0 and done.stderr.splitlines()[-1] == "run folder: 'a\\nb'"
    assert os.listdir(tmp_path) == ["a\nb"]


def test_a_fault_that_comes_again_is_asked_about_again(tmp_path):
    """As often as the operator has the position repeated, until he gives up."""
    scenario(tmp_path, fault="bus_off at=1.5")  # it fails again at once
    answers = "printf 'done\nrepeat position 1\nrepeat position 1\nabort\n'"
    done = in_shell(f'{answers} | "$@" --interactive --scenario scenario.txt --out run', tmp_path)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr.count("Fault: the CAN controller is off the bus.") == 3, done.stderr
