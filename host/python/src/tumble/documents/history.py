"""tumble.history/1: the calibrations of many blocks, as `history` prints them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Literal, TypeAlias

from msgspec import Meta, field

from tumble.documents.base import Count, Document, Positive, Share, Size, exactly

HISTORY: Final = "tumble.history/1"

Time: TypeAlias = Annotated[str, exactly("[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}Z")]
Parameter: TypeAlias = Annotated[str, exactly("(scale_[xyz]|angle_(xy|xz|yz)|(bias|seat)_[xyz])")]
if TYPE_CHECKING:
    Millionths: TypeAlias = str
    Kind: TypeAlias = str
    Method: TypeAlias = str
    Why: TypeAlias = str
else:
    Millionths = Literal["ppm", "urad", "ug"]
    Kind = Literal["jump", "outlier", "open", "drift"]
    Method = Literal["control-chart", "staircase"]
    Why = Literal["growth", "interval", "alarm", "not shown", "no growth known", "one calibration"]


class Calibration(Document, kw_only=True):
    """type: Label type or model of the item; empty: none.
    measured: By a label date of the item or of the environment, else when it was solved.
    believed: Its numbers count: neither gravity check nor fit has failed.
    u_norm_g: Worst u(|a|).
    sha256: Of its document.
    """

    serial: str
    type: str
    measured: Time
    stand: str | None
    schedule: str | None
    estimator: str
    passed: bool = field(name="pass")
    believed: bool
    u_norm_g: Size | None
    temperature_c: float | None
    sha256: str


class ParameterGrowth(Document):
    """Per year of 365.25 days, in the unit; walk: per square root of a year; spread: of the drift, from block to block.

    ratio: Root mean square of the innovations over what is stated; null: none.
    """

    name: Parameter
    unit: Millionths
    drift: float
    u_drift: Size | None
    spread: Size
    u_spread: Size | None
    walk: Size
    u_walk: Size | None
    ratio: Size | None


class TypeOfBlock(Document):
    """intervals: Between calibrations that follow each other, from which the growth is estimated.
    growth: null: of too few.
    """

    type: str
    blocks: Count
    calibrations: Count
    intervals: Count
    growth: tuple[ParameterGrowth, ...] | None


class Alarm(Document):
    """kind: jump: the calibrations after it agree with it; outlier: they agree with those before; open: it is the last
        one; drift: the moving average, of changes that are small and stay.
    size: Found less foreseen, in the unit.
    z: The same, or of a drift the moving average, in its standard deviations.
    of_seat: The block sits otherwise, but has not changed, if no other parameter has an alarm.
    """

    serial: str
    type: str
    measured: Time
    parameter: Parameter
    kind: Kind
    size: float
    unit: Millionths
    z: float
    of_seat: bool


class Point(Document):
    """value: Less that of the first calibration, scales relative, in the unit.
    z, ewma: Of the control charts; null: none.
    """

    measured: Time
    parameter: Parameter
    value: float
    u: Size
    unit: Millionths
    z: float | None
    ewma: float | None


class DueBlock(Document):
    """last: Its last calibration.
    days: From that on; null: more than a hundred years, or unknown.
    due: null: unknown, or never within a hundred years.
    why: growth: the uncertainty reaches the limit then; interval: by the staircase; alarm: the last calibration is
        beyond its control limit; not shown: the limit is not kept even at once; no growth known: too few calibrations
        of its type; one calibration: the staircase needs two, a day apart at least.
    """

    serial: str
    type: str
    last: Time
    days: Size | None
    due: Time | None
    why: Why


class History(Document):
    """What tumble history prints with --json, by its subcommand."""

    schema: Literal["tumble.history/1"] = HISTORY


class Listing(History, kw_only=True):
    """What tumble history show prints.

    history: The file, or the URL without its password.
    calibrations: By block and time.
    """

    kind: Literal["show"] = "show"
    history: str
    calibrations: tuple[Calibration, ...]


class Trend(History, kw_only=True):
    """What tumble history trend prints.

    confidence: Share of the calibrations of blocks that behave that give no alarm, at least.
    control_limit: Of z and ewma, for that.
    left_out: Calibrations that do not count, by why.
    without_gravity: Those that count but state no gravity_m_s2: taken as measured at the usual one of their blocks.
    types: How their parameters grow: `drift`, `spread` and `walk` with their standard uncertainties.
    alarms: By time: `serial`, `parameter`, `kind` ("jump", "outlier", "open", "drift"), `size` and `z`; of_seat where
        only the seat has one.
    temperatures_apart_c: Largest difference of the temperatures of a block, as far as they are known.
    points: Values and control charts of a single block that was asked for, else none.
    """

    kind: Literal["trend"] = "trend"
    history: str
    confidence: Share
    control_limit: Positive
    blocks: Count
    calibrations: Count
    left_out: dict[str, Count]
    without_gravity: Count
    temperatures_apart_c: Size
    types: tuple[TypeOfBlock, ...]
    alarms: tuple[Alarm, ...]
    points: tuple[Point, ...]


class Due(History, kw_only=True):
    """What tumble history due prints.

    method: By which the days are found.
    blocks: The one that is due first, first: `last` calibration, `days` from that on, `due`, and `why` then. Of trend:
        how many.
    """

    kind: Literal["due"] = "due"
    history: str
    method: Method
    limit_g: Positive
    coverage_factor: Annotated[float, Meta(ge=1)]
    left_out: dict[str, Count]
    blocks: tuple[DueBlock, ...]
