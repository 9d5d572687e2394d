"""`tumble history`: the calibrations of many blocks, in a database."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, BadInput, UsageError, quoted

if TYPE_CHECKING:
    from tumble.documents.history import History as Document, Trend
    from tumble.store.codec import HistoryEntry

_DB = "history.db"
_CONFIDENCE = "0.9973"
_COVERAGE = "3"


def describe(parser: argparse.ArgumentParser) -> None:
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    subject = subjects.add_parser(
        "add",
        help="add results",
        description="Add results to the history. One that is there already is not added again; all are added or none.",
        epilog="Exit codes: 0 done, 2 bad input, 77 a package is missing, 130 interrupted.",
    )
    subject.add_argument(
        "results",
        metavar="RESULT.json|FOLDER|IMAGE",
        nargs="*",
        help="results, folders of runs, or memories of computers",
    )
    subject.add_argument("--node", metavar="LINK", help="read the history of this computer, such as can:can0, instead")
    _add_database(subject)
    subject.add_argument("--serial", metavar="NAME", help="of the block; default: serial of the result")
    subject.add_argument("--type", metavar="NAME", help="of the block; default: label type or model of the item")
    subject.add_argument("--date", metavar="YYYY-MM-DD", help="of the run; default: label date, else key created")
    subject.set_defaults(run_command=add)
    subject = subjects.add_parser(
        "show",
        help="list calibrations",
        description="List the calibrations, by block and time.",
        epilog="Exit codes: 0 done, 2 bad input, 77 a package is missing, 130 interrupted.",
    )
    _add_choice(subject)
    options.add(subject, "--json")
    subject.set_defaults(run_command=show)
    subject = subjects.add_parser(
        "trend",
        help="how blocks change, and which of them do not behave",
        description="Drift and random walk of every parameter of a type, by maximum likelihood over its blocks; control"
        " charts of every block, and alarms: jumps, outliers, slow drifts, seats that were exchanged.",
        epilog="Exit codes: 0 no alarm of a last calibration, 1 there is one, 2 bad input, 77 a package is missing, 130"
        " interrupted.",
    )
    _add_choice(subject)
    _add_confidence(subject)
    subject.add_argument(
        "--plot", metavar="FILE", help="draw the parameters of the block of --serial: .svg, .png or .pdf"
    )
    subject.add_argument("--chart", metavar="FILE", help="draw its control charts")
    options.add(subject, "--json")
    subject.set_defaults(run_command=trend)
    subject = subjects.add_parser(
        "due",
        help="when the next calibration is due",
        description="The day at which the coverage factor times u(|a|), grown since the last calibration, reaches a"
        " limit at the worst attitude (ILAC-G24, control chart); or an interval by the last one alone (staircase).",
        epilog="Exit codes: 0 none is overdue, 1 one is, 2 bad input, 77 a package is missing, 130 interrupted.",
    )
    _add_choice(subject)
    subject.add_argument("--limit", metavar="G", required=True, help="within which |a| shall stay, in g")
    subject.add_argument("--coverage", metavar="K", default=_COVERAGE, help=f"coverage factor; default: {_COVERAGE}")
    subject.add_argument(
        "--method", choices=("control-chart", "staircase"), default="control-chart", help="default: control-chart"
    )
    subject.add_argument("--on", metavar="YYYY-MM-DD", help="the day on which a block is overdue; default: today")
    _add_confidence(subject)
    options.add(subject, "--json")
    subject.set_defaults(run_command=due)
    subject = subjects.add_parser(
        "export",
        help="write all as Parquet, which DuckDB reads",
        description="Write the calibrations as one table of Parquet. Scales in V/g, angles in rad, biases in g; u_scale"
        " is relative.",
        epilog="Exit codes: 0 done, 2 bad input, 77 a package is missing, 130 interrupted.",
    )
    _add_choice(subject)
    subject.add_argument("--out", metavar="FILE.parquet", required=True, help="the file to write")
    subject.set_defaults(run_command=export)


def _add_database(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--db", metavar="FILE|URL", default=_DB, help=f"of SQLite, or a URL of SQLAlchemy; default: {_DB}"
    )


def _add_choice(parser: argparse.ArgumentParser) -> None:
    _add_database(parser)
    parser.add_argument("--serial", metavar="NAME", help="of one block; default: all")
    parser.add_argument("--type", metavar="NAME", help="of the blocks; default: all")


def _add_confidence(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--confidence",
        metavar="P",
        default=_CONFIDENCE,
        help=f"share of calibrations of blocks that behave that give no alarm; default: {_CONFIDENCE}",
    )


def add(arguments: argparse.Namespace) -> int:
    """Add and say how many. Returns the exit code; raises TumbleError."""
    if (arguments.node is None) == (not arguments.results):
        raise UsageError("give results, or --node LINK")
    if arguments.node is not None and arguments.serial is None:
        raise UsageError("--node: give --serial NAME: a node does not say of which block the sets in its history are")

    if arguments.node is not None and arguments.date is not None:
        raise UsageError("--date: the sets in the history of a node have dates of their own: leave it out")

    from tumble.history import History
    from tumble.history.calibrations import rows_of_sets

    with History(arguments.db) as history:
        if arguments.node is None:
            new = history.add(*arguments.results, serial=arguments.serial, type=arguments.type, date=arguments.date)
        else:
            sets = _sets_of_node(arguments.node)
            new = history.add_rows(rows_of_sets(sets, arguments.node, arguments.serial, arguments.type))
    sys.stdout.write(f"{new} added\n")
    return EXIT_PASS


def _sets_of_node(link: str) -> list[HistoryEntry]:
    """The history of a navigation computer, newest first. An uncertainty of 0 is none. Raises TumbleError."""
    from tumble import client
    from tumble.store.codec import HAS_TEMPERATURE, HAS_UNCERTAINTY, HistoryEntry

    found = []
    numbers = [f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"]
    heads = [f"History: {name}" for name in ("Sequence", "Origin", "Estimator", "Date", "Temperature")]
    values = [f"History values: {name}" for name in numbers]
    uncertainties = [f"History uncertainties: u_{name}" for name in numbers]
    with client.connect(link) as node:
        node.write("History: Entry", 0)
        for number in range(int(node.read("History: Entries") or 0)):
            node.write("History: Entry", number)
            head, of_set, u = (
                [float(one or 0.0) for one in node.read_together(*them)] for them in (heads, values, uncertainties)
            )
            sequence, origin, estimator, date = map(int, head[:4])
            flags = HAS_TEMPERATURE | (HAS_UNCERTAINTY if all(u) else 0)
            found.append(HistoryEntry(number, sequence, origin, estimator, flags, date or None, head[4], of_set, u))
    return found


def show(arguments: argparse.Namespace) -> int:
    """List. Returns the exit code; raises TumbleError."""
    from tumble.history import History, report

    with History(arguments.db) as history:
        told = history.show(*_serials(arguments), type=arguments.type)
    return _print(told, arguments, report.render_listing(told), EXIT_PASS)


def trend(arguments: argparse.Namespace) -> int:
    """Estimate and print. Returns the exit code; raises TumbleError."""
    confidence = options.parse_confidence(arguments.confidence)
    plots = {"--plot": arguments.plot, "--chart": arguments.chart}
    if any(plots.values()) and arguments.serial is None:
        raise UsageError("--plot, --chart: a picture is of one block: give --serial NAME")

    from tumble.files.disk import refuse_overwriting
    from tumble.history import History, report

    for option, file in plots.items():
        refuse_overwriting(file, arguments.db, option=option)
        if file is not None:
            from tumble.pictures import require_format

            require_format(file, option)
    with History(arguments.db) as history:
        told = history.trend(arguments.serial, type=arguments.type, confidence=confidence)
    _draw(told, arguments)
    is_open = any(one.kind == "open" and not one.of_seat for one in told.alarms)
    return _print(told, arguments, report.render_trend(told), EXIT_LIMITS_FAILED if is_open else EXIT_PASS)


def _draw(told: Trend, arguments: argparse.Namespace) -> None:
    """Both files or none. Raises BadInput for a block that has no calibration that counts."""
    if not (arguments.plot or arguments.chart):
        return
    from tumble import pictures
    from tumble.files.disk import write_all

    if not told.points:
        raise BadInput(
            f"no calibration of block {quoted(arguments.serial)} counts, so there is no picture", told.history
        )
    drawn = [(pictures.trend, arguments.plot), (pictures.control_chart, arguments.chart)]
    write_all({file: pictures.written(draw(told), file) for draw, file in drawn if file is not None})


def due(arguments: argparse.Namespace) -> int:
    """Forecast and print. Returns the exit code; raises TumbleError."""
    limit_g = options.parse_number(arguments.limit, "--limit", options.ABOVE_0, 1.0, "an acceleration in g")
    coverage = options.parse_number(arguments.coverage, "--coverage", 1.0, 10.0)
    confidence = options.parse_confidence(arguments.confidence)

    import time

    from tumble.documents.labels import iso
    from tumble.history import History, report
    from tumble.history.calibrations import seconds_of

    now = iso(time.time() if arguments.on is None else seconds_of(arguments.on, "--on"))
    with History(arguments.db) as history:
        told = history.due(
            limit_g,
            arguments.serial,
            type=arguments.type,
            coverage_factor=coverage,
            method=arguments.method,
            confidence=confidence,
        )
    is_over = any(one.due is not None and one.due < now for one in told.blocks)
    return _print(told, arguments, report.render_due(told), EXIT_LIMITS_FAILED if is_over else EXIT_PASS)


def export(arguments: argparse.Namespace) -> int:
    """Write the table and say how many. Returns the exit code; raises TumbleError."""
    if not arguments.out.endswith(".parquet"):
        raise UsageError("--out: the file of an export ends in .parquet")

    from tumble.history import History

    with History(arguments.db) as history:
        count = history.export(arguments.out, *_serials(arguments), type=arguments.type)
    sys.stdout.write(f"{count} written\n")
    return EXIT_PASS


def _serials(arguments: argparse.Namespace) -> list[str]:
    return [] if arguments.serial is None else [arguments.serial]


def _print(told: Document, arguments: argparse.Namespace, text: str, code: int) -> int:
    from tumble.documents.base import to_json

    sys.stdout.write(to_json(told) if arguments.json else text)
    return code
