"""The C programs by their command lines: options that are none, and scenarios that are none or lack something."""

import subprocess

import pytest
from simulated_bench import HASTY_STAND, scenario

from tumble.world import programs

LINUX = ("tumble-node", "tumble-stand")


def run(name, *arguments):
    command = [programs.find(name), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=20)


def refuses(name, complaint, *arguments):
    """With one line of complaint."""
    done = run(name, *arguments)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"{name}: {complaint}\n")


@pytest.mark.parametrize("name", LINUX)
def test_options_that_are_none(name):
    text = run(name, "--help").stdout
    assert max(map(len, text.splitlines())) <= 80 and run(name, "-h").stdout == text and "  -h, --help" in text
    for wrong in ("--bogus", "-x"):
        refuses(name, f"{wrong}: no such option; see --help", wrong)


@pytest.mark.parametrize("names, option, values, says", [
    (LINUX, "--log", ["xml", ""], "must be text or json"),
    (LINUX, "--log-level", ["6"], "must be error, warning, notice or info"),
    (LINUX[1:], "--operator", ["bogus", "", "on_confirm", "by itself", "Never"],
     "must be by-itself, on-confirm, never, hands, start or ask"),
])
def test_values_that_are_none(names, option, values, says):
    for name in names:
        for value in values:
            refuses(name, f"{option}: {says}", "vcan0", option, value)
        refuses(name, f"{option}: needs a value", "vcan0", option)


@pytest.mark.parametrize("log", [["--log", "json"], ["--log", "text"], ["--log-level", "error"]])
@pytest.mark.parametrize("progress", [["--progress"], ["--progress-fd", "2"]])
def test_one_standard_error_for_two(log, progress):
    """Lines of progress are no events; whoever reads a log of JSON would stumble over each."""
    says = "--progress: cannot share standard error with --log; --progress-fd has another"
    for given in (log + progress, progress + log):
        refuses("tumble-node", says, "nocan0", *given)
    done = run("tumble-node", "nocan0", "--progress-fd", "1", *log)
    assert done.returncode in (2, 77) and done.stderr.startswith("tumble-node: nocan0: ")


def test_a_stand_file_is_no_scenario(tmp_path):
    stand = tmp_path / "my.toml"
    stand.write_text(HASTY_STAND)
    none = tmp_path / "none.toml"
    for name in LINUX:
        refuses(name, f"{stand}: looks like a stand file; a scenario file is wanted (docs/gateway.md)", "vcan0", stand)
        refuses(name, f"{none}: No such file or directory", "vcan0", none)


def test_a_memory_needs_the_name_of_the_block(tmp_path):
    """Before it is made, and before the bus is opened."""
    nv = tmp_path / "nv.bin"
    says = "keeper.serial: is missing: with --nv the scenario must name the block"
    for given in ((), (scenario(tmp_path),), (scenario(tmp_path, "other.txt", keeper__commits="no"),)):
        refuses("tumble-node", says, "vcan0", *given, "--nv", nv)
        assert not nv.exists()
    named = scenario(tmp_path, "named.txt", keeper__serial="B-17")
    done = run("tumble-node", "nocan0", named, "--nv", nv)
    assert done.returncode in (2, 77) and "nocan0" in done.stderr and not nv.exists()


@pytest.mark.parametrize("serial, line", [
    ("B-17", "keeper.serial = B-17"),
    ("x" * 24, "keeper.serial = " + "x" * 24),
    ("x" * 25, "# keeper.serial: the stand file's is no word of at most 24 ASCII characters"),
    ("SN 7", "# keeper.serial: the stand file's is no word of at most 24 ASCII characters"),
    ("B-17 \u00e9", "# keeper.serial: the stand file's is no word of at most 24 ASCII characters"),
])
def test_the_scenario_names_the_block(tumble, tmp_path, serial, line):
    """And the simulation takes it, whatever the name."""
    block = f'[block]\nserial = "{serial}"\nscale_v_per_g = 2.0\nmisalignment_rad = 0.02\n'
    (tmp_path / "my.toml").write_text(HASTY_STAND + block, encoding="utf-8")
    done = tumble("bench", "--stand", tmp_path / "my.toml", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "run/inputs/scenario.txt").read_text()
    assert [one for one in text.splitlines() if "keeper.serial" in one] == [line]
