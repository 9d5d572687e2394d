"""A run on a stand that scripts drive: turn, wait until the block is at rest, sample, and keep what there is.

The block itself says when it is at rest, by the test of a recording (importing/rests.py). Its noise is that of the
quietest rows so far, so the first positions could be taken while the table still swung: at the end all are judged
together, and those that were not at rest are measured again.

Motion is bounded: no angle outside the limits is ever commanded, and whatever ends a run, from a fault to Ctrl-C,
stops the table first. After every position the run file is written as a whole; a later run goes on from it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.errors import BadInput, BenchFault, TumbleError, UsageError, quoted
from tumble.estimators import INCLINED
from tumble.files.disk import read_bytes, write_text
from tumble.files.run_file import smallest_step
from tumble.importing.rests import Thresholds, find_rests
from tumble.model.coefficients import gravity_errors
from tumble.model.estimators import estimate, unidentified
from tumble.model.inclined import NotShown
from tumble.schedule import Mounting, Position, Schedule

FEWEST_SAMPLES, MOST_SAMPLES = 50, 100_000  # at a position
DEFAULT_SAMPLES, DEFAULT_REST_TIMEOUT_S = 100, 120.0
_WINDOW = 40  # samples that are looked at together before a position is left
_CALM_POSITIONS = 3  # whose rows the test of rest sees beside those of the position
_SCATTER, _WANDER = 2.5, 6.0  # of a position at the end, in units of the median of all: more is no rest
_HEADER = "mounting,position,ux [{0}],uy [{0}],uz [{0}],time_s"  # seconds since 1970-01-01 UTC at which it was read


@dataclass(frozen=True)
class Drive:
    """What turns the table: `turn` returns when the table is at an angle, deg; `stop` ends any motion; `limits_deg`:
    the lowest and the highest angle that may be commanded."""

    turn: Callable[[float], object]
    stop: Callable[[], object]
    limits_deg: tuple[float, float]

    def require_within(self, schedule: Schedule) -> None:
        """Raise UsageError for a schedule with an angle beyond the limits."""
        low, high = self.limits_deg
        if not -math.inf < low < high < math.inf:
            raise UsageError(f"limits_deg: {low:g} to {high:g} is no range of angles")
        for one in schedule.positions:
            if not low <= one.angle_deg <= high:
                where = f"position {one.label} is at {one.angle_deg:g} deg"
                raise UsageError(f"{where}, beyond the limits of the table, {low:g} to {high:g} deg")


@dataclass(frozen=True)
class AcquisitionPlan:
    """A run: `samples` at each position of the `schedule`, outputs in `unit`, written to `file`. `read` returns one
    sample (3,) or several (n, 3), `forget` drops what came while nobody read; `turn_by_hand` and `mount` return when
    somebody has done it. A table that never comes to rest ends the run after `rest_timeout_s`."""

    schedule: Schedule
    samples: int
    unit: str
    file: str
    read: Callable[[], object]
    mount: Callable[[Mounting], object]
    drive: Drive | None
    turn_by_hand: Callable[[Position], object]
    rest_timeout_s: float = DEFAULT_REST_TIMEOUT_S
    forget: Callable[[], object] = lambda: None

    def require_possible(self) -> None:
        """Raise UsageError."""
        if type(self.samples) is not int or not FEWEST_SAMPLES <= self.samples <= MOST_SAMPLES:
            raise UsageError(f"samples: {self.samples!r} is not a whole number, {FEWEST_SAMPLES} to {MOST_SAMPLES}")
        if not (isinstance(self.rest_timeout_s, (int, float)) and 0.0 < self.rest_timeout_s):
            raise UsageError(f"rest_timeout_s: {self.rest_timeout_s!r} is not a number of seconds above 0")
        if self.drive is not None:
            self.drive.require_within(self.schedule)


class Acquisition:
    """One run. `rows`: by index of a position, its samples and their times, (n, 4); those that are there when it begins
    are not measured again. `report` gets a line for each position."""

    def __init__(self, plan: AcquisitionPlan, rows: dict[int, Floats], report: Callable[[str], object]):
        plan.require_possible()
        self._plan, self._schedule, self._report = plan, plan.schedule, report
        self.rows = {index: own for index, own in rows.items() if len(own) >= plan.samples}
        self._mounted: int | None = None

    def run(self) -> None:
        """All positions that are left. Raises BenchFault for an instrument, or a stand that does not come to rest."""
        try:
            self._measure([index for index in range(len(self._schedule.positions)) if index not in self.rows])
            if unsettled := self._not_at_rest():
                self._report(f"not at rest, as the noise of the whole run shows: {self._labels(unsettled)}; once more")
                self._measure(unsettled)
            if unsettled := self._not_at_rest():
                raise BenchFault(f"never at rest at {self._labels(unsettled)}: does something shake the stand?")
        except BaseException as ended:
            self._stop(ended)
            raise

    def _stop(self, ended: BaseException) -> None:
        """The table, whatever it does; a table that does not obey is the greater fault."""
        if self._plan.drive is None:
            return
        try:
            self._plan.drive.stop()
        except Exception as error:
            why = ended if isinstance(ended, TumbleError) else type(ended).__name__
            raise BenchFault(f"THE TABLE MAY STILL TURN: it cannot be stopped ({quoted(error)}) after: {why}") from None

    def _labels(self, indices: list[int]) -> str:
        return ", ".join(self._schedule.positions[index].label for index in indices)

    def _measure(self, indices: list[int]) -> None:
        for index in indices:
            position = self._schedule.positions[index]
            if position.mounting != self._mounted:
                self._plan.mount(next(one for one in self._schedule.mountings if one.number == position.mounting))
                self._mounted = position.mounting
            if self._plan.drive is None:
                self._plan.turn_by_hand(position)
            else:
                self._plan.drive.turn(position.angle_deg)
            begun = time.monotonic()
            self._plan.forget()
            self.rows[index] = self._at_rest(position)
            write_text(self._plan.file, self._text())
            self._report(self._line(position, time.monotonic() - begun))

    def _at_rest(self, position: Position) -> Floats:
        """The samples of a position, once the block is at rest there. Only its latest rows are looked at, so that
        those of the positions before, which were at rest, are enough to show what the noise is."""
        samples, window = self._plan.samples, min(_WINDOW, 2 * self._plan.samples // 5)
        calm = [own[:, :3] for own in list(self.rows.values())[-_CALM_POSITIONS:]]
        latest, taken, looked_at = self._sample(), 1, 0
        end = time.monotonic() + self._plan.rest_timeout_s
        while True:
            if taken - looked_at >= samples // 4 and len(latest) >= samples:
                looked_at = taken
                rests = _rests([*calm, latest[:, :3]], window, samples)
                begin = rests[-1][1] - sum(map(len, calm)) - samples if rests else -1
                if begin >= 0 and rests[-1][1] - rests[-1][0] >= samples:
                    return latest[begin : begin + samples].copy()
            if time.monotonic() >= end:
                where = f"position {position.label}: not at rest within {self._plan.rest_timeout_s:g} s"
                raise BenchFault(f"{where}, {taken} samples, of which {samples} at rest are wanted")
            more = self._sample()
            latest, taken = np.concatenate([latest, more])[-samples - 2 * window :], taken + len(more)

    def _sample(self) -> Floats:
        """What `read` gives, with the time: (n, 4). Raises BenchFault for what are no outputs."""
        given = self._plan.read()
        try:
            outputs = np.atleast_2d(np.asarray(given, dtype=float))
        except (TypeError, ValueError):
            outputs = np.empty((0, 0))
        if outputs.ndim != 2 or outputs.shape[1] != 3 or not len(outputs) or not np.isfinite(outputs).all():
            raise BenchFault(f"read: {quoted(given)} is no sample of three finite outputs")
        return np.column_stack([outputs, np.full(len(outputs), time.time())])

    def _not_at_rest(self) -> list[int]:
        """Positions whose samples scatter, or whose quarters differ, far more than they usually do in this run."""
        indices = sorted(self.rows)
        parts = [self.rows[index][:, :3] for index in indices]
        half_step = np.array([smallest_step(channel) for channel in np.concatenate(parts).T]) / 2.0
        scatter = np.array([own.std(axis=0, ddof=1) for own in parts])
        quarters = np.array([[quarter.mean(axis=0) for quarter in np.array_split(own, 4)] for own in parts])
        moved = np.zeros(len(parts), dtype=bool)
        for sizes, most in ((scatter, _SCATTER), (np.ptp(quarters, axis=1), _WANDER)):
            moved |= (sizes > most * np.maximum(np.median(sizes, axis=0), half_step)).any(axis=1)
        return [index for index, is_unsettled in zip(indices, moved) if is_unsettled]

    def _text(self) -> str:
        lines = [_HEADER.format(self._plan.unit)]
        for index, own in sorted(self.rows.items()):
            position = self._schedule.positions[index]
            place = f"{position.mounting},{position.number}"
            lines += [f"{place},{x!r},{y!r},{z!r},{at:.3f}" for x, y, z, at in own.tolist()]
        return "\n".join(lines) + "\n"

    def _line(self, position: Position, waited_s: float) -> str:
        done = f"{position.label} at {position.angle_deg:g} deg: {self._plan.samples} samples in {waited_s:.1f} s"
        worst = self.gravity_error()
        gravity = "" if worst is None else f"; largest gravity error so far {worst[0]:.1e} g at {worst[1]}"
        return f"{done}, {len(self.rows)} of {len(self._schedule.positions)} positions{gravity}"

    def gravity_error(self) -> tuple[float, str] | None:
        """The largest of formula (8) at what has been measured, g, and where; None while that does not show all twelve
        coefficients. By least squares, or `inclined`: a first look, not the result."""
        part = self._schedule.part([index in self.rows for index in range(len(self._schedule.positions))])
        means = np.array([own[:, :3].mean(axis=0) for _, own in sorted(self.rows.items())])
        if not part.fit_indices or unidentified(part):
            return None
        try:
            errors = gravity_errors(means, *estimate(part, means, INCLINED if part.is_inclined else "least_squares"))
        except (UsageError, NotShown, ValueError, np.linalg.LinAlgError):
            return None
        worst = int(np.argmax(np.abs(errors)))
        return float(errors[worst]), part.positions[worst].label


def _rests(parts: list[Floats], window: int, fewest: int) -> list[tuple[int, int]]:
    """First row and the one behind the last of each rest in `parts`, between which time is missing."""
    gaps = np.cumsum([len(one) for one in parts])[:-1]
    thresholds = Thresholds(window_samples=window, min_rest_samples=fewest)
    rests = find_rests(np.concatenate(parts), gaps, None, thresholds).rests
    return list(zip(rests.begin.tolist(), rests.end.tolist()))


def rows_in(file: str, unit: str, schedule: Schedule) -> dict[int, Floats]:
    """What an earlier run has written, by index of the position. Raises BadInput."""
    by_place = {(one.mounting, one.number): index for index, one in enumerate(schedule.positions)}
    header, *lines = read_bytes(file).decode("utf-8", errors="replace").splitlines() or [""]
    if header != (own := _HEADER.format(unit)):
        raise BadInput(f"{quoted(header, 80)} is not the header of a run of this kind, {own}", file, 1)
    rows: dict[int, list[list[float]]] = {}
    for number, line in enumerate(lines, start=2):
        try:
            mounting, position, *values = map(float, line.split(","))
            if len(values) != 4:
                raise ValueError
        except ValueError:
            raise BadInput(f"{quoted(line)} is no row of this file", file, number) from None
        if (mounting, position) not in by_place:
            where = f"{mounting:g}.{position:g}"
            raise BadInput(f"the schedule has no position {where}: was the run begun with another?", file, number)
        rows.setdefault(by_place[int(mounting), int(position)], []).append(values)
    return {index: np.array(own) for index, own in rows.items()}
