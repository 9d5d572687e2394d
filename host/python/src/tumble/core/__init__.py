"""The firmware core, for Python: numpy arrays in and out, a refusal of the core as an exception.

No coefficient and no check is computed here: they come from the C functions that fly. Angles of a schedule become sines
and cosines here (`sine_cosine`). Arrays: `means` (positions, 3) in volts (or any unit, in which the coefficients then
come out), in the schedule's order; `measured` (positions,) bool; K (3, 3) in volts per g, row i = channel i; U0 (3,) in
volts. Rows of `means` that are not measured are never looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats, Integers
from tumble.schedule import CHECK, FIT, Mounting, Position, Schedule
from tumble.stand import COMMON, PER_CHANNEL, SOURCES, Stand, per_channel

if TYPE_CHECKING:
    from _tumble_core import CData


MAX_POSITIONS: int = lib.TUMBLE_MAX_POSITIONS
MAX_SAMPLES: int = lib.TUMBLE_MAX_SAMPLES
MAX_MOUNTINGS: int = lib.TUMBLE_MAX_MOUNTINGS
MAX_YAWS: int = lib.TUMBLE_MAX_YAWS  # mountings, where each has unknowns of its own
MAX_STAND_ERROR_RAD: float = lib.TUMBLE_MAX_STAND_ERROR_RAD  # beyond it nothing is linear
MAX_MEAN: float = lib.TUMBLE_MAX_MEAN_V
MIN_ROW_RATIO: float = lib.TUMBLE_MIN_ROW_RATIO
AXES = "xyz"

# TUMBLE_ESTIMATOR_LIST of tumble/core.h, as an array in binding/batch.c: by name what estimates and what states
# uncertainties, such as tumble_estimate_refined (firmware/core/closed_form.c); NULL for both where a gain record is
# needed.
ESTIMATOR_ROWS = {ffi.string(row.name).decode(): row for row in lib.estimator_rows}
LINEAR_ESTIMATORS = {name: row.estimate for name, row in ESTIMATOR_ROWS.items() if row.estimate}


class CoreRefusal(Exception):
    """The core returned a status other than TUMBLE_OK.

    `name`: such as "TUMBLE_E_RANK"; `sentence`: what that means; `details`: what else is known, by keyword:
    `where` (index of a mounting or position), `missing` (labels of positions), `unidentified` (names of coefficients).
    """

    def __init__(self, status: int, **details: Any):
        self.status = status
        self.name = ffi.string(lib.tumble_status_name(status)).decode()
        self.sentence = ffi.string(lib.tumble_status_sentence(status)).decode()
        self.details = details
        super().__init__(self.sentence)


@dataclass(frozen=True)
class GravityCheck:
    """Formula (8) at every position. `delta_g` (positions,) in g, NaN where not measured; maxima None if none of that
    kind was judged."""

    delta_g: Floats
    max_abs_fit: float | None
    max_abs_check: float | None
    passed: bool


@dataclass(frozen=True)
class Intrinsic:
    """What does not depend on how the block sits on the stand: `scale` (3,) V/g, cosines of the angles between the
    sensitive axes xy, xz, yz (3,), `bias` (3,) in g."""

    scale: Floats
    cosines: Floats
    bias: Floats

    @property
    def angles(self) -> Floats:
        """The angles (3,) in radians: the core has no arc cosine."""
        return np.arccos(np.clip(self.cosines, -1.0, 1.0))


def require_ok(status: int, **details: Any) -> None:
    """Raise CoreRefusal unless `status` is TUMBLE_OK."""
    if status != lib.TUMBLE_OK:
        raise CoreRefusal(status, **details)


@lru_cache(1024)
def sine_cosine(angle_deg: float) -> tuple[float, float]:
    """Sine and cosine of an angle in degrees, correctly rounded at every multiple of 30 and 45 degrees.

    Degrees are reduced exactly before anything is turned into radians, so -315, 45 and 405 give the same bits.
    """
    if not math.isfinite(angle_deg):
        return math.nan, math.nan
    angle = math.fmod(angle_deg, 360.0)
    quarter = round(angle / 90.0)
    sine, cosine = _sine_cosine_within_45(angle - 90.0 * quarter)
    turned = [(sine, cosine), (cosine, -sine), (-sine, -cosine), (-cosine, sine)][quarter % 4]
    return turned[0] + 0.0, turned[1] + 0.0  # no negative zeros


def _sine_cosine_within_45(rest_deg: float) -> tuple[float, float]:
    half, root_half, root_three_quarters = 0.5, math.sqrt(0.5), math.sqrt(0.75)
    exact = {0.0: (0.0, 1.0), 30.0: (half, root_three_quarters), 45.0: (root_half, root_half)}
    if abs(rest_deg) in exact:
        sine, cosine = exact[abs(rest_deg)]
        return math.copysign(sine, rest_deg), cosine
    return math.sin(math.radians(rest_deg)), math.cos(math.radians(rest_deg))


def _angle(angle_deg: float) -> dict[str, Any]:
    sine, cosine = sine_cosine(angle_deg)
    return {"deg": angle_deg, "sine": sine, "cosine": cosine}


def _coefficient_names(bits: int) -> list[str]:
    """Names of the coefficients in a mask of unknowns: bits 0 to 2 for K_ix, K_iy, K_iz, bit 3 for U0_i."""
    columns = [f"K_{{}}{axis}" for axis in AXES] + ["U0_{}"]
    return [column.format(axis) for bit, column in enumerate(columns) if bits >> bit & 1 for axis in AXES]


class CoreSchedule:
    """A schedule in the core's own memory, validated. Immutable; may be used by several estimations at once.

    Raises CoreRefusal(where=index of the mounting or position at fault) when the core does not accept it.
    """

    def __init__(self, schedule: Schedule, name: str | None = None):
        """`name`: of a built-in schedule, where it is one."""
        self.data, self.name = schedule, name
        self._mountings = ffi.new(
            "tumble_mounting_t[]",
            [
                {"number": m.number, "matrix": m.matrix, "tilt": _angle(m.tilt_deg), "bolting": m.bolting or 0}
                for m in schedule.mountings
            ],
        )
        self._positions = ffi.new("tumble_position_t[]", [self._position(p) for p in schedule.positions])
        counts = [min(len(rows), 255) for rows in (schedule.mountings, schedule.positions)]
        self.struct = ffi.new("tumble_schedule_t *", [self._mountings, self._positions, *counts])
        where = ffi.new("uint8_t *")
        require_ok(lib.tumble_schedule_validate(self.struct, where), where=where[0])

    @classmethod
    def built_in(cls, name: str) -> CoreSchedule:
        """The core's own schedule of that name."""
        return cls(built_in(name), name)

    @staticmethod
    def _position(position: Position) -> dict[str, Any]:
        use = lib.TUMBLE_USE_FIT if position.use == FIT else lib.TUMBLE_USE_CHECK
        angle = _angle(position.angle_deg)
        return {"mounting": position.mounting, "number": position.number, "use": use, "angle": angle}

    def __len__(self) -> int:
        return len(self.data.positions)

    def part(self, measured: Flags) -> CoreSchedule:
        """The schedule without the positions that a run does not have."""
        return self if measured.all() else CoreSchedule(self.data.part(measured))

    def identify(self, measured: Flags | None = None) -> None:
        """Raise CoreRefusal(unidentified=names) unless the (measured) fit positions identify all coefficients."""
        bits = ffi.new("uint8_t *")
        status = lib.tumble_schedule_identify(self.struct, self.flags(measured), bits)
        require_ok(status, unidentified=_coefficient_names(bits[0]))

    def harmonic(self, measured: Flags | None = None) -> None:
        """Raise CoreRefusal(missing=labels of positions) unless the closed forms of averaged and refined apply."""
        harmonic_map, bits = ffi.new("tumble_harmonic_map_t *"), ffi.new("uint64_t *")
        status = lib.tumble_schedule_harmonic(self.struct, self.flags(measured), harmonic_map, bits)
        require_ok(status, missing=self.labels(bits[0]))

    def inclinations(self, measured: Flags | None = None) -> int:
        """How many the closed form of `inclined` has. Raises CoreRefusal(missing=labels of positions) unless it
        applies."""
        of, bits = ffi.new("tumble_inclined_map_t *"), ffi.new("uint64_t *")
        status = lib.tumble_schedule_inclinations(self.struct, self.flags(measured), of, bits)
        require_ok(status, missing=self.labels(bits[0]))
        return int(of.count)

    def labels(self, bits: int) -> list[str]:
        """The labels of the positions with these bits, each by its index."""
        return [self.data.positions[index].label for index in _set_bits(bits)]

    def flags(self, measured: Flags | None) -> CData:
        """One flag per position as the core has them; null for None. Raises ValueError for another number of them."""
        if measured is None:
            return ffi.NULL
        flags = np.ascontiguousarray(measured, dtype=bool)
        if flags.shape != (len(self),):
            raise ValueError(f"measured must have shape ({len(self)},), not {flags.shape}")
        return ffi.from_buffer("bool[]", flags)

    def means(self, means: Floats, measured: Flags | None = None) -> CData:
        """The core's structure of means, filled. Raises ValueError for arrays of another shape."""
        values = np.ascontiguousarray(means, dtype=float)
        if values.shape != (len(self), 3):
            raise ValueError(f"means must have shape ({len(self)}, 3), not {values.shape}")
        struct = ffi.new("tumble_means_t *")
        ffi.memmove(struct.u_v, ffi.from_buffer(values), values.nbytes)
        flags = self.flags(np.ones(len(self), dtype=bool) if measured is None else measured)
        ffi.memmove(struct.measured, flags, len(self))
        return struct


def _set_bits(bits: int) -> list[int]:
    return [bit for bit in range(bits.bit_length()) if bits >> bit & 1]


def built_in(name: str) -> Schedule:
    """A schedule of tumble.schedule.BUILT_IN as the core holds it."""
    held = getattr(lib, f"tumble_schedule_{name}")
    mountings = [held.mountings[m] for m in range(held.mounting_count)]
    positions = [held.positions[p] for p in range(held.position_count)]
    return Schedule(
        tuple(Mounting(m.number, tuple(map(tuple, m.matrix)), m.tilt.deg, m.bolting or None) for m in mountings),
        tuple(Position(p.mounting, p.number, p.angle.deg, CHECK if p.use else FIT) for p in positions),
    )


def paper_schedule() -> Schedule:
    """The default schedule as the core holds it: the paper's two mountings of nine positions."""
    return built_in("paper")


def pack(k: Floats, u0: Floats) -> CData:
    """K and U0 as the core has them."""
    values = np.concatenate([np.asarray(k, dtype=float).ravel(), np.asarray(u0, dtype=float).ravel()])
    if values.shape != (lib.TUMBLE_COEFFICIENTS,):
        raise ValueError("K must have shape (3, 3) and U0 shape (3,)")
    struct = ffi.new("tumble_coefficients_t *")
    ffi.memmove(struct, ffi.from_buffer(values), values.nbytes)
    return struct


def unpack(struct: CData) -> tuple[Floats, Floats]:
    """K and U0 of a tumble_coefficients_t."""
    values = np.frombuffer(ffi.buffer(struct)).copy()
    return values[:9].reshape(3, 3), values[9:]


def estimate(
    schedule: CoreSchedule, means: Floats, measured: Flags | None = None, estimator: str = "refined"
) -> tuple[Floats, Floats]:
    """K and U0 by one of estimators.LINEAR. Raises CoreRefusal(missing=..., unidentified=...)."""
    coefficients, refusal = ffi.new("tumble_coefficients_t *"), ffi.new("tumble_refusal_t *")
    status = LINEAR_ESTIMATORS[estimator](schedule.struct, schedule.means(means, measured), coefficients, refusal)
    require_estimable(schedule, status, refusal)
    return unpack(coefficients)


def inclined_runs(schedule: CoreSchedule, means: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """Of means (runs, positions, 3), all measured, of a block bolted on once: coefficients (runs, 12), and of every
    inclination its angle beta and the zero tau of its table angle (runs, inclinations), rad. `weights` (3,) of the
    channels, best in proportion to 1 / noise. Raises CoreRefusal(run=index) at the first run refused."""
    means, found, where = _arrays(schedule, means)
    count = schedule.inclinations()
    seen = np.empty((len(means), ffi.sizeof("tumble_inclinations_t") // 8))
    given = np.ascontiguousarray(weights, dtype=float)
    pointers = [ffi.from_buffer("double[]", array) for array in (means, given, found, seen)]
    status = lib.batch_inclined(schedule.struct, len(means), *pointers, where)
    require_ok(status, run=where[0])
    sine, cosine, turn_sine, turn_cosine = np.moveaxis(seen.reshape(len(means), 4, -1)[..., :count], 1, 0)
    return found, np.arctan2(sine, cosine), np.arctan2(turn_sine, turn_cosine)


def require_estimable(schedule: CoreSchedule, status: int, refusal: CData) -> None:
    """Raise CoreRefusal(missing=..., unidentified=...) unless `status` is TUMBLE_OK; `refusal`: a tumble_refusal_t."""
    if status != lib.TUMBLE_OK:
        missing, unidentified = schedule.labels(refusal.missing), _coefficient_names(refusal.unidentified)
        raise CoreRefusal(status, missing=missing, unidentified=unidentified)


class Calibration:
    """Coefficients turned round: a = K^-1 (U - U0). Raises CoreRefusal when K is singular or not finite."""

    def __init__(self, k: Floats, u0: Floats):
        self.struct = ffi.new("tumble_calibration_t *")
        require_ok(lib.tumble_calibration_invert(pack(k, u0), self.struct))


def intrinsic(k: Floats, u0: Floats) -> Intrinsic:
    """Scales, cosines between the axes and biases. Raises CoreRefusal for a row of K that is (nearly) zero."""
    found = ffi.new("tumble_intrinsic_t *")
    require_ok(lib.tumble_calibration_intrinsic(pack(k, u0), found))
    cosines = np.array([found.cosine_xy, found.cosine_xz, found.cosine_yz])
    return Intrinsic(np.array(list(found.scale_v_per_g)), cosines, np.array(list(found.bias_g)))


def gravity_check(
    schedule: CoreSchedule, means: Floats, measured: Flags | None, calibration: Calibration, limit_g: float
) -> GravityCheck:
    """Judge every measured position by formula (8). `limit_g` finite and above 0. Raises CoreRefusal."""
    check, struct = ffi.new("tumble_gravity_check_t *"), schedule.means(means, measured)
    require_ok(lib.tumble_gravity_check(schedule.struct, struct, calibration.struct, limit_g, check))
    judged = np.frombuffer(ffi.buffer(check.delta_g_g), count=len(schedule))
    delta_g = np.where(np.ones(len(schedule), bool) if measured is None else measured, judged, np.nan)
    max_abs_fit = check.max_abs_fit_g if check.fit_positions else None
    max_abs_check = check.max_abs_check_g if check.check_positions else None
    return GravityCheck(delta_g, max_abs_fit, max_abs_check, getattr(check, "pass"))


def closure(schedule: CoreSchedule, means: Floats, measured: Flags | None, mounting: int) -> Floats | None:
    """Outputs (3,) at the last measured position of a mounting less those at an earlier one of the same attitude;
    None when the mounting has no such pair."""
    difference = np.empty(3)
    struct = schedule.means(means, measured)
    status = lib.tumble_closure(schedule.struct, struct, mounting, ffi.from_buffer("double[]", difference))
    if status == lib.TUMBLE_E_MISSING_POSITION:
        return None
    require_ok(status)
    return difference


def residual_rms(schedule: CoreSchedule, means: Floats, measured: Flags | None, k: Floats, u0: Floats) -> Floats | None:
    """Root mean square (3,) of the residuals of the fit positions; None with fewer than five of them."""
    rms, struct = np.empty(3), schedule.means(means, measured)
    status = lib.tumble_residual_rms(schedule.struct, struct, pack(k, u0), ffi.from_buffer("double[]", rms))
    if status == lib.TUMBLE_E_TOO_FEW:
        return None
    require_ok(status)
    return rms


_BEFORE_NUMBERS, _HEAD, _SIGMA_MEAN = 24, 26, 13  # of a gain record: bytes; numbers before the gains; one of them


class GainRecord:
    """A gain record (docs/files.md) opened by the core for one schedule. Raises CoreRefusal."""

    def __init__(self, schedule: CoreSchedule, record: bytes):
        self.schedule = schedule
        self._memory = ffi.new("double[]", (len(record) + 7) // 8)  # aligned as the record demands
        ffi.memmove(self._memory, record, len(record))
        opened = ffi.new("const tumble_gain_record_t **")
        require_ok(lib.tumble_gain_record_open(self._memory, len(record), schedule.struct, opened))
        self.struct = opened[0]

    def numbers(self) -> Floats:
        """K, the prior, the noise and the uncertainties (26 numbers), then all gains: in place."""
        return np.frombuffer(ffi.buffer(self._memory), offset=_BEFORE_NUMBERS)[:-1]  # the last: zero and CRC


def estimate_runs(schedule: CoreSchedule, means: Floats, estimator: str) -> Floats:
    """Coefficients (runs, 12), K row by row, then U0, of means (runs, positions, 3), all measured, by one of
    estimators.LINEAR. Raises CoreRefusal(run=index) at the first run refused."""
    means, found, where = _arrays(schedule, means)
    pointers = ffi.from_buffer("double[]", means), ffi.from_buffer("double[]", found)
    status = lib.batch_estimate(LINEAR_ESTIMATORS[estimator], schedule.struct, len(means), *pointers, where)
    require_ok(status, run=where[0])
    return found


def optimal_runs(record: GainRecord, means: Floats) -> tuple[Floats, Floats]:
    """As estimate_runs, by `optimal`: coefficients (runs, 12) and the stand's errors (runs, 2 + mountings): alpha1,
    alpha2, alpha3 by mounting, rad."""
    means, found, where = _arrays(record.schedule, means)
    stand = np.empty((len(means), ffi.sizeof("tumble_stand_errors_t") // 8))
    pointers = [ffi.from_buffer("double[]", array) for array in (means, found, stand)]
    status = lib.batch_optimal(record.struct, record.schedule.struct, len(means), *pointers, where)
    require_ok(status, run=where[0])
    return found, stand[:, : 2 + record.struct.mountings]


@dataclass(frozen=True)
class Gains:
    """Tables of many runs: `k` (runs, 3, 3) that each was made at, `sigma_mean` (runs,) and `weights` (runs, 3) of the
    channels, `gains` (runs, 12, 3 x fit positions) and `stand_gains`, rows as in a gain record."""

    k: Floats
    sigma_mean: Floats
    weights: Floats
    gains: Floats
    stand_gains: Floats


def optimal_each(record: GainRecord, means: Floats, tables: Gains) -> Floats:
    """As optimal_runs, but each run by its own table, of finite numbers: coefficients (runs, 12). The tables take turns
    in the memory of `record`, which the core has checked and which lends the rest; nobody else sees them, so they get
    no checksum. Raises CoreRefusal(run=index)."""
    means, found, where = _arrays(record.schedule, means)
    stand = np.empty(ffi.sizeof("tumble_stand_errors_t") // 8)
    parts = [tables.gains.reshape(len(means), -1), tables.stand_gains.reshape(len(means), -1)]
    numbers, into = np.concatenate(parts, axis=1), record.numbers()
    gains = slice(_HEAD, _HEAD + numbers.shape[1])
    of_channels = into[gains.stop + (record.struct.inclinations > 0) :]  # three, or none where they are alike
    pointers = [ffi.from_buffer("double[]", array) for array in (means, found)]
    spare, columns = ffi.from_buffer("double[]", stand), means[0].size
    for run, (k, sigma_mean) in enumerate(zip(tables.k.reshape(-1, 9), tables.sigma_mean)):
        into[:9], into[_SIGMA_MEAN], into[gains] = k, sigma_mean, numbers[run]
        of_channels[:] = tables.weights[run, : len(of_channels)] ** 2
        here = pointers[0] + run * columns, pointers[1] + run * lib.TUMBLE_COEFFICIENTS
        status = lib.batch_optimal(record.struct, record.schedule.struct, 1, *here, spare, where)
        require_ok(status, run=run)
    return found


def _arrays(schedule: CoreSchedule, means: Floats) -> tuple[Floats, Floats, CData]:
    means = np.ascontiguousarray(means, dtype=float)
    if means.ndim != 3 or means.shape[1:] != (len(schedule), 3):
        raise ValueError(f"means must have shape (runs, {len(schedule)}, 3), not {means.shape}")
    return means, np.empty((len(means), lib.TUMBLE_COEFFICIENTS)), ffi.new("size_t *")


def record_of(stand: Stand, least_noise: float = 0.0) -> Any:
    """The declared stand as the core takes it; the noise of a mean never counts as less than `least_noise`."""
    angles = [source for source in SOURCES.values() if source.is_angle and not source.of_inclinations]
    numbers: dict[str, Any] = {source.key: stand.sigma(source.attribute) for source in angles}
    for source in PER_CHANNEL:
        sigma = per_channel(stand.sigmas(source))
        numbers[f"channel_{source}_v" if isinstance(sigma, tuple) else f"{source}_v"] = sigma
    labels = {"least_noise_v": least_noise, "samples": stand.samples, "common_yaw": stand.remounting == COMMON}
    return ffi.new("tumble_stand_record_t *", numbers | labels)


class JudgedRun:
    """A run as the core has it; keeps what the structure points at."""

    def __init__(
        self,
        schedule: CoreSchedule,
        k: Floats,
        stand: Stand,
        samples: Integers,
        measured: Flags | None,
        mean_variance: Floats | None = None,
        least_noise: float = 0.0,
        at: tuple[Any, Any] = (ffi.NULL, ffi.NULL),
        weights: Floats | None = None,
    ):
        """`at`: an attitude, double[3], and where u(|a|) there is to be written, double *; `weights` (3,) of the
        channels, as `inclined` takes them."""
        averaged_over = stand.averaged_over(samples)
        self._stand = record_of(stand, least_noise)
        self._coefficients = pack(k, np.zeros(3))
        self._samples = ffi.new("uint32_t[]", averaged_over.tolist())
        self._flags = schedule.flags(measured)
        self._weights = ffi.NULL if weights is None else ffi.new("double[3]", weights.tolist())
        self._excess = ffi.NULL
        if mean_variance is not None:
            declared = np.maximum(stand.mean_variance(samples), least_noise**2)
            self._excess = ffi.from_buffer(np.maximum(mean_variance - declared, 0.0))
        self.struct = ffi.new(
            "tumble_judged_run_t *",
            {
                "schedule": schedule.struct,
                "stand": self._stand,
                "coefficients": self._coefficients,
                "measured": self._flags,
                "samples": self._samples,
                "excess_variance_v2": ffi.cast("double (*)[3]", self._excess),
                "attitude": at[0],
                "norm_g": at[1],
                "weights": self._weights,
            },
        )


def uncertainties(
    schedule: CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    measured: Flags | None = None,
    mean_variance: Floats | None = None,
    weights: Floats | None = None,
) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of an estimate by an estimator of the core that needs no stand.

    `k` (3, 3): the solved K; `samples` (positions,): rows of the run at each position, as Stand.averaged_over takes
    them; `measured` (positions,) bool; `mean_variance` (positions, 3): by the noise as measured, counts
    where it is larger than the stand's; `weights` (3,) of the channels for `inclined`, whose schedule has the
    inclinations that the run shows. Raises CoreRefusal(missing=..., unidentified=...).
    """
    run = JudgedRun(schedule, k, stand, samples, measured, mean_variance, weights=weights)
    found, refusal = ffi.new("tumble_uncertainty_t *"), ffi.new("tumble_refusal_t *")
    require_estimable(schedule, ESTIMATOR_ROWS[estimator].uncertainty(run.struct, found, refusal), refusal)
    return unpack(found)


def gain_table(gains: Floats, stand: Stand) -> Any:
    """It does not keep the gains."""
    inclination = 0.0 if math.isinf(stand.inclination) else stand.sigma("inclination")
    return ffi.new("tumble_gain_table_t *", [ffi.from_buffer("double[]", gains), gains.shape[1] // 3, inclination])


def uncertainties_of_gains(
    schedule: CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    gains: Floats,
    measured: Flags | None = None,
    mean_variance: Floats | None = None,
    least_noise: float = 0.0,
) -> tuple[Floats, Floats]:
    """The same for an estimate by constant gains (12, 3 x fit positions). The noise of a mean never counts as less than
    `least_noise`. Raises CoreRefusal."""
    table = np.ascontiguousarray(gains, dtype=float)
    if table.ndim != 2 or table.shape[0] != lib.TUMBLE_COEFFICIENTS or table.shape[1] % 3:
        raise ValueError(f"gains must have shape (12, 3 x fit positions), not {table.shape}")
    run = JudgedRun(schedule, k, stand, samples, measured, mean_variance, least_noise)
    found = ffi.new("tumble_uncertainty_t *")
    struct = gain_table(table, stand)
    require_ok(lib.tumble_uncertainty_gains(struct, run.struct, found))
    return unpack(found)
