"""The output on a terminal: the same content as the plain text, at 80 columns, colours only where they are wanted."""

import os
import pty
import re
import struct
import subprocess
import sys
import termios
from fcntl import ioctl

import pytest
from conftest import EXAMPLES

from tumble.cli.commands import COMMANDS
from tumble.messages import signed

pytestmark = pytest.mark.python

SOLVE = [sys.executable, "-m", "tumble", "solve", "paper_stand.csv", "--unit", "V", "--stand", "paper_stand.toml"]


def on_terminal(command, columns=80, **environment):
    """What a command prints on a pseudo-terminal."""
    ours, theirs = pty.openpty()
    ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    clean = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "COLUMNS", "FORCE_COLOR")}
    child = subprocess.Popen(
        command,
        stdout=theirs,
        stderr=theirs,
        cwd=EXAMPLES,
        env={**clean, "TERM": "xterm", "LC_ALL": "C.UTF-8", **environment},
    )
    os.close(theirs)
    output = b""
    while True:
        try:
            chunk = os.read(ours, 65536)
        except OSError:  # the other end is closed
            break
        if not chunk:
            break
        output += chunk
    os.close(ours)
    assert child.wait(timeout=60) == 0
    return output.decode().replace("\r\n", "\n")


def without_styles(text):
    return re.sub(r"\x1b\[[0-9;]*m", "", text)


def words(text):
    """The content: all that is not drawing."""
    return re.sub(r"[#|\u2500-\u259f\s]+", " ", without_styles(text)).split()


def test_the_same_content_as_plain_text():
    command = [*SOLVE, "--details"]
    plain = subprocess.run(command, cwd=EXAMPLES, capture_output=True, text=True, check=True).stdout
    shown = on_terminal(command)
    for ours, theirs in {"\u00b1": "+-", "\u00b5": "u"}.items():
        assert ours in shown and ours not in plain
        shown = shown.replace(ours, theirs)
    assert words(shown) == words(plain)
    assert max(map(len, without_styles(shown).splitlines())) <= 80


@pytest.mark.parametrize(("environment", "coloured"), [({}, True), ({"NO_COLOR": "1"}, False)])
def test_colours(environment, coloured):
    shown = on_terminal(SOLVE, **environment)
    colours = re.findall(r"\x1b\[(?:\d;)*3[1-7]m", shown)
    assert bool(colours) == coloured


def test_the_page_is_short_and_its_details_are_asked_for(tumble):
    """The verdict first, twelve rows, a line for each check, on one screen of 40 lines."""
    inclined = ("inclined_stand.csv", "--schedule", "inclined", "--stand", "inclined_stand.toml")
    for words in (SOLVE[4:], inclined, ["paper_stand.csv"]):
        short = tumble("solve", *words, cwd=EXAMPLES).stdout
        lines = short.splitlines()
        assert lines[0].startswith("PASS") and len(lines) <= 40 and max(map(len, lines)) <= 80
        assert [line for line in lines if line.startswith(("K_", "U0_"))] == lines[lines.index("") + 4 :][:12]
        for check in ("Gravity check: ", "Closure: ", "numpy agrees; --details "):
            assert sum(line.startswith(check) for line in lines) == 1, check
        whole = tumble("solve", *words, "--details", cwd=EXAMPLES).stdout
        assert "\n   1.1  fit " in whole and "\nResiduals, rms: " in whole and "\nStand seen: " in whole
        assert whole.partition("\n\n")[0] == short.partition("\n\n")[0]


def test_a_terminal_without_unicode_gets_ascii():
    assert without_styles(on_terminal(SOLVE, PYTHONIOENCODING="ascii")).isascii()


def test_a_plan_has_the_signs_too(tumble):
    plan = ["plan", "schedule", "--norm", "2e-5", "--angles", "45", "--mountings", "2", "--inclination", "0"]
    shown = on_terminal([*SOLVE[:3], *plan])
    assert re.search(r"Worst u\(\|a\|\): [\d.]+ \u00b5g", shown) and re.search(r"table at [^\n]*\d\u00b0", shown)
    piped = tumble(*plan).stdout
    assert re.search(r"[\d.]+ ug", piped) and "\u00b5" not in piped and "\u00b0" not in piped


@pytest.mark.parametrize(("plain", "shown"), {
    "x 2.0 +- 2.2e-05      +6.6e-03 +- 8e-06  xy": "x 2.0 \u00b1 2.2e-05       +6.6e-03 \u00b1 8e-06   xy",
    "27.4 urad, 8.37 ug, 3 uV": "27.4 \u00b5rad, 8.37 \u00b5g, 3 \u00b5V",
    "20 to 21.5 deg C; table at 0, 45 deg": "20 to 21.5 \u00b0C; table at 0, 45\u00b0",
    "tumble: /ug/a+-1/12 deg.csv: --signs=+-+ --unit ug": "tumble: /ug/a+-1/12 deg.csv: --signs=+-+ --unit ug",
}.items())  # fmt: skip
def test_signs_of_quantities(plain, shown):
    """Columns stay where they are."""
    assert signed(plain) == shown


def test_a_narrow_terminal_gets_all_of_it():
    assert "K_xx" in on_terminal(SOLVE, columns=40)


def test_the_truth_fits_beside_the_coefficients(tmp_path):
    bench = [sys.executable, "-m", "tumble", "bench", "--out", str(tmp_path / "run")]
    shown = without_styles(on_terminal(bench))
    # The progress line before it is cut to the terminal's width where time is short.
    result = shown.split("run folder:")[1]
    assert "\u2026" not in result
    assert max(len(line) for line in result.splitlines()[1:]) <= 80
    assert "truth" in shown and "error/u" in shown


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_the_widest_table_fits_eighty_columns(estimator, tumble, tmp_path):
    """Of the bench, which knows the truth: large errors and uncertainties."""
    stand = tmp_path / "stand.toml"
    text = (EXAMPLES / "lab_stand.toml").read_text().replace("remount_rad = 2e-3", "remount_rad = 2e-2")
    stand.write_text(text.replace("noise_v = 5e-4", "noise_v = 5e-3"))
    done = tumble("bench", "--stand", stand, "--estimator", estimator, "--limit", "1", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    assert max(map(len, done.stdout.splitlines())) <= 80


@pytest.mark.parametrize(
    "command",
    [*COMMANDS, "fixture check", "store dump"]
    + [f"draw {subject}" for subject in ("stand", "mountings", "angles", "states", "wiring")]
    + [f"plan {subject}" for subject in ("budget", "require", "optimize", "schedule", "validate", "paper")],
)
def test_help_fits_eighty_columns(command, tumble):
    done = tumble(*command.split(), "--help", COLUMNS="80")
    assert done.returncode == 0 and max(map(len, done.stdout.splitlines())) <= 80
