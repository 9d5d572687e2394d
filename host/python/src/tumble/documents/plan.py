"""tumble.plan/1: what a stand is worth before a run, by subject (`plan`). K in V/g, U0 in volts, angles in radians,
biases in g."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Generic, Literal, TypeAlias, TypeVar

from msgspec import UNSET, Meta, UnsetType, field

from tumble.documents.base import (
    ByChannel,
    Count,
    Document,
    FurtherGains,
    Gains,
    Interval,
    Matrix,
    PerCoefficient,
    Positive,
    Share,
    SixSizes,
    Size,
    SizeMatrix,
    SizePerCoefficient,
    Sizes,
    Three,
)
from tumble.documents.further import Term
from tumble.documents.result import AtLeastOne, Remedy, SecondOrder, Unseen, WorstNorm
from tumble.estimators import COEFFICIENTS, ESTIMATORS

PLAN: Final = "tumble.plan/1"
ROWS = ("K_xx", "K_yy", "K_zz", "a0_x", "a0_y", "a0_z", "noise")  # that a limit is shared out over

Limit: TypeAlias = Annotated[float, Meta(gt=0, le=1)]  # of the gravity check, g
Asked: TypeAlias = Annotated[float, Meta(ge=0.5, le=0.9999)]  # a probability
Known: TypeAlias = Size | None
Channels: TypeAlias = tuple[Known, Known, Known]
BySource: TypeAlias = Annotated[tuple[Known, ...], Meta(min_length=5, max_length=9)]
Terms: TypeAlias = Annotated[tuple[Term, ...], Meta(min_length=1, extra_json_schema={"uniqueItems": True})]
Numbers: TypeAlias = Literal["standard deviations", "as declared"]
if TYPE_CHECKING:
    Name: TypeAlias = str
    Estimator: TypeAlias = str
    ForAnySchedule: TypeAlias = str
    Weights: TypeAlias = str
    RowName: TypeAlias = str
    Table: TypeAlias = str
    Names: TypeAlias = tuple[str, ...]
else:
    Name = Literal[tuple(one.replace("U0", "a0") for one in COEFFICIENTS)]
    Estimator = Literal[ESTIMATORS]
    ForAnySchedule = Literal["least_squares", "optimal", "inclined"]
    Weights = Literal["published", "derived"]
    RowName = Literal[ROWS]
    Table = Literal["known", "run"]
    Names = Annotated[tuple[Literal[COEFFICIENTS], ...], Meta(extra_json_schema={"const": COEFFICIENTS})]

OneT = TypeVar("OneT")
AngleT = TypeVar("AngleT")
OutputT = TypeVar("OutputT")


class OfSources(Document, Generic[OneT]):
    """One of each source; of the last four where the stand declares them."""

    alpha1: OneT
    alpha2: OneT
    alpha3: OneT
    alpha4: OneT
    noise: OneT
    seat: OneT | UnsetType = UNSET
    platform: OneT | UnsetType = UNSET
    encoder: OneT | UnsetType = UNSET
    drift: OneT | UnsetType = UNSET


class OfPaper(Document, Generic[AngleT, OutputT]):
    """Of the paper's five sources."""

    alpha1_rad: AngleT
    alpha2_rad: AngleT
    alpha3_rad: AngleT
    alpha4_rad: AngleT
    noise_v: OutputT


class OfStand(OfPaper[AngleT, OutputT]):
    """Of the sources; of the last four where the stand declares them."""

    seat_rad: AngleT | UnsetType = UNSET
    platform_rad: AngleT | UnsetType = UNSET
    encoder_rad: AngleT | UnsetType = UNSET
    drift_v: OutputT | UnsetType = UNSET


class SourceSizes(OfStand[Size, ByChannel]):
    """Sizes of the sources."""


class SourceLimits(OfStand[Known, ByChannel | None]):
    """Null where nothing limits."""


class MeanSizes(SourceSizes, kw_only=True):
    """Sizes of the sources; the noise is that of a position's mean, with what rounding leaves in it."""

    samples: AtLeastOne


class Enough(SourceSizes, kw_only=True):
    """Sizes of the sources that leave the probability: the requirements times the factor; what no row limits is as
    declared. Null where no factor does."""

    samples: AtLeastOne | None
    factor: Positive


class Rule(OfPaper[Known, ByChannel | None]):
    """With published weights, whose own values are (19) as printed: what the paper's rule gives."""

    samples: AtLeastOne | None
    set_by: OfSources[RowName | None]


class Equation18(Document):
    alpha2_rad: Known
    alpha4_rad: Known
    noise_v: ByChannel | None


class Block(Document):
    scale_v_per_g: float | Three
    misalignment_rad: Size


class WithoutTerms(Document):
    """Standard uncertainties, V/g, V and g, without the further terms."""

    u_K: SizeMatrix
    u_U0: Sizes
    u_norm_g: Size


class ModelCost(Document):
    """Further terms of the model (--model): what they cost. Null for a term that is not in it.

    u_norm_of_K_U0_g: As u_norm_g, by K and U0 alone.
    u_norm_g: Worst u(|a|), g, the terms applied; a drift is over.
    """

    terms: Terms
    u_k2_per_g: Sizes | None
    u_k3_per_g2: Sizes | None
    u_drift_v: Sizes | None
    u_norm_of_K_U0_g: Size
    without: WithoutTerms
    u_norm_g: Size
    u_asymmetry: Sizes | UnsetType = UNSET
    u_cross_per_g: SixSizes | UnsetType = UNSET


class Promise(Document):
    """Probabilities that a run passes the gravity check, and that the error of |a| is within the limit at every
    attitude; u: the standard errors with which they are computed.

    u_norm_worst_g: The worst standard uncertainty of |a|.
    shown: Whether coverage_factor times u_norm_worst_g is within the limit: else no run passes.
    assumes: As assumes of tumble.result/1: seat where every_attitude rests on a block that sits square.
    """

    limit_g: Limit
    passes: Share
    u_passes: Share
    every_attitude: Share
    u_every_attitude: Share
    u_norm_worst_g: Size
    coverage_factor: Annotated[float, Meta(ge=1)]
    shown: bool
    assumes: Annotated[tuple[Literal["seat"], ...], Meta(extra_json_schema={"uniqueItems": True})]


class GrowingPromise(Promise):
    """A promise.

    growth: The factor by which all errors of the stand may grow until the less probable of both has the probability
        asked for, or until the uncertainty does not show the limit; null without errors.
    """

    growth: Size | None


class Plan(Document):
    """What tumble plan prints with --json. K in V/g, U0 in volts, angles in radians, biases in g. Unknown is null,
    never NaN."""

    schema: Literal["tumble.plan/1"] = PLAN


class Budget(Plan, kw_only=True):
    """What a stand leaves of the accuracy of every coefficient.

    numbers: What the numbers are: with derived weights standard deviations, with published ones as in the stand file.
    u_K_relative: Row i: of K_ix, K_iy, K_iz, relative to the coefficient; null where that is zero.
    u_K: V/g; null where the coefficient is zero.
    u_U0: V
    terms: Contributions of alpha1 to alpha4 and the noise, then of seat, platform, encoder and drift where sources has
        them, relative or, of a bias, in g.
    promise: Null with the paper's weights, which have no joint law.
    reliability: As in a result, for the nominal block; null with the paper's weights.
    """

    plan: Literal["budget"] = "budget"
    weights: Weights
    estimator: Estimator
    numbers: Numbers
    block: Block
    sources: MeanSizes
    u_K_relative: tuple[Channels, Channels, Channels]
    u_a0_g: Sizes
    u_K: tuple[Channels, Channels, Channels]
    u_U0: Sizes
    terms: Annotated[dict[Name, BySource], Meta(min_length=12)]
    second_order: SecondOrder
    promise: Promise | None
    reliability: tuple[Unseen, ...] | None = None
    reliability_norm_g: Size | None = None
    extended: ModelCost | UnsetType = UNSET


class Row(Document):
    limit: Size
    weights: Annotated[tuple[Size, ...], Meta(min_length=5, max_length=9)]
    shares: Annotated[tuple[Size, ...], Meta(min_length=5, max_length=9)]


class Require(Plan, kw_only=True):
    """What an accuracy asks of a stand, and how much room it has.

    samples: Null, here and below, where the rounding of a converter that no noise dithers leaves more in a mean of any
        number.
    set_by: The row that sets the requirement; null where nothing does.
    numbers: What the numbers are: with derived weights standard deviations, with published ones as in the stand file.
    split: How sources share the square of a row.
    alone: How large one source may be while the others are as declared.
    margin: The factor by which all sources may grow together.
    margins: The margin with every estimator that the schedule allows: at 1 a third of the limit is the standard
        deviation of a row; null for a stand without errors.
    probability: What is just enough; null, like the next three, with published weights, which promise none.
    promises: Of the declared stand, with every estimator that the schedule allows.
    would_show: Where the uncertainty is beyond the limit: as would_show of tumble.result/1; else null.
    """

    plan: Literal["require"] = "require"
    weights: Weights
    estimator: Estimator
    limit_g: Limit
    alpha1_rad: Known
    alpha2_rad: Known
    alpha3_rad: Known
    alpha4_rad: Known
    noise_v: ByChannel | None
    seat_rad: Known | UnsetType = UNSET
    platform_rad: Known | UnsetType = UNSET
    encoder_rad: Known | UnsetType = UNSET
    drift_v: ByChannel | UnsetType | None = UNSET
    samples: AtLeastOne | None
    set_by: OfSources[RowName | None]
    rule: Rule | UnsetType = UNSET
    equation_18: Equation18 | UnsetType = UNSET
    numbers: Numbers
    split: OfSources[Positive]
    rows: Annotated[dict[RowName, Row], Meta(min_length=len(ROWS))]
    declared: SourceSizes
    alone: SourceLimits
    margin: Known
    margins: dict[Estimator, Known]
    probability: Asked | None
    promise: GrowingPromise | None
    promises: dict[Estimator, GrowingPromise] | None
    just_enough: Enough | None
    would_show: tuple[Remedy, ...] | None = None
    extended: ModelCost | UnsetType = UNSET


class Line(Document):
    """A printed number or formula.

    value: As printed, or what the formula gives.
    agrees: After rounding to the printed digits, or for a weight to first order.
    notes: Numbers of the discrepancies that it shows.
    """

    table: str
    row: str
    column: str
    printed: str
    value: float
    computed: float
    agrees: bool
    notes: tuple[AtLeastOne, ...]


class Discrepancy(Document):
    """Where printed numbers do not follow from printed formulas, or these from the geometry.

    number: As the lines refer to it.
    where: In the paper.
    """

    number: AtLeastOne
    where: str
    printed: str
    computed: str
    why: str


class Paper(Plan, kw_only=True):
    """The paper's tables and formulas computed again."""

    plan: Literal["paper"] = "paper"
    misalignments_of_weights: Matrix
    lines: Annotated[tuple[Line, ...], Meta(min_length=1)]
    discrepancies: Annotated[tuple[Discrepancy, ...], Meta(min_length=1)]


class Optimize(Plan, kw_only=True):
    """The gain table that is best for a stand.

    gains: Rows as names; a column for each mounting, position and channel, the last fastest.
    stand_gains: The same of the errors of the stand that are estimated with the coefficients.
    efficiency: The least possible standard deviations over those of the gains.
    gain_over_refined: Null where the schedule has no such estimator.
    sigma_mean_v: Of a position's mean.
    noise_floored: The stand declares no noise; the weights are those for 1e-9 g of it.
    """

    plan: Literal["optimize"] = "optimize"
    stand: str | None
    block: Block
    estimator: Literal["optimal"] = "optimal"
    unit: Literal["V"] = "V"
    names: Names
    K: Matrix
    gains: Gains
    stand_gains: FurtherGains
    u_K: SizeMatrix
    u_U0: Sizes
    efficiency: SizePerCoefficient
    gain_over_refined: SizePerCoefficient | None
    gain_over_least_squares: SizePerCoefficient
    sigma_mean_v: ByChannel
    noise_floored: bool
    second_order: SecondOrder
    promise: Promise


class Goal(Document):
    """A worst u(|a|), or a limit with its probability."""

    norm_g: Positive | None
    limit_g: Limit | None
    probability: Asked | None


class Pace(Document):
    velocity_deg_per_s: Positive
    acceleration_deg_per_s2: Positive
    settling_s: Size
    sample_rate_hz: Positive
    remounting_s: Size
    inclining_s: Size


class Timed(Document):
    """mountings: Or inclinations of one bolting.
    samples: At each position.
    freedom: Of the residuals.
    """

    mountings: AtLeastOne
    positions: AtLeastOne
    samples: AtLeastOne
    freedom: Count
    seconds: Size
    moving_s: Size
    settling_s: Size
    averaging_s: Size
    remounting_s: Size
    inclining_s: Size


class FoundSchedule(Timed):
    """estimator: By which it gets there.
    boltings: How often the block is bolted on: once, where the stand is inclined.
    matrices: As in a schedule file.
    axis_tilts_deg: At which each mounting is inclined, to both sides.
    less_steep_deg: How much nearer to the level these may be for the limit; 0: they are meant as they stand.
    angles_deg: Of each mounting.
    """

    estimator: ForAnySchedule
    boltings: AtLeastOne
    matrices: Annotated[tuple[Matrix, ...], Meta(min_length=2)]
    axis_tilts_deg: Annotated[tuple[float, ...], Meta(min_length=2)]
    less_steep_deg: Size
    angles_deg: Annotated[tuple[Annotated[tuple[float, ...], Meta(min_length=1)], ...], Meta(min_length=2)]


class Beside(Document):
    """What the built-in schedules take for the same; null where they do not get there, or the stand does not incline as
    they ask."""

    paper: Timed | None
    three_mountings: Timed | None
    diagonal: Timed | None
    inclined: Timed | None
    inclined_closed: Timed | None


class Quickest(Plan, kw_only=True):
    """The quickest schedule for an accuracy.

    estimator: By which the schedule gets there.
    angles_deg: Table angles are multiples of it.
    other: The quickest of the other kind: of one bolting where `schedule` is re-mounted, and the other way round; null
        where none gets there.
    reliability: As in a result, for the nominal block.
    """

    plan: Literal["schedule"] = "schedule"
    stand: str
    block: Block
    estimator: ForAnySchedule
    goal: Goal
    angles_deg: float
    pace: Pace
    schedule: FoundSchedule
    other: FoundSchedule | None
    u_norm_g: WorstNorm
    promise: GrowingPromise
    reliability: tuple[Unseen, ...] | None = None
    reliability_norm_g: Size | None = None
    extended: ModelCost | UnsetType = UNSET
    beside: Beside


class Covered(Document):
    """Shares of the runs within so many of their own stated standard uncertainties, and where the probability lies."""

    covered: SizePerCoefficient
    low: SizePerCoefficient
    high: SizePerCoefficient


class Shares(Document):
    """Of the simulated runs, beside the probabilities promised."""

    passes: Share
    every_attitude: Share


class Figures(Document):
    """Of an estimator.

    u: As planned.
    bound: The least possible.
    coverage: By coverage factor.
    outside: What lies outside its limits, in words.
    """

    u: SizePerCoefficient
    bound: SizePerCoefficient
    bias_over_u: PerCoefficient
    spread_over_u: SizePerCoefficient
    efficiency: SizePerCoefficient
    coverage: dict[str, Covered]
    outside: tuple[str, ...]
    promise: Promise
    simulated: Shares


class FigureLimits(Document):
    """coverage: By coverage factor.
    binomial_sigmas: How far a share may be off by chance.
    """

    bias_over_u: Size
    spread_over_u: Interval
    efficiency_of_optimal: float
    coverage: dict[str, Interval]
    binomial_sigmas: Size


class Validation(Plan, kw_only=True):
    """Simulated runs against what they claim. Arrays run over names.

    table: Optimal weights: for the block's known K, or made anew for each run.
    passed: Every figure is within its limits.
    """

    plan: Literal["validate"] = "validate"
    stand: str | None
    block: Block
    runs: AtLeastOne
    seed: Count
    table: Table
    model: Terms | UnsetType = UNSET
    names: Names
    limits: FigureLimits
    estimators: Annotated[dict[Estimator, Figures], Meta(min_length=1)]
    passed: bool = field(name="pass")
