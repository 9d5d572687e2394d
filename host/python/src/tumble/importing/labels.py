"""Recordings whose rows say where they were taken: position, angle or running number; mountings by number or by name.

What the labels say is held against gravity. Where mountings have names, every way of giving them the schedule's numbers
is tried, and the one is taken that gives a block whose channels feel their own axes; two that do are refused.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.errors import Remedy, quoted
from tumble.importing import attitudes
from tumble.importing.attitudes import View
from tumble.importing.match import (
    LEFT_OUT,
    NONE,
    REPEATED,
    REPEATS,
    TAKEN,
    Doubtful,
    Matched,
    UserChoices,
    about_inclinations,
    every_part,
    signs_note,
)
from tumble.importing.rests import FEWEST_IN_BLOCK, Found, Rests, rests_of
from tumble.model.geometry import Geometry
from tumble.schedule import Schedule

LABELS = ("mounting", "position", "angle", "number")
WITHOUT_LABELS = Remedy(
    {"columns": "position=,angle=,number=,mounting="}, "positions come from gravity, not from labels"
)
_NEAR_DEG = 3.0  # of a set angle, what a table shows may be off
_FACE = re.compile(r"([+-])([xyz])|([xyz])[ _-]*(\+|-|up|down|plus|minus|pos|neg)", re.IGNORECASE)
_DOWN = {"-", "down", "minus", "neg"}
_SAME_FACE = 1e-3  # rad
_ALL = "all"  # key of groups that are numbered through all mountings
_MOST_NAMES = 6  # of mountings whose numbers nobody says: 720 ways of giving six numbers, half a second


def labelled_rests(
    texts: dict[str, list[str]], outputs: Floats, file_of_row: Integers, found: Found, interval: float | None
) -> tuple[Rests, list[str]]:
    """Of rows with the same labels those that are at rest: with a clock, the longest rest in it; without one, all. And
    sentences on those that never are. `texts`: of each row, by name in LABELS. Raises Doubtful."""
    rows = list(zip(file_of_row.tolist(), *texts.values()))
    begins = [0, *(row for row in range(1, len(rows)) if rows[row] != rows[row - 1]), len(rows)]
    spans, firsts, lost = [], [], []
    for first, last in itertools.pairwise(begins):  # the rows between have the same labels
        starts, stops = np.maximum(found.rests.begin, first), np.minimum(found.rests.end, last)
        inside = np.flatnonzero(stops - starts >= FEWEST_IN_BLOCK)
        if interval is None or last - first < 4 * found.block:
            spans.append((first, last))
        elif len(inside):
            longest = inside[(stops - starts)[inside].argmax()]
            spans.append((int(starts[longest]), int(stops[longest])))
        else:
            labels = ", ".join(quoted(texts[name][first]) for name in LABELS if name in texts)
            lost.append(f"rows labelled {labels} are never at rest: left out")
            continue
        firsts.append(first)
    if not spans:
        said = "no group of rows with the same labels is at rest: see --still, --drift, --min-rest"
        raise Doubtful(said, WITHOUT_LABELS)
    own = {name: [column[row] for row in firsts] for name, column in texts.items()}
    return replace(rests_of(outputs, spans, found.block, found.rounding), file=file_of_row[firsts], labels=own), lost


@dataclass(frozen=True)
class _Way:
    """One way of giving mountings numbers: `positions` (rests,), which of the rests are `taken`, and how far off its
    position each is, rad."""

    numbers: dict[str, int]
    positions: Integers
    taken: Flags
    off: Floats
    fit: attitudes.Fit


def match(rests: Rests, schedule: Schedule, user_choices: UserChoices, named: dict[str, int]) -> Matched:
    """The position of every rest by its labels. `named`: numbers of mountings by name, as far as the user says. Raises
    Doubtful."""
    kept = np.array([number not in user_choices.leave_out for number in range(1, len(rests) + 1)], dtype=bool)
    if not kept.any():
        raise Doubtful("--leave-out leaves no rest")
    way = _only_way(
        _Labelled(rests.part(np.flatnonzero(kept)), np.flatnonzero(kept) + 1, schedule, user_choices), named
    )
    positions, states = np.full(len(rests), NONE), np.full(len(rests), LEFT_OUT, dtype=object)
    positions[kept] = np.where(way.taken, way.positions, NONE)
    states[kept] = np.where(way.taken, TAKEN, REPEATED)
    felt = way.fit.attitudes(rests.means)
    off = np.linalg.norm(felt[:, None] - way.fit.forces, axis=-1).min(axis=1)
    off[kept] = way.off
    spread = float(np.sqrt((way.off[way.taken] ** 2).mean()))
    notes = [f"positions: from the labels of the rows, confirmed by gravity; mountings {_told(way.numbers)}"]
    notes += about_inclinations(way.fit)
    if way.fit.inclinations is not None and user_choices.signs is None:  # up and down exchanged look like another sign
        x, y, z = (1 if own >= 0 else -1 for own in np.diag(way.fit.k))
        notes.append(signs_note((x, y, z), "assuming that the labels tell up from down; not given (--signs)"))
    elif user_choices.signs is not None:
        notes.append(signs_note(user_choices.signs, user_choices.signs_from))
    present = set(way.positions.tolist())
    missing = [place.label for index, place in enumerate(schedule.positions) if index not in present]
    notes += [f"no rows at {', '.join(missing)}"] if missing else []
    again = [schedule.positions[index].label for index, visits in _visits(way.positions).items() if len(visits) > 1]
    if again and user_choices.repeats is not None:
        notes.append(f"positions measured more than once, {', '.join(again)}: the {user_choices.repeats} rest is used")
    elif again:
        choice = f"--repeats {'|'.join(REPEATS)} selects one"
        notes.append(f"positions measured more than once, {', '.join(again)}: all their rests are used; {choice}")
    return Matched(positions, tuple(states.tolist()), off, spread, way.fit, tuple(notes))


@dataclass(frozen=True)
class _Labelled:
    """What is matched: the `rests` that are not told to be left out, and their `numbers` (rests,) in the report."""

    rests: Rests
    numbers: Integers
    schedule: Schedule
    user_choices: UserChoices

    def way(self, keys: Sequence[str], mountings: dict[str, int]) -> _Way:
        """With these numbers of the mountings that `keys` (rests,) name. Raises Doubtful."""
        labels = self.rests.labels
        rows = [dict(zip(labels, texts)) for texts in zip(*labels.values())]
        positions = np.array([_position(row, mountings[key], self.schedule) for row, key in zip(rows, keys)])
        return self.at(positions, mountings)

    def at(self, positions: Integers, mountings: dict[str, int]) -> _Way:
        """With these positions (rests,). Raises Doubtful."""
        taken = np.ones(len(positions), dtype=bool)
        if self.user_choices.repeats is not None:  # of those at one position the visit that the user chooses
            for visits in _visits(positions).values():
                samples = [int(self.rests.samples[visit].sum()) for visit in visits]
                choices = {"first": 0, "last": len(visits) - 1, "longest": int(np.argmax(samples))}
                taken[list(itertools.chain(*visits))] = False
                taken[visits[choices[self.user_choices.repeats]]] = True
        return _Way(mountings, positions, taken, *self._held_against_gravity(positions, taken))

    def _held_against_gravity(self, positions: Integers, taken: Flags) -> tuple[Floats, attitudes.Fit]:
        """How far off its position each rest is, rad. Raises Doubtful where labels and gravity disagree."""
        known = attitudes.attitudes_of(self.schedule)
        fit = attitudes.fitted(known.of_positions(self.schedule), positions[taken], self.rests.means[taken])
        if fit is None:
            count = len(set(positions[taken].tolist()))
            raise Doubtful(
                f"{count} position{'s do' if count != 1 else ' does'} not show scale and bias of every channel: give "
                f"the recordings of {every_part(self.schedule)} together"
            )
        x, y, z = (1 if own >= 0 else -1 for own in np.diag(fit.k))
        if not attitudes.is_view_of(View(signs=self.user_choices.signs or (x, y, z)), fit.k):
            raise Doubtful(
                "with these labels, channels measure axes other than their own, or with signs other than given: are "
                "mountings or positions exchanged, or columns (--columns ux=...)? ",
                Remedy({"mountings": None}),
                WITHOUT_LABELS,
            )
        off: Floats = np.linalg.norm(fit.attitudes(self.rests.means) - fit.forces[positions], axis=1)
        judged = taken & np.array([number not in self.user_choices.take for number in self.numbers], dtype=bool)
        worst = int(np.where(judged, off, 0.0).argmax())
        if judged[worst] and off[worst] > min(self.user_choices.tolerance, 0.4 * known.apart):
            label, number = self.schedule.positions[positions[worst]].label, int(self.numbers[worst])
            raise Doubtful(
                f"rest {number} is labelled {label}, but gravity is {np.rad2deg(off[worst]):.3g} deg off there: "
                f"correct its label, or delete its rows; --leave-out {number} leaves it out, "
                f"--take {number} uses it",
                Remedy({"leave_out": str(number)}),
                WITHOUT_LABELS,
            )
        return off, fit


def _visits(positions: Integers) -> dict[int, list[list[int]]]:
    """By position, the stretches of rests that are at it with no other position between."""
    found: dict[int, list[list[int]]] = {}
    for position, visit in itertools.groupby(range(len(positions)), key=lambda index: int(positions[index])):
        found.setdefault(position, []).append(list(visit))
    return found


def _require_names(named: dict[str, int], there: Sequence[str], schedule: Schedule) -> None:
    """Raise Doubtful where the user names a mounting that the rows do not, or gives one a number that is not there.
    `there`: the names of the rows, empty where they have none."""
    numbers = [mounting.number for mounting in schedule.mountings]
    for name, number in named.items():
        if not there:
            raise Doubtful(f"--mountings: {quoted(name)} is not a mounting here: the rows name none")
        if name not in there:
            listed = ", ".join(map(quoted, there))
            raise Doubtful(f"--mountings: {quoted(name)} is not a mounting here; the rows have {listed}")
        if number not in numbers:
            known = ", ".join(map(str, numbers))
            raise Doubtful(f"--mountings: the schedule has no mounting {number}; it has {known}")


def require_one_name_a_mounting(
    texts: Sequence[str], rests: Rests, matched: Matched, schedule: Schedule, told: dict[str, int]
) -> None:
    """A column of mountings beside a continuous recording, `texts` by row: a name for each mounting, the one that is
    `told`; empty: there is none. Raises Doubtful."""
    _require_names(told, list(dict.fromkeys(texts)), schedule)
    known: dict[str, tuple[int, int]] = {}
    middles = (rests.begin + rests.end) // 2
    for number, (middle, position) in enumerate(zip(middles, matched.positions), 1):
        if position == NONE or not texts:
            continue
        mounting = schedule.positions[position].mounting
        name = texts[middle]
        if told.get(name, mounting) != mounting:
            raise Doubtful(f"rest {number} is in mounting {mounting}, but --mountings says {name!r} is {told[name]}")
        first, other = known.setdefault(name, (mounting, number))
        if first != mounting:
            raise Doubtful(
                f"the rows of mounting {name!r} are mounting {first} at rest {other} and {mounting} at rest {number}: "
                f"--leave-out {number} or {other}, or leave out that column (--columns mounting=)",
                Remedy({"columns": "mounting="}, "mountings come from gravity, not from that column"),
            )


def _only_way(given: _Labelled, named: dict[str, int]) -> _Way:
    """The numbers of mountings that labels and gravity agree on. Raises Doubtful."""
    keys = _mounting_keys(given.rests, given.schedule)
    _require_names(named, [key for key in dict.fromkeys(keys) if key != _ALL], given.schedule)
    if not named and (faces := faces_of(given.rests.labels, given.schedule)) is not None:
        numbers = {key: given.schedule.positions[place].mounting for key, place in zip(keys, faces)}
        return given.at(np.array(faces), numbers)
    found, faults = list[_Way](), list[Doubtful]()
    for numbers in _ways(list(dict.fromkeys(keys)), given.schedule, named):
        try:
            found.append(given.way(keys, numbers))
        except Doubtful as fault:
            faults.append(fault)
    if not found:
        many = Doubtful("the labels name more mountings than the schedule has", WITHOUT_LABELS)
        raise min(faults, key=lambda one: len(str(one)), default=many)
    if len(found) > 1:
        both = " and ".join(_told(one.numbers) for one in found[:3])
        ways = [_told(one.numbers) for one in found]
        which = [Remedy({"mountings": way}, f"the mountings are {way}") for way in ways]
        raise Doubtful(f"the mountings fit {len(found)} ways, {both}: choose with --mountings", *which)
    return found[0]


def faces_of(texts: dict[str, list[str]], schedule: Schedule) -> list[int] | None:
    """Indices of the positions of rests whose only labels name the axis that points up, such as +x, "z down" or Y_UP;
    None where they are no such names, or the schedule has no such attitudes."""
    if texts.keys() != {"mounting"}:
        return None
    names, forces, found = texts["mounting"], Geometry(schedule).force(), dict[str, int]()
    for name in set(names):
        if (face := _FACE.fullmatch(name.strip())) is None:
            return None
        axis, way = next((axis, way) for way, axis in (face.group(1, 2), face.group(4, 3)) if axis)
        up = np.eye(3)["xyz".index(axis.lower())] * (-1.0 if way.lower() in _DOWN else 1.0)
        near = np.flatnonzero(np.linalg.norm(forces - up, axis=1) < _SAME_FACE)
        if not len(near):
            return None
        found[name] = int(near[0])
    return [found[name] for name in names]


def _told(numbers: dict[str, int]) -> str:
    return ",".join(f"{key}={number}" for key, number in numbers.items())


def _mounting_keys(rests: Rests, schedule: Schedule) -> list[str]:
    """What tells the mountings of rests apart: their column, the file, or that positions begin anew."""
    labels = rests.labels
    if "mounting" in labels:
        return labels["mounting"]
    unknown = [""] * len(rests)
    positions, angles = labels.get("position", unknown), labels.get("angle", unknown)
    most = max((place.number for place in schedule.positions), default=0)
    if "number" in labels or max(_value(text) or 0 for text in positions) > most:
        return [_ALL] * len(rests)  # positions are numbered through all mountings
    if len(set(rests.file.tolist())) > 1:
        return [f"file{file + 1}" for file in rests.file.tolist()]
    keys, part, before = [], 1, -np.inf
    for position, angle in zip(positions, angles):
        value = _value(position or angle)
        if value is not None and value < before:
            part += 1
        before = -np.inf if value is None else value
        keys.append(f"part{part}")
    return keys


def _ways(keys: list[str], schedule: Schedule, named: dict[str, int]) -> Iterator[dict[str, int]]:
    """Numbers of mountings by key: what is said, else the schedule's own numbers, else every way."""
    numbers = [mounting.number for mounting in schedule.mountings]
    if keys == [_ALL]:
        yield {_ALL: 0}
        return
    own = {key: int(key) for key in keys if re.fullmatch(r"\d{1,3}", key) and int(key) in numbers}
    if set(own) == set(keys) and not named:
        yield own
        return
    fixed = {key: named[key] for key in keys if key in named}
    open_keys = [key for key in keys if key not in fixed]
    free = [number for number in numbers if number not in fixed.values()]
    if len(open_keys) > _MOST_NAMES:
        listed = ",".join(f"{key}=N" for key in open_keys[:2])
        raise Doubtful(
            f"{len(open_keys)} mountings have names, too many to try every number for each: give"
            f" --mountings {listed},... and leave at most {_MOST_NAMES} open"
        )
    for choice in itertools.permutations(free, len(open_keys)):
        yield {key: {**fixed, **dict(zip(open_keys, choice))}[key] for key in keys}


def _value(text: str | None) -> float | None:
    """The number that a label begins or ends with, such as 3 of "Pos 3" and "POS-3", and -45 of "-45°" and "at -45"."""
    found = re.search(r"(?:(?<![\w.,])-)?\d+(?:[.,]\d+)?", text or "")
    return float(found[0].replace(",", ".")) if found else None


def _position(labels: dict[str, str], mounting: int, schedule: Schedule) -> int:
    """Index of the position of a rest with these labels. Raises Doubtful."""
    position, number = labels.get("position"), labels.get("number")
    if mounting == 0 or (position is None and number is not None):
        text = position if number is None else number
        value = _value(text)
        if value is None or value != int(value) or not 1 <= value <= len(schedule.positions):
            raise Doubtful(
                f"{quoted(text)} is not a running number from 1 to {len(schedule.positions)} of the schedule; "
                "another schedule? (--schedule)",
                WITHOUT_LABELS,
            )
        return int(value) - 1
    inside = [index for index, place in enumerate(schedule.positions) if place.mounting == mounting]
    if position is None and "angle" not in labels:
        return inside[0]  # each mounting has one position
    if position is not None:
        value = _value(position)
        found = [index for index in inside if schedule.positions[index].number == value]
        what = f"position {quoted(position)}"
    else:
        value = _value(labels.get("angle"))
        off = {
            index: abs(schedule.positions[index].angle_deg - (np.inf if value is None else value)) for index in inside
        }
        found = [index for index in sorted(inside, key=off.__getitem__)[:1] if off[index] <= _NEAR_DEG]
        what = f"angle {quoted(labels.get('angle'))}"
    if not found:
        said = f"the schedule has no {what} in mounting {mounting}; another one? (--schedule)"
        raise Doubtful(said, WITHOUT_LABELS)
    return found[0]
