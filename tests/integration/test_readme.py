"""The README and the tutorial: their commands run, and their transcripts are what they print."""

import importlib.util
import math
import re
import shlex
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT

from tumble.model import Geometry, built_in

pytestmark = pytest.mark.python

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = [block.replace("\\\n", "") for block in re.findall(r"```console\n(.*?)```", README, re.DOTALL)]
TRANSCRIPTS = re.findall(r"```console\n\$ \./tools/tumble ([^\n]*)\n```\n\n```text\n(.*?)```", README, re.DOTALL)
UNIT = "tumble: warning: the run file names no unit: outputs taken for volts (--unit V, or ux [V] in its header)\n"


def test_the_two_commands_are_there():
    installed = README.partition("\n## Install\n")[2]
    assert re.search(r"```console\n(.*?)```", installed, re.DOTALL)[1] == (
        "$ ./tools/tumble solve examples/paper_stand.csv\n$ ./tools/test\n")


@pytest.fixture
def desk(tmp_path):
    """Where the commands of a block run, one after the other: elsewhere, for they leave files."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    return tmp_path


@pytest.mark.parametrize("block", [block for block in BLOCKS if "./tools/tumble " in block])
def test_its_commands_run(block, tumble, desk):
    """But for user-mode Linux, which tools/trial and the tests on real buses start. Where WeasyPrint is missing, the
    report is HTML."""
    endings = [".pdf", ".pdf" if importlib.util.find_spec("weasyprint") else ".html"]
    for command in re.findall(r"^\$ \./tools/tumble (?!uml )(.*)$", block, re.MULTILINE):
        done = tumble(*shlex.split(command.replace(*endings)), cwd=desk)
        errors = done.stderr.replace(UNIT, "") if "--unit" not in command else done.stderr
        told = command.startswith(("bench ", "plan validate ")) or errors.startswith("tumble: notice: ")
        assert done.returncode == 0 and (not errors or told), command
        assert "warning" not in errors


def shows(shown, printed):
    """Is this what was printed, where a line of three dots stands for one line or more that are left out?"""
    parts = [re.escape(part) for part in re.split(r"^\.\.\.\n", shown, flags=re.MULTILINE)]
    return re.fullmatch(r"(?:[^\n]*\n)+".join(parts), printed) is not None


@pytest.mark.parametrize(("arguments", "shown"), TRANSCRIPTS)
def test_its_transcript_is_real(arguments, shown, tumble):
    assert shows(shown, tumble(*shlex.split(arguments), cwd=ROOT).stdout)


@pytest.mark.parametrize("shown", ["a\n...\nc\nd\n", "a\n...\nb\nc\n", "...\nb\n", "a.*\n", "a\nb\n"])
def test_another_transcript_is_noticed(shown):
    """The canary; and what may be left out."""
    assert shows("a\n...\nc\n", "a\nb\nc\n") and shows("a\n...\n", "a\nb\nc\n")
    assert not shows(shown, "a\nb\nc\n")


def test_its_commands_fit_the_page():
    assert all(line.startswith("$ ") for block in BLOCKS for line in block.splitlines())
    shown = re.findall(r"```console\n(.*?)```", README, re.DOTALL)
    assert max(len(line) for block in shown for line in block.splitlines()) <= 100


def test_a_transcript_is_there():
    assert len(TRANSCRIPTS) == 1


@pytest.mark.parametrize("page", ["README.md"] + [f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")])
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((ROOT / page).parent / target).exists(), target


TUTORIAL = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")


def block(language):
    """The tutorial's one block of this language, and what it is shown to print, if that follows."""
    return re.search(rf"```{language}\n(.*?)```\n(?:\n```text\n(.*?)```)?", TUTORIAL, re.DOTALL).groups()


@pytest.fixture
def first_run(tumble, tmp_path):
    """Where the tutorial's commands have been given, one after the other as a reader gives them."""
    folder = tmp_path / "tutorial"
    folder.mkdir()
    (folder / "examples").symlink_to(ROOT / "examples")
    steps = re.findall(r"```console\n\$ \./tools/tumble ([^\n]*)\n```\n(?:\n```text\n(.*?)```)?", TUTORIAL, re.DOTALL)
    assert len(steps) == TUTORIAL.count("$ ./tools/tumble ") == 4
    for command, shown in steps:
        done = tumble(*shlex.split(command), cwd=folder)
        assert done.returncode == 0 and (not shown or shows(shown, done.stdout)), command
    return folder


def test_the_tutorial_leads_to_coefficients(first_run):
    code, shown = block("python")
    done = subprocess.run([sys.executable, "-c", code], cwd=first_run, capture_output=True, text=True, check=True)
    assert done.stdout == shown


def test_the_tutorial_joins_the_files_of_a_logger(first_run, tumble, tmp_path):
    rows = (first_run / "runs/first/run.csv").read_text().splitlines()[1:]
    for mounting, position in ((m, p) for m in (1, 2) for p in range(1, 10)):
        samples = [row.split(",")[2:5] for row in rows if row.startswith(f"{mounting},{position},")]
        text = "".join(",".join(fields) + "\r\n" for fields in [["ux", "uy", "uz"], *samples])
        (tmp_path / f"{mounting}-{position}.csv").write_text(text, newline="")
    subprocess.run(["sh", "-euc", block("sh")[0]], cwd=tmp_path, check=True)
    bare = tmp_path / "bare.csv"  # without the columns that the logger does not have, such as temperature
    recorded = (first_run / "runs/first/run.csv").read_text().splitlines()
    bare.write_text("".join(",".join(row.split(",")[:5]) + "\n" for row in recorded))
    said = [tumble("solve", run).stdout.splitlines()[3:] for run in (tmp_path / "runs/joined.csv", bare)]
    assert said[0] == said[1] and "PASS at the 18 measured positions only, assuming" in "\n".join(said[0])


def test_the_tutorial_says_what_the_axes_feel():
    """Exactly, at every position of the schedule."""
    rows = re.findall(r"^\| (\d) \| (\d+)° \| (.*) \|$", TUTORIAL, re.MULTILINE)
    size = {"0": 0.0, "1": 1.0, "√½": math.sqrt(0.5)}
    felt = [[-size[cell[1:]] if cell[0] == "-" else size[cell.lstrip("+")] for cell in row.split(" | ")]
            for _, _, row in rows]  # fmt: skip
    schedule = built_in("paper")
    assert [(int(p), float(angle)) for p, angle, _ in rows] == [(p.number, p.angle_deg) for p in schedule.positions[:9]]
    force = Geometry(schedule).force()
    assert np.abs(np.array(felt) - np.hstack([force[:9], force[9:]])).max() < 1e-15
