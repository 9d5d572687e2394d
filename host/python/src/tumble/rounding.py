"""Numbers beside their standard uncertainties, with as many digits as these leave them."""

from __future__ import annotations

import math

_LEAST = 1e-3  # of an uncertainty without an exponent


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
