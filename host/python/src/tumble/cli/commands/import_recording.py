"""`tumble import`: continuous recordings in, a run file out, with all that was taken for granted."""

from __future__ import annotations

import argparse
import math
import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from tumble.cli import options
from tumble.defaults import DEFAULT_SCHEDULE
from tumble.errors import EXIT_PASS, BadInput, TumbleError, UsageError, quoted
from tumble.estimators import HARMONIC, LEAST_SQUARES, OPTIMAL
from tumble.schedule import ANY_POSE, file_of

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

    from tumble.importing.attitudes import Signs
    from tumble.importing.pipeline import Imported, Settings
    from tumble.importing.rests import Thresholds

SettingsT = TypeVar("SettingsT", bound="DataclassInstance")

_REPEATS = ("first", "last", "longest")
_WIDTH = 80
_BYTES_OF_ROW = 40  # roughly


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Find the rests in time-stamped recordings, match them to the positions of a schedule by the"
        " direction of gravity, and write a run file. Assumptions are listed; ambiguous recordings are refused."
    )
    parser.epilog = (
        "Exit codes: 0 done, 2 bad input or an ambiguous recording, 77 a package is missing, 130 interrupted."
    )
    parser.add_argument(
        "recordings",
        metavar="RECORDING",
        nargs="+",
        help="CSV of a logger, a RAWIMU log (ASCII), a CAN log, TDMS, HDF5, ULog, DataFlash, a ROS bag, MCAP, Parquet,"
        " NPZ or MAT; several are one run, in this order",
    )
    options.add(parser, "--schedule", remark=f", {ANY_POSE}")
    parser.add_argument("--stand", metavar="FILE", help="stand file: its scale_v_per_g gives the signs of K")
    parser.add_argument("--signs", metavar="+++", help="signs of K_xx, K_yy, K_zz, such as -+-; default: the stand's")
    parser.add_argument(
        "--order", choices=("schedule", "any"), help="order in which positions were measured; default: the schedule's"
    )
    parser.add_argument("--repeats", choices=_REPEATS, help="which of several rests at one position to take")
    parser.add_argument("--leave-out", metavar="N,...", help="numbers of rests to ignore")
    parser.add_argument("--take", metavar="N,...", help="numbers of rests to take in spite of their deviation")
    parser.add_argument("--mountings", metavar="NAME=N,...", help="numbers for named mountings")
    parser.add_argument("--recipe", metavar="FILE", help="take the options from this file; it is written if missing")
    parser.add_argument("--out", metavar="RUN.csv", help="write the run file")
    parser.add_argument("--plot", metavar="FILE", help="draw the recording: .png, .svg or .pdf; needs matplotlib")
    options.add(parser, "--json")
    layout = options.add_layout(parser, "recordings", "ux=AccX,time=Tick")
    layout.add_argument("--time-unit", choices=("s", "ms", "us", "ns", "min", "h", "d"), help="unit of a numeric clock")
    layout.add_argument("--rate", metavar="HZ", help="samples a second; replaces the file's clock")
    which = "rows of one source: COLUMN=VALUE or source=NAME, 1/2 (the first of every two) or 2:481 (lines)"
    layout.add_argument("--rows", metavar="WHICH", help=which)
    bus = parser.add_argument_group("CAN logs", "candump, ASC, BLF, TRC, MF4, CSV of python-can")
    bus.add_argument("--dbc", metavar="FILE", help="of other frames than our block's; --columns names their signals")
    bus.add_argument("--can-id", metavar="ID", help="first identifier of the block, of several, such as 0x684")
    bus.add_argument("--can-channel", metavar="NAME", help="interface, of several that have such frames")
    rests = parser.add_argument_group("detection of rests")
    rests.add_argument("--still", metavar="X", help="scatter in a window, at most, in units of the noise; default: 2.5")
    rests.add_argument("--drift", metavar="X", help="of block means in a window, likewise; default: 8")
    rests.add_argument("--window", metavar="S", help="seconds (without a clock: samples); default: 0.4 (40)")
    rests.add_argument("--min-rest", metavar="S", help="the shortest rest, likewise; default: 0.6 (60)")
    rests.add_argument("--tolerance", metavar="DEG", help="how far off its position gravity may be; default: 6")
    parser.set_defaults(run_command=run, parser=parser)


def run(arguments: argparse.Namespace) -> int:
    """Import and tell. Returns the exit code; raises TumbleError."""
    from tumble.documents.base import to_json
    from tumble.files.disk import refuse_overwriting, write_all
    from tumble.importing import report

    sources = (*arguments.recordings, arguments.stand, arguments.dbc, file_of(arguments.schedule))
    for option in ("out", "plot", "recipe"):
        refuse_overwriting(getattr(arguments, option), *sources, option=f"--{option}")
    outputs = [os.path.realpath(one) for one in (arguments.out, arguments.plot, arguments.recipe) if one is not None]
    if len(set(outputs)) < len(outputs):
        raise UsageError("--out, --plot and --recipe: two of them name the same file")
    options.require_ending(arguments.out, "--out", ".csv")
    options.require_ending(arguments.recipe, "--recipe", ".toml")
    if arguments.plot is not None:
        from tumble.pictures import require_format

        require_format(arguments.plot, "--plot")
    replayed = arguments.recipe is not None and os.path.exists(arguments.recipe)
    try:
        done, settings, about_stand = _imported(arguments)
    except (BadInput, UsageError) as refusal:
        refusal.remedy = _remedy(refusal, arguments) if refusal.assumed else ""
        raise
    remarks = [f"recipe {os.path.basename(arguments.recipe)} followed"] if replayed else []
    done = replace(done, notes=(*remarks, *about_stand, *done.notes))
    after = _after_import(done, arguments.out, arguments.stand)
    found = report.document(done)
    text = to_json(found) if arguments.json else report.text(found) + after
    files: dict[str, bytes] = {}
    if arguments.out is not None:
        files[arguments.out] = report.run_csv(done).encode()
    if arguments.plot is not None:
        from tumble.pictures import written
        from tumble.pictures.recording import recording

        files[arguments.plot] = written(recording(done), arguments.plot)
    if arguments.recipe is not None and not replayed:
        files[arguments.recipe] = report.recipe_text(settings).encode()
    write_all(files)
    sys.stdout.write(text)
    return EXIT_PASS


def _imported(arguments: argparse.Namespace) -> tuple[Imported, Settings, list[str]]:
    """By these options; the settings that they make, and remarks on the stand file. Raises TumbleError."""
    from tumble.files.schedule_file import read_schedule
    from tumble.importing.any_pose import POSES
    from tumble.importing.pipeline import import_recordings

    replayed = arguments.recipe is not None and os.path.exists(arguments.recipe)
    signs, signs_from, about_stand = _told_signs(arguments)
    settings = _settings(arguments, replayed, signs, signs_from)
    is_any = settings.schedule_name == ANY_POSE
    schedule = POSES if is_any else read_schedule(settings.schedule_name).data
    done = import_recordings(arguments.recordings, schedule, settings)
    if is_any:  # what was not measured does not lack
        done = replace(
            done, schedule=schedule.part(index in done.matched.positions for index in range(len(schedule.positions)))
        )
    return done, settings, about_stand


def _remedy(refusal: TumbleError, arguments: argparse.Namespace) -> str:
    """The command that imports what was refused, as it has been tried; empty where none was found."""
    from tumble.importing import remedies

    said = {name: value for name, value in vars(arguments).items() if isinstance(value, str)}

    def changed(chosen: dict[str, str | None]) -> argparse.Namespace:
        options = {name: value and remedies.joined(said, {name: value})[name] for name, value in chosen.items()}
        return argparse.Namespace(**{**vars(arguments), **options})

    def attempt(chosen: dict[str, str | None]) -> TumbleError | int:
        try:
            done, *_ = _imported(changed(chosen))
        except TumbleError as fault:
            return fault
        return len(done.schedule.positions) - len(set(done.matched.positions.tolist()) - {-1})

    rows = sum(os.path.getsize(file) for file in arguments.recordings if os.path.isfile(file)) // _BYTES_OF_ROW
    found = remedies.found(refusal, said, rows, attempt)
    if found is None:
        return ""
    heading = f"remedy, if {found.condition}:" if found.condition else "remedy:"
    return "\n".join([heading, *_command_lines(*_command_parts(changed(dict(found.options))))])


def _command_parts(arguments: argparse.Namespace) -> list[list[str]]:
    """The command that these options make: the arguments of each part of a line."""
    parts = [[os.environ.get("TUMBLE_PROGRAM", "tumble"), "import"], *([one] for one in arguments.recordings)]
    for action in arguments.parser._actions:
        value, option = getattr(arguments, action.dest, None), (action.option_strings or [""])[-1]
        if option and value is True:
            parts.append([option])
        elif option and isinstance(value, str):
            parts.append([f"{option}={value}"] if value.startswith("-") or option == "--signs" else [option, value])
    return parts


def _settings(arguments: argparse.Namespace, replayed: bool, signs: Signs | None, signs_from: str | None) -> Settings:
    """The recipe's, or the usual ones, with what the options say, and the `signs` that they say. Raises TumbleError."""
    from tumble.files.stand_file import read_stand
    from tumble.importing import report
    from tumble.importing.pipeline import Settings
    from tumble.importing.recording import COLUMNS, Choice

    base = report.read_recipe(arguments.recipe) if replayed else Settings()
    told = options.layout_options(arguments, COLUMNS, may_lack=COLUMNS[3:])
    given = {"delimiter": told.delimiter, "decimal": told.decimal, "unit": told.unit}
    layout = _with(base.layout, columns=base.layout.columns | told.columns, **given)
    rate_hz = None if arguments.rate is None else _positive(arguments.rate, "--rate")
    mountings = None if arguments.mountings is None else _parse_mountings(arguments.mountings)
    thresholds = _thresholds(arguments, base.thresholds)
    degrees = None if arguments.tolerance is None else _positive(arguments.tolerance, "--tolerance", 45.0)
    user_choices = _with(
        base.user_choices,
        signs=signs,
        signs_from=signs_from,
        order=arguments.order,
        tolerance=degrees and math.radians(degrees),
        repeats=arguments.repeats,
        leave_out=_parse_rests(arguments.leave_out, "--leave-out"),
        take=_parse_rests(arguments.take, "--take"),
    )
    identifier = None
    if arguments.can_id is not None:
        try:
            identifier = int(arguments.can_id, 0)
        except ValueError:
            raise UsageError(f"--can-id: {quoted(arguments.can_id)} is not an identifier such as 0x683") from None
    step_v = None if arguments.stand is None else read_stand(arguments.stand).step_v
    where = {"dbc": arguments.dbc, "identifier": identifier, "channel": arguments.can_channel}
    bus, timing = _with(base.bus, **where, v_per_count=step_v), _with(base.timing, rate_hz=rate_hz)
    rows = base.rows if arguments.rows is None else Choice.parsed(arguments.rows)
    parts = {
        "rows": rows,
        "layout": layout,
        "timing": _with(timing, unit=arguments.time_unit),
        "bus": bus,
        "user_choices": user_choices,
    }
    return _with(base, schedule=arguments.schedule, thresholds=thresholds, mountings=mountings, **parts)


def _with(base: SettingsT, **said: Any) -> SettingsT:
    """With what is said; None: nothing is."""
    return replace(base, **{name: value for name, value in said.items() if value is not None})


def _thresholds(arguments: argparse.Namespace, base: Thresholds) -> Thresholds:
    said: dict[str, float | None] = {
        name: _positive(getattr(arguments, name), f"--{name}")
        for name in ("still", "drift")
        if getattr(arguments, name) is not None
    }
    for option, name in (("window", "window"), ("min-rest", "min_rest")):
        text = getattr(arguments, name)
        if text is None:
            continue
        value = _positive(text, f"--{option}")
        said |= {f"{name}_s": value, f"{name}_samples": int(value) if value >= 1 and value == int(value) else None}
    return replace(base, **said)  # type: ignore[arg-type] # samples are whole, the rest are not


def _told_signs(arguments: argparse.Namespace) -> tuple[Signs | None, str | None, list[str]]:
    """The signs of K that the options say, where a stand file has them, and remarks on it; None: they say none."""
    from tumble.files.stand_file import read_stand
    from tumble.importing.report import parse_signs
    from tumble.stand import by_channel

    of_stand, source, remarks = None, None, []
    if arguments.stand is not None:
        block, name = read_stand(arguments.stand).block, os.path.basename(arguments.stand)
        if block is None:
            remarks = [f"signs of K: {name} has no [block], and tells none"]
        else:
            x, y, z = (1 if scale > 0 else -1 for scale in by_channel(block["scale_v_per_g"]).tolist())
            of_stand, source = (x, y, z), f"from scale_v_per_g in {name}"
    if arguments.signs is None:
        return of_stand, source, remarks
    if (signs := parse_signs(arguments.signs)) is None:
        told = quoted(arguments.signs)
        raise UsageError(f"--signs: {told} is not three of + and -, of x, y and z, such as --signs=+-+")
    return signs, None, []


def _parse_rests(text: str | None, option: str) -> frozenset[int]:
    """Read `3,7`."""
    if text is None:
        return frozenset()
    return frozenset(options.parse_whole(part.strip(), option, 1, 10**6) for part in text.split(","))


def _parse_mountings(text: str) -> dict[str, int]:
    """Read `A=1,B=2`."""
    found: dict[str, int] = {}
    for part in text.split(","):
        name, equals, number = (piece.strip() for piece in part.partition("="))
        if not equals or not name or name in found:
            raise UsageError(f"--mountings: {quoted(part)} is not NAME=NUMBER, each name once")
        found[name] = options.parse_whole(number, "--mountings", 1, 255)
    return found


def _positive(text: str, option: str, most: float = 1e6) -> float:
    return options.parse_number(text, option, options.ABOVE_0, most, f"a number above 0, at most {most:g}")


def _after_import(done: Imported, run: str | None, stand: str | None) -> str:
    """The lines that are said last: the command that solves the run file which has been written, on lines that a shell
    joins; an option and its value stay together. `run`: that file, None where none was asked for; `stand`: the stand
    file, if any. The program is called as it was: tools/tumble of a checkout says how, by TUMBLE_PROGRAM."""
    from tumble.core import CoreSchedule
    from tumble.files.schedule_file import default_estimator
    from tumble.model.inclined import layout

    has_closed_form = default_estimator(CoreSchedule(done.schedule)) in HARMONIC  # which needs every position

    if run is None:
        return "\nNext: the same with --out RUN.csv, which writes the run file for tumble solve.\n"
    command = [os.environ.get("TUMBLE_PROGRAM", "tumble"), "solve", run]
    if done.settings.schedule_name != DEFAULT_SCHEDULE:
        command += ["--schedule", done.settings.schedule_name]
    command += [] if stand is None else ["--stand", stand]
    present = set(done.matched.positions.tolist())
    measured = done.schedule.part(index in present for index in range(len(done.schedule.positions)))
    if layout(done.schedule) is not None:
        if layout(measured) is None:
            return (
                "\nNext: measure the missing rest, or leave out that inclination: the estimator inclined takes"
                "\ninclinations on both sides of the level, three or more, turned in equal steps.\n"
            )
    elif has_closed_form and len(measured.fit_indices) < len(done.schedule.fit_indices):
        command += ["--estimator", LEAST_SQUARES if stand is None else OPTIMAL]  # of the positions that were found
    command += ["--out", os.path.join(os.path.dirname(run), "result.json")]  # which apply and report take
    lines = _command_lines(command[:2], command[2:3], *zip(command[3::2], command[4::2]))
    if done.settings.schedule_name == "six_faces" and stand is None:
        lines += ["Its limit is a rotary stand's: import faces that were laid by hand with", "  --schedule hand_laid"]
    return "\n".join(["", "Next:", *lines, ""])


def _command_lines(first: Sequence[str], *parts: Sequence[str]) -> list[str]:
    """A command on lines that a shell joins; the arguments of one part stay together."""
    lines = ["  " + " ".join(map(shlex.quote, first))]
    for part in (" ".join(map(shlex.quote, arguments)) for arguments in parts):
        if len(lines[-1]) + len(part) + len("  \\") > _WIDTH:
            lines[-1] += " \\"
            lines.append(f"    {part}")
        else:
            lines[-1] += f" {part}"
    return lines
