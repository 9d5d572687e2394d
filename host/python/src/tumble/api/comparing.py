"""Two results held against each other: the one way, of `tumble.compare` and of the command line."""

from __future__ import annotations

import json
import os
from typing import Any

from tumble.api.arguments import as_number, in_python, is_one_of, require_flag, told_in_python
from tumble.api.result import Result, load
from tumble.comparison import pair, report
from tumble.comparison.pair import OneStand
from tumble.core import CoreSchedule
from tumble.defaults import ANEW, DEFAULT_CONFIDENCE, LEVELLED
from tumble.documents import comparison as types
from tumble.documents.base import to_json
from tumble.errors import UsageError, quoted
from tumble.files.schedule_file import schedule_of
from tumble.files.stand_file import StandFile, stand_file_of
from tumble.schedule import BUILT_IN, Schedule
from tumble.solving.decision import complaints_of_result
from tumble.stand import Stand


class Comparison:
    """What `tumble.compare` found of a block that was calibrated twice. Immutable."""

    def __init__(self, told: types.Comparison):
        self._told, self._text = told, to_json(told)

    @property
    def checked(self) -> types.Comparison:
        """The same by its types, tumble.documents.comparison."""
        return self._told

    @property
    def document(self) -> dict[str, Any]:
        """All that is known, as the command line writes it: schema tumble.comparison/1, docs/files.md explains every
        key. A copy."""
        found: dict[str, Any] = json.loads(self._text)
        return found

    @property
    def verdict(self) -> str:
        """Of "unchanged", "seat" (only the seat has changed), "block" (the block has), "cannot tell"."""
        return self._told.verdict

    @property
    def block_changed(self) -> bool | None:
        """None where nobody can tell: for want of uncertainties, or because a result failed its check."""
        return None if self.verdict == "cannot tell" else self.verdict == "block"

    @property
    def changed(self) -> tuple[str, ...]:
        """Names of the parameters of the block that have changed by themselves, such as "scale_x"."""
        return self._told.changed

    @property
    def sentence(self) -> str:
        """What was found, in plain words."""
        return in_python(report.sentence(self._told))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Why the comparison may not be what it claims: the sentences that the command line prints, with arguments in
        place of options, as in all that follows."""
        return tuple(map(in_python, self._told.warnings))

    @property
    def notes(self) -> tuple[str, ...]:
        """What the comparison rests on, and what it leaves out."""
        return tuple(map(in_python, self._told.notes))

    @property
    def text(self) -> str:
        """As `tumble compare` prints it."""
        return report.render(self._told, in_python)

    def to_json(self) -> str:
        """As `tumble compare --json` prints it."""
        return self._text

    def __repr__(self) -> str:
        return f"<tumble.Comparison {self._told.b.file} with {self._told.a.file}: {self.verdict}>"


def compare(
    a: Result | str | os.PathLike[str],
    b: Result | str | os.PathLike[str],
    *,
    stand: Stand | StandFile | str | os.PathLike[str] | None = None,
    schedule: str | os.PathLike[str] | Schedule | None = None,
    levelled: str = ANEW,
    two_stands: bool = False,
    confidence: float = DEFAULT_CONFIDENCE,
) -> Comparison:
    """Are two calibrations of one block the same? Has the block changed, only its seat, or neither?

    Parameters
    ----------
    a, b : Result or path
        Results or their files, the earlier one first, of any schedule and estimator, their outputs in one unit.
    stand : path, Stand or StandFile, optional
        That both were measured on, if it was one: errors that return with every run on it are then counted once;
        default: the one that both declare, if they do.
    schedule : str, path or Schedule, optional
        That a result was measured by which does not tell it.
    levelled : str, optional
        Was the stand levelled "once" for both, or "anew" before each?
    two_stands : bool, optional
        They were measured on two, even if both declare the same.
    confidence : float, optional
        That a block which has not changed is not said to have, 0.5 to 0.999999.

    Returns
    -------
    Comparison

    Raises
    ------
    BadInput
        For files that cannot be used and for different units.
    UsageError
        For arguments that cannot be.

    Examples
    --------
    >>> import tumble
    >>> result = tumble.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml")
    >>> tumble.compare(result, result).verdict
    'unchanged'
    """
    with told_in_python():
        return Comparison(compared(a, b, stand, schedule, levelled, two_stands, confidence))


def compared(
    a: Result | str | os.PathLike[str],
    b: Result | str | os.PathLike[str],
    stand: Stand | StandFile | str | os.PathLike[str] | None,
    schedule: str | os.PathLike[str] | Schedule | None,
    levelled: str,
    two_stands: bool,
    confidence: float,
) -> types.Comparison:
    """What `compare` finds, as a document; sentences, and errors of files, advise options of the command line."""
    require_flag(two_stands, "two_stands")
    if not is_one_of(levelled, LEVELLED):
        raise UsageError(f"levelled: {quoted(levelled)} is not one of {', '.join(LEVELLED)}")
    if schedule is not None and stand is None:
        raise UsageError("schedule: serves to tell what the stand brings to a result, so it needs stand=")
    if two_stands and (stand is not None or levelled != ANEW):
        raise UsageError("two_stands: nothing is shared then, which stand= and levelled= speak of")
    if not 0.5 <= as_number(confidence) <= 0.999999:
        raise UsageError(f"confidence: {quoted(confidence)} is not a number from 0.5 to 0.999999")
    first, second = _compared(a, "A"), _compared(b, "B")
    one_stand = None
    if stand is not None:
        name, file = os.fspath(stand) if isinstance(stand, (str, os.PathLike)) else "the stand", stand_file_of(stand)
        schedules = [] if schedule is None else [schedule_of(schedule)]
        schedules += [CoreSchedule.built_in(one) for one in BUILT_IN]
        one_stand = OneStand(name, file.stand, file.step_v, schedules, levelled)
    return report.document(pair.compare(first, second, one_stand, confidence, two_stands, levelled))


def _compared(given: Result | str | os.PathLike[str], name: str) -> pair.ComparedResult:
    if isinstance(given, (str, os.PathLike)):
        name, given = os.fspath(given), load(given)
    if not isinstance(given, Result):
        raise UsageError(f"{name}: a {type(given).__name__} is neither a tumble.Result nor the path of one")
    return pair.ComparedResult.of(name, given.checked, complaints_of_result(given.checked))
