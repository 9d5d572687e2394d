"""The simulated world in C (host/world/border.h) as an object: keys in, time on, frames, samples and report out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple, TypeAlias

import msgspec
import numpy as np

from tumble.documents import base
from tumble.documents.bench import Bench
from tumble.errors import BenchFault, set_up

try:
    from _tumble_world import ffi, lib
except ImportError:
    _IS_BUILT = False
else:
    _IS_BUILT = True

Event: TypeAlias = "dict[str, Any]"

FOREVER_US = 2**64 - 1
_MOST_ID, _MOST_BYTES = 0x7FF, 8
FRAME, CHANGE, AVERAGED, QUESTION, ENDED = 1, 2, 4, 8, 16  # bits of what has happened
_NO_MEMORY = 32
OPERATORS = ("by-itself", "on-confirm", "never", "asked")  # who acts when the firmware waits for a person
ENDS = ("running", "done", "fault", "interrupted", "too long", "left")
ANSWERS = ("done", "abort", "repeat position", "repeat mounting", "leave")
SENDERS = ("navcomp", "drive", "block", "guest")

FRAMES = np.dtype([("time_us", "u8"), ("id", "u2"), ("length", "u1"), ("sender", "u1"), ("data", "V8")], align=True)
_SAMPLES = np.dtype(
    [
        ("block_ms", "u8"),
        ("counts", "i4", 3),
        ("ordinal", "u4"),
        ("counter", "u2"),
        ("timestamp_ms", "u2"),
        ("index", "u1"),
        ("temperature_half_c", "i1"),
    ],
    align=True,
)


class Refused(Exception):
    """What the world says of a key, a frame or an answer that it does not take; `line`: of the scenario, 0: none."""

    line = 0

    def where(self, file: str) -> str:
        """The sentence, behind the place in a file."""
        return f"{file}:{self.line}: {self}" if self.line else f"{file}: {self}"


def require_built() -> None:
    """Raise BenchFault where the extension is not built."""
    if not _IS_BUILT:
        raise BenchFault(f"the simulated world is not built: {set_up('world') or 'pip install'} builds it")


def text(of: Any) -> str:
    """A text of the world's."""
    return str(ffi.string(of).decode("utf-8", "backslashreplace"))


class Key(NamedTuple):
    """A key of a scenario: so many `values`, each in `range`; `about`: unit and meaning."""

    name: str
    values: int
    range: str
    about: str


def require_good(sentence: Any, line: int = 0) -> None:
    """Raise Refused with a sentence of the world's, if there is one."""
    if sentence != ffi.NULL:
        refused = Refused(text(sentence))
        refused.line = line
        raise refused


def keys() -> dict[str, Key]:
    """All keys that come at most once, by name."""
    require_built()
    found: dict[str, Key] = {}
    row = 0
    while (key := lib.world_key(row)).name != ffi.NULL:
        if name := text(key.name):
            found[name] = Key(name, key.count, text(key.range), text(key.about))
        row += 1
    return found


_CHOICE = "one of "
_SCENARIO = """Scenario files: one `key = value` a line, # comments.

{keys}

Lines that may repeat:
mounting = NUMBER  TILT_DEG SINE COSINE  M11 M12 M13 M21 M22 M23 M31 M32 M33  [BOLTING]
position = MOUNTING NUMBER fit|check  ANGLE_DEG SINE COSINE
drive.lacks = INDEX ...
profile.receive_pdo = NUMBER COB_ID INDEX:SUBINDEX:BITS ...
profile.transmit_pdo = NUMBER COB_ID INHIBIT_100US EVENT_MS INDEX:SUBINDEX:BITS ...
profile.write = INDEX SUBINDEX SIZE VALUE
        INDEX is hexadecimal: 0x6040; 6040 in a PDO. Other numbers are decimal or 0x.
fault = KIND at=MOUNTING.POSITION [phase=mount|home|move|settle|average] | time=SECONDS
        [delay=S] [duration=S] [times=N] [channels=xyz] [value=X] [count=N] [id=N] [mask=N]
        [probability=P]

Kinds of faults:
{faults}
"""


def scenario_help() -> str:
    """What a scenario may say, for people."""
    told = [
        f"{key.name:34} {key.range}{'' if key.range.startswith(_CHOICE) else f'; {key.about}'}"
        for key in keys().values()
    ]
    about = ffi.new("const char **")
    faults: list[str] = []
    while (kind := lib.world_fault_kind(len(faults), about)) != ffi.NULL:
        faults.append(f"{text(kind):20} {text(about[0])}")
    return _SCENARIO.format(keys="\n".join(told), faults="\n".join(faults))


class Border:
    """A world: `lines` of a scenario, then power; without `records` it keeps neither frames nor samples. Raises
    Refused; BenchFault where the extension is not built."""

    def __init__(
        self,
        seed: int,
        lines: Iterable[str],
        gains: bytes | None,
        operator: str = OPERATORS[0],
        memory: bool = False,
        records: bool = True,
    ):
        self._set(lines, gains)
        if not records:
            lib.world_record_nothing(self._world)
        require_good(lib.world_power_on(self._world, seed, OPERATORS.index(operator), memory))

    def _set(self, lines: Iterable[str], gains: bytes | None) -> None:
        require_built()
        self._world = ffi.gc(lib.world_new(), lib.world_free)
        if self._world == ffi.NULL:
            raise MemoryError
        for number, line in enumerate(lines, start=1):
            require_good(
                lib.world_set(self._world, line.encode("utf-8", "surrogateescape").replace(b"\0", b"?")), number
            )
        if gains is not None:
            require_good(lib.world_set_gains(self._world, gains, len(gains)))

    @property
    def now_us(self) -> int:
        """Virtual time since power-on."""
        return int(lib.world_now_us(self._world))

    def advance(self, until_us: int, stop_at: int) -> int:
        """Let time pass, as world_advance does. Returns what has happened. Raises MemoryError."""
        happened = int(lib.world_advance(self._world, until_us, stop_at))
        if happened == _NO_MEMORY:
            raise MemoryError("what goes over the bus cannot be recorded any more")
        return happened

    def end(self, how: str) -> None:
        """Stop the table and give up; time must pass until it rests."""
        lib.world_end(self._world, ENDS.index(how))

    def send(self, identifier: int, data: bytes) -> None:
        """Put a frame on the bus. Raises Refused."""
        if not 0 <= identifier <= _MOST_ID or len(data) > _MOST_BYTES:
            raise Refused("no classic data frame with an 11-bit identifier")
        require_good(lib.world_send(self._world, identifier, len(data), data))

    def turn_table(self, angle_deg: float, speed_deg_s: float) -> None:
        """Turn the table, where no simulated drive does. Raises Refused."""
        require_good(lib.world_turn_table(self._world, angle_deg, speed_deg_s))

    def answer(self, answer: str) -> None:
        """Answer the open question: one of ANSWERS, a repetition with its number behind it. Raises Refused."""
        first, _, number = answer.rpartition(" ") if answer.startswith("repeat ") else (answer, "", "0")
        if first not in ANSWERS or not (number.isascii() and number.isdigit() and int(number) <= 255):
            raise Refused("an answer is done, abort, leave, repeat position INDEX or repeat mounting NUMBER")
        require_good(lib.world_answer(self._world, ANSWERS.index(first), int(number)))

    def set_power(self, on: bool) -> None:
        """The navigation computer's. Raises Refused."""
        require_good(lib.world_set_power(self._world, on))

    def start(self) -> None:
        """Command a calibration. Raises Refused."""
        require_good(lib.world_start(self._world))

    @property
    def memory(self) -> bytes:
        """A copy of what outlives power; empty where the computer has none."""
        size = ffi.new("size_t *")
        first = lib.world_memory(self._world, size)
        return bytes(ffi.buffer(first, size[0])) if size[0] else b""

    def frames(self, first: int = 0) -> Any:
        """Frames since power-on, from number `first` on: a record array of time_us, id, length, sender (of SENDERS),
        data."""
        return self._array(lib.world_frames, FRAMES, first)

    def samples(self) -> Any:
        """Those of the means that were kept, in the order of the schedule."""
        return self._array(lib.world_samples, _SAMPLES)

    def _array(self, function: Any, kind: np.dtype[Any], first: int = 0) -> Any:
        size = ffi.new("size_t *")
        all_of_it = function(self._world, size)
        count = size[0] - first
        if count <= 0:
            return np.empty(0, kind)
        return np.frombuffer(ffi.buffer(all_of_it + first, count * kind.itemsize), kind).copy()

    @property
    def step_v(self) -> float:
        """Volts of a count."""
        return float(lib.world_step_v(self._world))

    def positions(self) -> list[tuple[int, int]]:
        """Mounting and number of each, in the order of the schedule."""
        found: list[tuple[int, int]] = []
        place = ffi.new("uint8_t[2]")
        while lib.world_position(self._world, len(found), place, place + 1):
            found.append((place[0], place[1]))
        return found

    def document(self) -> Bench:
        """What was found by now."""
        told = ffi.string(lib.world_document(self._world))
        return msgspec.json.decode(told, type=Bench, dec_hook=base.array_of)

    def told(self) -> dict[str, Any]:
        """The same as it is in JSON, which takes a third of the time."""
        told: dict[str, Any] = msgspec.json.decode(ffi.string(lib.world_document(self._world)))
        return told

    def event(self, happened: int) -> Event | None:
        """What a person at a terminal, or a page that shows the run, is told of CHANGE, AVERAGED or QUESTION; 0: of the
        angle while the table turns."""
        told = lib.world_event(self._world, happened)
        return None if told == ffi.NULL else msgspec.json.decode(ffi.string(told))
