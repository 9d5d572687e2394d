"""`tumble import`: a real recording, recordings that fit two ways, recipes, pictures, and options."""

import csv
import itertools
import json
import re
import shlex

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES, ROOT
from documents import paper_stand, valid
from recordings import Habits, recording

from tumble.errors import BadInput
from tumble.importing import match
from tumble.importing.pipeline import Settings, import_recordings
from tumble.model import built_in

pytestmark = pytest.mark.python

HAND_HELD = EXAMPLES / "hand_held_session.csv"
SIX_FACES = ("--schedule", "six_faces", "--order", "any", "--signs=+++", "--unit", "m/s^2", "--rate", "102.4")
SCHEDULE = built_in("paper")
U0 = np.array([0.1, 0.2, 0.3])
QUIET = Habits(rate_hz=50.0, rest_s=(2.0, 3.0), noise_g=1e-4, angle=1e-5, seat=1e-5, bench=0.0, pause=0.0, gap=0.0)
IN_ORDER = list(range(18))


def logged(folder, visits=IN_ORDER, k=NOMINAL_K, seed=1, name="log.csv", habits=QUIET):
    """A recording of these positions, as a file."""
    made = recording(SCHEDULE, visits, np.asarray(k), U0, habits, np.random.default_rng(seed))
    (folder / name).write_text(made.csv())
    return folder / name


def places(run):
    """Of a run file: (mounting, position) of its stretches, in order."""
    with open(run) as stream:
        rows = [(int(row[0]), int(row[1])) for row in csv.reader(stream) if row[0].isdigit()]
    return [place for place, _ in itertools.groupby(rows)]


def expected(visits):
    return [(SCHEDULE.positions[place].mounting, SCHEDULE.positions[place].number) for place in visits]


# A sensor laid on six faces by hand.


def test_the_hand_held_session_leads_by_its_advice_to_a_solution(tumble, refused, tmp_path):
    assert "all of hand_laid have: --schedule hand_laid" in refused("import", HAND_HELD)
    said = refused("import", HAND_HELD, "--schedule", "six_faces", "--order", "any")
    assert "fits 8 ways" in said and "(--signs=+++ --order any)" in said
    said = refused("import", HAND_HELD, *SIX_FACES)
    assert "rests 1 and 7 and 8 are all at 1.3: --repeats first|last|longest selects one" in said
    done = tumble("import", HAND_HELD, *SIX_FACES, "--repeats", "first", "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "")
    assert max(map(len, done.stdout.partition("\nNext:\n")[0].splitlines())) <= 80
    command, of_hands = done.stdout.partition("\nNext:\n")[2].replace("\\\n", "").split("Its limit is a rotary stand's")
    said, advised = shlex.split(command), ("--schedule", "six_faces", "--out", str(tmp_path / "result.json"))
    assert of_hands.endswith("--schedule hand_laid\n")
    assert said == ["tumble", "solve", str(tmp_path / "run.csv"), *advised]
    assert "measured in the order 1.3 1.7 2.1 2.5 1.1 1.5" in " ".join(done.stdout.split())
    assert places(tmp_path / "run.csv") == [(1, 3), (1, 7), (2, 1), (2, 5), (1, 1), (1, 5)]
    solved = tumble("solve", tmp_path / "run.csv", "--schedule", "six_faces", "--json")
    assert (solved.returncode, solved.stderr) == (1, "")
    result = json.loads(solved.stdout)
    # The six sections that others cut out of it by hand gave these (test_six_face_session).
    assert np.diag(result["K"]) == pytest.approx([9.776727847, 9.833534627, 10.038596053], abs=1e-3)
    assert result["unit"] == "m/s^2" and 5e-4 < result["verification"]["max_abs_delta_g_g"] < 2e-3


def test_a_refusal_begins_with_what_it_took(tumble, tmp_path):
    """What the file says, what an option says, and what nobody said."""

    def took(*words):
        first = tumble("import", *words).stderr.splitlines()[0]
        assert first.startswith("took: ")
        return first.removeprefix("took: ").split("; ")

    assert took(HAND_HELD) == [
        "no clock, lengths are in samples (--rate HZ gives seconds)",
        "outputs acc_x, acc_y, acc_z in V, assumed because no unit is given (1 g is 9.882 of it, which looks like"
        " m/s^2: --unit m/s^2)",
        "schedule paper, the default (--schedule)",
        "no labels of positions",
        "13 rests, noise 0.0137 0.0116 0.0165 V (--still, --drift)",
        "one source",
        "column 'n_samples' counts samples: not read",
    ]
    said = took(HAND_HELD, *SIX_FACES)
    assert said[:3] == ["time by --rate 102.4 Hz", "outputs acc_x, acc_y, acc_z in m/s^2", "schedule six_faces"]
    header, *rows = HAND_HELD.read_text().splitlines()
    lines = [f"Timestamp,{header}", *(f"{10 * number},{row}" for number, row in enumerate(rows))]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    own = ("--schedule", "six_faces", "--unit", "m/s^2")
    guessed = "clock: 'Timestamp' names no unit, its steps of 10 are read as ms (--time-unit)"
    for options, is_guessed in (((), True), (("--time-unit", "ms"), False)):
        said = took(tmp_path / "log.csv", *own, *options)
        assert said[0] == "time of column 'Timestamp' in ms, 100 Hz" and (guessed in said) == is_guessed


def test_a_refusal_of_labelled_rows_says_that_it_read_labels(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("Pos,Ux,Uy,Uz\n" + "".join(f"{place},0.{place},0.2,0.3\n" for place in (1, 2, 3, 4)))
    with pytest.raises(BadInput) as refusal:
        import_recordings([str(log)], SCHEDULE, Settings(schedule="paper"))
    assert refusal.value.assumed == (
        "no clock, lengths are in samples (--rate HZ gives seconds)",
        "outputs Ux, Uy, Uz in V, assumed because no unit is given (--unit)",
        "schedule paper",
        "labels 'Pos' (--columns)",
        "0 rests, noise 0 0 0 V (--still, --drift)",
        "one source",
    )


@pytest.mark.parametrize("which", ["last", "longest"])
def test_other_rests_of_the_hand_held_session_give_nearly_the_same(tumble, tmp_path, which):
    done = tumble("import", HAND_HELD, *SIX_FACES, "--repeats", which, "--out", tmp_path / "run.csv", "--json")
    document = valid(done.stdout, "import")
    taken = [number for number, rest in enumerate(document["rests"], 1) if rest["state"] == "taken"]
    assert taken == ([2, 4, 6, 8, 10, 13] if which == "last" else [1, 2, 3, 4, 5, 6])
    assert np.diag(document["K"]) == pytest.approx([9.7767, 9.8335, 10.0386], abs=0.01)


# Recordings that fit two ways: refused with both, and the option that is named decides.


def test_reversed_or_negative(tumble, refused, tmp_path):
    """Turned the other way round, a block looks like one whose x channel is upside down."""
    back = [0, *range(7, 0, -1), 8, 9, *range(16, 9, -1), 17]
    file = logged(tmp_path, back)
    said = refused("import", file)
    assert "(1) in the schedule's order, K negative in x (--signs=-++)" in said
    assert "(2) in another order, K positive (--signs=+++ --order any)" in said
    done = tumble("import", file, "--signs=+++", "--order", "any", "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and places(tmp_path / "run.csv")[1:8] == expected(back[1:8])
    done = tumble("import", file, "--signs=-++", "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and places(tmp_path / "run.csv") == expected(IN_ORDER)


def test_mountings_exchanged_or_channels(tumble, refused, tmp_path):
    visits = [*range(17, 8, -1), *range(8, -1, -1)]
    file = logged(tmp_path, visits)
    said = refused("import", file, "--signs=+++")
    assert "channels z and y exchanged" in said and "(2) in another order, K positive (--order any)" in said
    assert "(--columns ux=<that of ux>,uy=<that of uz>,uz=<that of uy>)" in said
    done = tumble("import", file, "--signs=+++", "--order", "any", "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and places(tmp_path / "run.csv") == expected(visits)
    exchanged = ("--columns", "ux=Ax,uy=Az,uz=Ay")
    done = tumble("import", file, "--signs=+++", *exchanged, "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and places(tmp_path / "run.csv") == expected(IN_ORDER)


def test_the_stand_file_says_the_signs(tumble, refused, tmp_path):
    file = logged(tmp_path, k=-NOMINAL_K)
    assert "K negative in x, y, z (--signs=---)" in refused("import", file)
    done = tumble("import", file, "--stand", paper_stand(tmp_path, scale_v_per_g=-2.0), "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and places(tmp_path / "run.csv") == expected(IN_ORDER)
    assert "- signs of K: ---, from scale_v_per_g in stand.toml" in done.stdout
    assert "assumed positive" not in done.stdout


def test_signs_that_are_said_are_not_the_stand_file_s(tumble, tmp_path):
    """The report said that they were its own."""
    stand = paper_stand(tmp_path, scale_v_per_g=-2.0)
    done = tumble("import", logged(tmp_path), "--stand", stand, "--signs=+++", "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and places(tmp_path / "run.csv") == expected(IN_ORDER)
    assert "scale_v_per_g" not in done.stdout and "- signs of K: +++, as given" in done.stdout


def test_a_stand_file_without_a_block_keeps_the_signs_of_the_recipe(tumble, refused, tmp_path):
    stand = paper_stand(tmp_path)
    stand.write_text(stand.read_text().split("[block]")[0])
    file, recipe = logged(tmp_path, k=-NOMINAL_K), tmp_path / "recipe.toml"
    recipe.write_text('[import]\nsigns = "---"\n')
    done = tumble("import", file, "--stand", stand, "--recipe", recipe, "--out", tmp_path / "run.csv")
    assert done.returncode == 0, done.stderr
    assert "- signs of K: stand.toml has no [block], and tells none" in done.stdout
    assert "K negative in x, y, z (--signs=---)" in refused("import", file, "--stand", stand)


def test_positive_signs_are_told(tumble, tmp_path):
    done = tumble("import", logged(tmp_path), "--json")
    document = valid(done.stdout, "import")
    assert any(note.startswith("signs of K: not given, assumed positive") for note in document["assumed"])
    assert (document["signs"], document["order"], document["missing"]) == (None, "schedule", [])
    placed = [(rest["mounting"], rest["position"]) for rest in document["rests"] if rest["position"]]
    assert placed == expected(IN_ORDER)


# Rests in doubt.


def test_a_position_measured_twice(tumble, refused, tmp_path):
    file = logged(tmp_path, [*range(4), 3, *range(4, 18)], habits=Habits(**{**vars(QUIET), "angle": 2e-3}), seed=3)
    # The table was not turned between: that second visit differs by nothing and is joined.
    done = tumble("import", file, "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and "joined to the next" in done.stdout
    text = file.read_text().splitlines()
    moved = shifted(text, tumble, file)
    (tmp_path / "moved.csv").write_text("\n".join(moved) + "\n")
    said = refused("import", tmp_path / "moved.csv")
    found = re.search(r"rests (\d+) and (\d+) are all at 1.4: --repeats first\|last\|longest selects one", said)
    assert found, said
    for options in (("--repeats", "last"), ("--leave-out", found[2]), ("--repeats", "first")):
        done = tumble("import", tmp_path / "moved.csv", *options, "--out", tmp_path / "run.csv")
        assert done.returncode == 0 and places(tmp_path / "run.csv") == expected(IN_ORDER), options


def shifted(text, tumble, file):
    """The recording with its second rest of position 1.4 a milliradian or so off the first."""
    rests = json.loads(tumble("import", file, "--json").stdout)["rests"]
    second = [rest for rest in rests if (rest["mounting"], rest["position"]) == (1, 4)][1]
    for row in range(second["first_row"] - 60, second["last_row"] + 60):
        t, x, y, z = map(float, text[row].split(","))
        text[row] = f"{t:.6f},{x + 2e-3:.7f},{y:.7f},{z - 2e-3:.7f}"
    return text


def test_labelled_rows_that_are_never_at_rest_are_refused(refused, tmp_path):
    rows = [
        f"{i / 100:.2f},{i // 500 + 1},{np.sin(i / 33):.6f},{np.cos(i / 43):.6f},{np.sin(i / 20):.6f}"
        for i in range(4000)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["time,position,ux,uy,uz", *rows]) + "\n")
    assert "no group of rows with the same labels is at rest: see --still" in refused("import", tmp_path / "log.csv")


def test_a_position_that_was_missed_is_named(tumble, tmp_path):
    file = logged(tmp_path, [place for place in IN_ORDER if place != 4])
    done = tumble("import", file, "--out", tmp_path / "run.csv")
    assert done.returncode == 0 and "- no rest at 1.5" in done.stdout
    assert places(tmp_path / "run.csv") == expected([place for place in IN_ORDER if place != 4])


def test_a_rest_far_off_is_in_doubt_until_somebody_says(tumble, refused, tmp_path):
    text = logged(tmp_path).read_text().splitlines()
    rests = json.loads(tumble("import", tmp_path / "log.csv", "--json").stdout)["rests"]
    off = next(number for number, rest in enumerate(rests) if (rest["mounting"], rest["position"]) == (1, 6))
    for row in range(rests[off]["first_row"] - 60, rests[off]["last_row"] + 60):
        t, x, y, z = map(float, text[row].split(","))
        text[row] = f"{t:.6f},{x + 0.04:.7f},{y:.7f},{z - 0.04:.7f}"
    (tmp_path / "off.csv").write_text("\n".join(text) + "\n")
    said = refused("import", tmp_path / "off.csv")
    assert re.search(rf"rest {off + 1} is [0-9.]+ mrad off 1.6, far more than the other rests", said), said
    done = tumble("import", tmp_path / "off.csv", "--leave-out", off + 1)
    assert done.returncode == 0 and "- no rest at 1.6" in done.stdout and "left out by --leave-out" in done.stdout
    done = tumble("import", tmp_path / "off.csv", "--take", off + 1)
    assert done.returncode == 0 and "no rest at" not in done.stdout


# Recipes.


def test_a_recipe_is_written_once_and_then_followed(tumble, refused, tmp_path):
    told = (*SIX_FACES, "--repeats", "longest", "--still", "3", "--columns", "ux=acc_x,uy=acc_y,uz=acc_z")
    recipe = ("--recipe", tmp_path / "bench.toml")
    first = tumble("import", HAND_HELD, *told, *recipe, "--out", tmp_path / "first.csv")
    written = (tmp_path / "bench.toml").read_bytes()
    again = tumble("import", HAND_HELD, *recipe, "--out", tmp_path / "again.csv")
    assert first.returncode == again.returncode == 0, again.stderr
    assert (tmp_path / "first.csv").read_bytes() == (tmp_path / "again.csv").read_bytes()
    assert (tmp_path / "bench.toml").read_bytes() == written
    said = again.stdout.replace("- recipe bench.toml followed\n", "").replace("again.csv", "first.csv")
    assert said == first.stdout
    done = tumble("import", HAND_HELD, *recipe, "--repeats", "last", "--out", tmp_path / "last.csv")
    assert done.returncode == 0 and (tmp_path / "last.csv").read_bytes() != (tmp_path / "first.csv").read_bytes()
    (tmp_path / "bench.toml").write_text("[import]\nordre = 'any'\n")
    assert "bench.toml: row 2: unknown key 'ordre' in [import]" in refused("import", HAND_HELD, *recipe)


# Pictures.


def test_without_matplotlib_a_picture_is_refused_in_a_line(tumble, without_matplotlib, tmp_path):
    done = tumble("import", HAND_HELD, "--plot", tmp_path / "x.png", **without_matplotlib)
    assert (done.returncode, done.stdout) == (77, "")
    assert done.stderr == "tumble: --plot needs matplotlib: tools/setup plot\n"


@pytest.mark.parametrize(("suffix", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")])
def test_a_picture_is_drawn(tumble, tmp_path, suffix, begins):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    file = tmp_path / f"picture.{suffix}"
    done = tumble("import", logged(tmp_path), "--plot", file)
    assert done.returncode == 0, done.stderr
    assert file.read_bytes().startswith(begins)


def test_other_pictures_are_refused(refused, tmp_path):
    assert "does not end in .png, .svg or .pdf" in refused("import", HAND_HELD, "--plot", tmp_path / "x.gif")


# Options.


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--signs=++",), "--signs: '++' is not three of + and -"),
        (("--leave-out", "x"), "--leave-out: 'x' is not a whole number from 1 to 1000000"),
        (("--mountings", "A"), "--mountings: 'A' is not NAME=NUMBER"),
        (("--still", "0"), "--still: '0' is not a number above 0"),
        (("--tolerance", "90"), "--tolerance: '90' is not a number above 0, at most 45"),
        (("--columns", "u=Ax"), "position, angle, number, temperature, once each"),
        (("--columns", "time=T"), "no column 'T' (for time) among 'n_samples,acc_x,acc_y,acc_z'"),
        (("--window", "4000"), "0 rests do not show scale and bias of every channel"),
    ],
)
def test_options_that_cannot_be_followed(refused, options, said):
    assert said in refused("import", HAND_HELD, *options)


def test_inputs_are_not_overwritten(refused, tmp_path):
    file = logged(tmp_path)
    assert "is an input of this command" in refused("import", file, "--out", file)


# The longest way through rests and positions, by brute force.


def brute(nearest, of_position):
    """The most positions that rests can have, in the order of both, and every way to that."""
    ways = {}
    for choice in itertools.product(*([-1, *np.flatnonzero(of_position == one)] for one in nearest)):
        kept = [place for place in choice if place >= 0]
        if all(one < other for one, other in itertools.pairwise(kept)):
            ways.setdefault(len(kept), []).append(choice)
    most = max(ways)
    return most, ways[most]


def test_the_order_is_the_best_and_says_where_another_is_as_good():
    rng = np.random.default_rng(7)
    for _ in range(300):
        of_position = rng.integers(0, 4, rng.integers(2, 7))
        nearest = rng.integers(-1, 4, rng.integers(1, 7))
        found = match.assign(match.SCHEDULE, nearest, np.zeros(len(nearest)), of_position, SCHEDULE)
        most, ways = brute(nearest, of_position)
        assert found.matched == most and tuple(found.positions) in [tuple(map(int, way)) for way in ways]
        for rest, place in enumerate(found.positions):
            if place >= 0:
                could_be = sorted({int(way[rest]) for way in ways} - {-1})
                assert sorted(found.ambiguous.get(rest, (place,))) == could_be


# The rate that somebody says.

FIRST = (*SIX_FACES, "--repeats", "first")


def at_rate(rate, *words):
    return [rate if word == "102.4" else word for word in (*words, *FIRST)]


@pytest.mark.parametrize(("rate", "is_odd"), [("102.4", False), ("0.2", True)])
def test_a_rate_that_makes_rests_too_long_is_doubted(rate, is_odd, tumble):
    text = " ".join(tumble("import", *at_rate(rate, HAND_HELD)).stdout.split())
    assert ("if that is not so, the rate is wrong" in text) == is_odd


@pytest.mark.parametrize("rate", ["600", "1024"])
def test_a_rate_that_hides_the_rests_is_doubted(rate, refused):
    assert refused("import", *at_rate(rate, HAND_HELD)).endswith(f"; is --rate {rate} right?\n")


@pytest.mark.parametrize(("clock", "rate", "is_odd"), [
    (lambda row: f"{row / 102.4:.6f}", "102.4", False), (lambda row: f"{row / 102.4:.6f}", "200", True),
    (lambda row: str(row * 1000 // 1024), "102.4", False), (lambda row: "00:00:00", "102.4", False),
    (lambda row: "lost", "102.4", False), (lambda row: f"{int(row / 102.4)}", "200", True),
])  # fmt: skip
def test_a_clock_that_contradicts_the_rate_is_told(clock, rate, is_odd, tumble, tmp_path):
    """Not one that cannot be read: it is why the rate is said."""
    header, *rows = HAND_HELD.read_text().splitlines()
    lines = [f"time s,{header}", *(f"{clock(number)},{row}" for number, row in enumerate(rows))]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    done = tumble("import", *at_rate(rate, tmp_path / "log.csv"), "--columns", "time=time s")
    assert done.returncode == 0, done.stderr
    text = " ".join(done.stdout.split())
    assert bool(re.search(r"advances at 10\d(\.\d+)? Hz: which is right\?", text)) == is_odd


# The page.


def test_the_page_shows_what_a_refusal_prints(tumble):
    page = (ROOT / "docs/first-calibration.md").read_text(encoding="utf-8").partition("\n## Import a logger")[2]
    step = re.search(r"```console\n\$ \./tools/tumble ([^\n]*)\n```\n\n```text\n(.*?)```", page, re.DOTALL)
    command, shown = step.groups()
    assert tumble(*shlex.split(command), cwd=ROOT, TUMBLE_PROGRAM="./tools/tumble").stderr == shown


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--take", "99"), "--leave-out, --take: no rest 99, there are 13"),
        (("--take", "3", "--leave-out", "3"), "rest 3 is named by both --leave-out and --take"),
        (("--out", "same", "--recipe", "same"), "--out, --plot and --recipe: two of them name the same file"),
    ],
)
def test_what_cannot_be_meant_is_refused(options, said, refused, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said in refused("import", HAND_HELD, *SIX_FACES, "--repeats", "first", *options)
    assert not list(tmp_path.iterdir())
