"""What people do to a run by mistake, at random: rows exchanged, moved, repeated, scaled, dropped, channels and signs,
positions off by degrees, and several of these at once. A result, or exit code 2 with one line; nothing else."""

import contextlib
import io
import random
import re
import zlib

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import valid

import tumble as package
from tumble.cli.main import main
from tumble.files.schedule_file import read_schedule
from tumble.model import Geometry

pytestmark = pytest.mark.python
SHOWN, ALL = 3, 2000  # mutilations of a run
RUNS = {  # run: stand file, schedule
    "paper_stand": ("paper_stand.toml", "paper"),
    "angle_stand": ("angle_stand.toml", "paper"),
    "lab_stand": ("lab_stand.toml", "paper"),
    "six_faces": ("paper_stand.toml", "six_faces.toml"),
    "with_checks": ("paper_stand.toml", "with_checks.toml"),
    "diagonal_stand": ("diagonal_stand.toml", "diagonal"),
    "three_mountings_stand": ("three_mountings_stand.toml", "three_mountings"),
    "hand_held_session": ("hand_laid.toml", "hand_laid_faces.toml"),
}
HEADER = "mounting,position,ux,uy,uz"
ESTIMATORS = ("averaged", "refined", "least_squares", "optimal")


class Mutilated:
    """Rows (mounting, position, ux, uy, uz) of an example, to be mutilated by `rng`; `places` of its schedule."""

    def __init__(self, rows, schedule, rng):
        self.rows, self.rng = rows.copy(), rng
        self._geometry, self._scale = Geometry(schedule), float(np.ptp(rows[:, 2:]) / 2)
        self.places = [(one.mounting, one.number) for one in schedule.positions]

    def at(self, place):
        return (self.rows[:, 0] == place[0]) & (self.rows[:, 1] == place[1])

    def relabel(self, places):
        """Rows at each place of the schedule get the label of another."""
        chosen = [self.at(place) for place in self.places]
        for rows, place in zip(chosen, places):
            self.rows[rows, :2] = place

    def some(self):
        """Indices of rows that follow one another."""
        first, behind = sorted(self.rng.randrange(len(self.rows) + 1) for _ in range(2))
        return np.arange(first, behind)

    def part(self):
        """Rows of a position, of a mounting, of the end of the run, or all."""
        place = self.rng.choice(self.places)
        end = np.arange(len(self.rows)) >= self.rng.randrange(len(self.rows))
        return self.rng.choice([self.at(place), self.rows[:, 0] == place[0], end, np.ones(len(self.rows), bool)])

    # Mistakes.

    def neighbours_exchanged(self):
        places, at = list(self.places), self.rng.randrange(len(self.places) - 1)
        places[at], places[at + 1] = places[at + 1], places[at]
        self.relabel(places)

    def positions_in_random_order(self):
        self.relabel(self.rng.sample(self.places, len(self.places)))

    def begun_elsewhere(self):
        """A mounting, or the whole run, one or several positions late."""
        mounting, late = self.rng.choice([None, *{place[0] for place in self.places}]), self.rng.randrange(1, 8)
        moved = [place for place in self.places if mounting in (None, place[0])]
        new = dict(zip(moved, moved[late % len(moved) :] + moved[: late % len(moved)]))
        self.relabel([new.get(place, place) for place in self.places])

    def mountings_exchanged(self):
        numbers = sorted({place[0] for place in self.places})
        new = dict(zip(numbers, self.rng.sample(numbers, len(numbers))))
        self.rows[:, 0] = [new[number] for number in self.rows[:, 0]]

    def position_repeated(self):
        """Its outputs stand at another place too, instead of what belongs there or beside it."""
        own, other = self.rng.sample(self.places, 2)
        copied = self.rows[self.at(own)]
        copied[:, :2] = other
        self.rows = np.vstack((self.rows[~self.at(other)] if self.rng.random() < 0.5 else self.rows, copied))

    def positions_off(self):
        """Turned too far, or the block leant, by up to 30 degrees."""
        few = self.rng.sample(range(len(self.places)), self.rng.randrange(1, min(4, len(self.places))))
        error = self.rng.choice(("delta", "alpha1"))
        size = np.zeros(len(self.places))
        size[few] = np.deg2rad(self.rng.choice((0.5, 5.0, -30.0, 30.0)))
        wrong = size if error == "delta" else float(size.sum())
        moved = self._scale * (self._geometry.force(**{error: wrong}) - self._geometry.force())
        for place in few:
            self.rows[self.at(self.places[place]), 2:] += moved[place]

    def rows_shuffled(self):
        self.rows = self.rows[self.rng.sample(range(len(self.rows)), len(self.rows))]

    def rows_moved(self):
        some = self.some()
        kept = np.delete(self.rows, some, axis=0)
        self.rows = np.insert(kept, self.rng.randrange(len(kept) + 1), self.rows[some], axis=0)

    def rows_relabelled(self):
        self.rows[self.some()[:200], :2] = self.rng.choice(self.places)

    def rows_repeated(self):
        some = self.rows[self.some()] if self.rng.random() < 0.5 else self.rows
        self.rows = np.vstack((self.rows, *[some] * self.rng.randrange(1, 3)))

    def rows_dropped(self):
        some = self.part() if self.rng.random() < 0.5 else np.isin(np.arange(len(self.rows)), self.some())
        self.rows = self.rows[~some] if not some.all() else self.rows[:1]

    def every_nth_kept(self):
        self.rows = self.rows[:: self.rng.choice((2, 5, 20, 50))]

    def means_alone(self):
        means = [[*place, *self.rows[self.at(place), 2:].mean(axis=0)] for place in self.places if self.at(place).any()]
        self.rows = np.array(means)

    def scaled(self):
        channel = self.rng.choice(([2], [3], [4], [2, 3, 4]))
        factor = self.rng.choice((0.5, 2.0, -1.0, 0.0, 1000.0, 1e-3, 9.80665, 1e-9, 1.001))
        self.rows[np.ix_(np.flatnonzero(self.part()), channel)] *= factor

    def shifted(self):
        size = self.rng.choice((1e-4, 1e-2, 1.0, 100.0)) * self._scale
        self.rows[self.part(), self.rng.randrange(2, 5)] += size

    def channels_exchanged(self):
        order = self.rng.sample((2, 3, 4), 3)
        rows = self.part()
        self.rows[rows, 2:] = self.rows[rows][:, order]

    def noisier(self):
        rows = np.flatnonzero(self.part())
        size = self._scale * self.rng.choice((1e-5, 1e-3, 0.1))
        self.rows[rows, 2:] += size * np.random.default_rng(self.rng.randrange(1 << 32)).standard_normal((len(rows), 3))

    def coarse(self):
        step = self._scale * self.rng.choice((1e-4, 1e-2, 0.3))
        self.rows[:, 2:] = np.rint(self.rows[:, 2:] / step) * step

    def spikes(self):
        for _ in range(self.rng.randrange(1, 4)):
            self.rows[self.rng.randrange(len(self.rows)), self.rng.randrange(2, 5)] = self.rng.uniform(-10, 10)


HELPERS = ("at", "relabel", "some", "part")
MISTAKES = [name for name, one in vars(Mutilated).items() if callable(one) and name[0] != "_" and name not in HELPERS]


@pytest.fixture(scope="module")
def examples(tmp_path_factory):
    """Rows of each run, by name; those of the hand-held session as they are imported."""
    folder = tmp_path_factory.mktemp("imported")
    session = [EXAMPLES / "hand_held_session.csv", "--schedule", EXAMPLES / "hand_laid_faces.toml", "--stand",
               EXAMPLES / "hand_laid.toml", "--unit", "m/s^2", "--rate", "102.4", "--repeats", "first"]  # fmt: skip
    assert run("import", *session, "--out", folder / "hand_held_session.csv")[0] == 0
    found = {}
    for name in RUNS:
        recorded = package.read((folder if name == "hand_held_session" else EXAMPLES) / f"{name}.csv")
        found[name] = np.column_stack((recorded.mounting, recorded.position, recorded.outputs))
    return found


def run(*words):
    """`tumble ...` within this process: exit code, standard output and error."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([*map(str, words)])
    return code, out.getvalue(), err.getvalue()


def mutilate(rows, schedule, rng):
    """One to three mistakes, and their names."""
    found, made = Mutilated(rows, schedule, rng), rng.choices(MISTAKES, k=rng.choice((1, 1, 2, 3)))
    for mistake in made:
        getattr(found, mistake)()
    return found.rows, made


def judge(code, out, err, said):
    if code == 2:
        assert not out and err.endswith("\n") and err.count("\n") == 1, (said, out, err)
    else:
        assert code in (0, 1) and out, (said, err)


def schedule_of(name):
    schedule = RUNS[name][1]
    return str(EXAMPLES / schedule) if schedule.endswith(".toml") else schedule


def words_of(rng, name, with_stand):
    """Options that fit: mostly as one would solve the run, sometimes others."""
    stand = RUNS[name][0]
    words = ["--schedule", schedule_of(name)]
    words += ["--estimator", rng.choice(ESTIMATORS if with_stand else ESTIMATORS[:3])]
    words += ["--stand", EXAMPLES / stand] if with_stand else []
    words += ["--json"] if rng.random() < 0.5 else []
    return words + (["--model", rng.choice(("k2", "drift", "k2,k3"))] if rng.random() < 0.1 else [])


def go_through(name, rows, mutilations, seed, file):
    """Mutilate and solve with and without the stand file."""
    schedule = read_schedule(schedule_of(name)).data
    for number in range(mutilations):
        rng = random.Random(seed + number)
        text, made = mutilate(rows, schedule, rng)
        np.savetxt(file, text, "%d,%d,%.7f,%.7f,%.7f", header=HEADER, comments="")
        for with_stand in (True, False):
            words = words_of(rng, name, with_stand)
            said = f"{name}, seed {seed + number}: {', '.join(made)}: {' '.join(map(str, words))}"
            code, out, err = run("solve", file, *words)
            judge(code, out, err, said)
            if code < 2 and "--json" in words:
                valid(out)


@pytest.mark.parametrize("name", RUNS)
def test_some_mutilations(name, examples, tmp_path):
    go_through(name, examples[name], SHOWN, 1000 * zlib.crc32(name.encode()), tmp_path / "run.csv")


ONCE_FAULTS = [
    ("paper_stand", 175),  # numpy divided by no noise at all, and said so
    ("hand_held_session", 123),  # core and numpy had other chi-squared, far beyond linear theory
    ("hand_held_session", 683),
    ("hand_held_session", 1833),
]


@pytest.mark.parametrize(("name", "seed"), ONCE_FAULTS)
def test_mutilations_that_once_ended_in_a_fault(name, seed, examples, tmp_path):
    go_through(name, examples[name], 1, seed, tmp_path / "run.csv")


@pytest.mark.full
@pytest.mark.parametrize("name", RUNS)
def test_all_mutilations(name, examples, tmp_path, fresh_seed):
    go_through(name, examples[name], ALL, fresh_seed, tmp_path / "run.csv")


def relabelled(rows, new):
    """Rows of a position with the label of another one."""
    found = rows.copy()
    for own, other in new.items():
        found[(rows[:, :2] == own).all(axis=1), :2] = other
    return found


def gain_cut(rows):
    return np.column_stack((rows[:, :2], rows[:, 2:] * np.where(rows[:, :1] == 2, 0.25, 1.0)))


def two_turned_too_far(rows):
    """By 30 degrees each: 1.3 and 2.6 of the paper's run."""
    schedule, delta, found = read_schedule("paper").data, np.zeros(18), rows.copy()
    delta[[2, 14]] = np.deg2rad(30.0)
    moved = 2.0 * (Geometry(schedule).force(delta=delta) - Geometry(schedule).force())
    for place in (2, 14):
        own = (schedule.positions[place].mounting, schedule.positions[place].number)
        found[(rows[:, :2] == own).all(axis=1), 2:] += moved[place]
    return found


@pytest.mark.parametrize("mistake, places", [
    (lambda rows: relabelled(rows, {(1, 1): (1, 2), (1, 2): (1, 1)}), ("1.2", "1.1")),
    (gain_cut, ("2.7", "2.3")),
    (two_turned_too_far, ("1.3", "2.6")),
])  # fmt: skip
def test_common_mistakes_are_explained(mistake, places, tmp_path):
    """By the two positions that are wrong, where two are."""
    rows = np.loadtxt(EXAMPLES / "paper_stand.csv", delimiter=",", skiprows=1)
    np.savetxt(tmp_path / "run.csv", mistake(rows), "%d,%d,%.7f,%.7f,%.7f", header=HEADER, comments="")
    code, out, err = run("solve", tmp_path / "run.csv", "--stand", EXAMPLES / "paper_stand.toml")
    assert code == 1 and "the run does not fit the stand file: " in err, err
    assert re.findall(r"position (\S+) \(", err) == list(places)
    assert out.startswith("FAIL: ")


@pytest.mark.parametrize("rows", [588, 645])
def test_a_third_mounting_that_is_not_finished(rows, tmp_path):
    """numpy took the first two for the paper's, with its closed form of the angles, and the core did not: exit 3."""
    text = (EXAMPLES / "three_mountings_stand.csv").read_text().splitlines(keepends=True)
    (tmp_path / "run.csv").write_text("".join(text[: 1 + rows]))
    words = ("--schedule", "three_mountings", "--estimator", "least_squares", "--json")
    code, out, err = run("solve", tmp_path / "run.csv", *words)
    assert code == 0, err
    assert valid(out)["stand_seen"]["alpha1_rad"] is None
