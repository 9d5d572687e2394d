"""What a result rests on that its run cannot test and its stand file does not declare."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from tumble.solving.solution import Solution

Coefficients = tuple[str, ...]
_ALL: Coefficients = ()
_FEWEST_TO_TEST = 4  # samples: two lengths of blocks


@dataclass(frozen=True)
class Assumption:
    """`phrase`: what is assumed, to stand behind "assuming"; `why`: in a few words. `of`: the coefficients of a
    solution that rest on it, empty where all do; None where it need not be assumed."""

    phrase: str
    why: str
    of: Callable[[Solution], Coefficients | None]


def _on_white_noise(solution: Solution) -> Coefficients | None:
    return None if solution.run.samples.max() >= _FEWEST_TO_TEST else _ALL


def _on_rounding(solution: Solution) -> Coefficients | None:
    return _ALL if solution.noise.undithered.any() else None


ASSUMPTIONS: Mapping[str, Assumption] = {
    "white_noise": Assumption("white noise", "too few samples at a position to test it", _on_white_noise),
    "undithered": Assumption("independent rounding errors", "all samples of a position round alike", _on_rounding),
}


def assumed(solution: Solution) -> dict[str, Coefficients]:
    """What a solution rests on, by name and in the order of ASSUMPTIONS, and the coefficients that do."""
    found = {name: assumption.of(solution) for name, assumption in ASSUMPTIONS.items()}
    return {name: coefficients for name, coefficients in found.items() if coefficients is not None}


def phrase(names: Iterable[str]) -> str:
    """Behind a verdict, such as ", assuming a square seat"; empty for none. Names of a later version stay as they
    are."""
    phrases = [ASSUMPTIONS[name].phrase if name in ASSUMPTIONS else name for name in names]
    return f", assuming {' and '.join(phrases)}" if phrases else ""
