"""What several commands have in common: their options, how the words given become values, and who simulates a lot."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from tumble.defaults import DEFAULT_CONFIDENCE, DEFAULT_ESTIMATOR, DEFAULT_LIMIT_G
from tumble.errors import UsageError, listed, quoted
from tumble.estimators import ESTIMATORS
from tumble.messages import on_terminal
from tumble.schedule import BUILT_IN
from tumble.terms import EXTENDABLE, TERMS

if TYPE_CHECKING:
    from tumble.files.run_layout import LayoutOptions
    from tumble.workers.over import Team

Options: TypeAlias = "argparse._ActionsContainer"  # a parser, or a group of options in one

NO_REPORT = "TUMBLE_NO_REPORT"
FIRMWARES = ("host", "zcu102")
LARGEST_SEED = 2**64 - 1
ABOVE_0 = math.ulp(0.0)  # the least number that is
MOST_WORKERS = 256
_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "\\t": "\t", "space": " "}
_PROMISING = frozenset(
    ".c .csv .h .htm .html .jpeg .jpg .json .m .mat .md .npz .parquet .pdf .png .pq .svg .toml .tsv .xls .xlsx .xml"
    " .yaml .yml".split()
)  # endings that say what is in a file

_BY_SCHEDULE = "by schedule"
_SHARED: dict[str, dict[str, Any]] = {  # by option, what argparse is told; {}: where a command remarks on it
    "--schedule": {
        "metavar": "NAME",
        "help": f"{', '.join(BUILT_IN[1:])}{{}}, or a schedule file (TOML); default: paper, its 2 x 9 positions",
    },
    "--estimator": {
        "choices": ESTIMATORS,
        "default": _BY_SCHEDULE,
        "metavar": "NAME",
        "help": f"{listed(ESTIMATORS, 'or')}; default: {DEFAULT_ESTIMATOR} where the schedule goes round whole circles,"
        " inclined on inclined schedules, else least_squares{}",
    },
    "--model": {
        "metavar": "TERM,...",
        "help": f"further terms to find: {', '.join(TERMS)} (second and third order, a scale that differs by sign,"
        f" products of two axes, drift over the run); needs --estimator {' or '.join(EXTENDABLE)}",
    },
    "--limit": {
        "metavar": "G",
        "help": f"limit of the gravity check in g; default: the stand file's, else {DEFAULT_LIMIT_G:g}",
    },
    "--confidence": {
        "metavar": "P",
        "default": str(DEFAULT_CONFIDENCE),
        "help": f"at which the run must fit its stand; default: {DEFAULT_CONFIDENCE}",
    },
    "--firmware": {"choices": FIRMWARES, "default": FIRMWARES[0], "help": f"{{}}default: {FIRMWARES[0]}"},
    "--seed": {"metavar": "N", "default": "1", "help": "0 to 2^64 - 1{}; default: 1"},
    "--json": {"action": "store_true", "help": "print the result as one JSON document"},
    "--details": {
        "action": "store_true",
        "help": "print every position, residuals, the stand seen and intrinsic parameters, too",
    },
    "--no-report": {"action": "store_true", "help": f"write no report; the same as {NO_REPORT}=1 in the environment"},
    "--workers": {"metavar": "N", "help": f"processes, 1 to {MOST_WORKERS}; the result is the same; default: 1"},
    "--cluster": {
        "metavar": "ADDRESS",
        "help": "a scheduler of Dask distributed, such as tcp://HOST:8786, or tls:// with the files of Dask's own"
        " configuration; needs the extra cluster",
    },
    "--resume": {
        "metavar": "FILE.parquet",
        "help": "keep finished work in this file, and resume from it; needs the extra parquet",
    },
}
WORKERS = ("--workers", "--cluster", "--resume")  # of what simulates a lot


def add(parser: Options, *options: str, remark: str = "", **own: Any) -> None:
    """Options that are the same in several commands; the `remark` stands in the help of those that have a place for
    one. `own`: what argparse is told otherwise here."""
    for option in options:
        how = _SHARED[option] | own
        parser.add_argument(option, **{**how, "help": how["help"].format(remark)})


def choose_estimator(arguments: argparse.Namespace) -> None:
    """What --estimator is where nobody says."""
    if getattr(arguments, "estimator", None) == _BY_SCHEDULE:
        arguments.estimator, name = DEFAULT_ESTIMATOR, getattr(arguments, "schedule", None)
        if name is not None:
            from tumble.files.schedule_file import estimator_by_name

            arguments.estimator = estimator_by_name(name)


def refuse_model(parser: argparse.ArgumentParser, why: str) -> None:
    """--model, where it makes no sense."""

    class Refuse(argparse.Action):
        def __call__(self, *_: object) -> None:
            raise UsageError(f"--model: {why}")

    parser.add_argument("--model", action=Refuse, help=argparse.SUPPRESS)


def add_layout(
    parser: argparse.ArgumentParser, what: str, example: str = "ux=AccX,uy=AccY", has_unit: bool = True
) -> argparse._ArgumentGroup:
    """--columns, --delimiter, --decimal, and if it `has_unit` --unit, of `what`. Returns their group."""
    layout = parser.add_argument_group(f"layout of the {what}", "detected, unless given")
    layout.add_argument("--columns", metavar="NAME=COLUMN,...", help=f"names of its columns, such as {example}")
    layout.add_argument("--delimiter", metavar="SIGN", help="comma, semicolon, tab or another sign")
    layout.add_argument("--decimal", choices=(".", ","), help="decimal mark")
    if has_unit:
        layout.add_argument("--unit", help="unit of the outputs; default: the one in brackets in the header, else V")
    return layout


def layout_options(
    arguments: argparse.Namespace, names: Sequence[str], has_unit: bool = True, may_lack: Sequence[str] = ()
) -> LayoutOptions:
    """What the options say about the layout, with columns of these names, of which some `may_lack`, by an empty name.
    Raises UsageError."""
    from tumble.api.arguments import require_unit
    from tumble.files.run_layout import LayoutOptions, is_delimiter
    from tumble.units import spelled

    columns: dict[str, str] = {}  # of `ux=AccX,uy=AccY`
    for part in [] if arguments.columns is None else arguments.columns.split(","):
        wanted, equals, name = (piece.strip() for piece in part.partition("="))
        if not equals or wanted not in names or not (name or wanted in may_lack) or wanted in columns:
            known = ", ".join(names)
            raise UsageError(f"--columns: {quoted(part)} is not NAME=COLUMN with NAME one of {known}, once each")
        columns[wanted] = name
    delimiter = arguments.delimiter
    if delimiter is not None:
        delimiter = _DELIMITERS.get(delimiter.lower(), delimiter)
        if not is_delimiter(delimiter):
            raise UsageError(
                f"--delimiter: {quoted(arguments.delimiter)} is not comma, semicolon, tab or another single sign"
            )
    unit = spelled(arguments.unit) if has_unit and arguments.unit is not None else None
    require_unit(unit, "--unit")
    return LayoutOptions(columns, delimiter, arguments.decimal, unit)


def require_ending(file: str | None, option: str, *endings: str) -> None:
    """Raise UsageError for an output, given by `option`, whose name promises another format than those that are written
    under `endings`. A name that promises none is taken as it is."""
    ending = "" if file is None else os.path.splitext(file)[1].lower()
    if ending in _PROMISING and ending not in endings:
        raise UsageError(f"{option}: {quoted(file)} does not end in {listed(endings, 'or')}")


def parse_limit(text: str | None) -> float | None:
    """The value of --limit, g; None without one. Raises UsageError."""
    return None if text is None else parse_number(text, "--limit", ABOVE_0, 1.0, "a number of g above 0, at most 1")


def parse_confidence(text: str) -> float:
    """The value of --confidence. Raises UsageError."""
    return parse_number(text, "--confidence", 0.5, 0.999999)


def parse_seed(text: str) -> int:
    """The value of --seed. Raises UsageError."""
    return parse_whole(text, "--seed", 0, LARGEST_SEED)


def parse_whole(text: str, option: str, low: int, high: int) -> int:
    """The value of an option, a whole number of a range. Raises UsageError."""
    if re.fullmatch(r"[0-9]{1,20}", text, re.ASCII) and low <= int(text) <= high:
        return int(text)
    raise UsageError(f"{option}: {quoted(text)} is not a whole number from {low} to {high}")


def parse_number(text: str, option: str, low: float, high: float, what: str = "") -> float:
    """The value of an option, a number of a range, which is `what` is asked for. Raises UsageError."""
    from tumble.files.run_layout import NUMBER

    value = float(text) if NUMBER.fullmatch(text) else math.nan
    if not low <= value <= high:
        raise UsageError(f"{option}: {quoted(text)} is not {what or f'a number from {low:g} to {high:g}'}")
    return value


def workers_of(arguments: argparse.Namespace) -> int:
    """How many processes. Raises UsageError."""
    return 1 if arguments.workers is None else parse_whole(arguments.workers, "--workers", 1, MOST_WORKERS)


@contextmanager
def team_of(arguments: argparse.Namespace, campaign: str, **depends: Any) -> Iterator[Team]:
    """Who does it, by these options. `depends`: on what the results do, beside the program's version; as text it says
    all. Raises TumbleError."""
    count = workers_of(arguments)
    if arguments.cluster is not None and arguments.workers is not None:
        raise UsageError("--cluster: it has workers of its own, --workers is for this machine")
    if arguments.resume is not None and not arguments.resume.endswith(".parquet"):
        raise UsageError(f"--resume: {quoted(arguments.resume)} does not end in .parquet")

    from tumble.workers.over import Team

    team = Team()
    if arguments.resume is not None:
        from tumble.workers.over import Kept

        team.kept = Kept(arguments.resume, {"campaign": campaign, **depends})
    if arguments.cluster is not None:
        from tumble.workers.crews import Cluster

        team.crew = Cluster(arguments.cluster)
    elif count > 1:
        from tumble.workers.crews import Processes

        team.crew = Processes(count)
    with team:
        yield team


class Bar(Protocol):
    """Is told how much more is done; and of how much, if that is known only now."""

    def __call__(self, done: int, of: int | None = None) -> None: ...


@contextmanager
def progress_bar(what: str, total: int | None = None) -> Iterator[Bar]:
    """On a terminal a bar, with the time left."""
    if not on_terminal():
        yield lambda done, of=None: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)

        def advance(done: int, of: int | None = None) -> None:
            bar.update(task, advance=done, total=of)

        yield advance
