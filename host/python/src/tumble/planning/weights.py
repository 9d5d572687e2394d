"""The weights gamma1 to gamma5 of equation (2): what one unit of each source does to each coefficient.

Weights have the shape (12, 5): rows as in published.NAMES, columns as in published.SOURCES; derived ones have a further
column for every other source that the stand declares. A coefficient of K counts
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
from tumble.model.errors import NOISE, OF_OUTPUTS, declared, unit_effect
from tumble.model.estimators import paper_slots
from tumble.planning.case import Case
from tumble.planning.published import NAMES, REFINED, SOURCES, TABLE_1, TABLE_1_CORRECTED, TABLE_4, evaluate
from tumble.schedule import Schedule
from tumble.stand import COMMON, PAPER_STAND, Stand
from tumble.terms import EXTENDABLE

WORST = "worst"
QUADRATURE = "quadrature"
_ROUNDING = 1e-13
_CHANNELS = np.r_[np.repeat(np.arange(3), 3), np.arange(3)]  # of the rows


def estimator_gains(case: Case, estimator: str, k: Floats) -> Floats:
    """Gains (12, 3 x fit positions) of an estimator; those of optimal are for the case's stand and this K."""
    return case.propagation(estimator, k).gains[:12]


def estimators_of(case: Case) -> tuple[str, ...]:
    """Those that find all that the case's model has, in as many mountings as they can."""
    names = EXTENDABLE if case.terms else ESTIMATORS
    return tuple(name for name in names if name != OPTIMAL or len(case.schedule.mountings) <= core.MAX_YAWS)


def sources_of(stand: Stand) -> tuple[str, ...]:
    """The columns of derived weights: published.SOURCES, and all others that the stand declares."""
    return (*SOURCES, *(name for name in declared(stand) if name not in SOURCES))


def absolute_weights(
    schedule: Schedule,
    common_yaw: bool,
    k: Floats,
    gain_rows: Floats,
    sources: tuple[str, ...] = SOURCES,
    stand: Stand = PAPER_STAND,
) -> Floats:
    """Weights (rows, sources) in the units of the rows (V/g, V), for any linear gains (rows, 3P) of the positions of a
    schedule, all of them fitted.

    Draws of one kind are independent: yaws of several mountings, set angles and noise add in quadrature. What cancels
    to rounding is zero. Noise and drift count as those of the channel that has most; the others have theirs in
    proportion, as the `stand` declares them.
    """
    found = []
    for name in sources:
        if name == NOISE:
            profile = np.tile(stand.profile("noise"), len(schedule.positions))
            found.append(np.linalg.norm(gain_rows * profile, axis=1))
            continue
        draws = unit_effect(schedule, name, common_yaw).derivative(k)
        if name in OF_OUTPUTS:
            draws = draws * stand.profile(name)[:, None, None]
        by_draw = draws.reshape(len(draws), -1).T
        sums, largest = gain_rows @ by_draw, np.abs(gain_rows) @ np.abs(by_draw)
        rounded = np.abs(sums) <= _ROUNDING * largest.max(axis=1, keepdims=True)
        found.append(np.linalg.norm(np.where(rounded, 0.0, sums), axis=1))
    return np.stack(found, axis=1)


def reference_values(k: Floats) -> Floats:
    """What each of the twelve is related to (12,): a coefficient of K to itself, a bias to K_ii; NaN for zero."""
    values = np.abs(np.concatenate([k.ravel(), np.diag(k)]))
    return np.where(values > 0.0, values, np.nan)


def derived(case: Case, estimator: str, k: Floats) -> Floats:
    """The weights of an estimator on the exact geometry, to first order, for a block of sensitivity `k`."""
    rows, common = estimator_gains(case, estimator, k), case.stand.remounting == COMMON
    given = case.fitted, common, k, rows, sources_of(case.stand), case.stand
    return absolute_weights(*given) / reference_values(k)[:, None]


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
