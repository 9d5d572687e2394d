"""What is known of a block before a run, from its last calibration: nine intrinsic parameters, the logarithms of the
scales, the angles between the axes, the biases in g.

K of one run differs from that of the next by a turn of the whole block, as a seat is not the same twice. That turn is
no part of a prior: it is left to the run. So a prior is nine rows

    P (beta - beta_0) = p - p(beta_0),    P = dp/dbeta

of the covariance of p, beside the outputs of the run in one least-squares problem. As P depends on beta, the problem is
made again where the one before ended.

First the two are held against each other. Of a run that determines all coefficients it is the difference of its own
parameters and the prior, in units of their joint covariance. Of another, with G the gains of the means, of covariance
C, and M those of the whitened rows, the estimate leaves e = p - p(beta) of the rows, of covariance

    S = (I - P M)(I - P M)^T + P G C G^T P^T

whose rank is 9, less the coefficients that the run alone does not determine. e^T S^+ e is then chi-squared if the block
is the one that it was.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.distributions import chi_squared_above
from tumble.documents.labels import is_believed, iso, measured_s, serial_of
from tumble.documents.result import Result, WorstNorm
from tumble.errors import BadInput, UsageError, quoted
from tumble.model.coefficients import NotSolvable, by_intrinsic, intrinsic, worst_norm
from tumble.model.errors import by_gains, covariance_of, sources
from tumble.model.estimators import design, null_space
from tumble.model.optimal import NOISE_FLOOR_G, Whitened, mean_sigma, samples_in_a_mean
from tumble.schedule import Schedule
from tumble.stand import ALWAYS, SOURCES, PerChannel, Stand

PARAMETERS = (
    *(f"scale_{axis}" for axis in "xyz"),
    *(f"angle_{pair}" for pair in ("xy", "xz", "yz")),
    *(f"bias_{axis}" for axis in "xyz"),
)
_PASSES = 30
_CONVERGED = 1e-8  # of max|K|: a step further is its square
_SEEN = 1e-9  # of the square of a change of the rows: less of it is rounding
_TOLD = 3.0  # standard uncertainties: a parameter that has changed by more is named


def parameters(k: Floats, u0: Floats) -> Floats:
    """p (9,)."""
    scale, angles, bias = intrinsic(k, u0)
    return np.concatenate([np.log(scale), angles, bias])


def by_parameters(k: Floats, u0: Floats) -> Floats:
    """P (9, 12)."""
    found = by_intrinsic(k, u0)
    found[:3] /= np.linalg.norm(k, axis=1)[:, None]
    return found


DAY_S = 86400.0
YEAR = 365.25  # days


@dataclass(frozen=True)
class Growth:
    """How the parameters of a block change: `walk` (9,) per square root of a day, `drift` (9,) per day, of its type,
    and its `spread` (9,) from block to block; `by`: "declared" or "history"."""

    walk: Floats
    drift: Floats
    spread: Floats
    by: str

    @classmethod
    def declared(cls, scale: float, angle: float, bias: float) -> Growth:
        """By standard deviations of what changes in a year, relative, in rad and in g."""
        return cls(np.repeat([scale, angle, bias], 3) / YEAR**0.5, np.zeros(9), np.zeros(9), "declared")

    def after(self, days: float) -> Floats:
        """Standard deviations (9,) of what has changed, beside the drift."""
        found: Floats = np.sqrt(self.walk**2 * days + (self.spread * days) ** 2)
        return found


@dataclass(frozen=True)
class Run:
    """What of a run decides whether a prior is for it: `serial` of the block, `unit` of the outputs, when it was
    measured, its hash, its `stand` (None: none is declared), and local gravity in m/s^2, None where it is not told."""

    serial: str | None
    unit: str
    measured_s: int
    sha256: str | None
    stand: Stand | None
    gravity_m_s2: float | None


@dataclass(frozen=True)
class Prior:
    """Of a block on the day of a run: `values` (9,) of the parameters and their `covariance` (9, 9), which has grown
    since; `k` (3, 3), `u0` (3,): the calibration that they came from, in the unit of the outputs.

    For whoever is told of it: `source`, its name; `created`, when it was measured; `days` since; `growth` (9,),
    standard deviations of what may have changed in these days, and `drift` (9,), what is expected to have, which
    `values` have in them; `growth_by` as in Growth; `temperature_c`: lowest and highest of its run, None: not told.
    """

    values: Floats
    covariance: Floats
    k: Floats
    u0: Floats
    source: str
    created: str
    days: float
    growth: Floats
    drift: Floats
    growth_by: str
    temperature_c: tuple[float, float] | None = None

    def rows(self, k: Floats, u0: Floats) -> tuple[Floats, Floats]:
        """The rows at these coefficients (9, 12), of covariance 1, and what is left of them there (9,)."""
        whiten = np.linalg.inv(np.linalg.cholesky(self.covariance))
        return whiten @ by_parameters(k, u0), whiten @ (self.values - parameters(k, u0))

    @property
    def worst_norm(self) -> WorstNorm:
        """Where |a| is least certain by the prior alone: a turn of the block, which it leaves open, does not count."""
        back = np.linalg.pinv(by_parameters(self.k, self.u0))
        return worst_norm(self.k, back @ self.covariance @ back.T)


@dataclass(frozen=True)
class LastCalibration:
    """The `result` that may be a prior, which messages call `name`, of the block `serial`, measured then (None: nobody
    says), and the `growth` of its block since."""

    result: Result
    name: str
    growth: Growth
    serial: str | None
    measured_s: int | None

    @classmethod
    def of(cls, result: Result, name: str, growth: Growth) -> LastCalibration:
        """As the result says it itself. Raises BadInput for a date that is none."""
        try:
            measured = measured_s(result.item, result.environment, result.created)
        except ValueError as error:
            raise BadInput(str(error), name) from None
        return cls(result, name, growth, serial_of(result.serial, result.item), measured)

    def at(self, run: Run) -> Prior:
        """As it is known on the day of a run. Raises BadInput where it is no prior for it."""
        told = self.result
        k, u0, covariance, measured = self._usable()
        self._require_same_block(run)
        days = (run.measured_s - measured) / DAY_S
        if days <= -1.0:
            raise self._refused(f"was measured on {iso(measured)[:10]}, after this run ({iso(run.measured_s)[:10]})")
        days = max(0.0, days)  # a date has no hours
        by_parameter = by_parameters(k, u0)
        growth, drift = self.growth.after(days), self.growth.drift * days
        values = parameters(k, u0) + drift
        gravity = (told.environment or {}).get("gravity_m_s2")
        if run.gravity_m_s2 is not None and gravity is not None:  # both in units of the local one
            ratio = run.gravity_m_s2 / float(gravity)
            values[:3] += np.log(ratio)
            values[6:] /= ratio
        own = by_parameter @ covariance @ by_parameter.T
        return Prior(
            values=values,
            covariance=own + np.diag(growth**2),
            k=k,
            u0=u0,
            source=self.name,
            created=iso(measured),
            days=days,
            growth=growth,
            drift=drift,
            growth_by=self.growth.by,
            temperature_c=None if told.temperature is None else (told.temperature.min_c, told.temperature.max_c),
        )

    def _usable(self) -> tuple[Floats, Floats, Floats, int]:
        """K, U0, their covariance, and the day. Raises BadInput."""
        told = self.result
        if told.covariance is None:
            raise self._refused("has no covariance: a prior needs one; solve its run with a stand file")
        if told.extended is not None:
            raise self._refused(f"has {', '.join(told.extended.terms)} in its model: a prior has the twelve alone")
        if not is_believed(told):
            raise self._refused("failed its gravity check or does not fit its stand: no prior")
        if self.measured_s is None:
            raise self._refused("has no date (key created): nobody knows how much its block has changed")
        return told.K, told.U0, told.covariance, self.measured_s

    def _require_same_block(self, run: Run) -> None:
        told = self.result
        if run.serial is None:
            raise UsageError("--prior: this run names no block: write serial under [block] of the stand file")
        if self.serial != run.serial:
            whose = "names no block" if self.serial is None else f"is of block {quoted(self.serial)}"
            raise self._refused(f"{whose}, this run is of {quoted(run.serial)}")
        if told.unit != run.unit:
            raise self._refused(f"has outputs in {told.unit}, this run in {run.unit}")
        if told.run_sha256 is not None and told.run_sha256 == run.sha256:
            raise self._refused("is of this very run: a prior is of an earlier one")
        if told.stand is None or run.stand is None or (told.stand.name or "") != run.stand.name:
            return
        if kept := [one.key for one in SOURCES.values() if one.returns == ALWAYS and getattr(run.stand, one.attribute)]:
            raise self._refused(
                f"is of the same stand, which keeps its {' and '.join(kept)}: the two are not independent"
            )

    def _refused(self, why: str) -> BadInput:
        return BadInput(why, self.name)


@dataclass(frozen=True)
class Change:
    """Of a parameter, if it alone has changed: its `size` and standard uncertainty `u`, relative, in rad or g."""

    parameter: str
    size: float
    u: float


@dataclass(frozen=True)
class PriorTest:
    """Of the difference of run and prior: `chi_squared` with `freedom`; `p`: how often a block that has not changed
    comes out above; `change` (9,) of each parameter, if it alone has changed, and its standard uncertainty `u_change`
    (9,), infinite where the run does not show it."""

    chi_squared: float
    freedom: int
    p: float
    change: Floats
    u_change: Floats

    @property
    def changes(self) -> tuple[Change, ...]:
        """Those that explain the difference by themselves, the likeliest first."""
        by_u = np.abs(self.change) / self.u_change
        likeliest = [i for i in np.argsort(-by_u, kind="stable").tolist() if by_u[i] > _TOLD]
        return tuple(Change(PARAMETERS[i], float(self.change[i]), float(self.u_change[i])) for i in likeliest)


@dataclass(frozen=True)
class WithPrior:
    """An estimate from the means of a run and a prior: `k` (3, 3), `u0` (3,), their `covariance` (12, 12), `gains` (12,
    3 x fit positions) of the means, and the `test` of the prior."""

    k: Floats
    u0: Floats
    covariance: Floats
    gains: Floats
    test: PriorTest


@dataclass(frozen=True)
class Given:
    """What beside means and prior makes an estimate: `schedule`, all of it measured, `stand` and the converter's `step`
    in the unit of the outputs, `samples` (positions,) of each mean."""

    schedule: Schedule
    stand: Stand
    samples: Integers
    step: PerChannel = 0.0

    def whitened(self, k: Floats, rows: Floats) -> Whitened:
        """The problem at this K."""
        number = samples_in_a_mean(self.schedule, self.stand, self.samples)
        sigma = mean_sigma(k, self.stand, self.step, number)[0]
        return Whitened(self.schedule, k, self.stand, sigma, (), rows)

    def gains(self, k: Floats, u0: Floats, prior: Prior) -> tuple[Floats, Floats]:
        """Of the means (12, 3 x fit positions) and of the rows (12, 9)."""
        whitened = self.whitened(k, prior.rows(k, u0)[0])
        return whitened.gains, whitened.gains_of_rows

    def by_run(self, gains: Floats, k: Floats, variance: Floats | None) -> Floats:
        """Covariance (12, 12) that the run brings by these gains; `variance` (positions, 3) of the means, by the noise
        as measured, where it counts for more than the stand's."""
        least = (NOISE_FLOOR_G * np.abs(k).max()) ** 2
        floored = np.maximum(0.0 if variance is None else variance, least)
        errors = sources(self.schedule, k, self.stand.with_step(self.step), self.samples, floored)
        return covariance_of(by_gains(self.schedule, gains), errors)

    def covariance(self, k: Floats, u0: Floats, prior: Prior, variance: Floats | None) -> Floats:
        """Of an estimate with a prior (12, 12)."""
        gains, of_rows = self.gains(k, u0, prior)
        found: Floats = self.by_run(gains, k, variance) + of_rows @ of_rows.T
        return found


def estimate_with_prior(
    given: Given,
    means: Floats,
    prior: Prior,
    variance: Floats | None = None,
    start: tuple[Floats, Floats] | None = None,
) -> WithPrior:
    """Of the `means` (positions, 3); `variance` as of Given.by_run; `start`: K and U0 to begin at, those of the prior
    unless given. Raises NotSolvable where the two have so little in common that there is no estimate."""
    k, u0 = (prior.k, prior.u0) if start is None else start
    fitted = means[None, given.schedule.fit_indices]
    for _ in range(_PASSES):
        before = np.concatenate([k.ravel(), u0])
        rows, left = prior.rows(k, u0)
        x, _ = given.whitened(k, rows).solve_exactly(fitted, left + rows @ before)
        k, u0 = x[0, -12:-3].reshape(3, 3), x[0, -3:]
        if not (np.isfinite(x).all() and np.linalg.norm(k, axis=1).min() > 0.0):
            break
        if np.abs(x[0, -12:] - before).max() <= _CONVERGED * np.abs(k).max():
            gains, of_rows = given.gains(k, u0, prior)
            brought = given.by_run(gains, k, variance)
            covariance = brought + of_rows @ of_rows.T
            return WithPrior(k, u0, covariance, gains, _test(given.schedule, prior, k, u0, of_rows, brought))
    raise NotSolvable("run and prior have no coefficients in common: axes or mountings exchanged, or another block")


def difference_test(prior: Prior, k: Floats, u0: Floats, covariance: Floats) -> PriorTest:
    """Of an estimate without the prior: K (3, 3), U0 (3,) and their covariance (12, 12). However far the two are from
    each other, nothing is linearised between them."""
    by = by_parameters(k, u0)
    inverse = np.linalg.inv(by @ covariance @ by.T + prior.covariance)
    difference = parameters(k, u0) - prior.values
    chi_squared, pull, variance = float(difference @ inverse @ difference), inverse @ difference, np.diag(inverse)
    p = chi_squared_above(chi_squared, len(difference))
    return PriorTest(chi_squared, len(difference), p, pull / variance, 1.0 / np.sqrt(variance))


def _test(schedule: Schedule, prior: Prior, k: Floats, u0: Floats, of_rows: Floats, brought: Floats) -> PriorTest:
    """At the estimate; `brought` (12, 12): covariance by the run."""
    rows, left = prior.rows(k, u0)
    own = np.eye(len(rows)) - rows @ of_rows  # what a change of a row leaves of itself
    spread = own @ own.T + rows @ brought @ rows.T
    freedom = len(rows) - len(null_space(design(schedule)))
    sizes, directions = np.linalg.eigh(spread)
    shown = directions[:, -freedom:] if freedom else directions[:, :0]
    inverse = (shown / sizes[len(sizes) - freedom :]) @ shown.T
    chi_squared = float(left @ inverse @ left)
    columns = np.linalg.inv(np.linalg.cholesky(prior.covariance))  # what a unit of each parameter does to the rows
    gain = np.einsum("ip,ij,jp->p", columns, inverse @ own, columns)
    seen = gain > _SEEN * (columns**2).sum(axis=0)
    gain = np.where(seen, gain, 1.0)
    change = np.where(seen, -columns.T @ inverse @ left / gain, 0.0)  # of the block, not of what was known
    u_change = np.where(seen, np.sqrt(np.einsum("ip,ij,jp->p", columns, inverse, columns)) / gain, np.inf)
    return PriorTest(chi_squared, freedom, chi_squared_above(chi_squared, freedom), change, u_change)
