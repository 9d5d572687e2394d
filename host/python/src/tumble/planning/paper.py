"""The paper's numbers computed again, and where they do not follow.

The paper's tables and formulas computed again from its own weights and from the geometry, beside what is printed.

Where the paper's printed numbers do not follow from its printed formulas, or these from the geometry.

Every figure is computed when it is asked for, none is copied.

The audit of the paper as a JSON document and as tables.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import replace
from decimal import Decimal
from itertools import groupby

import numpy as np

from tumble.arrays import Floats
from tumble.documents.plan import Discrepancy, Line, Paper
from tumble.model.errors import unit_effect
from tumble.model.estimators import linear_gains
from tumble.planning import tables, weights
from tumble.planning.case import Case
from tumble.planning.require import Requirements, printed as evaluate_printed, requirements, samples_for
from tumble.planning.weights import (
    EQUATION_6_PPM,
    EQUATION_18,
    EQUATION_19,
    GROUP_FACTOR,
    GROUP_SAMPLES,
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

# Misalignments that no two formulas confuse: K_ij/K_ii off the diagonal.
AUDIT_K = 2.0 * np.array([[1.0, 0.020, 0.016], [0.014, 1.0, 0.018], [0.012, 0.010, 1.0]])
_FIRST_ORDER = 0.05  # a weight may differ by the misalignments themselves, which a formula of first order leaves out
_SIZES = np.array([float(STAND_5[source]) for source in SOURCES])
_GROUPED = _SIZES / np.array([1.0, 1.0, 1.0, 1.0, float(GROUP_FACTOR)])


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
    by_angle = [unit_effect(schedule, name, True).derivative(k).ravel() for name in ("alpha1", "alpha2", "alpha3")]
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


_Found = tuple[int, str, str, str, str]


def discrepancies() -> list[Discrepancy]:
    """All of them, numbered from 1."""
    found = [*_of_the_tables(), *_of_the_requirements(), *_of_the_weights(), *_of_the_words()]
    return sorted((Discrepancy(*one) for one in found), key=lambda one: one.number)


def _row(gamma: Floats, name: str, grouped: bool = False) -> Floats:
    """Terms (5,) of one coefficient."""
    terms: Floats = gamma[NAMES.index(name)] * sizes(grouped)
    return terms


def _of_the_tables() -> list[_Found]:
    case = paper_case()
    averaged = weights.published(case, "averaged")
    worst = weights.published(case, "averaged", weights.WORST)
    k_xx, a0_x, k_yx = (_row(averaged, name, True) for name in ("K_xx", "a0_x", "K_yx"))
    misprinted = _row(averaged, "K_xz", True)
    misprinted[1] = case.misalignment * sizes(True)[1]
    as_printed = np.array([float(value) for value in TABLE_2["K_xx"]]) / (1, 1, 1, 1, 7)
    tilted = np.array([float(value) for value in TABLE_2["a0_x"]]) / (1, 1, 1, 1, 7)
    alpha2, alpha3 = _row(averaged, "K_xx")[1:3]
    return [
        (
            1,
            "Table 1, K_xz, gamma2",
            "a_zx",
            "1/a_zx",
            f"with a_zx Table 3 would say {_ppm(misprinted):.0f} ppm, not {TABLE_3['K_xz']}",
        ),
        (
            2,
            "Tables 2 and 3, K_xx",
            f"alpha2 {TABLE_2['K_xx'][1]}; sum {TABLE_3['K_xx']} ppm",
            f"alpha2 {alpha2:.1e}; sum {_ppm(k_xx):.1f} ppm",
            f"alpha3 is {alpha3 / alpha2:.0f} times alpha2, the printed terms 40;"
            f" they themselves sum to {_ppm(as_printed):.1f} ppm",
        ),
        (
            3,
            "Tables 2 and 3, a0_x",
            f"alpha1 {TABLE_2['a0_x'][0]}; sum {TABLE_3['a0_x']} mg",
            f"alpha1 {_row(averaged, 'a0_x')[0]:.1e} to {_row(worst, 'a0_x')[0]:.1e};"
            f" sum {1e3 * np.linalg.norm(a0_x):.3f} mg",
            f"the printed terms themselves sum to {1e3 * np.linalg.norm(tilted):.3f} mg",
        ),
        (
            4,
            "Table 3, K_yx and K_zx",
            f"{TABLE_3['K_yx']} ppm",
            f"{_ppm(k_yx):.0f} ppm",
            f"{1e6 * (k_yx[1] + k_yx[2]):.0f} is the plain sum of the two systematic terms,"
            " not the quadrature all others have",
        ),
    ]


def _ppm(terms: Floats) -> float:
    return 1e6 * float(np.linalg.norm(terms))


def _of_the_requirements() -> list[_Found]:
    case, limit_g = paper_case(), float(LIMIT_20_G)
    general, rule = general_requirements(), rule_requirements().limits
    noise = sizes(False)[SOURCES.index("noise")]
    quadrature = limit_g / (6.0 * weights.published(case, "refined")[0, 2])
    yaw_bias = general["alpha3"] ** 2 / 2.0
    return [
        (
            5,
            "Table 5, alpha1, alpha2, alpha4",
            ", ".join(TABLE_5_REQUIRED[source] for source in ("alpha1", "alpha2", "alpha4")) + " rad",
            ", ".join(f"{general[source]:.3g}" for source in ("alpha1", "alpha2", "alpha4")) + " rad",
            "a requirement is rounded up, past what (19) allows",
        ),
        (
            6,
            "Table 5, noise",
            f"{noise:g} V used, {general['noise']:.0e} required",
            "not met by one sample",
            f"'all requirements are met' takes the grouping: at least {samples_for(noise, general['noise'])} samples;"
            f" {GROUP_SAMPLES} were taken",
        ),
        (
            7,
            "(19), alpha4",
            "dg/0.8",
            f"dg/{limit_g / rule[3]:.2f}",
            f"0.8 is the row of K_yy; Table 1's 0.4 for a0_x is stricter:"
            f" {rule[3]:.3g} rad, not {general['alpha4']:.3g}",
        ),
        (
            9,
            "(19), alpha3",
            f"dg/a_ij = {1e3 * general['alpha3']:.0f} mrad",
            f"dg/(6 a_ij) = {1e3 * rule[2]:.1f} mrad",
            f"after (7) alpha3 enters K_xx alone, with four sources ({1e3 * quadrature:.1f} mrad in quadrature); at the"
            f" printed limit alpha3^2/2 = {yaw_bias:.1e} of K_xx by itself exceeds dg/3",
        ),
        (
            10,
            "(19), alpha2",
            f"dg/(5.2 a_ij) = {1e3 * general['alpha2']:.2f} mrad",
            f"dg/(6 a_ij) = {1e3 * rule[1]:.1f} mrad",
            "K_xx is stricter than K_yy when a_yx and a_zx are opposite",
        ),
        (
            13,
            "(10) and (11)",
            "sqrt(3) |da_j|; K_ij left out",
            "|da_j|; K_ij counts",
            f"the three a_j cannot all be g; and at Table 5's alpha4 the K_ij err by"
            f" 0.55 alpha4 = {0.55 * general['alpha4']:.1e}, of the order of dg",
        ),
    ]


def _of_the_weights() -> list[_Found]:
    squares = np.linalg.norm(linear_gains(paper_case().fitted, "averaged"), axis=1)
    k_yy, k_xy, k_xx, k_yx, bias = (squares[NAMES.index(name)] for name in ("K_yy", "K_xy", "K_xx", "K_yx", "a0_x"))
    printed = {(line.table, line.row, line.column): line for line in lines()}
    k_yz, alone = printed["Table 1", "K_yz", "alpha2"], printed["Table 4", "K1_yx", "alpha2"]
    angles = printed["Table 1", "K_yy", "alpha4"], printed["Table 1", "a0_x", "alpha4"]
    weighed = printed["Table 1", "K_yz", "alpha4"], printed["Table 4", "K1_yx", "alpha4"]
    return [
        (
            8,
            "Table 1, K_yy and Table 4, K1_yx: gamma2",
            "a_xy and 1",
            "-a_xy and -1",
            "negative in the one geometry that makes all other signs right; limits are symmetric, so no number changes",
        ),
        (
            11,
            "Tables 1 and 4, gammas of +-1",
            "1",
            f"{k_yz.computed:.2f}, {alone.computed:.2f} (see above)",
            "they are ratios within a row, such as a_xy/a_zy: 1 only where misalignments are equal",
        ),
        (
            12,
            "Table 1, K_yx and K_zx, gamma5",
            "0.25",
            f"{0.4 / 2**0.5:.2f}",
            "Table 4's 0.4 over sqrt(2), for the mean of two",
        ),
        (
            14,
            "Tables 1 and 4, gamma4 and gamma5",
            "K_yy 0.15, 0.3; a0_x 0.4, 0.4",
            f"K_yy {angles[0].computed:.3f}, {k_yy:.3f}; a0_x {angles[1].computed:.3f}, {bias:.3f}",
            "none follows from the formulas (3) and (7): independent errors of 18 positions add in quadrature to these",
        ),
        (
            15,
            "Table 1, gamma5 among rows",
            "K_yy 0.3, K_xy 0.55; K_xx 0.2, K_yx 0.25; a0_x 0.4, a0_y 0.2",
            f"{k_yy:.3f}, {k_xy:.3f}; {k_xx:.3f}, {k_yx:.3f}; {bias:.3f} both",
            "one combination of outputs, such as (3), serves all three channels: its noise cannot differ between them",
        ),
        (
            16,
            "Tables 1 and 4, gamma4 without 1/a_ij",
            "K_yz 0.55, K1_yx 0.4",
            f"{weighed[0].computed:.2f}, {weighed[1].computed:.2f} (see above)",
            "these depend on the ratio of two misalignments too, as number 11 does",
        ),
    ]


def _of_the_words() -> list[_Found]:
    averaged = weights.published(paper_case(), "averaged")
    refined = weights.published(paper_case(), "refined")
    k_yx = _row(averaged, "K_yx")
    largest = [SOURCES[int(np.argmax(_row(refined, name, True)))] for name in NAMES]
    by_angles = [name for name, source in zip(NAMES, largest) if source not in ("alpha3", "noise")]
    return [
        (
            17,
            "(14), (18), (19), noise",
            "dg K_ii/3",
            "dg |K_ii|/3",
            "with the paper's K of -2 V/g the printed limit is negative",
        ),
        (
            18,
            "text to Table 2",
            "noise is decisive in every error",
            f"K_yx: alpha3 {k_yx[2]:.1e}, noise {k_yx[4]:.1e}",
            "not in K_yx and K_zx, which the table leaves out",
        ),
        (
            19,
            "conclusions",
            "alpha3 and noise matter most",
            f"rows in which each is largest: {_listed(largest)}",
            f"with (7) and 50 samples another angle is the largest source of {', '.join(by_angles)}",
        ),
    ]


def _listed(largest: list[str]) -> str:
    return ", ".join(f"{source} {largest.count(source)}" for source in SOURCES if source in largest)


_TITLES = {
    "Table 1": "Table 1: weights of the averaged estimates",
    "Table 2": "Table 2: contributions of one sample (relative; a0 in g)",
    "Table 3": "Table 3: errors, 50 samples",
    "Table 4": "Table 4: weights of K_yx and K_zx from one mounting",
    "(6)": "(6): errors of K_yx and K_zx from one mounting",
    "(18)": "(18): what dg is divided by, from K_yy; recomputed: 3 sqrt(3) gamma",
    "(19)": "(19): what dg is divided by; recomputed: the rule, in the row that is strictest",
    "Table 5": "Table 5: the stand (rad, V); recomputed: (19), and what (5) says was used",
}
_WEIGHTS = ("Table 1", "Table 4")
_LEGEND = (
    "What is printed, beside what comes out now. ok: equal after rounding to the\n"
    "digits printed, a weight to first order. Numbers in brackets: the list at the end.\n"
)


def document() -> Paper:
    """The audit for JSON."""
    return Paper(misalignments_of_weights=AUDIT_K / 2.0, lines=tuple(lines()), discrepancies=tuple(discrepancies()))


def show() -> None:
    """Print the audit for people."""
    out = tables.console()
    out.print(_LEGEND)
    for table, group in groupby(lines(), key=lambda line: line.table):
        out.print(tables.heading(_TITLES[table]))
        if table in _WEIGHTS:
            out.print("Values for K = 2 V/g and misalignments of 0.010 to 0.020 rad, all different")
        rows = [_cells(line) for line in group if line.printed != "0" or line.computed != 0.0]
        headings = ["", "", *(["formula"] if table in _WEIGHTS else []), "printed", "recomputed", "", ""]
        out.print(tables.table(headings, rows, left=(0, 1, len(headings) - 1)))
    out.print(tables.heading("Discrepancies"))
    for one in discrepancies():
        out.print(f"[{one.number}] {one.where}", style="bold", markup=False)
        out.print(_indented(f"printed {one.printed}; recomputed {one.computed}"), markup=False)
        out.print(_indented(one.why), markup=False)


def _cells(line: Line) -> list[str]:
    formula = [line.printed] if line.table in _WEIGHTS else []
    printed = f"{line.value:.3g}" if line.table in _WEIGHTS else line.printed
    notes = " ".join(f"\\[{note}]" for note in line.notes)
    return [line.row, line.column, *formula, printed, f"{line.computed:.4g}", "ok" if line.agrees else "differs", notes]


def _indented(text: str) -> str:
    return textwrap.fill(text, tables.WIDTH, initial_indent="    ", subsequent_indent="    ")
