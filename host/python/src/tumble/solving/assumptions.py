"""What a result rests on that its run cannot test and its stand file does not declare."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.model.unseen import moved_by_a_seat, seat_is_unseen, unseen_patterns
from tumble.schedule import Schedule
from tumble.solving.solution import Solution
from tumble.stand import Stand
from tumble.terms import Terms

Coefficients = tuple[str, ...]
_FEWEST_TO_TEST = 4  # samples: two lengths of blocks
_EXPECTED_RAD = 1e-4  # of a seat or a platform that nobody declares
_RAISED = 1.1  # u is by it, before a coefficient is marked
_COUNTS = 0.1  # of the largest change, where no u is known: less is the block's own misalignment
_ROUNDING = 1e-9  # of the largest change: less is none


@dataclass(frozen=True)
class Assumption:
    """`phrase`: what is assumed, to stand behind "assuming"; `why`: in a few words. `of`: the coefficients of a
    solution that rest on it, empty where all do; None where it need not be assumed. `mark`: of a coefficient that does;
    empty where all do."""

    phrase: str
    why: str
    of: Callable[[Solution], Coefficients | None]
    mark: str = ""


def rests_on_a_seat(schedule: Schedule, k: Floats, stand: Stand | None, terms: Terms = ()) -> bool:
    """Whether the stand declares no tilt of the block against the axis, and the fit positions show none. `terms`:
    further ones of the model."""
    return (stand is None or not stand.declares_seat) and seat_is_unseen(schedule, k, terms)


def _on_a_linear_block(solution: Solution) -> Coefficients | None:
    found = solution.found
    moved = unseen_patterns(solution.measured_schedule, found.k, _linear(found.estimator))
    return _names(np.any(list(moved.values()), axis=0).ravel()) if moved else None


def _linear(estimator: str) -> str:
    """The estimator, or the one that is most like `optimal`."""
    return "least_squares" if estimator == OPTIMAL else estimator


def _names(moved: Flags) -> Coefficients:
    """Of those of the twelve, or of the nine of K."""
    return tuple(COEFFICIENTS[index] for index in np.flatnonzero(moved))


def _on_a_square_seat(solution: Solution) -> Coefficients | None:
    """Those whose uncertainty an undeclared tilt of a size to be expected would raise by a tenth or more."""
    found, schedule = solution.found, solution.measured_schedule
    if not rests_on_a_seat(schedule, found.k, solution.stand, found.terms):
        return None
    stated = solution.stated or solution.scatter_alone
    variance = np.zeros(12) if stated is None else np.diag(stated.of_twelve)
    moved = np.array(list(moved_by_a_seat(schedule, found.k, _linear(found.estimator)).values()))
    least_rad = _EXPECTED_RAD * moved.max() * (_COUNTS if stated is None else _ROUNDING)
    raised = (_EXPECTED_RAD * moved) ** 2 > np.maximum((_RAISED**2 - 1.0) * variance, least_rad**2)
    return _names(raised.any(axis=0))


def _in_volts(solution: Solution) -> Coefficients | None:
    return None if solution.run.unit_told else ()


def _on_white_noise(solution: Solution) -> Coefficients | None:
    return None if solution.run.samples.max() >= _FEWEST_TO_TEST else ()


def _on_a_temperature(solution: Solution) -> Coefficients | None:
    return () if solution.run.temperature is None else None


def _on_rounding(solution: Solution) -> Coefficients | None:
    return () if solution.noise.undithered.any() else None


def _in_order(solution: Solution) -> Coefficients | None:
    return () if solution.is_out_of_order else None


ASSUMPTIONS: Mapping[str, Assumption] = {
    "seat": Assumption("a square seat", "no position shows the block's tilt against the axis", _on_a_square_seat, "*"),
    "linear": Assumption(
        "linearity", "the positions do not show all higher orders of the block", _on_a_linear_block, "^"
    ),
    "order": Assumption("nothing exchanged or reversed", "no [block] says that its axes are such", _in_order),
    "unit": Assumption("volts", "the run file names no unit (--unit)", _in_volts),
    "white_noise": Assumption("white noise", "too few samples at a position to test it", _on_white_noise),
    "undithered": Assumption("independent rounding errors", "all samples of a position round alike", _on_rounding),
    "temperature": Assumption(
        "one temperature", "K and U0 hold at that of the run, which is unknown", _on_a_temperature
    ),
}


def assumed(solution: Solution) -> dict[str, Coefficients]:
    """What a solution rests on, by name and in the order of ASSUMPTIONS, and the coefficients that do."""
    found = {name: assumption.of(solution) for name, assumption in ASSUMPTIONS.items()}
    return {name: coefficients for name, coefficients in found.items() if coefficients is not None}


def marks(assumes: Mapping[str, Iterable[str]]) -> dict[str, str]:
    """By coefficient, the marks of all that it rests on; `assumes`: as `assumed` gives it, or a document's
    `assumed_for`. Names of a later version have none."""
    found: dict[str, str] = {}
    for name, coefficients in assumes.items():
        for coefficient in coefficients if name in ASSUMPTIONS else ():
            found[coefficient] = found.get(coefficient, "") + ASSUMPTIONS[name].mark
    return found


def phrase(names: Iterable[str]) -> str:
    """Behind a verdict, such as ", assuming a square seat"; empty for none. Names of a later version stay as they
    are."""
    phrases = [ASSUMPTIONS[name].phrase if name in ASSUMPTIONS else name for name in names]
    listed = [*filter(None, [", ".join(phrases[:-1])]), *phrases[-1:]]
    return f", assuming {' and '.join(listed)}" if phrases else ""
