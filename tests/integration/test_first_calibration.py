"""docs/first-calibration.md: the commands of its parts run one after the other, and print what it shows."""

import json
import math
import re
import shlex
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT
from test_readme import shows

import tumble as tumble_package
from tumble.model import Geometry, built_in
from tumble.solving.uncertainty import HANDS as HANDS_SENTENCE

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

pytestmark = pytest.mark.python

RUNS = 4000

PAGE = (ROOT / "docs/first-calibration.md").read_text(encoding="utf-8")
RECORDING, STAND = (PAGE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
                    for title in ("From a recording to a report", "On a rotary stand"))  # fmt: skip
BLOCKS = re.findall(r"```console\n(.*?)```\n(?:\n```text\n(.*?)```)?", RECORDING, re.DOTALL)
STEPS = [([line[2:] for line in commands.replace("\\\n", "").splitlines()], shown) for commands, shown in BLOCKS]


def test_its_commands_print_what_it_shows(tumble, tmp_path, monkeypatch):
    """What stands behind a block is what its last command prints; notices are for stderr."""
    monkeypatch.setenv("TUMBLE_PROGRAM", "./tools/tumble")  # as the program of a checkout has it
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
    assert [bool(shown) for _, shown in STEPS] == [True] * 4 + [False] and RECORDING.count("```console") == len(STEPS)
    assert max(len(line) for commands, _ in BLOCKS for line in commands.splitlines()) <= 80


FACES, HANDS = EXAMPLES / "hand_laid_faces.toml", EXAMPLES / "hand_laid.toml"
PLACED = ("--schedule", FACES, "--stand", HANDS)
RECORDED = (EXAMPLES / "hand_held_session.csv", "--unit", "m/s^2", "--rate", "102.4", *PLACED)
HANDS_OF_4_MRAD = '[stand]\nsamples = 100\nnoise_v = 0.0143\nlimits = "sigma1"\n' + "".join(
    f"{one}_rad = 4e-3\n" for one in ("axis_tilt", "level", "remount", "angle", "seat")
)


def test_hands_are_over_100_times_worse_than_noise(tumble, tmp_path):
    """As `solve`, reports and a page say of u without a stand file: what 4 mrad an angle make of it."""
    assert "100 times" in HANDS_SENTENCE
    assert HANDS_SENTENCE[1:] in " ".join((ROOT / "docs/method.md").read_text(encoding="utf-8").split())
    run = tmp_path / "run.csv"
    done = tumble("import", *RECORDED, "--repeats", "first", "--out", run)
    assert done.returncode == 0, done.stderr
    (tmp_path / "hands.toml").write_text(HANDS_OF_4_MRAD)
    solving = ("solve", run, "--schedule", FACES, "--estimator", "least_squares", "--limit", "5e-3", "--json")
    alone, hands = (
        json.loads(tumble(*solving, *stand).stdout) for stand in ((), ("--stand", tmp_path / "hands.toml"))
    )
    ratio = np.array(hands["u_K"]) / np.array(alone["scatter_alone"]["u_K"])
    assert ratio[~np.eye(3, dtype=bool)].max() > 100


def test_rests_at_no_position_are_hatched(tumble, tmp_path):
    """Told apart in grey too: seven of the recording's rests, in three channels each; six are placed."""
    pytest.importorskip("matplotlib")
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    words = shlex.split(STEPS[1][0][0])[1:]
    assert tumble(*words, "--plot", "rests.svg", cwd=tmp_path).returncode == 0
    drawn = (tmp_path / "rests.svg").read_text(encoding="utf-8")
    (pattern,) = re.findall(r'<pattern id="(\w+)"', drawn)
    assert drawn.count(f"url(#{pattern})") == 7 * 3


def test_its_result_can_be_compared(tumble, tmp_path):
    """The faces that were laid down again later give the same block, within the uncertainties."""
    for repeats in ("first", "last"):
        run = tmp_path / f"{repeats}.csv"
        order = () if repeats == "first" else ("--order", "any")
        done = tumble("import", *RECORDED, *order, "--repeats", repeats, "--out", run)
        assert done.returncode == 0, done.stderr
        done = tumble("solve", run, *PLACED, "--estimator", "least_squares", "--out", run.with_suffix(".json"))
        assert (done.returncode, done.stderr) == (0, "")
    done = tumble("compare", tmp_path / "first.json", tmp_path / "last.json", "--json")
    assert (done.returncode, json.loads(done.stdout)["verdict"]) == (0, "unchanged")


def hand_laid(forces, rng, runs, seat_rad, drift, noise):
    """Errors of K and U0 (runs, 12), in units of the block, of plain least squares on faces that lie by chance: gravity
    along `forces` (P, 3), turned about both axes across it by seats of their own; linear drift; noise of a mean."""
    block = 9.81 * np.eye(3)
    first = np.roll(forces, 1, axis=1)
    tilts = seat_rad * rng.standard_normal((2, runs, len(forces), 1))
    felt = forces + tilts[0] * first + tilts[1] * np.cross(forces, first)
    felt /= np.linalg.norm(felt, axis=-1, keepdims=True)
    course = np.linspace(-0.5, 0.5, len(forces))[:, None]
    means = felt @ block.T + drift * course * rng.standard_normal((runs, 1, 3))
    means += noise * rng.standard_normal(means.shape)
    design = np.column_stack([forces, np.ones(len(forces))])
    found = np.linalg.pinv(design) @ means  # (runs, 4, 3): columns of K, then U0
    return np.concatenate([(found[:, :3].transpose(0, 2, 1) - block).reshape(runs, 9), found[:, 3]], axis=1)


def stated(tumble, tmp_path, schedule, placed):
    """Standard uncertainties (12,) that a run on this schedule gets; `placed`: mounting, position, force by face."""
    rng, run = np.random.default_rng(1), tmp_path / "run.csv"
    lines = ["mounting,position,ux [m/s^2],uy [m/s^2],uz [m/s^2]"]
    for mounting, position, force in placed:
        rows = 9.81 * np.asarray(force) + 0.02 * rng.standard_normal((600, 3))
        lines += [f"{mounting},{position},{x:.6f},{y:.6f},{z:.6f}" for x, y, z in rows]
    run.write_text("\n".join(lines) + "\n")
    options = ("--schedule", schedule, "--stand", HANDS, "--estimator", "least_squares", "--json")
    result = json.loads(tumble("solve", run, *options).stdout)
    return np.array([*np.ravel(result["u_K"]), *result["u_U0"]])


def test_the_uncertainties_of_hand_laid_faces_are_true(tumble, tmp_path):
    """By simulated sessions: each face tilted anew, by what its stand file says. With two mountings for six faces, as
    on a rotary stand, they are not: faces of one mounting would share their tilt."""
    up_and_down = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    declared = tomllib.loads(HANDS.read_text())["stand"]
    rng = np.random.default_rng(2)
    sizes = declared["seat_rad"], declared["drift_v"], declared["noise_v"] / 600**0.5
    errors = np.abs(hand_laid(np.array(up_and_down), rng, RUNS, *sizes))
    u = stated(tumble, tmp_path, FACES, [(number, 1, force) for number, force in enumerate(up_and_down, 1)])
    within = (errors <= 1.96 * u).mean(axis=0)
    assert np.abs(within - 0.95).max() < 4 * (0.95 * 0.05 / RUNS) ** 0.5, within
    names = [(1, 3), (1, 7), (2, 1), (2, 5), (1, 1), (1, 5)]  # of the built-in schedule, x up to z down
    u = stated(tumble, tmp_path, "six_faces", [(*name, force) for name, force in zip(names, up_and_down)])
    assert (errors <= 1.96 * u).mean(axis=0).min() < 0.5


@pytest.mark.parametrize("seed", range(8))
def test_no_session_of_hand_laid_faces_is_in_dispute(seed):
    """Poses without a turn of a table tell nothing of its axis and angles: nothing is sought, so the core and its
    witness cannot come to differ about it."""
    rng = np.random.default_rng(seed)
    forces = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)] + 3e-3 * rng.standard_normal((6, 3))
    means = 9.81 * forces / np.linalg.norm(forces, axis=1, keepdims=True)
    outputs = np.repeat(means, 100, axis=0) + 0.02 * rng.standard_normal((600, 3))
    columns = {f"u{axis} [m/s^2]": outputs[:, place] for place, axis in enumerate("xyz")}
    run = {"mounting": np.repeat(np.arange(1, 7), 100), "position": np.ones(600, dtype=int), **columns}
    result = tumble_package.solve(run, schedule=FACES, stand=HANDS, estimator="least_squares")
    seen = json.loads(result.to_json())["stand_seen"]
    assert seen["alpha1_rad"] is None and seen["alpha4_rad"] is None and seen["noise_v"] == pytest.approx(0.02, rel=0.1)


@pytest.mark.parametrize("page", ["first-calibration", "files"])
def test_what_a_page_writes_is_no_news_to_git(page):
    """In the folder of the repository, where its commands are given."""
    ignored = (ROOT / ".gitignore").read_text().splitlines()
    text = (ROOT / f"docs/{page}.md").read_text(encoding="utf-8")
    commands = "\n".join(re.findall(r"```console\n(.*?)```", text, re.DOTALL)).replace("\\\n", "")
    written = re.findall(r"(?:--out|--plot|--recipe|>) ([\w./-]+)", commands)
    tops = {one.partition("/")[0] for one in written}
    assert tops and all(f"/{top}" in ignored or f"/{top}/" in ignored for top in tops), tops


# The part about a stand.



def block(language):
    """The one block of the part about a stand of this language, and what it is shown to print, if that follows."""
    return re.search(rf"```{language}\n(.*?)```\n(?:\n```text\n(.*?)```)?", STAND, re.DOTALL).groups()


@pytest.fixture
def first_run(tumble, tmp_path):
    """Where the commands of the part about a stand have been given, one after the other as a reader gives them."""
    folder = tmp_path / "stand"
    folder.mkdir()
    (folder / "examples").symlink_to(ROOT / "examples")
    steps = re.findall(r"```console\n\$ \./tools/tumble ([^\n]*)\n```\n(?:\n```text\n(.*?)```)?", STAND, re.DOTALL)
    assert len(steps) == STAND.count("$ ./tools/tumble ") == 4
    for command, shown in steps:
        done = tumble(*shlex.split(command), cwd=folder)
        assert done.returncode == 0 and (not shown or shows(shown, done.stdout)), command
    return folder


def test_a_stand_leads_to_coefficients(first_run):
    code, shown = block("python")
    done = subprocess.run([sys.executable, "-c", code], cwd=first_run, capture_output=True, text=True, check=True)
    assert done.stdout == shown


def test_the_files_of_a_logger_are_joined(first_run, tumble, tmp_path):
    rows = (first_run / "runs/first/run.csv").read_text().splitlines()[1:]
    for mounting, position in ((m, p) for m in (1, 2, 3) for p in range(1, 5)):
        samples = [row.split(",")[2:5] for row in rows if row.startswith(f"{mounting},{position},")]
        text = "".join(",".join(fields) + "\r\n" for fields in [["ux", "uy", "uz"], *samples])
        (tmp_path / f"{mounting}-{position}.csv").write_text(text, newline="")
    subprocess.run(["sh", "-euc", block("sh")[0]], cwd=tmp_path, check=True)
    bare = tmp_path / "bare.csv"  # without the columns that the logger does not have, such as temperature
    recorded = (first_run / "runs/first/run.csv").read_text().splitlines()
    bare.write_text("".join(",".join(row.split(",")[:5]) + "\n" for row in recorded))
    runs = tmp_path / "runs/joined.csv", bare
    said = [tumble("solve", run, "--schedule", "diagonal").stdout.partition(".csv: ") for run in runs]
    assert said[0][2] == said[1][2] and said[0][0].startswith("PASS at the 12 measured positions only, assuming ")


def test_the_page_says_what_the_axes_feel():
    """Exactly, at every position of the schedule."""
    rows = re.findall(r"^\| (\d) \| (\d+)° \| (.*) \|$", STAND, re.MULTILINE)
    size = {"0": 0.0, "1": 1.0, "√½": math.sqrt(0.5)}
    felt = [[-size[cell[1:]] if cell[0] == "-" else size[cell.lstrip("+")] for cell in row.split(" | ")]
            for _, _, row in rows]  # fmt: skip
    schedule = built_in("diagonal")
    assert [(int(p), float(angle)) for p, angle, _ in rows] == [(p.number, p.angle_deg) for p in schedule.positions[:4]]
    force = Geometry(schedule).force()
    assert np.abs(np.array(felt) - np.hstack([force[:4], force[4:8], force[8:]])).max() < 1e-15
