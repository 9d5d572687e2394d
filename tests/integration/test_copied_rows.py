"""Rows that are no measurements of their own: written again, copied to another position, of two blocks in turn; and
honest rows, however coarse, slow or disturbed by hum, which are not taken for such."""

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble as package
from tumble.files import run_rows
from tumble.files.run_file import smallest_step
from tumble.model import Geometry, built_in

pytestmark = pytest.mark.python
HEADER = "mounting,position,ux [V],uy [V],uz [V]"
PAPER = EXAMPLES / "paper_stand.toml"
POSITIONS = 18


@pytest.fixture(scope="module")
def rows():
    return np.loadtxt(EXAMPLES / "paper_stand.csv", delimiter=",", skiprows=1)


def written(path, rows):
    np.savetxt(path, rows, "%d,%d,%.7f,%.7f,%.7f", header=HEADER, comments="")
    return path


def at(rows, mounting, position):
    return (rows[:, 0] == mounting) & (rows[:, 1] == position)


def copied_to(rows, own, other):
    """Outputs of one position at another one too."""
    found = rows.copy()
    found[at(rows, *other), 2:] = rows[at(rows, *own), 2:]
    return found


ALL = "1.1 to 2.9"


@pytest.mark.parametrize(
    ("spoil", "again", "first"),
    [
        (lambda rows: np.vstack((rows, rows)), f"902 to 1801 ({ALL})", f"2 to 901 ({ALL})"),
        (lambda rows: np.vstack((rows[:500], rows)), "502 to 1001 (1.1 to 2.1)", "2 to 501 (1.1 to 2.1)"),
        (lambda rows: np.vstack((rows, rows, rows)), f"902 to 2701 ({ALL})", f"2 to 1801 ({ALL})"),
        (lambda rows: np.vstack((rows[:150], rows[100:])), "152 to 201 (1.3)", "102 to 151 (1.3)"),
        (lambda rows: copied_to(rows, (1, 1), (1, 9)), "402 to 451 (1.9)", "2 to 51 (1.1)"),
        (lambda rows: np.vstack((rows[::12], rows[::12])), f"77 to 151 ({ALL})", f"2 to 76 ({ALL})"),
    ],
)
def test_rows_that_come_again(spoil, again, first, rows, refused, tmp_path):
    run = written(tmp_path / "run.csv", spoil(rows))
    for stand in ((), ("--stand", PAPER)):
        said = f"{run}: row {again.split()[0]}: rows {again} are rows {first} again, digit for digit: written twice? "
        assert f"{said}Leave them out" in refused("solve", run, *stand)


@pytest.mark.parametrize("times", [2, 3, 4])
def test_every_row_several_times_in_place(times, rows, tmp_path):
    """It is told, with rows; honest rows are not taken for it, nor those of a converter that shows no noise."""
    said = f"rows 2 to {times + 1}, and so on, are equal, digit for digit: each measurement is written {times} times"
    odd = package.solve(written(tmp_path / "run.csv", np.repeat(rows, times, axis=0)), stand=PAPER).warnings
    assert sum(said in one for one in odd) == 1, odd
    whole = np.repeat(rows, times, axis=0)[times - 1 :]  # the log begins within the first
    for honest in (rows, whole, np.round(rows, 1)):
        told = package.solve(written(tmp_path / "honest.csv", honest), stand=PAPER).warnings
        assert not any("and so on" in one for one in told)


def means_of(rows):
    places = [(m, p) for m in (1, 2) for p in range(1, 10)]
    return np.array([[*place, *rows[at(rows, *place), 2:].mean(axis=0)] for place in places])


@pytest.mark.parametrize("own, other", [((1, 3), (1, 4)), ((1, 2), (2, 7))])
def test_means_that_are_copies(own, other, rows, refused, tmp_path):
    run = written(tmp_path / "run.csv", copied_to(means_of(rows), own, other))
    labels = " and ".join(f"{m}.{p}" for m, p in sorted((own, other)))
    line = refused("solve", run, "--stand", PAPER)
    assert f"{run}: positions {labels} have the same means, digit for digit, where the block lies otherwise: " in line


def test_means_of_one_attitude_may_be_the_same(rows, tmp_path):
    """Where the block lies as before, a coarse converter gives what it gave."""
    run = written(tmp_path / "run.csv", copied_to(means_of(rows), (1, 1), (1, 9)))
    assert package.solve(run, stand=PAPER).passed


def with_second_source(rows, difference):
    found = rows.copy()
    found[1::2, 2:] += difference
    return found


def test_two_sources_in_turn(rows, refused, tmp_path):
    run = written(tmp_path / "run.csv", with_second_source(rows, (0.03, -0.05, 0.02)))
    line = refused("solve", run, "--stand", PAPER)
    assert f"{run}: row 2: rows alternate, uy between " in line
    assert " V: two sources in one file? Keep the rows of one" in line


def test_sources_that_hardly_differ(rows, tmp_path):
    """It may also be a vibration."""
    said = package.solve(with_second_source(rows, (8e-4, 0.0, 0.0)), stand=PAPER).warnings
    (told,) = [one for one in said if "alternate" in one]
    assert told.startswith("from row 1 on rows alternate, ux between ")
    assert told.endswith(" V: two sources in one file, or a vibration in step with them?")


def test_import_refuses_both(refused, tmp_path):
    """A recording of two sensors in turn, and one that a logger wrote from its beginning twice."""
    session = np.loadtxt(EXAMPLES / "hand_held_session.csv", delimiter=",", skiprows=1)[:, 1:]
    options = ("--schedule", EXAMPLES / "hand_laid_faces.toml", "--stand", EXAMPLES / "hand_laid.toml",
               "--unit", "m/s^2", "--rate", "102.4", "--repeats", "first", "--out", tmp_path / "run.csv")  # fmt: skip
    twice = np.vstack((session, session))
    log = tmp_path / "log.csv"
    np.savetxt(log, twice, "%.9f", delimiter=",", header="acc_x,acc_y,acc_z", comments="")
    assert "rows 10378 to 20753 are rows 2 to 10377 again, digit for digit" in refused("import", log, *options)
    session[1::2] += (0.2, -0.3, 0.4)
    np.savetxt(log, session, "%.9f", delimiter=",", header="acc_x,acc_y,acc_z", comments="")
    assert "two sources in one file? Keep the rows of one" in refused("import", log, *options)


def test_a_logger_that_begins_and_ends_with_zeros():
    """And one that toggles by a step before it is moved: quiet parts are no copies of one another."""
    rng = np.random.default_rng(3)
    noisy = np.rint(rng.normal(0.0, 40.0, (2000, 3)))
    for quiet in (np.zeros((160, 3)), np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]])[rng.integers(0, 2, 160)]):
        rows = np.vstack((quiet, noisy, rng.permutation(quiet)))
        assert run_rows.copied(rows, np.zeros(len(rows), dtype=int), np.ones(3)) is None


def test_round_numbers_are_told_apart():
    """Their bits end with zeros, and so did what was made of them to find copies."""
    rows = np.random.default_rng(4).integers(-8, 8, (4000, 3)) / 4.0
    rows = np.vstack((rows, rows[1000:1100]))
    found = run_rows.copied(rows, np.zeros(len(rows), dtype=int), np.full(3, 0.25))
    assert found == run_rows.Repeat(1000, 4000, 100)


# Honest ones.


def ar(rho, noise):
    found = noise.copy()
    for row in range(1, noise.shape[1]):
        found[:, row] = rho * found[:, row - 1] + np.sqrt(1 - rho**2) * noise[:, row]
    return found


def hum(period, times, noise, rng):
    phase = rng.uniform(0.0, 2 * np.pi, (len(noise), 1, 3))
    return noise + times * np.sin(2 * np.pi * np.arange(noise.shape[1])[:, None] / period + phase)


KINDS = {
    "white": lambda noise, rng: noise,
    "alternating": lambda noise, rng: ar(-0.8, noise),
    "slow": lambda noise, rng: ar(0.95, noise),
    "walk": lambda noise, rng: 0.3 * np.cumsum(noise, axis=1),
    "held": lambda noise, rng: np.repeat(noise[:, ::4], 4, axis=1)[:, : noise.shape[1]],
    "hum": lambda noise, rng: hum(10, 10.0, noise, rng),
    "hum beside steps": lambda noise, rng: hum(7, 50.0, noise, rng),
    "in all channels": lambda noise, rng: np.repeat(noise[..., :1], 3, axis=2),
    "two levels": lambda noise, rng: 0.3 * noise + 3 * (np.cumsum(noise > 1.3, axis=1) % 2),
    "none": lambda noise, rng: 0.0 * noise,
}


def honest(kind, rng):
    """Rows at each position (positions, rows, 3) of one or two passes, on a converter of any step; the step."""
    size, step = 10 ** rng.uniform(-6, -3), rng.choice([1e-3, 0.05, 0.3, 1, 2, 3, 5, 10, 30, 100])
    if kind == "none":  # a converter hides it: none repeats itself to a millionth
        size, step = 1e-5, max(1.0, step)
    rows = int(rng.choice([1, 2, 4, 5, 8, 12, 20, 40, 50, 100, 200]))
    exact = Geometry(built_in("paper")).force() * rng.uniform(0.5, 2) + rng.normal(0, 0.05, 3)
    exact = exact[:, None] + rng.choice([0.0, 3e-5]) * rng.standard_normal((POSITIONS, 1, 3))
    drawn = [rng.standard_normal((POSITIONS, rows, 3)) for _ in range(rng.choice([1, 2]))]
    passes = [exact + size * KINDS[kind](noise, rng) for noise in drawn]
    return [np.round(np.rint(one / (step * size)) * step * size, 9) for one in passes]


def alarms(kind, runs, seed):
    found = []
    for number in range(runs):
        passes = honest(kind, np.random.default_rng((seed, number)))
        outputs = np.concatenate([one.reshape(-1, 3) for one in passes])
        position = np.concatenate([np.repeat(np.arange(POSITIONS), one.shape[1]) for one in passes])
        step = np.array([one if np.isfinite(one := smallest_step(channel)) else 0.0 for channel in outputs.T])
        rests = [outputs[position == place] for place in range(POSITIONS)]
        told = run_rows.copied(outputs, position, step), run_rows.in_turn(rests, step, "V")
        found += [(number, one) for one in told if one is not None]
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_honest_rows_are_not_blamed(kind):
    assert alarms(kind, 20, 1) == []


@pytest.mark.full
@pytest.mark.parametrize("kind", KINDS)
def test_thousands_of_honest_runs(kind, fresh_seed):
    assert alarms(kind, 1000, fresh_seed) == []


@pytest.mark.parametrize("step", [1e-3, 1.0, 2.0])
def test_coarse_rows_are_noticed(step):
    """Written twice, of noise down to half a step of the converter."""
    rng = np.random.default_rng(7)
    exact = Geometry(built_in("paper")).force()[:, None] + 1e-4 * rng.standard_normal((POSITIONS, 1, 3))
    rows = np.rint((exact + 1e-4 * rng.standard_normal((POSITIONS, 20, 3))) / (step * 1e-4)) * step * 1e-4
    twice, position = np.vstack([rows.reshape(-1, 3)] * 2), np.tile(np.repeat(np.arange(POSITIONS), 20), 2)
    found = run_rows.copied(twice, position, np.array([smallest_step(channel) for channel in twice.T]))
    assert found == run_rows.Repeat(0, 20 * POSITIONS, 20 * POSITIONS)
