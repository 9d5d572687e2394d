"""Random recordings of all positions of a schedule, imported: right, or refused with a reason; never wrong without a
word."""

import re
from collections import Counter

import numpy as np
import pytest
from dressed import KINDS, dressed
from recordings import random_case

from tumble.errors import BadInput
from tumble.files.run_layout import LayoutOptions
from tumble.importing.match import UserChoices
from tumble.importing.pipeline import Settings, import_recordings
from tumble.model import built_in

pytestmark = pytest.mark.python

PAPER, INCLINED = "paper", "inclined"
ALIKE = {8: 0, 17: 9, 26: 18}  # the last position of a mounting is the attitude of its first
FAR = 6.0  # standard errors, of a mean that moving rows are in


def judged(case, name, folder, kind="plain", seed=0):
    """("right" | "refused" | "wrong", what) of a case of the schedule of this name, in a file of this kind."""
    file, made = folder / "recording.csv", dressed(case.recorded, kind, np.random.default_rng(seed))
    file.write_bytes(made.data)
    user_choices = UserChoices(order=case.order, signs=case.signs)
    options = LayoutOptions(unit=None if kind == "TOA5" else "V")
    try:
        done = import_recordings([str(file)], built_in(name), Settings(name, options, user_choices=user_choices))
    except BadInput as refused:
        return "refused", str(refused)
    told = " ".join(done.notes)
    faults = []
    rests = zip(done.rests.begin, done.rests.end, done.rests.means, done.matched.positions.tolist())
    for begin, end, mean, position in rests:
        if position < 0:
            continue
        rows = made.row_of_line[[done.line(row) for row in range(begin, end)]]
        rows = np.where(rows < 0, -1, case.recorded.truth[rows])
        true = int(np.bincount(rows + 1).argmax()) - 1
        alike = ALIKE.get(true, true) == ALIKE.get(position, position) and "have the same attitude" in told
        same = true == position or alike
        if not same:
            faults.append(f"rest of {true} called {position}")
        elif moved(case.recorded, mean / made.scale + made.offset, end - begin, true, 0.5 / made.scale) > FAR:
            faults.append(f"rows in motion at {position}")
    missing = len(done.schedule.positions) - len(set(done.matched.positions.tolist()) - {-1})
    if missing and "no rest at" not in told:
        faults.append(f"{missing} positions are missing, and nobody says so")
    return ("wrong", "; ".join(faults)) if faults else ("right", f"{missing} missing")


def moved(recorded, mean, samples, position, half_count=0.0):
    """How far the mean of a rest is off the truth, in standard errors, beyond what rounding can do to it; to a count as
    well, where the scale is not 1."""
    expected = recorded.k @ recorded.forces[position] + recorded.u0
    noise = np.hypot(recorded.noise, 0.3 * recorded.step) * np.abs(np.diag(recorded.k)) / np.sqrt(samples)
    digits = 1e-7 * np.abs(recorded.outputs).max()  # of the file
    rounded = 0.5 * recorded.step * np.abs(np.diag(recorded.k)) if recorded.noise < recorded.step else 0.0
    rounded = rounded + (half_count if half_count != 0.5 else 0.0)
    return ((np.abs(mean - expected) - rounded) / (noise + digits)).max()


def outcomes(name, seeds, folder):
    """Of random recordings of this schedule, each in a file of another kind: [(seed, case, outcome, what)]."""
    found = []
    for seed in seeds:
        case, kind = random_case(built_in(name), seed), list(KINDS)[seed % len(KINDS)]
        outcome, what = judged(case, name, folder, kind, seed)
        found.append((seed, case, outcome, f"{kind}: {what}"))
    return found


def require(found, least):
    """Nothing is wrong; what is said falsely is refused, what is said truly is right in a part of cases, at `least`."""
    assert [(seed, what) for seed, _, outcome, what in found if outcome == "wrong"] == []
    for seed, case, outcome, what in found:
        if outcome == "refused":
            assert re.search(r"--(signs|order|leave-out|repeats|take)", what), (seed, what)
        elif case.order == "schedule":
            assert case.kind == "schedule", seed
    true = [outcome for _, case, outcome, _ in found if is_true(case)]
    assert true.count("right") >= least * len(true)


def is_true(case):
    """Is what the user says, or what is assumed where he says nothing, so?"""
    order = case.order == "any" or case.kind == "schedule"
    return order and (case.signs is not None or (case.order == "schedule" and case.true_signs == (1, 1, 1)))


@pytest.mark.toolchain
@pytest.mark.parametrize(("name", "count"), [(PAPER, 32), (INCLINED, 12)])
def test_a_few_dozen(name, count, tmp_path):
    require(outcomes(name, range(count), tmp_path), 0.8)


@pytest.mark.toolchain
def test_a_temperature_that_could_be_a_clock_is_none(tmp_path):
    """T rises eight times in the run: in hours it would be a clock of 16 Hz, whose rests begin while the table
    settles."""
    [(_, case, outcome, what)] = outcomes(INCLINED, [1237], tmp_path)
    assert is_true(case) and outcome == "right", what


@pytest.mark.full
@pytest.mark.slow
@pytest.mark.parametrize("name", [PAPER, INCLINED])
def test_a_thousand(name, tmp_path):
    found = outcomes(name, range(1000, 2000), tmp_path)
    print(Counter(outcome for *_, outcome, _ in found))
    kinds = Counter((what.partition(":")[0], outcome) for _, case, outcome, what in found if is_true(case))
    print("\n".join(f"{kind}, {outcome}: {count}" for (kind, outcome), count in sorted(kinds.items())))
    print("of those whose user says what is so:", Counter(outcome for _, case, outcome, _ in found if is_true(case)))
    require(found, 0.95)
