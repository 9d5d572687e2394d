"""The weights gamma1 to gamma5 of equation (2): what one unit of each source does to each coefficient.

Weights have the shape (12, 5): rows as in published.NAMES, columns as in published.SOURCES; derived ones have a further
column for each of FURTHER that the stand declares. A coefficient of K counts
relative to itself, a bias as U0_i/K_ii in g; angles are in radians and the noise is that of a position's mean. A row
is NaN where the coefficient is zero, and so has no relative error. Signs being unknown, weights are not negative.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.errors import UsageError
from tumble.estimators import ESTIMATORS, HARMONIC, OPTIMAL
from tumble.planning.case import Case
from tumble.planning.published import NAMES, REFINED, SOURCES, TABLE_1, TABLE_1_CORRECTED, TABLE_4, evaluate
from tumble.reference.estimators import paper_slots
from tumble.solving import extended
from tumble.solving.gains import Linearised, gains, linearise, optimal_table
from tumble.stand import COMMON, PAPER_STAND, Stand
from tumble.terms import EXTENDABLE

FURTHER = ("seat", "platform", "encoder", "drift")
OF_OUTPUTS = ("noise", "drift")  # in volts; the others are angles
WORST = "worst"
QUADRATURE = "quadrature"
_ROUNDING = 1e-13
_CHANNELS = np.r_[np.repeat(np.arange(3), 3), np.arange(3)]  # of the rows


def estimator_gains(case: Case, estimator: str, k: Floats) -> Floats:
    """Gains (12, 3 x fit positions) of an estimator; those of optimal are for the case's stand and this K."""
    return all_gains(case, estimator, k)[:12]


def all_gains(case: Case, estimator: str, k: Floats) -> Floats:
    """The same, and those of the sizes of the case's further terms: (12 + 3 x terms, 3 x fit positions)."""
    if not case.terms:
        return gains(case.fitted, estimator, k, case.stand, case.step_v)
    run = core.CoreSchedule(case.schedule)
    if estimator != OPTIMAL:
        return extended.gains(run, case.terms)
    return optimal_table(case.fitted, k, case.stand, case.step_v, None, extended.fitted_columns(run, case.terms)).gains


def estimators_of(case: Case) -> tuple[str, ...]:
    """Those that find all that the case's model has, in as many mountings as they can."""
    names = EXTENDABLE if case.terms else ESTIMATORS
    return tuple(name for name in names if name != OPTIMAL or len(case.schedule.mountings) <= core.MAX_YAWS)


def sources_of(stand: Stand) -> tuple[str, ...]:
    """The columns of derived weights: published.SOURCES, and those of FURTHER that the stand declares."""
    return (*SOURCES, *(name for name in FURTHER if np.any(getattr(stand, name))))


def absolute_weights(
    model: Linearised,
    common_yaw: bool,
    k: Floats,
    gain_rows: Floats,
    sources: tuple[str, ...] = SOURCES,
    stand: Stand = PAPER_STAND,
) -> Floats:
    """Weights (rows, sources) in the units of the rows (V/g, V), for any linear gains (rows, 3P) of the fit positions.

    Draws of one kind are independent: yaws of several mountings, set angles and noise add in quadrature. What cancels
    to rounding is zero. Noise and drift count as those of the channel that has most; the others have theirs in
    proportion, as the `stand` declares them.
    """
    rows = gain_rows.reshape(len(gain_rows), -1, 3)
    mountings = np.unique(model.mounting)[:, None] == model.mounting
    yaws = np.ones((1, len(model.mounting)), dtype=bool) if common_yaw else mountings

    def in_quadrature(sums: Floats, largest: Floats) -> Floats:
        rounded = np.abs(sums) <= _ROUNDING * largest.max(axis=1, keepdims=True)
        sizes: Floats = np.linalg.norm(np.where(rounded, 0.0, sums), axis=1)
        return sizes

    def of(force: Floats, draws: Floats) -> Floats:
        parts = rows * (force @ k.T)
        return in_quadrature(parts.sum(axis=2) @ draws.T, np.abs(parts).sum(axis=2) @ np.abs(draws).T)

    together, each = np.ones_like(yaws[:1]), np.eye(len(model.mounting), dtype=bool)
    drifts = rows * model.course[:, None] * stand.profile("drift")
    found = {
        "alpha1": of(model.alpha1, together),
        "alpha2": of(model.delta, together),
        "alpha3": of(model.alpha3, yaws),
        "alpha4": of(model.delta, each),
        "noise": np.linalg.norm(gain_rows * np.tile(stand.profile("noise"), rows.shape[1]), axis=1),
        "seat": np.hypot(of(model.theta_h, mountings), of(model.delta, mountings)),
        "platform": of(model.theta_h, together),
        "encoder": of(model.delta, model.waves.T),
        "drift": in_quadrature(drifts.sum(axis=1), np.abs(drifts).sum(axis=1)),
    }
    return np.stack([found[source] for source in sources], axis=1)


def reference_values(k: Floats) -> Floats:
    """What each of the twelve is related to (12,): a coefficient of K to itself, a bias to K_ii; NaN for zero."""
    values = np.abs(np.concatenate([k.ravel(), np.diag(k)]))
    return np.where(values > 0.0, values, np.nan)


def derived(case: Case, estimator: str, k: Floats) -> Floats:
    """The weights of an estimator on the exact geometry, to first order, for a block of sensitivity `k`."""
    model, common = linearise(case.fitted), case.stand.remounting == COMMON
    rows, sources = estimator_gains(case, estimator, k), sources_of(case.stand)
    return absolute_weights(model, common, k, rows, sources, case.stand) / reference_values(k)[:, None]


def published_formulas(estimator: str) -> dict[str, tuple[str, ...]]:
    """Table 1, its misprint corrected, with Table 4's rows for K_yx and K_zx where formula (7) is used.

    Raises UsageError for an estimator that the paper does not have.
    """
    if estimator not in HARMONIC:
        raise UsageError(f"--weights published: the paper has averaged and refined, not {estimator}")
    rows = {name: list(formulas) for name, formulas in TABLE_1.items()}
    for (name, source), formula in TABLE_1_CORRECTED.items():
        rows[name][SOURCES.index(source)] = formula
    if estimator == "refined":
        rows.update({name: list(TABLE_4[single]) for name, single in REFINED.items()})
    return {name: tuple(formulas) for name, formulas in rows.items()}


def published(case: Case, estimator: str, signs: str = QUADRATURE) -> Floats:
    """The paper's weights. Of the misalignments' signs, which are unknown, either the WORST counts, or all of them do:
    QUADRATURE, as Table 2 has it.

    Raises UsageError where the paper has no weights: another estimator, or other positions.
    """
    formulas = published_formulas(estimator)
    if len(case.fitted.positions) != 18 or paper_slots(case.fitted) is None:
        raise UsageError("--weights published: the paper's weights are for its own 2 x 9 positions")
    values = np.array([_evaluated(case, formulas, pattern) for pattern in product((1.0, -1.0), repeat=6)])
    found: Floats = np.abs(values).max(axis=0) if signs == WORST else np.sqrt((values**2).mean(axis=0))
    return found


def _evaluated(case: Case, formulas: dict[str, tuple[str, ...]], signs: tuple[float, ...]) -> Floats:
    """Weights (12, 5) for one choice of the misalignments' signs."""
    pattern = np.eye(3)
    pattern[~np.eye(3, dtype=bool)] = signs
    values = symbols(case.nominal_k(pattern))
    rows = np.array([[evaluate(formula, values) for formula in formulas[name]] for name in NAMES])
    rows[np.isnan(rows).any(axis=1)] = np.nan
    rows[:, SOURCES.index("noise")] *= case.stand.profile("noise")[_CHANNELS]
    return rows


def symbols(k: Floats) -> dict[str, float]:
    """The paper's symbols for a block: K_ij, and the misalignment a_ji = K_ij/K_ii (an element over its row's own)."""
    axes = "xyz"
    values = {f"K_{axes[i]}{axes[j]}": float(k[i, j]) for i in range(3) for j in range(3)}
    values.update({f"a_{axes[j]}{axes[i]}": float(k[i, j] / k[i, i]) for i in range(3) for j in range(3) if i != j})
    return values
