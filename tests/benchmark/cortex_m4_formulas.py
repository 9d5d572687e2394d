"""The formulas of the rows of cortex_m4.py, as far as they are counted."""

import arithmetic
import numpy as np

from tumble import core
from tumble.model import estimators
from tumble.model.optimal import optimal_table
from tumble.stand import PAPER_STAND


def formulas():
    """Operations of a row's formula, {kind: number}. For a schedule that is known, least squares are constant gains."""
    paper = core.built_in("paper")
    outputs, column = np.ones((18, 3)).tolist(), np.ones((54, 1)).tolist()
    ideal = estimators.linear_gains(paper, "least_squares")
    optimal = optimal_table(paper, np.full((3, 3), 0.04) + 1.96 * np.eye(3), PAPER_STAND).gains
    each, table_alone = (arithmetic.linear(without_rounding(one)) for one in (ideal, optimal))
    found = {
        "refined": (arithmetic.refined(estimators.circles(paper)), outputs),
        "least_squares: 4 unknowns": (each, column),
        "4 unknowns, shared normal matrix": (each, column),
        "optimal, linear: table alone": (table_alone, column),
        "division of the 54 means": (arithmetic.means, [[50.0, 50.0, 1e-6]] * 54),
    }
    for name, row in zip(("three_mountings", "diagonal"), ("refined, three mountings", "refined, diagonal")):
        schedule = core.built_in(name)
        shape = len(schedule.positions), 3
        found[row] = arithmetic.refined(estimators.circles(schedule)), np.ones(shape).tolist()
    return {name: arithmetic.counted(*one)[0] for name, one in found.items()}


def without_rounding(table):
    """Gains that are zero but for rounding, as zeros."""
    return np.where(np.abs(table) < 1e-12 * np.abs(table).max(), 0.0, table)
