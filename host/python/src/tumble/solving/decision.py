"""The decision rule: may a calibration be called good, and where? (docs/method.md, "The decision rule")

Three questions, each with its own answer: do the measured positions meet the limit, does the run fit the declared
stand, and is the limit met at every attitude, as far as the uncertainties say? PASS needs all that can be asked. Where
the first two are good and the third is not, conformity is not shown, which is no PASS. Without a declared stand nobody
knows an uncertainty: then PASS holds at the measured positions only.
"""

from __future__ import annotations

from dataclasses import dataclass

from tumble.defaults import DEFAULT_COVERAGE_FACTOR
from tumble.documents.result import Result
from tumble.rounding import on_its_side
from tumble.solving.assumptions import assumed, phrase
from tumble.solving.solution import Solution

GRAVITY, FIT, UNCERTAINTY = "gravity", "fit", "uncertainty"
_NAMES = {GRAVITY: "the gravity check", FIT: "the fit to the declared stand", UNCERTAINTY: "the uncertainty"}
PASS, NOT_SHOWN, FAIL = "PASS", "NOT SHOWN", "FAIL"
EVERYWHERE, AT_POSITIONS = "everywhere", "measured positions"


@dataclass(frozen=True)
class Decision:
    """`failures`: of GRAVITY, FIT and UNCERTAINTY, in this order; `assumes`: what the result rests on, by name;
    `positions`: how many were measured; `u_norm_g`: the worst standard uncertainty of |a|, None without a stand."""

    failures: tuple[str, ...]
    assumes: tuple[str, ...]
    positions: int
    limit_g: float
    coverage_factor: float
    u_norm_g: float | None

    @classmethod
    def of(cls, result: Result) -> Decision:
        """As a document tells it; one that is older than the rule stays as it was."""
        told, worst = result.decision, result.u_norm_g
        reason = result.pass_reason or (None if result.passed else GRAVITY)
        return cls(
            failures=() if reason is None else tuple(reason.split(" and ")),
            assumes=result.assumes,
            positions=len(result.verification.delta_g_g),
            limit_g=result.verification.limit_g,
            coverage_factor=DEFAULT_COVERAGE_FACTOR if told is None else told.coverage_factor,
            u_norm_g=(None if worst is None else worst.worst_g) if told is None else told.u_norm_worst_g,
        )

    @property
    def passed(self) -> bool:
        """Whether nothing fails."""
        return not self.failures

    @property
    def is_not_shown(self) -> bool:
        """Whether nothing but the uncertainty stands in the way."""
        return self.failures == (UNCERTAINTY,)

    @property
    def scope(self) -> str:
        """Where it holds."""
        return AT_POSITIONS if self.u_norm_g is None else EVERYWHERE

    @property
    def word(self) -> str:
        """In capitals."""
        return PASS if self.passed else NOT_SHOWN if self.is_not_shown else FAIL

    @property
    def reason(self) -> str:
        """What stands behind the word, beginning with what separates them; empty for a PASS that rests on nothing."""
        if self.is_not_shown:
            return f": {self.comparison}"
        if not self.passed:
            *others, last = (_NAMES.get(one, one) for one in self.failures)
            return f": {', '.join(others)} and {last}" if others else f": {last}"
        rests_on = phrase(self.assumes)
        return f"{self.where};{rests_on.removeprefix(',')}" if self.where and rests_on else self.where + rests_on

    @property
    def where(self) -> str:
        """Behind PASS without a stand; else empty, as it holds everywhere."""
        if self.scope == EVERYWHERE:
            return ""
        return f"{self.only}: no stand declared, no uncertainty elsewhere"

    @property
    def only(self) -> str:
        """Where a PASS holds, in short; empty for everywhere."""
        return "" if self.scope == EVERYWHERE else f" at the {self.positions} measured positions only"

    @property
    def comparison(self) -> str:
        """Of the uncertainty with the limit, such as "3 u(|a|) is up to 0.00045 g, limit 0.0003 g"."""
        if self.u_norm_g is None:
            return "no uncertainty, as no stand is declared"
        reach = self.coverage_factor * self.u_norm_g
        shown = on_its_side(reach, self.limit_g)
        limit = on_its_side(self.limit_g, float(shown), 6)
        return f"{self.coverage_factor:g} u(|a|) is up to {shown} g, limit {limit} g"

    @property
    def sentence(self) -> str:
        """Word and reason: the one form of the verdict, on a terminal, in a report, in an export."""
        return self.word + self.reason


def is_shown(limit_g: float, coverage_factor: float, u_norm_g: float | None) -> bool:
    """Whether the limit is met at every attitude, as far as a worst u(|a|) says; where nobody knows one, nothing is
    claimed."""
    return u_norm_g is None or coverage_factor * u_norm_g <= limit_g


def decide(solution: Solution) -> Decision:
    """By the rule."""
    u_norm_g = None if solution.u_norm is None else solution.u_norm.worst
    limit_g, factor = solution.limit_g, solution.coverage_factor
    good = {
        GRAVITY: solution.found.gravity.passed,
        FIT: solution.fit is None or solution.fit.fits,
        UNCERTAINTY: is_shown(limit_g, factor, u_norm_g),
    }
    failures = tuple(name for name, is_good in good.items() if not is_good)
    positions = int((solution.run.samples > 0).sum())
    return Decision(failures, tuple(assumed(solution)), positions, limit_g, factor, u_norm_g)
