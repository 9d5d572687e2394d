"""How well a schedule's subsets know the norm of a: the worst u(|a|) over all attitudes, for thousands of subsets.

Everything that does not depend on the subset is computed once, for all candidate positions: what the stand's errors do
to the outputs, and what errors of the unknowns do to |a|. An error of the stand that touches one position only,
such as that of a set angle, adds to the covariance of its outputs; one that positions share is an unknown with a prior.
For `optimal` the information of the positions then simply adds up. `least_squares` is propagated as it is.

Unknowns are the coefficients, and the sizes of the case's further terms. A drift goes by the order of the candidates;
of a subset that leaves some out it is nearly the drift of the run.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.errors import UsageError
from tumble.estimators import OPTIMAL
from tumble.model.errors import NOISE, declared, of_stand
from tumble.model.estimators import columns_at
from tumble.model.geometry import ideal_force
from tumble.model.norm import norm_gradient, spread_attitudes, worst_norm
from tumble.model.optimal import UNEQUAL, mean_sigma
from tumble.planning.case import Case
from tumble.schedule import Schedule
from tumble.stand import by_channel
from tumble.terms import EXTENDABLE

ESTIMATORS = EXTENDABLE
_ATTITUDES = 400  # a worst u(|a|) at one of these is short of the true one by a percent or two
_SENSITIVITY = 1e-3  # g: with less, per square root of the positions, a coefficient is not identified
_UNKNOWN_G = 1e3  # prior of a coefficient, in parts of max|K|: what a subset cannot identify is this far off


class NormSpread:
    """The candidates are the fit positions of `schedule`, for the case's stand and nominal block."""

    def __init__(self, case: Case, schedule: Schedule, estimator: str):
        if estimator not in ESTIMATORS:
            raise UsageError(f"--estimator: a schedule is sought for {' or '.join(ESTIMATORS)}, not {estimator}")
        k, count = case.nominal_k(), len(schedule.positions)
        self.estimator, self.schedule, self.k = estimator, schedule, k
        one_sample = replace(case.stand, samples=1)
        self.noise = mean_sigma(k, one_sample, case.step_v, 1)[0] ** 2
        self.rounding = by_channel(case.stand.rounding) ** 2
        found = of_stand(schedule, k, one_sample, [name for name in declared(one_sample) if name != NOISE]).values()
        errors = np.concatenate([one.derivative * one.sigma[:, None, None] for one in found])
        shared = (np.abs(errors).max(axis=2) > 0.0).sum(axis=1) > 1
        self.shared = np.moveaxis(errors[shared], 0, 2)
        self.local = np.einsum("dpi,dpj->pij", errors[~shared], errors[~shared])
        force, self.terms = ideal_force(schedule), case.terms
        further, force = columns_at(force, case.terms), np.column_stack([force, np.ones(count)])
        own = np.einsum("tipi->ipt", further.reshape(-1, 3, count, 3))  # of no term but its own does a channel feel any
        self.felt = np.concatenate([np.broadcast_to(force, (3, count, 4)), own], axis=2)
        self.weak = (_UNKNOWN_G * np.abs(k).max()) ** -2
        self.gradient = norm_gradient(k, spread_attitudes(_ATTITUDES), case.terms)

    def worst(self, chosen: Flags, samples: int) -> Floats:
        """The worst u(|a|), g, of every subset at some attitudes: `chosen` (subsets, candidates), `samples` at each
        position."""
        variances = ((self.gradient @ self._covariances(chosen, samples)) * self.gradient).sum(axis=2)
        u: Floats = np.sqrt(variances.max(axis=1))
        return u

    def exact(self, chosen: Flags, samples: int) -> float:
        """The worst u(|a|), g, of one subset (candidates,) at any attitude."""
        return worst_norm(self.k, self._covariances(chosen[None], samples)[0], self.terms).worst

    def _covariances(self, chosen: Flags, samples: int) -> Floats:
        """Of the unknowns (subsets, n, n): K row by row, U0, sizes by term and channel."""
        noise = self.local + np.diag(self.noise / samples)
        found = (self._optimal if self.estimator == OPTIMAL else self._least_squares)(chosen, noise)
        rows = np.arange(found.shape[1]).reshape(3, -1)
        order = np.concatenate([rows[:, :3].ravel(), rows[:, 3:].T.ravel()])
        return found[:, order[:, None], order]

    def _optimal(self, chosen: Flags, noise: Floats) -> Floats:
        """Channel by channel: unknowns are those of the model, and the shared errors over their sigma."""
        positions, count = self.felt.shape[1:]
        design = np.einsum("ipr,ij->pijr", self.felt, np.eye(3)).reshape(positions, 3, 3 * count)
        model = np.concatenate([design, self.shared], axis=2)
        weighted = np.linalg.solve(noise, model)
        each = np.swapaxes(model, 1, 2) @ weighted
        total = np.tensordot(chosen.astype(float), each, axes=1)
        prior = np.r_[np.full(3 * count, self.weak), np.ones(model.shape[2] - 3 * count)]
        scale = np.sqrt(total.diagonal(axis1=1, axis2=2) + prior)
        total = (total + np.diag(prior)) / scale[:, :, None] / scale[:, None, :]
        try:
            inverse = np.linalg.inv(total) / scale[:, :, None] / scale[:, None, :]
        except np.linalg.LinAlgError:
            raise UsageError(UNEQUAL) from None
        if self.rounding.any():  # weights, as those of a solve, do not know it
            unweighted = np.swapaxes(weighted, 1, 2) @ (self.rounding[:, None] * weighted)
            inverse = inverse + inverse @ np.tensordot(chosen.astype(float), unweighted, axes=1) @ inverse
        found: Floats = inverse[:, : 3 * count, : 3 * count]
        if not (found.diagonal(axis1=1, axis2=2) > 0.0).all():
            raise UsageError(UNEQUAL)
        return found

    def _least_squares(self, chosen: Flags, noise: Floats) -> Floats:
        """Likewise."""
        count = self.felt.shape[2]
        weighted = chosen[:, None, :, None] * self.felt
        normal = np.swapaxes(weighted, 2, 3) @ self.felt
        lost = np.linalg.eigvalsh(normal)[..., 0] <= _SENSITIVITY**2 * chosen.sum(axis=1)[:, None]
        gains = weighted @ np.linalg.inv(np.where(lost[..., None, None], np.eye(count), normal))
        gains[lost] *= _UNKNOWN_G / self.noise.min() ** 0.5  # far off too
        by_shared = np.einsum("bipr,pid->bird", gains, self.shared, optimize=True).reshape(len(chosen), 3 * count, -1)
        noise = noise + np.diag(self.rounding)
        by_local = np.einsum("bipr,bjps,pij->birjs", gains, gains, noise, optimize=True)
        found: Floats = by_local.reshape(len(chosen), 3 * count, 3 * count) + by_shared @ np.swapaxes(by_shared, 1, 2)
        return found
