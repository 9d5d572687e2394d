"""tumble.result/1: the outcome of one calibration. U = U0 + K a: outputs U, specific force a in units of local gravity.

A new key is a field here with its meaning, a value in solving.result.document_of, and whatever shows it;
tools/schemas.py makes the schema and the table in docs/files.md of it (`_WRITTEN` there: keys that are always written
though a reader does without), and `tools/goldens write` takes it up. A key with a default came later, or is not always
written.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Final, Generic, Literal, TypeAlias, TypeVar

import msgspec
from msgspec import UNSET, Meta, UnsetType, field

from tumble.documents.base import (
    LARGEST,
    ByChannel,
    Count,
    Covariance,
    Document,
    Interval,
    Matrix,
    Number,
    PlaceNumber,
    Positive,
    Share,
    Size,
    SizeMatrix,
    Sizes,
    Vector,
    exactly,
    read,
)
from tumble.documents.further import Extended
from tumble.documents.prior import Prior
from tumble.errors import quoted
from tumble.files.disk import RESULT_FILE, read_bytes
from tumble.schedule import CHECK, FIT
from tumble.stand import COMMON, INDEPENDENT, LIMIT_KINDS, SOURCES
from tumble.units import UNIT, spelled

RESULT: Final = "tumble.result/1"
REASONS = ("gravity", "fit", "uncertainty")  # why it did not pass, in this order

Name: TypeAlias = Annotated[str, exactly("[A-Za-z0-9_]+")]
Coefficient: TypeAlias = Annotated[str, exactly("(K_[xyz][xyz]|U0_[xyz])")]
Channels: TypeAlias = Annotated[tuple[Literal["ux", "uy", "uz"], ...], Meta(extra_json_schema={"uniqueItems": True})]
Day: TypeAlias = Annotated[str, exactly("[0-9]{4}-[0-9]{2}-[0-9]{2}")]
AtLeastOne: TypeAlias = Annotated[int, Meta(ge=1)]
Counts: TypeAlias = tuple[AtLeastOne, AtLeastOne, AtLeastOne]
Freedom: TypeAlias = Positive | None  # degrees of freedom; null: infinite
Freedoms: TypeAlias = tuple[Freedom, Freedom, Freedom]
Factor: TypeAlias = Annotated[float, Meta(ge=1.9599)]
Factors: TypeAlias = tuple[Factor, Factor, Factor]
Labels: TypeAlias = dict[str, str | int | float]
if TYPE_CHECKING:  # a type checker takes no names that are made
    Firmware: TypeAlias = str
    From: TypeAlias = str
    Scope: TypeAlias = str
    ToldBy: TypeAlias = str
    Use: TypeAlias = str
else:
    Firmware = Literal["host", "zcu102"]
    From = Literal["stand", "run"]
    Scope = Literal["everywhere", "measured positions"]
    ToldBy = Literal["run_file", "environment"]
    Use = Literal[FIT, CHECK]

OneT = TypeVar("OneT")
ThreeT = TypeVar("ThreeT")
BiasT = TypeVar("BiasT")
Angle: TypeAlias = Annotated[float, Meta(ge=0, le=3.1416)]


if TYPE_CHECKING:

    class DeclaredStand(Document):
        """Its further keys are those of the table of sources."""

        name: str | None
        limits: str
        remount: str
        samples: int
        step_v: ByChannel | None

else:
    DeclaredStand = msgspec.defstruct(
        "DeclaredStand",
        [
            ("name", str | None),
            ("limits", Literal[LIMIT_KINDS]),
            ("remount", Literal[INDEPENDENT, COMMON]),
            ("samples", AtLeastOne),
            *((one.key, Size if one.is_angle else ByChannel) for one in SOURCES.values() if not one.of_inclinations),
            ("step_v", ByChannel | None, None),
            *((one.key, Size | UnsetType, UNSET) for one in SOURCES.values() if one.of_inclinations),
        ],
        bases=(Document,),
        module=__name__,
        namespace={"__doc__": "With the keys of [stand].\n\nstep_v: Of the block's converter; null: unknown."},
    )


class Mounting(Document):
    """A table [[mounting]] of a schedule file."""

    number: PlaceNumber
    matrix: Matrix
    axis_tilt_deg: float
    bolting: PlaceNumber | UnsetType = UNSET


class Inclination(Document):
    """As a run shows it."""

    mounting: PlaceNumber
    deg: float
    u_deg: Size | None
    zero_deg: float


class Position(Document):
    """A table [[position]] of a schedule file."""

    mounting: PlaceNumber
    position: PlaceNumber
    angle_deg: float
    use: Use


class Schedule(Document):
    """With the tables of a schedule file.

    name: Of a built-in one.
    """

    name: str | None
    mounting: Annotated[tuple[Mounting, ...], Meta(min_length=1)]
    position: Annotated[tuple[Position, ...], Meta(min_length=1)]


class Units(Document):
    K: str
    U0: str
    u_K: str
    u_U0: str


class WorstNorm(Document):
    worst_g: Size
    attitude: Vector


class SetAngles(Document):
    """u_rad: Of the least certain mark. repeatability_rad: With which the table comes to a mark again."""

    learned: Day
    expires: Day
    runs: AtLeastOne
    u_rad: Size
    repeatability_rad: Size
    u_repeatability_rad: Size


class Shift(Document):
    source: str
    coefficient: Coefficient
    bias_relative: Size
    limit: Size


class Bias(Document):
    """Expected of the estimate, less the truth, in its units."""

    K: Matrix
    U0: Vector


class SecondOrder(Document):
    """bias_K_xx_relative: alpha3^2/2, what a yaw takes off K_xx of a linear estimate; limit: 0.2 u(K_xx)/K_xx.

    shifts: Every coefficient whose bias matters, the source with the largest part in it, bias and limit over the scale
        factor of its row.
    """

    bias_K_xx_relative: Size
    limit: Size
    matters: bool
    shifts: tuple[Shift, ...]
    bias: Bias | None = None


class Simulated(Document):
    """Of one coefficient.

    shift: Mean of the estimates less the truth.
    u: Standard deviation of the estimates.
    difference: Larger one of the differences of the ends.
    tolerance: Half a unit of the first digit of the stated uncertainty.
    """

    name: Coefficient
    shift: float
    u: Size
    interval: Interval
    linear_interval: Interval
    difference: Size
    tolerance: Size
    verdict: Literal["agrees", "differs", "cannot tell"]


class MonteCarlo(Document):
    """Of solve --monte-carlo: runs simulated on the declared stand at this result, their intervals beside those of the
    stated uncertainties.

    coverage: Of the intervals.
    level: At which the ends of a simulated interval are taken as known.
    agrees: All coefficients agree; null: too few runs to decide.
    """

    runs: Annotated[int, Meta(ge=1000)]
    seed: Count
    coverage: Share
    level: Share
    agrees: bool | None
    coefficients: Annotated[tuple[Simulated, ...], Meta(min_length=12, max_length=12)]


class Explanation(Document):
    """patterns: Those that this run cannot distinguish, the likeliest first.
    p: Corrected after Holm.
    u_size: Standard uncertainty.
    column: What the size is of, such as a channel; null: of all.
    """

    patterns: Annotated[tuple[Name, ...], Meta(min_length=1, extra_json_schema={"uniqueItems": True})]
    p: Share
    size: float | None
    u_size: Size | None
    unit: str
    column: str | None


class Fit(Document):
    """Does the run fit the declared stand? The same for every estimator.

    chi2: Squares of all residuals in units of what the stand declares.
    p: How often a run that fits has a larger chi2.
    explanations: What the run shows that is not declared, in the order in which it was found: of a run that does not
        fit, or at the same confidence of one that fits as a whole.
    """

    chi2: Size
    dof: Count
    p: Share
    fits: bool
    confidence: Annotated[float, Meta(gt=0, lt=1)]
    explanations: tuple[Explanation, ...]


class Unseen(Document):
    """An error that the run could not have shown.

    size: null: no size is detectable.
    norm_error_g: Error of |a| at that size, worst attitude.
    """

    pattern: Name
    size: Size | None
    unit: str
    norm_error_g: Size | None


class Decision(Document):
    """coverage_factor times u_norm_worst_g within limit_g, at every attitude. scope: measured positions without a
    declared stand, whose uncertainties nobody knows.
    """

    coverage_factor: Annotated[float, Meta(ge=1)]
    u_norm_worst_g: Size | None
    limit_g: Positive
    scope: Scope


class Remedy(Document):
    """What would show that the limit is met. change: the estimator, samples at each position, mountings, poses;
    inclinations: the steepest, deg; stand or converter: how many times better.

    reach_g: Coverage factor times the worst u(|a|) then.
    """

    change: Literal["estimator", "samples", "mountings", "poses", "inclinations", "stand", "converter"]
    to: str | int | float
    reach_g: Size

    def __post_init__(self) -> None:
        kind = {"estimator": str, "samples": int, "mountings": int, "poses": int}.get(self.change, (int, float))
        if not isinstance(self.to, kind) or (not isinstance(self.to, str) and self.to < 0):
            raise ValueError("a change to something else")


class Noise(Document):
    """The noise that the samples show, by channel, in the unit of the outputs; null where no position has two samples.

    scatter: Standard deviation of one sample.
    of_means: Scatter of white noise that would give the standard errors of the means.
    block_samples: The length of the blocks used for these.
    freedom: Their degrees of freedom.
    above_declared: Channels whose uncertainties use it instead of the declared noise; all without a declared stand.
    undithered: Channels whose samples round alike.
    """

    scatter: Vector | None
    of_means: Vector | None
    block_samples: Counts | None
    freedom: Counts | None
    above_declared: Channels
    undithered: Channels


class ScatterAlone(Document):
    u_K: Matrix
    u_U0: Vector


class Angles(Document, Generic[OneT]):
    """Between the rows of K, that is, between the sensitive axes."""

    xy: OneT
    xz: OneT
    yz: OneT


class OfBlock(Document, Generic[ThreeT, OneT, BiasT]):
    """What does not depend on how the block sits on the stand.

    scale: Of the lengths of the rows of K.
    bias_g: Of U0_i over the length of row i of K.
    """

    scale: ThreeT
    angle_rad: Angles[OneT]
    bias_g: BiasT


class Coverage(Document):
    """Effective degrees of freedom after Welch and Satterthwaite, and the factor k of Student's t, so that the truth is
    within k u with the probability. What the stand file declares counts as known.

    freedom_intrinsic: The same of the intrinsic parameters.
    """

    probability: Share
    freedom_K: tuple[Freedoms, Freedoms, Freedoms]
    freedom_U0: Freedoms
    k_K: tuple[Factors, Factors, Factors]
    k_U0: Factors
    freedom_intrinsic: OfBlock[Freedoms, Freedom, Freedoms] | None = None
    k_intrinsic: OfBlock[Factors, Factor, Factors] | None = None


class DeltaG(Document):
    """u_delta_g_g: Standard uncertainty of delta_g_g by the noise of the position's mean: no error of the stand changes
        the length of gravity. null where no noise is known.
    k_delta_g: Its coverage factor for the probability of coverage.
    """

    mounting: PlaceNumber
    position: PlaceNumber
    use: Use
    delta_g_g: float
    u_delta_g_g: Size | None = None
    k_delta_g: Size | None = None


class Closure(Document):
    mounting: PlaceNumber
    difference: Vector


class Verification(Document, kw_only=True):
    """The gravity check.

    delta_g_g: (|a|^2 - 1)/2 at every measured position, in g.
    max_abs_delta_g_fit_g: On positions used for the fit, where it is optimistic.
    max_abs_delta_g_check_g: On positions measured for this check only; null if there are none.
    closure: Outputs at the last position of a mounting less those at an earlier one of the same attitude.
    residual_rms: Root mean square of U - U0 - K a on the ideal geometry, per channel, over the fit positions less four,
        and one for each further term of the model; null where that leaves none.
    """

    delta_g_g: Annotated[tuple[DeltaG, ...], Meta(min_length=1)] = ()
    max_abs_delta_g_g: Size
    max_abs_delta_g_fit_g: Size | None = None
    max_abs_delta_g_check_g: Size | None = None
    limit_g: Positive
    passed: bool = field(name="pass")
    closure: tuple[Closure, ...] = ()
    residual_rms: Sizes | None = None


class YawChange(Document):
    mounting: int
    alpha3_difference_rad: float | None
    u_alpha3_difference_rad: Size | None


class SeenAngles(Document):
    """Angles of a stand as a run shows them, each with its standard uncertainty."""

    alpha1_rad: float | None
    u_alpha1_rad: Size | None
    alpha2_plus_alpha3_rad: float | None
    u_alpha2_plus_alpha3_rad: Size | None
    alpha3_difference_rad: float | None
    u_alpha3_difference_rad: Size | None


class Augmented(SeenAngles):
    """The angles by least squares for coefficients, angles and every set angle at once: sharper, and for any schedule.

    other_yaw_changes: From the third mounting on: yaw of the first less that of this one.
    """

    other_yaw_changes: tuple[YawChange, ...] = ()


class StandSeen(SeenAngles, kw_only=True):
    """The stand as the run shows it. alpha1: tilt of the axis; alpha2 + alpha3: zero of the table angle plus mean yaw
    of the block; alpha3_difference: yaw of mounting 1 less that of mounting 2; alpha4: error of a set angle;
    noise_v: standard deviation of one sample, in volts for outputs in V, mV, uV or kV, else in the unit of the
    outputs. u_: standard uncertainty.

    alpha4_rad: Of a set angle, from the residuals beyond the noise; null where they do not exceed it.
    noise_v_by_channel: That of x, y and z by itself, of a stand that declares three; with its u_ twin, else null.
        noise_v is then of all together, each beside its own, as in the channel that has most.
    u_from: Origin of the uncertainties of the angles: the declared stand, or the scatter and residuals of the run;
        null: unknown.
    u_freedom: Degrees of freedom of u_from run, for Student's t; null for a declared stand.
    alpha4_freedom: Degrees of freedom of alpha4.
    """

    alpha4_rad: float | None
    u_alpha4_rad: Size | None
    noise_v: Size | None
    u_noise_v: Size | None
    noise_v_by_channel: Vector | None = None
    u_noise_v_by_channel: Vector | None = None
    u_from: From | None
    u_freedom: Size | None
    alpha4_freedom: Size | None
    augmented: Augmented | None


class SiUnits(Document):
    K: str
    bias: Literal["m/s^2"]


class Si(Document, kw_only=True):
    """Coefficients for accelerations in m/s^2. Uncertainties include that of gravity; null where u_gravity_m_s2 or the
    stand is not told. scale: length of row i of K; bias: U0_i over the length of row i.
    """

    gravity_m_s2: Positive
    u_gravity_m_s2: Size | None
    units: SiUnits
    K: Matrix
    u_K: SizeMatrix | None = None
    scale: Vector | None = None
    u_scale: Sizes | None = None
    bias: Vector
    u_bias: Sizes | None = None


class Reference(Document):
    """The result less that of the independent numpy computation."""

    max_abs_difference_K: Size
    max_abs_difference_U0: Size
    difference_K: Matrix
    difference_U0: Vector


class Mean(Document):
    """scatter: Standard deviation of one sample; null for a lone row."""

    mounting: PlaceNumber
    position: PlaceNumber
    use: Use
    samples: AtLeastOne
    mean: Vector
    scatter: Sizes | None


class Temperature(Document):
    """Of the run, degrees Celsius, where the coefficients hold.

    source: The column temperature of the run file, or temperature_c of the environment.
    """

    min_c: Number
    max_c: Number
    source: ToldBy | None = None


class Table(Document):
    """How far the simulation's true table has turned since power-on."""

    at_rest: bool
    lowest_deg: float
    highest_deg: float


class OverTemperature(Document):
    """A simulated block at the temperature T.

    K: By powers of (T - `reference_c`) / 1 K, from 0 to 2; with `U0`.
    """

    reference_c: float
    K: Annotated[tuple[Matrix, ...], Meta(min_length=3, max_length=3)]
    U0: Annotated[tuple[Vector, ...], Meta(min_length=3, max_length=3)]


class Truth(Document):
    """What a simulated run was made of; angles are the errors of the stand.

    alpha3_rad: One per mounting.
    alpha4_rad: One per position.
    theta_h_rad: Seat, one per mounting; the platform's is in it.
    theta_n_rad: Seat, one per mounting.
    beta_rad: Of a block that is bolted on once: the inclinations, one per mounting, with their errors.
    tau_rad: Likewise: error of the zero of the table angle, one per mounting; alpha2 is not in it.
    encoder_rad: Where declared: errors by the sine and cosine of the table angle, and of its double.
    drift_v: Where declared: from the first fit position to the last.
    over_temperature: Of a block that changes with its temperature: `K` and `U0` above are those at its `reference_c`.
    """

    K: Matrix
    U0: Vector
    alpha1_rad: float
    alpha2_rad: float
    alpha3_rad: Annotated[tuple[float, ...], Meta(min_length=1)]
    alpha4_rad: Annotated[tuple[float, ...], Meta(min_length=1)]
    theta_h_rad: Annotated[tuple[float, ...], Meta(min_length=1)] = (0.0,)
    theta_n_rad: Annotated[tuple[float, ...], Meta(min_length=1)] = (0.0,)
    encoder_rad: Annotated[tuple[float, ...], Meta(min_length=4, max_length=4)] | UnsetType = UNSET
    drift_v: Annotated[tuple[float, ...], Meta(min_length=3, max_length=3)] | UnsetType = UNSET
    beta_rad: Annotated[tuple[float, ...], Meta(min_length=1)] | UnsetType = UNSET
    tau_rad: Annotated[tuple[float, ...], Meta(min_length=1)] | UnsetType = UNSET
    over_temperature: OverTemperature | UnsetType = UNSET


class Result(Document, kw_only=True):
    """U = U0 + K a: outputs U, specific force a in units of local gravity. Unknown is null, never NaN.

    created: When the result was made: UTC, ISO 8601; the second of `SOURCE_DATE_EPOCH` if the environment sets it.
        Otherwise null for a bench run in virtual time: the same seed gives the same bytes.
    tumble: The version that made the result.
    run_file: The solved file; null: unknown.
    run_sha256: SHA-256 of the run file, byte for byte; null: unknown.
    serial: Of the block, from the stand file; null: unknown.
    stand: As declared in its file, with the keys of `[stand]` and the step of its converter, `step_v` (null without
        one). Noise and drift in volts for V, mV, uV, kV, else in the outputs' unit. null: none is declared.
    schedule: The schedule of the run, with the tables of a [schedule file](#schedule-file-toml) and the `name` of a
        built-in one.
    estimator: The estimator of the coefficients.
    unit: Of the outputs, and of every value here whose name states no unit.
    units: Of the coefficients.
    K: Coefficients: row i is the response of channel i to acceleration along x, y, z, in the unit of the outputs per g.
    U0: Outputs at zero acceleration.
    u_K: Standard uncertainties (k = 1) of K; null without a stand file.
    u_U0: Standard uncertainties of U0; null without a stand file.
    covariance: Of the coefficients, `K` row by row, then `U0`, in the products of their units; the roots of its
        diagonal are `u_K` and `u_U0`, to 1e-9 of them (`optimal`: 1e-6); null without a stand file.
    u_norm_g: `worst_g`: standard uncertainty of the length of the calibrated acceleration, at the attitude where it is
        largest; `attitude`: that direction on the block's axes. [How](method.md#uncertainty)
    extended: For `--model`, else null: `terms`, and their values by channel, `k2_per_g`, `k3_per_g2`, `asymmetry`,
        `cross_per_g`, `drift_v` (over the whole run; `U0` refers to its middle), each with its `u_` twin; `covariance`
        of `K`, `U0` and `names`; `without`: `u_K`, `u_U0` and `u_norm_g` of the same run with twelve coefficients, and
        `u_norm_of_K_U0_g`; `max_abs_difference` from numpy. `drift_v` is in volts as `noise_v` is. `stand_seen`
        then has no angles. [How](method.md#more-coefficients)
    second_order: Whether the declared angles are small enough for these uncertainties, which are of first order: `bias`
        is the expected shift of every coefficient by squares of the angles, in its unit; `matters` is true if any
        exceeds 0.2 u; `shifts` lists those coefficients (`source` with the largest part, `coefficient`, `bias_relative`
        and `limit` over the scale factor of the row); `bias_K_xx_relative` = alpha3^2/2, the reduction of K_xx by a yaw
        in a linear estimate, and its `limit`; null without a stand file, and with a prior that is used.
        [How](method.md#what-the-linear-theory-leaves-out)
    monte_carlo: For `--monte-carlo`, else null: `runs`, `seed`, whether all `agrees`, and for every coefficient the
        mean error (`shift`), `u`, the 95 % `interval` and the `linear_interval`, their `difference`, its `tolerance`,
        and a `verdict` ("agrees", "differs", "cannot tell": too few runs). [How](method.md#of-one-result)
    misfit: `sqrt(chi2/dof)`: rms of the residuals over that expected from the declared stand, near 1 if the declaration
        is true; null without a stand file.
    fit: Does the run fit the declared stand? `chi2` of all residuals with `dof` degrees of freedom, `p`, `fits` at the
        `confidence` of `--confidence` (0.999), and `explanations` if it does not, or if it fits as a whole but shows a
        pattern at that confidence (a warning): `patterns` that this run cannot distinguish, the likeliest first, `p`
        after Holm, `size`, `u_size` in `unit` of its largest `column`. The same for every estimator; null without a
        stand file. [How](method.md#does-the-run-fit-its-stand)
    stand_doubts: The declared sources among the explanations (names as in `stand_seen`): worse than declared. The
        uncertainties are then too small, and a warning says so; null without a stand file.
    reliability: How large an error could stay hidden in the run: for every undeclared `pattern` the `size`, in `unit`,
        that its test finds in nine runs of ten, and `norm_error_g`, the resulting error of the length of a calibrated
        acceleration at the worst attitude; both null if no size is detectable. The largest error comes first; it is
        `reliability_norm_g`. null without a stand file. [How](method.md#what-a-run-could-not-have-shown)
    reliability_norm_g: The largest `norm_error_g` of `reliability`; null if none is known.
    passed: The [decision](method.md#the-decision-rule): gravity check passed, `fits`, and the uncertainty within the
        limit at every attitude. Without a stand file the gravity check alone.
    pass_reason: Why it did not pass: one or several of "gravity", "fit", "uncertainty", joined by " and ".
        "uncertainty" alone is the verdict NOT SHOWN.
    decision: `coverage_factor` (3, or that of `[accept]`) times `u_norm_worst_g` (null without a stand file) must be
        within `limit_g`; `scope` of the statement: "everywhere", without a stand file "measured positions".
    would_show: For a verdict NOT SHOWN, else null: what would show the limit, as a list of `change` ("estimator",
        "samples" at each position, "mountings", "inclinations": deg of the steepest, "stand": how many times better,
        "converter": the same of the converter too, whose rounding no samples average away), `to`, and `reach_g`, the
        coverage factor times the worst u(|a|) then.
    assumes: Names of the result's assumptions, which the run cannot test and the stand file does not declare. `seat`:
        that no mounting tilts the block against the axis, if neither `seat_rad` nor `platform_rad` is above 0 and no
        fit position shows such a tilt ([why](method.md#is-the-result-to-be-believed)); it affects the coefficients
        whose uncertainty a seat or a platform of 1e-4 rad would raise by a tenth. `linear`: that the block has no third
        order (or another one of its patterns), if the fit positions cannot separate it from the coefficients, as on the
        diagonals. `order`: that channels, mountings and the table's direction are as given, if K looks exchanged or
        reversed and no `[block]` is declared. `unit`: that outputs are in volts, if neither file nor `--unit` names a
        unit. `white_noise`: that noise is white, if no position has four samples. `undithered`: that rounding errors
        are independent, if all samples of a position round alike. `temperature`: that the block is used at the
        temperature of its run, if neither run file nor environment states it. `hands`: that faces lie as the schedule
        `hand_laid` has it, if no stand is declared. `growth`: that the block has changed no more than stated since the
        calibration that is its `prior`. `frame`: that K is in a frame of the block's own, if it comes from
        |a| alone.
    assumed_for: By name as in `assumes`: the coefficients that depend on it; an empty list: all. A table marks each of
        these (`*` seat, `^` linear).
    warnings: The warnings on stderr, in the same order; an empty list: none.
    noise: The measured noise, by channel: `scatter` of one sample; `of_means`, the scatter of white noise that would
        give the standard errors of the means; the blocks used for these (`block_samples`, `freedom`); `above_declared`,
        channels whose uncertainties use it instead of the declared noise; `undithered`.
        [How](method.md#noise-that-is-not-white)
    scatter_alone: Without a stand file: `u_K`, `u_U0` due to the noise of the samples alone, without any error of the
        stand; null with a stand file, and if no position has two samples.
    coverage: How well the standard uncertainties are known (those of `scatter_alone` without a stand file), and their
        coverage factors: effective degrees of freedom `freedom_K`, `freedom_U0`, where null is infinite (this u comes
        from declared values only), and `k_K`, `k_U0`, so that the truth lies within k u with `probability` 0.95 (for
        `scatter_alone`: by noise alone, without the errors of the stand); the same of the intrinsic parameters in
        `freedom_intrinsic`, `k_intrinsic`. null without uncertainties. [How](method.md#expanded-uncertainty)
    verification: `delta_g_g` per position, with its standard uncertainty `u_delta_g_g` by the noise of the position's
        mean (no error of the stand changes the length of gravity) and the coverage factor `k_delta_g` for 95 %, both
        null if no noise is known; the largest over all, over fit and over check positions, `limit_g`, `pass`,
        `closure`, `residual_rms`.
    stand_seen: The stand's errors estimated from the run, each with its `u_` twin; `noise_v` in volts for V, mV, uV,
        kV, else in the outputs' unit; `noise_v_by_channel` of x, y and z if the stand declares three, else null;
        `alpha4_rad` the standard deviation of set angles from the residuals, with `alpha4_freedom`, null if they do not
        exceed the noise; `u_from` the origin of the angles' uncertainties ("stand", "run", null), with `u_freedom` for
        Student's t; `augmented` the angles by the more precise fit.
    inclinations: For a block that is bolted on once, the estimated inclinations by `mounting`: the angle of the axis,
        `deg`, with its standard uncertainty `u_deg` (null without a stand file), and `zero_deg`, the zero of the table
        angle relative to that at the first one. [How](never-remounted.md)
    level_rad: The inclination at the first mounting that is set to 0, that is the level error of the axis; with
        `u_level_rad`.
    intrinsic: `scale` (lengths of the rows of K), `angle_rad` {xy, xz, yz} between these rows, `bias_g` (U0_i over the
        length of row i): independent of how the block is mounted.
    si: Coefficients for accelerations in m/s^2, if the environment has `gravity_m_s2`: `K`, `scale` (lengths of its
        rows), `bias` (`bias_g` times gravity), `u_K`, `u_scale` and `u_bias` including `u_gravity_m_s2`, null if that
        or the stand file is missing; `units`.
    u_intrinsic: Their standard uncertainties, same names; null without a stand file.
    reference: The result of the C core less that of numpy, and the largest differences; with a prior that is used, of
        numpy's two computations.
    means: Per measured position: samples, mean, scatter.
    counters: Rows, positions, blank and comment lines, columns ignored.
    item: From the stand file.
    environment: From the stand file.
    temperature: Of the run, in deg C: `min_c`, `max_c`, and their `source`: "run_file" (its column; of a bench run the
        frames of the block) or "environment"; null: unknown.
    set_angles: Where the stand file has a table of set angles that was used: when it was `learned` and `expires`, of
        how many `runs`, the standard uncertainty `u_rad` of its least certain mark, and the repeatability. `means` are
        then corrected by it, and `stand` has what is left in `angle_rad` and `level_rad`.
        [How](method.md#set-angles-that-are-known)
    prior: For `--prior`: the last calibration of the block, whether the run agrees with it, and what it brings.
        [How](method.md#with-the-last-calibration)
    seed: Of a run on the bench: the same seed and inputs give the same result and bus log, byte for byte.
    bus: Of a run on the bench.
    firmware: Of a run on the bench: where the firmware ran.
    table: Of a run on the bench: the true travel of the simulation's table since power-on.
    truth: The true values of a run on the bench.
    """

    schema: Literal["tumble.result/1"] = RESULT
    created: Annotated[str, exactly("[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}Z")] | None = None
    tumble: str | None = None
    run_file: str | None = None
    run_sha256: Annotated[str, exactly("[0-9a-f]{64}")] | None = None
    serial: str | None = None
    stand: DeclaredStand | None = None
    schedule: Schedule | None = None
    estimator: Annotated[str, exactly("[A-Za-z_][A-Za-z0-9_]*")]
    unit: Annotated[str, exactly(UNIT.pattern)]
    units: Units | UnsetType = UNSET
    K: Matrix
    U0: Vector
    u_K: SizeMatrix | None
    u_U0: Sizes | None
    covariance: Covariance | None = None
    u_norm_g: WorstNorm | None = None
    extended: Extended | None = None
    second_order: SecondOrder | None = None
    monte_carlo: MonteCarlo | None = None
    misfit: Size | None = None
    fit: Fit | None = None
    stand_doubts: tuple[Name, ...] | None = None
    reliability: tuple[Unseen, ...] | None = None
    reliability_norm_g: Size | None = None
    passed: bool = field(name="pass", default=UNSET)  # type: ignore[arg-type, assignment, unused-ignore]
    pass_reason: str | None = None
    decision: Decision | None = None
    would_show: tuple[Remedy, ...] | None = None
    assumes: tuple[Name, ...] = ()
    assumed_for: dict[Name, tuple[Name, ...]] = field(default_factory=dict)
    warnings: tuple[Annotated[str, Meta(min_length=1)], ...] | None = None
    noise: Noise | None = None
    scatter_alone: ScatterAlone | None = None
    coverage: Coverage | None = None
    verification: Verification
    stand_seen: StandSeen | UnsetType = UNSET
    inclinations: tuple[Inclination, ...] | UnsetType = UNSET
    level_rad: float | UnsetType = UNSET
    u_level_rad: Size | UnsetType | None = UNSET
    intrinsic: OfBlock[Sizes, Angle, Vector] | UnsetType = UNSET
    si: Si | None = None
    u_intrinsic: OfBlock[Sizes, Size, Sizes] | None = None
    reference: Reference | UnsetType = UNSET
    means: Annotated[tuple[Mean, ...], Meta(min_length=1)] = ()
    counters: dict[str, Count] = field(default_factory=dict)
    item: Labels | None = None
    environment: Labels | None = None
    temperature: Temperature | None = None
    set_angles: SetAngles | UnsetType = UNSET
    prior: Prior | UnsetType = UNSET
    seed: Count | UnsetType = UNSET
    bus: Annotated[str, exactly("(inprocess|uml|socketcan:[A-Za-z0-9._-]{1,15})")] | UnsetType = UNSET
    firmware: Firmware | UnsetType = UNSET
    table: Table | UnsetType = UNSET
    truth: Truth | UnsetType = UNSET

    def __post_init__(self) -> None:
        if (self.u_K is None) != (self.u_U0 is None):
            raise ValueError("u_K and u_U0 must be both known or both null")
        self.unit = spelled(self.unit)  # as runs have it now; older results have it as it was typed
        if not isinstance(self.passed, bool):
            self.passed = self.verification.passed
        require_usable(self.pass_reason, self.environment)


def require_usable(pass_reason: str | None, environment: Labels | None) -> None:
    """Raise ValueError for reasons that are none, and for a local gravity that is no number above 0."""
    told = () if pass_reason is None else pass_reason.split(" and ")
    if list(told) != [one for one in REASONS if one in told]:
        raise ValueError(f"pass_reason is {quoted(pass_reason)}")
    for key, least in (("gravity_m_s2", 1e-300), ("u_gravity_m_s2", 0.0)):
        size = (environment or {}).get(key, 1.0)
        if isinstance(size, str) or not least <= size < LARGEST:
            raise ValueError(f"environment.{key} is {quoted(size)}")


def read_result(file: str) -> Result:
    """Of a file. Raises BadInput."""
    return parse_result(read_bytes(file, RESULT_FILE), file)


def parse_result(data: bytes, file: str) -> Result:
    """As `read_result`, of what a `file` holds."""
    return read(Result, RESULT, data, file)
