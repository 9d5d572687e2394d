"""Numbers beside their standard uncertainties, with as many digits as these leave them."""

from __future__ import annotations

import math

_LEAST = 1e-3  # of an uncertainty without an exponent
_ALL_DIGITS = 17


def rounded(size: float, u: float | None) -> tuple[str, str]:
    """A number and its standard uncertainty, both to the second digit of this; "-" for one that is unknown."""
    if u is None or u == 0.0:
        return f"{size:+.3g}", "-" if u is None else "0"
    if u < _LEAST:
        finest = math.floor(math.log10(u)) - 1
        digits = max(0, math.floor(math.log10(abs(size))) - finest) if size else 0
        return f"{size:+.{digits}e}", f"{u:.1e}"
    places = max(0, 1 - math.floor(math.log10(u)))
    return f"{size:+.{places}f}", f"{u:.{places}f}"


def on_its_side(value: float, other: float, digits: int = 2) -> str:
    """A number with so many digits, or more until it is above, at or below the other one as it is in full."""
    for count in range(digits, _ALL_DIGITS):
        text = f"{value:.{count}g}"
        if (float(text) > other, float(text) < other) == (value > other, value < other):
            return text
    return f"{value:.{_ALL_DIGITS}g}"
