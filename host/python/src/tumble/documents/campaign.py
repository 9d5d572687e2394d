"""What campaigns find: tumble.campaign/1, statistics of calibrations, and tumble.hostile/1, of the fault campaign."""

from __future__ import annotations

from typing import Annotated, Final, Literal, TypeAlias

from msgspec import Meta, field

from tumble.documents.base import Count, Document
from tumble.documents.result import Table

CAMPAIGN: Final = "tumble.campaign/1"
HOSTILE: Final = "tumble.hostile/1"

Nine: TypeAlias = Annotated[tuple[float | None, ...], Meta(min_length=9, max_length=9)]
Three: TypeAlias = Annotated[tuple[float | None, ...], Meta(min_length=3, max_length=3)]
Counted: TypeAlias = dict[str, Count]


class Exits(Document):
    passed: Count = field(name="0")
    limits_failed: Count = field(name="1")
    fault: Count = field(name="3")


class ErrorsOfK(Document):
    mean_error: Nine
    rms_error: Nine


class ErrorsOfU0(Document):
    mean_error: Three
    rms_error: Three


class Campaign(Document, kw_only=True):
    """Statistics of calibrations: tumble campaign runs --summary.

    exits: Runs by exit code.
    K: Errors found less true, V/g, row by row; null where no run came to a result.
    U0: V
    table: The range of the true tables of all runs since power-on; at_rest: all of them ended at rest.
    cpu_s: Null where some of the runs were kept by an earlier version.
    """

    schema: Literal["tumble.campaign/1"] = CAMPAIGN
    runs: Count
    first_seed: Count
    exits: Exits
    reasons: dict[Annotated[str, Meta(pattern="^TUMBLE_REASON_")], Count]
    K: ErrorsOfK
    U0: ErrorsOfU0
    frames: Count
    virtual_s: float
    table: Table
    jobs: Count
    wall_s: float
    cpu_s: float | None
    calibrations_per_s: float
    frames_per_s: float
    calibrations_per_cpu_s: float | None
    frames_per_cpu_s: float | None


class Violation(Document):
    """drawn: How many events the run was drawn with; `events`: those that are enough."""

    seed: Count
    kind: str
    at_s: float
    what: str
    drawn: Count
    world: str
    events: tuple[str, ...]


class Sets(Document):
    committed: Count
    judged: Count
    held: Count


class Speed(Document):
    """Different every time."""

    jobs: Count
    wall_s: float
    cpu_s: float
    ms_per_life: float


class Hostile(Document, kw_only=True):
    """The fault campaign: tumble campaign lives.

    violated: Runs that broke a rule.
    violations: Runs by rule.
    first: The first violations, minimised.
    faults: By kind: how often it occurred.
    excuses: Runs that had one.
    ends: By state and reason.
    table: The range of the true tables of all runs since power-on; at_rest: all of them ended at rest.
    """

    schema: Literal["tumble.hostile/1"] = HOSTILE
    runs: Count
    first_seed: Count
    violated: Count
    violations: Counted
    first: tuple[Violation, ...]
    faults: Counted
    events: Counted
    flipped_bits: Count
    excuses: Counted
    ends: dict[str, Counted]
    homings: Count
    sets: Sets
    lives_with_commit: Count
    virtual_s: float
    frames: Count
    steps: Count
    table: Table
    speed: Speed
