"""The first page of the site, docs/ten-minutes.md: its commands run one after the other, and print what it shows."""

import json
import re
import shlex
import subprocess

import numpy as np
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


def test_its_way_is_whole():
    """From the recording to the last step; and the lines fit the page."""
    verbs = [command.split()[1] for commands, _ in STEPS for command in commands if command.startswith("./")]
    assert verbs == ["import", "solve", "apply", "report"]
    assert [bool(shown) for _, shown in STEPS] == [True] * 4 + [False] and PAGE.count("```console") == len(STEPS)
    assert max(len(line) for commands, _ in BLOCKS for line in commands.splitlines()) <= 80


HANDS = "[stand]\nsamples = 100\nnoise_v = 0.0143\n" + "".join(
    f"{one}_rad = 4e-3\n" for one in ("axis_tilt", "level", "remount", "angle", "seat")
)


def test_hands_are_over_100_times_worse_than_noise(tumble, tmp_path):
    """As its text, `solve` and reports say of u without a stand file: what 4 mrad an angle make of it."""
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    (tmp_path / "hands.toml").write_text(HANDS + 'limits = "sigma1"\n')
    words, solving = (shlex.split(STEPS[step][0][0])[1:] for step in (1, 2))
    assert tumble(*words, cwd=tmp_path).returncode == 0
    alone, hands = (
        json.loads(tumble(*solving, "--json", *stand, cwd=tmp_path).stdout)
        for stand in ((), ("--stand", "hands.toml"))
    )
    ratio = np.array(hands["u_K"]) / np.array(alone["scatter_alone"]["u_K"])
    across = ratio[~np.eye(3, dtype=bool)]
    assert f"{across.min():.0f} to {across.max():.0f} times larger" in " ".join(PAGE.split())
    assert across.max() > 100


def test_rests_at_no_position_are_hatched(tumble, tmp_path):
    """Told apart in grey too: seven of the recording's rests, in three channels each; six are placed."""
    pytest.importorskip("matplotlib")
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    words = shlex.split(STEPS[1][0][0])[1:]
    assert tumble(*words, "--plot", "rests.svg", cwd=tmp_path).returncode == 0
    drawn = (tmp_path / "rests.svg").read_text(encoding="utf-8")
    (pattern,) = re.findall(r'<pattern id="(\w+)"', drawn)
    assert drawn.count(f"url(#{pattern})") == 7 * 3
