"""The weights gamma1 to gamma5 of equation (2): what one unit of each source does to each coefficient.

Weights have the shape (12, 5): rows as in NAMES, columns as in SOURCES; derived ones have a further column for every
other source that the stand declares. A coefficient of K counts relative to itself, a bias as U0_i/K_ii in g; angles are
in radians and the noise is that of a position's mean. A row is NaN where the coefficient is zero, and so has no
relative error. Signs being unknown, weights are not negative.

Published weights are those of the paper, whose numbers stand here as printed (decimal points for decimal commas):
M. Chernyak, V. Rybak, V. Paliushok, "Ensuring the given accuracy of calibrating a three-axis block of navigation
accelerometers on a single-axis rotary stand" (in Ukrainian). Formulas have a_ij for the misalignments, K_ij for the
coefficients, g = 1 and dg for the acceptance limit; `evaluate` gives their value.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from itertools import product

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.errors import UsageError
from tumble.estimators import ESTIMATORS, HARMONIC, INCLINED, LINEAR, OPTIMAL
from tumble.model.errors import NOISE, OF_OUTPUTS, declared, unit_effect
from tumble.model.estimators import paper_slots
from tumble.planning.case import Case
from tumble.schedule import Schedule
from tumble.stand import COMMON, PAPER_STAND, Stand
from tumble.terms import EXTENDABLE

SOURCES = ("alpha1", "alpha2", "alpha3", "alpha4", "noise")
NAMES = (*tuple(f"K_{i}{j}" for i in "xyz" for j in "xyz"), "a0_x", "a0_y", "a0_z")

# Equation (5) and the text around it. The noise is that of one sample; grouping 50 divides it "by 7".
STAND_5 = {"alpha1": "2e-5", "alpha2": "2e-5", "alpha3": "4e-4", "alpha4": "4e-5", "noise": "3e-4"}
GROUP_SAMPLES = 50
GROUP_FACTOR = "7"

# Table 1: gamma1 to gamma5 of the averaged estimates.
TABLE_1 = {
    "K_xx": ("0", "(a_yx - a_zx)/2", "(a_zx - a_yx)/2", "0.1", "0.2/K_xx"),
    "K_yy": ("0", "a_xy", "0", "0.15", "0.3/K_yy"),
    "K_zz": ("0", "a_xz", "0", "0.15", "0.3/K_zz"),
    "a0_x": ("(a_yx + a_zx)/2", "0", "0", "0.4", "0.4/K_xx"),
    "a0_y": ("0.5", "0", "0", "0.2", "0.2/K_yy"),
    "a0_z": ("0.5", "0", "0", "0.2", "0.2/K_zz"),
    "K_xy": ("0", "-1/a_yx", "0", "0.55/a_yx", "0.55/K_xy"),
    "K_xz": ("0", "a_zx", "0", "0.55/a_zx", "0.55/K_xz"),
    "K_yx": ("0", "0.5/a_xy", "-0.5/a_xy", "0.2/a_xy", "0.25/K_yx"),
    "K_yz": ("0", "1", "0", "0.55", "0.55/K_yz"),
    "K_zx": ("0", "-0.5/a_xz", "0.5/a_xz", "0.2/a_xz", "0.25/K_zx"),
    "K_zy": ("0", "-1", "0", "0.55", "0.55/K_zy"),
}
# A misprint: without it Table 3 would not say 1600 ppm.
TABLE_1_CORRECTED = {("K_xz", "alpha2"): "1/a_zx"}

# Table 2: the five contributions of three coefficients, relative or in g, for one sample.
TABLE_2 = {
    "K_xx": ("0", "1.5e-7", "6e-6", "4e-6", "3e-5"),
    "a0_x": ("5e-8", "0", "0", "1.6e-5", "6e-5"),
    "K_xy": ("0", "1e-3", "0", "1.1e-3", "4.1e-3"),
}

# Table 3: their sums with 50 samples, in ppm; biases in mg.
TABLE_3 = dict(zip(TABLE_1, "9 9 9 0.01 0.01 0.01 1600 1600 10500 590 10500 590".split()))

# Table 4: gamma1 to gamma5 of K_yx and K_zx from one mounting alone.
TABLE_4 = {
    "K1_yx": ("0", "1", "-1/a_xy", "0.4", "0.4/K_yx"),
    "K2_yx": ("0", "1/a_xy", "1", "0.4/a_xy", "0.4/K_yx"),
    "K1_zx": ("0", "-1/a_xz", "-1", "0.4/a_xz", "0.4/K_zx"),
    "K2_zx": ("0", "1", "1/a_xz", "0.4", "0.4/K_zx"),
}
REFINED = {"K_yx": "K2_yx", "K_zx": "K1_zx"}  # formula (7)

EQUATION_6_PPM = {"K1_yx": "20000", "K2_yx": "1400", "K1_zx": "1400", "K2_zx": "20000"}

# (18): from K_yy alone; (19): in general; (20): the limit. a_ij stands for the largest misalignment.
EQUATION_18 = {"alpha2": "dg/(5.2*a_xy)", "alpha4": "dg/0.8", "noise": "dg*K_yy/1.6"}
EQUATION_19 = {
    "alpha1": "dg/2.6",
    "alpha2": "dg/(5.2*a_ij)",
    "alpha3": "dg/a_ij",
    "alpha4": "dg/0.8",
    "noise": "dg*K_ii/3",
}
LIMIT_20_G = "3e-4"
TABLE_5_REQUIRED = {"alpha1": "1.5e-4", "alpha2": "3e-3", "alpha3": "15e-3", "alpha4": "4e-4", "noise": "2e-4"}
TABLE_5_USED = {"alpha1": "2e-5", "alpha2": "2e-5", "alpha3": "4e-4", "alpha4": "4e-5", "noise": "3e-4"}

_OPERATIONS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}


def evaluate(formula: str, values: dict[str, float]) -> float:
    """A printed formula's value: numbers, the names in `values`, + - * / and brackets. A division by zero gives NaN."""

    def value_of(node: ast.expr) -> float:
        match node:
            case ast.Constant(int() | float() as number):
                return float(number)
            case ast.Name(name):
                return values[name]
            case ast.UnaryOp(ast.USub(), operand):
                return -value_of(operand)
            case ast.BinOp(left, operation, right):
                return _OPERATIONS[type(operation)](value_of(left), value_of(right))
        raise ValueError(f"{formula}: {ast.unparse(node)} is no part of a printed formula")

    try:
        return value_of(ast.parse(formula, mode="eval").body)
    except ZeroDivisionError:
        return float("nan")


WORST = "worst"
QUADRATURE = "quadrature"
_ROUNDING = 1e-13
_CHANNELS = np.r_[np.repeat(np.arange(3), 3), np.arange(3)]  # of the rows


def estimator_gains(case: Case, estimator: str, k: Floats) -> Floats:
    """Gains (12, 3 x fit positions) of an estimator; those of optimal are for the case's stand and this K."""
    return case.propagation(estimator, k).gains[:12]


def estimators_of(case: Case) -> tuple[str, ...]:
    """Those that find all that the case's model has, in as many mountings as they can, inclined or not."""
    names = [name for name in ESTIMATORS if not case.terms or name in EXTENDABLE]
    too_many = len(case.schedule.mountings) > core.MAX_YAWS
    of_inclinations = (INCLINED, OPTIMAL) if case.schedule.is_inclined else (*LINEAR, OPTIMAL)
    return tuple(name for name in names if name in of_inclinations and not (name == OPTIMAL and too_many))


def sources_of(case: Case) -> tuple[str, ...]:
    """The columns of derived weights: SOURCES, and all others that the stand declares."""
    return (*SOURCES, *(name for name in declared(case.stand, case.schedule) if name not in SOURCES))


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
    given = case.fitted, common, k, rows, sources_of(case), case.stand
    return absolute_weights(*given) / reference_values(k)[:, None]


def published(case: Case, estimator: str, signs: str = QUADRATURE) -> Floats:
    """The paper's weights. Of the misalignments' signs, which are unknown, either the WORST counts, or all of them do:
    QUADRATURE, as Table 2 has it. They are Table 1, its misprint corrected, with Table 4's rows for K_yx and K_zx where
    formula (7) is used.

    Raises UsageError where the paper has no weights: another estimator, or other positions.
    """
    if estimator not in HARMONIC:
        raise UsageError(f"--weights published: the paper has averaged and refined, not {estimator}")
    if len(case.fitted.positions) != 18 or paper_slots(case.fitted) is None:
        raise UsageError("--weights published: the paper's weights are for its own 2 x 9 positions")
    rows = {name: list(formulas) for name, formulas in TABLE_1.items()}
    for (name, source), formula in TABLE_1_CORRECTED.items():
        rows[name][SOURCES.index(source)] = formula
    if estimator == "refined":
        rows.update({name: list(TABLE_4[single]) for name, single in REFINED.items()})
    values = np.array([_evaluated(case, rows, pattern) for pattern in product((1.0, -1.0), repeat=6)])
    found: Floats = np.abs(values).max(axis=0) if signs == WORST else np.sqrt((values**2).mean(axis=0))
    return found


def _evaluated(case: Case, formulas: dict[str, list[str]], signs: tuple[float, ...]) -> Floats:
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
