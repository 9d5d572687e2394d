"""What a recording may be: views of its rests in one order or another, and which of them fits.

A hypothesis is a view (signs, channels) and an order. The one that is claimed, by the user or by what is assumed where
he says nothing, is held against the others: with any other signs, with channels exchanged, in any order. Of each all
twelve coefficients are fitted; what counts is how many positions it finds, then how far off the rests are. The claimed
one is taken only if no other finds more, nor, among those that nobody has ruled out, as many.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import UsageError
from tumble.importing import attitudes, order
from tumble.importing.attitudes import AXES, STRAIGHT, Attitudes, Seen, Signs, View
from tumble.importing.order import ANY, NONE, SCHEDULE, Assigned
from tumble.importing.rests import Rest
from tumble.schedule import Schedule

POSITIVE: Signs = (1, 1, 1)
REPEATS = ("first", "last", "longest")
_CLEARLY_WORSE = 3.0  # times as far off
_FEWEST = 5  # positions: K and U0 take four
_MOST_LISTED = 3


class Doubtful(Exception):
    """Why the rests are not matched, and what to do about it: one line."""


@dataclass(frozen=True)
class Claims:
    """What is claimed of a recording. `signs` of K's diagonal, None: not told, taken for positive; `order`: SCHEDULE
    or ANY; `tolerance`: rad; `repeats`: one of REPEATS, None: refuse; `leave_out`, `take`: numbers of rests, from 1."""

    signs: Signs | None = None
    order: str = SCHEDULE
    tolerance: float = math.radians(6.0)
    repeats: str | None = None
    leave_out: frozenset[int] = frozenset()
    take: frozenset[int] = frozenset()

    def require_rests(self, count: int) -> None:
        """Raise UsageError where rests are named that are not there, or both ways."""
        unknown = sorted(number for number in self.leave_out | self.take if not 1 <= number <= count)
        if unknown:
            raise UsageError(f"--leave-out, --take: there is no rest {unknown[0]}, of {count}")
        if both := sorted(self.leave_out & self.take):
            raise UsageError(f"rest {both[0]} is to be left out (--leave-out) and to be taken (--take)")


@dataclass(frozen=True)
class Hypothesis:
    order: str
    seen: Seen
    assigned: Assigned

    @property
    def matched(self) -> int:
        return self.assigned.matched

    @property
    def off(self) -> float:
        """Root mean square over the rests that have a position."""
        return float(np.sqrt(np.mean(self.seen.off[self.assigned.positions != NONE] ** 2))) if self.matched else np.inf


class Evidence:
    """The rests of a recording, what is claimed of them, and the schedule that they are held against.

    `means`, `errors` (rests, 3); `used` (rests,): not told to be left out; `attitudes` of the schedule; `tolerance`:
    how far off one of them a rest may be, rad."""

    def __init__(self, rests: Sequence[Rest], schedule: Schedule, claims: Claims):
        self.rests, self.schedule, self.claims = rests, schedule, claims
        self.used = np.array([n not in claims.leave_out for n in range(1, len(rests) + 1)], dtype=bool)
        self.means = np.array([rest.mean for rest in rests]).reshape(-1, 3)
        self.errors = np.array([rest.error for rest in rests]).reshape(-1, 3)
        self.attitudes: Attitudes = attitudes.attitudes_of(schedule)
        self.tolerance = min(claims.tolerance, 0.4 * self.attitudes.apart)
        self._signs = POSITIVE if claims.signs is None else claims.signs

    def claimed(self) -> Hypothesis:
        """The one that is claimed, if it fits and nothing else does as well. Raises Doubtful."""
        rough = attitudes.scale_and_bias(self.means[self.used])
        if rough is None:
            raise Doubtful(self._too_few())
        self._rough = rough
        own = self._hypothesis(View(signs=self._signs), self.claims.order)
        self._require_no_other(own)
        assert own is not None
        return own

    def _hypothesis(self, view: View, in_order: str) -> Hypothesis | None:
        seen = attitudes.see(self.means[self.used], self._rough, view, self.attitudes, self.tolerance)
        if seen is None:
            return None
        nearest, off = np.full(len(self.used), NONE), np.full(len(self.used), np.inf)
        nearest[self.used], off[self.used] = seen.nearest, seen.off
        seen = replace(seen, nearest=nearest, off=off)
        return Hypothesis(in_order, seen, self.assign(in_order, nearest, off))

    def assign(self, in_order: str, nearest: Integers, off: Floats) -> Assigned:
        nearness = np.clip(1.0 - off / self.tolerance, 0.0, 1.0)
        return order.assign(in_order, nearest, nearness, self.attitudes.of_position, self.schedule)

    def _require_no_other(self, own: Hypothesis | None) -> None:
        """Raises Doubtful where another hypothesis explains the rests better, or as well."""
        found = 0 if own is None else own.matched
        others = self._others()
        better = [other for other in others if other.matched > max(found, _FEWEST - 1)]
        if better:
            raise Doubtful(self._not_as_claimed(own, better))
        if own is None or found < _FEWEST:
            raise Doubtful(self._nothing_fits(own))
        rivals = [
            other
            for other in others
            if other.matched == found
            and other.order == self.claims.order
            and other.seen.view.channels == STRAIGHT
            and other.seen.view != own.seen.view
            and self.claims.signs is None
            and other.off <= _CLEARLY_WORSE * own.off + self._noise(own)
        ]
        if rivals:
            both = self._listed([own, *rivals])
            raise Doubtful(f"fits {1 + len(rivals)} ways: {both}; say the signs of K (--signs, or --stand FILE)")

    def _others(self) -> list[Hypothesis]:
        """Which the claimed one is held against: the schedule's order in every view and any order in the claimed one;
        where that is any order, other signs."""
        own = View(signs=self._signs)
        if self.claims.order == SCHEDULE:
            tried = [(view, SCHEDULE) for view in attitudes.views(None, channels=True) if view != own] + [(own, ANY)]
        else:
            tried = [(view, ANY) for view in attitudes.views(self.claims.signs, channels=False) if view != own]
        return [one for view, way in tried if (one := self._hypothesis(view, way)) is not None]

    def _noise(self, own: Hypothesis) -> float:
        """Of the mean of a rest, rad."""
        return float(np.median(np.linalg.norm(np.linalg.solve(own.seen.fit.k, self.errors.T), axis=0)))

    def label(self, position: int) -> str:
        return self.schedule.positions[position].label

    def forces(self, positions: Integers | Iterable[int]) -> Floats:
        found: Floats = self.attitudes.forces[self.attitudes.of_position[np.asarray(positions, dtype=int)]]
        return found

    # Words.

    def _not_as_claimed(self, own: Hypothesis | None, better: list[Hypothesis]) -> str:
        most = max(other.matched for other in better)
        best = [other for other in better if other.matched == most]
        found = 0 if own is None else own.matched
        claimed = self._described(View(signs=self._signs), self.claims.order)
        return (
            f"{claimed}, {found} of {len(self.schedule.positions)} positions are found; "
            f"{most} {'either way' if len(best) > 1 else ''}: ".replace(" :", ":")
            + f"{self._listed(best)}; choose by these options"
        )

    def _listed(self, fits: Sequence[Hypothesis]) -> str:
        told = [
            f"({number}) {self._described(one.seen.view, one.order)} ({self._option(one)})"
            for number, one in enumerate(fits[:_MOST_LISTED], 1)
        ]
        more = f" and {len(fits) - _MOST_LISTED} more" if len(fits) > _MOST_LISTED else ""
        return " ".join(told) + more

    def _described(self, view: View, in_order: str) -> str:
        way = "in the schedule's order" if in_order == SCHEDULE else "in another order"
        exchanged = [AXES[channel] for axis, channel in enumerate(view.channels) if axis != channel]
        channels = f", channels {' and '.join(exchanged)} exchanged" if exchanged else ""
        negative = [axis for axis, sign in zip(AXES, view.signs) if sign < 0]
        return f"{way}{channels}, K {'negative in ' + ', '.join(negative) if negative else 'positive'}"

    def _option(self, one: Hypothesis) -> str:
        options = []
        if one.seen.view.channels != STRAIGHT:
            names = (f"u{axis}=<that of u{AXES[channel]}>" for axis, channel in zip(AXES, one.seen.view.channels))
            options.append("--columns " + ",".join(names))
        if one.seen.view.signs != self._signs or self.claims.signs is None:
            options.append("--signs=" + "".join("+" if sign > 0 else "-" for sign in one.seen.view.signs))
        if one.order != self.claims.order or one.order == ANY:
            options.append(f"--order {one.order}")
        return " ".join(options) or "as claimed"

    def _nothing_fits(self, own: Hypothesis | None) -> str:
        found = "none" if own is None else str(own.matched)
        return (
            f"of {int(self.used.sum())} rests {found} fit the positions of this schedule; another one? (--schedule; "
            "poses of your own: a schedule file)"
        )

    def _too_few(self) -> str:
        return (
            f"{int(self.used.sum())} rests do not show scale and bias of every channel: give the recordings of all "
            "mountings together, or see whether --still, --drift or --min-rest hide some"
        )
