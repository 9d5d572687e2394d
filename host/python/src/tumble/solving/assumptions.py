"""What a result rests on that its run cannot test and its stand file does not declare."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

import numpy as np

from tumble import reference
from tumble.arrays import Flags, Floats
from tumble.estimators import OPTIMAL
from tumble.records import dataclass
from tumble.schedule import Schedule
from tumble.solving.solution import Solution
from tumble.stand import Stand
from tumble.terms import Terms

Coefficients = tuple[str, ...]
_FEWEST_TO_TEST = 4  # samples: two lengths of blocks


@dataclass(frozen=True)
class Assumption:
    """`phrase`: what is assumed, to stand behind "assuming"; `why`: in a few words. `of`: the coefficients of a
    solution that rest on it, empty where all do; None where it need not be assumed."""

    phrase: str
    why: str
    of: Callable[[Solution], Coefficients | None]


def resting_on_a_seat(
    schedule: Schedule, k: Floats, estimator: str, stand: Stand | None, terms: Terms = ()
) -> Coefficients | None:
    """The coefficients that a tilt of the block against the axis would move unseen; None where the stand declares such
    a tilt or the fit positions show it. `terms`: further ones of the model."""
    if stand is not None and stand.declares_seat:
        return None
    moved = reference.unseen_tilt(schedule, k, _linear(estimator), terms)
    return None if moved is None else _names(moved)


def _on_a_linear_block(solution: Solution) -> Coefficients | None:
    found = solution.found
    moved = reference.unseen_patterns(solution.measured_schedule, found.k, _linear(found.estimator))
    return _names(np.any(list(moved.values()), axis=0)) if moved else None


def _linear(estimator: str) -> str:
    """The estimator, or the one that is most like `optimal`."""
    return "least_squares" if estimator == OPTIMAL else estimator


def _names(moved: Flags) -> Coefficients:
    return tuple(f"K_{'xyz'[i]}{'xyz'[j]}" for i, j in np.argwhere(moved))


def _on_a_square_seat(solution: Solution) -> Coefficients | None:
    found = solution.found
    return resting_on_a_seat(solution.measured_schedule, found.k, found.estimator, solution.stand, found.terms)


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
    "seat": Assumption("a square seat", "no position shows the block's tilt against the axis", _on_a_square_seat),
    "linear": Assumption("linearity", "the positions do not show all higher orders of the block", _on_a_linear_block),
    "order": Assumption("nothing exchanged or reversed", "no [block] says that its axes are such", _in_order),
    "unit": Assumption("volts", "the run file names no unit (--unit)", _in_volts),
    "white_noise": Assumption("white noise", "too few samples at a position to test it", _on_white_noise),
    "undithered": Assumption("independent rounding errors", "all samples of a position round alike", _on_rounding),
    "temperature": Assumption(
        "one temperature", "K and U0 hold at that of the run, which is unknown", _on_a_temperature
    ),
}


@lru_cache(1)  # all parts of an output ask for it
def assumed(solution: Solution) -> Mapping[str, Coefficients]:
    """What a solution rests on, by name and in the order of ASSUMPTIONS, and the coefficients that do."""
    found = {name: assumption.of(solution) for name, assumption in ASSUMPTIONS.items()}
    return {name: coefficients for name, coefficients in found.items() if coefficients is not None}


def phrase(names: Iterable[str]) -> str:
    """Behind a verdict, such as ", assuming a square seat"; empty for none. Names of a later version stay as they
    are."""
    phrases = [ASSUMPTIONS[name].phrase if name in ASSUMPTIONS else name for name in names]
    listed = [*filter(None, [", ".join(phrases[:-1])]), *phrases[-1:]]
    return f", assuming {' and '.join(listed)}" if phrases else ""
