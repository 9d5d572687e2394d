"""A navigation computer as a script sees it: commands, state, result, settings; the same over CAN and Modbus."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.client import link as links, names
from tumble.client.names import COMMAND, Objection, Reason, objections, verdict
from tumble.client.tables import SETTINGS
from tumble.errors import TumbleError, UsageError, quoted

SAVE, LOAD = 0x65766173, 0x64616F6C  # "save", "load"
_HINT = "; no run may be on, and the service level must be open: unlock() opens it"
_SHOWN_BY = {"Host: Calendar": "Keeper: Calendar", "Host: Inhibit": "Keeper: Inhibit left"}  # where they are read


@functools.cache
def kinds_of_settings() -> dict[str, tuple[str, str, bool]]:
    """Unit, type and service level (True if required) of each setting, by name."""
    parts = ((name.rpartition(": "), kind) for name, kind in links.read_map().kinds.items())
    return {f"{of}: {name}": (*kind, name in SETTINGS[of]) for (of, _, name), kind in parts if of in SETTINGS}


class Settings(Mapping[str, float | None]):
    """The settings of a node, by the names and in the units of docs/client.md. None where the node has no such setting
    or no value now.

    Writing raises Refused for a value out of range, in a state that does not allow it, and without the service level.
    An unknown name raises KeyError when read, as in any mapping, and UsageError when written.
    """

    def __init__(self, link: links.Link):
        self._link = link

    def __getitem__(self, name: str) -> float | None:
        if name not in self:
            raise KeyError(name)
        value = self._link.read(_SHOWN_BY.get(name, name))
        return None if value is None else links.number(value)

    def __setitem__(self, name: str, value: float) -> None:
        if name not in self:
            raise UsageError(f"there is no setting {quoted(name)}; see docs/client.md")
        links.require_number(f"writing {name}", value)
        whole = kinds_of_settings()[name][1] not in ("f32", "f64")
        if whole and not float(value).is_integer():
            raise links.Refused(f"writing {name}", links.OUT_OF_RANGE, "; it is a whole number")
        try:
            self._link.write(name, int(value) if whole else value)
        except links.Refused as refusal:
            if refusal.code == links.DEVICE_STATE and self.needs_unlock(name):
                raise links.Refused(f"writing {name}", refusal.code, _HINT) from None
            raise

    def __contains__(self, name: object) -> bool:
        return name in kinds_of_settings()

    def __iter__(self) -> Iterator[str]:
        return iter(kinds_of_settings())

    def __len__(self) -> int:
        return len(kinds_of_settings())

    @staticmethod
    def unit(name: str) -> str:
        """The unit of a setting, "" if it has none. Raises KeyError."""
        return kinds_of_settings()[name][0]

    @staticmethod
    def needs_unlock(name: str) -> bool:
        """Whether a setting can be written at service level only. Raises KeyError."""
        return kinds_of_settings()[name][2]

    def save(self) -> None:
        """Store the settings, so that they survive power-off (1010h). Needs `unlock()`. Raises Refused."""
        self._link.write("Store parameters: Save all parameters", SAVE)

    def restore(self) -> None:
        """Discard the stored settings (1011h): the board's own apply after the next power-on. Needs `unlock()`. Raises
        Refused."""
        self._link.write("Restore default parameters: Restore all default parameters", LOAD)


_K = tuple(f"{{}}K_{row}{column}" for row in "xyz" for column in "xyz")
_U0 = tuple(f"{{}}U0_{row}" for row in "xyz")
_MORE = "Keeper: More objections"
_NUMBERS = (
    "Run number",
    "Keeper: Verdict",
    "Keeper: Objections",
    "Keeper: Calibration counter",
    "Proposal: Record CRC",
    "Gravity check: Pass",
    "Gravity check: Largest deviation on fit positions",
    "Gravity check: Largest deviation on check positions",
    "Gravity check: Limit",
)
NAMES = (
    *(name.format("K: ") for name in _K),
    *(name.format("U0: ") for name in _U0),
    *(f"u_K: {name.format('u_')}" for name in _K),
    *(f"u_U0: {name.format('u_')}" for name in _U0),
    *_NUMBERS,
)


@dataclass(frozen=True, eq=False)
class Result:
    """The last finished run. `run`: its number. `K` (3, 3), V/g, and `U0` (3,), V, with standard uncertainties `u_K`
    and `u_U0`, None where the board declares no stand or has no memory. `passed`: the gravity check;
    `max_abs_delta_g_g`: its largest deviation; `limit_g`: its limit. `verdict`: COMMITTED, HELD, REPEATED, ACCEPTED,
    DISCARDED, ROLLED_BACK or FAILED, None on a board without memory. `objections`: why it is held. `proposal`: the
    number to accept it by, None where nothing is held. `calibration_counter`: of the active set."""

    run: int
    K: Floats
    U0: Floats
    u_K: Floats | None  # as everywhere
    u_U0: Floats | None
    passed: bool
    max_abs_delta_g_g: float
    limit_g: float
    verdict: str | None
    objections: tuple[Objection, ...]
    proposal: int | None
    calibration_counter: int | None


def read(link: links.Link) -> Result | None:
    """Read the result; None if there is none."""
    values = link.read_together(*NAMES)
    k, u0, u_k, u_u0 = values[:9], values[9:12], values[12:21], values[21:24]
    run, verdict_number, bits, counter, crc, passed, fit, check, limit = values[24:]
    if None in k or None in u0:
        return None
    said = verdict(_whole(verdict_number))
    return Result(
        int(links.number(run)),
        np.reshape(_floats(k), (3, 3)),
        _floats(u0),
        None if None in u_k else np.reshape(_floats(u_k), (3, 3)),
        None if None in u_u0 else _floats(u_u0),
        bool(passed),
        max(float(links.number(fit)), float(links.number(check))),
        float(links.number(limit)),
        said,
        all_objections(link, said, _whole(bits) or 0),
        _whole(crc) if said == "HELD" else None,
        _whole(counter),
    )


def all_objections(link: links.Link, verdict: str | None, bits: int) -> tuple[Objection, ...]:
    """The objections, including those from 16 on, which an older node does not have. `bits`: those below 16, of
    2120h:6."""
    more = None
    if verdict == "HELD" and link.has(_MORE):
        with suppress(links.Refused):
            more = link.read(_MORE)
    return objections(bits | (_whole(more) or 0) << 16)


def _floats(values: list[links.Value]) -> Floats:
    return np.array([links.number(value) for value in values], dtype=float)


def _whole(value: links.Value) -> int | None:
    return None if value is None else int(links.number(value))


SERVICE_KEY = 0x76726573  # "serv"
ENDED = ("FAULT", "ABORT")
AT_REST = ("IDLE", "DONE", "ABORT")  # whoever waits in one of these waits for a run that is still to begin
OTHER_RUN = ("START", "ABORT", "RESUME")  # RESUME after a loss of power, too
TO_TABLE = ("HOME_AXIS", "TURN_AXIS")
STAND_STATE = "Progress: Stand state"
STOP_NOT_CONFIRMED = 6  # of 2004h:10
STEP_S = 10.0  # within which a command that the node has taken shows
WORKING = "WORKING"
_STATUS = (
    "Run number",
    "State",
    "Reason",
    "Progress: Mounting number",
    "Progress: Position number",
    "Progress: Positions finished",
    "Progress: Position count",
    "Keeper: Verdict",
    "Keeper: Objections",
    "Keeper: Calibration counter",
)


_REFUSAL = ("Failure: Refused object", "Failure: Refused subindex", "Failure: Abort code", "Failure: Refused in")
_STOP_RUNG = "Failure: Stop rung"
_INCLINATION = ("Progress: Stays bolted", "Progress: Inclination")


@dataclass(frozen=True)
class Status:
    """The progress of a run. `run`: its number since power-on. `mounting`, `position`: as in the schedule. `finished`:
    how many positions of `count` are done. `verdict`: None on a board without memory."""

    run: int
    state: str
    reason: Reason
    mounting: int
    position: int
    finished: int
    count: int
    verdict: str | None
    objections: tuple[Objection, ...]
    calibration_counter: int


class Node:
    """A node on an open link. Leave it by `close()`, or use it as a context manager. A command returns the state after
    it.

    Use it from one thread at a time. Every member raises CommunicationError when nothing answers; its docstring names
    the other errors.
    """

    def __init__(self, link: links.Link):
        self.link = link
        self.settings = Settings(link)
        self._run: int | None = None  # the one that is waited for

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the link."""
        self.link.close()

    # Objects by name, as in docs/canopen.md and docs/modbus.md.

    def has(self, name: str) -> bool:
        """Whether the link offers an object of this name."""
        return self.link.has(name)

    def read(self, name: str) -> links.Value:
        """Read an object, such as "Progress: Actual angle"; None where the node has no value now. Raises Refused."""
        return self.link.read(name)

    def read_together(self, *wanted: str) -> list[links.Value]:
        """Read several objects, in this order: all of one run, over Modbus of one moment. Raises Refused."""
        return self.link.read_together(*wanted)

    def write(self, name: str, value: float) -> None:
        """Write an object that is not a command. Raises Refused."""
        self.link.write(name, value)

    # What it is at.

    @property
    def state(self) -> str:
        """The state, such as "IDLE", "WAIT_MOUNTING", "DONE"."""
        return names.state(self._whole("State"))

    @property
    def reason(self) -> Reason:
        """Why the run stopped, with its remedy."""
        return names.reason(self._whole("Reason"))

    @property
    def drive_refusal(self) -> str:
        """What the drive refuses, or did not do in time: object, abort code and step; "" for nothing. The current
        value, also between runs."""
        told = self.read_together(*_REFUSAL) if all(map(self.has, _REFUSAL)) else [None]
        return "" if None in told else names.drive_refusal(*map(int, map(links.number, told)))  # None: an older node

    @property
    def run(self) -> int:
        """The number of runs begun since power-on."""
        return self._whole("Run number")

    @property
    def mounting(self) -> int:
        """The number of the mounting that is asked for or being measured."""
        return self._whole("Progress: Mounting number")

    @property
    def inclination(self) -> float | None:
        """The angle to incline the stand to, degrees, for the mounting that is asked for or being measured, if the
        block stays bolted on; None if the block is to be mounted for it."""
        if not all(map(self.has, _INCLINATION)):  # an older node
            return None
        stays_bolted, degrees = self.read_together(*_INCLINATION)
        return float(links.number(degrees)) if stays_bolted else None

    @property
    def status(self) -> Status:
        """State, reason, progress and verdict, read together."""
        run, state, reason, *progress, judged, bits, counter = self.link.read_together(*_STATUS)
        mounting, position, finished, count = (int(links.number(one)) for one in progress)
        said = verdict(_whole(judged))
        return Status(
            int(links.number(run)),
            names.state(int(links.number(state))),
            names.reason(int(links.number(reason))),
            mounting,
            position,
            finished,
            count,
            said,
            all_objections(self.link, said, int(links.number(bits))),
            int(links.number(counter)),
        )

    def events(self, timeout: float | None = None) -> Iterator[Status]:
        """Yield the status now and after every change; end after `timeout` seconds, None: never. A change that is
        undone between two readings (20 a second over CAN, the polls of the gateway over Modbus) is not seen."""
        end, before = _end(timeout), None
        while True:
            now = self.status
            if now != before:
                yield now
                before = now
            if time.monotonic() >= end:
                return
            self.link.wait_for_news()

    def wait(self, until: str | tuple[str, ...] = "DONE", timeout: float | None = None) -> str:
        """Wait until the state is `until`, or one of several, and return it. Raises RunFailed on FAULT or ABORT that
        was not waited for, RunGone where the run ends otherwise, TimedOut, UsageError for an unknown state."""
        wanted = (until,) if isinstance(until, str) else until
        if not wanted:
            raise UsageError("no state is given to wait for")
        for name in wanted:
            if name not in names.STATE_NAMES:
                raise UsageError(f"there is no state {quoted(name)}; there are {', '.join(names.STATE_NAMES)}")
        end = _end(timeout)
        while (look := self._look())[0] not in wanted:
            state, reason = look
            if state in ENDED:
                raise links.RunFailed(state, reason, self.drive_refusal)
            if time.monotonic() >= end:
                raise links.TimedOut(" or ".join(wanted), timeout or 0.0, state)
            self.link.wait_for_news()
        return look[0]

    def _look(self) -> tuple[str, Reason]:
        """State and reason, while they belong to the run that is waited for. Raises RunGone."""
        run, state_number, reason_number = (
            int(links.number(one)) for one in self._all("Run number", "State", "Reason")
        )
        state, reason = names.state(state_number), names.reason(reason_number)
        before, self._run = self._run, None if state in AT_REST else run
        if before not in (None, run):
            raise links.RunGone(before, run, state, reason)
        return state, reason

    def result(self, timeout: float | None = 60.0) -> Result:
        """The result of the last run, once it is finished, judged and stored. Raises NoResult, TimedOut."""
        self._judged(timeout)
        found = read(self.link)
        if found is None:
            raise links.NoResult(f"the node has no result; its state is {self.state}")
        return found

    # Commands. All raise Refused where the state does not allow them.

    def command(self, name: str, argument: int = 0, angle_deg: float | None = None, proposal: int = 0) -> str:
        """Give any of the commands `TUMBLE_COMMAND_...`, such as "HOME_AXIS". `angle_deg`: the target of TURN_AXIS.
        Raises UsageError for an unknown name, and for TURN_AXIS without an angle."""
        if name not in COMMAND:
            raise UsageError(f"there is no command {quoted(name)}; there are {', '.join(COMMAND)}")
        if name == "TURN_AXIS" and angle_deg is None:  # the node would go where somebody sent it before
            raise UsageError("TURN_AXIS needs angle_deg, the target")
        self._give(name, argument, angle_deg, proposal)
        return self.state

    def _give(self, name: str, argument: int = 0, angle_deg: float | None = None, proposal: int = 0) -> None:
        try:
            self.link.command(COMMAND[name], argument, angle_deg, proposal)
            self._run = None if name in OTHER_RUN else self._run
        except links.Refused as refusal:
            if refusal.code != links.DEVICE_STATE:
                raise
            raise links.Refused(refusal.what, refusal.code, f"; it is {self.state}{self._stand(name)}") from None

    def _stand(self, command: str) -> str:
        """For a message: the state of the stand, if the command is one to the table; what the drive refused; and a stop
        in progress that CLEAR_FAULT has to wait for."""
        if command == "CLEAR_FAULT" and self.has(_STOP_RUNG) and 0 < self._whole(_STOP_RUNG) < STOP_NOT_CONFIRMED:
            return ", and the axis is not yet known to be at rest after the stop: try again"
        if command not in TO_TABLE:
            return ""
        refusal = self.drive_refusal
        return f", the stand {names.stand(self._whole(STAND_STATE))}{refusal and f': {refusal}'}"

    def start(self) -> str:
        """Begin a run. The state returned, and all that is read later, belongs to this run."""
        before, end = self.run, time.monotonic() + STEP_S
        self._give("START")
        while (run := self.run) <= before:
            if time.monotonic() >= end:
                raise links.CommunicationError("the node accepted START but shows no new run")
            self.link.wait_for_news()
        self._run = run
        return self.state

    def abort(self) -> str:
        """Stop the table and abort the run."""
        return self.command("ABORT")

    def resume(self) -> str:
        """Continue after FAULT, or after a loss of power."""
        return self.command("RESUME")

    def confirm(self, mounting: int | None = None) -> str:
        """Confirm that the block sits in this mounting; None: in the one that is asked for."""
        return self.command("CONFIRM_MOUNTING", self.mounting if mounting is None else mounting)

    def accept(self, result: Result) -> str:
        """Make a held result the active set. Returns the verdict. Raises Refused if another result has taken its place,
        UsageError if nothing is held."""
        if result.proposal is None:
            raise UsageError(f"the result is not held: its verdict is {result.verdict}")
        self._give("ACCEPT", proposal=result.proposal)
        return self._judged(STEP_S) or ""

    def discard(self) -> str:
        """Discard the held result. Returns the verdict."""
        self._give("DISCARD")
        return self._judged(STEP_S) or ""

    @contextmanager
    def unlock(self) -> Iterator[None]:
        """Open the service level, as a context manager: within it, settings of level `service` can be written, for 60 s
        at most. Raises Refused while a run is in progress."""
        self.link.write("Service level: Key", SERVICE_KEY)
        try:
            yield
        except BaseException:
            with suppress(TumbleError):  # what went wrong first is what is told
                self.link.write("Service level: Key", 0)
            raise
        self.link.write("Service level: Key", 0)

    def _judged(self, timeout: float | None) -> str | None:
        """Wait for the verdict. Raises TimedOut."""
        end = _end(timeout)
        while (said := verdict(_whole(self.link.read("Keeper: Verdict")))) == WORKING:
            if time.monotonic() >= end:
                raise links.TimedOut("the verdict", timeout or 0.0, self.state)
            self.link.wait_for_news()
        return said

    def _whole(self, name: str) -> int:
        [value] = self._all(name)
        return int(links.number(value))

    def _all(self, *wanted: str) -> list[links.Value]:
        found = self.link.read_together(*wanted)
        if None in found:
            raise links.CommunicationError(f"the node does not report its {wanted[found.index(None)]}")
        return found


def _end(timeout: float | None) -> float:
    return float("inf") if timeout is None else time.monotonic() + timeout
