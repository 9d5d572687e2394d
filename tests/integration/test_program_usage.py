"""The C programs by their command lines: options that are none, and scenarios that are none or lack something."""

import subprocess

import pytest
from simulated_bench import HASTY_STAND, scenario

from tumble.bench import programs


@pytest.mark.parametrize("name, folder", [
    ("tumble-node", "boards/linux"), ("tumble-stand", "boards/linux"), ("tumble-replay", "host/replay"),
])
def test_options_that_are_none(name, folder):
    path = programs.find(name, folder)

    def run(*arguments):
        return subprocess.run([path, *arguments], capture_output=True, text=True, timeout=20)

    text = run("--help").stdout
    assert max(map(len, text.splitlines())) <= 80 and run("-h").stdout == text and "  -h, --help" in text
    for wrong in ("--bogus", "-x"):
        done = run(wrong)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == f"{name}: {wrong}: no such option; see --help\n"


def refusal(name, folder, *arguments):
    """Its one line of complaint."""
    command = [programs.find(name, folder), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stdout) == (2, "")
    return done.stderr


@pytest.mark.parametrize("name", ["tumble-node", "tumble-stand"])
@pytest.mark.parametrize("given, says", [
    (("--log", "xml"), "--log: must be text or json"),
    (("--log", ""), "--log: must be text or json"),
    (("--log-level", "6"), "--log-level: must be error, warning, notice or info"),
    (("--log",), "--log: needs a value"),
])
def test_logs_that_are_none(name, given, says):
    assert refusal(name, "boards/linux", "vcan0", *given) == f"{name}: {says}\n"


@pytest.mark.parametrize("log", [["--log", "json"], ["--log", "text"], ["--log-level", "error"]])
@pytest.mark.parametrize("progress", [["--progress"], ["--progress-fd", "2"]])
def test_one_standard_error_for_two(log, progress):
    """Lines of progress are no events; whoever reads a log of JSON would stumble over each."""
    says = "--progress: cannot share standard error with --log; --progress-fd has another"
    for given in (log + progress, progress + log):
        assert refusal("tumble-node", "boards/linux", "nocan0", *given) == f"tumble-node: {says}\n"
    done = subprocess.run([programs.find("tumble-node", "boards/linux"), "nocan0", "--progress-fd", "1", *log],
                          capture_output=True, text=True, timeout=20)
    assert done.returncode in (2, 77) and done.stderr.startswith("tumble-node: nocan0: ")


@pytest.mark.parametrize("given", ["bogus", "", "on_confirm", "by itself", "Never"])
def test_operators_that_are_none(given):
    says = "tumble-stand: --operator: must be by-itself, on-confirm, never, hands, start or ask\n"
    assert refusal("tumble-stand", "boards/linux", "vcan0", "--operator", given) == says


def test_a_stand_file_is_no_scenario(tmp_path):
    stand = tmp_path / "my.toml"
    stand.write_text(HASTY_STAND)
    says = f"{stand}: looks like a stand file; a scenario file is wanted (docs/real-bus.md)\n"
    none = tmp_path / "none.toml"
    for name in ("tumble-node", "tumble-stand"):
        assert refusal(name, "boards/linux", "vcan0", stand) == f"{name}: {says}"
        assert refusal(name, "boards/linux", "vcan0", none) == f"{name}: {none}: No such file or directory\n"


def test_a_memory_needs_the_name_of_the_block(tmp_path):
    """Before it is made, and before the bus is opened."""
    nv = tmp_path / "nv.bin"
    says = "tumble-node: keeper.serial: is missing: with --nv the scenario must name the block\n"
    for given in ((), (scenario(tmp_path),), (scenario(tmp_path, "other.txt", keeper__commits="no"),)):
        assert refusal("tumble-node", "boards/linux", "vcan0", *given, "--nv", nv) == says
        assert not nv.exists()
    named = scenario(tmp_path, "named.txt", keeper__serial="B-17")
    done = subprocess.run([programs.find("tumble-node", "boards/linux"), "nocan0", named, "--nv", nv],
                          capture_output=True, text=True, timeout=20)
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
