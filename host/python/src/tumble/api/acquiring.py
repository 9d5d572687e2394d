"""A run on one's own stand: functions that turn the table and read the block, or an operator who is asked."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from tumble import prompts
from tumble.acquisition.run import DEFAULT_REST_TIMEOUT_S, DEFAULT_SAMPLES, Acquisition, AcquisitionPlan, Drive, rows_in
from tumble.api.arguments import as_number, require_flag, require_unit, told_in_python
from tumble.api.result import Result
from tumble.api.solving import solve
from tumble.defaults import DEFAULT_SCHEDULE
from tumble.errors import BadInput, Interrupted, UsageError
from tumble.files.disk import path_of
from tumble.files.schedule_file import schedule_of
from tumble.messages import tell
from tumble.schedule import Mounting, Position, Schedule

_ANSWERS = "Enter: it is done; abort: stop here"


class Operator:
    """Who mounts the block and turns a table that nothing drives, asked on the terminal. An answer "abort", or the end
    of standard input, raises Interrupted."""

    def __init__(self, schedule: Schedule, say: Callable[[str], object] = tell):
        self._schedule, self._say = schedule, say
        self._on_table: int | None = None

    def mount(self, mounting: Mounting) -> None:
        """The block as the mounting says, or the stand inclined."""
        self._ask(prompts.to_mount(self._schedule, mounting.number, self._on_table, _ANSWERS))
        self._on_table = mounting.number

    def turn(self, position: Position) -> None:
        """The table to the angle of a position. A block that is laid by hand needs no table."""
        if self._schedule.is_laid_by_hand:
            return
        self._ask(prompts.to_turn(self._schedule, position.mounting, position.angle_deg, _ANSWERS))

    def _ask(self, lines: list[str]) -> None:
        prompts.forget_what_was_typed()
        for line in lines:
            self._say(line)
        while (answer := prompts.read_answer()) != prompts.DONE:
            if answer == prompts.ABORT:
                raise Interrupted("stopped by the operator")
            self._say(f"not understood: {answer} [{_ANSWERS}]")


def acquired(plan: AcquisitionPlan, resume: bool, report: Callable[[str], object] = tell) -> None:
    """Make the run, or what is left of it. Raises BadInput for a file that is there already, or cannot be continued."""
    there = os.path.lexists(plan.file)
    if there and not resume:
        raise BadInput("is there already; remove it, or go on with it (--resume)", plan.file)
    rows = rows_in(plan.file, plan.unit, plan.schedule) if there else {}
    acquisition = Acquisition(plan, rows, report)
    if acquisition.rows:
        report(f"{len(acquisition.rows)} of {len(plan.schedule.positions)} positions are there already")
    acquisition.run()


def acquire(
    *,
    read: Callable[[], Any],
    out: str | os.PathLike[str],
    move: Callable[[float], Any] | None = None,
    stop: Callable[[], Any] | None = None,
    limits_deg: tuple[float, float] | None = None,
    mount: Callable[[Mounting], Any] | None = None,
    schedule: Schedule | str | os.PathLike[str] | None = None,
    samples: int = DEFAULT_SAMPLES,
    unit: str = "V",
    rest_timeout_s: float = DEFAULT_REST_TIMEOUT_S,
    resume: bool = False,
    report: Callable[[str], Any] = tell,
    **solving: Any,
) -> Result:
    """Make a run on a stand of one's own, and solve it.

    At each position of the schedule the table is turned, the block is read until it is at rest, as its own outputs
    show, and `samples` of it are kept. After every position the run file `out` is written as a whole.

    Parameters
    ----------
    read : callable
        Returns one sample, three outputs in `unit`, or several, an array (n, 3).
    out : path
        The run file, CSV, which must not be there yet.
    move : callable, optional
        Turns the table to an angle in degrees, returns when it is there. Without it somebody is asked to turn it.
    stop : callable
        Needed with `move`: stops the table; always called when the run ends, from an exception in `move` to Ctrl-C.
    limits_deg : pair of float
        Needed with `move`: the lowest and the highest angle. A schedule beyond is refused before anything moves.
    mount : callable, optional
        Called with a tumble.Mounting before its first position, returns when block and stand are so. Without it
        somebody is asked on the terminal.
    schedule : str, path or Schedule, optional
        As of `solve`; default: "paper".
    samples : int, optional
        Kept at each position, 50 to 100000.
    unit : str, optional
        Of the outputs, such as "V" or "m/s^2".
    rest_timeout_s : float, optional
        How long the block may take to come to rest at a position.
    resume : bool, optional
        Go on from the positions that `out` has.
    report : callable, optional
        Gets a line for each position, with the largest gravity error so far; default: on standard error.
    solving : any, optional
        Arguments of `solve` by name: `stand`, `estimator`, `limit_g`, `confidence`, `model`.

    Returns
    -------
    Result
        As `solve` gives it.

    Raises
    ------
    BenchFault
        For a block that does not come to rest, or a table that cannot be stopped; and what `solve` raises.
    """
    require_unit(unit, "unit")
    require_flag(resume, "resume")
    drive = _drive(move, stop, limits_deg)
    with told_in_python():
        planned = schedule_of(DEFAULT_SCHEDULE if schedule is None else schedule).data
        operator = Operator(planned, report)
        plan = AcquisitionPlan(
            schedule=planned,
            samples=samples,
            unit=unit,
            file=path_of(out),
            read=read,
            mount=mount or operator.mount,
            drive=drive,
            turn_by_hand=operator.turn,
            rest_timeout_s=rest_timeout_s,
        )
        acquired(plan, resume, report)
    return solve(out, schedule=schedule, **solving)


def _drive(move: Any, stop: Any, limits_deg: Any) -> Drive | None:
    """Raises UsageError for motion that is not bounded."""
    if move is None:
        if stop is not None or limits_deg is not None:
            raise UsageError("stop and limits_deg are of a table that move turns")
        return None
    try:
        low, high = limits_deg
    except (TypeError, ValueError):
        raise UsageError(
            "limits_deg: (low, high), degrees, is needed with move: nothing moves without limits"
        ) from None
    if not callable(stop):
        raise UsageError("stop: a function that stops the table is needed with move")
    return Drive(move, stop, (as_number(low), as_number(high)))
