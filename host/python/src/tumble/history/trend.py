"""How blocks of a type change, and which of them do not behave: a Kalman filter for every parameter of every block.

A parameter of a block is measured at the times t_k, days, as y_k = x(t_k) + e_k, e_k of the stated variance v_k. It
grows as its type does:

    x(t + tau) = x(t) + r tau + w,    r ~ N(drift, spread^2) of the block,    w ~ N(0, walk^2 tau)

Nothing is known of x before the first calibration. The filter has the mean (x, r) and its covariance; each calibration
that follows gives an innovation y_k - (x + r tau) of variance S, and z_k = innovation / sqrt(S), which is N(0, 1) and
independent of those before if the block behaves. The logarithm of the likelihood of a type is the sum of
-(log S + z^2)/2 over its blocks; drift, spread and walk are where it is greatest, their uncertainties by its curvature.

Two control charts of each z: Shewhart's, |z| within a limit, and the exponentially weighted moving average, which finds
small changes that stay. The limit is such that of all calibrations of blocks that behave at most 1 - confidence gives
an alarm of either chart in any parameter (Bonferroni, which holds whatever they have in common). What is beyond
Shewhart's limit is a jump if the calibration after it is likelier from there than from before, else an outlier; of the
last calibration of a block it is open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.history.calibrations import OF_BLOCK, PARAMETERS
from tumble.history.database import Columns

DAY_S = 86400.0
_STANDARD_GRAVITY = 9.80665  # m/s^2
IN_ORDER, JUMP, OUTLIER, OPEN, DRIFT = range(5)  # what a calibration is to a parameter
_ROUNDING = 1e-24  # a variance that even numbers without uncertainty have
SMOOTHING = 0.2  # lambda of the moving average
LEAST_INTERVALS = 10  # between calibrations of a type, from which its growth is estimated
_MOST_BLOCKS = 1000  # of a type, for its likelihood: more would change little
_MEDIAN_OF_CHI2 = 0.45493642311957283  # of one degree of freedom
_ROUNDS, _STEPS, _HALVINGS = 2, 12, 6
_DIFFERENCE, _KICK, _CONVERGED = 0.02, 0.2, 2e-3  # of the scatter of one calibration


def _unknown() -> Floats:
    return np.full(len(PARAMETERS), np.nan)


@dataclass(frozen=True)
class Series:
    """Calibrations of some blocks, in the order of time: `days` (blocks, most), since 1970; `values` and `variances`
    (blocks, most, 12), scales as logarithms, by standard gravity as the biases, the seat against the first one, NaN
    where there is none; `anew`: the seat is another stand's from here on; `rows` (blocks, most): where they stand in
    the history, -1: nowhere."""

    serials: list[str]
    days: Floats
    values: Floats
    variances: Floats
    anew: Flags
    rows: Integers

    def every(self, step: int) -> Series:
        """Every `step`-th block."""
        return Series(
            self.serials[::step],
            self.days[::step],
            self.values[::step],
            self.variances[::step],
            self.anew[::step],
            self.rows[::step],
        )

    @property
    def intervals(self) -> int:
        """How many there are between two calibrations."""
        return int(np.maximum((self.rows >= 0).sum(axis=1) - 1, 0).sum())


@dataclass(frozen=True)
class Growth:
    """Of a type, by parameter (12,): `drift` per day and its `spread` from block to block, `walk` per square root of a
    day, each with its standard uncertainty; `ratio`: root mean square of z, 1 where the stated uncertainties are right.
    `intervals`: how many between two calibrations it rests on."""

    drift: Floats
    spread: Floats
    walk: Floats
    intervals: int = 0
    u_drift: Floats = field(default_factory=_unknown)
    u_spread: Floats = field(default_factory=_unknown)
    u_walk: Floats = field(default_factory=_unknown)
    ratio: Floats = field(default_factory=_unknown)


class State(NamedTuple):
    """What is known of a parameter, each (blocks, 12): mean and covariance of its value and its rate; and how the
    means move with the drift of the type."""

    x: Floats
    rate: Floats
    p_xx: Floats
    p_xr: Floats
    p_rr: Floats
    x_by_drift: Floats
    rate_by_drift: Floats

    def after(self, tau: Floats, walk: Floats) -> State:
        """Predicted `tau` days later."""
        return self._replace(
            x=self.x + self.rate * tau,
            p_xx=self.p_xx + tau * (2.0 * self.p_xr + tau * self.p_rr + walk**2),
            p_xr=self.p_xr + tau * self.p_rr,
            x_by_drift=self.x_by_drift + self.rate_by_drift * tau,
        )

    def measured(self, e: Floats, s: Floats, v: Floats) -> State:
        """With an innovation `e` of variance `s`, by a calibration of variance `v`."""
        gain_x, gain_r = self.p_xx / s, self.p_xr / s
        return State(
            x=self.x + gain_x * e,
            rate=self.rate + gain_r * e,
            p_xx=gain_x * v,
            p_xr=gain_r * v,
            p_rr=self.p_rr - gain_r * self.p_xr,
            x_by_drift=self.x_by_drift * (1.0 - gain_x),
            rate_by_drift=self.rate_by_drift - gain_r * self.x_by_drift,
        )

    def begun(self, y: Floats, v: Floats) -> State:
        """Of the value nothing but this calibration is known; the rate stays."""
        zero = np.zeros_like(self.x)
        return self._replace(x=y, p_xx=v, p_xr=zero, x_by_drift=zero)


@dataclass(frozen=True)
class Filtered:
    """By block, calibration and parameter: innovations `size` and `z`, their moving average `ewma` in standard
    deviations, NaN where there are none; `kinds`; which of them `counts`, being in order; derivatives `by_drift` of a
    prediction by the drift of the type, and logarithms of variances S. `last`: what is known at the end."""

    size: Floats
    z: Floats
    ewma: Floats
    kinds: Integers
    counts: Flags
    by_drift: Floats
    logs: Floats
    last: State


def fleet_of(columns: Columns) -> tuple[dict[str, list[Series]], dict[str, int]]:
    """Of what `Database.read` gives, by type, blocks of about as many calibrations together; and how many calibrations
    are left out, by why. The type of a block is that of its last calibration, whether that counts or not. Of a
    run that was solved several times the last one that was added counts."""
    runs = list(zip(columns["run_sha256"], columns["serial"]))
    latest = {run: added for added, run in sorted(zip(columns["id"].tolist(), runs), key=lambda one: one[0])}
    is_again = [run[0] is not None and latest[run] != added for added, run in zip(columns["id"], runs)]
    again = np.array(is_again, dtype=bool)
    unsure = np.isnan(columns["u_scale_x"])
    failed = ~unsure & ~columns["believed"]
    left_out = {"without uncertainties": unsure, "failed": failed, "solved again": again & ~unsure & ~failed}
    kept = np.flatnonzero(~unsure & ~failed & ~again)
    _, block, counts = np.unique(columns["serial"][kept].astype(str), return_inverse=True, return_counts=True)
    order = np.argsort(block, kind="stable")  # a database may sort the letters of serials otherwise
    kept, block = kept[order], block[order]
    first = np.cumsum(counts) - counts
    place = np.arange(len(kept)) - first[block]
    last_type = dict(zip(columns["serial"], columns["type"]))
    kinds = np.array([last_type[serial] for serial in columns["serial"][kept[first]]], dtype=object)
    lengths = np.ceil(np.log2(counts)).astype(int)
    fleet: dict[str, list[Series]] = {}
    for kind in sorted(set(kinds)):
        for length in np.unique(lengths[kinds == kind]):
            of_these = np.flatnonzero((kinds == kind) & (lengths == length))
            rows = np.full((len(of_these), counts[of_these].max()), -1)
            chosen = np.isin(block, of_these)
            rows[np.searchsorted(of_these, block[chosen]), place[chosen]] = kept[chosen]
            fleet.setdefault(kind, []).append(_series(columns, rows))
    return fleet, {why: int(them.sum()) for why, them in left_out.items() if them.any()}


def _series(columns: Columns, rows: Integers) -> Series:
    """Build a Series; `rows` (blocks, most) are indices into the columns, -1 where there is none."""
    there = rows >= 0
    values = np.stack([columns[name] for name in PARAMETERS], axis=-1)[rows]
    variances = np.stack([columns[f"u_{name}"] for name in PARAMETERS], axis=-1)[rows] ** 2 + _ROUNDING
    relative = relative_gravity(np.where(there, columns["gravity_m_s2"][rows], np.nan))[..., None]
    values[..., :3] = np.log(values[..., :3] / relative)
    values[..., 6:9] *= relative
    values[..., 9:] = turned_by(values[:, :1, 9:], values[..., 9:])
    values[~there], variances[~there] = np.nan, np.nan
    stand = columns["stand"][rows]
    anew = np.zeros(rows.shape, dtype=bool)
    anew[:, 1:] = (stand[:, 1:] != stand[:, :-1]) & there[:, 1:]
    days = np.where(there, columns["created_s"][rows] / DAY_S, np.nan)
    return Series(list(columns["serial"][rows[:, 0]]), days, values, variances, anew, rows)


def relative_gravity(stated: Floats) -> Floats:
    """Local gravity over the standard one, (blocks, most), by the `stated` (blocks, most) in m/s^2, NaN where none is.
    A calibration that states none counts as measured at the usual gravity of its block, the median of those stated (of
    an even number the lower of the middle two): a laboratory that did not write it down did not move either, and the
    standard one is that of few places. Of a block that never states it all count as measured at the standard one."""
    count = np.isfinite(stated).sum(axis=1, keepdims=True)
    usual = np.take_along_axis(np.sort(stated, axis=1), np.maximum(count - 1, 0) // 2, axis=1)
    found = np.where(np.isnan(stated), usual, stated) / _STANDARD_GRAVITY
    return np.where(np.isnan(found), 1.0, found)


def turned_by(first: Floats, then: Floats) -> Floats:
    """The turn (..., 3), about the axes of the block, from one seat to the other, both vectors of turns (..., 3)."""
    between = np.swapaxes(_turns(first), -1, -2) @ _turns(then)
    cross = np.stack([between[..., i, j] - between[..., j, i] for i, j in ((2, 1), (0, 2), (1, 0))], axis=-1) / 2.0
    sine = np.linalg.norm(cross, axis=-1, keepdims=True)
    angle = np.arctan2(sine, (np.trace(between, axis1=-2, axis2=-1)[..., None] - 1.0) / 2.0)
    found: Floats = cross * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 1.0)
    return found


def _turns(vectors: Floats) -> Floats:
    """Matrices (..., 3, 3), by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)
    half = np.sinc(angle / (2.0 * np.pi))
    found: Floats = np.eye(3) + np.sinc(angle / np.pi) * cross + half**2 / 2.0 * (cross @ cross)
    return found


def control_limit(confidence: float) -> float:
    """Of |z| and of its moving average: two charts of twelve parameters."""
    return NormalDist().inv_cdf(1.0 - (1.0 - confidence) / (4.0 * len(PARAMETERS)))


def filtered(series: Series, growth: Growth, limit: float = np.inf, known: Integers | None = None) -> Filtered:
    """Go through all calibrations. `known`: what they are; else what is beyond the `limit` is judged."""
    shape = series.values.shape
    size, z, ewma, by_drift, logs = np.full((5, *shape), np.nan)
    kinds = np.full(shape, IN_ORDER) if known is None else known.copy()
    all_counts = np.zeros(shape, dtype=bool)
    following = None if known is not None else _following(series)
    zero = np.zeros_like(series.values[:, 0])
    state = State(zero, zero + growth.drift, zero, zero, zero + growth.spread**2, zero, zero + 1.0)
    since, average, weight = np.full(zero.shape, np.nan), zero, zero
    for k in range(series.days.shape[1]):
        y, v, there = series.values[:, k], series.variances[:, k], np.isfinite(series.values[:, k])
        has, day = np.isfinite(since), series.days[:, k, None]
        shown = there & has
        shown[:, OF_BLOCK:] &= ~series.anew[:, k, None]
        ahead = state.after(np.where(there & has, day - since, 0.0), growth.walk)
        s, e = np.where(shown, ahead.p_xx + v, 1.0), np.where(shown, y - ahead.x, 0.0)
        if following is not None:
            beyond = shown & (np.abs(e) > limit * np.sqrt(s))
            if beyond.any():
                kinds[:, k] = np.where(beyond, _judged(series, k, following[:, k], ahead, growth), IN_ORDER)
        kind = np.where(kinds[:, k] == DRIFT, IN_ORDER, kinds[:, k])
        kind[:, OF_BLOCK:] = kind[:, OF_BLOCK:].max(axis=1, keepdims=True)  # a seat turns as a whole
        all_counts[:, k] = counts = shown & (kind == IN_ORDER)
        if following is not None:
            average = np.where(counts, (1.0 - SMOOTHING) * average + SMOOTHING * e / np.sqrt(s), average)
            weight = np.where(counts, (1.0 - SMOOTHING) ** 2 * weight + SMOOTHING**2, weight)
            ewma[:, k] = np.where(counts, average / np.sqrt(np.where(counts, weight, 1.0)), np.nan)
            slow = counts & (np.abs(ewma[:, k]) > limit)
            kinds[:, k] = np.where(slow, DRIFT, kinds[:, k])
            average, weight = np.where(slow, 0.0, average), np.where(slow, 0.0, weight)
        size[:, k], z[:, k] = np.where(shown, (e, e / np.sqrt(s)), np.nan)
        by_drift[:, k], logs[:, k] = np.where(shown, (ahead.x_by_drift, np.log(s)), np.nan)
        begins = there & ~counts & ~(shown & (kind == OUTLIER))
        parts = zip(state, ahead.measured(e, s, v), state.begun(y, v))
        state = State(*(np.where(begins, begun, np.where(counts, better, same)) for same, better, begun in parts))
        since = np.where(begins | counts, day, since)
    return Filtered(size, z, ewma, kinds, all_counts, by_drift, logs, state)


def _following(series: Series) -> Integers:
    """Index (blocks, most, 12) of the calibration after each that measures the parameter too; -1: there is none."""
    found, next_one = np.full(series.values.shape, -1), np.full((len(series.serials), len(PARAMETERS)), -1)
    for k in reversed(range(series.days.shape[1])):
        found[:, k] = next_one
        next_one = np.where(np.isfinite(series.values[:, k]), k, next_one)
        next_one[:, OF_BLOCK:] = np.where(series.anew[:, k, None], -1, next_one[:, OF_BLOCK:])
    return found


def _judged(series: Series, k: int, following: Integers, ahead: State, growth: Growth) -> Integers:
    """Is calibration k, which is beyond the limit, a jump or an outlier? As the one after it is likelier from there, or
    from what was foreseen."""
    places = np.maximum(following, 0)
    y, v = (np.take_along_axis(one, places[:, None], axis=1)[:, 0] for one in (series.values, series.variances))
    tau = np.where(following < 0, 0.0, np.take_along_axis(series.days, places, axis=1) - series.days[:, k, None])
    unlikely = []
    for state in (ahead, ahead.begun(series.values[:, k], series.variances[:, k])):
        then = state.after(tau, growth.walk)
        s = then.p_xx + v
        unlikely.append(np.log(s) + (y - then.x) ** 2 / s)
    return np.where(following < 0, OPEN, np.where(unlikely[1] < unlikely[0], JUMP, OUTLIER))


def growth_of(fleet: Sequence[Series], limit: float) -> Growth | None:
    """Of the blocks of one type, without what is beyond the `limit`; None: too few calibrations."""
    blocks = sum(len(series.serials) for series in fleet)
    fleet = [series.every(max(1, -(-blocks // _MOST_BLOCKS))) for series in fleet]
    intervals = sum(series.intervals for series in fleet)
    if intervals < LEAST_INTERVALS:
        return None
    growth = _robust_start(fleet)
    for _ in range(_ROUNDS):
        kinds = [filtered(series, growth, limit).kinds for series in fleet]
        growth = _likeliest(fleet, kinds, growth)
    return replace(growth, intervals=intervals)


def _robust_start(fleet: Sequence[Series]) -> Growth:
    """A walk alone, such that half of all differences of calibrations that follow each other are within the median of
    the normal distribution: jumps move it little."""
    squares = _flat(np.diff(one.values, axis=1) ** 2 for one in fleet)
    variances = _flat(one.variances[:, 1:] + one.variances[:, :-1] for one in fleet)
    days = _flat(np.repeat(np.diff(one.days, axis=1)[..., None], len(PARAMETERS), axis=2) for one in fleet)
    low, high = np.zeros(len(PARAMETERS)), np.nanmax(squares / np.maximum(days, 1.0), axis=0) + 1e-300
    for _ in range(60):
        middle = (low + high) / 2.0
        too_small = np.nanmedian(squares / (variances + middle * days), axis=0) > _MEDIAN_OF_CHI2
        low, high = np.where(too_small, middle, low), np.where(too_small, high, middle)
    typical = np.nanmedian(variances / np.maximum(days, 1.0), axis=0)
    walk = np.sqrt(np.maximum(low, 0.01 * typical))
    return Growth(np.zeros(len(PARAMETERS)), 0.5 * walk / np.sqrt(max(1.0, np.nanmedian(days))), walk)


def _flat(parts: Iterable[Floats]) -> Floats:
    """By parameter alone, (n, 12)."""
    return np.concatenate([one.reshape(-1, len(PARAMETERS)) for one in parts])


def _likeliest(fleet: Sequence[Series], kinds: Sequence[Integers], start: Growth) -> Growth:
    """By Newton's method for walk and spread, all parameters at once, in units of the scatter of one calibration over a
    typical interval; of each pair of them the drift that is likeliest. The likelihood is even in both, so that one that
    is nothing is found at 0."""
    days = max(1.0, float(np.nanmedian(np.concatenate([np.diff(one.days, axis=1).ravel() for one in fleet]))))
    scatter = np.sqrt(np.nanmedian(_flat(one.variances for one in fleet), axis=0))
    units = np.stack([scatter / np.sqrt(days), scatter / days])  # of walk, spread

    def look(at: Floats) -> tuple[Floats, Growth]:
        return _log_likelihood(fleet, kinds, Growth(np.zeros(len(PARAMETERS)), at[1] * units[1], at[0] * units[0]))

    at = np.stack([start.walk, start.spread]) / units
    height, _ = look(at)
    for _ in range(_STEPS):
        step, _ = _newton(lambda one: look(one)[0], at, height)
        before = at
        for _ in range(_HALVINGS):
            found, _ = look(np.abs(at + step))
            better = found > height
            at, height = np.where(better, np.abs(at + step), at), np.where(better, found, height)
            step = np.where(better, 0.0, step / 2.0)
            if np.abs(step).max() < _CONVERGED:
                break
        if np.abs(at - before).max() < _CONVERGED:
            break
    u = _newton(lambda one: look(one)[0], at, height)[1]
    # beside 0 there is no curvature: a variance that the scatter of so many differences, 2 in these units, would hide
    u = np.minimum(u, (8.0 / sum(one.intervals for one in fleet)) ** 0.25) * units
    return replace(look(at)[1], u_walk=u[0], u_spread=u[1])


def _log_likelihood(fleet: Sequence[Series], kinds: Sequence[Integers], growth: Growth) -> tuple[Floats, Growth]:
    """Its logarithm (12,) for the spread and walk of a `growth`, and that growth with the drift that is likeliest."""
    info, moment, squares, logs, count = np.zeros((5, len(PARAMETERS)))
    for series, known in zip(fleet, kinds):
        found = filtered(series, replace(growth, drift=np.zeros(len(PARAMETERS))), known=known)
        counts = found.counts
        z, by_drift = np.where(counts, found.z, 0.0), np.where(counts, found.by_drift * np.exp(-found.logs / 2.0), 0.0)
        info += (by_drift**2).sum(axis=(0, 1))
        moment += (by_drift * z).sum(axis=(0, 1))
        squares += (z**2).sum(axis=(0, 1))
        logs += np.where(counts, found.logs, 0.0).sum(axis=(0, 1))
        count += counts.sum(axis=(0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        drift = np.where(info > 0.0, moment / info, 0.0)
        left = squares - drift * moment
        told = replace(growth, drift=drift, u_drift=1.0 / np.sqrt(info), ratio=np.sqrt(left / count))
    return -(logs + left) / 2.0, told


def _newton(height: Callable[[Floats], Floats], at: Floats, middle: Floats) -> tuple[Floats, Floats]:
    """A step (2, 12) up from `at`, where a `height` (12,) is `middle`, and the standard uncertainties (2, 12) by its
    curvature. Where that is upward, as at 0 under a summit beside it, the step is one of _KICK at least."""
    first, second = np.array([[_DIFFERENCE], [0.0]]), np.array([[0.0], [_DIFFERENCE]])
    ends = [(height(at + one), height(at - one)) for one in (first, second)]
    slope = np.stack([(up - down) / (2.0 * _DIFFERENCE) for up, down in ends], axis=-1)
    own = [(up - 2.0 * middle + down) / _DIFFERENCE**2 for up, down in ends]
    both = (height(at + first + second) - ends[0][0] - ends[1][0] + middle) / _DIFFERENCE**2
    values, vectors = np.linalg.eigh(np.stack([own[0], both, both, own[1]], axis=-1).reshape(-1, 2, 2))
    along = np.einsum("pji,pj->pi", vectors, slope) / np.maximum(np.abs(values), 1e-9)
    along = np.where(values > 0.0, np.where(along < 0.0, -1.0, 1.0) * np.maximum(np.abs(along), _KICK), along)
    step = np.einsum("pij,pj->ip", vectors, along)
    step *= np.minimum(1.0, np.maximum(1.0, np.abs(at).max(axis=0)) / np.maximum(np.abs(step).max(axis=0), 1e-300))
    u = np.sqrt(np.einsum("pij,pj->ip", vectors**2, 1.0 / np.maximum(np.abs(values), 1e-9)))
    return step, u
