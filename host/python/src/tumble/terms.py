"""Further terms that a model may have beside the twelve coefficients, by the names that --model takes.

    U_i = U0_i + sum_j K_ij a_j + K_ii (K2_i a_i^2 + K3_i a_i^3) + drift_i (t - 1/2)

with t from 0, the first position of the run, to 1, the last one. Each term has a size for every channel, in the unit of
the outputs: K_ii K2_i, K_ii K3_i and drift_i. The outputs are linear in the sizes.
"""

from __future__ import annotations

from tumble.errors import UsageError, quoted
from tumble.estimators import INCLINED, NORM

Terms = tuple[str, ...]

DRIFT = "drift"
POWERS = {"k2": 2, "k3": 3}  # of the specific force along the channel's own axis
KEYS = {"k2": "k2_per_g", "k3": "k3_per_g2", DRIFT: "drift_v"}  # in a result
TERMS: Terms = (*POWERS, DRIFT)
EXTENDABLE = ("least_squares", "optimal")  # the estimators that find them


def names(terms: Terms) -> tuple[str, ...]:
    """Of what is found of them, such as K2_x and drift_z, in the order of the sizes: by term, then by channel."""
    return tuple(f"{term if term == DRIFT else term.upper()}_{axis}" for term in terms for axis in "xyz")


def parse(text: str | None, estimator: str | None) -> Terms:
    """The further terms that a list such as "k2,k3" names, in the order of TERMS; None names none. `estimator`: the one
    in use, None for all that find them. Raises UsageError."""
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
    return tuple(term for term in TERMS if term in named)
