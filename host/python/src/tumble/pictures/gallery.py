"""Which pictures there are of a result, and what each of them needs."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from msgspec import UNSET

from tumble.core import CoreSchedule
from tumble.documents.result import Result
from tumble.errors import UsageError, quoted
from tumble.files.schedule_file import schedule_of
from tumble.files.stand_file import StandFile, stand_file_of
from tumble.pictures import canvas, result, uncertainty
from tumble.pictures.result import Facts, Recorded
from tumble.solving import result as results
from tumble.solving.expected import expected, measured_schedule

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SEEN = "The errors of the stand as the run itself shows them, with their expanded uncertainties"
CAPTIONS = {
    "gravity_check": "The length of gravity that the calibrated block shows at each position, less 1 g. It must stay"
    " within the limit; at check positions, which were not fitted, this says most.",
    "residuals": "Mean output minus the value computed from the coefficients, at each position, channel by channel. The"
    " grey band holds 95 % of what the errors that the legend names would leave by themselves.",
    "samples": "All samples of the run. Every stretch, grey or white, is averaged for the position that is named"
    " above it.",
    "budget": "Where the uncertainty of each coefficient comes from: the shares of the stand's sources of error in its"
    " variance.",
    "stand_seen": f"{_SEEN}, beside what is declared of the stand.",
    "inclinations": "How the outputs say where level is: at each inclination of the stand, of the part that turns with"
    " the table how much is left across the axis, over how far the part that does not turn has moved. The parabola"
    " through them is highest where the axis is level.",
    "correlation": "How the errors of the twelve coefficients go together: +1 is as one, -1 is against each other, 0 is"
    " not at all.",
    "attitude": "The standard uncertainty of the length of the specific force that the calibrated block shows, over all"
    " its directions on the block's axes. The star marks the worst.",
}
_RESULT = "result"
_A_STAND = "a result that was solved with a stand"
_NEEDS: dict[str, tuple[Callable[[Facts], Figure], Callable[[Facts], bool], str]] = {
    "gravity_check": (result.gravity_check, lambda facts: True, ""),
    "residuals": (result.residuals, lambda facts: facts.schedule is not None, "the schedule (schedule=)"),
    "samples": (result.samples, lambda facts: facts.run is not None, "the run (run=)"),
    "budget": (
        uncertainty.budget,
        lambda facts: facts.expected is not None and facts.expected.is_uncertain,
        "the stand and the schedule (stand=, schedule=)",
    ),
    "stand_seen": (
        result.stand_seen,
        lambda facts: len(result.rows(facts)) > 1,  # of one number a table says as much
        "a run that shows angles of its stand",
    ),
    "inclinations": (
        result.inclinations,
        lambda facts: facts.schedule is not None and facts.result.inclinations is not UNSET,
        "a run of a block that was inclined as it was bolted on",
    ),
    "correlation": (uncertainty.correlation, lambda facts: facts.result.covariance is not None, _A_STAND),
    "attitude": (uncertainty.attitude, lambda facts: facts.result.u_norm_g is not None, _A_STAND),
}


def kinds() -> tuple[str, ...]:
    """The names of all pictures, in their order."""
    return tuple(_NEEDS)


def figures(
    solved: Result,
    run: Recorded | None = None,
    schedule: Any = None,
    *,
    stand: Any = None,
    kind: str | None = None,
) -> dict[str, Figure]:
    """The pictures of a result, by name, as far as there is what each of them needs.

    `solved`: the result, as documents.result reads it. `run`: what was solved, as `tumble.read` returns it. `schedule`,
    by name, path or object, and `stand`, path or object: those that the result does not carry, as earlier versions
    wrote it; a built-in schedule is found by itself. `kind`: this one alone.

    Raises UsageError for a `kind` that is none, or that lacks something, and for a run, a schedule or a stand that is
    not the result's; BadInput for files that cannot be read; NotInstalled where matplotlib is not there.
    """
    if kind is not None and not (isinstance(kind, str) and kind in _NEEDS):
        raise UsageError(f"kind: {quoted(kind)} is not one of {', '.join(_NEEDS)}")
    canvas.require("a picture")
    given = None if schedule is None else schedule_of(schedule), None if stand is None else stand_file_of(stand)
    facts = _facts(solved, run, *given)
    if kind is not None and not _NEEDS[kind][1](facts):
        raise UsageError(f"kind: {kind} needs {_NEEDS[kind][2]}")
    wanted = {name: draw for name, (draw, is_known, _) in _NEEDS.items() if kind in (None, name) and is_known(facts)}
    return {name: draw(facts) for name, draw in wanted.items()}


def caption(name: str, solved: Result) -> str:
    """A sentence or two for a picture of this result: of what is declared only where anything is."""
    return CAPTIONS[name] if solved.stand or name != "stand_seen" else f"{_SEEN}."


def _facts(solved: Result, run: Recorded | None, schedule: CoreSchedule | None, given: StandFile | None) -> Facts:
    if run is not None:
        result.require_same_run(solved, run)
    planned = results.schedule_of(solved, _RESULT) if schedule is None else schedule
    on = measured_schedule(solved, None if planned is None else planned.data)
    if given is not None:
        found = None if on is None else expected(solved, on, given.stand, given.step_v)
        return Facts(solved, run, on, given.stand, found)
    known, found = results.stand_of(solved, _RESULT), None
    if on is not None and known is not None:
        # Where a result had more to go by, nothing is known of it by its own stand: `optimal` of a computer that has a
        # record of gains has other uncertainties than its stand leaves this run.
        with suppress(UsageError):
            found = expected(solved, on, known, results.step_of(solved))
    return Facts(solved, run, on, known, found)
