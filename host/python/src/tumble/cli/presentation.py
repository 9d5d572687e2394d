"""What a person is told about a solution: the words and figures, whatever they are printed with."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass

import numpy as np

from tumble.api.complaints import complaint, consequence, named, noise_notice
from tumble.arrays import Floats
from tumble.cli import propagated
from tumble.estimators import COEFFICIENTS, HARMONIC
from tumble.files.rows import OF_ENVIRONMENT, OF_RUN_FILE
from tumble.fixture.judge import Limits
from tumble.model.fit import SYSTEMATIC
from tumble.model.stand_seen import NAMES, Estimate
from tumble.rounding import on_its_side
from tumble.schedule import CHECK
from tumble.solving.decision import ASSUMPTIONS, UNCERTAINTY, assumed, decide, in_words, marks, phrase, would_show
from tumble.solving.further import Further
from tumble.solving.solution import Solution
from tumble.solving.uncertainty import HANDS, NEARLY_INFINITE, PROBABILITY, Coverage
from tumble.terms import names
from tumble.units import noise_unit, per_g, volts_per

_HEADINGS = ("", "value", "unit", "std uncertainty", "relative", "vs numpy")
_HEADINGS_ALONE = ("", "value", "unit", "u, scatter alone", "relative", "vs numpy")
_HEADINGS_WITH_TRUTH = ("", "value", "unit", "u", "u, rel.", "vs numpy", "truth", "error/u")
_HINT = "For uncertainties, describe the stand: --stand FILE"
_HINT_ALONE = f"u contains noise only. {HANDS} To include errors of the stand, describe it: --stand FILE"
BAR_WIDTH = 36
_COLUMNS = 80
_UNKNOWN = "unknown"


@dataclass(frozen=True)
class GravityBar:
    """One position of the gravity check: `filled` of BAR_WIDTH cells, the limit standing in cell `limit`."""

    label: str
    use: str
    delta_g: str
    filled: int
    limit: int
    exceeds: bool


def title(solution: Solution, file: str) -> str:
    """What was solved, and how."""
    counters = solution.run.counters
    positions = f"{counters['positions']} of {len(solution.schedule.positions)} positions"
    model = f" with {', '.join(solution.found.terms)}" if solution.further is not None else ""
    return f"{file}: {counters['rows']} samples at {positions}, estimator {solution.found.estimator}{model}"


def coefficient_headings(solution: Solution) -> tuple[str, ...]:
    """One for each column of `coefficient_rows`."""
    if solution.truth is not None:
        return _HEADINGS_WITH_TRUTH
    return _HEADINGS if solution.scatter_alone is None else _HEADINGS_ALONE


def coefficient_rows(solution: Solution) -> list[tuple[str, ...]]:
    """The twelve coefficients: name, value, unit, standard uncertainty, the same relative, difference from numpy; of a
    simulated run also the true value, and the error (estimate less truth) over the standard uncertainty.

    An uncertainty is given over the scale of its row, K_ii: of K_ii itself in ppm, of a cross-axis sensitivity as the
    angle that it is, in urad, of U0 in ug. A name that ends in a mark rests on what `notes` say of it.
    """
    unit, rows = solution.run.unit, []
    shown = solution.scatter_alone or solution.stated
    marked = marks(assumed(solution))
    truth = solution.truth
    errors = None if truth is None else _errors_over_u(solution)
    decimals = max(0, min(12, 9 - math.floor(math.log10(np.abs(solution.found.k).max()))))
    for i, channel in enumerate("xyz"):
        for j, axis in enumerate("xyz"):
            u = None if shown is None else shown.u_k[i, j]
            relative = _ratio(u, solution.found.k[i, i], "ppm " if i == j else "urad")
            difference = _difference(solution.comparison.k[i, j])
            value = f"{solution.found.k[i, j]:+.{decimals}f}"
            known = () if truth is None or errors is None else _known(truth.k[i, j], errors[0][i, j], decimals)
            name = f"K_{channel}{axis}"
            rows.append((name + marked.get(name, ""), value, per_g(unit), _u(u), relative, difference, *known))
    for i, channel in enumerate("xyz"):
        u = None if shown is None else shown.u_u0[i]
        relative = _ratio(u, solution.found.k[i, i], "ug  ")
        difference = _difference(solution.comparison.u0[i])
        value = f"{solution.found.u0[i]:+.{decimals}f}"
        known = () if truth is None or errors is None else _known(truth.u0[i], errors[1][i], decimals)
        name = f"U0_{channel}"
        rows.append((name + marked.get(name, ""), value, unit, _u(u), relative, difference, *known))
    return rows + ([] if solution.further is None else _further_rows(solution.further, unit, decimals))


def _further_rows(further: Further, unit: str, decimals: int) -> list[tuple[str, ...]]:
    """The same of further terms of the model; an uncertainty in ug is that of an output in g, at 1 g."""
    rows: list[tuple[str, ...]] = []
    scales = np.tile(np.diag(further.k), len(further.terms))
    units = [{"k2": "1/g", "k3": "1/g^2"}.get(term, unit) for term in further.terms for _ in "xyz"]
    u = [None] * len(units) if further.u is None else further.u.ravel().tolist()
    differences = (further.difference * further.factors).ravel().tolist()
    for i, (name, value, its_unit) in enumerate(zip(names(further.terms), further.values.ravel(), units)):
        relative = _ratio(u[i], scales[i] if its_unit == unit else 1.0, "ug  ")
        rows.append((name, f"{value:+.{decimals}f}", its_unit, _u(u[i]), relative, _difference(differences[i])))
    return rows


def notes(solution: Solution) -> list[str]:
    """What marked coefficients, or all, rest on."""
    rests_on = {ASSUMPTIONS[name]: names for name, names in assumed(solution).items()}
    told = [
        f"{f'Values with {one.mark}' if names else 'All values'} assume {one.phrase}: {one.why}"
        for one, names in rests_on.items()
    ]
    return [line for one in told for line in textwrap.wrap(one, _COLUMNS, subsequent_indent="  ")]


def uncertainty_notes(solution: Solution) -> list[str]:
    """What uncertainties are made from, where that is not the stand file alone."""
    if solution.u_k is None:
        if solution.coverage is None:
            return [_HINT]
        return [*textwrap.wrap(_HINT_ALONE, _COLUMNS), _expanded(solution.coverage, "of the noise ")]
    told = noise_notice(solution)
    lines = [] if told is None else textwrap.wrap(f"u of {told}", 80, break_on_hyphens=False)
    return lines + ([] if solution.coverage is None else [_expanded(solution.coverage)])


def _expanded(coverage: Coverage, of: str = "") -> str:
    """By what factor u is to be multiplied, and where they differ, of which coefficient it is largest. `of`: what u
    holds, where that is not all."""
    k, freedom = coverage.factors, coverage.freedom
    least = int(freedom.argmin())
    low, high = f"{k.min():.2f}", f"{k.max():.2f}"
    line = f"{PROBABILITY * 100:.0f} % {of}within k u: k = {high if low == high else f'{low} to {high}'}"
    if freedom[least] > NEARLY_INFINITE:
        return line
    whose = "" if low == high else f"{COEFFICIENTS[least]}: "
    return f"{line} ({whose}{freedom[least]:.3g} degrees of freedom)"


def _errors_over_u(solution: Solution) -> tuple[Floats, Floats]:
    """Estimate less truth over the standard uncertainty: (3, 3) and (3,). A stand without errors leaves none: NaN."""
    truth, u_k, u_u0 = solution.truth, solution.u_k, solution.u_u0
    assert truth is not None and u_k is not None and u_u0 is not None  # who simulates a run declares its stand
    with np.errstate(divide="ignore", invalid="ignore"):
        of_k = (solution.found.k - truth.k) / u_k
        of_u0 = (solution.found.u0 - truth.u0) / u_u0
    return np.where(u_k > 0, of_k, np.nan), np.where(u_u0 > 0, of_u0, np.nan)


def _known(truth: float, error: float, decimals: int) -> tuple[str, str]:
    return f"{truth:+.{decimals}f}", "-" if math.isnan(error) else f"{error:+.2f}"


def _u(u: float | None) -> str:
    return _UNKNOWN if u is None else f"{u:.1e}"


def _difference(difference: float) -> str:
    return "0" if difference == 0.0 else f"{difference:.0e}"


def _ratio(u: float | None, of: float, millionths: str) -> str:
    if u is None or of == 0.0:
        return "-"
    ratio = abs(u / of) * 1e6
    if ratio >= 1e5:
        return f"{ratio:.0e} {millionths}"
    return f"{ratio:.0f} {millionths}" if ratio >= 100 else f"{ratio:.3g} {millionths}"


def gravity_title(solution: Solution) -> str:
    """What the bars show."""
    return f"Gravity check: delta_g in g at every position; | marks the limit, {solution.limit_g:g} g"


def gravity_bars(solution: Solution) -> list[GravityBar]:
    """One bar for each measured position, to one scale: the limit, or the largest error if that is larger."""
    full = max(float(np.nanmax(np.abs(solution.found.gravity.delta_g))), solution.limit_g) / BAR_WIDTH
    bars = []
    for position, delta_g in zip(solution.schedule.positions, solution.found.gravity.delta_g.tolist()):
        if not math.isnan(delta_g):
            filled = min(BAR_WIDTH, math.ceil(abs(delta_g) / full))
            limit = min(BAR_WIDTH, math.ceil(solution.limit_g / full))
            exceeds = abs(delta_g) > solution.limit_g
            bars.append(GravityBar(position.label, position.use, f"{delta_g:+.2e}", filled, limit, exceeds))
    return bars


def remarks(solution: Solution) -> list[str]:
    """Closure, residuals, the stand as the run shows it, what follows from the coefficients: one line each, where there
    is anything to say."""
    unit = solution.run.unit
    lines = _fit_and_check(solution)
    lines += [] if solution.truth is None else _truth_remarks(solution)
    lines += _temperature_line(solution)
    lines += [
        f"Closure of mounting {mounting}: {_three(difference)} {unit}"
        for mounting, difference in solution.found.closure.items()
    ]
    if solution.found.residual_rms is not None:
        yaw = " (yaw included)" if solution.found.estimator in HARMONIC else ""
        lines.append(f"Residuals, rms: {_three(solution.found.residual_rms)} {unit}{yaw}")
    if solution.fit is not None:
        freedom = f"{solution.fit.freedom} degrees of freedom"
        lines.append(f"Fit to the stand: chi-squared {solution.fit.chi_squared:.3g}, {freedom}, p {solution.fit.p:.2g}")
    return lines + _stand_remarks(solution) + propagated.remarks(solution)


def _temperature_line(solution: Solution) -> list[str]:
    """That of the run; no line where it is not known."""
    found = solution.run.temperature
    who = {OF_RUN_FILE: "run file", OF_ENVIRONMENT: "stand file"}
    return [] if found is None else [f"Temperature of the run: {found.text} ({who[found.source]})"]


def _stand_remarks(solution: Solution) -> list[str]:
    """What the run shows of every source, and what is declared of it: standard deviations."""
    seen, stand, unit = solution.stand_seen, solution.stand, solution.run.unit
    angles = {f"{name}_rad": seen.augmented[name] if one is None else one for name, one in seen.angles.items()}
    numbers = [mounting.number for mounting in solution.measured_schedule.fitted_mountings]
    told = [(NAMES[source], source, one) for source, one in angles.items()]
    if seen.other_yaw_changes:  # then each is named by its two mountings
        changes = {numbers[1]: angles["alpha3_difference_rad"], **seen.other_yaw_changes}
        told.pop()
        told += [(f"yaw {numbers[0]} - {other}", "alpha3_difference_rad", one) for other, one in changes.items()]
    told += [(NAMES[source], source, one) for source, one in (("alpha4_rad", seen.alpha4), ("noise_v", seen.noise))]
    declared = {} if stand is None else Limits.declared(stand, len(numbers)).sigma
    lines: list[str] = []
    for name, source, one in told:
        if one is not None:
            its_unit, factor = (noise_unit(unit), volts_per(unit)) if source == "noise_v" else ("rad", 1.0)
            has_u = seen.source is not None or source not in SYSTEMATIC
            measured = _measured(one, has_u, factor, " " if source not in SYSTEMATIC else "+")
            said = f"{measured} {its_unit}" + (f", declared {declared[source]:.2e}" if source in declared else "")
            if source == "noise_v" and solution.channel_noise is not None:
                said = solution.channel_noise.sentence(its_unit)
            begin = "" if lines else "Stand seen:"
            line = f"{begin:11} {name:11} {said}"
            lines += textwrap.wrap(line, _COLUMNS, subsequent_indent=" " * 24, break_on_hyphens=False)
    return lines


def _truth_remarks(solution: Solution) -> list[str]:
    errors, names = np.concatenate([part.ravel() for part in _errors_over_u(solution)]), coefficient_rows(solution)
    if np.isnan(errors).all():
        return []
    worst = int(np.nanargmax(np.abs(errors)))
    return [f"Largest error against the truth: {abs(errors[worst]):.2f} u, of {names[worst][0]}"]


def _fit_and_check(solution: Solution) -> list[str]:
    """The largest gravity errors apart, if the schedule has check positions: on fitted ones the check is optimistic."""
    planned = [index for index, position in enumerate(solution.schedule.positions) if position.use == CHECK]
    if not planned:
        return []
    measured = sum(int(solution.run.samples[index] > 0) for index in planned)
    gravity = solution.found.gravity
    largest = f"{gravity.max_abs_check:.2g} g" if measured else "unknown"
    where = f"check positions {largest} ({measured} of {len(planned)})"
    return [f"Largest gravity error: fitted {gravity.max_abs_fit:.2g} g, {where}", ""]


def _three(values: Floats) -> str:
    return "  ".join(f"{axis} {value:+.2e}" for axis, value in zip("xyz", values))


def _measured(seen: Estimate, has_u: bool, factor: float, sign: str) -> str:
    return f"{seen.value * factor:{sign}.2e}" + (f" +- {seen.u * factor:.1e}" if has_u else "")


def beware(solution: Solution) -> list[str]:
    """What `complaint` has to say, if anything: a paragraph, and an empty line."""
    text = complaint(solution)
    if text is None:
        return []
    warning = f"Beware: {text}. The uncertainties above {consequence(solution)}."
    return [*textwrap.wrap(warning, _COLUMNS, break_on_hyphens=False), ""]


def foremost(solution: Solution) -> list[str]:
    """What is said before all else, and an empty line: where a PASS without a stand holds."""
    decision = decide(solution)
    return [decision.word + decision.where, ""] if decision.passed and decision.where else []


def verdict(solution: Solution) -> str:
    """The decision and why, in one line if it fits."""
    worst = solution.worst_position
    size = f"{on_its_side(abs(float(solution.found.gravity.delta_g[worst])), solution.limit_g)} g"
    limit = f"limit {solution.limit_g:g} g"
    rest = f"{size} at {solution.schedule.positions[worst].label}, {limit}; numpy agrees"
    decision = decide(solution)
    if not decision.passed:
        largest = f"; largest gravity error {size}"
        told = f"{largest}. {_remedies(solution)}." if decision.is_not_shown else _failure(solution, largest)
        return textwrap.fill(decision.sentence + told, _COLUMNS, break_on_hyphens=False)
    condition = phrase(decision.assumes)
    passes = f"{decision.word}{decision.only}{condition}: "
    line = f"{passes}{rest}" if condition else f"{passes}largest gravity error {rest}"
    shorter = [line.removesuffix("; numpy agrees")]  # as the tables show, and the place
    if condition:
        shorter += [f"{passes}{size}, {limit}", f"{passes}{size[:-2]} <= {solution.limit_g:g} g"]
    return next((one for one in (line, *shorter) if len(one) <= _COLUMNS), textwrap.fill(shorter[-1], _COLUMNS))


def _remedies(solution: Solution) -> str:
    return in_words(would_show(solution), solution.limit_g)


def _failure(solution: Solution, largest: str) -> str:
    """What stands behind a failure. Where something explains it, it is named, and not the position with the largest
    error: an error at one position makes others look wrong."""
    decision = decide(solution)
    best = explained_best(solution)
    where = "" if best else f" at {solution.schedule.positions[solution.worst_position].label}"
    exceeds = UNCERTAINTY in decision.failures
    return f"{best}{largest}{where}" + (f"; {decision.comparison}" if exceeds else f", limit {solution.limit_g:g} g")


def explained_best(solution: Solution) -> str:
    """What explains the run best, to stand behind a failure; empty where nothing does."""
    if solution.fit is None or not solution.fit.explanations:
        return ""
    return f"; explained best by {named(solution.fit.explanations[0])}"
