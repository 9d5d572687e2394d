"""The paper's tables and formulas computed again from its own weights and from the geometry, beside what is printed."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from decimal import Decimal

import numpy as np

from tumble.arrays import Floats
from tumble.model.errors import felt
from tumble.model.estimators import linear_gains
from tumble.planning import weights
from tumble.planning.case import Case
from tumble.planning.published import (
    EQUATION_6_PPM,
    EQUATION_18,
    EQUATION_19,
    GROUP_FACTOR,
    LIMIT_20_G,
    NAMES,
    SOURCES,
    STAND_5,
    TABLE_1,
    TABLE_2,
    TABLE_3,
    TABLE_4,
    TABLE_5_REQUIRED,
    TABLE_5_USED,
    evaluate,
)
from tumble.planning.require import Requirements, requirements
from tumble.planning.requirement_report import printed as evaluate_printed

# Misalignments that no two formulas confuse: K_ij/K_ii off the diagonal.
AUDIT_K = 2.0 * np.array([[1.0, 0.020, 0.016], [0.014, 1.0, 0.018], [0.012, 0.010, 1.0]])
_FIRST_ORDER = 0.05  # a weight may differ by the misalignments themselves, which a formula of first order leaves out
_SIZES = np.array([float(STAND_5[source]) for source in SOURCES])
_GROUPED = _SIZES / np.array([1.0, 1.0, 1.0, 1.0, float(GROUP_FACTOR)])


@dataclass(frozen=True)
class Line:
    """One printed number or formula: where, as printed, its value if a formula, and what comes out now. `agrees`: after
    rounding to the printed digits, or for a weight to first order. `notes`: numbers of the discrepancies it shows."""

    table: str
    row: str
    column: str
    printed: str
    value: float
    computed: float
    agrees: bool
    notes: tuple[int, ...]


def rounds_to(printed: str, value: float) -> bool:
    """Is this the value, rounded to the digits printed? Zeros at the end of a whole number are not digits."""
    quantum = int(Decimal(printed).normalize().as_tuple().exponent)
    return abs(value - float(printed)) <= 0.5 * 10.0**quantum * (1.0 + 1e-9)


def lines() -> list[Line]:
    """All of it, in the paper's order."""
    in_order = (_table_1, _table_2, _table_3, _table_4, _equation_6, _equation_18, _equation_19, _table_5)
    return [line for part in in_order for line in part()]


def sizes(grouped: bool) -> Floats:
    """Sizes (5,) of the sources by (5); the noise of one sample, or divided by the paper's 7."""
    return _GROUPED if grouped else _SIZES


def paper_case() -> Case:
    """The paper's stand, block and schedule, with one yaw for both mountings as Table 1 has it."""
    case = Case.of(None, None, None)
    return replace(case, stand=replace(case.stand, remounting="common"))


def signed_weights(gain_rows: Floats, k: Floats) -> Floats:
    """Weights (rows, 5) in V/g with the signs of alpha1 to alpha3; those of the random sources are positive."""
    schedule = paper_case().fitted
    by_angle = [felt(schedule, name, True).derivative(k).ravel() for name in ("alpha1", "alpha2", "alpha3")]
    signed, sizes = gain_rows @ np.array(by_angle).T, weights.absolute_weights(schedule, True, k, gain_rows)
    return np.column_stack([np.where(sizes[:, :3] > 0.0, signed, 0.0), sizes[:, 3:]])


def single_mounting_gains() -> dict[str, Floats]:
    """Gain rows (54,) of K_yx and K_zx from one mounting alone, named as in Table 4."""
    averaged = linear_gains(paper_case().fitted, "averaged").reshape(12, 2, 27)
    rows = {}
    for name in TABLE_4:
        row, mounting = NAMES.index("K_" + name[-2:]), int(name[1]) - 1
        rows[name] = np.zeros((2, 27))
        rows[name][mounting] = 2.0 * averaged[row, mounting]
    return {name: row.ravel() for name, row in rows.items()}


def _weight_lines(
    table: str,
    formulas: Mapping[str, tuple[str, ...]],
    derived: Floats,
    notes_of: Callable[[str, str], tuple[int, ...]],
) -> list[Line]:
    """Weights: a printed formula against the geometry, both for AUDIT_K."""
    values, found = weights.symbols(AUDIT_K), []
    for name, printed, row in zip(formulas, formulas.values(), derived):
        for source, formula, computed in zip(SOURCES, printed, row):
            value = evaluate(formula, values)
            agrees = bool(abs(value - computed) <= _FIRST_ORDER * abs(value))
            found.append(Line(table, name, source, formula, value, float(computed), agrees, notes_of(name, source)))
    return found


def _table_1() -> list[Line]:
    gain_rows = linear_gains(paper_case().fitted, "averaged")
    related = np.concatenate([AUDIT_K.ravel(), np.diag(AUDIT_K)])
    derived = signed_weights(gain_rows, AUDIT_K) / related[:, None]
    order = [NAMES.index(name) for name in TABLE_1]
    derived[:, 3:] = np.abs(derived[:, 3:])
    return _weight_lines("Table 1", TABLE_1, derived[order], _notes_table_1)


def _notes_table_1(name: str, source: str) -> tuple[int, ...]:
    known = {
        ("K_xz", "alpha2"): (1,),
        ("K_yy", "alpha2"): (8,),
        ("K_yz", "alpha2"): (11,),
        ("K_zy", "alpha2"): (11,),
        ("K_yx", "noise"): (12, 14, 15),
        ("K_zx", "noise"): (12, 14, 15),
        ("K_yz", "alpha4"): (14, 16),
        ("K_zy", "alpha4"): (14, 16),
    }
    if source == "noise":
        return known.get((name, source), (14, 15))
    return known.get((name, source), (14,) if source == "alpha4" else ())


def _table_2() -> list[Line]:
    gamma = weights.published(paper_case(), "averaged")
    notes = {("K_xx", "alpha2"): (2,), ("a0_x", "alpha1"): (3,)}
    return [
        _rounded(
            "Table 2",
            name,
            source,
            printed,
            float(gamma[NAMES.index(name), s] * _SIZES[s]),
            notes.get((name, source), ()),
        )
        for name, row in TABLE_2.items()
        for s, (source, printed) in enumerate(zip(SOURCES, row))
    ]


def _table_3() -> list[Line]:
    totals = np.linalg.norm(weights.published(paper_case(), "averaged") * _GROUPED, axis=1)
    notes = {"K_xx": (2,), "a0_x": (3,), "K_yx": (4,), "K_zx": (4,), "K_xz": (1,)}
    return [
        _rounded(
            "Table 3",
            name,
            "mg" if name.startswith("a0") else "ppm",
            printed,
            float(totals[NAMES.index(name)]) * (1e3 if name.startswith("a0") else 1e6),
            notes.get(name, ()),
        )
        for name, printed in TABLE_3.items()
    ]


def _table_4() -> list[Line]:
    rows = single_mounting_gains()
    related = np.array([AUDIT_K[1, 0] if name.endswith("yx") else AUDIT_K[2, 0] for name in rows])
    derived = signed_weights(np.array(list(rows.values())), AUDIT_K) / related[:, None]
    return _weight_lines("Table 4", TABLE_4, derived, _notes_table_4)


def _notes_table_4(name: str, source: str) -> tuple[int, ...]:
    if source in ("alpha4", "noise"):
        return (14, 16) if source == "alpha4" and name in ("K1_yx", "K2_zx") else (14,)
    formula = TABLE_4[name][SOURCES.index(source)]
    if (name, source) == ("K1_yx", "alpha2"):
        return (8, 11)
    return (11,) if formula in ("1", "-1") else ()


def _equation_6() -> list[Line]:
    values = weights.symbols(paper_case().nominal_k())
    found = []
    for name, printed in EQUATION_6_PPM.items():
        gamma = np.array([evaluate(formula, values) for formula in TABLE_4[name]])
        found.append(_rounded("(6)", name, "ppm", printed, float(1e6 * np.linalg.norm(gamma * _GROUPED)), ()))
    return found


def factor(formula: str) -> str:
    """What dg is divided by in a printed formula of (18) or (19), apart from a_ij and K_ii: the number in it, or 1."""
    number = re.search(r"\d+(\.\d+)?", formula)
    return "1" if number is None else number[0]


def _equation_18() -> list[Line]:
    """Divisors of dg: with three sources in the row, 3 sqrt(3) gamma."""
    row = {"alpha2": 1.0, "alpha4": 0.15, "noise": 0.3}
    return [
        _rounded("(18)", "K_yy", source, factor(formula), 3.0 * 3.0**0.5 * row[source], ())
        for source, formula in EQUATION_18.items()
    ]


def rule_requirements() -> Requirements:
    """What the paper's own rule gives: strictest row, worst signs, formula (7) in use."""
    return requirements(paper_case(), "published", "refined", float(LIMIT_20_G), np.ones(len(SOURCES)))


def general_requirements() -> dict[str, float]:
    """What (19) gives as printed, by source."""
    return evaluate_printed(paper_case(), EQUATION_19, float(LIMIT_20_G))


def _equation_19() -> list[Line]:
    """Divisors of dg beside those of the paper's own rule."""
    rule, case = rule_requirements(), paper_case()
    units = np.array([1.0, case.misalignment, case.misalignment, 1.0, 1.0 / case.full_scale["noise"]])
    divisors = float(LIMIT_20_G) / rule.limits / units
    notes = {"alpha2": (10,), "alpha3": (9,), "alpha4": (7,), "noise": (17,)}
    return [
        _rounded("(19)", str(rule.set_by[s]), source, factor(formula), float(divisors[s]), notes.get(source, ()))
        for s, (source, formula) in enumerate(EQUATION_19.items())
    ]


def _table_5() -> list[Line]:
    general = general_requirements()
    notes = {"alpha1": (5,), "alpha2": (5, 10), "alpha3": (9,), "alpha4": (5, 7), "noise": (6,)}
    required = [
        _rounded("Table 5", "required", source, printed, general[source], notes[source])
        for source, printed in TABLE_5_REQUIRED.items()
    ]
    used = [
        _rounded("Table 5", "used", source, printed, float(size), (6,) if source == "noise" else ())
        for (source, printed), size in zip(TABLE_5_USED.items(), _SIZES)
    ]
    return required + used


def _rounded(table: str, row: str, column: str, printed: str, computed: float, notes: tuple[int, ...]) -> Line:
    return Line(table, row, column, printed, float(printed), computed, rounds_to(printed, computed), notes)
