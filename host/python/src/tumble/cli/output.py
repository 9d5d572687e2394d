"""What a command says of a solution: as JSON, as plain ASCII, or on a terminal.

`page` makes the one page for people: the verdict, the coefficients, a line for each check; with details every position
and what the run shows of the stand. It consists of lines, each of pieces of text with the style that a terminal shows
them in, and of the table of coefficients. Plain text leaves the styles away; rich draws them.
"""

from __future__ import annotations

import math
import os
import sys
import textwrap
from dataclasses import dataclass

import numpy as np
from msgspec import UnsetType

from tumble.api.solving import misfit_consequence, misfit_sentence, named, noise_notice, simulation_complaint
from tumble.arrays import Floats
from tumble.documents.result import Truth
from tumble.errors import listed
from tumble.estimators import COEFFICIENTS, HARMONIC
from tumble.files.rows import OF_ENVIRONMENT, OF_RUN_FILE
from tumble.fixture.judge import Limits
from tumble.messages import signed_for
from tumble.model import reliability
from tumble.model.fit import SYSTEMATIC
from tumble.model.stand_seen import NAMES, Estimate
from tumble.model.thermal import Polynomials
from tumble.schedule import CHECK
from tumble.solving.decision import (
    ASSUMPTIONS,
    UNCERTAINTY,
    Decision,
    assumed,
    decide,
    marks,
    phrase,
    remedies_text,
    would_show,
)
from tumble.solving.many_runs import NORMAL_COVERAGE, MonteCarlo
from tumble.solving.prior import test_text
from tumble.solving.solution import Solution
from tumble.solving.uncertainty import HANDS, NEARLY_INFINITE, PROBABILITY, Coverage, ExtendedTerms
from tumble.terms import UNITS_OF_VALUES, model_of, names
from tumble.units import noise_unit, on_its_side, per_g, volts_per

_COLUMNS = 80  # a narrower terminal wraps lines, which loses nothing
_BAR_WIDTH = 36
_LOSS = 1.05  # of an uncertainty, before it is spoken of
_DETAILS_HINT = "numpy agrees; --details shows every position, residuals, the stand seen and more"
_HINT = "For uncertainties, describe the stand: --stand FILE"
_HINT_ALONE = f"u contains noise only. {HANDS} To include errors of the stand, describe it: --stand FILE"

Line = list[tuple[str, str]]  # of pieces: a text, and its style on a terminal


@dataclass(frozen=True)
class Table:
    """Rows as long as `headings`."""

    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]


def print_solution(solution: Solution, json_text: str | None, title: str, with_details: bool) -> None:
    """As JSON, or for people. `title`: what was solved."""
    if json_text is not None:
        sys.stdout.write(json_text)
    else:
        print_lines(page(solution, title, with_details))


def print_lines(lines: list[Line | Table]) -> None:
    """With rich on a terminal."""
    if sys.stdout.isatty():
        _show(lines)
    else:
        sys.stdout.write(_plain_text(lines))


def _plain_text(lines: list[Line | Table]) -> str:
    """Within 80 columns as long as the file's name and the numbers are of ordinary size. Columns of a table are as wide
    as need be, the first and the unit to the left, numbers to the right."""
    text: list[str] = []
    for line in lines:
        if isinstance(line, Table):
            rows = [line.headings, *line.rows]
            widths = [max(map(len, column)) for column in zip(*rows)]
            text.append("")
            for row in rows:
                padded = [f"{one:{'<' if i in (0, 2) else '>'}{widths[i]}}" for i, one in enumerate(row)]
                text.append("  ".join(padded).rstrip())
        else:
            text.append("".join(piece for piece, _ in line).rstrip())
    return "\n".join(text) + "\n"


def _show(lines: list[Line | Table]) -> None:
    """On a terminal. Colours heed NO_COLOR; a terminal without Unicode gets ASCII."""
    from rich import box, table
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False)
    console.width = max(console.width, _COLUMNS)
    block = "#" if console.options.ascii_only else "\u2588"
    for line in lines:
        if isinstance(line, Table):
            shown = table.Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="dim")
            for heading in line.headings:
                shown.add_column(heading, justify="left" if heading in ("", "unit") else "right", no_wrap=True)
            for row in line.rows:
                styles = {"": "bold", "value": "cyan", "vs numpy": "dim"}
                cells = zip(row, line.headings)
                shown.add_row(*(Text(signed_for(one, sys.stdout), styles.get(name, "")) for one, name in cells))
            console.print(shown)
        elif len(line) == 1:
            [(text, style)] = line
            console.print(Text(signed_for(text, sys.stdout), style))
        else:  # a bar
            pieces = [(piece.replace("#", block), style) for piece, style in line]
            console.print(Text.assemble(*pieces), no_wrap=True, overflow="crop")


def page(solution: Solution, file: str, with_details: bool) -> list[Line | Table]:
    """All that a person is told of a solution, from top to bottom. `file`: what was solved."""
    decision, counters = decide(solution), solution.run.counters
    model = f" with {', '.join(model_of(solution.found.terms))}" if solution.extended_terms is not None else ""
    positions = f"{counters['positions']} of {len(solution.schedule.positions)} positions"
    solved = f"{file}: {counters['rows']} samples at {positions}, estimator {solution.found.estimator}{model}"
    why = misfit_sentence(solution)
    warning = "" if why is None else f"Beware: {why}. The uncertainties below {misfit_consequence(solution)}."
    bewares = [*textwrap.wrap(warning, _COLUMNS, break_on_hyphens=False), ""] if warning else []
    if solution.prior is not None and (changed := solution.prior.finding) is not None:
        bewares += [*textwrap.wrap(f"Beware: {changed}. The prior is not used.", _COLUMNS, break_on_hyphens=False), ""]
    colour = "green" if decision.passed and not decision.where else "yellow"
    if not decision.passed and not decision.is_not_shown:
        colour = "red"
    return [
        [(_verdict_line(solution, decision), f"{colour} bold")],
        [("", "")],
        *([(line, "yellow")] for line in bewares),
        [(solved, "bold")],
        Table(*coefficient_table(solution, with_details)),
        *([(line, "yellow")] for line in notes(solution) + uncertainty_notes(solution)),
        [("", "")],
        *(_details(solution) if with_details else [[(line, "")] for line in checks(solution)]),
    ]


def _details(solution: Solution) -> list[Line]:
    limit = f"| marks the limit, {solution.limit_g:g} g"
    return [
        [(f"Gravity check: delta_g in g at every position; {limit}", "bold")],
        *_gravity_bars(solution),
        [("", "")],
        *([(line, "")] for line in remarks(solution)),
    ]


def coefficient_table(solution: Solution, with_details: bool) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and rows of the twelve coefficients: name, value, unit, standard uncertainty, the same relative; with
    details the difference from numpy; of a simulated run also the true value, and the error (estimate less truth) over
    the standard uncertainty. Then the same of further terms of the model.

    An uncertainty is given over the scale of its row, K_ii: of K_ii itself in ppm, of a cross-axis sensitivity as the
    angle that it is, in urad, of U0 in ug; of a further term in ug, as that of an output in g, at 1 g. Of a channel
    that measures along another axis, which has no such scale, it is left out. A name that ends in a mark rests on what
    `notes` say of it.
    """
    u_named = "std uncertainty" if solution.scatter_alone is None else "u, scatter alone"
    unit, found, shown = solution.run.unit, solution.found, solution.scatter_alone or solution.stated
    marked = marks(assumed(solution))
    scale = np.where(np.abs(found.k).argmax(axis=1) == np.arange(3), np.diag(found.k), 0.0)
    decimals = max(0, min(12, 9 - math.floor(math.log10(np.abs(found.k).max()))))
    values = _twelve(found.k, found.u0)
    units = [per_g(unit)] * 9 + [unit] * 3
    u: list[float | None] = [None] * 12 if shown is None else [*_twelve(shown.u_k, shown.u_u0)]
    scales = [*np.repeat(scale, 3).tolist(), *scale.tolist()]
    millionths = ["ppm ", "urad", "urad", "urad", "ppm ", "urad", "urad", "urad", "ppm ", *["ug  "] * 3]
    differences = _twelve(solution.comparison.k, solution.comparison.u0)
    if solution.extended_terms is not None:
        extended = solution.extended_terms
        of_terms = [UNITS_OF_VALUES.get(term, unit) for term in extended.terms for _ in "xyz"]
        values += extended.values.ravel().tolist()
        units += of_terms
        u += [None] * len(of_terms) if extended.u is None else extended.u.ravel().tolist()
        sizes = np.tile(np.diag(extended.k), len(extended.terms))
        scales += [size if its_unit == unit else 1.0 for size, its_unit in zip(sizes, of_terms)]
        millionths += ["ug  "] * len(of_terms)
        differences += (extended.difference * extended.factors).ravel().tolist()
    rows: list[tuple[str, ...]] = [
        (
            name + marked.get(name, ""),
            f"{values[i]:+.{decimals}f}",
            units[i],
            "unknown" if u[i] is None else f"{u[i]:.1e}",
            _relative(u[i], scales[i], millionths[i]),
        )
        for i, name in enumerate(COEFFICIENTS + names(found.terms if solution.extended_terms is not None else ()))
    ]
    headings: tuple[str, ...] = ("", "value", "unit", u_named, "relative")
    if with_details:
        headings += ("vs numpy",)
        rows = [(*row, "0" if d == 0.0 else f"{d:.0e}") for row, d in zip(rows, differences)]
    if solution.truth is not None:
        headings = ("", "value", "unit", "u", "u, rel.", *headings[5:], "truth", "error/u")
        known = zip(_twelve(*_truth_of_run(solution.truth, solution)), _errors_over_u(solution).tolist())
        for i, (true, error) in enumerate(known):
            rows[i] += (f"{true:+.{decimals}f}", "-" if math.isnan(error) else f"{error:+.2f}")
    return headings, rows


def _twelve(k: Floats, u0: Floats) -> list[float]:
    """In the order of COEFFICIENTS."""
    return [*k.ravel().tolist(), *u0.tolist()]


def _relative(u: float | None, of: float, millionths: str) -> str:
    if u is None or of == 0.0:
        return "-"
    ratio = abs(u / of) * 1e6
    if ratio >= 1e5:
        return f"{ratio:.0e} {millionths}"
    return f"{ratio:.0f} {millionths}" if ratio >= 100 else f"{ratio:.3g} {millionths}"


def _truth_of_run(truth: Truth, solution: Solution) -> tuple[Floats, Floats]:
    """K and U0 in the middle of the temperatures of the run, of a block that changes with its temperature."""
    warm, felt = truth.over_temperature, solution.run.temperature
    if isinstance(warm, UnsetType) or felt is None:
        return truth.K, truth.U0
    polynomials = Polynomials(warm.reference_c, np.array(warm.K), np.array(warm.U0))
    return polynomials.at((felt.low_c + felt.high_c) / 2.0)


def _errors_over_u(solution: Solution) -> Floats:
    """Estimate less truth over the standard uncertainty (12,). A stand without errors leaves none: NaN."""
    truth, u_k, u_u0 = solution.truth, solution.u_k, solution.u_u0
    assert truth is not None and u_k is not None and u_u0 is not None  # who simulates a run declares its stand
    u = np.concatenate([u_k.ravel(), u_u0])
    k, u0 = _truth_of_run(truth, solution)
    errors = np.concatenate([(solution.found.k - k).ravel(), solution.found.u0 - u0])
    over: Floats = np.divide(errors, u, out=np.full(12, np.nan), where=u > 0)
    return over


def notes(solution: Solution) -> list[str]:
    """What marked coefficients, or all, rest on."""
    lines: list[str] = []
    for name, coefficients in assumed(solution).items():
        one = ASSUMPTIONS[name]
        whose = f"Values with {one.mark}" if coefficients else "All values"
        lines += textwrap.wrap(f"{whose} assume {one.phrase}: {one.why}", _COLUMNS, subsequent_indent="  ")
    return lines


def uncertainty_notes(solution: Solution) -> list[str]:
    """What uncertainties are made from, where that is not the stand file alone."""
    if solution.u_k is None:
        if solution.coverage is None:
            return [_HINT]
        return [*textwrap.wrap(_HINT_ALONE, _COLUMNS), _expanded(solution.coverage, "of the noise ")]
    told = noise_notice(solution)
    lines = [] if told is None else textwrap.wrap(f"u of {told}", _COLUMNS, break_on_hyphens=False)
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


def _gravity_bars(solution: Solution) -> list[Line]:
    """One for each measured position, to one scale: the limit, or the largest error if that is larger."""
    limit_g, bars = solution.limit_g, []
    full = max(float(np.nanmax(np.abs(solution.found.gravity.delta_g))), limit_g) / _BAR_WIDTH
    limit = min(_BAR_WIDTH, math.ceil(limit_g / full))
    for position, delta_g in zip(solution.schedule.positions, solution.found.gravity.delta_g.tolist()):
        if not math.isnan(delta_g):
            cells = ("#" * min(_BAR_WIDTH, math.ceil(abs(delta_g) / full))).ljust(_BAR_WIDTH)
            exceeds = abs(delta_g) > limit_g
            colour = "red" if exceeds else "green"
            bars.append([
                (f"{position.label:>6}  {position.use:<5}  {delta_g:+.2e}  ", ""),
                (cells[:limit], colour),
                ("|", "bold"),
                (cells[limit:], colour),
                ("  over" if exceeds else "", colour),
            ])  # fmt: skip
    return bars


def checks(solution: Solution) -> list[str]:
    """One line for each check, and what follows from the coefficients."""
    found, unit = solution.found, solution.run.unit
    position = solution.schedule.positions[solution.worst_position].label
    size = on_its_side(abs(float(found.gravity.delta_g[solution.worst_position])), solution.limit_g)
    lines = [f"Gravity check: largest error {size} g at {position}, limit {solution.limit_g:g} g"]
    lines += _check_positions(solution)
    if found.closure:
        number, largest = max(found.closure.items(), key=lambda one: float(np.abs(one[1]).max()))
        axis = int(np.abs(largest).argmax())
        size = f"{abs(largest[axis]):.2g} {unit}"
        lines.append(f"Closure: largest difference {size}, {'xyz'[axis]} of mounting {number}")
    lines += [*_set_angles(solution), *_fit(solution), *_prior(solution), *_truth_and_temperature(solution)]
    lines += _inclinations(solution)
    return [*lines, *_consequences(solution), _DETAILS_HINT]


def remarks(solution: Solution) -> list[str]:
    """Closure, residuals, the stand as the run shows it, what follows from the coefficients: one line each, where there
    is anything to say."""
    found, unit = solution.found, solution.run.unit
    lines = [*_check_positions(solution), *_truth_and_temperature(solution)]
    lines += [f"Closure of mounting {one}: {_three(difference)} {unit}" for one, difference in found.closure.items()]
    if found.residual_rms is not None:
        yaw = " (yaw included)" if found.estimator in HARMONIC else ""
        lines.append(f"Residuals, rms: {_three(found.residual_rms)} {unit}{yaw}")
    lines += [*_set_angles(solution), *_fit(solution), *_prior(solution), *_stand_seen(solution)]
    lines += _inclinations(solution)
    return [*lines, *_intrinsic(solution), *_consequences(solution)]


def _set_angles(solution: Solution) -> list[str]:
    if (table := solution.set_angles) is None or solution.stand is None:
        return []
    left = 1e6 * solution.stand.sigma("angle")
    return [f"Set angles: corrected by the table of {table.learned} ({table.runs} runs), to {left:.2g} urad"]


def _check_positions(solution: Solution) -> list[str]:
    """Their errors are told apart: on fitted positions the gravity check is optimistic."""
    gravity = solution.found.gravity
    indices = [index for index, position in enumerate(solution.schedule.positions) if position.use == CHECK]
    if not indices:
        return []
    measured = sum(int(solution.run.samples[index] > 0) for index in indices)
    largest = f"{gravity.max_abs_check:.2g} g" if measured else "unknown"
    fitted = f"fitted {gravity.max_abs_fit:.2g} g"
    return [f"Largest gravity error: {fitted}, check positions {largest} ({measured} of {len(indices)})"]


def _truth_and_temperature(solution: Solution) -> list[str]:
    """What the run is held against, or was made at: the truth of a simulated one, its temperature."""
    lines: list[str] = []
    if solution.truth is not None and not np.isnan(errors := np.abs(_errors_over_u(solution))).all():
        worst = int(np.nanargmax(errors))
        lines.append(f"Largest error against the truth: {errors[worst]:.2f} u, of {COEFFICIENTS[worst]}")
    if (temperature := solution.run.temperature) is not None:
        who = {OF_RUN_FILE: "run file", OF_ENVIRONMENT: "stand file"}[temperature.source]
        lines.append(f"Temperature of the run: {temperature.text} ({who})")
    return lines


def _fit(solution: Solution) -> list[str]:
    if (fit := solution.fit) is None:
        return []
    freedom = f"{fit.freedom} degrees of freedom"
    return [f"Fit to the stand: chi-squared {fit.chi_squared:.3g}, {freedom}, p {fit.p:.2g}"]


def _prior(solution: Solution) -> list[str]:
    """What a prior brings, or why it does not."""
    if (told := solution.prior) is None:
        return []
    prior = told.prior
    said = f"Prior: {os.path.basename(prior.source)}, {prior.days:.0f} days earlier, "
    said += "agrees" if told.used else "NOT USED"
    lines = [f"{said}: {test_text(told.test)}"]
    if told.used and solution.u_norm is not None:
        alone = "unknown" if told.u_norm_alone_g is None else f"{told.u_norm_alone_g * 1e6:.3g}"
        sizes = f"prior {prior.worst_norm.worst_g * 1e6:.3g}, run {alone}, both {solution.u_norm.worst_g * 1e6:.3g} ug"
        lines.append(f"Worst u(|a|) of each: {sizes}")
    if told.undetermined:
        lines.append(f"The run alone does not determine {listed(told.undetermined)}: they rest on the prior")
    wrapped = [textwrap.wrap(one, _COLUMNS, subsequent_indent="  ", break_on_hyphens=False) for one in lines]
    return [line for one in wrapped for line in one]


def _three(values: Floats) -> str:
    return "  ".join(f"{axis} {value:+.2e}" for axis, value in zip("xyz", values))


def _stand_seen(solution: Solution) -> list[str]:
    """What the run shows of every source, and what is declared of it: standard deviations."""
    seen, stand, unit = solution.stand_seen, solution.stand, solution.run.unit
    angles = {f"{name}_rad": seen.augmented[name] if one is None else one for name, one in seen.angles.items()}
    numbers = [mounting.number for mounting in solution.measured_schedule.fitted_mountings]
    told: list[tuple[str, str, Estimate | None]] = [(NAMES[source], source, one) for source, one in angles.items()]
    if seen.other_yaw_changes:  # then each is named by its two mountings
        changes = {numbers[1]: angles["alpha3_difference_rad"], **seen.other_yaw_changes}
        told.pop()
        told += [(f"yaw {numbers[0]} - {other}", "alpha3_difference_rad", one) for other, one in changes.items()]
    told += [(NAMES[source], source, one) for source, one in (("alpha4_rad", seen.alpha4), ("noise_v", seen.noise))]
    declared = {} if stand is None else Limits.declared(stand, len(numbers)).sigma
    lines: list[str] = []
    for name, source, one in told:
        if one is None:
            continue
        its_unit, factor = (noise_unit(unit), volts_per(unit)) if source == "noise_v" else ("rad", 1.0)
        systematic = source in SYSTEMATIC
        said = f"{one.value * factor:{'+' if systematic else ' '}.2e}"
        said += f" +- {one.u * factor:.1e}" if seen.source is not None or not systematic else ""
        said += f" {its_unit}" + (f", declared {declared[source]:.2e}" if source in declared else "")
        if source == "noise_v" and solution.channel_noise is not None:
            said = solution.channel_noise.sentence(its_unit)
        line = f"{'' if lines else 'Stand seen:':11} {name:11} {said}"
        lines += textwrap.wrap(line, _COLUMNS, subsequent_indent=" " * 24, break_on_hyphens=False)
    return lines


def _inclinations(solution: Solution) -> list[str]:
    """Of a block that is bolted on once, how its axis stood in each mounting."""
    seen, u = solution.inclinations, solution.u_inclinations
    if seen is None:
        return []
    set_at = {one.number: one.tilt_deg for one in solution.schedule.mountings}
    lines: list[str] = []
    for index, (number, beta) in enumerate(zip(seen.numbers, np.rad2deg(seen.beta))):
        sure = "" if u is None else f" +- {np.rad2deg(u[index]):.4f}"
        lines.append(
            f"{'' if lines else 'Inclined:':11} mounting {number:<2} {beta:+9.4f}{sure} deg, set to {set_at[number]:g}"
        )
    return lines


def _intrinsic(solution: Solution) -> list[str]:
    """Scale factors, biases and angles between the axes, where a stand is declared."""
    found, u = solution.found.intrinsic, solution.u_intrinsic
    if u is None:
        return []
    rows = [("Intrinsic: row of K", "bias over it, g", "angle of two rows, rad")]
    for i, (axis, pair) in enumerate(zip("xyz", ("xy", "xz", "yz"))):
        scale = f"{axis} {found.scale[i]:#.6g} +- {u.scale[i]:.1e}"
        bias = f"{found.bias[i]:+.3e} +- {u.bias[i]:.1e}"
        rows.append((scale, bias, f"{pair} {found.angles[i]:.6f} +- {u.angles[i]:.1e}"))
    return [f"{scale:24}  {bias:21}  {angle}".rstrip() for scale, bias, angle in rows]


def _consequences(solution: Solution) -> list[str]:
    """|a| at its worst, what else the uncertainties of a declared stand lead to."""
    if (norm := solution.u_norm) is None:
        return []
    x, y, z = norm.attitude
    size = reliability.amount(norm.worst_g * 1e6, "ug")
    lines = [f"Worst u(|a|): {size}, at the attitude ({x:+.2f}, {y:+.2f}, {z:+.2f})"]
    lines += [] if solution.extended_terms is None else _cost_of_terms(solution.extended_terms)
    lines += [] if solution.reliability is None else reliability.lines(solution.reliability, solution.limit_g)
    return lines + ([] if solution.monte_carlo is None else _simulated(solution.monte_carlo))


def _cost_of_terms(extended: ExtendedTerms) -> list[str]:
    """What further terms of the model cost the twelve: of each kind of coefficient the one that loses most."""
    without, now = extended.without, extended.worst_norm
    assert without is not None and now is not None  # of a declared stand they are known
    assert extended.covariance is not None
    before = np.concatenate([without.u_K.ravel(), without.u_U0])
    after = np.sqrt(np.diag(extended.covariance)[:12])
    scale = np.abs(np.concatenate([np.repeat(np.diag(extended.k), 3), np.diag(extended.k)])) * 1e-6
    parts = []
    for kind, unit in ((range(0, 9, 4), "ppm"), ((1, 2, 3, 5, 6, 7), "urad"), (range(9, 12), "ug")):
        with np.errstate(divide="ignore", invalid="ignore"):
            worst = max(kind, key=lambda i: float(np.nan_to_num(after[i] / before[i])))
        if after[worst] > _LOSS * before[worst]:
            sizes = f"{before[worst] / scale[worst]:.3g} -> {after[worst] / scale[worst]:.3g}"
            parts.append(f"u({COEFFICIENTS[worst]}) {sizes} {unit}")
    parts.append(f"worst u(|a|) {without.u_norm_g * 1e6:.3g} -> {now.worst_g * 1e6:.3g} ug")
    return textwrap.wrap(
        f"Because of {listed(model_of(extended.terms))}: {', '.join(parts)}", _COLUMNS, break_on_hyphens=False
    )


def _simulated(found: MonteCarlo) -> list[str]:
    """What simulated runs make of the uncertainties, mean error, standard deviation and interval of each coefficient,
    and what that comes to. Of a stand without errors there is no unit for them."""
    lines = ["", f"Monte Carlo, {found.runs} runs, seed {found.seed}; in units of the stated u:"]
    lines.append(f"{'':6} {'mean error':>10}  {'u':>6}  {'95 % interval':>16}  linear: -1.960 to +1.960")
    for i, (name, verdict) in enumerate(zip(COEFFICIENTS, found.verdicts)):
        u = (found.linear_high[i] - found.linear_low[i]) / (2.0 * NORMAL_COVERAGE)
        middle = (found.linear_high[i] + found.linear_low[i]) / 2.0
        shift = spread = ends = "-"
        if u != 0.0:
            shift, spread = f"{found.shift[i] / u:+.3f}", f"{found.u[i] / u:.3f}"
            ends = f"{(found.low[i] - middle) / u:+.3f} to {(found.high[i] - middle) / u:+.3f}"
        lines.append(f"{name:6} {shift:>10}  {spread:>6}  {ends:>16}  {verdict.value}")
    return lines + textwrap.wrap(simulation_complaint(found) or "It agrees with the linear uncertainties.", _COLUMNS)


def _verdict_line(solution: Solution, decision: Decision) -> str:
    """The decision and why, in one line if it fits."""
    position = solution.schedule.positions[solution.worst_position].label
    size = f"{on_its_side(abs(float(solution.found.gravity.delta_g[solution.worst_position])), solution.limit_g)} g"
    limit = f"limit {solution.limit_g:g} g"
    if not decision.passed:
        told = f"{decision.sentence}{_failure(solution, decision, size, position, limit)}"
        return textwrap.fill(told, _COLUMNS, break_on_hyphens=False)
    condition = phrase(decision.assumes)
    passes = f"{decision.word}{decision.only}{condition}: "
    sizes = [f"{size} at {position}, {limit}", f"{size}, {limit}", f"{size[:-2]} <= {solution.limit_g:g} g"]
    lines = [passes + one for one in sizes] if condition else [f"{passes}largest gravity error {sizes[0]}"]
    return next((line for line in lines if len(line) <= _COLUMNS), textwrap.fill(lines[-1], _COLUMNS))


def _failure(solution: Solution, decision: Decision, size: str, position: str, limit: str) -> str:
    """What stands behind a failure. Where something explains it, it is named, and not the position with the largest
    error: an error at one position makes others look wrong."""
    if decision.is_not_shown:
        return f"; largest gravity error {size}. {remedies_text(would_show(solution), solution.limit_g)}."
    best = None if solution.fit is None else next(iter(solution.fit.explanations), None)
    by = f" at {position}" if best is None else ""
    explained = "" if best is None else f"; explained best by {named(best)}"
    exceeded = f"; {decision.comparison}" if UNCERTAINTY in decision.failures else f", {limit}"
    return f"{explained}; largest gravity error {size}{by}{exceeded}"
