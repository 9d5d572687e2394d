"""Recordings to a run, all steps of it: read, find rests, match, and what is to be told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.defaults import DEFAULT_SCHEDULE
from tumble.errors import BadInput, UsageError, quoted
from tumble.files import run_rows
from tumble.files.run_file import smallest_step
from tumble.files.run_layout import NO_WISHES, Wishes
from tumble.importing import any_pose, labels, match, recording
from tumble.importing.attitudes import scale_and_bias
from tumble.importing.can_bus import NO_BUS, Bus
from tumble.importing.match import ANY, JOINED, NONE, POSITIVE, REPEATED, TAKEN, Claims, Doubtful, Matched
from tumble.importing.recording import CONTRADICTED, Recording, Timing
from tumble.importing.rests import Found, Rests, Thresholds, find_rests
from tumble.model.geometry import built_in
from tumble.schedule import ANY_POSE, BUILT_IN, Schedule
from tumble.units import looks_like

_SHORTEST_S, _LONGEST_S = 1.5, 900.0  # of the usual rest: nobody's hand or table is quicker, or so patient
_FEWEST_RESTS = 6  # of a recording that is of any use
_EXPLAINED = 0.8  # of the rests, by a schedule that is to be advised


@dataclass(frozen=True)
class Settings:
    """All that an import depends on, but for the files. `schedule`: its name or file, None: nobody says; `mountings`:
    numbers by name; `bus`: of CAN logs."""

    schedule: str | None = None
    wishes: Wishes = NO_WISHES
    timing: Timing = field(default_factory=Timing)
    thresholds: Thresholds = field(default_factory=Thresholds)
    claims: Claims = field(default_factory=Claims)
    mountings: dict[str, int] = field(default_factory=dict)
    bus: Bus = NO_BUS

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
    """All of it. Raises BadInput and UsageError.

    Once the rests are found, a BadInput tells in `assumed` what it rests on. One before, of reading a file, does not:
    the fault is in the file itself, and noise and rests, which `assumed` tells too, are not known yet.
    """
    recordings = [recording.read(file, settings.wishes, settings.timing, settings.bus) for file in files]
    if len(units := {one.unit for one in recordings}) > 1:
        raise UsageError(
            f"recordings in different units, {', '.join(sorted(units))}: --unit says which, or import each"
        )
    outputs = np.concatenate([one.outputs for one in recordings])
    lengths = [len(one.outputs) for one in recordings]
    file_of_row = np.repeat(np.arange(len(files)), lengths)
    seconds, interval, gaps = _joined_clocks(recordings)
    found = find_rests(outputs, gaps, interval, settings.thresholds)
    texts, about_same = _labels_that_tell(recordings, schedule, settings.mountings)
    labelled, rests = bool(texts.keys() - {"mounting"}), found.rests
    about_sources = _require_one_block(recordings, outputs, file_of_row, found)
    try:
        if labelled:
            rests, lost = labels.labelled_rests(texts, outputs, file_of_row, found, interval)
            settings.claims.require_rests(len(rests))
            matched = labels.match(rests, schedule, settings.claims, settings.mountings)
            matched = replace(matched, notes=(*matched.notes, *lost))
        else:
            settings.claims.require_rests(len(rests))
            matched = _matched(rests, schedule, settings)
            names = texts.get("mounting", [])
            labels.require_one_name_a_mounting(names, rests, matched, schedule, settings.mountings)
    except (BadInput, Doubtful) as doubt:
        hint = _rate_hint(recordings, rests, settings.timing.rate_hz)
        refusal = doubt if isinstance(doubt, BadInput) else BadInput(f"{doubt}{hint}", files[0])
        refusal.assumed = _assumed(recordings, settings, found, interval, texts, about_same)
        raise refusal from None
    notes = [
        *_notes(recordings, settings, interval, labelled),
        *_about_unit(recordings, matched),
        *_about_rate(settings.timing.rate_hz, rests, matched),
        *about_same,
        *about_sources,
        *matched.notes,
    ]
    return Imported(
        recordings=tuple(recordings),
        settings=settings,
        schedule=schedule,
        outputs=outputs,
        seconds=seconds,
        file_of_row=file_of_row,
        found=found,
        rests=rests,
        matched=matched,
        labelled=labelled,
        notes=tuple(notes),
    )


def _require_one_block(
    recordings: Sequence[Recording], outputs: Floats, file_of_row: Integers, found: Found
) -> list[str]:
    """A note where rows at rest may be of several sources in turn. Raises BadInput where they are, and where rows stand
    there twice."""
    step = np.array([smallest_step(channel) for channel in outputs.T])
    lines = np.concatenate([one.lines for one in recordings])
    file = recordings[0].file
    copies = run_rows.copied(outputs, file_of_row, step)
    if copies is not None:
        named = (f"{lines[row]} to {lines[row + copies.length - 1]}" for row in (copies.again, copies.first))
        said = run_rows.WRITTEN_AGAIN.format(*named)
        raise BadInput(said, recordings[file_of_row[copies.again]].file, int(lines[copies.again]))
    rests = (outputs[begin:end] for begin, end in zip(found.rests.begin, found.rests.end))
    sources = run_rows.in_turn(rests, step, recordings[0].unit)
    if sources is not None and sources.is_certain:
        raise BadInput(sources.sentence, file, int(lines[0]))
    return [] if sources is None else [sources.sentence]


def _labels_that_tell(
    recordings: Sequence[Recording], schedule: Schedule, told: dict[str, int]
) -> tuple[dict[str, list[str]], list[str]]:
    """The labels (by name, a text for each row) that all recordings have, without those that are the same in every row
    and tell nothing; and sentences on these. `told`: names of mountings that the user says numbers of."""
    names = set.intersection(*(set(one.labels) for one in recordings))
    texts = {name: [text for one in recordings for text in one.labels[name]] for name in sorted(names)}
    meant = set(texts.get("mounting", [])) if len(schedule.mountings) == 1 else set(told)
    same = {
        name: rows[0]
        for name, rows in texts.items()
        if len(set(rows)) == 1 and not (name == "mounting" and rows[0] in meant)
    }
    notes = [f"{name}: {quoted(text)} in every row, which tells nothing: not read" for name, text in same.items()]
    return {name: rows for name, rows in texts.items() if name not in same}, notes


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
        raise UsageError(f"recordings of different rates, {rates} Hz: import each alone")
    return np.concatenate(seconds), intervals[0], np.array(sorted(gaps), dtype=int)


def _matched(rests: Rests, schedule: Schedule, settings: Settings) -> Matched:
    """Raises Doubtful; where no schedule was said, with the one that fits."""
    if settings.schedule == ANY_POSE:
        return any_pose.matched(rests, settings.claims)
    try:
        matched = match.match(rests, schedule, settings.claims)
        missing = len(schedule.positions) - len(set(matched.positions.tolist()) - {NONE})
        if missing and settings.schedule is None and (other := _other_schedule(rests, matched, settings.claims)):
            raise Doubtful(f"no schedule is told, and of {DEFAULT_SCHEDULE} {missing} positions have no rest: {other}")
        return matched
    except Doubtful as doubt:
        if settings.schedule is None and "--schedule" not in str(doubt):
            other = _other_schedule(rests, None, settings.claims)
            if other:
                raise Doubtful(f"no schedule is told, and {DEFAULT_SCHEDULE} does not fit: {other}") from None
        raise


def _other_schedule(rests: Rests, matched: Matched | None, claims: Claims) -> str | None:
    """Advice, where another built-in schedule is found as a whole, and explains nearly all rests: of those that are,
    the one of most positions."""
    explained = max(_EXPLAINED * len(rests), 0 if matched is None else _explained(matched))
    advice: dict[int, str] = {}
    for name in BUILT_IN:
        if name == DEFAULT_SCHEDULE:
            continue
        schedule = built_in(name)
        for order in dict.fromkeys((claims.order, ANY)):
            signs = claims.signs or POSITIVE
            tried = replace(claims, order=order, signs=signs, repeats=claims.repeats or "first")
            try:
                other = match.match(rests, schedule, tried)
            except Doubtful:
                continue
            whole = set(range(len(schedule.positions))) <= set(other.positions.tolist())
            if whole and _explained(other) >= explained:
                options = f"--schedule {name}" + (" --order any" if order != claims.order else "")
                advice.setdefault(len(schedule.positions), f"all of {name} have: {options}")
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
        notes.append(f"schedule: nobody says, taken for {DEFAULT_SCHEDULE} (--schedule)")
    if interval is None and not labelled:
        notes.append("clock: none, so lengths are counted in samples (--rate HZ gives seconds)")
    return notes


def _assumed(
    recordings: Sequence[Recording],
    settings: Settings,
    found: Found,
    interval: float | None,
    texts: dict[str, list[str]],
    about_same: Sequence[str],
) -> tuple[str, ...]:
    """What a refusal rests on besides what was said: schedule, clock, unit, what tells the positions, noise."""
    by_labels = texts.keys() - {"mounting"}
    notes = _notes(recordings, settings, interval, bool(by_labels))
    said = ("schedule: nobody", "clock: ")
    facts = [note for note in notes if any(start in note for start in said) and CONTRADICTED not in note]
    for column in (quoted(one.clock_column) for one in recordings if one.clock_column is not None):
        facts += [] if any(column in note for note in facts) else [f"clock: column {column}"]
    if any(not one.unit_told for one in recordings):
        rough = scale_and_bias(found.rests.means)
        facts.append("unit: nobody says " + _unit_hint(None if rough is None else float(np.prod(rough[0]) ** (1 / 3))))
    if by_labels:
        facts.append(f"positions: by labels of the rows, {' and '.join(texts)} (--columns)")
    else:
        facts += about_same or ["positions: by gravity, for the rows have no labels of positions (--columns)"]
    if found.noise.any() and (interval is not None or not by_labels):
        noise = " ".join(f"{one:.3g}" for one in found.noise)
        facts.append(f"rests: {len(found.rests)}, by the noise of the quietest rows, {noise} (--still, --drift)")
    return tuple(dict.fromkeys(facts))


def _about_rate(rate_hz: float | None, rests: Rests, matched: Matched) -> list[str]:
    """That the rests are so short or long by the rate which the user says that it may be wrong."""
    lengths = rests.samples[matched.positions != NONE]
    if rate_hz is None or not len(lengths):
        return []
    usual_s = float(np.median(lengths)) / rate_hz
    if _SHORTEST_S <= usual_s <= _LONGEST_S:
        return []
    return [f"clock: at --rate {rate_hz:g} Hz the usual rest lasts {usual_s:.3g} s: is that so? Else the rate is wrong"]


def _rate_hint(recordings: Sequence[Recording], rests: Rests, rate_hz: float | None) -> str:
    """Behind a refusal: that the rate which the user says may be why; empty where nothing speaks for that."""
    doubts = [note for one in recordings for note in one.notes if note.startswith(CONTRADICTED)]
    if doubts:
        return f"; {doubts[0]}"
    return "" if rate_hz is None or len(rests) >= _FEWEST_RESTS else f"; is --rate {rate_hz:g} right?"


def _about_unit(recordings: Sequence[Recording], matched: Matched) -> list[str]:
    """That nobody says the unit of the outputs, and which one they look like."""
    if all(one.unit_told for one in recordings):
        return []
    hint = _unit_hint(float(np.abs(np.linalg.det(matched.fit.k)) ** (1 / 3)))
    return [f"unit: nobody says; the run file names none either {hint}"]


def _unit_hint(per_g: float | None) -> str:
    """What the unit may be where 1 g comes out as so much, None: unknown."""
    seen = None if per_g is None else looks_like(per_g)
    return "(--unit)" if seen is None else f"(1 g is {per_g:.4g} of it, which looks like {seen})"
