"""`tumble plan ...`: what a stand is worth, before anything is measured on it.

    budget      what a stand leaves of the accuracy of every coefficient
    require     how good the stand must be for a limit of the gravity check
    optimize    the gain table that is best for a stand, for people, programs and the firmware
    schedule    the schedule that reaches an accuracy in the least test time
    validate    do thousands of simulated runs turn out as accurate as they claim to be?
    paper       the paper's tables and formulas computed again, side by side with what is printed

Each is described, run and shown by functions that follow each other here; what they have in common comes first.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError, quoted
from tumble.estimators import COEFFICIENTS, ESTIMATORS, HARMONIC, OPTIMAL
from tumble.schedule import file_of
from tumble.terms import parse

if TYPE_CHECKING:
    from tumble.arrays import Floats
    from tumble.documents.plan import Optimize, Plan, Promise
    from tumble.model.reliability import Reliability
    from tumble.planning.budget import Budget
    from tumble.planning.case import Case
    from tumble.planning.optimize import Optimized
    from tumble.solving.uncertainty import ExtendedTerms

DEFAULT_PROBABILITY = 0.95
_LEAST_PROBABLE, _MOST_PROBABLE = 0.5, 0.9999  # few are served by less, and none is computed better than the last
DEFAULT_RUNS = 20_000
FEWEST_RUNS, MOST_RUNS = 100, 10_000_000
_FEWEST_MOUNTINGS, _MOST_MOUNTINGS = 2, 6
_STEPS = ("15", "22.5", "45")
_STEEP = ("0", "15", "30", "45", "60")
_LONGEST_S = 1e6


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = "Judge a stand before anything is measured on it."
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    for name, (about, describe_subject, run) in _SUBJECTS.items():
        subject = subjects.add_parser(name, help=about, epilog="Exit codes: 0 done, 2 bad input, 130 interrupted.")
        subject.add_argument("--json", action="store_true", help="print one JSON document, schema tumble.plan/1")
        describe_subject(subject)
        subject.set_defaults(run_command=run)


def _add_case_options(parser: argparse.ArgumentParser, *more: str) -> None:
    """--stand, --limit, and of the shared options `more`."""
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML); default: the paper's stand, equation (5)")
    options.add(parser, "--limit", *more)


def _add_probability(parser: argparse.ArgumentParser, what: str) -> None:
    about = f"{what}; {_LEAST_PROBABLE:g} to {_MOST_PROBABLE:g}, default: {DEFAULT_PROBABILITY:g}"
    parser.add_argument("--probability", metavar="P", help=about)


def _parse_probability(text: str | None) -> float:
    """Raises UsageError."""
    if text is None:
        return DEFAULT_PROBABILITY
    return options.parse_number(text, "--probability", _LEAST_PROBABLE, _MOST_PROBABLE)


def _add_weights_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--weights",
        choices=("published", "derived"),
        default="derived",
        help="derived: the estimator's own, on the exact geometry (default); published: the paper's Tables 1 and 4",
    )


def _read_case(arguments: argparse.Namespace) -> Case:
    """What the options describe. Raises TumbleError."""
    from tumble.planning.case import Case

    stand_file = schedule = None
    limit_g, model = options.parse_limit(arguments.limit), getattr(arguments, "model", None)
    derived = getattr(arguments, "weights", "derived") == "derived"
    if arguments.stand is not None:
        from tumble.files.stand_file import read_stand

        stand_file = read_stand(arguments.stand)
    if getattr(arguments, "schedule", None) is not None:
        from tumble.files.schedule_file import read_schedule

        estimator = getattr(arguments, "estimator", None) if derived else None
        schedule = read_schedule(arguments.schedule, estimator=estimator).data
    case = Case.of(stand_file, arguments.stand, schedule)
    if model is not None and not derived:
        raise UsageError("--model: the paper's weights are for twelve coefficients (--weights derived)")
    case = replace(case, terms=parse(model, getattr(arguments, "estimator", None)))
    if case.terms and hasattr(arguments, "schedule"):
        from tumble.solving.computation import require_told_apart

        require_told_apart(case.schedule, case.terms)
    return case if limit_g is None else replace(case, limit_g=limit_g)


def _parse_positive(text: str, option: str) -> float:
    return options.parse_number(text, option, options.ABOVE_0, sys.float_info.max, "a number above 0")


def _told(arguments: argparse.Namespace, plan: Callable[[], Plan], show: Callable[[], None]) -> int:
    """As JSON, or for people. Returns the exit code."""
    from tumble.documents.base import to_json

    if arguments.json:
        sys.stdout.write(to_json(plan()))
    else:
        show()
    return EXIT_PASS


def _describe_budget(parser: argparse.ArgumentParser) -> None:
    parser.description = "Error budget: what each source of error of a stand contributes to every coefficient."
    _add_case_options(parser, "--schedule", "--model", "--estimator")
    _add_weights_option(parser)


def _run_budget(arguments: argparse.Namespace) -> int:
    case = _read_case(arguments)
    from tumble.planning import model_cost
    from tumble.planning.budget import budget, document
    from tumble.planning.promise import promise

    found = budget(case, arguments.weights, arguments.estimator)
    promised = unseen = None
    if arguments.weights == "derived":
        promised, unseen = promise(case, arguments.estimator), case.reliability(arguments.estimator)
    told = found, case, promised, unseen, model_cost.model_cost(case, arguments.estimator)
    return _told(arguments, lambda: document(*told), lambda: _show_budget(*told))


def _show_budget(
    found: Budget, case: Case, promised: Promise | None, unseen: Reliability | None, further: ExtendedTerms | None
) -> None:
    from tumble.model import reliability
    from tumble.planning import model_cost, tables
    from tumble.planning.budget import ALPHAS, notes, numbers_are, unit
    from tumble.planning.promise import sentence
    from tumble.planning.weights import NAMES

    out = tables.console()
    out.print(tables.heading(f"Error budget, {found.weights} weights, estimator {found.estimator}"))
    out.print(f"Stand: {case.stand.name or 'without a name'}; numbers are {numbers_are(found.weights)}")
    out.print(case.block_sentence)
    units = ("size", *map(unit, found.sources), "")
    sizes = ("", *(tables.number(size) for size in found.sizes), "")
    rows = [units, sizes]
    for index, name in enumerate(NAMES):
        millionth = "ug" if name.startswith("a0") else "ppm"
        cells = [tables.millionths(value) for value in (*found.terms[index], found.total[index])]
        rows.append((f"{name}, {millionth}", *cells))
    out.print(tables.table(("", *found.sources, "all"), rows))
    out.print(ALPHAS)
    out.print("ppm of the element itself: off the diagonal, 1000 ppm of 0.02 rad are 20 urad")
    for note in notes(case):
        out.print(note)
    if promised is not None:
        out.print(sentence(promised))
    for line in [] if unseen is None else reliability.lines(unseen):
        out.print(line)
    model_cost.show(out, further)
    if found.second_order.matters:
        for complaint in found.second_order.complaints:
            out.print(f"Beware: {complaint}", style="yellow")
        out.print("That is a bias, and in no column above", style="yellow")


def _describe_require(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Requirements: how large each source of error of a stand may be for a limit of the gravity check."
    )
    _add_case_options(parser, "--schedule", "--model", "--estimator")
    _add_weights_option(parser)
    _add_probability(
        parser, "what is just enough: probability of passing, and of |a| within the limit at every attitude"
    )
    parser.add_argument(
        "--split",
        metavar="SOURCE=PART,...",
        help="how alpha1 to alpha4, noise, and seat and platform if declared, share a row, as parts of its square;"
        " default: 1 each",
    )


def _run_require(arguments: argparse.Namespace) -> int:
    probability = _parse_probability(arguments.probability)
    case = _read_case(arguments)
    split = _split(arguments.split, case, arguments.weights == "published")

    from tumble.planning.require import require, show

    plan = require(case, arguments.weights, arguments.estimator, split, probability)
    return _told(arguments, lambda: plan, lambda: show(plan, case))


def _split(text: str | None, case: Case, published: bool) -> Floats:
    """Parts by source, in the order of budget.sources."""
    import numpy as np

    from tumble.planning.budget import sources

    parts = dict.fromkeys(sources(case, published), 1.0)
    given = [] if text is None else text.split(",")
    named = [item.partition("=")[0].strip() for item in given]
    for item in given:
        source, equals, part = item.partition("=")
        if not equals or source.strip() not in parts:
            raise UsageError(f"--split: {quoted(item)} is not SOURCE=PART with one of {', '.join(parts)}")
        if named.count(source.strip()) > 1:
            raise UsageError(f"--split: {source.strip()} is given twice")
        parts[source.strip()] = _parse_positive(part.strip(), "--split")
    return np.array(list(parts.values()))


def _describe_optimize(parser: argparse.ArgumentParser) -> None:
    parser.description = "The gain table of the optimal estimator for a stand, and how much better it is than refined."
    _add_case_options(parser, "--schedule")
    parser.set_defaults(estimator=OPTIMAL)
    options.refuse_model(
        parser,
        "the firmware's gains are for twelve coefficients; further terms are for other plans",
    )
    parser.add_argument(
        "--result",
        metavar="RESULT.json",
        help="linearise at the K of this result, the block's last known; default: its nominal K",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        help="also write the table: .json, .h (a C header) or .bin (a gain record for non-volatile memory)",
    )


def _run_optimize(arguments: argparse.Namespace) -> int:
    """Optimize and print. Returns the exit code; raises TumbleError.

    A table bears the serial of the block that it was made for, a gain record a CRC of it. That is for people: nothing
    checks it, as the firmware does not know which block is mounted.
    """
    kind = next((ending for ending in (".json", ".h", ".bin") if (arguments.out or "").endswith(ending)), None)
    if arguments.out is not None and kind is None:
        raise UsageError(f"--out: {quoted(arguments.out)} ends in none of .json, .h, .bin")

    from tumble.files.disk import refuse_overwriting, write_bytes
    from tumble.files.stand_file import read_stand
    from tumble.planning import optimize

    refuse_overwriting(arguments.out, arguments.stand, file_of(arguments.schedule), arguments.result)
    case = _read_case(arguments)
    k = None if arguments.result is None else _last_known_k(arguments.result)
    block = None if arguments.stand is None else read_stand(arguments.stand).block
    found = optimize.optimize(case, k, None if block is None else block["serial"])  # the record is for this block only
    document = optimize.document(found)
    if kind is not None:
        write_bytes(arguments.out, _content(kind, found, document))
    return _told(arguments, lambda: document, lambda: _show_optimize(found))


def _show_optimize(found: Optimized) -> None:
    import numpy as np

    from tumble.planning import tables
    from tumble.planning.promise import sentence
    from tumble.stand import per_channel

    out, record = tables.console(), found.table
    other = "least_squares" if found.u_refined is None else "refined"
    u_other = found.u_least_squares if found.u_refined is None else found.u_refined
    noise = ", ".join(f"{sigma:.2g}" for sigma in np.atleast_1d(per_channel(record.sigma_mean / record.weights)))
    angles = ", ".join(f"{sigma:.3g}" for sigma in record.sigma)
    out.print(tables.heading(f"Optimal weights: {record.fit_positions} fit positions in {record.mountings} mountings"))
    out.print(f"Standard deviations: alpha1 to alpha4 {angles} rad, a mean's noise {noise} V")
    rows = [
        (name, "V/g" if name.startswith("K") else "V", f"{u:.3e}", f"{old:.3e}", f"{old / u:.2f}", f"{efficiency:.4f}")
        for name, u, old, efficiency in zip(COEFFICIENTS, found.u, u_other, found.efficiency)
    ]
    headings = ("", "unit", "u, optimal", f"u, {other}", "gain", "efficiency")
    out.print(tables.table(headings, rows, left=(0, 1)))
    if (note := found.case.rounding_sentence) is not None:
        out.print(note)
    out.print(sentence(found.promise))
    if found.table.floored:
        out.print("Beware: the stand declares no noise; weights for 1e-9 g of it mean little.", style="yellow")
    for complaint in found.second_order.complaints:
        out.print(f"Beware: {complaint}", style="yellow")


def _content(kind: str, found: Optimized, document: Optimize) -> bytes:
    from tumble.documents.base import to_json
    from tumble.solving import optimal_run

    if kind == ".bin":
        return optimal_run.to_bytes(found.table)
    text = to_json(document) if kind == ".json" else optimal_run.to_c_header(found.table, found.case.stand.name)
    return text.encode("utf-8")


def _last_known_k(file: str) -> Floats:
    """K (3, 3) in V/g of a result file."""

    from tumble.documents.result import read_result
    from tumble.errors import BadInput
    from tumble.units import noise_unit, volts_per

    result = read_result(file)
    if noise_unit(result.unit) != "V":
        raise BadInput(f"K is in {quoted(result.unit)} per g; a gain table needs volts", file)
    return result.K * volts_per(result.unit)


def _describe_schedule(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "The mountings or inclinations, table angles and samples that reach a limit, or a worst standard uncertainty of"
        " |a|, in the least test time found; and what the built-in schedules take for the same."
    )
    _add_case_options(parser, "--model")
    _add_probability(parser, "of keeping the limit: of passing the check, and of |a| within it at every attitude")
    parser.add_argument(
        "--norm", metavar="G", help="reach this worst standard uncertainty of |a| over all attitudes, not a limit"
    )
    parser.add_argument(
        "--estimator",
        choices=("least_squares", "optimal"),
        default="optimal",
        metavar="NAME",
        help="least_squares or optimal; default: optimal. on an inclined stand least_squares means inclined",
    )
    parser.add_argument(
        "--mountings",
        metavar="N",
        default="3",
        help=f"at most this many, {_FEWEST_MOUNTINGS} to {_MOST_MOUNTINGS}; default: 3",
    )
    parser.add_argument(
        "--angles", choices=_STEPS, default="22.5", help="step of the table angles in degrees; default: 22.5"
    )
    parser.add_argument("--remounting", metavar="SECONDS", help="time to re-mount the block; default: 300")
    parser.add_argument(
        "--inclination",
        choices=_STEEP,
        default=_STEEP[-1],
        help="degrees up to which the stand can be inclined to both sides, 0: not at all; default: 60",
    )
    parser.add_argument("--inclining", metavar="SECONDS", help="time to incline the stand; default: 60")
    parser.add_argument("--out", metavar="FILE.toml", help="also write it as a schedule file")
    options.add(parser, *options.WORKERS)


def _run_schedule(arguments: argparse.Namespace) -> int:
    if arguments.norm is not None and (arguments.limit is not None or arguments.probability is not None):
        raise UsageError("--norm: a worst u(|a|) takes the place of --limit and --probability")
    if arguments.out is not None and not arguments.out.endswith(".toml"):
        raise UsageError(f"--out: {quoted(arguments.out)} does not end in .toml")
    norm_g = None if arguments.norm is None else _parse_positive(arguments.norm, "--norm")
    probability = _parse_probability(arguments.probability)
    most = options.parse_whole(arguments.mountings, "--mountings", _FEWEST_MOUNTINGS, _MOST_MOUNTINGS)
    remounting = _parse_seconds(arguments.remounting, "--remounting")
    inclining = _parse_seconds(arguments.inclining, "--inclining")

    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.files.schedule_file import to_toml
    from tumble.files.stand_file import read_stand
    from tumble.planning import schedule_search
    from tumble.planning.schedule_search import (
        DEFAULT_INCLINE_S,
        DEFAULT_REMOUNT_S,
        Goal,
        Pace,
        Reach,
        plan_schedule,
    )

    refuse_overwriting(arguments.out, arguments.stand)
    case = _read_case(arguments)
    stand_file = None if arguments.stand is None else read_stand(arguments.stand)
    pace = Pace.of(
        stand_file,
        DEFAULT_REMOUNT_S if remounting is None else remounting,
        DEFAULT_INCLINE_S if inclining is None else inclining,
    )
    goal = Goal(norm_g, probability, arguments.estimator)
    reach = Reach(float(arguments.angles), most, float(arguments.inclination))
    depends = {"case": case, "goal": goal, "pace": pace, "step_deg": reach.step_deg}
    with options.team_of(arguments, "plan schedule", **depends) as team, options.progress_bar("searching") as progress:
        found = plan_schedule(case, goal, pace, reach, progress, team)
    if arguments.out is not None:
        write_text(arguments.out, to_toml(found.best.schedule))
    show = partial(schedule_search.show, found, arguments.out, arguments.stand)
    return _told(arguments, lambda: schedule_search.document(found, reach.step_deg), show)


def _parse_seconds(text: str | None, option: str) -> float | None:
    """Raises UsageError."""
    if text is None:
        return None
    return options.parse_number(text, option, 0.0, _LONGEST_S, f"a number of seconds from 0 to {_LONGEST_S:g}")


def _describe_validate(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Monte Carlo: the firmware's estimators on simulated runs of the exact geometry. Bias, spread,"
        " coverage of the stated intervals, efficiency against the least possible spread."
    )
    parser.epilog = (
        "Exit codes: 0 every figure within its limits, 1 not so, 2 bad input, 77 --plot cannot be drawn here,"
        " 130 interrupted."
    )
    _add_case_options(parser, "--schedule", "--model")
    parser.add_argument(
        "--estimator", choices=ESTIMATORS, metavar="NAME", help="one of them; default: all that the schedule allows"
    )
    least = f"{FEWEST_RUNS} or more; "
    parser.add_argument("--runs", metavar="N", default=str(DEFAULT_RUNS), help=f"{least}default: {DEFAULT_RUNS}")
    options.add(parser, "--seed")
    parser.add_argument(
        "--table",
        choices=("known", "run"),
        default="known",
        help="optimal weights: for the block's known K (default), or made anew for each run, as solve does",
    )
    parser.add_argument(
        "--plot", metavar="FILE.svg", help="also draw histograms of error over stated uncertainty; needs matplotlib"
    )
    options.add(parser, *options.WORKERS)


def _run_validate(arguments: argparse.Namespace) -> int:
    runs = options.parse_whole(arguments.runs, "--runs", FEWEST_RUNS, MOST_RUNS)
    seed = options.parse_seed(arguments.seed)
    if arguments.plot is not None and not arguments.plot.endswith(".svg"):
        raise UsageError(f"--plot: {quoted(arguments.plot)} does not end in .svg")
    case = _read_case(arguments)
    if case.terms and arguments.table != "known":
        raise UsageError("--table run: not with --model; the second order makes up for weights made elsewhere")

    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.planning.validate import document, judge, show, validate

    refuse_overwriting(arguments.plot, arguments.stand, file_of(arguments.schedule), option="--plot")
    if arguments.plot is not None:
        from tumble.pictures import require, svg
        from tumble.pictures.histograms import histograms

        require("--plot")
    estimators = _estimators(arguments, case)
    depends = {"case": case, "estimators": estimators, "seed": seed, "table": arguments.table}
    with (
        options.team_of(arguments, "plan validate", **depends) as team,
        options.progress_bar("simulating", runs) as progress,
    ):
        found = validate(case, estimators, runs, seed, arguments.table, progress, team)
    plan = document(case, {one.estimator: judge(one) for one in found}, runs, seed, arguments.table)
    if arguments.plot is not None:
        write_text(arguments.plot, svg(histograms(found, f"{case.stand.name}: error over stated u, {runs} runs")))
    _told(arguments, lambda: plan, lambda: show(plan))
    return EXIT_PASS if plan.passed else EXIT_LIMITS_FAILED


def _estimators(arguments: argparse.Namespace, case: Case) -> tuple[str, ...]:
    """The one asked for, or all that the schedule allows."""
    from tumble.model.estimators import circles
    from tumble.planning.weights import estimators_of

    if arguments.estimator is not None:
        return (arguments.estimator,)
    harmonic = circles(case.fitted) is not None
    return tuple(name for name in estimators_of(case) if harmonic or name not in HARMONIC)


def _describe_paper(parser: argparse.ArgumentParser) -> None:
    parser.description = "Tables 1 to 5 and formulas (6), (18) and (19) of the paper, computed again and compared."
    options.refuse_model(parser, "the paper's model has twelve coefficients; further terms are for other plans")


def _run_paper(arguments: argparse.Namespace) -> int:
    from tumble.planning.paper import document, show

    return _told(arguments, document, show)


_SUBJECTS: dict[str, tuple[str, Callable[[argparse.ArgumentParser], None], Callable[[argparse.Namespace], int]]] = {
    "budget": (
        "error budget: contributions of every source to every coefficient, and their sum",
        _describe_budget,
        _run_budget,
    ),
    "require": (
        "requirements: how large each source may be for a limit of the gravity check",
        _describe_require,
        _run_require,
    ),
    "optimize": (
        "the best weights for a stand: a gain table for `optimal`",
        _describe_optimize,
        _run_optimize,
    ),
    "schedule": (
        "the quickest schedule: mountings, table angles and samples for a limit",
        _describe_schedule,
        _run_schedule,
    ),
    "validate": ("Monte Carlo: the stated uncertainties against simulated runs", _describe_validate, _run_validate),
    "paper": ("the paper, audited: its tables and formulas beside the corrected ones", _describe_paper, _run_paper),
}
