"""The README: its commands run, and its transcript is what they print."""

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


@pytest.mark.parametrize(("arguments", "shown"), TRANSCRIPTS)
def test_its_transcript_is_real(arguments, shown, tumble):
    assert tumble(*shlex.split(arguments), cwd=ROOT).stdout == shown


def test_its_commands_fit_the_page():
    assert all(line.startswith("$ ./tools/") for block in BLOCKS for line in block.splitlines())
    shown = re.findall(r"```console\n(.*?)```", README, re.DOTALL)
    assert max(len(line) for block in shown for line in block.splitlines()) <= 100


def test_a_transcript_is_there():
    assert len(TRANSCRIPTS) == 1


@pytest.mark.parametrize(
    "page", ["README.md"] + [f"docs/{name}.md" for name in ("files", "gateway", "method", "operations", "real-bus")]
)
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert ((ROOT / page).parent / target).exists(), target
