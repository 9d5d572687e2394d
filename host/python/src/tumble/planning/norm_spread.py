"""How well a schedule's subsets know the norm of a: the worst u(|a|) over all attitudes, for thousands of subsets.

Everything that does not depend on the subset is computed once, for all candidate positions: what the stand's errors do
to the outputs, and what errors of the coefficients do to |a|. An error of the stand that touches one position only,
such as that of a set angle, adds to the covariance of its outputs; one that positions share is an unknown with a prior.
For `optimal` the information of the positions then simply adds up. `least_squares` is propagated as it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tumble import reference
from tumble.arrays import Flags, Floats
from tumble.errors import UsageError
from tumble.estimators import OPTIMAL
from tumble.planning.case import Case
from tumble.planning.error_field import features, norm_forms
from tumble.reference.uncertainty import sources
from tumble.schedule import Schedule
from tumble.solving.covariance import spread_attitudes, worst_norm
from tumble.solving.gains import UNEQUAL, mean_sigma

ESTIMATORS = ("least_squares", OPTIMAL)
_ATTITUDES = 400  # a worst u(|a|) at one of these is short of the true one by a percent or two
_ORDER = [4 * i + j for i in range(3) for j in range(3)] + [3, 7, 11]  # K row by row, then U0, of channel by channel
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
        found = sources(schedule, k, one_sample, np.ones(count, dtype=int))
        errors = np.concatenate(
            [one.derivative * one.sigma[:, None, None] for name, one in found.items() if name != "noise"]
        )
        shared = (np.abs(errors).max(axis=2) > 0.0).sum(axis=1) > 1
        self.shared = np.moveaxis(errors[shared], 0, 2)
        self.local = np.einsum("dpi,dpj->pij", errors[~shared], errors[~shared])
        self.force = np.column_stack([reference.Geometry(schedule).force(), np.ones(count)])
        self.weak = (_UNKNOWN_G * np.abs(k).max()) ** -2
        self.to_forms = _forms_of_coefficients(k)
        self.features = features(spread_attitudes(_ATTITUDES))

    def worst(self, chosen: Flags, samples: int) -> Floats:
        """The worst u(|a|), g, of every subset at some attitudes: `chosen` (subsets, candidates), `samples` at each
        position."""
        forms = self.to_forms @ self._covariances(chosen, samples) @ self.to_forms.T
        variances = np.einsum("ar,brs,as->ba", self.features, forms, self.features, optimize=True)
        u: Floats = np.sqrt(variances.max(axis=1))
        return u

    def exact(self, chosen: Flags, samples: int) -> float:
        """The worst u(|a|), g, of one subset (candidates,) at any attitude."""
        return worst_norm(self.k, self._covariances(chosen[None], samples)[0][np.ix_(_ORDER, _ORDER)]).worst

    def _covariances(self, chosen: Flags, samples: int) -> Floats:
        noise = self.local + self.noise / samples * np.eye(3)
        return (self._optimal if self.estimator == OPTIMAL else self._least_squares)(chosen, noise)

    def _optimal(self, chosen: Flags, noise: Floats) -> Floats:
        """Covariances (subsets, 12, 12): unknowns are the coefficients, and the shared errors over their sigma."""
        design = np.einsum("pr,ij->pijr", self.force, np.eye(3)).reshape(len(self.force), 3, 12)
        model = np.concatenate([design, self.shared], axis=2)
        each = np.swapaxes(model, 1, 2) @ np.linalg.solve(noise, model)
        total = np.tensordot(chosen.astype(float), each, axes=1)
        prior = np.r_[np.full(12, self.weak), np.ones(model.shape[2] - 12)]
        scale = np.sqrt(total.diagonal(axis1=1, axis2=2) + prior)
        total = (total + np.diag(prior)) / scale[:, :, None] / scale[:, None, :]
        try:
            found: Floats = (np.linalg.inv(total) / scale[:, :, None] / scale[:, None, :])[:, :12, :12]
        except np.linalg.LinAlgError:
            raise UsageError(UNEQUAL) from None
        if not (found.diagonal(axis1=1, axis2=2) > 0.0).all():
            raise UsageError(UNEQUAL)
        return found

    def _least_squares(self, chosen: Flags, noise: Floats) -> Floats:
        weighted = chosen[:, :, None] * self.force
        normal = np.swapaxes(weighted, 1, 2) @ self.force
        lost = np.linalg.eigvalsh(normal)[:, 0] <= _SENSITIVITY**2 * chosen.sum(axis=1)
        gains = weighted @ np.linalg.inv(np.where(lost[:, None, None], np.eye(4), normal))
        gains[lost] *= _UNKNOWN_G / self.noise**0.5  # far off too
        by_shared = np.einsum("bpr,pid->bird", gains, self.shared, optimize=True).reshape(len(chosen), 12, -1)
        by_local = np.einsum("bpr,bps,pij->birjs", gains, gains, noise, optimize=True)
        found: Floats = by_local.reshape(len(chosen), 12, 12) + by_shared @ np.swapaxes(by_shared, 1, 2)
        return found


def _forms_of_coefficients(k: Floats) -> Floats:
    """(9, 12): forms of |a| by errors of K_ij and U0_i, channel by channel: K_ix, K_iy, K_iz, U0_i."""
    to_g, unit = np.linalg.inv(k), np.eye(12).reshape(12, 3, 4)
    return norm_forms(-to_g @ unit[:, :, :3], -unit[:, :, 3] @ to_g.T).T
