"""tumble.store/1: what an image of a navigation computer's non-volatile memory holds, as `store dump` prints it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeAlias

from msgspec import UNSET, Meta, UnsetType

from tumble.documents.base import Document
from tumble.documents.result import AtLeastOne

STORE: Final = "tumble.store/1"

Byte: TypeAlias = Annotated[int, Meta(ge=0, le=255)]
Word: TypeAlias = Annotated[int, Meta(ge=0, le=2**32 - 1)]
KnownWord: TypeAlias = Annotated[int, Meta(ge=1, le=2**32 - 1)]
Celsius: TypeAlias = Annotated[float, Meta(ge=-64, le=63.5)]  # that a sample can tell
Place: TypeAlias = Annotated[str, Meta(min_length=1)]
Vector: TypeAlias = Annotated[tuple[float | None, ...], Meta(min_length=3, max_length=3)]
Matrix: TypeAlias = Annotated[tuple[Vector, ...], Meta(min_length=3, max_length=3)]
if TYPE_CHECKING:
    Active: TypeAlias = str
    Origin: TypeAlias = str
    EntryOrigin: TypeAlias = str
else:
    Active = Literal["A", "B", "factory"]
    Origin = Literal["factory", "committed", "accepted", "rolled back", "held"]
    EntryOrigin = Literal["factory", "committed", "accepted", "rolled back", "held", "decayed"]


class Range(Document):
    """Of all samples averaged in the run (of a position: so far), also for means given up, degrees Celsius; null: not
    known, as where it touches an end.
    """

    min_c: Celsius
    max_c: Celsius


class Check(Document):
    max_abs_fit_g: float
    max_abs_check_g: float
    limit_g: float


class Slopes(Document):
    """K(T) and U0(T) of a set of version 2: K, U0 + slopes[0] (T - temperature_c) + slopes[1] (T - temperature_c)^2,
    within temperature.

    degree: The highest power of which a slope is not 0.
    K: Slopes of K, V/g per K and per K^2.
    U0: Those of U0, V per K and per K^2.
    """

    degree: Annotated[int, Meta(ge=0, le=2)]
    K: Annotated[tuple[Matrix, ...], Meta(min_length=2, max_length=2)]
    U0: Annotated[tuple[Vector, ...], Meta(min_length=2, max_length=2)]


class Set(Document):
    """sequence: The calibration counter as it was made active with; 0: factory.
    estimator: Its number on board.
    serial: Of the block.
    date_utc_s: Seconds since 1970 UTC; null: not known.
    temperature_c: Mean of the run, or of its part after a loss of power; with slopes, T0, which they are about.
    temperature: Of the run; with slopes, where they hold.
    u_K: Standard uncertainties; null: not known.
    check: The gravity check.
    samples: Of the whole run.
    reasons: Why it was held, bits.
    slopes: Only of a set of version 2.
    """

    sequence: Word
    origin: Origin
    estimator: Byte
    serial: str
    date_utc_s: AtLeastOne | None
    temperature_c: float | None
    temperature: Range | None
    gravity_m_s2: float | None
    K: Matrix
    U0: Vector
    u_K: Matrix | None
    u_U0: Vector | None
    check: Check | None
    closure_v: float | None
    samples: KnownWord | None
    fit_positions: Byte
    check_positions: Byte
    schedule_crc: KnownWord | None
    stand_crc: KnownWord | None
    reasons: Word
    restores: Word
    from_crc: Word
    resumed: bool
    other_rules: bool
    slopes: Slopes | UnsetType = UNSET


class Slots(Document):
    A: Set | None
    B: Set | None


class Entry(Document):
    """date_utc_s: Seconds since 1970 UTC; null: not known.
    u_K: Standard uncertainties; null: not known.
    """

    number: Word
    sequence: Word
    origin: EntryOrigin | None
    estimator: Byte
    flags: Annotated[int, Meta(ge=0, le=2**16 - 1)]
    date_utc_s: AtLeastOne | None
    temperature_c: float | None
    K: Matrix
    U0: Vector
    u_K: Matrix | None
    u_U0: Vector | None


class KeptPosition(Document):
    """sums: Of the raw counts.
    scatter: Standard deviation of one sample, counts.
    """

    index: Byte
    samples: Word
    sums: Annotated[tuple[int, ...], Meta(min_length=3, max_length=3)]
    scatter: Vector
    temperature: Range | None


class Checkpoint(Document):
    fingerprint: Word
    positions: tuple[KeptPosition, ...]


class Store(Document, kw_only=True):
    """What tumble store dump prints with --json: what an image of a navigation computer's non-volatile memory holds.
    Names and units as in docs/embedding.md; K in V/g, U0 in V. Unknown is null.

    active: Where the set in force is; null: there is none.
    history: Newest first.
    checkpoint: The finished positions of a run; null: none is kept.
    torn: Places that are neither blank nor valid, and why, in words.
    newer: Places of whole sets that a newer version wrote, which this one cannot read, in words.
    """

    schema: Literal["tumble.store/1"] = STORE
    active: Active | None
    factory: Set | None
    slots: Slots
    proposal: Set | None
    history: tuple[Entry, ...]
    checkpoint: Checkpoint | None
    torn: tuple[Place, ...]
    newer: tuple[Place, ...] = ()
