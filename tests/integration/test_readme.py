"""The README and the tutorial: their commands run, and their transcripts are what they print."""

import re
import shlex

import pytest
from conftest import ROOT

pytestmark = pytest.mark.python

README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = [block.replace("\\\n", "") for block in re.findall(r"```console\n(.*?)```", README, re.DOTALL)]
COMMANDS = [line[2:] for block in BLOCKS for line in block.splitlines()]
TRANSCRIPTS = re.findall(r"```console\n\$ \./tools/tumble ([^\n]*)\n```\n\n```text\n(.*?)```", README, re.DOTALL)


def test_the_two_commands_are_there():
    assert COMMANDS[:2] == ["./tools/tumble solve examples/paper_stand.csv", "./tools/test"]


@pytest.fixture(scope="module")
def desk(tmp_path_factory):
    """Where the commands run, one after the other: elsewhere, for a bench leaves its run folder."""
    folder = tmp_path_factory.mktemp("desk")
    (folder / "examples").symlink_to(ROOT / "examples")
    return folder


@pytest.mark.parametrize("command", [line for line in COMMANDS if line.startswith("./tools/tumble ")])
def test_its_commands_run(command, tumble, desk):
    done = tumble(*shlex.split(command)[1:], cwd=desk)
    assert done.returncode == 0 and (not done.stderr or " bench " in command or " validate " in command)
    assert "warning" not in done.stderr


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
    assert all(line.startswith("$ ./tools/") for block in BLOCKS for line in block.splitlines())
    shown = re.findall(r"```console\n(.*?)```", README, re.DOTALL)
    assert max(len(line) for block in shown for line in block.splitlines()) <= 100


def test_a_transcript_is_there():
    assert len(TRANSCRIPTS) == 1


@pytest.mark.parametrize(
    "page", ["README.md"] + [f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")]
)
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((ROOT / page).parent / target).exists(), target


def test_the_tutorial_leads_to_coefficients(tumble, tmp_path):
    """Its commands, one after the other as a reader gives them."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    text = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
    steps = re.findall(r"```console\n\$ \./tools/tumble ([^\n]*)\n```\n(?:\n```text\n(.*?)```)?", text, re.DOTALL)
    assert len(steps) == text.count("$ ./tools/tumble ") == 4
    for command, shown in steps:
        done = tumble(*shlex.split(command), cwd=tmp_path)
        assert done.returncode == 0 and (not shown or shows(shown, done.stdout)), command
