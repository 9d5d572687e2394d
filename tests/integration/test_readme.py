"""The README: its commands run, and its transcripts are what they print."""

import importlib.util
import re
import shlex

import pytest
from conftest import ROOT

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
