"""Recordings to a run, all steps of it: read, find rests, match, and what is to be told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.defaults import DEFAULT_SCHEDULE
from tumble.errors import BadInput, Remedy, UsageError, listed, quoted
from tumble.files import run_layout, run_rows
from tumble.files.run_file import smallest_step
from tumble.files.run_layout import NO_LAYOUT_OPTIONS, LayoutOptions
from tumble.importing import any_pose, can_bus, clocks, labels, match, recording, repairs
from tumble.importing.attitudes import scale_and_bias
from tumble.importing.can_bus import NO_BUS, Bus
from tumble.importing.clocks import CONTRADICTED, Timing
from tumble.importing.match import ANY, JOINED, NONE, POSITIVE, REPEATED, TAKEN, Doubtful, Matched, UserChoices
from tumble.importing.recording import Choice, Recording
from tumble.importing.rests import Found, Rests, Thresholds, find_rests
from tumble.model.geometry import built_in
from tumble.schedule import ANY_POSE, BUILT_IN, Schedule
from tumble.units import contradicts, looks_like

_SHORTEST_S, _LONGEST_S = 1.5, 900.0  # of the usual rest: nobody's hand or table is quicker, or so patient
_FEWEST_RESTS = 6  # of a recording that is of any use
_COUNTED = 0.9  # of the rows, by a column that counts them
_EXPLAINED = 0.8  # of the rests, by a schedule that is to be advised


@dataclass(frozen=True)
class Settings:
    """All that an import depends on, but for the files. `schedule`: its name or file, None: nobody says; `mountings`:
    numbers by name; `bus`: of CAN logs; `rows`: which are read, None: all."""

    schedule: str | None = None
    layout: LayoutOptions = NO_LAYOUT_OPTIONS
    timing: Timing = field(default_factory=Timing)
    thresholds: Thresholds = field(default_factory=Thresholds)
    user_choices: UserChoices = field(default_factory=UserChoices)
    mountings: dict[str, int] = field(default_factory=dict)
    bus: Bus = NO_BUS
    rows: Choice | None = None

    @property
    def schedule_name(self) -> str:
        """The schedule that is taken."""
        return self.schedule or DEFAULT_SCHEDULE


@dataclass(frozen=True)
class Imported:
    """`file_of_row`, `seconds`, `outputs` by row of all recordings, one after another; `rests` with what was
    made of each in `matched`; `labelled`: by the rows' own labels; `notes`: what was assumed and found."""

    recordings: tuple[Recording, ...]
    settings: Settings
    schedule: Schedule
    outputs: Floats
    seconds: Floats | None
    file_of_row: Integers
    found: Found
    rests: Rests
    matched: Matched
    labelled: bool
    notes: tuple[str, ...]

    @property
    def unit(self) -> str:
        """Of the outputs."""
        return self.recordings[0].unit

    @property
    def unit_told(self) -> bool:
        """By the files or the user, not assumed."""
        return all(one.unit_told for one in self.recordings)

    @cached_property
    def temperatures_c(self) -> Floats | None:
        """Of all rows, NaN where it is not known; None where no file tells it."""
        parts = [
            np.full(len(one.outputs), np.nan) if one.temperature is None else one.temperature for one in self.recordings
        ]
        return None if all(one.temperature is None for one in self.recordings) else np.concatenate(parts)

    def line(self, row: int) -> int:
        """The number of a row's line in its file."""
        before = sum(len(one.outputs) for one in self.recordings[: self.file_of_row[row]])
        return int(self.recordings[self.file_of_row[row]].lines[row - before])


def import_recordings(files: Sequence[str], schedule: Schedule, settings: Settings) -> Imported:
    """All of it. Raises BadInput and UsageError, which tell in `assumed` what they rest on, as far as that was known,
    and in `remedies` what is worth a try."""
    took: list[str] = []
    try:
        return _imported(files, schedule, settings, took)
    except Doubtful as doubt:
        refusal = BadInput(str(doubt), files[0]).advising(*doubt.remedies)
        refusal.assumed = tuple(took)
        raise refusal from None
    except (BadInput, UsageError) as refusal:
        refusal.assumed = tuple(dict.fromkeys((*took, *refusal.assumed)))
        raise


def _imported(files: Sequence[str], schedule: Schedule, settings: Settings, took: list[str]) -> Imported:
    """`took`: is filled with what is taken for granted. Raises Doubtful, BadInput and UsageError."""
    timing = replace(settings.timing, files=len(files))
    recordings = [
        _without_zeros(recording.read(file, settings.layout, timing, settings.bus, settings.rows)) for file in files
    ]
    if len(units := {one.unit for one in recordings}) > 1:
        raise UsageError(
            f"recordings in different units, {', '.join(sorted(units))}: set one with --unit, or import each separately"
        )
    joined = _Joined.of(recordings, settings.thresholds)
    recordings, found, interval = joined.recordings, joined.found, joined.interval
    texts, about_labels = _labels_that_tell(joined, schedule, settings.mountings)
    took += _took(joined, settings, texts, about_labels)
    about_sources = _require_one_block(joined)
    is_any = settings.schedule == ANY_POSE  # there labels tell the poses apart, and nothing tells how they lie
    labelled = not is_any and (bool(texts.keys() - {"mounting"}) or _is_by_face(texts, schedule, settings.mountings))
    if labelled and settings.schedule is None and texts.keys() == {"mounting"}:
        said = "no schedule is given, and rows are labelled by the axis that points up, like the faces of hand_laid"
        raise Doubtful(f"{said}: --schedule hand_laid", Remedy({"schedule": "hand_laid"}))
    rests, lost = found.rests, list[str]()
    if labelled or (texts and len(schedule.mountings) == len(schedule.positions)):
        rests, lost = labels.labelled_rests(texts, joined.outputs, joined.file_of_row, found, interval)
    settings.user_choices.require_rests(len(rests))
    try:
        if labelled:
            matched = labels.match(rests, schedule, settings.user_choices, settings.mountings)
        else:
            matched = _matched(rests, schedule, settings)
            names = [] if is_any else texts.get("mounting", [])
            labels.require_one_name_a_mounting(names, rests, matched, schedule, settings.mountings)
    except Doubtful as doubt:
        one_channel = repairs.about_channels(joined.outputs, recordings[0].columns)
        if one_channel is not None:
            raise Doubtful(one_channel) from None
        hint = _rate_hint(recordings, rests, settings.timing.rate_hz)
        raise Doubtful(f"{doubt}{hint}", *_with_columns(doubt.remedies, recordings[0])) from None
    notes = [
        *_notes(recordings, settings, interval, labelled),
        *_about_unit(recordings, matched),
        *_about_rate(settings.timing.rate_hz, interval, rests, matched),
        *about_labels,
        *about_sources,
        *matched.notes,
        *lost,
    ]
    return Imported(
        recordings=tuple(recordings),
        settings=settings,
        schedule=schedule,
        outputs=joined.outputs,
        seconds=joined.seconds,
        file_of_row=joined.file_of_row,
        found=found,
        rests=rests,
        matched=matched,
        labelled=labelled,
        notes=tuple(notes),
    )


@dataclass(frozen=True)
class _Joined:
    """Rows of all recordings, one after another, and their rests; `interval`: between two rows, s, None if unknown."""

    recordings: list[Recording]
    outputs: Floats
    file_of_row: Integers
    seconds: Floats | None
    interval: float | None
    found: Found

    @classmethod
    def of(cls, recordings: list[Recording], thresholds: Thresholds) -> _Joined:
        """Without stretches that repeat one value, if the rests that are left show noise that would have changed it."""
        own = cls._by_clock(recordings, thresholds)
        step = np.array([smallest_step(channel) for channel in own.outputs.T])
        same = np.zeros(len(own.outputs), dtype=bool)
        for first, last in repairs.same_runs(own.outputs, repairs.STUCK):
            same[first:last] = True
        if not same.any():
            return own
        moving = cls._of(_kept(recordings, ~same), thresholds)
        dead = repairs.stuck(own.outputs, moving.found.noise, step)
        if not dead.any() or len(moving.found.rests) < max(_FEWEST_RESTS, len(own.found.rests) // 2):
            return own
        note = "{} rows repeat one value, where noise would change it: left out"
        return cls._of(_kept(recordings, ~dead, note), thresholds)

    @classmethod
    def _by_clock(cls, recordings: list[Recording], thresholds: Thresholds) -> _Joined:
        """Without the clock, if it is hardly one, or by another unit of it, where nobody says it and its own shows next
        to no rest."""
        own = cls._of(recordings, thresholds)
        clock, is_enough = recordings[0].clock, len(own.found.rests) >= _FEWEST_RESTS
        if is_enough or len(recordings) > 1 or clock is None or not clock.unit or clock.told:
            return own
        if clocks.moves_seldom(clock):
            note = "clock: it changes at a few rows: not used (--columns time=)"
            without = cls._of([replace(recordings[0], clock=None, notes=(*recordings[0].notes, note))], thresholds)
            if len(without.found.rests) >= _FEWEST_RESTS:
                return without
        for unit in clocks.others(clock, len(own.outputs), 1):
            size = clocks.UNITS[unit] / clocks.UNITS[clock.unit]
            note = f"clock: {clock.unit} would show {len(own.found.rests)} rests: read as {unit} (--time-unit)"
            counted = replace(clock, seconds=clock.seconds * size, interval_s=clock.interval_s * size, unit=unit)
            other = cls._of([replace(recordings[0], clock=counted, notes=(*recordings[0].notes, note))], thresholds)
            if len(other.found.rests) >= _FEWEST_RESTS:
                return other
        return own

    @classmethod
    def _of(cls, recordings: list[Recording], thresholds: Thresholds) -> _Joined:
        outputs = np.concatenate([one.outputs for one in recordings])
        file_of_row = np.repeat(np.arange(len(recordings)), [len(one.outputs) for one in recordings])
        seconds, interval, gaps = _joined_clocks(recordings)
        return cls(recordings, outputs, file_of_row, seconds, interval, find_rests(outputs, gaps, interval, thresholds))


def _kept(recordings: Sequence[Recording], kept: Flags, note: str = "") -> list[Recording]:
    """The recordings with those of all rows that are kept; the `note` says how many are not."""
    parts, begin = [], 0
    for one in recordings:
        own = kept[begin : begin + len(one.outputs)]
        begin += len(one.outputs)
        notes = [note.format(int((~own).sum()))] if note and not own.all() else []
        parts.append(one.part(np.flatnonzero(own), *notes) if own.any() and not own.all() else one)
    return parts


def _without_zeros(one: Recording) -> Recording:
    return _kept([one], ~repairs.zeros(one.outputs), "{} rows of nothing but zeros are left out")[0]


def _with_columns(remedies: Sequence[Remedy], one: Recording) -> list[Remedy]:
    """With the names of the columns in place of those that a matcher does not know."""
    found = []
    for options, condition in remedies:
        told = options.get("columns") or ""
        for axis in "xyz":
            told = told.replace(match.THAT_OF.format(axis), one.columns.get(f"u{axis}", axis))
        found.append(Remedy({**options, "columns": told} if told else options, condition))
    return found


def _require_one_block(joined: _Joined) -> list[str]:
    """A note where rows at rest may be of several sources in turn. Raises BadInput where they are, and where rows stand
    there twice."""
    recordings, outputs, file_of_row = joined.recordings, joined.outputs, joined.file_of_row
    step = np.array([smallest_step(channel) for channel in outputs.T])
    lines = np.concatenate([one.lines for one in recordings])
    file = recordings[0].file
    copies = run_rows.copied(outputs, file_of_row, step)
    if copies is not None:
        begin, end = copies.again, copies.again + copies.length - 1
        named = (f"{lines[row]} to {lines[row + copies.length - 1]}" for row in (copies.again, copies.first))
        said = run_rows.WRITTEN_AGAIN.format(*named)
        is_rest = len(recordings) == 1 and end == len(lines) - 1
        without = [Remedy({"rows": f"{lines[0]}:{lines[begin - 1]}"})] if is_rest else []
        raise BadInput(said, recordings[file_of_row[begin]].file, int(lines[begin])).advising(*without)
    spans = list(zip(joined.found.rests.begin.tolist(), joined.found.rests.end.tolist()))
    sources = run_rows.in_turn((outputs[begin:end] for begin, end in spans), step, recordings[0].unit)
    column = recordings[0].source if len(recordings) == 1 else None
    if sources is not None and sources.is_certain:
        said = sources.sentence
        choice = f"1/{sources.number}" if column is None else f"{column[0]}={column[1][0]}"
        raise BadInput(said, file, int(lines[0])).advising(Remedy({"rows": choice}, "the first source is meant"))
    if column is not None and repairs.turns(outputs, column[1], spans):
        values = listed([quoted(value) for value in dict.fromkeys(column[1])])
        said = f"rows come from several sources, by column {quoted(column[0])}, {values}: --rows selects one"
        one = Remedy({"rows": f"{column[0]}={column[1][0]}"}, "the first source is meant")
        raise BadInput(said, file, int(lines[0])).advising(one)
    return [] if sources is None else [sources.sentence]


def _is_by_face(texts: dict[str, list[str]], schedule: Schedule, told: dict[str, int]) -> bool:
    """Are the mountings, which name positions where each has one, told by their names or numbers?"""
    names, numbers = set(texts.get("mounting", [])), {str(mounting.number) for mounting in schedule.mountings}
    if not names or labels.faces_of({"mounting": sorted(names)}, schedule) is not None:
        return bool(names)
    return len(schedule.mountings) == len(schedule.positions) and (names <= numbers or names <= set(told))


def _labels_that_tell(
    joined: _Joined, schedule: Schedule, told: dict[str, int]
) -> tuple[dict[str, list[str]], list[str]]:
    """The labels (by name, a text for each row) that all recordings have, without those that tell nothing: the same in
    every row, counting them, or changing at rest; and sentences on these. `told`: names of mountings that the user says
    numbers of."""
    recordings = joined.recordings
    names = set.intersection(*(set(one.labels) for one in recordings))
    texts = {name: [text for one in recordings for text in one.labels[name]] for name in sorted(names)}
    meant = set(texts.get("mounting", [])) if len(schedule.mountings) == 1 else set(told)
    notes = {
        name: f"{name}: {quoted(rows[0])} is the same in every row, so it cannot identify positions: not read"
        for name, rows in texts.items()
        if len(set(rows)) == 1 and not (name == "mounting" and rows[0] in meant)
    }
    for name in texts.keys() - notes.keys():
        column = f"column {quoted(recordings[0].columns.get(name, name))}"
        if _counts(texts[name], 2 * len(schedule.positions)):
            notes[name] = f"{column} counts samples: not read"
        elif _changes_at_rest(texts[name], joined.found.rests):
            notes[name] = f"{column} changes during a rest, so it is not a {name}: not read"
    return {name: rows for name, rows in texts.items() if name not in notes}, [notes[name] for name in sorted(notes)]


def _counts(texts: list[str], fewest: int) -> bool:
    """Do so many rows, or more, count themselves, from wherever they begin anew?"""
    changes = [texts[row] != texts[row - 1] for row in range(1, len(texts))]
    if len(texts) <= fewest or sum(changes) < _COUNTED * len(changes):
        return False
    if not all(map(run_layout.is_number, texts)):
        return False
    steps = np.diff([float(text.replace(",", ".")) for text in texts])
    return bool((steps == np.median(steps)).mean() >= _COUNTED and np.median(steps) != 0.0)


def _changes_at_rest(texts: list[str], rests: Rests) -> bool:
    """Are there several of them in most rests?"""
    spans = zip(rests.begin.tolist(), rests.end.tolist())
    several = [len(set(texts[begin:end])) > 1 for begin, end in spans]
    return len(several) >= _FEWEST_RESTS and sum(several) > len(several) / 2


def _joined_clocks(recordings: Sequence[Recording]) -> tuple[Floats | None, float | None, Integers]:
    """Seconds of all rows, the interval between two, and the rows before which time is missing: each file begins with a
    gap, and where the one before ended."""
    begins = np.cumsum([0, *(len(one.outputs) for one in recordings)])
    clocks = [one.clock for one in recordings]
    gaps = list(begins[1:-1])
    if any(clock is None for clock in clocks):
        return None, None, np.array(gaps, dtype=int)
    seconds, offset = [], 0.0
    for clock, begin in zip(clocks, begins):
        assert clock is not None
        seconds.append(clock.seconds + offset)
        gaps += (clock.gaps + begin).tolist()
        offset = float(seconds[-1][-1]) + clock.interval_s
    intervals = sorted(clock.interval_s for clock in clocks if clock is not None)
    if intervals[-1] > 1.5 * intervals[0]:
        rates = ", ".join(f"{1 / interval:.4g}" for interval in intervals)
        raise UsageError(f"recordings of different rates, {rates} Hz: import each separately")
    return np.concatenate(seconds), intervals[0], np.array(sorted(gaps), dtype=int)


def _matched(rests: Rests, schedule: Schedule, settings: Settings) -> Matched:
    """Raises Doubtful; where no schedule was said, with the one that fits."""
    if settings.schedule == ANY_POSE:
        return any_pose.matched(rests, settings.user_choices)
    try:
        matched = match.match(rests, schedule, settings.user_choices)
        missing = len(schedule.positions) - len(set(matched.positions.tolist()) - {NONE})
        if missing and settings.schedule is None and (other := _other_schedule(rests, matched, settings.user_choices)):
            said = f"no schedule is given, and of {DEFAULT_SCHEDULE} {missing} positions have no rest: {other[0]}"
            raise Doubtful(said, other[1])
        return matched
    except Doubtful as doubt:
        if settings.schedule is None and "--schedule" not in str(doubt):
            other = _other_schedule(rests, None, settings.user_choices)
            if other:
                said = f"no schedule is given, and {DEFAULT_SCHEDULE} does not fit: {other[0]}"
                raise Doubtful(said, other[1]) from None
        raise


def _other_schedule(rests: Rests, matched: Matched | None, user_choices: UserChoices) -> tuple[str, Remedy] | None:
    """Advice, and its options, where another built-in schedule is found as a whole, and explains nearly all rests: of
    those that are, the one of most positions."""
    explained = max(_EXPLAINED * len(rests), 0 if matched is None else _explained(matched))
    advice: dict[int, tuple[str, Remedy]] = {}
    for name in BUILT_IN:
        if name == DEFAULT_SCHEDULE:
            continue
        schedule = built_in(name)
        for order in dict.fromkeys((user_choices.order, ANY)):
            signs = user_choices.signs or POSITIVE
            tried = replace(user_choices, order=order, signs=signs, repeats=user_choices.repeats or "first")
            try:
                other = match.match(rests, schedule, tried)
            except Doubtful:
                continue
            whole = set(range(len(schedule.positions))) <= set(other.positions.tolist())
            if whole and _explained(other) >= explained:
                options = f"--schedule {name}" + (" --order any" if order != user_choices.order else "")
                said = {"schedule": name} | ({"order": ANY} if order != user_choices.order else {})
                advice.setdefault(len(schedule.positions), (f"all of {name} have: {options}", Remedy(said)))
    return advice[max(advice)] if advice else None


def _explained(matched: Matched) -> int:
    """How many rests are at a position, if for the second time."""
    return sum(state in (TAKEN, JOINED, REPEATED) for state in matched.states)


def _notes(recordings: Sequence[Recording], settings: Settings, interval: float | None, labelled: bool) -> list[str]:
    several = len(recordings) > 1
    notes = [
        f"{f'file {number}: ' if several else ''}{note}"
        for number, one in enumerate(recordings, 1)
        for note in one.notes
    ]
    if settings.schedule is None:
        notes.append(f"schedule: not given, assumed to be {DEFAULT_SCHEDULE} (--schedule)")
    if interval is None and not labelled:
        notes.append("clock: none, so lengths are counted in samples (--rate HZ gives seconds)")
    return notes


def _took(joined: _Joined, settings: Settings, texts: dict[str, list[str]], about_labels: Sequence[str]) -> list[str]:
    """What a refusal rests on: clock, outputs and their unit, schedule, labels, rests and their noise, sources."""
    recordings, found = joined.recordings, joined.found
    first, timing = recordings[0], settings.timing
    rate = "" if joined.interval is None else f", {1 / joined.interval:.4g} Hz"
    time = "no clock, lengths are in samples (--rate HZ gives seconds)"
    if timing.rate_hz is not None:
        time = f"time by --rate {timing.rate_hz:g} Hz"
    elif first.clock is not None and "time" in first.columns:
        counted = f" in {first.clock.unit}" if first.clock.unit else ""
        time = f"time of column {quoted(first.columns['time'])}{counted}{rate}"
    elif first.clock is not None:
        time = f"time of the log{rate}"
    unit = first.unit
    if not all(one.unit_told for one in recordings):
        rough = scale_and_bias(found.rests.means)
        unit += ", assumed because no unit is given " + _unit_hint(
            None if rough is None else float(np.prod(rough[0]) ** (1 / 3))
        )
    outputs = quoted(", ".join(first.columns.get(name, name) for name in can_bus.OUTPUTS), 100)[1:-1]
    names = [quoted(first.columns.get(name, name)) for name in texts]
    noise = " ".join(f"{one:.3g}" for one in found.noise)
    said = "schedule: not given"  # and the clock: it is among them already
    return [
        time,
        f"outputs {outputs} in {unit}",
        f"schedule {settings.schedule_name}{', the default (--schedule)' if settings.schedule is None else ''}",
        f"labels {' and '.join(names)} (--columns)" if names else "no labels of positions",
        f"{len(found.rests)} rests, noise {noise} {first.unit} (--still, --drift)",
        "one source" if len(recordings) == 1 else f"{len(recordings)} recordings, one after another",
        *(one for one in _notes(recordings, settings, None, True) if not one.startswith((said, CONTRADICTED))),
        *about_labels,
    ]


def _about_rate(rate_hz: float | None, interval: float | None, rests: Rests, matched: Matched) -> list[str]:
    """That the rests are so short or long by the rate which the user says, or so long by the clock, that it may be
    wrong."""
    lengths = rests.samples[matched.positions != NONE]
    if interval is None or not len(lengths):
        return []
    usual_s = float(np.median(lengths)) * interval
    if (rate_hz is None or usual_s >= _SHORTEST_S) and usual_s <= _LONGEST_S:
        return []
    if rate_hz is None:
        return [f"clock: a typical rest lasts {usual_s:.3g} s: if that is not so, its unit is wrong (--time-unit)"]
    return [
        f"clock: at --rate {rate_hz:g} Hz a typical rest lasts {usual_s:.3g} s: if that is not so, the rate is wrong"
    ]


def _rate_hint(recordings: Sequence[Recording], rests: Rests, rate_hz: float | None) -> str:
    """Behind a refusal: that the rate which the user says may be why; empty where nothing speaks for that."""
    contradictions = [note for one in recordings for note in one.notes if note.startswith(CONTRADICTED)]
    if contradictions:
        return f"; {contradictions[0]}"
    return "" if rate_hz is None or len(rests) >= _FEWEST_RESTS else f"; is --rate {rate_hz:g} right?"


def _about_unit(recordings: Sequence[Recording], matched: Matched) -> list[str]:
    """That nobody says the unit of the outputs, and which one they look like, or that they look to be in another."""
    per_g = float(np.abs(np.linalg.det(matched.fit.k)) ** (1 / 3))
    if all(one.unit_told for one in recordings):
        seen, unit = contradicts(per_g, recordings[0].unit), recordings[0].unit
        return [] if seen is None else [f"unit: {unit} is given, but 1 g is {per_g:.4g} of it, as in {seen}"]
    hint = _unit_hint(per_g)
    return [f"unit: not given, and the run file names none either {hint}"]


def _unit_hint(per_g: float | None) -> str:
    """What the unit may be where 1 g comes out as so much, None: unknown."""
    seen = None if per_g is None else looks_like(per_g)
    return "(--unit)" if seen is None else f"(1 g is {per_g:.4g} of it, which looks like {seen})"
