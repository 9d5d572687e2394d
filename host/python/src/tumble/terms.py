"""Further terms that a model may have beside the twelve coefficients, by the names that --model takes.

    U_i = U0_i + sum_j K_ij a_j + K_ii (K2_i a_i^2 + K3_i a_i^3 + s_i |a_i| + sum_j C_ij a_i a_j) + drift_i (t - 1/2)

with j another axis than i, and t from 0, the first position of the run, to 1, the last one. Each term has a size for
every channel, in the unit of the outputs: K_ii K2_i, K_ii K3_i, K_ii s_i and drift_i; `cross` has two, which code that
computes takes as two terms (`expanded`), of the axis that follows the channel's own and of that before it. The outputs
are linear in the sizes.
"""

from __future__ import annotations

from collections.abc import Iterable

from tumble.errors import UsageError, quoted
from tumble.estimators import INCLINED, NORM

Terms = tuple[str, ...]

DRIFT, ASYMMETRY, CROSS = "drift", "asymmetry", "cross"
CROSS_NEXT, CROSS_LAST = CROSSES = ("cross_next", "cross_last")  # in turn x, y, z
POWERS = {"k2": 2, "k3": 3, ASYMMETRY: 1, CROSS_NEXT: 2, CROSS_LAST: 2}  # of the specific force
KEYS = {
    "k2": "k2_per_g",
    "k3": "k3_per_g2",
    ASYMMETRY: ASYMMETRY,
    CROSS: "cross_per_g",
    DRIFT: "drift_v",
}  # in a result
TERMS: Terms = tuple(KEYS)
UNITS_OF_VALUES = {term: ("1", "1/g", "1/g^2")[power - 1] for term, power in POWERS.items()}
EXTENDABLE = ("least_squares", "optimal")  # the estimators that find them


def expanded(model: Iterable[str]) -> Terms:
    """Terms of three sizes each, of those that a model names."""
    return tuple(one for term in model for one in (CROSSES if term == CROSS else (term,)))


def model_of(terms: Terms) -> Terms:
    """As --model names them."""
    return tuple(dict.fromkeys(CROSS if term in CROSSES else term for term in terms))


def as_patterns(terms: Terms) -> Terms:
    """Names of the patterns of model.patterns that are in the model with these."""
    return tuple("cross_coupling" if term == CROSS else term for term in model_of(terms))


def name(term: str) -> str:
    """For people."""
    return term.upper() if term in ("k2", "k3") else term


def names(terms: Terms) -> tuple[str, ...]:
    """Of what is found of them, such as K2_x, cross_xy and drift_z, in the order of the sizes: by term, then by
    channel."""
    of = {CROSS_NEXT: [f"{CROSS}_{pair}" for pair in ("xy", "yz", "zx")]}
    of[CROSS_LAST] = [f"{CROSS}_{pair}" for pair in ("xz", "yx", "zy")]
    return tuple(one for term in terms for one in of.get(term, [f"{name(term)}_{axis}" for axis in "xyz"]))


def parse(text: str | None, estimator: str | None) -> Terms:
    """The further terms that a list such as "k2,k3" names, in the order of TERMS, `expanded`; None names none.
    `estimator`: the one in use, None for all that find them. Raises UsageError."""
    if text is None:
        return ()
    named = [term.strip() for term in text.split(",")]
    for term in named:
        if term not in TERMS or named.count(term) > 1:
            raise UsageError(f"--model: {quoted(term)} is not one of {', '.join(TERMS)}, once each")
    if estimator is not None and estimator not in EXTENDABLE:
        closed = f"{estimator} is a closed form of twelve coefficients"
        if estimator == NORM:
            closed = f"{estimator} finds nine coefficients of poses that nobody knows"
        others = "" if estimator == INCLINED else "least_squares, or "
        raise UsageError(f"--model: {closed}; use --estimator {others}optimal with --stand FILE")
    return expanded(term for term in TERMS if term in named)
