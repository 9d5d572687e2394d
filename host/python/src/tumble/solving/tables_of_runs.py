"""Tables of the optimal estimator for many runs at once, each at its own K: optimal_table in stacks.

The system is the one of model.optimal but for the errors of the set angles. Each of these moves the three outputs of
its own position alone, along d = sigma4 K f', so it needs no column: the reflection that turns d to the first axis
leaves noise of sqrt(sigma^2 + |d|^2) along that axis and of sigma on the other two, and dividing the first row by
their ratio makes all noise alike. Exact, and as well conditioned as the whole system. Every run is reckoned by itself,
so numbers do not depend on how many runs are in a stack.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.core.optimal import GainRecord, Gains, estimate_runs, optimal_each
from tumble.errors import UsageError
from tumble.model.errors import unit_effect
from tumble.model.estimators import design
from tumble.model.optimal import (
    LARGEST_LOSS,
    UNEQUAL,
    by_mounting,
    channel_weights,
    mean_sigma,
    optimal_table,
    require_drift,
    shared_errors,
)
from tumble.schedule import Schedule
from tumble.solving.optimal_run import record_of, to_bytes
from tumble.stand import PerChannel, Stand, by_channel

_AT_ONCE = 50  # runs: what a stack of them takes stays in a processor's second cache


def solve(schedule: Schedule, means: Floats, stand: Stand, step: PerChannel, samples: float) -> tuple[Floats, Floats]:
    """Coefficients (runs, 12) by the core, with weights made at each run's first estimate, from means (runs, positions,
    3) of a schedule that has fit positions alone; and standard uncertainties (runs, 12) at the K found. `step` as in
    optimal_table; `samples`: of a mean, for the weights; uncertainties are for the stand's own.

    Raises CoreRefusal; UsageError where weights cannot be made.
    """
    system = _System(schedule, stand, step)
    opened = core.CoreSchedule(schedule)
    first = estimate_runs(opened, means, "least_squares")[:, :9].reshape(-1, 3, 3)
    table = optimal_table(schedule, first[0], stand, step, samples)
    record = GainRecord(opened, to_bytes(record_of(table, schedule)))
    found, u = np.empty((2, len(means), 12))
    for part in _parts(len(means)):
        found[part] = optimal_each(record, means[part], system.weights(first[part], samples))
        u[part] = system.uncertainties(found[part, :9].reshape(-1, 3, 3))
    return found, u


def _parts(runs: int) -> Iterator[slice]:
    for start in range(0, runs, _AT_ONCE):
        yield slice(start, min(start + _AT_ONCE, runs))


class _Mirror:
    """Makes the noise of outputs alike: for positions whose angle's error moves them by `along` (runs, P, 3), beside
    noise `sigma` (runs,). The reflection is I - v w^T, with v along the sum of d/|d| and the first axis, both taken to
    one side, so that nothing cancels."""

    def __init__(self, along: Floats, sigma: Floats):
        size = np.linalg.norm(along, axis=2, keepdims=True)
        anywhere = np.broadcast_to(np.eye(3)[0], along.shape).copy()
        self.v = np.divide(along, size, out=anywhere, where=size > 0.0)
        self.v[..., 0] += np.where(self.v[..., 0] < 0.0, -1.0, 1.0)
        self.w = self.v / np.abs(self.v[..., :1])
        self.ratio = sigma[:, None] / np.hypot(size[..., 0], sigma[:, None])

    def of(self, outputs: Floats) -> Floats:
        """Of columns (runs, P, 3, n) of outputs."""
        across = _dot(np.swapaxes(outputs, 2, 3), self.w[:, :, None])
        turned: Floats = outputs - self.v[..., None] * across[:, :, None]
        turned[:, :, 0] *= self.ratio[..., None]
        return turned

    def back(self, rows: Floats) -> Floats:
        """Gains (runs, n, 3P) of what `of` made, as gains of the outputs."""
        by_position = rows.reshape(*rows.shape[:2], -1, 3).copy()
        by_position[..., 0] *= self.ratio[:, None]
        across = _dot(by_position, self.v[:, None])
        turned: Floats = by_position - across[..., None] * self.w[:, None]
        return turned.reshape(rows.shape)


@dataclass(frozen=True)
class _Whitened:
    """Runs with noise alike in all rows: `rows` (runs, 3P + shared, shared + 12), the prior's behind the outputs'. What
    they came from: outputs `by_shared` (runs, P, 3, shared), in units of the prior, and `by_angle` (runs, P, 3);
    `mirror`; `sigma` (runs, 3) of a mean, and the `weights` (runs, 1, 3) that make channels alike."""

    rows: Floats
    by_shared: Floats
    by_angle: Floats
    mirror: _Mirror
    sigma: Floats
    weights: Floats


class _System:
    """What the runs of a stand and a schedule share."""

    def __init__(self, schedule: Schedule, stand: Stand, step: PerChannel):
        self.schedule, self.stand, self.step = schedule, stand, step
        self.errors = shared_errors(schedule, np.eye(3), stand)
        self.shared = np.concatenate([source.sigma for source in self.errors.values()])
        self.design = design(schedule).reshape(-1, 3, 12)
        by_shared = np.concatenate([source.derivative for source in self.errors.values()])
        self.by_shared = np.moveaxis(by_shared, 0, 2) * self.shared
        self.angles = len(self.shared) - (3 if "drift" in self.errors else 0)  # the others do not depend on K
        self.by_angle = unit_effect(schedule, "alpha4").derivative(np.eye(3)).sum(axis=0) * stand.sigma("angle")

    def whiten(self, k: Floats, samples: float) -> _Whitened:
        """For blocks of sensitivity `k` (runs, 3, 3)."""
        runs, positions, shared = len(k), len(self.design), len(self.shared)
        sigma = mean_sigma(k, self.stand, self.step, samples)[0]
        require_drift(self.stand.sigmas("drift") / sigma)
        weights, largest = channel_weights(sigma)[:, None], sigma.max(axis=1)
        by_shared, by_angle = self._turned(k), self.by_angle @ np.swapaxes(k, 1, 2)
        outputs = np.empty((runs, positions, 3, shared + 12))
        outputs[..., :shared], outputs[..., shared:] = by_shared, self.design
        outputs *= weights[..., None]
        mirror = _Mirror(by_angle * weights, largest)
        prior = largest[:, None, None] * np.eye(shared, shared + 12)
        rows = np.concatenate([mirror.of(outputs).reshape(runs, -1, shared + 12), prior], axis=1)
        return _Whitened(rows, by_shared, by_angle, mirror, sigma, weights)

    def _turned(self, k: Floats) -> Floats:
        """`by_shared`, which is for K = 1, for the K of every run."""
        by_channel = k @ np.swapaxes(self.by_shared, 0, 1).reshape(3, -1)
        turned = np.swapaxes(by_channel.reshape(len(k), 3, *self.by_shared.shape[::2]), 1, 2).copy()
        turned[..., self.angles :] = self.by_shared[..., self.angles :]
        of_runs: Floats = turned
        return of_runs

    def weights(self, k: Floats, samples: float) -> Gains:
        """For each run. Raises UsageError where numbers are beyond any stand."""
        system, shared = self.whiten(k, samples), len(self.shared)
        q, r = np.linalg.qr(system.rows)
        data = np.swapaxes(q[:, : 3 * len(self.design)], 1, 2)
        with np.errstate(all="ignore"):
            beta = np.linalg.solve(r[:, shared:, shared:], data[:, shared:])
            left = data[:, :shared] - r[:, :shared, shared:] @ beta
            prior = self.shared[:, None] * np.linalg.solve(r[:, :shared, :shared], left)
            by_channel = np.tile(system.weights, len(self.design))
            beta, prior = system.mirror.back(beta) * by_channel, system.mirror.back(prior) * by_channel
            sound = self._is_sound(beta, _deviations(r[:, shared:, shared:], system.sigma), system)
        if not (np.isfinite(prior).all() and sound):
            raise UsageError(UNEQUAL)
        return Gains(
            k,
            system.sigma.max(axis=1),
            system.weights[:, 0],
            beta,
            by_mounting(prior, self.errors, self.schedule, self.stand),
        )

    def uncertainties(self, k: Floats) -> Floats:
        """What the runs state (runs, 12): of the estimates, for blocks of sensitivity `k`."""
        system, shared = self.whiten(k, self.stand.samples), len(self.shared)
        r = np.asarray(np.linalg.qr(system.rows, mode="r"))
        u, rounding = _deviations(r[:, shared:, shared:], system.sigma), by_channel(self.stand.rounding)
        if not rounding.any():
            return u
        gains_of_runs = self.weights(k, self.stand.samples).gains
        by_rounding = (gains_of_runs**2).reshape(len(k), 12, -1, 3).sum(axis=2) @ rounding**2
        together: Floats = np.sqrt(u**2 + by_rounding)
        return together

    def _is_sound(self, beta: Floats, u: Floats, system: _Whitened) -> bool:
        """As optimal_table: the gains give back the coefficients, and their spread is the one that QR says."""
        lost = np.abs(beta @ self.design.reshape(-1, 12) - np.eye(12)).max()
        by_shared = beta @ system.by_shared.reshape(*beta.shape[::2], -1)
        by_angle = _dot(beta.reshape(*beta.shape[:2], -1, 3), system.by_angle[:, None])
        noise = _dot((beta**2).reshape(*beta.shape[:2], -1, 3).sum(axis=2), system.sigma[:, None] ** 2)
        claimed = np.sqrt((by_shared**2).sum(axis=2) + (by_angle**2).sum(axis=2) + noise)
        return bool(lost < LARGEST_LOSS and (np.abs(claimed - u) < LARGEST_LOSS * u).all())


def _dot(one: Floats, other: Floats) -> Floats:
    """Over a last axis of three, which a sum of numpy takes several times as long for."""
    product: Floats = one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2]
    return product


def _deviations(r: Floats, sigma: Floats) -> Floats:
    deviations: Floats = sigma.max(axis=1)[:, None] * np.sqrt((np.linalg.inv(r) ** 2).sum(axis=2))
    return deviations
