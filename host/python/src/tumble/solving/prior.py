"""What became of a prior (model.prior) beside a run, and how people are told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from tumble.files.rows import Temperatures, range_text
from tumble.model.prior import Change, Prior, PriorTest

Unit = Literal["ppm", "urad", "ug"]
_UNITS: Mapping[str, Unit] = {"scale": "ppm", "angle": "urad", "bias": "ug"}
_NAMED = 3
TOLERANCE_C = 1.0  # as for data that a result is applied to


@dataclass(frozen=True)
class PriorOutcome:
    """The `test` of a `prior` against the run, and whether it is `used`; worst u(|a|) of the run alone, None where it
    determines too little, and the coefficients of which that is so (`undetermined`)."""

    prior: Prior
    test: PriorTest
    used: bool
    u_norm_alone_g: float | None
    undetermined: tuple[str, ...] = ()

    @property
    def finding(self) -> str | None:
        """What a person must be told; None for a prior that is used."""
        if self.used:
            return None
        since, test = self.prior.created[:10], self.test
        best = [_change_text(one) for one in test.changes[:_NAMED]]
        explained = f"; explained best by {' or '.join(best)}" if best else ""
        return f"the block has changed since {since}, or one of the two runs is wrong: {test_text(test)}{explained}"


def temperature_notice(prior: Prior, run: Temperatures | None) -> str | None:
    """That the two were measured at temperatures that differ by more than TOLERANCE_C; None where they were not, or
    nobody tells."""
    if prior.temperature_c is None or run is None:
        return None
    low, high = prior.temperature_c
    if run.low_c - TOLERANCE_C <= high and low <= run.high_c + TOLERANCE_C:
        return None
    return f"the prior is of {range_text(low, high)}, the run of {run.text}: growth counts days, not kelvins"


def test_text(test: PriorTest) -> str:
    """Its figures."""
    return f"chi-squared {test.chi_squared:.3g}, {test.freedom} degrees of freedom, p {test.p:.2g}"


def _change_text(change: Change) -> str:
    """Such as "bias_x, +120 +- 20 ug (6.0 u)"."""
    size, u = change.size * 1e6, change.u * 1e6
    return f"{change.parameter}, {size:+.3g} +- {u:.2g} {unit_of(change)} ({abs(size / u):.1f} u)"


def unit_of(change: Change) -> Unit:
    """Of a millionth of the parameter."""
    return _UNITS[change.parameter.partition("_")[0]]
