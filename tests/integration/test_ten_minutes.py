"""The first page of the site, docs/ten-minutes.md: its commands run one after the other, and print what it shows."""

import re
import shlex
import subprocess

import pytest
from conftest import ROOT
from test_readme import shows

pytestmark = pytest.mark.python

PAGE = (ROOT / "docs/ten-minutes.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```console\n(.*?)```\n(?:\n```text\n(.*?)```)?", PAGE, re.DOTALL)
STEPS = [([line[2:] for line in commands.replace("\\\n", "").splitlines()], shown) for commands, shown in BLOCKS]


def test_its_commands_print_what_it_shows(tumble, tmp_path):
    """What stands behind a block is what its last command prints; notices are for stderr."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    for commands, shown in STEPS:
        for command in commands:
            program, *words = shlex.split(command)
            assert program in ("./tools/tumble", "head"), command
            done = (tumble(*words, cwd=tmp_path) if program != "head" else
                    subprocess.run(["head", *words], cwd=tmp_path, capture_output=True, text=True))  # fmt: skip
            assert done.returncode == 0 and "warning" not in done.stderr, command
        assert not shown or shows(shown, done.stdout), command
    assert (tmp_path / "report.html").read_text(encoding="utf-8").count("<svg") >= 1


def test_its_way_is_whole():
    """From the recording to the last step; and the lines fit the page."""
    verbs = [command.split()[1] for commands, _ in STEPS for command in commands if command.startswith("./")]
    assert verbs == ["import", "solve", "apply", "report"]
    assert [bool(shown) for _, shown in STEPS] == [True, True, True, True, False] and PAGE.count("```console") == len(STEPS)
    assert max(len(line) for commands, _ in BLOCKS for line in commands.splitlines()) <= 80
