"""`tumble.World`: firmware, stand, block and bus in one virtual time, held by a script."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from tumble.api.result import Result
from tumble.defaults import DEFAULT_SCHEDULE
from tumble.documents import base, bench
from tumble.errors import NotInstalled, UsageError, quoted
from tumble.estimators import ESTIMATORS, OPTIMAL
from tumble.files.schedule_file import planned_with
from tumble.files.stand_file import stand_file_of
from tumble.firmware_tables import STATES
from tumble.world import in_process, outcome
from tumble.world.border import (
    CHANGE,
    ENDED,
    FOREVER_US,
    OPERATORS,
    QUESTION,
    SENDERS,
    Border,
    Event,
    Key,
    Refused,
    keys,
)
from tumble.world.setup import BY_OPTION, Setup, as_declared, gain_record, scenario_text, setup_of

if TYPE_CHECKING:
    from tumble.world.virtual_bus import VirtualBus

_STATE = "TUMBLE_STATE_"
_ESTIMATOR, _SAMPLES, _LIMIT = "procedure.estimator", "procedure.samples", "procedure.gravity_limit_g"
_BUDGET = "procedure.error_budget_v"
_US = 1e6
_LONGEST_S = 1e9
Number = TypeVar("Number", int, float)


class Frame(NamedTuple):
    """A frame on the bus: `time_s` of its end since power-on, the identifier, its data, and who sent it."""

    time_s: float
    id: int
    data: bytes
    sender: str


class World:
    """A simulated calibration that goes on when its holder lets it: the firmware as it flies, a stand with a drive or a
    dividing head, the block, the bus between them, an operator, and faults.

    Seed and arguments determine everything, to the last bit; `run.csv` and `bus.log` of `tumble bench --seed` are what
    a world with that seed records.

    Parameters
    ----------
    seed : int, optional
        Of all that is random, 0 to 2^64 - 1.
    stand, schedule : any, optional
        As `tumble.solve` takes them; default: the paper's.
    samples : int, optional
        Of a position.
    operator : str, optional
        Who acts when the firmware waits for a person: "by-itself" (the simulated operator), "on-confirm" (he does what
        somebody on the bus confirms), "never", or "asked" (`answer`).
    memory : bool, optional
        The computer keeps coefficients over a loss of power, and keeper.serial names the block.
    keys : any, optional
        Of a scenario (`World.keys()`), where they win over the stand file: numbers, texts, True or False, a list for
        several values; for `fault` and other lines that may repeat, a text or a list of them.

    Raises
    ------
    UsageError, BadInput
    BenchFault
        Where the extension is not built.

    Examples
    --------
    >>> import tumble
    >>> world = tumble.World(3, **{"fault": "stall at=1.3 phase=move duration=2"}).run()
    >>> world.state, world.reason
    ('FAULT', 'STALL')
    """

    def __init__(
        self,
        seed: int = 1,
        *,
        stand: Any = None,
        schedule: Any = None,
        samples: int | None = None,
        operator: str = OPERATORS[0],
        memory: bool = False,
        **keys: Any,
    ):
        if operator not in OPERATORS:
            raise UsageError(f"operator: {quoted(operator)} is not one of {', '.join(OPERATORS)}")
        self._stand_file = None if stand is None else stand_file_of(stand)
        self._setup = self._setup_of(seed, schedule, samples, keys)
        lines = list(_lines(keys))
        given = {line.partition("=")[0].strip() for line in lines}
        own = [one for one in scenario_text(self._setup).splitlines() if one.partition("=")[0].strip() not in given]
        self._setup = as_declared(self._setup, lines)
        record = gain_record(self._setup) if self._setup.estimator == OPTIMAL else None
        try:
            self._border = Border(seed, [*lines, *own], record, operator, memory)
        except Refused as refused:
            raise UsageError(f"this cannot be simulated: {refused}") from None

    def _setup_of(self, seed: int, schedule: Any, samples: int | None, keys: Mapping[str, Any]) -> Setup:
        estimator = keys.get(_ESTIMATOR)
        if estimator is not None and estimator not in ESTIMATORS:
            raise UsageError(f"{_ESTIMATOR}: {quoted(estimator)} is not one of {', '.join(ESTIMATORS)}")
        if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed < 2**64:
            raise UsageError(f"seed: {quoted(seed)} is not a whole number from 0 to 2^64 - 1")
        planned, estimator = planned_with(DEFAULT_SCHEDULE if schedule is None else schedule, estimator)
        if samples is not None and _SAMPLES in keys:
            raise UsageError(f"{_SAMPLES} is given by samples, too")
        for key, (_, place) in BY_OPTION.items():
            if key in keys and place is not None:
                raise UsageError(f"{key}: give it by {place}")
        samples, limit_g = _number(_SAMPLES, keys.get(_SAMPLES, samples), int), _number(_LIMIT, keys.get(_LIMIT), float)
        others = {"estimator": estimator, "error_budget_v": _number(_BUDGET, keys.get(_BUDGET), float) or 0.0}
        return setup_of(seed, self._stand_file, planned, samples, limit_g, **others)

    @staticmethod
    def keys() -> dict[str, Key]:
        """The keys of a scenario that come at most once, by name, with how many values each has and their range."""
        return keys()

    # Time.

    def run(self) -> World:
        """Let it go on to its end, when the table rests. Returns the world."""
        in_process.Run(self._border, lambda event: None, events=0).to_its_end()
        return self

    def advance(self, seconds: float | None = None, until: str | None = None) -> bool:
        """Let so much virtual time pass, or as much as it takes until the procedure is in the state `until`, such as
        "AVERAGE"; without either, until it moves on. Returns whether the world goes on; False: it has ended. Raises
        UsageError."""
        if until is not None and until not in STATES:
            raise UsageError(f"until: {quoted(until)} is none of {', '.join(STATES)}")
        end_us = FOREVER_US if seconds is None else self._border.now_us + round(_seconds(seconds) * _US)
        waits = until is not None or seconds is None
        while True:
            happened = self._border.advance(end_us, CHANGE if waits else 0)
            if happened & ENDED:
                return False
            if not happened or until is None or self.state == until:
                return True

    def stop(self) -> World:
        """Stop the table, give up, and let it come to rest. Returns the world."""
        self._border.end("interrupted")
        self._border.advance(FOREVER_US, 0)
        return self

    # What is done to it.

    def send(self, identifier: int, data: bytes) -> None:
        """Put a classic data frame on the bus, as one more node; it takes part in arbitration. Raises UsageError."""
        self._take(lambda one, what: self._border.send(one, bytes(what)), identifier, data)

    def turn_table(self, angle_deg: float, speed_deg_s: float) -> None:
        """Turn the table, for a drive of the caller's on the bus (present.drive = no): to at most 36000 degrees either
        way, at 1e-5 to 1e5 degrees per second. Raises UsageError."""
        self._take(self._border.turn_table, angle_deg, speed_deg_s)

    def bus(self, **options: Any) -> VirtualBus:
        """It as a bus of python-can, whose time the calling thread's `recv` and `sleep` let pass; `options`: as
        can_filters. The world goes on when the bus has been shut down. Needs python-can. Raises NotInstalled."""
        try:
            from tumble.world.virtual_bus import VirtualBus
        except ImportError:
            raise NotInstalled("the bus of a world", "python-can", extra="can") from None
        return VirtualBus(world=self._border, **options)

    def answer(self, words: str) -> None:
        """Of a world whose operator is asked: done, abort, leave, repeat position INDEX or repeat mounting NUMBER.
        Raises UsageError for what is not accepted."""
        self._take(self._border.answer, words)

    def cut_power(self) -> None:
        """Of the navigation computer: what it knows is lost but for its memory."""
        self._take(self._border.set_power, False)

    def start(self) -> None:
        """Command a calibration. Raises UsageError where one is under way."""
        self._take(self._border.start)

    def restore_power(self) -> None:
        """The firmware begins anew, and waits for a command. Raises UsageError where it refuses."""
        self._take(self._border.set_power, True)

    def _take(self, call: Any, *arguments: Any) -> None:
        try:
            call(*arguments)
        except Refused as refused:
            raise UsageError(str(refused)) from None
        except (TypeError, ValueError, OverflowError, AttributeError):
            raise UsageError(f"of the wrong type, or too large: {', '.join(map(quoted, arguments))}") from None

    # How it stands.

    def _state(self) -> Event:
        event = self._border.event(CHANGE)
        assert event is not None  # it can always be told
        return event

    @property
    def now_s(self) -> float:
        """Virtual time since power-on, s."""
        return self._border.now_us / _US

    @property
    def end(self) -> str:
        """running, done, fault, interrupted, too long or left."""
        return self._border.document().end

    @property
    def state(self) -> str:
        """Of the procedure, such as AVERAGE or DONE."""
        return str(self._state()["state"]).removeprefix(_STATE)

    @property
    def reason(self) -> str:
        """Of a fault or a refusal, by its name; NONE."""
        return str(self._state()["reason"]).removeprefix("TUMBLE_REASON_")

    @property
    def question(self) -> dict[str, Any] | None:
        """What a person is asked for: kind (mounting, angle, fault) and what it needs; None: nothing."""
        asked = self._border.event(QUESTION)
        return asked and {key: value for key, value in asked.items() if key not in ("event", "virtual_s")}

    @property
    def angle_deg(self) -> float | None:
        """Of the table, as its drive reports it; None: unknown."""
        angle_deg = self._state()["angle_deg"]
        return None if angle_deg is None else float(angle_deg)

    @property
    def table(self) -> dict[str, Any]:
        """Its true travel since power-on: lowest_deg, highest_deg, at_rest."""
        return base.written(self._border.document().table)

    @property
    def truth(self) -> dict[str, Any]:
        """What was simulated: K (V/g, rows), U0 (V), alpha1_rad and the other errors of the stand."""
        return base.written(self._border.document().truth)

    @property
    def counters(self) -> dict[str, int]:
        """Of firmware and bus, by name."""
        return self._border.document().counters

    @property
    def memory(self) -> bytes:
        """A copy of the computer's non-volatile memory; empty where it has none."""
        return self._border.memory

    @property
    def document(self) -> dict[str, Any]:
        """All of it, schema tumble.bench/1."""
        return bench.written(self._border.document())

    def frames(self) -> Iterator[Frame]:
        """Every frame since power-on, in order."""
        for time_us, identifier, length, sender, data in self._border.frames().tolist():
            yield Frame(time_us / _US, identifier, data[:length], SENDERS[min(sender, len(SENDERS) - 1)])

    @cached_property
    def result(self) -> Result:
        """The firmware's calibration, confirmed by numpy, as `tumble.solve` gives it. Raises BenchFault where the run
        has not come to a result, Disagreement."""
        found = self._border.document()
        outcome.require_done(found)
        with tempfile.TemporaryDirectory() as folder:
            in_process.write(self._border, Path(folder))
            solution = outcome.confirm(found, Path(folder), self._setup)
        return Result(outcome.result_text(solution, self._setup, self._stand_file, found))


def _seconds(value: Any) -> float:
    try:
        seconds = float(value)
    except (TypeError, ValueError):
        seconds = math.nan
    if not 0.0 <= seconds <= _LONGEST_S or isinstance(value, str):
        raise UsageError(f"seconds: {quoted(value)} is not a number from 0 to {_LONGEST_S:g}")
    return seconds


def _number(name: str, value: Any, kind: type[Number]) -> Number | None:
    """None: not given."""
    try:
        return None if value is None else kind(value)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"{name}: {quoted(value)} is not a number") from None


def _lines(keys: Mapping[str, Any]) -> Iterator[str]:
    """Of a scenario. A list repeats the line where its values are texts of several words, as those of faults are."""
    for key, value in keys.items():
        if isinstance(value, (list, tuple)) and not any(isinstance(one, (str, list, tuple)) for one in value):
            yield f"{key} = {' '.join(map(_word, value))}"
            continue
        for one in value if isinstance(value, (list, tuple)) else [value]:
            yield f"{key} = {' '.join(map(_word, one)) if isinstance(one, (list, tuple)) else _word(one)}"


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return repr(float(value)) if isinstance(value, float) else str(value)
