"""`tumble solve --temperature`: runs at several temperatures to K(T) and U0(T)."""

from __future__ import annotations

import argparse
import textwrap
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError, quoted
from tumble.estimators import COEFFICIENTS
from tumble.messages import warn
from tumble.schedule import file_of

if TYPE_CHECKING:
    from tumble.api.thermal import ThermalResult
    from tumble.cli.output import Line, Table

_COLUMNS = 80
_ALONE = ("monte_carlo", "model", "seed", "details", "prior", "growth", "db")  # options of one run


def add_options(parser: argparse.ArgumentParser) -> None:
    """--temperature, --at, --bolted-once."""
    group = parser.add_argument_group("over temperature, of several RUN.csv")
    group.add_argument(
        "--temperature",
        choices=("linear", "quadratic"),
        help="of all runs together; each has a column temperature, deg C, or its place in --at",
    )
    group.add_argument("--at", metavar="C,...", help="temperatures of the runs, deg C")
    group.add_argument(
        "--bolted-once",
        action="store_true",
        help="the block stays bolted and the stand level through all runs: seat, yaw and level are the same in them",
    )


def only_run(arguments: argparse.Namespace) -> str:
    """The run of a command without --temperature. Raises UsageError."""
    if arguments.at is not None or arguments.bolted_once:
        raise UsageError(f"{'--at' if arguments.at is not None else '--bolted-once'} is for --temperature")
    if len(arguments.run) > 1:
        raise UsageError(
            f"{len(arguments.run)} runs: solve takes one, or several at their temperatures (--temperature)"
        )
    file: str = arguments.run[0]
    return file


def run(arguments: argparse.Namespace, limit_g: float | None, confidence: float) -> int:
    """Solve and print. Returns the exit code; raises TumbleError."""
    for name in _ALONE:
        if getattr(arguments, name):
            raise UsageError(f"--{name.replace('_', '-')} is for one run, not for --temperature")
    at_c = None if arguments.at is None else [_celsius(one) for one in arguments.at.split(",")]

    import sys

    from tumble.api.recording import recording_of
    from tumble.api.thermal import ThermalResult, document_of, solved_together
    from tumble.cli.output import print_lines
    from tumble.files.disk import refuse_overwriting
    from tumble.files.run_layout import COLUMNS, TEMPERATURE

    layout = options.layout_options(arguments, (*COLUMNS, TEMPERATURE))
    refuse_overwriting(arguments.out, *arguments.run, arguments.stand, file_of(arguments.schedule))
    options.require_ending(arguments.out, "--out", ".json")
    single, found = solved_together(
        [recording_of(file, layout) for file in arguments.run],
        arguments.temperature,
        at_c,
        arguments.bolted_once,
        confidence,
        stand=arguments.stand,
        schedule=arguments.schedule,
        estimator=arguments.estimator,
        limit_g=limit_g,
    )
    result = ThermalResult(document_of(single, found))
    if arguments.out is not None:
        result.save(arguments.out)
    warn(result.checked.warnings)
    if arguments.json:
        sys.stdout.write(result.to_json())
    else:
        print_lines(page(result))
    return EXIT_PASS if result.passed else EXIT_LIMITS_FAILED


def _celsius(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise UsageError(f"--at: {quoted(text)} is no temperature") from None


def page(result: ThermalResult) -> list[Line | Table]:
    """All that a person is told, from top to bottom."""
    from tumble.cli.output import Table
    from tumble.solving.thermal import decision_of, verdict_of

    told = result.checked
    verdict, said = decision_of(told), "".join(verdict_of(told))
    colour = "green" if told.passed else "yellow" if verdict.is_not_shown else "red"
    by = f"({'T' if told.reference_c == 0 else f'T - {told.reference_c:g} deg C'})"
    title = f"{len(told.runs)} runs, {verdict.positions} positions; powers of {by} in K"
    return [
        *([(line, f"{colour} bold")] for line in textwrap.wrap(said, _COLUMNS)),
        [("", "")],
        [(title, "bold")],
        Table(*_coefficients(result)),
        [("", "")],
        *(
            [(line, "")]
            for sentence in _checks(result)
            for line in textwrap.wrap(sentence, _COLUMNS, subsequent_indent="  ")
        ),
    ]


def _coefficients(result: ThermalResult) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Headings and rows: value and standard uncertainty of every power."""
    import numpy as np

    told = result.checked
    names = ["value", "per K", "per K^2"][: told.degree + 1]
    headings: list[str] = ["", f"at {told.reference_c:g} C"]
    values = [np.concatenate([k.ravel(), u0]) for k, u0 in zip(told.K, told.U0)]
    u = None if told.u_K is None or told.u_U0 is None else [
        np.concatenate([k.ravel(), u0]) for k, u0 in zip(told.u_K, told.u_U0)
    ]  # fmt: skip
    headings += ["unit", "u"]
    for name in names[1:]:
        headings += [name, "u"]
    rows = []
    for i, name in enumerate(COEFFICIENTS):
        row = [name, f"{values[0][i]:+.8g}", f"{told.unit}/g" if i < 9 else told.unit]
        for power, of in enumerate(values):
            row += [f"{of[i]:+.4e}"] if power else []
            row += ["unknown" if u is None else f"{u[power][i]:.1e}"]
        rows.append(tuple(row))
    return tuple(headings), rows


def _checks(result: ThermalResult) -> list[str]:
    """A sentence for each."""
    from msgspec import UnsetType

    from tumble.model import reliability
    from tumble.model.patterns import BY_NAME

    told, unseen = result.checked, []
    lines = [f"Gravity check: largest error {told.max_abs_delta_g_g:.2g} g, limit {told.decision.limit_g:g} g"]
    if not isinstance(told.set_angles, UnsetType):
        lines.append(f"Set angles: corrected by the table of {told.set_angles.learned} ({told.set_angles.runs} runs)")
    if told.fit is not None:
        lines.append(
            f"Fit of all runs to the stand: chi-squared {told.fit.chi2:.3g}, {told.fit.dof} degrees of freedom,"
            f" p {told.fit.p:.2g}"
        )
    if told.u_norm_g:
        worst = max(told.u_norm_g, key=lambda one: one.worst_g)
        size = reliability.amount(worst.worst_g * 1e6, "ug")
        lines.append(f"Worst u(|a|): {size}, at {worst.temperature_c:.3g} deg C")
    else:
        lines.append("Uncertainties are unknown: --stand FILE describes the stand")
    lines.append(
        f"With the values at {told.reference_c:g} deg C alone |a| would be wrong by up to"
        f" {reliability.amount(told.at_one_temperature_g * 1e6, 'ug')}"
    )
    for one in told.reliability or ():
        unseen.append(reliability.Undetected(BY_NAME[one.pattern], one.size, one.norm_error_g))
    lines += reliability.lines(tuple(unseen), told.decision.limit_g)
    for run in told.runs:
        verdict = "PASS" if run.passed else f"FAIL: {run.pass_reason}"
        lines.append(f"{run.file} alone, at {run.mean_c:.3g} deg C: {verdict}")
    return lines
