"""What runs at several temperatures could not have shown, all together: model.reliability of K(T) and U0(T).

A property of the block, such as a third order, is the same in all runs; anything else happens in one of them. The error
of |a| that is left is the largest over all attitudes and the temperatures of the range.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from tumble.arrays import Floats
from tumble.model.coefficients import norm_gradient, spread_attitudes
from tumble.model.errors import NOISE, declared
from tumble.model.fit import DOUBTS, shown_by_residuals
from tumble.model.patterns import BLOCK, PATTERNS, Columns, Pattern, Scene
from tumble.model.reliability import BESIDE, Reliability, in_order, worst_of, worst_place
from tumble.model.thermal import Polynomials, System, ThermalRun
from tumble.stand import SOURCES, Stand

_ATTITUDES = 500
_TEMPERATURES = 5  # of the range


def reliability(
    runs: Sequence[ThermalRun],
    found: Polynomials,
    range_c: tuple[float, float],
    stand: Stand,
    confidence: float,
    kept: Collection[str] = (),
) -> Reliability:
    """Of runs that were solved as `found`, on a `stand` and with errors `kept` as model.thermal.fit has them."""
    joint = _Joint(runs, found, kept)
    attitudes, grid = spread_attitudes(_ATTITUDES), np.linspace(*range_c, _TEMPERATURES)
    gradient = np.concatenate([_gradient(found, t, attitudes) for t in grid.tolist()])
    false_alarms, taken_up, unseen = (1.0 - confidence) / (len(PATTERNS) + BESIDE), _taken_up(runs, stand), []
    for pattern in (one for one in PATTERNS if one.name not in taken_up):
        variants = joint.variants(pattern)
        in_use = None
        if pattern.lasts:  # by the block at the reference temperature
            lasting = pattern.columns(Scene(runs[0].schedule, found.k[0], attitudes))[0]
            in_use = {name: np.tile(one, (_TEMPERATURES, 1)) for name, one in lasting.items()}
        given = joint, found.k[0], joint.gains, gradient, pattern
        share = false_alarms / len(variants)
        unseen += worst_place(worst_of(*given, columns, in_use, share) for columns in variants)
    return in_order(unseen)


def _taken_up(runs: Sequence[ThermalRun], stand: Stand) -> set[str]:
    """Patterns that the declared stand contains: their effects are in the uncertainties."""
    names = {name for run in runs for name in declared(stand, run.schedule)}
    return {*DOUBTS, *(pattern for name in names for pattern in SOURCES[name].patterns)}


def _gradient(found: Polynomials, temperature_c: float, attitudes: Floats) -> Floats:
    """Of how much the length of a calibrated acceleration falls short, by all coefficients (attitudes, n)."""
    at, k = temperature_c - found.reference_c, found.at(temperature_c)[0]
    return np.hstack([at**power * norm_gradient(k, attitudes) for power in range(len(found.k))])


class _Joint:
    """The linearised system of all runs without errors. `gains` (n, outputs): of the coefficients."""

    def __init__(self, runs: Sequence[ThermalRun], found: Polynomials, kept: Collection[str]):
        self._runs, self._found = runs, found
        count = len(found.k)
        scale = max(float(np.abs(one.temperature_c - found.reference_c).max()) for one in runs) or 1.0
        system = System(runs, count - 1, [(one.temperature_c - found.reference_c) / scale for one in runs], kept)
        powers = np.repeat(scale ** np.arange(float(count)), 12)
        beta = np.hstack([found.k.reshape(count, 9), found.u0]).ravel() * powers
        rows = system.linearised(beta, np.zeros(system.count))[0]
        length = np.sqrt((rows**2).sum(axis=0))
        self._q, r = np.linalg.qr(rows / length)
        self._noise = np.concatenate([one.found[NOISE].sigma for one in runs])
        outputs, unknowns = len(self._noise), len(beta)
        self._coefficients = np.linalg.qr(rows[:outputs, :unknowns])[0]
        of_rows = np.linalg.solve(r, self._q[:outputs].T)[:unknowns]
        self.gains = of_rows / (length[:unknowns] * powers)[:, None] / self._noise

    def variants(self, pattern: Pattern) -> list[Columns]:
        """Outputs of all runs (positions of all, 3), by variant."""
        mean_k = [self._found.at(float(one.temperature_c.mean()))[0] for one in self._runs]
        own = [pattern.columns(Scene(one.schedule, k)) for one, k in zip(self._runs, mean_k)]
        nothing = [np.zeros((len(one.temperature_c), 3)) for one in self._runs]
        if pattern.whose == BLOCK:
            names = own[0][0]
            return [{name: np.concatenate([one[0][name] for one in own]) for name in names}]
        return [
            {name: np.concatenate([*nothing[:place], one, *nothing[place + 1 :]]) for name, one in columns.items()}
            for place, variants in enumerate(own)
            for columns in variants
        ]

    def whitened(self, columns: Columns) -> Floats:
        """As WholeModel.whitened, in other coordinates."""
        outputs = np.array([one.ravel() / self._noise for one in columns.values()]).T
        of_unknowns = self._q[: len(outputs)].T @ outputs
        shown = -self._q @ of_unknowns
        shown[: len(outputs)] += outputs
        return shown_by_residuals(outputs, shown, self._coefficients)
