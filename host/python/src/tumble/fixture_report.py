"""What a fixture check found, as a document of schema tumble.fixture/1 and as text."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any

from tumble.combination import Combination
from tumble.fixture import NEED_SIGMAS, SYSTEMATIC, Judgement, Limits, RunView, Verdict
from tumble.solving import stand_seen
from tumble.solving.result import per_g
from tumble.solving.stand_seen import NAMES
from tumble.stand import Stand, noise_unit, volts_per

SCHEMA = "tumble.fixture/1"
DECLARED = "declared"
_HEADINGS = ("", "seen", "u", "declared", "verdict", "needed", "verdict")
_WIDTH = 80


@dataclass(frozen=True)
class Outcome:
    """A finished check. `against`: "declared" or "needed", which the verdict goes by; `needed`, `needs`: the limits
    that the acceptance limit asks for and their verdicts, None where nothing is known of the block; `combined`: None
    for one run."""

    stand: Stand
    views: list[RunView]
    judged: dict[str, Judgement]
    needed: Limits | None
    needs: dict[str, Verdict] | None
    against: str
    limit_g: float
    confidence: float
    levelled: str
    combined: Combination | None

    def limit(self, source: str) -> float | None:
        """What the verdict goes by: a standard deviation, or three of them; None: no limit."""
        return self.judged[source].limit if self.against == DECLARED else self._needed_limit(source)

    def verdict(self, source: str) -> Verdict:
        """Of a source, by its limit."""
        return self.judged[source].verdict if self.against == DECLARED else self.needs[source]

    @property
    def gravity_failures(self) -> list[str]:
        """Files of the runs that fail the gravity check."""
        return [view.file for view in self.views if not view.solution.found.gravity.passed]

    def sources_with(self, verdict: Verdict) -> list[str]:
        """Names, for people, of the sources with this verdict."""
        return [name for source, name in NAMES.items() if self.verdict(source) is verdict]

    @property
    def passed(self) -> bool:
        """Nothing exceeds its limit, and every run passes the gravity check."""
        return not self.gravity_failures and not self.sources_with(Verdict.DOES_NOT_MEET)

    def _needed_limit(self, source: str) -> float | None:
        sigma = self.needed.sigma[source]
        factor = NEED_SIGMAS if source in SYSTEMATIC else 1.0
        return factor * sigma if math.isfinite(sigma) else None

    def need(self, source: str) -> dict[str, Any] | None:
        """Limit and verdict by what the acceptance limit needs."""
        if self.needs is None:
            return None
        return {"limit": self._needed_limit(source), "verdict": self.needs[source].value}


def document(outcome: Outcome) -> dict[str, Any]:
    """Ready for JSON."""
    return {
        "schema": SCHEMA,
        "stand": outcome.stand.name,
        "confidence": outcome.confidence,
        "against": outcome.against,
        "levelled": outcome.levelled,
        "delta_g_limit_g": outcome.limit_g,
        "runs": [_run(view) for view in outcome.views],
        "sources": {source: _source(outcome, source) for source in NAMES},
        "combined": None if outcome.combined is None else _combined(outcome),
        "pass": outcome.passed,
    }


def _run(view: RunView) -> dict[str, Any]:
    unit = view.solution.run.unit
    judged = view.solution.found.gravity
    largest = max(value for value in (judged.max_abs_fit, judged.max_abs_check) if value is not None)
    seen = stand_seen.document(view.seen, volts_per(unit))
    return {"file": view.file, "pass": judged.passed, "max_abs_delta_g_g": largest, "stand_seen": seen}


def _source(outcome: Outcome, source: str) -> dict[str, Any]:
    judged = outcome.judged[source]
    return {
        "value": judged.value,
        "u": judged.u,
        "limit": outcome.limit(source),
        "verdict": outcome.verdict(source).value,
        "chi_squared": judged.chi_squared,
        "freedom": judged.freedom,
        "sigma_low": judged.low,
        "sigma_high": judged.high,
        "declared": {"limit": judged.limit, "verdict": judged.verdict.value},
        "needed": outcome.need(source),
    }


def _combined(outcome: Outcome) -> dict[str, Any]:
    combined, unit = outcome.combined, outcome.views[0].solution.run.unit
    values = {"K": combined.k, "U0": combined.u0, "u_K": combined.u_k, "u_U0": combined.u_u0}
    return {
        "units": {"K": per_g(unit), "U0": unit},
        **{name: value.tolist() if combined.consistent else None for name, value in values.items()},
        "chi_squared": combined.chi_squared,
        "freedom": combined.freedom,
        "chi_squared_limit": combined.limit,
        "consistent": combined.consistent,
    }


def render(outcome: Outcome) -> str:
    """For people, within 80 columns; the last paragraph is the verdict in one sentence."""
    lines = [_title(outcome), "", *_table(outcome), "", *_notes(outcome), ""]
    if outcome.combined is not None:
        lines += [*_combined_lines(outcome), ""]
    return "\n".join([*lines, *_wrapped(_sentence(outcome))]) + "\n"


def _title(outcome: Outcome) -> str:
    count = len(outcome.views)
    runs = os.path.basename(outcome.views[0].file) if count == 1 else f"{count} runs"
    return f"Fixture check: {runs} against {outcome.stand.name or 'the stand'}"[:_WIDTH]


def _table(outcome: Outcome) -> list[str]:
    rows = [_HEADINGS if outcome.needs is not None else _HEADINGS[:5]]
    rows += [_row(outcome, source) for source in NAMES]
    widths = [max(map(len, column)) for column in zip(*rows)]
    aligned = [str.ljust, str.rjust, str.rjust, str.rjust, str.ljust, str.rjust, str.ljust]
    return ["  ".join(fit(cell, width) for fit, cell, width in zip(aligned, row, widths)).rstrip() for row in rows]


def _row(outcome: Outcome, source: str) -> tuple[str, ...]:
    judged, need = outcome.judged[source], outcome.need(source)
    sign = "+" if source in SYSTEMATIC and judged.freedom == 1 else ""
    seen = "-" if judged.value is None else f"{judged.value:{sign}.2e}"
    u = "-" if judged.u is None else f"{judged.u:.1e}"
    row = (NAMES[source], seen, u, f"{judged.limit:.1e}", judged.verdict.value)
    if need is None:
        return row
    return (*row, "-" if need["limit"] is None else f"{need['limit']:.1e}", need["verdict"])


def _notes(outcome: Outcome) -> list[str]:
    unit = noise_unit(outcome.views[0].solution.run.unit)
    percent = f"{100 * outcome.confidence:g} %"
    notes = [
        f"Angles in rad, noise of a sample in {unit}. Declared: standard deviations. Confidence of all verdicts"
        f" together: {percent}."
    ]
    if outcome.needs is not None:
        notes.append(
            f"Needed: for a gravity error of {outcome.limit_g:g} g, shared equally; of axis tilt, level and yaw what"
            " they may be now (three standard deviations), of set angle and noise the standard deviation."
        )
    return [line for note in notes for line in _wrapped(note)]


def _combined_lines(outcome: Outcome) -> list[str]:
    combined, unit = outcome.combined, outcome.views[0].solution.run.unit
    square = (
        f"chi-squared {combined.chi_squared:.1f}, {combined.freedom} degrees of freedom, limit {combined.limit:.1f}"
    )
    if not combined.consistent:
        return _wrapped(
            f"The runs do not agree ({square}): they are not of one block, or not of this stand as declared and"
            f" levelled {outcome.levelled} (--levelled). There is no combined result."
        )
    lines = [f"Combined of {len(outcome.views)} runs, stand levelled {outcome.levelled}:"]
    names = [f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"]
    values = [*combined.k.ravel().tolist(), *combined.u0.tolist()]
    uncertainties = [*combined.u_k.ravel().tolist(), *combined.u_u0.tolist()]
    for name, value, u in zip(names, values, uncertainties):
        lines.append(f"  {name}  {value:+.9f}  {u:.1e}  {per_g(unit) if name.startswith('K') else unit}")
    return [*lines, f"The runs agree: {square}"]


def _sentence(outcome: Outcome) -> str:
    runs = "this run" if len(outcome.views) == 1 else f"these {len(outcome.views)} runs"
    asked = "what the stand declares" if outcome.against == DECLARED else f"what {outcome.limit_g:g} g needs"
    missed, open_ = (outcome.sources_with(v) for v in (Verdict.DOES_NOT_MEET, Verdict.CANNOT_TELL))
    failed = outcome.gravity_failures
    apart = "" if outcome.combined is None or outcome.combined.consistent else "; the runs do not agree with each other"
    if outcome.passed:
        decided = len(open_) < len(NAMES)
        rest = f", which cannot tell {_listed(open_)}" if open_ and decided else ""
        rest += "" if decided else ", which cannot tell anything yet; more runs can (docs/method.md, Fixture check)"
        return f"PASS{'' if decided else ', not conclusive'}: nothing exceeds {asked} in {runs}{rest}{apart}."
    faults = [f"{_listed(missed)} {'does' if len(missed) == 1 else 'do'} not meet {asked}"] if missed else []
    faults += [f"the gravity check fails in {_listed(failed)}"] if failed else []
    return f"FAIL: {' and '.join(faults)}{apart}."


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def _wrapped(text: str) -> list[str]:
    lines = [""]
    for word in text.split(" "):
        if lines[-1] and len(lines[-1]) + 1 + len(word) > _WIDTH:
            lines.append("")
        lines[-1] += f" {word}" if lines[-1] else word
    return lines
