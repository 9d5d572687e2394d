"""The uncertainties that a solution states: by the core, confirmed by the covariance that numpy finds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core, reference
from tumble.arrays import Floats, Integers
from tumble.estimators import OPTIMAL
from tumble.files.run_file import Run
from tumble.reference.extended import covariance as extended_covariance
from tumble.schedule import Schedule
from tumble.solving import uncertainty
from tumble.solving.crosscheck import compare_uncertainties
from tumble.stand import PerChannel, Stand
from tumble.terms import Terms


@dataclass(frozen=True)
class Stated:
    """Standard uncertainties `u_k` (3, 3), `u_u0` (3,); `covariance` of K row by row, U0 and the sizes of further
    terms, where there are any."""

    u_k: Floats
    u_u0: Floats
    covariance: Floats

    @property
    def of_twelve(self) -> Floats:
        """Covariance (12, 12) of K row by row and U0."""
        return self.covariance[:12, :12]


@dataclass(frozen=True)
class Witness:
    """What numpy propagates: a `schedule` of measured positions and their `samples`, solved for `k`; the rest as of
    Propagation."""

    schedule: Schedule
    k: Floats
    stand: Stand
    samples: Integers
    estimator: str
    step: PerChannel

    def covariance(self, variance: Floats, terms: Terms = ()) -> Floats:
        """Of K row by row, U0 and the sizes of further `terms`; `variance` (positions, 3): by the noise as measured."""
        given = self.schedule, self.k, self.stand, self.samples
        if self.estimator == OPTIMAL:
            return reference.optimal_covariance(*given, self.step, variance, terms)
        if terms:
            return extended_covariance(*given, terms, variance)
        return reference.covariance(*given, self.estimator, variance)


@dataclass(frozen=True)
class Propagation:
    """What the errors of a `stand` and the noise of the means do to a run that was solved for `k`, all in the run's
    unit: `schedule` for the core, `witnessed` for numpy, with the measured positions alone; `step`: of the converter;
    `mean_variance` (positions, 3): by the noise as measured."""

    schedule: core.CoreSchedule
    witnessed: Schedule
    run: Run
    k: Floats
    estimator: str
    stand: Stand
    step: PerChannel
    mean_variance: Floats

    def to_twelve(self, optimal: reference.OptimalEstimate | None = None) -> Stated:
        """To K and U0, solved without further terms; `optimal`: what numpy found by that estimator, if it has.

        Raises CoreRefusal, Disagreement."""
        given = self.schedule, self.run.measured, self.k, self.stand, self.run.samples, self.estimator, self.step
        u = uncertainty.standard_uncertainties(*given, self.mean_variance)
        covariance = self._witness.covariance(self._variance) if optimal is None else optimal.covariance
        compare_uncertainties(u, reference.by_coefficient(covariance), self.estimator == OPTIMAL)
        return Stated(*u, covariance)

    def to_all(self, terms: Terms, optimal: reference.OptimalEstimate | None = None) -> Stated:
        """To K and U0 beside further `terms`; else as to_twelve."""
        given = self.schedule, self.run.measured, self.k, self.stand, self.run.samples, self.estimator, self.step
        u = uncertainty.extended_uncertainties(*given, terms, self.mean_variance)
        covariance = self._witness.covariance(self._variance, terms) if optimal is None else optimal.covariance
        stated = u[:9].reshape(3, 3), u[9:12], u[12:]
        witness = *reference.by_coefficient(covariance), np.sqrt(np.diag(covariance)[12:])
        compare_uncertainties(stated, witness, self.estimator == OPTIMAL)
        return Stated(*stated[:2], covariance)

    @property
    def _witness(self) -> Witness:
        samples = self.run.samples[self.run.measured]
        return Witness(self.witnessed, self.k, self.stand, samples, self.estimator, self.step)

    @property
    def _variance(self) -> Floats:
        return self.mean_variance[self.run.measured]
