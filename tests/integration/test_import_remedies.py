"""What a refusal of `tumble import` advises, followed: the command that it prints imports what the recording was."""

import csv
import itertools
import shlex

import numpy as np
import pytest
from conftest import cause_and_remedy
from dressed import KINDS, dressed
from recordings import Habits, recording

from tumble.cli.main import main
from tumble.importing import repairs
from tumble.model import built_in

pytestmark = pytest.mark.python

SCHEDULE = built_in("diagonal")
K, U0 = np.diag([1.1, 0.9, 1.05]) + 0.01, np.array([0.02, -0.03, 0.05])
QUIET = Habits(rate_hz=40.0, rest_s=(2.0, 3.0), noise_g=1e-3, angle=1e-5, seat=1e-5, bench=0.0, pause=0.0, gap=0.0)
IN_ORDER = list(range(len(SCHEDULE.positions)))


def made(visits=IN_ORDER, k=K, seed=1):
    return recording(SCHEDULE, visits, k, U0, QUIET, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def logged():
    return made()


@pytest.fixture
def run(tmp_path, capsys, monkeypatch):
    """`tumble import` with these options, in this process: exit code and standard error."""
    monkeypatch.chdir(tmp_path)

    def imported(*words):
        code = main(["import", *words])
        return code, capsys.readouterr().err

    return imported


def followed(run, stderr):
    """The run file of the command below a refusal: means by (mounting, position)."""
    assert stderr.startswith("took: "), stderr
    _, *lines = cause_and_remedy(stderr)
    program, verb, *words = shlex.split("".join(lines).replace("\\\n", ""))
    assert (program, verb) == ("tumble", "import")
    assert run(*words) == (0, "")
    rows = {}
    with open("run.csv") as stream:
        for row in csv.reader(line for line in stream if line[0].isdigit()):
            rows.setdefault((int(row[0]), int(row[1])), []).append([float(value) for value in row[2:5]])
    return {place: np.mean(samples, axis=0) for place, samples in rows.items()}


def require_right(means, recorded, missing=0):
    expected = recorded.forces @ recorded.k.T + recorded.u0
    places = [(one.mounting, one.number) for one in SCHEDULE.positions]
    assert len(means) >= len(places) - missing and means.keys() <= set(places)
    for place, own in means.items():
        assert own == pytest.approx(expected[places.index(place)], abs=3e-3), place


# What the user says and is not so: one command puts it right.


def written(text):
    with open("log.csv", "w") as stream:
        stream.write(text)


def labelled(text, of_row):
    """With a column `position` behind the clock."""
    head, *rows = text.splitlines()
    lines = [row.replace(",", f",{of_row(place)},", 1) for place, row in enumerate(rows)]
    return "\n".join([head.replace(",", ",position,", 1), *lines]) + "\n"


WRONG = {  # options beside --schedule diagonal, and what the cause names
    "a rate far too high": (("--rate", "100000"), "100000"),
    "a clock that counts seconds, said to count us": (("--time-unit", "us"), "rest"),
    "rests of a minute": (("--min-rest", "60"), "--min-rest"),
    "a threshold below the noise": (("--still", "0.01"), "--still"),
    "drift below the noise": (("--drift", "0.001"), "--drift"),
    "windows longer than rests": (("--window", "100"), "rest"),
    "a tolerance below the noise": (("--tolerance", "1e-5"), "fit the positions"),
    "another schedule": (("--schedule", "six_faces"), "position"),
    "signs that are not so": (("--signs=-++",), "--signs"),
    "channels exchanged": (("--columns", "ux=Ay,uy=Ax,uz=Az", "--signs=+++"), "exchanged"),
    "a rest that is not there": (("--leave-out", "99"), "no rest 99"),
    "a rest to be taken and left out": (("--leave-out", "3", "--take", "3"), "--leave-out"),
    "mountings that have no names": (("--mountings", "A=1"), "--mountings"),
    "rows that are not there": (("--rows", "Ax=7"), "--rows"),
}


@pytest.mark.parametrize("name", WRONG)
def test_an_option_that_is_not_so(name, logged, run):
    options, cause = WRONG[name]
    written(logged.csv())
    code, said = run("log.csv", "--schedule", "diagonal", "--signs=+++", *options, "--out", "run.csv")
    assert code == 2 and cause in cause_and_remedy(said)[0] + said.partition("\nremedy")[2], said
    require_right(followed(run, said), logged, missing=1 if "rest to be" in name else 0)


# What the recording is, and nobody says.

ANY = [*IN_ORDER[4:], *IN_ORDER[:4]]
TWICE = [*IN_ORDER[:6], 2, *IN_ORDER[6:]]
PLACES = ("--schedule", "diagonal", "--signs=+++")


@pytest.mark.parametrize(("visits", "options", "cause"), [
    (IN_ORDER, (), "no schedule is given"), (IN_ORDER[::-1], ("--schedule", "diagonal"), "positions are found"),
    (ANY, PLACES, "in another order"), (IN_ORDER, ("--schedule", "diagonal", "--order", "any"), "fits"),
])  # fmt: skip
def test_an_order_or_a_schedule_that_nobody_says(visits, options, cause, run):
    recorded = made(visits)
    written(recorded.csv())
    code, said = run("log.csv", *options, "--out", "run.csv")
    assert code == 2 and cause in cause_and_remedy(said)[0], said
    require_right(followed(run, said), recorded)


def test_a_position_that_comes_twice(run):
    written(made(TWICE).csv())
    code, said = run("log.csv", *PLACES, "--order", "any", "--out", "run.csv")
    assert code == 2 and "--repeats first|last|longest" in said
    require_right(followed(run, said), made(TWICE))


def of_rest(logged, number):
    """Which of the visits a row is in, from 1, exchanged at `number`; carried along while the table turns."""
    filled = np.maximum.accumulate(np.where(logged.truth >= 0, logged.truth + 1, 1))
    return lambda place: int(filled[place]) if filled[place] != number else 12


def with_time(text, time):
    """The same time in each row."""
    head, *rows = text.splitlines()
    return "\n".join([head, *(f"{time},{row.partition(',')[2]}" for row in rows)]) + "\n"


FILES = {  # the text of a file, the options, what the cause names
    "a label that gravity denies": (lambda one: labelled(one.csv(), of_rest(one, 3)), PLACES, "is labelled"),
    "two sources in turn": (lambda one: one.csv(), PLACES, "alternate"),
    "columns of other names": (lambda one: one.csv("time,left,right,up"), PLACES, "--columns"),
    "blanks between columns": (lambda one: one.csv().replace(",", "  "), PLACES, "--delimiter"),
    "a clock that stands still": (lambda one: with_time(one.csv(), "7"), PLACES, "does not increase"),
    "times that are none": (lambda one: with_time(one.csv(), "noon"), PLACES, "is not a time"),
    "rows written twice": (lambda one: one.csv() + one.csv().partition("\n")[2], PLACES, "again, digit for digit"),
}  # fmt: skip


def in_turn(text):
    """Each row, and one of another sensor below it."""
    head, *rows = text.splitlines()
    lines = [head.replace(",", ",I,", 1)]
    for row in rows:
        t, *values = row.split(",")
        lines += [f"{t},0,{','.join(values)}", f"{t},1,{','.join(str(0.9 * float(one) + 0.1) for one in values)}"]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("name", FILES)
def test_a_file_that_is_not_as_it_should_be(name, logged, run):
    of_recording, options, cause = FILES[name]
    text = of_recording(logged)
    written(in_turn(text) if name == "two sources in turn" else text)
    code, said = run("log.csv", *options, "--out", "run.csv")
    assert code == 2 and cause in cause_and_remedy(said)[0], said
    require_right(followed(run, said), logged, missing=2 if "label" in name else 0)


# Kinds of files, with whatever somebody says of them.


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_of_file_is_read_whatever_its_logger_does(kind, logged, run):
    """As it is; or by the command that the refusal prints."""
    file = dressed(logged, kind, np.random.default_rng(4))
    with open("log.csv", "wb") as stream:
        stream.write(file.data)
    code, said = run("log.csv", *PLACES, "--out", "run.csv")
    assert (code, said) == (0, ""), said
    with open("run.csv") as stream:
        rows = [row for row in csv.reader(stream) if row[0].isdigit()]
    places = [place for place, _ in itertools.groupby((int(row[0]), int(row[1])) for row in rows)]
    assert places == [(one.mounting, one.number) for one in SCHEDULE.positions]


@pytest.mark.parametrize("seed", range(12))
def test_random_mistakes_in_random_files(seed, logged, run):
    """Two mistakes at once in a file of any kind: imported right, or refused with a command that imports it right."""
    rng = np.random.default_rng(seed)
    kind = list(KINDS)[int(rng.integers(len(KINDS)))]
    file = dressed(logged, kind, rng)
    with open("log.csv", "wb") as stream:
        stream.write(file.data)
    wrong = [list(WRONG)[place] for place in rng.permutation(len(WRONG))[:2]]
    options = [word for name in wrong for word in WRONG[name][0] if "columns" not in WRONG[name][0][0]]
    code, said = run("log.csv", *PLACES, *options, "--out", "run.csv")
    if code == 2 and not said.startswith("took: "):
        return  # two options that cannot be meant together are refused before a file is read
    assert code == 2, said
    means = followed(run, said)
    require_right({place: one / file.scale + file.offset for place, one in means.items()}, logged, missing=1)


@pytest.mark.parametrize(("noise", "held"), [(0.05, False), (0.3, False), (30.0, True)])
def test_a_coarse_converter_is_not_stuck(noise, held):
    """In its steps. A calibration has mixed the channels, so that the smallest difference says nothing of the steps. A
    value that is held is found where noise would change it."""
    rng = np.random.default_rng(4)
    counts = np.round(
        np.repeat(rng.uniform(-1e4, 1e4, (18, 3)), 1000, axis=0) + noise * rng.standard_normal((18000, 3))
    )
    outputs = 1e-4 * counts @ (np.eye(3) + 0.01 * rng.standard_normal((3, 3)))
    seen = np.full(3, 1e-4 * max(noise, 0.1)), np.full(3, 1e-9)  # noise and step
    assert not repairs.stuck(outputs, *seen).any()
    outputs[5200:6000] = outputs[5200]
    found = np.flatnonzero(repairs.stuck(outputs, *seen))
    assert found.tolist() == (list(range(5200, 6000)) if held else [])
