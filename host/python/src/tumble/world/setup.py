"""What a bench run is to be, the scenario that tells the simulated world so, and the gain record of `optimal`.

A scenario has one `key = value` a line; `tumble bench --keys` lists them. What a stand file leaves out is left to the
program's own defaults.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tumble.core import CoreSchedule, sine_cosine
from tumble.defaults import DEFAULT_COVERAGE_FACTOR, DEFAULT_ESTIMATOR, DEFAULT_LIMIT_G, UNDECLARED_RAD
from tumble.errors import BadInput, UsageError, quoted
from tumble.files.stand_file import StandFile, converter_step_v
from tumble.model.optimal import optimal_table
from tumble.schedule import Mounting, Position, Schedule
from tumble.solving.optimal_run import Known, record_of, require_declared_inclinations, to_bytes
from tumble.stand import (
    COMMON,
    INDEPENDENT,
    LIMIT_KINDS,
    PAPER_STAND,
    SOURCES,
    PerChannel,
    Stand,
    by_channel,
    over,
    per_channel,
)
from tumble.terms import Terms

_MOST_BITS = 24
_REMEMBERED = 16  # schedules: worlds by the hundred have the same one
_RATES_HZ = (1.0, 1000.0)
_MOTION = {  # by key of [motion]: key of the scenario, least, most
    "velocity_deg_per_s": ("motion.speed_deg_s", 0.1, 1e4),
    "acceleration_deg_per_s2": ("motion.acceleration_deg_s2", 0.1, 1e5),
    "settling_s": ("motion.settling_s", 0.0, 4.095),  # less than a turn of the block's timestamp
}
_BIAS_G = 0.05  # drawn biases lie within this: the same share of every block's range
_USUAL_MOTION = {"velocity_deg_per_s": 90.0, "acceleration_deg_per_s2": 180.0, "settling_s": 0.5}
_USUAL_CABLE_DEG = (-30.0, 400.0)
_CABLE_SLACK_DEG = 30.0
_LONGEST_MS = 2**32 - 1
BY_OPTION = {  # keys of a scenario that the check of the result has to know of: option, and what else World takes it by
    "mounting": ("--schedule", "schedule"),
    "position": ("--schedule", "schedule"),
    "procedure.estimator": ("--estimator", None),
    "procedure.samples": ("--samples", None),
    "procedure.error_budget_v": ("--error-budget", None),
    "procedure.gravity_limit_g": ("--limit", None),
    "block.converter_bits": ("--block", "[block] of the stand"),
    "block.range_v": ("--block", "[block] of the stand"),
}
_REPEATED = ("fault", "profile.receive_pdo", "profile.transmit_pdo", "profile.write", "drive.lacks")
_DECLARED = {  # keys by which a scenario declares a stand to the firmware: fields of Stand
    **{f"stand.{one.key}": one.attribute for one in SOURCES.values() if one.attribute != "noise"},
    "block.noise_v": "noise",
}
_USUAL_BLOCK = {"scale_v_per_g": -2.0, "misalignment_rad": 0.02}  # the program's own, where no file describes a block
_FEWEST_SAMPLES = 16  # before which the procedure does not look at an error budget
_MOST = 1e6  # times the budget that one sample's noise counts as, at most
_USUAL_CONVERTER = {"converter_bits": 24, "range_v": 10.0}  # where the file leaves it open


@dataclass(frozen=True)
class Setup:
    """A bench run. `block`, `truth`, `motion`: as of a stand file, None: the program's own; `block_file` and
    `stand_file` are named in complaints. `limit_g`: of the gravity check, g.
    `error_budget_v`: standard error of a mean that ends averaging before `samples`; 0: it does not. `terms`: further
    ones of the model, to be found once the firmware is done. `coverage_factor`: of the decision rule."""

    seed: int
    stand: Stand
    block: dict[str, Any] | None
    truth: dict[str, Any] | None
    motion: dict[str, float] | None
    schedule: CoreSchedule
    samples: int
    estimator: str
    limit_g: float
    error_budget_v: float = 0.0
    stand_file: str = ""
    block_file: str = ""
    terms: Terms = ()
    coverage_factor: float = DEFAULT_COVERAGE_FACTOR


def setup_of(
    seed: int,
    file: StandFile | None,
    schedule: CoreSchedule,
    samples: int | None = None,
    limit_g: float | None = None,
    **others: Any,
) -> Setup:
    """What a stand file says, or the paper's stand; `samples` and `limit_g` where they are told; `others`: fields of
    Setup."""
    stand = PAPER_STAND if file is None else file.stand
    samples = stand.samples if samples is None else samples
    if limit_g is None:
        limit_g = DEFAULT_LIMIT_G if file is None or file.delta_g_limit_g is None else file.delta_g_limit_g
    told = {
        "block": None if file is None else file.block,
        "truth": None if file is None else file.truth,
        "motion": None if file is None else file.motion,
        "estimator": DEFAULT_ESTIMATOR,
        "coverage_factor": DEFAULT_COVERAGE_FACTOR if file is None else file.decided_by,
        **others,
    }
    stand = replace(stand, samples=samples)
    return Setup(seed=seed, stand=stand, schedule=schedule, samples=samples, limit_g=limit_g, **told)


def scenario_text(setup: Setup, file: str | None = None, given: bytes | None = None, told: Sequence[str] = ()) -> str:
    """The scenario file, in which the lines of another one, `given`, win over those of the setup, and those that are
    `told` one by one over both. Raises BadInput for what can be declared but not simulated, and for lines in whose
    place there is an option; UsageError for one that is told and is none."""
    schedule = setup.schedule.data
    pairs = [*_stand(setup.stand, schedule.is_inclined), *_block(setup), *_motion(setup), *_procedure(setup)]
    pairs += _schedule(schedule)
    own = [*(f"{key} = {value}" for key, value in pairs), *_serial(setup.block)]
    lines = own if file is None or given is None else _overridden(own, file, given)
    if told:
        keys = {_told_key(line) for line in told}
        lines = [*("" if _key(line) in keys else line for line in lines), *told]
    return "".join(f"{line}\n" for line in lines)


def as_declared(setup: Setup, lines: Sequence[str]) -> Setup:
    """The setup with the stand that the `lines` of a scenario declare to the firmware, in place of the stand file's:
    the result is confirmed by the same. What cannot be simulated is left for the program to refuse."""
    own = set(scenario_text(setup).splitlines())
    pairs = (line.partition("=") for line in lines if line not in own)
    told = {key.strip(): value.strip() for key, _, value in pairs}
    limits = told.get("stand.limits", setup.stand.limits)
    noise_limits = told.get("block.noise_limits", setup.stand.limits)
    remounting = told.get("stand.remount", setup.stand.remounting)
    if {limits, noise_limits} - {*LIMIT_KINDS} or remounting not in (INDEPENDENT, COMMON):
        return setup
    try:
        changed: dict[str, Any] = {one: _sizes(told[key]) for key, one in _DECLARED.items() if key in told}
    except ValueError:
        return setup
    stand = replace(setup.stand, limits=limits, remounting=remounting, **changed)
    if noise_limits != limits:
        per_limit = replace(stand, limits=noise_limits).limits_over_sigma / stand.limits_over_sigma
        stand = replace(stand, noise=over(stand.noise, per_limit))
    return replace(setup, stand=stand)


def _sizes(text: str) -> PerChannel:
    """One number or three. Raises ValueError."""
    first, *others = map(float, text.split() or [text])
    if not others:
        return first
    second, third = others
    return first, second, third


def _overridden(own: list[str], file: str, given: bytes) -> list[str]:
    """The file's lines come first: then a line number of a complaint is the file's. Those that say the same as `own`,
    as in inputs/ of an earlier run, are left out."""
    lines, keys = [], set()
    for row, line in enumerate(_scenario_lines(file, given), start=1):
        key = _key(line)
        same = line in own
        if key in BY_OPTION and not same:
            raise BadInput(f"{key} is given by {BY_OPTION[key][0]}", file, row)
        keys |= set() if same else {key}
        lines.append("" if same else line)
    return [*lines, *(line for line in own if _key(line) not in keys)]


def _told_key(line: str) -> str:
    """Of KEY=VALUE; lines that may repeat have none, as they add."""
    key, equals, _ = line.partition("=")
    key = key.strip()
    if not equals or not key or not line.isascii() or not line.isprintable():
        raise UsageError(f"--set: {quoted(line)} is not KEY=VALUE")
    if key in BY_OPTION:
        raise UsageError(f"--set: {key} is given by {BY_OPTION[key][0]}")
    return "" if key in _REPEATED else key


def _key(line: str) -> str:
    return line.partition("=")[0].strip()


def _scenario_lines(file: str, given: bytes) -> Iterator[str]:
    """Without what stands in comments, which may be in any language."""
    for row, line in enumerate(given.split(b"\n"), start=1):
        text = line.strip()
        if not text.isascii() and not text.startswith(b"#"):
            raise BadInput("is not ASCII text", file, row)
        yield "" if text.startswith(b"#") else text.decode("ascii")


def _serial(block: dict[str, Any] | None) -> Iterator[str]:
    """The block's, for a computer that keeps coefficients: a word there, not any text as in a stand file."""
    serial = (block or {}).get("serial")
    if serial is None:
        return
    if re.fullmatch("[!-~]{1,24}", serial) is None:
        yield "# keeper.serial: the stand file's is no word of at most 24 ASCII characters"
    else:
        yield f"keeper.serial = {serial}"


def _numbers(*values: float) -> str:
    """With as many digits as it takes to read back the same bits."""
    return " ".join(map(repr, map(float, values)))


def _per_channel(value: PerChannel) -> str:
    return _numbers(*np.atleast_1d(value).tolist())


def _stand(stand: Stand, is_inclined: bool) -> Iterator[tuple[str, str]]:
    for source in SOURCES.values():
        size = getattr(stand, source.attribute)
        if source.is_angle and not source.of_inclinations and (source.required or size > 0.0):
            yield f"stand.{source.key}", _numbers(size)
    inclination = stand.inclination
    if is_inclined and math.isinf(inclination):  # nobody sets it well
        inclination = UNDECLARED_RAD * stand.limits_over_sigma
    if 0.0 < inclination < math.inf:
        yield "stand.inclination_rad", _numbers(inclination)
    if stand.declares_drift:
        yield "stand.drift_v", _per_channel(stand.drift)
    yield "stand.limits", stand.limits
    yield "stand.remount", stand.remounting
    yield "block.noise_v", _numbers(*by_channel(stand.noise).tolist())
    yield "block.noise_limits", stand.limits


def _block(setup: Setup) -> Iterator[tuple[str, str]]:
    block = setup.block
    if block is not None:
        yield "block.scale_v_per_g", _per_channel(block["scale_v_per_g"])
        yield "block.bias_v", _per_channel(per_channel(_BIAS_G * np.abs(by_channel(block["scale_v_per_g"]))))
        yield "block.misalignment_rad", _numbers(block["misalignment_rad"])
        if block["converter_bits"] is not None:
            _require(block["converter_bits"], 8, _MOST_BITS, "[block] converter_bits", setup.block_file)
            yield "block.converter_bits", str(block["converter_bits"])
        if isinstance(block["range_v"], tuple):
            said = "[block] range_v must be one number on the bench: the firmware counts all channels alike"
            raise BadInput(said, setup.block_file)
        if block["range_v"] is not None:
            yield "block.range_v", _numbers(block["range_v"])
        if block["sample_rate_hz"] is not None:
            _require(block["sample_rate_hz"], *_RATES_HZ, "[block] sample_rate_hz", setup.block_file)
            yield "block.sample_period_us", str(round(1e6 / block["sample_rate_hz"]))
    if setup.truth is not None:
        yield "block.k", _numbers(*(element for row in setup.truth["K"] for element in row))
        yield "block.u0", _numbers(*setup.truth["U0"])


def _require(value: float, low: float, high: float, name: str, file: str) -> None:
    if not low <= value <= high:
        raise BadInput(f"{name} must be {low:g} to {high:g} on the bench, not {value:g}", file)


def _motion(setup: Setup) -> Iterator[tuple[str, str]]:
    """How the table moves, how far its cable reaches, and how long that may take."""
    motion = {**_USUAL_MOTION, **(setup.motion or {})}
    for name, (key, low, high) in _MOTION.items():
        _require(motion[name], low, high, f"[motion] {name}", setup.stand_file)
        yield key, _numbers(motion[name])
    angles = [position.angle_deg for position in setup.schedule.data.positions]
    lowest = min(_USUAL_CABLE_DEG[0], min(angles) - _CABLE_SLACK_DEG)
    highest = max(_USUAL_CABLE_DEG[1], max(angles) + _CABLE_SLACK_DEG)
    yield "procedure.cable_min_deg", _numbers(lowest)
    yield "procedure.cable_max_deg", _numbers(highest)

    speed = motion["velocity_deg_per_s"]
    slow = min(45.0, speed)
    move_s = (highest - lowest) / speed + speed / motion["acceleration_deg_per_s2"] + motion["settling_s"]
    home_s = move_s + (highest - lowest) / slow + 60.0 / (slow / 10.0)
    yield "profile.homing_fast_deg_s", _numbers(slow)
    yield "profile.homing_slow_deg_s", _numbers(slow / 10.0)
    for room in ("procedure", "profile"):
        yield f"{room}.move_timeout_ms", _milliseconds(max(30.0, 2.0 * move_s))
        yield f"{room}.home_timeout_ms", _milliseconds(max(60.0, 2.0 * home_s))
    yield "profile.stop_timeout_ms", _milliseconds(max(5.0, 2.0 * speed / motion["acceleration_deg_per_s2"]))
    yield "procedure.settle_ms", _milliseconds(motion["settling_s"])
    yield "procedure.settle_timeout_ms", _milliseconds(5.0 + 2.0 * motion["settling_s"])


def _milliseconds(seconds: float) -> str:
    return str(min(_LONGEST_MS, math.ceil(1e3 * seconds)))


def _procedure(setup: Setup) -> Iterator[tuple[str, str]]:
    rate_hz = (setup.block or {}).get("sample_rate_hz") or 100.0
    yield "procedure.estimator", setup.estimator
    yield "procedure.samples", str(setup.samples)
    if setup.samples < _fewest_that_show_stuck(setup):
        yield "averaging.stuck_run", "0"  # the firmware refuses a gate that could not tell
    if setup.error_budget_v > 0.0:
        yield "procedure.error_budget_v", _numbers(setup.error_budget_v)
    yield "procedure.gravity_limit_g", _numbers(setup.limit_g)
    yield "limit.virtual_s", _numbers(36000.0 + 4.0 * len(setup.schedule) * setup.samples / rate_hz)


def step_v(setup: Setup) -> PerChannel:
    """Size of a count of the simulated converter."""
    block = setup.block or {}
    return converter_step_v({key: block.get(key) or usual for key, usual in _USUAL_CONVERTER.items()})


def _fewest_that_show_stuck(setup: Setup) -> int:
    """So many equal samples come by chance in one of 100,000 positions at most (docs/method.md)."""
    noise_counts = max(1.0, float((setup.stand.sigmas("noise") / by_channel(step_v(setup))).min()))
    return 1 + math.ceil(math.log(1e5) / math.log(noise_counts * math.sqrt(2.0 * math.pi)))


@lru_cache(_REMEMBERED)
def _schedule(schedule: Schedule) -> list[tuple[str, str]]:
    mountings = [("mounting", _mounting(mounting)) for mounting in schedule.mountings]
    return mountings + [("position", _position(position)) for position in schedule.positions]


def _mounting(mounting: Mounting) -> str:
    elements = (element for row in mounting.matrix for element in row)
    bolting = "" if mounting.bolting is None else f" {mounting.bolting}"
    return f"{mounting.number} {_angle(mounting.tilt_deg)} {_numbers(*elements)}{bolting}"


def _position(position: Position) -> str:
    return f"{position.mounting} {position.number} {position.use} {_angle(position.angle_deg)}"


def _angle(angle_deg: float) -> str:
    return _numbers(angle_deg, *sine_cosine(angle_deg))


def weights_made_for(setup: Setup) -> Known:
    """The block's nominal K and the samples of a position."""
    block = _USUAL_BLOCK if setup.block is None else setup.block
    shape = np.full((3, 3), block["misalignment_rad"])
    np.fill_diagonal(shape, 1.0)
    return Known(by_channel(block["scale_v_per_g"])[:, None] * shape, _expected_samples(setup))


def _expected_samples(setup: Setup) -> float:
    """All that are asked for; with an error budget as many as bring the noise of a mean to it, but no fewer than the
    procedure takes before it looks."""
    if setup.error_budget_v == 0.0:
        return float(setup.samples)
    one_sample = float(setup.stand.with_step(step_v(setup)).sigmas("noise").max())
    wanted = (one_sample / setup.error_budget_v) ** 2 if one_sample < _MOST * setup.error_budget_v else _MOST**2
    return max(wanted, float(min(_FEWEST_SAMPLES, setup.samples)))


def gain_record(setup: Setup) -> bytes:
    """What goes into the navigation computer's non-volatile memory. Raises UsageError where no weights can be made."""
    require_declared_inclinations(setup.schedule.data, setup.stand)
    before, schedule = weights_made_for(setup), setup.schedule.data
    return to_bytes(record_of(optimal_table(schedule, before.k, setup.stand, step_v(setup), before.samples), schedule))
