"""What a run on the bench says of itself: tumble.bench/1 in virtual time; on a real bus tumble.node/1 of the computer
and tumble.stand/1 of the simulated stand; tumble.replay/1 where a recorded bus goes through the firmware again; and
tumble.log/1, a line of what the programs log. The last three but replay are written in C (host/node, host/stand
and host/programs).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, TypeAlias

from msgspec import UNSET, Meta, UnsetType, field

from tumble.documents import base
from tumble.documents.base import Count, Document, Matrix, Positive, Size, Vector, exactly
from tumble.documents.result import OverTemperature, Table, Use

BENCH: Final = "tumble.bench/1"
NODE: Final = "tumble.node/1"
STAND: Final = "tumble.stand/1"
REPLAY: Final = "tumble.replay/1"
LOG: Final = "tumble.log/1"

StateName: TypeAlias = Annotated[str, exactly("TUMBLE_STATE_[A-Z0-9_]+")]
ReasonName: TypeAlias = Annotated[str, exactly("TUMBLE_REASON_[A-Z0-9_]+")]
StatusName: TypeAlias = Annotated[str, exactly("TUMBLE_(OK|E_[A-Z0-9_]+)")]
Counters: TypeAlias = dict[str, Count]
if TYPE_CHECKING:
    End: TypeAlias = str
    ExitCode: TypeAlias = int
    Axis: TypeAlias = str
    LogFormat: TypeAlias = str
    Firmware: TypeAlias = str
    Program: TypeAlias = str
    Level: TypeAlias = str
    LogEvent: TypeAlias = str
else:
    End = Literal["running", "done", "fault", "interrupted", "too long", "left"]
    ExitCode = Literal[0, 1, 2, 3, 130]
    Axis = Literal["x", "y", "z"]
    LogFormat = Literal["candump", "ASC", "BLF", "TRC", "MF4", "python-can CSV"]
    Firmware = Literal["host", "zcu102"]
    Program = Literal["tumble-node", "tumble-stand", "tumble-gateway"]
    Level = Literal["error", "warning", "notice", "info"]
    LogEvent = Literal[
        tuple(
            "ready state fault refused command held commit discarded repeated memory unlock lock stand connected"
            " disconnected turned_away put_off link mounted mended ignored unwritten unread lost end".split()
        )
    ]


class Mean(Document):
    mounting: Count
    position: Count
    samples: Count
    u_v: Vector
    standard_error_v: Vector


class Deviation(Document):
    mounting: Count
    position: Count
    use: Use
    delta_g_g: float


class GravityCheck(Document):
    delta_g_g: tuple[Deviation, ...]
    max_abs_delta_g_g: Size
    max_abs_fit_g: Size
    max_abs_check_g: Size
    limit_g: Positive
    passed: bool = field(name="pass")


class NoiseOnBoard(Document):
    block_samples: Count
    noise_v: Vector
    declared_v: float
    above_declared: tuple[Axis, ...]


class Refusal(Document):
    """Of an SDO request to the drive, or of a handshake: then the object that did not show in time what was waited for.

    step: What the drive was asked for.
    """

    index: Count
    subindex: Count
    abort: Count
    step: str
    sentence: str


class Truth(Document):
    """What the simulation was made of: angles are the errors of the stand, by mounting, alpha4 by position.

    theta_h_rad: Seat; the platform's is in it.
    beta_rad: Of a block that is bolted on once: the inclinations themselves, with alpha1 and the error of setting them.
    tau_rad: Likewise: error of the zero of the table angle at each; alpha2 is not in it.
    encoder_rad: By the sine and cosine of the table angle, and of its double.
    drift_v: By channel.
    over_temperature: Of a block that changes with its temperature: `K` and `U0` above are those at its `reference_c`.
    """

    K: Matrix
    U0: Vector
    alpha1_rad: float
    alpha2_rad: float
    alpha3_rad: tuple[float, ...]
    alpha4_rad: tuple[float, ...]
    theta_h_rad: tuple[float, ...]
    theta_n_rad: tuple[float, ...]
    encoder_rad: Annotated[tuple[float, ...], Meta(min_length=4, max_length=4)]
    drift_v: Annotated[tuple[float, ...], Meta(min_length=3, max_length=3)]
    beta_rad: tuple[float, ...] | UnsetType = UNSET
    tau_rad: tuple[float, ...] | UnsetType = UNSET
    over_temperature: OverTemperature | UnsetType = UNSET


class Fault(Document):
    kind: str
    times: Count


class FirmwareRun(Document, kw_only=True):
    """What the firmware did and found.

    exit: The exit code that a program with this run has.
    state: Where the run ended.
    failed_in: The state in which it failed; IDLE: no failure.
    reason: Why it ended.
    drive_code: The drive's own error code, or 0.
    K: V/g; null without a result.
    U0: V
    u_K: Standard uncertainties; null where none can be stated.
    noise: The noise as evaluated by the firmware; null if it was not evaluated.
    verification: The gravity check; null without a result.
    closure_g: By mounting.
    means: Of the positions finished.
    """

    schema: str
    seed: Count
    end: End
    exit: ExitCode
    state: StateName
    failed_in: StateName
    reason: ReasonName
    reason_number: Count
    reason_sentence: str
    status: StatusName
    drive_code: Count
    drive_refusal: Refusal | None
    estimator: str
    K: Matrix | None
    U0: Vector | None
    u_K: Matrix | None
    u_U0: Vector | None
    noise: NoiseOnBoard | None
    verification: GravityCheck | None
    closure_g: tuple[float, ...] | None
    means: tuple[Mean, ...]
    counters: Counters


class Bench(FirmwareRun, kw_only=True):
    """A simulated run: World.document, and fault.json of a run folder.

    counters: Of firmware, bus and simulation; host/world/report.c lists them.
    truth: What the simulation was made of.
    faults: Those of the scenario, and how often each has come.
    virtual_s: When it ended.
    table: How far the true table has turned since power-on.
    """

    schema: Literal["tumble.bench/1"] = BENCH
    truth: Truth
    faults: tuple[Fault, ...]
    virtual_s: Size
    table: Table


class Cause(Document):
    failed_in: StateName
    reason: ReasonName
    reason_number: Count
    reason_sentence: str
    drive_code: Count


class Computer(FirmwareRun, kw_only=True):
    """A run of a computer on a real bus.

    cause: The first fault from which the run has not recovered.
    counters: Of firmware and interface.
    """

    schema: Literal["tumble.node/1"] = NODE
    interface: str
    cause: Cause | None
    virtual_s: Size


class Node(Computer, kw_only=True):
    """What tumble-node prints when it ends."""


class NodeWithStand(Computer, kw_only=True):
    """The same with the simulated stand's data: fault.json of a run folder.

    counters: Of the stand, too.
    """

    truth: Truth
    faults: tuple[Fault, ...]
    table: Table


class Operator(Document):
    answers: Count
    refusals: Count


class Stand(Document, kw_only=True):
    """What tumble-stand prints when it ends.

    truth: What the simulation was made of.
    faults: Those of the scenario, and how often each has come.
    virtual_s: When it ended.
    table: How far the table has turned.
    angle_deg: Of the table, at the end.
    counters: Of the simulated bus and the interface.
    """

    schema: Literal["tumble.stand/1"] = STAND
    interface: str
    seed: Count
    truth: Truth
    faults: tuple[Fault, ...]
    virtual_s: Size
    table: Table
    angle_deg: float
    operator: Operator
    counters: Counters


class ReplayCounters(Document):
    received: Count
    samples: Count
    averaged: Count
    lost: Count
    retries: Count
    commands_refused: Count


class Replay(Document, kw_only=True):
    """A recorded bus log through the firmware again: what tumble replay prints.

    format: Of the log.
    time_step_us: All its times are multiples of this many microseconds; null: not looked at.
    state: Where the firmware ended.
    reason: Why.
    K: V/g
    U0: V
    bits: The twelve coefficients as hexadecimal digits of IEEE 754 doubles.
    passed: Of the gravity check.
    """

    schema: Literal["tumble.replay/1"] = REPLAY
    log: str
    format: LogFormat
    time_step_us: Count | None
    firmware: Firmware
    state: StateName
    reason: ReasonName
    K: Matrix
    U0: Vector
    bits: Annotated[tuple[Annotated[str, exactly("[0-9a-f]{16}")], ...], Meta(min_length=12, max_length=12)]
    passed: bool = field(name="pass")
    counters: ReplayCounters


class Log(Document, kw_only=True):
    """A line of tumble-node, tumble-stand or tumble-gateway with --log json: one event. docs/operations.md says which
    members each event has.

    time: UTC, with milliseconds.
    message: The event as a sentence: the line of --log text.
    cause: The first fault from which the run has not recovered.
    remedy: The remedy of docs/operations.md.
    exit: The exit code.
    """

    schema: Literal["tumble.log/1"] = LOG
    time: Annotated[str, exactly(r"[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}\.[0-9]{3}Z")]
    program: Program
    level: Level
    event: LogEvent
    message: Annotated[str, Meta(max_length=599)]
    reason: ReasonName | UnsetType = UNSET
    cause: ReasonName | UnsetType = UNSET
    state: StateName | UnsetType = UNSET
    sentence: str | UnsetType = UNSET
    remedy: str | UnsetType = UNSET
    exit: Annotated[int, Meta(ge=0, le=255)] | UnsetType = UNSET


RunWithTruth: TypeAlias = Bench | NodeWithStand

_WHOLE = 1e17  # below it a whole number is written without a point


def written(document: Document | dict[str, Any]) -> dict[str, Any]:
    """As the programs in C write theirs: unknown is null, a whole number has no point."""
    return base.written(document, _as_in_c)


def _as_in_c(value: Any) -> Any:
    if isinstance(value, float):
        if not math.isfinite(value):
            return None
        return int(value) if value == int(value) and abs(value) < _WHOLE else value
    return value
