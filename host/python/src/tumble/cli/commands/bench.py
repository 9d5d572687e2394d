"""`tumble bench`: the firmware calibrates a block on a simulated stand; numpy confirms; the truth stands beside it."""

from __future__ import annotations

import argparse
import math
import os
import signal
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from tumble import errors
from tumble.cli import options
from tumble.estimators import OPTIMAL
from tumble.messages import on_terminal, tell, warn
from tumble.schedule import file_of
from tumble.terms import parse

if TYPE_CHECKING:
    from tumble.documents.bench import RunWithTruth
    from tumble.files.stand_file import StandFile
    from tumble.world.border import Border
    from tumble.world.folder import RunFolder
    from tumble.world.in_process import OnEvent
    from tumble.world.setup import Setup


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = "Calibrate a block on a simulated stand over CAN with the firmware, and confirm the result."
    parser.epilog = (
        "Writes a run folder: run.csv, bus.log (candump -L), result.json, report.html, inputs/. After a fault:"
        " run.csv as far as it got, bus.log, fault.json, inputs/. After bad input or Ctrl-C: nothing. Exit codes: 0"
        " pass, 1 gravity check failed, the run does not fit its stand, or its uncertainty does not show the limit (NOT"
        " SHOWN), 2 bad input, 3 fault, or firmware and numpy disagree, 77 the bus is not available here, 130"
        " interrupted, the table stopped."
    )
    add_options(parser)
    parser.set_defaults(run_command=run)


def add_options(parser: options.Options, shows_interactive: bool = True) -> None:
    """All that a run can be told. Who refuses --interactive does not show it."""
    options.add(parser, "--seed", remark="; replays a run exactly")
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML); default: the paper's stand")
    parser.add_argument("--block", metavar="FILE", help="file of [block] and [block.true]; overrides the stand's")
    options.add(parser, "--schedule")
    parser.add_argument("--scenario", metavar="FILE", help="faults, and other keys (--keys); overrides the stand file")
    parser.add_argument(
        "--set",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="one key of a scenario, as a line of its file; may be repeated",
    )
    parser.add_argument("--keys", action="store_true", help="print the keys of a scenario, with their ranges")
    parser.add_argument("--samples", metavar="N", help="averaged at a position; default: the stand file's, else 50")
    parser.add_argument(
        "--error-budget",
        metavar="V",
        help="average at a position only until the standard error of every channel's mean is at most this; --samples"
        " is then the maximum",
    )
    options.add(parser, "--estimator", "--model")
    parser.add_argument(
        "--bus",
        metavar="BUS",
        default="inprocess",
        help="inprocess: simulated, in virtual time; socketcan:IF: on this CAN interface, in real time; uml: likewise,"
        " inside user-mode Linux, where the kernel has no CAN; default: inprocess",
    )
    options.add(parser, "--firmware", remark="zcu102: on a real bus only, and not with --interactive; ")
    parser.add_argument(
        "--interactive",
        action="store_true",
        help="you are the operator: the bench shows how to mount the block, waits until you have mounted it (Enter),"
        " and asks what to do after a fault; without it mountings count as done and a fault ends the run"
        if shows_interactive
        else argparse.SUPPRESS,
    )
    options.add(parser, "--limit")
    parser.add_argument(
        "--runs",
        metavar="N",
        help="N runs with seeds from --seed upwards: a line of JSON each, as tumble campaign runs prints it; no folder",
    )
    parser.add_argument("--jobs", metavar="N", help="number of processes for --runs; default: 1")
    parser.add_argument("--out", metavar="DIR", help="run folder, new or empty; default: runs/<UTC time>-<seed>")
    report_choice = parser.add_mutually_exclusive_group()
    report_choice.add_argument(
        "--report",
        action="store_true",
        help="also write report.html into the run folder; default: if its packages are installed, and without --json",
    )
    options.add(report_choice, "--no-report")
    options.add(parser, "--details", "--json")


class Onlooker(Protocol):
    """Somebody who is told of a run in place of the person at the terminal. `pace`: virtual seconds per second."""

    pace: float

    def __call__(self, event: dict[str, Any]) -> None:
        """Take an event (host/world/report.h)."""

    def ended(self, document: RunWithTruth) -> None:
        """Take what the run says of itself at the end."""


def run(arguments: argparse.Namespace, onlooker: Onlooker | None = None) -> int:
    """Simulate, confirm, print. Returns the exit code; raises TumbleError."""
    from tumble.api.solving import complaints
    from tumble.cli.output import print_solution
    from tumble.files.disk import read_bytes
    from tumble.solving.decision import decide
    from tumble.world import border, folder, outcome, realbus, setup

    if arguments.keys:
        print(border.scenario_help(), end="")
        return errors.EXIT_PASS
    bus = realbus.require_bus(arguments.bus)
    _require_one_way(arguments)
    with_report = arguments.runs is None and _wants_report(arguments)
    if arguments.firmware == realbus.BOARD and arguments.interactive:
        raise errors.UsageError(f"--interactive: not with --firmware {realbus.BOARD}")
    if arguments.firmware == realbus.BOARD:
        realbus.require_there(bus, realbus.BOARD)
    files = (arguments.stand, arguments.block, file_of(arguments.schedule), arguments.scenario)
    given = {
        file: read_bytes(file) for file in dict.fromkeys(files) if file is not None
    }  # each is read once: it may be a pipe
    wanted, stand_file = _read_setup(arguments, given)
    extra = None if arguments.scenario is None else given[arguments.scenario]
    scenario = setup.scenario_text(wanted, arguments.scenario, extra, arguments.set)
    wanted = setup.as_declared(wanted, scenario.splitlines())
    gain_record = setup.gain_record(wanted) if wanted.estimator == OPTIMAL else None
    if arguments.runs is not None:
        return _run_many(arguments, scenario, gain_record)
    path = folder.default_path(wanted.seed) if arguments.out is None else arguments.out
    with folder.RunFolder(path, may_make_parent=folder.is_in_default_parent(path)) as made:
        scenario_path = made.add_inputs(given, scenario, gain_record)
        document = _simulate(arguments, wanted, scenario, gain_record, scenario_path, made, onlooker)
        try:
            outcome.require_done(document)
            solution = outcome.confirm(document, made.stage, wanted)
        except errors.BenchFault:
            made.keep(outcome.DOCUMENT, renamed="fault.json")
            tell(f"run folder: {errors.file_name(path)}")
            raise
        text = outcome.result_text(solution, wanted, stand_file, document, arguments.bus, arguments.firmware)
        if with_report:
            _add_report(made, text, arguments.report)
        made.keep(outcome.DOCUMENT, result=text)
    tell(f"run folder: {errors.file_name(path)}")
    warn(complaints(solution))
    print_solution(solution, text if arguments.json else None, f"seed {wanted.seed}", arguments.details)
    return errors.EXIT_PASS if decide(solution).passed else errors.EXIT_LIMITS_FAILED


def _require_one_way(arguments: argparse.Namespace) -> None:
    """Raise UsageError for what is of one run alone, or of many."""
    if arguments.runs is None and arguments.jobs is not None:
        raise errors.UsageError("--jobs: needs --runs")
    if arguments.runs is not None and (
        arguments.out is not None or arguments.interactive or arguments.report or arguments.model
    ):
        raise errors.UsageError("--runs: takes no --out, --interactive, --report or --model")
    if arguments.runs is not None and arguments.bus != "inprocess":
        raise errors.UsageError("--runs: runs inprocess alone, not on a real bus")


def _run_many(arguments: argparse.Namespace, scenario: str, gain_record: bytes | None) -> int:
    """Calibrate, and print lines as they come. Returns the exit code."""
    from tumble.cli.commands import campaign
    from tumble.world import campaigns

    options.parse_whole(arguments.jobs or "1", "--jobs", 1, options.MOST_WORKERS)
    seed, count = campaign.seeds(arguments, "--runs", arguments.runs)
    arguments.workers, arguments.cluster, arguments.resume, arguments.summary = arguments.jobs, None, None, False
    _world(arguments, seed, scenario, gain_record)  # what is refused is refused once
    job = campaigns.Runs(tuple(scenario.splitlines()), arguments.scenario or "scenario", False, gain_record)
    return campaign.print_runs(arguments, job, seed, count)


def _wants_report(arguments: argparse.Namespace) -> bool:
    """Is one to be left? Raises NotInstalled where it is asked for and cannot be made."""
    if not arguments.report:
        return not (arguments.no_report or arguments.json or os.environ.get(options.NO_REPORT))
    from tumble.report.make import HTML, require_installed

    require_installed(HTML)
    return True


def _read_setup(arguments: argparse.Namespace, given: dict[str, bytes]) -> tuple[Setup, StandFile | None]:
    """Everything that the files and options say: the setup, and the stand file or None."""
    seed = options.parse_seed(arguments.seed)
    limit_g = options.parse_limit(arguments.limit)
    terms = parse(arguments.model, arguments.estimator)

    from tumble.core import MAX_SAMPLES
    from tumble.files.schedule_file import read_schedule
    from tumble.files.stand_file import read_block, read_stand
    from tumble.solving.computation import require_told_apart
    from tumble.world.setup import setup_of

    samples = None if arguments.samples is None else options.parse_whole(arguments.samples, "--samples", 1, MAX_SAMPLES)
    error_budget_v = 0.0
    if arguments.error_budget is not None:
        most_v, volts = math.nextafter(1e9, 0.0), "a number of volts above 0"
        error_budget_v = options.parse_number(arguments.error_budget, "--error-budget", options.ABOVE_0, most_v, volts)
    name = arguments.schedule or "paper"
    schedule = read_schedule(name, given.get(name), arguments.estimator)
    require_told_apart(schedule.data, terms)
    file = None if arguments.stand is None else read_stand(arguments.stand, given[arguments.stand])
    others: dict[str, Any] = {}
    if arguments.block is not None:
        others["block"], others["truth"] = read_block(arguments.block, given[arguments.block])
    setup = setup_of(
        seed,
        file,
        schedule,
        samples,
        limit_g,
        stand_file=arguments.stand or "",
        block_file=arguments.block or arguments.stand or "",
        error_budget_v=error_budget_v,
        estimator=arguments.estimator,
        terms=terms,
        **others,
    )
    return setup, file


def _simulate(
    arguments: argparse.Namespace,
    wanted: Setup,
    scenario: str,
    gain_record: bytes | None,
    scenario_path: Path,
    made: RunFolder,
    onlooker: Onlooker | None,
) -> RunWithTruth:
    """Let it run. Returns its document; raises where there is none, or the user did not want to wait for it."""
    from tumble.world import realbus
    from tumble.world.progress import LiveProgress, Progress

    kind = LiveProgress if on_terminal() else Progress
    seen = kind(wanted.schedule.data, arguments.interactive) if onlooker is None else nullcontext(onlooker)
    with seen as progress:
        if arguments.bus == realbus.INPROCESS:
            pace = 0.0 if onlooker is None else onlooker.pace
            border = _world(arguments, wanted.seed, scenario, gain_record)
            document = _inside(border, made, progress, pace)
        else:
            document = _outside(arguments, wanted, scenario_path, made, progress)
    if onlooker is not None:
        onlooker.ended(document)
    return document


def _inside(border: Border, made: RunFolder, progress: OnEvent, pace: float) -> RunWithTruth:
    """In a world within this process."""
    from tumble.files.disk import reason
    from tumble.world import in_process

    interrupted = in_process.Run(border, progress, pace).to_its_end()
    try:
        document = in_process.write(border, made.stage)
    except OSError as error:
        raise errors.BadInput(f"cannot be written: {reason(error)}", made.path) from None
    if interrupted:
        raise _interrupted(document.table.at_rest)
    return document


def _world(arguments: argparse.Namespace, seed: int, scenario: str, gain_record: bytes | None) -> Border:
    """Powered on. Raises UsageError."""
    from tumble.world.border import OPERATORS, Border, Refused

    lines, operator = scenario.splitlines(), "asked" if arguments.interactive else OPERATORS[0]
    try:
        return Border(seed, lines, gain_record, operator)
    except Refused as refused:
        is_told = refused.line > len(lines) - len(arguments.set)
        where = f"--set: {refused}" if is_told else refused.where(arguments.scenario or "scenario")
        raise errors.UsageError(f"this cannot be simulated: {where}") from None


def _interrupted(at_rest: bool) -> errors.Interrupted:
    return errors.Interrupted("interrupted; " + ("the table is at rest" if at_rest else "THE TABLE MAY STILL TURN"))


def _outside(
    arguments: argparse.Namespace, wanted: Setup, scenario_path: Path, made: RunFolder, progress: OnEvent
) -> RunWithTruth:
    """By programs on a real bus."""
    from tumble.world import realbus

    given = arguments.bus, arguments.firmware, scenario_path, wanted.seed, made.stage
    ended, document = realbus.run(*given, progress, wanted.schedule.data, arguments.interactive)
    if ended.interrupted or ended.code == errors.Interrupted.exit_code:
        never_began = ended.code == -signal.SIGTERM  # it did not get so far as to listen to signals
        raise _interrupted(never_began or (document is not None and document.table.at_rest))
    _, _, said = ended.complaint.partition(": ")
    at_fault, _, why = said.partition(f"{made.stage / 'bench'}: ")
    if ended.code == errors.BadInput.exit_code and why and not at_fault:  # the program could not write what it had to
        raise errors.BadInput(why, made.path)
    complaint = ended.complaint.replace(str(scenario_path), arguments.scenario or "scenario")
    if ended.code == errors.BadInput.exit_code:
        raise errors.UsageError(f"this cannot be simulated: {complaint}")
    if document is None:
        raise errors.BenchFault(f"the run failed ({ended.code}): {complaint or 'it says nothing'}")
    for file in (made.stage / "bench").iterdir():
        file.rename(made.stage / file.name)
    (made.stage / "bench").rmdir()
    return document


def _add_report(made: RunFolder, result: str, is_asked_for: bool) -> None:
    """One that nobody asked for must not cost the run. Raises TumbleError for one that was."""
    try:
        from tumble.api.recording import recording_of
        from tumble.api.result import Result
        from tumble.files.run_layout import LayoutOptions
        from tumble.report.make import HTML

        run = recording_of(made.stage / "run.csv", LayoutOptions(unit="V"))
        made.add("report.html", Result(result).reported(HTML, run))
    except errors.NotInstalled as error:
        tell(f"tumble: the run is made without a report: {error}; --no-report leaves this line out")
    except errors.TumbleError as error:
        if is_asked_for:
            raise
        tell(f"tumble: no report is left: {error}")
