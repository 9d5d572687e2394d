"""tumble.watch/1: what `watch` knows of a run at one moment."""

from __future__ import annotations

from typing import Annotated, Final, Literal, TypeAlias

from msgspec import Meta, field

from tumble.documents.base import Count, Document, exactly

WATCH: Final = "tumble.watch/1"

Text: TypeAlias = Annotated[str, Meta(min_length=1)]
Vector: TypeAlias = Annotated[tuple[float, ...], Meta(min_length=3, max_length=3)]  # of the channels x, y, z
Matrix: TypeAlias = Annotated[tuple[Vector, ...], Meta(min_length=3, max_length=3)]


class Mean(Document):
    """The running mean; the last one stays until there is another.

    mean_v: V.
    standard_error_v: Of the mean, V.
    """

    mounting: Count | None
    position: Count | None
    samples: Count | None
    wanted: Count | None
    mean_v: Vector
    standard_error_v: Vector | None


class Gravity(Document):
    """The gravity check.

    max_fit_g: Largest deviation from 1 g on fitted positions, g.
    max_check_g: On check positions, g.
    limit_g: What they are held to.
    passed: null: the check has not been made.
    """

    max_fit_g: float | None
    max_check_g: float | None
    limit_g: float | None
    passed: bool | None

    @property
    def worst_g(self) -> float | None:
        """The larger of the two deviations."""
        known = [value for value in (self.max_fit_g, self.max_check_g) if value is not None]
        return max(known, default=None)


class Snapshot(Document):
    """A navigation computer and its run.

    state: Of the run, as TUMBLE_STATE_... has it.
    reason: As TUMBLE_REASON_... has it; null: nothing is wrong, or unknown.
    trouble: What the source itself says is wrong.
    run: Number of the run since power-on.
    count: Positions of the schedule.
    finished: Positions with a mean.
    attempt: 0: the first.
    samples: In the open mean.
    wanted: Samples of a position.
    stand: As TUMBLE_STAND_... has it.
    angle_rad: Of the table; null as well before homing and after a fault of the axis.
    temperature_c: Of the block, degrees Celsius.
    k_v_per_g: K of the last run, V/g.
    u0_v: U0 of the last run, V.
    u_k_v_per_g: Standard uncertainties of K, V/g.
    u_u0_v: Standard uncertainties of U0, V.
    emergencies: By name of the node: the CiA 301 error code that it has raised and not taken back.
    virtual_s: Time of a simulated run, s.
    over: Nothing more will come.
    meaning: What is done in that state.
    sentence: What the reason means.
    remedy: What to do about it.
    """

    state: Text | None = None
    reason: Text | None = None
    trouble: Text | None = None
    run: Count | None = None
    mounting: Count | None = None
    position: Count | None = None
    count: Count | None = None
    finished: Count | None = None
    attempt: Count | None = None
    samples: Count | None = None
    wanted: Count | None = None
    stand: Text | None = None
    angle_rad: float | None = None
    target_rad: float | None = None
    temperature_c: float | None = None
    mean: Mean | None = None
    k_v_per_g: Matrix | None = None
    u0_v: Vector | None = None
    u_k_v_per_g: Matrix | None = None
    u_u0_v: Vector | None = None
    gravity: Gravity | None = None
    emergencies: dict[str, Annotated[str, exactly("[0-9A-F]{4}")]] = field(default_factory=dict)
    virtual_s: float | None = None
    over: bool = False
    meaning: Text | None = None
    sentence: Text | None = None
    remedy: Text | None = None


class Outage(Document):
    since_unix_s: float
    why: Text


class Watch(Document, kw_only=True):
    """What tumble watch knows of a run at one moment (docs/bench.md). Unknown is null. Vectors are of the channels x,
    y, z; matrices row by row.

    source: As it was given to tumble watch.
    time_unix_s: When this was found out, s since 1970 UTC.
    lost: The source does not answer; the snapshot is the last one. null: it answers.
    snapshot: null: there was none yet.
    """

    schema: Literal["tumble.watch/1"] = WATCH
    source: Text
    time_unix_s: float
    lost: Outage | None
    snapshot: Snapshot | None
