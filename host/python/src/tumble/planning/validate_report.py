"""What a Monte Carlo campaign found: for JSON, and for people."""

from __future__ import annotations

from typing import Any

from tumble.estimators import COEFFICIENTS
from tumble.planning import tables
from tumble.planning.case import SCHEMA, Case
from tumble.planning.validate import COVERAGE_FACTORS, Validated
from tumble.planning.verdict import CHANCE_SIGMAS, COVERAGE_LIMITS, Judged, bias_limit, tolerance

_HONEST = (
    "PASS: the stated uncertainties are honest: every figure within its limits.\n"
    "Is the stand good enough for a limit? Ask tumble plan require."
)


def document(case: Case, found: list[tuple[Validated, Judged]], seed: int, table: str) -> dict[str, Any]:
    """The campaign for JSON, schema tumble.plan/1. Arrays run over `names`."""
    runs = found[0][0].tally.runs
    return {
        "schema": SCHEMA,
        "plan": "validate",
        "stand": case.stand.name,
        "block": {"scale_v_per_g": case.scale, "misalignment_rad": case.misalignment},
        "runs": runs,
        "seed": seed,
        "table": table,
        **({"model": list(case.terms)} if case.terms else {}),
        "names": list(COEFFICIENTS),
        "limits": {
            "bias_over_u": bias_limit(runs),
            "spread_over_u": [1.0 - tolerance(runs), 1.0 + tolerance(runs)],
            "efficiency_of_optimal": 1.0 - tolerance(runs),
            "coverage": {str(factor): list(limits) for factor, limits in COVERAGE_LIMITS.items()},
            "binomial_sigmas": CHANCE_SIGMAS,
        },
        "estimators": {one.estimator: _figures(one, judged) for one, judged in found},
        "pass": not any(judged.outside for _, judged in found),
    }


def _figures(found: Validated, judged: Judged) -> dict[str, Any]:
    return {
        "u": found.u.tolist(),
        "bound": found.bound.tolist(),
        "bias_over_u": judged.bias_over_u.tolist(),
        "spread_over_u": judged.spread_over_u.tolist(),
        "efficiency": judged.efficiency.tolist(),
        "coverage": {
            str(factor): {name: rows[row].tolist() for name, rows in _binomial(judged).items()}
            for row, factor in enumerate(COVERAGE_FACTORS)
        },
        "outside": judged.outside,
        "promise": found.promise.document(),
        "simulated": {name: count / found.tally.runs for name, count in _kept(found).items()},
    }


def _kept(found: Validated) -> dict[str, int]:
    return {"passes": found.tally.passed, "every_attitude": found.tally.everywhere}


def _binomial(judged: Judged) -> dict[str, Any]:
    return {"covered": judged.covered, "low": judged.low, "high": judged.high}


def show(case: Case, found: list[tuple[Validated, Judged]], seed: int) -> None:
    """Print the campaign on standard output."""
    out, runs = tables.console(), found[0][0].tally.runs
    out.print(tables.heading(f"Monte Carlo: {runs} runs of the firmware's estimators, seed {seed}"))
    out.print(f"Stand: {case.stand.name or 'without a name'}")
    if case.terms:
        out.print(f"Beside the twelve coefficients each run finds {', '.join(case.terms)}")
    headings = ("", "u planned", "bias/u", "spread/u", "bound/spread", "k = 1", "k = 2", "k = 3")
    for one, judged in found:
        out.print(tables.heading(f"\n{one.estimator}"))
        out.print(tables.table(headings, [_row(one, judged, index) for index in range(len(COEFFICIENTS))]))
        out.print(_promised(one))
        for complaint in judged.outside:
            out.print(f"Outside: {complaint}", style="red")
    out.print("k = 1, 2, 3: % of runs within k of their own stated standard uncertainties")
    outside = sum(len(judged.outside) for _, judged in found)
    verdict = f"FAIL: {outside} figures lie outside their limits" if outside else _HONEST
    out.print(verdict, style="red bold" if outside else "green bold")


def _promised(found: Validated) -> str:
    """Beside what was simulated, with its standard error."""
    runs, promised = found.tally.runs, found.promise
    shares = {name: count / runs for name, count in _kept(found).items()}
    seen = {name: f"{100 * p:.1f} +- {100 * (p * (1 - p) / runs) ** 0.5:.1f} %" for name, p in shares.items()}
    return (
        f"{promised.limit_g:g} g: passes the gravity check {tables.percent(promised.passes.value)}"
        f" (seen {seen['passes']}),\n"
        f"|a| within it at every attitude {tables.percent(promised.everywhere.value)} (seen {seen['every_attitude']})"
        f"{promised.condition}"
    )


def _row(found: Validated, judged: Judged, index: int) -> tuple[str, ...]:
    covered = (f"{100 * judged.covered[row, index]:.2f}" for row in range(len(COVERAGE_FACTORS)))
    return (
        COEFFICIENTS[index],
        f"{found.u[index]:.3e}",
        f"{judged.bias_over_u[index]:+.3f}",
        f"{judged.spread_over_u[index]:.4f}",
        f"{judged.efficiency[index]:.4f}",
        *covered,
    )
