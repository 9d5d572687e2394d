"""Runs of the fault campaign (docs/architecture.md): drawn from a seed, run (host/world/fault_campaign.h), described.

A run has an ordinary course, faults, losses of power, single frames of a stranger, and scenes of what belongs
together, as a fault alone or a frame alone seldom meets the moment at which it hurts.
"""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import count, takewhile
from typing import Any, TypeVar

from tumble.firmware_tables import STATES
from tumble.world.border import require_built, require_good, text

with contextlib.suppress(ImportError):  # which require_built tells of
    from _tumble_world import ffi, lib

_WORLD, _COURSE, _FAULTS, _FRAMES, _CUTS, _SCENES = range(6)  # streams of random numbers
_BURST = 150  # frames
_MOST_FAULTS = 4
_FOR_GOOD = 0.0
_WITHOUT_END = 2**32 - 1  # of a fault's count
_MICROSECOND = 1e-6
_SERVICE_KEY = 0x76726573
_PHASES = ("mount", "home", "move", "settle", "average")
_DRIVE_ONLY = ("sdo_drive", "set_point", "sdo_set_point")
_COEFFICIENTS = "K_xx K_xy K_xz K_yx K_yy K_yz K_zx K_zy K_zz U0_x U0_y U0_z".split()
_ENDS = ("IDLE", "DONE", "FAULT", "ABORT")

Frame = tuple[int, bytes]
Write = tuple[int, int, int, int]
One = TypeVar("One")


def _writes(table: str) -> list[Write]:
    """Of INDEX:SUBINDEX:BYTES:VALUE, hexadecimal."""
    return [tuple(int(one, 16) for one in row.split(":")) for row in table.split()]  # type: ignore[misc]


# What the stop, the watch over the drive and the way of its reports depend on.
_STOP_WRITES = _writes("""
    1800:1:4:80000202 1800:1:4:80000202 1800:1:4:80000000 1800:1:4:80000000 1800:1:4:80000202 1800:1:4:80000202
    1800:1:4:80000202 1800:2:1:F0 1800:2:1:0 1800:3:2:FFFF 1A00:0:1:0 1400:1:4:80000182 1600:0:1:0 1016:1:4:0
    1016:1:4:21388 1016:2:4:0 1017:0:2:0 1017:0:2:EA60 1029:1:1:0 1029:1:1:2 1802:1:4:80000181 1802:1:4:202
    1804:1:4:800006C1 1804:1:4:202 2006:1:4:76726573 2006:1:4:76726573 2006:1:4:73657276 2006:1:4:0
""")
# Other objects of the navigation computer that can be written, most with a value that might do harm.
_OTHER_WRITES = _writes("""
    1802:1:4:80000181 1803:1:4:80000681 1A02:0:1:0 1801:1:4:202 1401:1:4:182 1003:0:1:0 1010:1:4:65766173
    1011:1:4:64616F6C 2040:1:2:F 2040:2:4:57E40 2040:4:2:627 2040:5:4:AFC80 2050:1:4:1 2050:2:1:2 2050:3:2:0
    2050:4:1:FF 2121:2:2:1 2121:2:2:0 2122:2:4:1 2122:6:1:1 2122:3:4:3C 2123:1:4:41200000 2123:2:1:3 2123:2:1:0
    2124:1:4:3F800000 2125:A:4:3F800000 2126:4:4:3F800000 2150:1:1:11 2160:1:1:3 2002:1:1:2 2001:0:1:1 2152:1:4:A
""")
_DRIVE_COMMANDS = _writes("""
    6040:0:2:F 6040:0:2:1F 6040:0:2:3F 6040:0:2:2 6040:0:2:0 6040:0:2:80 607A:0:4:15F90 607A:0:4:7A120
    607A:0:4:15F900 6040:0:2:10F
""")
_DRIVE_SETTINGS = _writes("""
    6060:0:1:6 6098:0:1:25 6085:0:4:64 607C:0:4:1388 1016:1:4:0 1017:0:2:0 1400:1:4:80000202 605A:0:2:0
    1800:1:4:80000182 6007:0:2:0
""")
# Those that the navigation computer reads back before a motion.
_READ_BACK = _writes("""
    6081:0:4:40B28 6081:0:4:40B28 6081:0:4:40B28 6081:0:4:0 6081:0:4:3E8 6083:0:4:7D0 607D:1:4:80000000
    607D:2:4:7FFFFFFF 607A:0:4:7A120
""")
_LIMITS_OFF = _writes("607D:1:4:80000001 607D:2:4:7FFFFFFF")
_COMMANDS = """START ABORT ABORT HOME_AXIS TURN_AXIS TURN_AXIS RESUME CLEAR_FAULT REPEAT_POSITION REPEAT_MOUNTING
    CONFIRM_MOUNTING ACCEPT DISCARD ROLLBACK""".split()
_IDENTIFIERS = [int(one, 16) for one in "0 82 83 181 182 182 202 202 582 602 581 601 683 683 693 701 702 703".split()]


@lru_cache
def _names_of(enumeration: str, prefix: str) -> list[str]:
    """Of an enumeration of fault_campaign.h, by number."""
    return [name.removeprefix(prefix).lower() for _, name in sorted(ffi.typeof(enumeration).elements.items())]


@lru_cache
def _names(of: str) -> list[str]:
    """Of a closed list of the firmware or the simulation, by number."""
    number = getattr(lib, f"CAMPAIGN_NAMES_OF_{of}")
    rows = (lib.campaign_name(number, row) for row in count())
    return [text(name) for name in takewhile(lambda name: name != ffi.NULL, rows)]


def _kinds() -> list[str]:
    return _names_of("campaign_event_kind_t", "CAMPAIGN_EVENT_")


def _commands() -> list[str]:
    return [name.removeprefix("TUMBLE_COMMAND_") for name in _names("COMMANDS")]


class _Stream:
    """The random numbers of a part of a plan."""

    def __init__(self, seed: int, number: int):
        self._stream = ffi.new("campaign_stream_t *")
        lib.campaign_stream_open(self._stream, seed, number)

    def pick(self, count: int) -> int:
        """A whole number from 0 to count - 1."""
        return int((lib.campaign_stream_next(self._stream) >> 32) * count >> 32)

    def draw(self, low: float, high: float) -> float:
        """Uniform."""
        unit: float = ((lib.campaign_stream_next(self._stream) >> 12) + 0.5) * 2.0**-52
        return low + (high - low) * unit

    def chance(self, probability: float) -> bool:
        """True with this probability."""
        return self.draw(0.0, 1.0) < probability

    def one_of(self, several: Sequence[One]) -> One:
        """Each as likely."""
        return several[self.pick(len(several))]

    def sign(self) -> float:
        """1 or -1."""
        return 1.0 if self.chance(0.5) else -1.0

    def bytes(self, count: int) -> bytearray:
        """Any."""
        return bytearray(lib.campaign_stream_next(self._stream) & 0xFF for _ in range(count))


@dataclass
class _Fault:
    """As a line of a scenario has it. `place`: mounting, position and phase; None: at its time."""

    kind: str
    time_s: float
    duration_s: float
    place: tuple[int, int, str] | None = None
    delay_s: float = 0.0
    channels: int = 1
    value: float = 0.0
    count: int = _WITHOUT_END
    id: int = 0
    mask: int = 0x7FF
    probability: float = 1.0

    def line(self) -> str:
        """Of a scenario."""
        when = f"time={self.time_s!r}"
        if self.place is not None:
            when = "at={}.{} phase={} ".format(*self.place) + f"delay={self.delay_s!r}"
        channels = "".join(name for bit, name in enumerate("xyz") if self.channels >> bit & 1)
        return (
            f"fault = {self.kind} {when} duration={self.duration_s!r} channels={channels} value={self.value!r}"
            f" count={self.count} id={self.id} mask={self.mask} probability={self.probability!r}"
        )

    def description(self) -> str:
        """For people."""
        when = f"{self.time_s:10.6f} s  "
        if self.place is not None:
            when = "at {}.{} {}, plus ".format(*self.place) + f"{self.delay_s:.3f} s: "
        many = -1 if self.count == _WITHOUT_END else self.count
        frames = ""
        if self.kind.startswith("frame_"):
            frames = f"id {self.id:03X}h, mask {self.mask:03X}h, probability {self.probability:.3f}, "
        last = f"for {self.duration_s:.3f} s" if self.duration_s > 0.0 else "for good"
        return f"{when}fault {self.kind}, value {self.value:g}, count {many}, channels {self.channels}, {frames}{last}"


@dataclass
class _Event:
    """As campaign_event_t has it, by names: its kind, its states, its command. `frame`: identifier and data."""

    kind: str
    number: int
    at_us: int
    states: tuple[str, ...] = ()
    writing: bool = False
    delay_us: int = 0
    command: str = "NONE"
    argument: int = 0
    angle_deg: float = 0.0
    relative: bool = False
    by_host: bool = False
    frame: Frame = (0, b"")
    count: int = 0
    counts: int = 0
    off_us: int = 0
    fault: _Fault | None = None

    def as_c(self) -> dict[str, Any]:
        """The members of campaign_event_t."""
        own = {name: value for name, value in vars(self).items() if name not in ("frame", "fault")}
        identifier, data = self.frame
        return {
            **own,
            "kind": _kinds().index(self.kind),
            "states": sum(1 << list(STATES).index(state) for state in self.states),
            "command": _commands().index(self.command),
            "id": identifier,
            "length": len(data),
            "data": list(data),
        }

    def description(self) -> str:
        """For people."""
        if self.fault is not None:
            return self.fault.description()
        return f"{self.at_us * _MICROSECOND:10.6f} s  {self._condition()}{self._what()}"

    def _condition(self) -> str:
        if not self.states and not self.writing:
            return ""
        states = "".join(f", in {state}" for state in self.states)
        written = ", while the memory is written" if self.writing else ""
        return f"or later{states}{written}, plus {self.delay_us * _MICROSECOND:.6f} s: "

    def _what(self) -> str:
        angle = f"{self.angle_deg:.3f} deg"
        if self.kind == "command":
            to = f" to {angle}" if self.command == "TURN_AXIS" else f" {self.argument}" if self.argument else ""
            return f"{self.command}{to}, {'by the board' if self.by_host else 'over CAN'}"
        if self.kind == "power_cut":
            return f"power off for {self.off_us * _MICROSECOND:.6f} s, {self.count} bits flipped"
        if self.kind in ("set_point", "sdo_set_point"):
            where = "202h" if self.kind == "set_point" else "602h"
            return f"forged set-point {where}: {angle}{' off the target' if self.relative else ''}"
        if self.kind in ("position", "near_position"):
            apart = "" if self.kind == "position" else ", 0.3 ms apart"
            return f"{self.count} forged positions 182h, each {angle} further{apart}"
        if self.kind in ("sample", "spoilt_sample"):
            return f"forged sample, {self.counts} counts off, checksum {'good' if self.kind == 'sample' else 'wrong'}"
        identifier, data = self.frame
        told = f"{self.kind} {identifier:03X}#{data.hex().upper()}"
        if identifier & 0x780 == 0x600 and len(data) == 8 and data[0] & 0xE0 == 0x20:
            told += f" (write {data[2::-1][:2].hex().upper()}h:{data[3]} = {data[:3:-1].hex().upper()}h)"
        return told


# Frames that a stranger, or a node gone mad, puts on the bus.


def _write(node: int, write: Write) -> Frame:
    """An SDO write to a server."""
    index, subindex, size, value = write
    return 0x600 + node, struct.pack("<BHBI", 0x23 | (4 - size) << 2, index, subindex, value)


def _navcomp_frame(stream: _Stream) -> Frame:
    if stream.chance(0.35):
        return _write(1, stream.one_of(_STOP_WRITES))
    if stream.chance(0.7):
        identifier, written = _write(1, stream.one_of(_OTHER_WRITES))
        return 0x401 if stream.chance(0.2) else identifier, written  # the other server
    data = stream.bytes(8)  # segments, aborts, reads of anything
    data[0] = stream.pick(8) << 5
    data[2] = 0x10 + stream.pick(0x12)
    return 0x601, bytes(data)


def _drive_frame(stream: _Stream) -> Frame:
    if stream.chance(0.4):
        data = stream.bytes(8)
        data[0], data[2] = 0x40, 0x60  # a read, which may come between a transfer of the node's
        return 0x602, bytes(data)
    if stream.chance(0.3):
        return _write(2, stream.one_of(_READ_BACK))
    return _write(2, stream.one_of(_DRIVE_COMMANDS if stream.chance(0.7) else _DRIVE_SETTINGS))


def _answer(stream: _Stream) -> Frame:
    identifier, data = 0x582 if stream.chance(0.9) else 0x583, stream.bytes(8)
    data[0] = stream.one_of((0x60, 0x43, 0x4B, 0x4F, 0x80, 0x20, 0x00))
    index = stream.one_of((0x607A, 0x6040, 0x1016, 0x1017, 0x1400, 0x1600, 0x6081, 0x6060))
    data[1:3] = index.to_bytes(2, "little")
    data[3] = stream.pick(3)
    return identifier, bytes(data)


def _any_frame(stream: _Stream) -> Frame:
    length = stream.pick(9)
    return stream.pick(0x800), bytes(stream.bytes(length))


_FRAMES_OF = {  # by kind; the others' are made when they are sent
    "sdo_navcomp": _navcomp_frame,
    "sdo_drive": _drive_frame,
    "sdo_answer": _answer,
    "nmt": lambda one: (0, bytes([one.one_of((0x01, 0x02, 0x80, 0x81, 0x82, 0x55)), one.pick(5)])),
    "heartbeat": lambda one: (0x701 + one.pick(4), bytes([one.one_of((0x00, 0x04, 0x05, 0x7F, 0x85, 0x33))])),
    "emergency": lambda one: (0x081 + one.pick(3), bytes(one.bytes(8))),
    "sync": lambda one: (0x080, bytes(one.bytes(one.pick(2)))),
    "lss": lambda one: (0x7E5 if one.chance(0.5) else 0x7E4, bytes(one.bytes(8))),
    "any_frame": _any_frame,
}


def _draw_set_point(stream: _Stream, event: _Event) -> None:
    """Some within the window in which the drive is at its target."""
    event.relative = stream.chance(0.3)
    event.angle_deg = stream.draw(-0.2, 0.2) if event.relative else stream.draw(-1500.0, 1500.0)


def _draw_near_positions(stream: _Stream, event: _Event) -> None:
    """Eight of 45 deg are a turn."""
    sign = stream.sign()
    event.count = 7 + stream.pick(4)
    event.angle_deg = sign * (360.0 / event.count if stream.chance(0.5) else stream.draw(30.0, 45.0))


def _draw_content(stream: _Stream, event: _Event) -> None:
    """Of the kinds whose frame is made when it is sent, only what it is made with."""
    if event.kind in ("set_point", "sdo_set_point"):
        _draw_set_point(stream, event)
    elif event.kind == "near_position":
        _draw_near_positions(stream, event)
    elif event.kind == "position":
        event.angle_deg = stream.draw(-360.0, 360.0)
        event.count = 1 + stream.pick(4)
    elif event.kind in ("sample", "spoilt_sample"):
        event.counts = int(stream.draw(-2e6, 2e6))
    else:
        event.frame = _FRAMES_OF[event.kind](stream)


class _Plan:
    """The whole of it: keys of the world, what else campaign_plan_t says, and events in the order of their times."""

    def __init__(self, seed: int):
        self._seed = seed
        self.events: list[_Event] = []
        self._draw_world(_Stream(seed, _WORLD))
        self._draw_course(_Stream(seed, _COURSE))
        self._draw_faults(_Stream(seed, _FAULTS))
        self._draw_cuts(_Stream(seed, _CUTS))
        self._draw_scene(_Stream(seed, _SCENES))
        self._draw_frames(_Stream(seed, _FRAMES))
        self.events.sort(key=lambda event: (event.at_us, event.number))

    def lines(self, events: list[_Event]) -> list[str]:
        """The scenario, with the faults among these events."""
        keys = (f"{key} = {value}" for key, value in self.keys.items())
        return [*keys, *(event.fault.line() for event in events if event.fault is not None)]

    def description(self) -> str:
        """The world, for people."""
        keys, told = self.keys, self.told
        wraps = f"wraps at {keys['drive.wrap_counts']}" if keys["drive.wrap_counts"] else "does not wrap"
        stale = "stale" if keys["drive.latches_stale_target"] == "yes" else "new"
        return (
            f"drive: {keys['motion.speed_deg_s']:g} deg/s, sign {keys['drive.sign']}, {wraps}, takes the {stale}"
            f" target, stops by {keys['profile.stop'].replace('_', ' ')}; memory: erases in {told['erase_us']} us,"
            f" {'holds a set' if told['has_set'] else 'blank'}; attendant: mends {told['mends']}"
            f"{', resumes' if told['resumes'] else ''}"
        )

    @property
    def _lasts_s(self) -> float:
        return _MICROSECOND * float(self.told["lasts_us"])

    def _add(self, kind: str, at_s: float, **others: Any) -> _Event:
        event = _Event(kind, len(self.events), int(at_s * 1e6) if at_s > 0.0 else 0, **others)
        if len(self.events) < lib.CAMPAIGN_MOST_EVENTS:
            self.events.append(event)
        return event

    def _command(self, at_s: float, command: str, **others: Any) -> _Event:
        return self._add("command", at_s, command=command, **others)

    def _fault(self, kind: str, at_s: float, duration_s: float) -> _Fault:
        """That begins at a time."""
        fault = _Fault(kind, at_s, duration_s)
        self._add("fault", at_s, fault=fault)
        return fault

    def _draw_world(self, stream: _Stream) -> None:
        self.keys: dict[str, Any] = {
            "drive.wrap_counts": stream.one_of((0, 0, 360000, 360000, 720000)),
            "drive.sign": 1 if stream.chance(0.5) else -1,
            "drive.latches_stale_target": "yes" if stream.chance(0.5) else "no",
            "drive.reaction_us": int(stream.draw(200.0, 20000.0)),
            "drive.report_us": int(stream.draw(5000.0, 50000.0)),
            "motion.speed_deg_s": (speed := stream.one_of((90.0, 90.0, 60.0, 30.0))),
            "motion.settling_s": 0.1,
            "profile.homing_fast_deg_s": min(speed, 45.0),
        }
        velocity = 30.0 if speed >= 60.0 and stream.chance(0.5) else 0.0
        self.keys |= {
            "profile.stop": "halt" if stream.chance(0.3) else "quick_stop",
            "stand.remount_rad": 4e-5,
            "block.sample_period_us": 10000 if stream.chance(0.5) else 20000,
            "block.noise_v": 2e-4,
            "procedure.samples": 24,
            "procedure.estimator": stream.one_of(("averaged", "refined", "least_squares")),
            "procedure.settle_ms": 100,
            "procedure.warm_up_samples": 5,
            "procedure.mounting_timeout_ms": 20000,
            "procedure.warm_up_timeout_ms": 20000,
            "procedure.retries": stream.pick(3),
            "keeper.serial": "TB-0001",
            "keeper.first": "yes" if stream.chance(0.7) else "no",  # else the first result is held
            "keeper.gravity_m_s2": 9.81,
        }
        self.told: dict[str, Any] = {
            "velocity_deg_s": velocity,
            "has_set": stream.chance(0.5),
            "utc_s": 1800000000 if stream.chance(0.7) else 0,
            "erase_us": int(stream.draw(1000.0, 80000.0)) if stream.chance(0.5) else 0,
            "program_us": int(stream.draw(20.0, 3000.0)) if stream.chance(0.5) else 0,
            "mount_s": stream.draw(0.3, 3.0),
            "mend_s": stream.draw(1.0, 10.0),
            "mends": stream.pick(4),
            "resumes": stream.chance(0.6),
            "errs": stream.chance(0.03),
            "lasts_us": int(stream.draw(80.0, 180.0) * 1e6),
        }
        self.keys |= {f"operator.{what}_s": -1 for what in ("mount", "incline", "turn", "mend")}
        self.keys |= {"operator.mends": 0, "firmware.starts": "no"}
        self.keys["limit.virtual_s"] = self._lasts_s + 1.0  # the plan ends it

    def _draw_course(self, stream: _Stream) -> None:
        """A run, perhaps another, and what people do besides."""
        commands = stream.pick(7) if stream.chance(0.5) else 0
        if stream.chance(0.85):
            self._command(stream.draw(0.2, 4.0), "START", by_host=True)
        if stream.chance(0.6):
            self._command(stream.draw(60.0, 120.0), "START")
        for _ in range(commands):
            at_s, command = stream.draw(0.0, self._lasts_s), stream.one_of(_COMMANDS)
            event = self._command(at_s, command)
            if command in ("REPEAT_MOUNTING", "CONFIRM_MOUNTING"):
                event.argument = 1 + stream.pick(2)
            event.by_host = stream.chance(0.3)
            if command == "REPEAT_POSITION":
                event.argument = stream.pick(20)
            elif command == "TURN_AXIS":
                event.angle_deg = stream.draw(-40.0, 410.0)

    def _draw_cuts(self, stream: _Stream) -> None:
        for _ in range(1 + stream.pick(3) if stream.chance(0.35) else 0):
            cut = self._add("power_cut", stream.draw(0.0, self._lasts_s))
            cut.off_us = int(1e6 * stream.draw(0.01, 8.0))
            cut.writing = stream.chance(0.5)
            cut.delay_us = int(stream.draw(0.0, 20000.0)) if stream.chance(0.5) else 0
            flips = 1 if stream.chance(0.5) else 1 + stream.pick(8)
            cut.count = flips if stream.chance(0.3) else 0

    def _draw_faults(self, stream: _Stream) -> None:
        for _ in range(1 + stream.pick(_MOST_FAULTS) if stream.chance(0.7) else 0):
            at_s = stream.draw(0.0, self._lasts_s)
            short_s, long_s = stream.draw(0.01, 2.0), stream.draw(1.0, 30.0)
            duration_s = short_s if stream.chance(0.4) else long_s if stream.chance(0.7) else _FOR_GOOD
            fault = self._fault(stream.one_of(_names("FAULTS")), at_s, duration_s)
            (_draw_frame_fault if fault.kind.startswith("frame_") else _draw_value)(stream, fault)
            if stream.chance(0.4):
                fault.place = 1 + stream.pick(2), 1 + stream.pick(9), stream.one_of(_PHASES)
                fault.delay_s = stream.draw(0.0, 0.8)

    def _draw_frames(self, stream: _Stream) -> None:
        """By themselves. What commands or rewrites the drive itself excuses much, and so comes in few runs."""
        kind = stream.draw(0.0, 1.0)
        many = 0 if kind < 0.4 else 1 + stream.pick(16) if kind < 0.95 else _BURST
        spares_drive = stream.chance(0.85)
        from_s = stream.draw(0.0, 0.8e-6 * float(self.told["lasts_us"]))
        for_s = 5.0 if stream.chance(0.5) else self._lasts_s
        frames = _kinds()[_kinds().index("sdo_navcomp") :]
        for _ in range(many):
            frame = stream.one_of(frames)
            frame = "sdo_navcomp" if spares_drive and frame in _DRIVE_ONLY else frame
            _draw_content(stream, self._add(frame, from_s + stream.draw(0.0, for_s)))

    # Scenes.

    def _draw_scene(self, stream: _Stream) -> None:
        scenes = (
            *(self._void_the_stop, self._lose_the_mark, self._garble_the_count, self._garble_the_count),
            *(self._command_the_drive, *[self._spoil_a_motion] * 3, self._leave_a_proposal),
        )
        if stream.chance(0.4):
            stream.one_of(scenes)(stream)

    def _void_the_stop(self, stream: _Stream) -> None:
        """The table is set in motion by command, the way to stop it is tampered with, and then it is told to stop."""
        turns, at_s = stream.chance(0.4), stream.draw(2.0, 8.0)
        moves_s = at_s + 16.0 if turns else at_s
        writes_s = moves_s + stream.draw(-0.5, 2.5)
        self.events.clear()  # a run would be in the way
        self._command(at_s, "HOME_AXIS")
        if turns:
            self._command(moves_s, "TURN_AXIS", angle_deg=stream.draw(200.0, 399.0))
        elif stream.chance(0.8):
            self._fault("homing_endless", stream.draw(0.0, 2.0), _FOR_GOOD)
        if stream.chance(0.3):  # the stranger knows the key
            self._add("sdo_navcomp", writes_s - 0.1, frame=_write(1, (0x2006, 1, 4, _SERVICE_KEY)))
        for _ in range(1 + stream.pick(2)):
            self._add("sdo_navcomp", writes_s, frame=_write(1, stream.one_of(_STOP_WRITES)))
        abort = self._command(writes_s + stream.draw(0.05, 3.0), "ABORT")
        abort.by_host = stream.chance(0.3)

    def _lose_the_mark(self, stream: _Stream) -> None:
        kind, at_s = "homing_endless" if stream.chance(0.7) else "homing_fails", stream.draw(0.0, 1.0)
        self._fault(kind, at_s, _FOR_GOOD if stream.chance(0.7) else stream.draw(10.0, 60.0))
        if stream.chance(0.4):
            self._command(at_s + 1.0, "HOME_AXIS")

    def _garble_the_count(self, stream: _Stream) -> None:
        """Position reports that nobody sent, while nothing moves: each a part of a turn further than the one before."""
        states = (("WAIT_MOUNTING",), ("WAIT_MOUNTING",), ("DONE",), ("SETTLE", "AVERAGE"), ("MOVE",))
        event = self._add("position", stream.draw(10.0, 60.0))
        event.states = stream.one_of(states)
        event.delay_us = int(stream.draw(5000.0, 250000.0))
        event.angle_deg = stream.one_of((120.0, -120.0, 120.0, -120.0, 90.0, -90.0, 170.0, 240.0))
        event.count = 1 + stream.pick(3)
        if stream.chance(0.4):
            event.kind = "near_position"
            _draw_near_positions(stream, event)
        self.told["errs"] = False
        if event.states == ("DONE",):
            turn = self._command(_MICROSECOND * event.at_us, "TURN_AXIS", states=event.states)
            turn.delay_us = event.delay_us + int(stream.draw(1e5, 2e6))
            turn.angle_deg = stream.draw(-30.0, 400.0)

    def _lead_away(self, stream: _Stream, at_s: float) -> None:
        """The limits first, then set-points, each less than half a turn off: by the shorter way of a drive that
        wraps."""
        sign, many = stream.sign(), 1 + stream.pick(5)
        for before_s, limit in zip((0.1, 0.05), _LIMITS_OFF):
            self._add("sdo_drive", at_s - before_s, frame=_write(2, limit))
        for number in range(many):
            event = self._add("sdo_set_point", at_s + 0.8 * number)
            _draw_set_point(stream, event)
            if number > 0:
                event.relative = True
                event.angle_deg = sign * stream.draw(100.0, 175.0)

    def _spoil_a_motion(self, stream: _Stream) -> None:
        """The table turns by command, alone on the stand, and something is wrong with what moves it or tells where it
        is."""
        at_s, homes = stream.draw(2.0, 8.0), stream.chance(0.4)
        moves_s = at_s + (0.0 if homes else 16.0)
        spoils_s = moves_s + stream.draw(-0.5, 2.5)
        what = stream.pick(10)
        self.events.clear()  # a run would be in the way
        self._command(at_s, "HOME_AXIS")
        if not homes:
            angle_deg = stream.draw(-30.0, 400.0) if stream.chance(0.5) else 400.0
            self._command(moves_s, "TURN_AXIS", angle_deg=angle_deg)
        if homes and stream.chance(0.5):
            self._fault("homing_endless", at_s - 1.0, _FOR_GOOD)
        if what < 4:
            kind = ("runaway", "runaway", "frozen_position", "position_scale")[what]
            _draw_value(stream, self._fault(kind, spoils_s, _FOR_GOOD))
        elif what < 6:
            self.keys["motion.speed_deg_s"] = 90.0  # which makes such steps plausible
            self.told["velocity_deg_s"] = 0.0
            _draw_near_positions(stream, self._add("near_position", spoils_s))
            self._command(moves_s + 12.0, "TURN_AXIS", angle_deg=395.0)
        elif what < 8:
            self._lead_away(stream, spoils_s)
        else:
            self.told["velocity_deg_s"] = 0.5 * self.keys["motion.speed_deg_s"]
            self._add("sdo_drive", spoils_s, frame=_write(2, stream.one_of(_READ_BACK)))
            self._command(moves_s + 30.0, "TURN_AXIS", angle_deg=185.0)
            self._command(moves_s + 50.0, "TURN_AXIS", angle_deg=-25.0)

    def _leave_a_proposal(self, stream: _Stream) -> None:
        """A result waits for its operator, and power is lost."""
        cut = self._add("power_cut", 10.0, states=("DONE",))
        cut.off_us = int(stream.draw(1e4, 8e6))
        cut.delay_us = int(stream.draw(1e3, 15e6))
        cut.count = 1 if stream.chance(0.5) else 0
        self.told["has_set"], self.keys["keeper.first"] = False, "no"

    def _command_the_drive(self, stream: _Stream) -> None:
        kind = "set_point" if stream.chance(0.5) else "sdo_set_point"
        event = self._add(kind, stream.draw(1.0, self._lasts_s))
        _draw_set_point(stream, event)
        if stream.chance(0.5):
            event.states = ("IDLE",) if stream.chance(0.5) else ("WAIT_MOUNTING",)


def _draw_frame_fault(stream: _Stream, fault: _Fault) -> None:
    fault.id = stream.one_of(_IDENTIFIERS)
    fault.mask = 0x780 if stream.chance(0.2) else 0 if stream.chance(0.1) else 0x7FF
    fault.count = 1 + stream.pick(30) if stream.chance(0.7) else _WITHOUT_END
    fault.probability = stream.draw(0.01, 0.7) if stream.chance(0.5) else 1.0
    fault.value = stream.draw(0.001, 1.0)  # of a delay, s


# The value of a fault, where it means anything: as likely small as large. Of a sign and a size within 1.
_VALUES: dict[str, Callable[[_Stream, float, float], float]] = {
    "drive_fault": lambda stream, sign, size: float(0x3210),
    "never_reached": lambda stream, sign, size: 0.2 + 20.0 * size,
    "runaway": lambda stream, sign, size: 0.0 if stream.chance(0.5) else 720.0 * size * size,
    "position_scale": lambda stream, sign, size: stream.one_of((0.1, 0.25, 0.5, 0.9, 1.1, 2.0, 4.0, 10.0)),
    "slip": lambda stream, sign, size: sign * 20.0 * size * size,
    "noisy": lambda stream, sign, size: 2e-4 + 0.02 * size * size,
    "step": lambda stream, sign, size: sign * 0.2 * size * size * size,
    "status": lambda stream, sign, size: float(1 << stream.pick(4)),
    "warm": lambda stream, sign, size: sign * 20.0 * size,
}


def _draw_value(stream: _Stream, fault: _Fault) -> None:
    sign, size = stream.sign(), stream.draw(0.0, 1.0)
    fault.channels = 1 + stream.pick(7)
    if fault.kind in _VALUES:
        fault.value = _VALUES[fault.kind](stream, sign, size)
    if fault.kind == "slip":
        fault.count = stream.pick(2)
    elif fault.kind == "swapped":
        fault.channels = stream.one_of((3, 5, 6))
    elif fault.kind not in _VALUES:
        fault.count = 1 + stream.pick(40) if stream.chance(0.7) else _WITHOUT_END


_BROKEN = {  # what a person reads
    "rest": "the table still turns 6 s after the end",
    "stays": "the table at rest moves without a command",
    "cable": "the table goes beyond the cable's limits",
    "homing": "homing goes farther than the cable's span and a turn",
    "speed": "the table turns for 1 s faster than it was told to",
    "foreign": "a stranger's motion is not stopped within 1 s",
    "reason": "FAULT or ABORT without a reason",
    "finite": "a readable object is not a finite number",
    "truth": "a set that became active by itself is off by more than 6 u",
    "lost": "the active set is lost",
    "counter": "the calibration counter went back, and nothing was told",
    "proposal": "a proposal is lost that nobody has decided about",
    "decayed": "a record or mark with a flipped bit counts as valid",
    "mean": "a mean is not of its own samples, as many as are configured",
    "level": "the service level is open, or was not asked for, without its key",
    "run": "the run number does not count the runs",
    "bench": "the bench cannot go on",
}


def _violation(kind: str, found: Any) -> str:
    value, what = found.value, found.what
    if kind == "truth":
        told = f"{_COEFFICIENTS[what]} by {value:.1f} u"
    elif kind in ("level", "finite"):
        told = f"{what >> 8:04X}h:{what & 0xFF}"
    elif kind == "decayed":
        told = f"at {what}"
    elif kind == "proposal":
        told = f"{what:08X}"
    elif kind == "mean":
        told = f"of row {what} of the schedule, sample {value:.0f}"
    elif kind in ("run", "lost", "counter"):
        told = f"from {what} to {value:.0f}"
    else:
        told = f"{value:.1f} deg, in {list(STATES)[what]}"
    return f"{kind}: {_BROKEN[kind]}, {told}, at {found.at_us * _MICROSECOND:.6f} s"


class FaultCampaign:
    """Runs by seed; each gives numbers that add. Raises BenchFault where the extension is not built."""

    def __init__(self) -> None:
        require_built()
        self._found = ffi.new("campaign_found_t *")

    def run_seed(self, seed: int) -> dict[str, Any]:
        """The run of a seed, in the form of the document of many (schema tumble.hostile/1); `said`: what was
        violated, where something was."""
        plan = _Plan(seed)
        violated = self._execute(seed, plan, plan.events)
        found = self._found
        excuses, reasons = _names_of("campaign_excuse_t", "CAMPAIGN_EXCUSE_"), _names("REASONS")
        ends = {state: found.ends[list(STATES).index(state)] for state in _ENDS}
        return {
            "runs": 1,
            "violated": int(violated is not None),
            "violations": {kind: int(kind == violated) for kind in _BROKEN},
            "first": [],
            "faults": dict(zip(_names("FAULTS"), found.faults)),
            "events": dict(zip(_kinds(), found.events)),
            "flipped_bits": found.flipped_bits,
            "excuses": {name: found.excuses >> bit & 1 for bit, name in enumerate(excuses)},
            "ends": {f"TUMBLE_STATE_{state}": dict(zip(reasons, counted)) for state, counted in ends.items()},
            "homings": found.homings,
            "sets": {"committed": found.committed, "judged": found.judged, "held": found.held},
            "lives_with_commit": int(found.committed > 0),
            "table": {name: getattr(found, name) for name in ("at_rest", "lowest_deg", "highest_deg")},
            "virtual_us": found.virtual_us,
            "frames": found.frames,
            "steps": found.steps,
            **({} if violated is None else {"said": _violation(violated, found)}),
        }

    def shrunk(self, seed: int) -> dict[str, Any]:
        """The run of a seed that breaks a rule, repeated with the fewest events that are enough. Events go in halves,
        quarters and so on down to single ones."""
        plan = _Plan(seed)
        left, size = plan.events, (len(plan.events) + 1) // 2
        kind = self._execute(seed, plan, left)
        while True:
            before = len(left)
            left = self._fewer(seed, plan, kind, left, size)
            if size == 1 and len(left) == before:
                break
            size = max(1, (size + 1) // 2)
        kind = self._execute(seed, plan, left)
        assert kind is not None  # as with all events
        at_s, what = self._found.at_us * _MICROSECOND, _violation(kind, self._found)
        told = {"seed": seed, "kind": kind, "at_s": at_s, "what": what, "drawn": len(plan.events)}
        return {**told, "world": plan.description(), "events": [event.description() for event in left]}

    def _fewer(self, seed: int, plan: _Plan, kind: str | None, left: list[_Event], size: int) -> list[_Event]:
        """Without the pieces of this size that it takes no part of."""
        at = 0
        while at < len(left):
            fewer = left[:at] + left[at + size :]
            if self._execute(seed, plan, fewer) == kind:
                left = fewer
            else:
                at += size
        return left

    def _execute(self, seed: int, plan: _Plan, events: list[_Event]) -> str | None:
        """Returns what was violated."""
        world = ffi.gc(lib.world_new(), lib.world_free)
        if world == ffi.NULL:
            raise MemoryError
        for line in plan.lines(events):
            require_good(lib.world_set(world, line.encode()))
        own = ffi.new("campaign_event_t[]", [event.as_c() for event in events if event.fault is None])
        told = ffi.new("campaign_plan_t *", plan.told)
        require_good(lib.campaign_execute(world, seed, told, own, len(own), self._found))
        kind = _names_of("campaign_violation_t", "CAMPAIGN_VIOLATION_")[self._found.kind]
        return None if kind == "none" else kind
