"""Which rest is which position: what a recording may be, and what of it is certain.

A hypothesis is a view (signs, channels) and an order. The one that is claimed, by the user or by what is assumed where
he says nothing, is held against the others: with any other signs, with channels exchanged, in any order. Of each all
twelve coefficients are fitted; what counts is how many positions it finds, then how far off the rests are. The claimed
one is taken only if no other finds more, nor, among those that nobody has ruled out, as many.

Of the hypothesis that is taken, a rest that is off, by F over what the others leave, is left out where another rest is
at its position; where none is, the recording is refused. So is one with several rests at a position, unless the user
says which to take. Two that differ by no more than noise, with nothing between them, are one rest that was interrupted.

In the schedule's order, rests have positions by the longest way through both that goes forward in both. In any order:
the mountings one after another with as few changes as can be, those that are alike in the schedule's order, and
positions of one attitude and mounting told apart by the shortest way of the table. A rest that another assignment, as
good, would call otherwise is in doubt.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.distributions import f_quantile
from tumble.errors import Remedy, UsageError, listed
from tumble.importing import attitudes
from tumble.importing.attitudes import AXES, STRAIGHT, Attitudes, Fit, Seen, Signs, View
from tumble.importing.rests import Rests
from tumble.schedule import Schedule

SCHEDULE, ANY = "schedule", "any"
NONE = -1
THAT_OF = "<that of u{}>"  # the column of a channel, which a matcher does not know
POSITIVE: Signs = (1, 1, 1)
REPEATS = ("first", "last", "longest")
_CLEARLY_WORSE = 3.0  # times as far off
_FEWEST = 5  # positions: K and U0 take four
_MOST_LISTED = 3
_CHANCE = 1e-6  # that an honest rest is called off
_CHANCE_SPARE = 1e-4  # the same of one whose position another rest has
_AGREE = 5.0  # standard errors: two rests closer than this are one, twice interrupted

TAKEN, JOINED, REPEATED, OFF, NOWHERE, LEFT_OUT = "taken", "joined", "repeated", "off", "no position", "left out"


@dataclass(frozen=True)
class Matched:
    """`positions` (rests,): index in the schedule, NONE; `states` (rests,): one of TAKEN and the like; `off` (rests,):
    from its position, or from the nearest attitude of the schedule, rad; `spread`: what is usual of that; `fit`: K and
    U0, roughly; `notes`: sentences on what was taken for granted or found."""

    positions: Integers
    states: tuple[str, ...]
    off: Floats
    spread: float
    fit: Fit
    notes: tuple[str, ...]


class Doubtful(Exception):
    """Why the rests are not matched, and what to do about it: one line; and the `remedies` that are worth a try."""

    def __init__(self, message: str, *remedies: Remedy):
        super().__init__(message)
        self.remedies = remedies


@dataclass(frozen=True)
class UserChoices:
    """What the user chooses for matching rests to positions. `signs` of K's diagonal, None: not given, taken as
    positive; `order`: SCHEDULE or ANY; `tolerance`: rad; `repeats`: one of REPEATS, None: refuse; `leave_out`, `take`:
    numbers of rests, from 1; `signs_from`: where the signs are from, in words."""

    signs: Signs | None = None
    order: str = SCHEDULE
    tolerance: float = math.radians(6.0)
    repeats: str | None = None
    leave_out: frozenset[int] = frozenset()
    take: frozenset[int] = frozenset()
    signs_from: str = "as given"

    def require_rests(self, count: int) -> None:
        """Raise UsageError where rests are named that are not there, or both ways."""
        unknown = sorted(number for number in self.leave_out | self.take if not 1 <= number <= count)
        if unknown:
            raise UsageError(f"--leave-out, --take: no rest {unknown[0]}, there are {count}")
        if both := sorted(self.leave_out & self.take):
            raise UsageError(f"rest {both[0]} is named by both --leave-out and --take")


@dataclass(frozen=True)
class Assigned:
    """`positions` (rests,): index in the schedule, NONE where the rest is none; `ambiguous`: by rest, all positions
    that it could be; `alike`: positions of one attitude in one mounting, which order alone tells apart."""

    positions: Integers
    ambiguous: dict[int, tuple[int, ...]] = field(default_factory=dict)
    alike: tuple[tuple[int, ...], ...] = ()

    @property
    def matched(self) -> int:
        """How many positions have a rest."""
        return len(set(self.positions.tolist()) - {NONE})


@dataclass(frozen=True)
class _Hypothesis:
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


def match(rests: Rests, schedule: Schedule, user_choices: UserChoices) -> Matched:
    """Which rest is which position. Raises Doubtful."""
    matcher = _Matcher(rests, schedule, user_choices)
    return matcher.judge(matcher.claimed())


def every_part(schedule: Schedule) -> str:
    """What has to be recorded together."""
    return "all inclinations" if attitudes.inclinations_of(schedule) else "all mountings"


def about_inclinations(fit: Fit) -> list[str]:
    """Where the rests show a block that is bolted on once."""
    found = fit.inclinations
    if found is None:
        return []
    if fit.unknowns < attitudes.TWELVE + 2 * len(found.numbers) - 1:
        return ["inclinations: the rests do not show all of them, the others are as in the schedule"]
    degrees = np.rad2deg(found.beta)
    each = ", ".join(f"{number} at {degree:.2f}" for number, degree in zip(found.numbers, degrees))
    return [f"inclinations found from the rests: {each} deg"]


class _Matcher:
    """The rests of a recording, what is claimed of them, and the schedule that they are held against.

    `_used` (rests,): not told to be left out; `_attitudes` of the schedule, `_places` of its positions; `_tolerance`:
    how far off one of them a rest may be, rad; `_rough`: scale and bias of each channel, as the rests alone show
    them."""

    def __init__(self, rests: Rests, schedule: Schedule, user_choices: UserChoices):
        """Raises Doubtful where the rests do not show scale and bias."""
        self._rests, self._schedule, self._user_choices = rests, schedule, user_choices
        self._used = ~self._is_among(user_choices.leave_out)
        self._attitudes: Attitudes = attitudes.attitudes_of(schedule)
        self._places = self._attitudes.of_positions(schedule)
        self._tolerance = min(user_choices.tolerance, 0.4 * self._attitudes.apart)
        self._signs = POSITIVE if user_choices.signs is None else user_choices.signs
        rough = attitudes.scale_and_bias(rests.means[self._used])
        if rough is None:
            used = int(self._used.sum())
            shown = "1 rest does" if used == 1 else f"{used} rests do"
            if lacking := self._missing_faces():
                raise Doubtful(
                    f"{used} rests, but none with {listed(lacking, 'or')}: scale and bias need all six faces; lay the "
                    "sensor on that face too, or check whether --still, --drift or --min-rest hide it"
                )
            raise Doubtful(
                f"{shown} not show scale and bias of every channel: give the recordings of {every_part(schedule)} "
                "together, or check whether --still, --drift or --min-rest hide some"
            )
        self._rough = rough

    def _missing_faces(self) -> list[str]:
        """Such as "z down": of faces, by the channel that is farthest from where the others leave it, the few that no
        rest shows; empty where two rests show the same, most are missing, or other attitudes are wanted as well."""
        means, forces = self._rests.means[self._used], self._attitudes.forces
        if not len(means) or len(forces) != 6 or not (np.abs(forces).max(axis=1) > math.cos(self._tolerance)).all():
            return []
        off = (means - np.median(means, axis=0)) * self._signs
        axes = np.abs(off).argmax(axis=1)
        seen = {(axis, bool(one[axis] > 0.0)) for axis, one in zip(axes.tolist(), off)}
        lacking = [f"{AXES[axis]} {'up' if up else 'down'}" for axis in range(3) for up in (True, False)
                   if (axis, up) not in seen]  # fmt: skip
        return lacking if len(seen) == len(means) and len(lacking) <= 2 else []

    def claimed(self) -> _Hypothesis:
        """The one that is claimed, if it fits and nothing else does better, or as well. Raises Doubtful."""
        own = self._hypothesis(View(signs=self._signs), self._user_choices.order)
        found, others = 0 if own is None else own.matched, self._others()
        better = [other for other in others if other.matched > max(found, _FEWEST - 1)]
        if better:
            most = max(other.matched for other in better)
            best = [other for other in better if other.matched == most]
            if self._schedule.is_laid_by_hand:  # hands lay faces in any order; wires are seldom exchanged
                best.sort(key=lambda other: other.order != ANY)
            claimed = self._described(View(signs=self._signs), self._user_choices.order)
            positions = len(self._schedule.positions)
            would = f"{'all ' if most == positions else ''}{most} would be found"
            if len(best) > 1:
                would += f" in {len(best)} ways: {self._listed(best)}; choose one by its options"
            else:
                would += f" {self._described(best[0].seen.view, best[0].order)} ({self._option(best[0])})"
            raise Doubtful(f"{claimed}, {found} of {positions} positions are found; {would}", *map(self._remedy, best))
        if own is None or found < _FEWEST:
            lacks = "is an inclination missing, or " if attitudes.inclinations_of(self._schedule) else ""
            raise Doubtful(
                f"of {int(self._used.sum())} rests {'none' if own is None else found} fit the positions of this "
                f"schedule; {lacks}is this another schedule? (--schedule; any_pose takes poses that nobody knows, a "
                "schedule file poses of your own)"
            )
        noise = float(np.median(np.linalg.norm(np.linalg.solve(own.seen.fit.k, self._rests.errors.T), axis=0)))  # rad
        rivals = [
            other
            for other in others
            if other.matched == found
            and other.order == self._user_choices.order
            and other.seen.view.channels == STRAIGHT
            and other.seen.view != own.seen.view
            and self._user_choices.signs is None
            and other.off <= _CLEARLY_WORSE * own.off + noise
        ]
        if rivals:
            both = self._listed([own, *rivals])
            advice = "give the signs of K (--signs, or --stand FILE)"
            raise Doubtful(f"fits {1 + len(rivals)} ways: {both}; {advice}", *map(self._remedy, [own, *rivals]))
        return own

    def _hypothesis(self, view: View, order: str) -> _Hypothesis | None:
        seen = attitudes.see(self._rests.means[self._used], self._rough, view, self._attitudes, self._tolerance)
        if seen is None:
            return None
        nearest, off = np.full(len(self._used), NONE), np.full(len(self._used), np.inf)
        nearest[self._used], off[self._used] = seen.nearest, seen.off
        seen = replace(seen, nearest=nearest, off=off)
        return _Hypothesis(order, seen, self._assign(order, nearest, off))

    def _assign(self, order: str, nearest: Integers, off: Floats) -> Assigned:
        nearness = np.clip(1.0 - off / self._tolerance, 0.0, 1.0)
        return assign(order, nearest, nearness, self._attitudes.of_position, self._schedule)

    def _others(self) -> list[_Hypothesis]:
        """Which the claimed one is held against: the schedule's order in every view and any order in the claimed one;
        where that is any order, other signs."""
        own = View(signs=self._signs)
        if self._user_choices.order == SCHEDULE:
            tried = [(view, SCHEDULE) for view in attitudes.views(None, channels=True) if view != own] + [(own, ANY)]
        else:
            tried = [(view, ANY) for view in attitudes.views(self._user_choices.signs, channels=False) if view != own]
        return [one for view, way in tried if (one := self._hypothesis(view, way)) is not None]

    def _label(self, position: int) -> str:
        return self._schedule.positions[position].label

    def _listed(self, fits: Sequence[_Hypothesis]) -> str:
        told = [
            f"({number}) {self._described(one.seen.view, one.order)} ({self._option(one)})"
            for number, one in enumerate(fits[:_MOST_LISTED], 1)
        ]
        more = f" and {len(fits) - _MOST_LISTED} more" if len(fits) > _MOST_LISTED else ""
        return " ".join(told) + more

    def _described(self, view: View, order: str) -> str:
        way = "in the schedule's order" if order == SCHEDULE else "in another order"
        exchanged = [AXES[channel] for axis, channel in enumerate(view.channels) if axis != channel]
        channels = f", channels {' and '.join(exchanged)} exchanged" if exchanged else ""
        negative = [axis for axis, sign in zip(AXES, view.signs) if sign < 0]
        return f"{way}{channels}, K {'negative in ' + ', '.join(negative) if negative else 'positive'}"

    def _option(self, one: _Hypothesis) -> str:
        told = (f"--{name}{'=' if name == 'signs' else ' '}{value}" for name, value in self._options(one).items())
        return " ".join(told) or "as claimed"

    def _options(self, one: _Hypothesis) -> dict[str, str]:
        """Those that say so, by name."""
        options = {}
        if one.seen.view.channels != STRAIGHT:
            names = (f"u{axis}={THAT_OF.format(AXES[channel])}" for axis, channel in zip(AXES, one.seen.view.channels))
            options["columns"] = ",".join(names)
        if one.seen.view.signs != self._signs or self._user_choices.signs is None:
            options["signs"] = "".join("+" if sign > 0 else "-" for sign in one.seen.view.signs)
        if one.order != self._user_choices.order or one.order == ANY:
            options["order"] = one.order
        return options

    def _remedy(self, one: _Hypothesis) -> Remedy:
        return Remedy(self._options(one), f"it was {self._described(one.seen.view, one.order)}")

    def judge(self, own: _Hypothesis) -> Matched:
        """Every rest of the hypothesis that is taken. Raises Doubtful."""
        excluded: dict[int, int] = {}  # rests that are off, and the position that each would have had
        nearest, assigned = own.seen.nearest.copy(), own.assigned
        seen = own.seen.fit.at(self._attitudes.of_position)
        while True:
            fit, variance, freedom = self._refit(assigned.positions, seen)
            far = self._farthest(assigned.positions, fit, variance, freedom)
            if far is None or 3 * len(excluded) >= own.matched:
                break
            excluded[far] = int(assigned.positions[far])
            nearest[far] = NONE
            assigned = self._assign(own.order, nearest, own.seen.off)
        for rest, could_be in assigned.ambiguous.items():
            labels = " or ".join(map(self._label, could_be))
            without = Remedy({"leave_out": str(rest + 1)})
            raise Doubtful(f"rest {rest + 1} could be {labels}: --leave-out {rest + 1} continues without it", without)
        self._require_filled(excluded, assigned, fit)
        return self._finish(assigned, excluded, fit, variance, freedom)

    def _refit(self, positions: Integers, otherwise: Fit) -> tuple[Fit, float, int]:
        """K and U0 by the rests that have a position, the variance of what is left (rad^2), its degrees of freedom."""
        used = positions != NONE
        fit = attitudes.fitted(self._places, positions[used], self._rests.means[used]) or otherwise
        freedom = 3 * int(used.sum()) - fit.unknowns
        left = fit.attitudes(self._rests.means[used]) - fit.forces[positions[used]]
        return fit, float((left**2).sum() / freedom) if freedom > 0 else 0.0, freedom

    def _farthest(self, positions: Integers, fit: Fit, variance: float, freedom: int) -> int | None:
        """The rest that is off most, if it is off more than the others allow; by F, the rest itself left out."""
        if freedom <= 3:
            return None
        used = np.flatnonzero((positions != NONE) & ~self._is_among(self._user_choices.take))
        places = positions[used]
        left = 1.0 - fit.leverage[places]
        off = fit.attitudes(self._rests.means[used]) - fit.forces[places]
        squares = (off**2).sum(axis=1) / np.maximum(left, 1e-6)
        others = np.maximum(variance * freedom - squares, 0.0) / (freedom - 3)
        ratios = squares / 3.0 / (others + self._variances(fit)[used] + 1e-18)
        worst = int(np.argmax(np.where(left > 0.05, ratios, 0.0)))
        return int(used[worst]) if ratios[worst] > f_quantile(1 - _CHANCE, 3.0, freedom - 3) else None

    def _variances(self, fit: Fit) -> Floats:
        """Of each rest, by its noise, rad^2 a component."""
        found: Floats = (np.linalg.solve(fit.k, self._rests.errors.T) ** 2).mean(axis=0)
        return found

    def _finish(self, assigned: Assigned, excluded: dict[int, int], fit: Fit, variance: float, freedom: int) -> Matched:
        felt = fit.attitudes(self._rests.means)
        distances = np.linalg.norm(felt[:, None] - fit.forces, axis=-1)
        off, place = distances.min(axis=1), distances.argmin(axis=1)
        nearest = self._attitudes.of_position[place]
        states = [
            LEFT_OUT if not used else OFF if rest in excluded else NOWHERE if position == NONE else TAKEN
            for rest, (used, position) in enumerate(zip(self._used, assigned.positions))
        ]
        positions = assigned.positions.copy()
        spare = [rest for rest, state in enumerate(states) if state == NOWHERE and off[rest] <= self._tolerance]
        allowed = self._allowed(fit, variance, freedom, place, spare)
        for rest in spare:
            twin = self._twin(rest, nearest[rest], positions, states)
            if twin is not None:
                positions[rest], states[rest] = positions[twin], JOINED
            elif off[rest] <= allowed[rest]:
                states[rest] = REPEATED
            else:
                states[rest] = OFF
        self._settle_repeats(positions, states, nearest)
        notes = (*self._notes(assigned, positions, states), *about_inclinations(fit))
        return Matched(positions, tuple(states), off, math.sqrt(3 * variance), fit, notes)

    def _allowed(self, fit: Fit, variance: float, freedom: int, place: Integers, spare: list[int]) -> dict[int, float]:
        """How far off its nearest `place` a rest outside the fit may be that is still at it, rad."""
        if not spare:
            return {}
        factor = f_quantile(1 - _CHANCE_SPARE, 3.0, max(freedom, 1))
        wider = 1.0 + fit.leverage[place[spare]]
        noise = self._variances(fit)[spare]
        return dict(zip(spare, np.sqrt(3.0 * factor * (wider * variance + noise)).tolist()))

    def _twin(self, rest: int, attitude: int, positions: Integers, states: list[str]) -> int | None:
        """The rest just before or after, if it is at the same attitude to within the noise."""
        for step in (-1, 1):
            other = rest + step
            while 0 <= other < len(states) and states[other] == LEFT_OUT:
                other += step
            if not 0 <= other < len(states) or positions[other] == NONE:
                continue
            apart = np.abs(self._rests.means[rest] - self._rests.means[other])
            error = np.hypot(self._rests.errors[rest], self._rests.errors[other])
            if self._attitudes.of_position[positions[other]] == attitude and (apart <= _AGREE * error).all():
                return other
        return None

    def _settle_repeats(self, positions: Integers, states: list[str], nearest: Integers) -> None:
        """Of rests at a position that has one already. Raises Doubtful where nobody says which to take."""
        groups: dict[int, list[int]] = {}
        for rest, state in enumerate(states):
            if state == REPEATED:
                groups.setdefault(self._position_beside(rest, int(nearest[rest]), positions), []).append(rest)
        repeats = self._user_choices.repeats
        if groups and repeats is None:
            position, spare = next(iter(groups.items()))
            held = np.flatnonzero(positions == position).tolist() if position != NONE else []
            numbers = " and ".join(str(rest + 1) for rest in sorted([*held, *spare]))
            all_spare = ",".join(str(rest + 1) for group in groups.values() for rest in group)
            where = self._label(position) if position != NONE else "one position"
            raise Doubtful(
                f"rests {numbers} are all at {where}: --repeats {'|'.join(REPEATS)} selects one, "
                f"--leave-out {all_spare} continues without the later ones",
                Remedy({"repeats": "first"}, "the first visit of a position counts"),
                Remedy({"leave_out": all_spare}),
            )
        for position, spare in groups.items():
            if position == NONE:
                continue
            held = [rest for rest in np.flatnonzero(positions == position).tolist() if states[rest] in (TAKEN, JOINED)]
            all_of_them = [*held, *spare]
            between = set(positions[min(all_of_them) : max(all_of_them) + 1].tolist())
            if self._user_choices.order == SCHEDULE and not between <= {NONE, position}:
                continue  # another position comes between: out of order, so the repeat is the one to leave
            if repeats == "longest":
                choice = max(all_of_them, key=lambda rest: self._rests.samples[rest])
            else:
                choice = max(all_of_them) if repeats == "last" else min(all_of_them)
            if choice in held and repeats != "last":
                continue
            for rest in held:
                positions[rest], states[rest] = NONE, REPEATED
            positions[choice], states[choice] = position, TAKEN

    def _position_beside(self, rest: int, attitude: int, positions: Integers) -> int:
        """Of the positions of an attitude the one whose rest is nearest in time."""
        held = [r for r, p in enumerate(positions) if p != NONE and self._attitudes.of_position[p] == attitude]
        return int(positions[min(held, key=lambda other: abs(other - rest))]) if held else NONE

    def _require_filled(self, excluded: dict[int, int], assigned: Assigned, fit: Fit) -> None:
        """A rest that is off is named and left out where another is at its position; else it is in doubt."""
        filled = set(assigned.positions.tolist())
        lost = [(rest, position) for rest, position in excluded.items() if position not in filled]
        if lost:
            rest, position = lost[0]
            felt = fit.attitudes(self._rests.means[[rest]])[0] - fit.forces[position]
            many = ",".join(str(rest + 1) for rest, _ in lost)
            raise Doubtful(
                f"rest {rest + 1} is {1e3 * float(np.linalg.norm(felt)):.3g} mrad off {self._label(position)}, "
                f"far more than the other rests: --take {many} uses it, --leave-out {many} leaves it out",
                Remedy({"leave_out": many}),
                Remedy({"take": many}),
            )

    def _notes(self, assigned: Assigned, positions: Integers, states: list[str]) -> tuple[str, ...]:
        notes = []
        if self._user_choices.signs is None:
            notes.append("signs of K: not given, assumed positive (--signs, or scale_v_per_g of a stand file)")
        else:
            notes.append(signs_note(self._user_choices.signs, self._user_choices.signs_from))
        if self._user_choices.order == ANY:
            run = [position for position in positions.tolist() if position != NONE]
            places = list(dict.fromkeys(run))
            way = "the order " + " ".join(map(self._label, places))
            if places in (sorted(places), sorted(places, reverse=True)):
                way = "the schedule's order" + ("" if places == sorted(places) else " reversed")
            notes.append(f"order: any; measured in {way}")
        else:
            notes.append("order: the schedule's")
        for alike in assigned.alike:
            labels = " and ".join(self._label(position) for position in alike)
            notes.append(
                f"{labels} have the same attitude and are told apart by the direction of the table, else by time"
            )
        present = {self._schedule.positions[position].mounting for position in set(positions.tolist()) - {NONE}}
        for same in alike_mountings(self._attitudes.of_position, self._schedule):
            if self._user_choices.order == ANY and present >= {*same}:
                notes.append(f"{' and '.join(map(str, same))} have the same attitudes and are told apart by time")
        missing = sorted(set(range(len(self._schedule.positions))) - set(positions.tolist()))
        if missing:
            notes.append(f"no rest at {', '.join(map(self._label, missing))}")
        if REPEATED in states:
            notes.append(f"positions measured more than once: the {self._user_choices.repeats} rest is used")
        return tuple(notes)

    def _is_among(self, numbers: frozenset[int]) -> Flags:
        return np.array([rest + 1 in numbers for rest in range(len(self._rests))], dtype=bool)


def signs_note(signs: Signs, why: str) -> str:
    """Which signs K is taken to have, and why."""
    return f"signs of K: {''.join('+' if sign > 0 else '-' for sign in signs)}, {why}"


# Positions in an order.

_NEARER = 0.25  # part of a match that nearness is worth, so that it never outweighs one
_ALIKE = 1e-5  # of what two ways are worth
_MOST_OPEN = 10  # rests whose mounting is open: of more, only stretches are tried
_MOST_IN_TURN = 3  # mountings that these may be of


def assign(order: str, nearest: Integers, nearness: Floats, of_position: Integers, schedule: Schedule) -> Assigned:
    """`nearest` (rests,): attitude of each rest, NONE: of no position; `nearness` (rests,), 0 to 1; `of_position`:
    attitude of each position."""
    if order == SCHEDULE:
        return _in_order(nearest, nearness, of_position)
    return _in_any_order(nearest, of_position, schedule)


def _in_order(nearest: Integers, nearness: Floats, of_position: Integers) -> Assigned:
    rests, positions = len(nearest), len(of_position)
    worth = np.where(nearest[:, None] == of_position, 1.0 + _NEARER * nearness[:, None] / max(rests, 1), 0.0)
    ahead, behind = _best_ways(worth), _best_ways(worth[::-1, ::-1])[::-1, ::-1]
    found, ambiguous = np.full(rests, NONE), {}
    best = ahead[rests, positions]
    rest, position = rests, positions
    while rest and position:
        if worth[rest - 1, position - 1] > 0 and math.isclose(
            ahead[rest, position], ahead[rest - 1, position - 1] + worth[rest - 1, position - 1], rel_tol=_ALIKE
        ):
            rest, position = rest - 1, position - 1
            found[rest] = position
        elif math.isclose(ahead[rest, position], ahead[rest - 1, position], rel_tol=_ALIKE):
            rest -= 1
        else:
            position -= 1
    for rest in np.flatnonzero(found != NONE).tolist():
        through = ahead[rest, :-1] + worth[rest] + behind[rest + 1, 1:]
        others = np.flatnonzero((worth[rest] > 0) & (through > best - 0.5))
        if len(others) > 1:
            ambiguous[rest] = tuple(map(int, others))
    return Assigned(found, ambiguous)


def _best_ways(worth: Floats) -> Floats:
    """Best sum over the first r rests and p positions, both in order: (rests + 1, positions + 1)."""
    best = np.zeros((worth.shape[0] + 1, worth.shape[1] + 1))
    for rest, row in enumerate(worth):
        taken = np.maximum(best[rest, 1:], np.where(row > 0, best[rest, :-1] + row, 0.0))
        best[rest + 1, 1:] = np.maximum.accumulate(taken)
    return best


def _in_any_order(nearest: Integers, of_position: Integers, schedule: Schedule) -> Assigned:
    by_attitude: list[dict[int, list[int]]] = [{} for _ in range(int(of_position.max()) + 1)]  # by mounting: positions
    for index, position in enumerate(schedule.positions):
        by_attitude[of_position[index]].setdefault(position.mounting, []).append(index)
    used = [rest for rest, attitude in enumerate(nearest.tolist()) if attitude != NONE]
    open_to = {rest: sorted(by_attitude[int(nearest[rest])]) for rest in used}
    chosen, doubtful = _mountings(used, open_to, nearest, by_attitude, alike_mountings(of_position, schedule))
    found = np.full(len(nearest), NONE)
    groups: dict[tuple[int, int], list[int]] = {}
    for rest in used:
        groups.setdefault((chosen[rest], int(nearest[rest])), []).append(rest)
    for (mounting, attitude), here in groups.items():
        places = by_attitude[attitude][mounting]
        found[here[: len(places)]] = places[: len(here)]
    alike = []
    for (mounting, attitude), here in groups.items():
        if len(places := by_attitude[attitude][mounting]) > 1:
            alike.append(tuple(places))
            _tell_apart(here, places, [rest for rest in used if chosen[rest] == mounting], found, schedule)
    ambiguous = {rest: tuple(by_attitude[int(nearest[rest])][m][0] for m in open_to[rest]) for rest in doubtful}
    return Assigned(found, ambiguous, tuple(sorted(alike)))


def alike_mountings(of_position: Integers, schedule: Schedule) -> list[tuple[int, ...]]:
    """Mountings of the same attitudes, such as an inclination and the return to it: only time tells them apart."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for mounting in schedule.mountings:
        own = [index for index, place in enumerate(schedule.positions) if place.mounting == mounting.number]
        groups.setdefault(tuple(sorted(of_position[own].tolist())), []).append(mounting.number)
    return [tuple(group) for group in groups.values() if len(group) > 1]


def _mountings(
    used: list[int],
    open_to: dict[int, list[int]],
    nearest: Integers,
    by_attitude: list[dict[int, list[int]]],
    alike: list[tuple[int, ...]],
) -> tuple[dict[int, int], set[int]]:
    """The mounting of each rest, and the rests for which another would do as well: most positions found, then fewest
    changes of mounting."""
    open_rests = [rest for rest in used if len(open_to[rest]) > 1]
    choices: Iterable[tuple[int, ...]] = itertools.product(*(open_to[rest] for rest in open_rests))
    if len(open_rests) > _MOST_OPEN:
        choices = _one_after_another([open_to[rest] for rest in open_rests])
    ranked = []
    for choice in dict.fromkeys(choice for choice in choices if _in_turn(choice, alike)):
        mounting = {rest: open_to[rest][0] for rest in used} | dict(zip(open_rests, choice))
        changes = sum(mounting[one] != mounting[other] for one, other in itertools.pairwise(used))
        counts = Counter((int(nearest[rest]), number) for rest, number in mounting.items())
        found = sum(min(count, len(by_attitude[attitude][number])) for (attitude, number), count in counts.items())
        ranked.append((-found, changes, choice))
    if not ranked:
        return {rest: open_to[rest][0] for rest in used}, set(open_rests)
    ranked.sort()
    best = [choice for *rank, choice in ranked if rank == [*ranked[0][:2]]]
    doubtful = {rest for place, rest in enumerate(open_rests) if len({choice[place] for choice in best}) > 1}
    return {rest: open_to[rest][0] for rest in used} | dict(zip(open_rests, best[0])), doubtful


def _one_after_another(open_to: list[list[int]]) -> Iterator[tuple[int, ...]]:
    """Ways through rests that are all open to the same mountings, each of which comes once; none where the rests are
    open to several, or to too many."""
    numbers = open_to[0]
    if len(numbers) > _MOST_IN_TURN or any(other != numbers for other in open_to):
        return
    for order in itertools.permutations(numbers):
        for cuts in itertools.combinations_with_replacement(range(len(open_to) + 1), len(order) - 1):
            lengths = np.diff([0, *cuts, len(open_to)])
            yield tuple(np.repeat(order, lengths).tolist())


def _in_turn(choice: tuple[int, ...], alike: list[tuple[int, ...]]) -> bool:
    """Do mountings that are alike come in the schedule's order, the first of them first?"""
    came = list(dict.fromkeys(choice))
    own = [tuple(number for number in came if number in group) for group in alike]
    return all(some == group[: len(some)] for some, group in zip(own, alike))


def _tell_apart(here: list[int], places: list[int], block: list[int], found: Integers, schedule: Schedule) -> None:
    """Of positions that share an attitude: those that make the table's way the shortest, else in order of time."""
    count = min(len(here), len(places))
    if count == 0 or len(places) > 4:
        return

    def way(choice: Iterable[int]) -> float:
        tried = found.copy()
        tried[here[:count]] = list(choice)
        angles = [schedule.positions[tried[rest]].angle_deg for rest in block if tried[rest] != NONE]
        return float(np.abs(np.diff(angles)).sum())

    found[here[:count]] = min(itertools.permutations(places, count), key=way)
