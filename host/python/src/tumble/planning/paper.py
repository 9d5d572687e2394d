"""The paper's numbers computed again, and where they do not follow.

Its tables and formulas are computed from its own weights and from the geometry, beside what is printed (`lines`). Where
printed numbers do not follow from printed formulas, or these from the geometry, `discrepancies` says why. Every figure
is computed when it is asked for, none is copied.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal
from itertools import groupby
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.documents.plan import Discrepancy, Line, Paper
from tumble.model.errors import unit_effect
from tumble.model.estimators import linear_gains
from tumble.planning import tables, weights
from tumble.planning.case import Case
from tumble.planning.require import Requirements, printed as evaluate_printed, requirements, samples_for
from tumble.planning.weights import NAMES, SOURCES, evaluate

# Misalignments that no two formulas confuse: K_ij/K_ii off the diagonal.
AUDIT_K = 2.0 * np.array([[1.0, 0.020, 0.016], [0.014, 1.0, 0.018], [0.012, 0.010, 1.0]])
_FIRST_ORDER = 0.05  # a weight may differ by the misalignments themselves, which a formula of first order leaves out
_SIZES = np.array([float(weights.STAND_5[source]) for source in SOURCES])  # by (5); the noise of one sample
_GROUPED = _SIZES / np.array([1.0, 1.0, 1.0, 1.0, float(weights.GROUP_FACTOR)])  # and divided by the paper's 7

# Numbers of the discrepancies that a line shows, by table, row and column, or by table and column.
_NOTES = {
    "Table 1 noise": (14, 15),
    "Table 1 alpha4": (14,),
    "Table 1 K_xz alpha2": (1,),
    "Table 1 K_yy alpha2": (8,),
    "Table 1 K_yz alpha2": (11,),
    "Table 1 K_zy alpha2": (11,),
    "Table 1 K_yx noise": (12, 14, 15),
    "Table 1 K_zx noise": (12, 14, 15),
    "Table 1 K_yz alpha4": (14, 16),
    "Table 1 K_zy alpha4": (14, 16),
    "Table 2 K_xx alpha2": (2,),
    "Table 2 a0_x alpha1": (3,),
    "Table 3 K_xx ppm": (2,),
    "Table 3 a0_x mg": (3,),
    "Table 3 K_yx ppm": (4,),
    "Table 3 K_zx ppm": (4,),
    "Table 3 K_xz ppm": (1,),
    "Table 4 noise": (14,),
    "Table 4 alpha4": (14,),
    "Table 4 K1_yx alpha4": (14, 16),
    "Table 4 K2_zx alpha4": (14, 16),
    "Table 4 K1_yx alpha2": (8, 11),
    "Table 4 K2_yx alpha3": (11,),
    "Table 4 K1_zx alpha3": (11,),
    "Table 4 K2_zx alpha2": (11,),
    "(19) alpha2": (10,),
    "(19) alpha3": (9,),
    "(19) alpha4": (7,),
    "(19) noise": (17,),
    "Table 5 required alpha1": (5,),
    "Table 5 required alpha2": (5, 10),
    "Table 5 required alpha3": (9,),
    "Table 5 required alpha4": (5, 7),
    "Table 5 noise": (6,),
}


def rounds_to(printed: str, value: float) -> bool:
    """Whether the value rounds to the printed digits. Trailing zeros of a whole number are not digits."""
    quantum = int(Decimal(printed).normalize().as_tuple().exponent)
    return abs(value - float(printed)) <= 0.5 * 10.0**quantum * (1.0 + 1e-9)


def lines() -> list[Line]:
    """All figures, in the paper's order."""
    case, rule, general = _paper_case(), _rule_requirements(), _general_requirements()
    averaged = weights.published(case, "averaged")
    totals = np.linalg.norm(averaged * _GROUPED, axis=1)
    found = _weights_from_both_mountings()
    for name, row in weights.TABLE_2.items():
        computed = averaged[NAMES.index(name)] * _SIZES
        found += [_rounded("Table 2", name, *one) for one in zip(SOURCES, row, computed.tolist())]
    for name, printed in weights.TABLE_3.items():
        unit, size = ("mg", 1e3) if name.startswith("a0") else ("ppm", 1e6)
        found.append(_rounded("Table 3", name, unit, printed, float(totals[NAMES.index(name)]) * size))
    found += _weights_from_one_mounting()
    values = weights.symbols(case.nominal_k())
    for name, printed in weights.EQUATION_6_PPM.items():
        gamma = np.array([evaluate(formula, values) for formula in weights.TABLE_4[name]])
        found.append(_rounded("(6)", name, "ppm", printed, _ppm(gamma * _GROUPED)))
    for source, weight in (("alpha2", 1.0), ("alpha4", 0.15), ("noise", 0.3)):  # three in the row: 3 sqrt(3) gamma
        found.append(_rounded("(18)", "K_yy", source, _factor(weights.EQUATION_18[source]), 3.0 * 3.0**0.5 * weight))
    units = np.array([1.0, case.misalignment, case.misalignment, 1.0, 1.0 / case.full_scale["noise"]])
    divisors = (float(weights.LIMIT_20_G) / rule.limits / units).tolist()
    for strictest, (source, formula), divisor in zip(rule.set_by, weights.EQUATION_19.items(), divisors):
        found.append(_rounded("(19)", str(strictest), source, _factor(formula), divisor))
    for source, printed in weights.TABLE_5_REQUIRED.items():
        found.append(_rounded("Table 5", "required", source, printed, general[source]))
    for (source, printed), size in zip(weights.TABLE_5_USED.items(), _SIZES.tolist()):
        found.append(_rounded("Table 5", "used", source, printed, size))
    return found


def _rounded(table: str, row: str, column: str, printed: str, computed: float) -> Line:
    agrees = rounds_to(printed, computed)
    return Line(table, row, column, printed, float(printed), computed, agrees, _notes(table, row, column))


def _notes(table: str, row: str, column: str) -> tuple[int, ...]:
    return _NOTES.get(f"{table} {row} {column}", _NOTES.get(f"{table} {column}", ()))


def _ppm(terms: Floats) -> float:
    return float(1e6 * np.linalg.norm(terms))


def _factor(formula: str) -> str:
    """The number that divides dg in a printed formula of (18) or (19), apart from a_ij and K_ii; 1 if none."""
    number = re.search(r"\d+(\.\d+)?", formula)
    return "1" if number is None else number[0]


def _paper_case() -> Case:
    """The paper's stand, block and schedule, with one yaw for both mountings as Table 1 has it."""
    case = Case.of(None, None, None)
    return replace(case, stand=replace(case.stand, remounting="common"))


def _rule_requirements() -> Requirements:
    """The paper's rule: strictest row, worst signs, with formula (7)."""
    return requirements(_paper_case(), "published", "refined", float(weights.LIMIT_20_G), np.ones(len(SOURCES)))


def _general_requirements() -> dict[str, float]:
    """The values of (19) as printed, by source."""
    return evaluate_printed(_paper_case(), weights.EQUATION_19, float(weights.LIMIT_20_G))


def _weights_from_both_mountings() -> list[Line]:
    """Table 1."""
    related = np.concatenate([AUDIT_K.ravel(), np.diag(AUDIT_K)])
    derived = _signed_weights(linear_gains(_paper_case().fitted, "averaged")) / related[:, None]
    derived[:, 3:] = np.abs(derived[:, 3:])
    return _weight_lines("Table 1", weights.TABLE_1, derived[[NAMES.index(name) for name in weights.TABLE_1]])


def _weights_from_one_mounting() -> list[Line]:
    """Table 4: K_yx and K_zx."""
    averaged = linear_gains(_paper_case().fitted, "averaged").reshape(12, 2, 27)
    gain_rows = np.zeros((len(weights.TABLE_4), 2, 27))
    for own, name in zip(gain_rows, weights.TABLE_4):
        mounting = int(name[1]) - 1
        own[mounting] = 2.0 * averaged[NAMES.index("K_" + name[-2:]), mounting]
    related = np.array([AUDIT_K[1, 0] if name.endswith("yx") else AUDIT_K[2, 0] for name in weights.TABLE_4])
    return _weight_lines("Table 4", weights.TABLE_4, _signed_weights(gain_rows.reshape(-1, 54)) / related[:, None])


def _signed_weights(gain_rows: Floats) -> Floats:
    """Weights (rows, 5) in V/g for AUDIT_K with the signs of alpha1 to alpha3; those of the random sources are
    positive."""
    schedule = _paper_case().fitted
    by_angle = [unit_effect(schedule, one, True).derivative(AUDIT_K).ravel() for one in ("alpha1", "alpha2", "alpha3")]
    signed, sizes = gain_rows @ np.array(by_angle).T, weights.absolute_weights(schedule, True, AUDIT_K, gain_rows)
    return np.column_stack([np.where(sizes[:, :3] > 0.0, signed, 0.0), sizes[:, 3:]])


def _weight_lines(table: str, formulas: Mapping[str, tuple[str, ...]], derived: Floats) -> list[Line]:
    """Weights by the printed formulas and by the geometry, both for AUDIT_K."""
    values, found = weights.symbols(AUDIT_K), []
    for name, printed, row in zip(formulas, formulas.values(), derived):
        for source, formula, computed in zip(SOURCES, printed, row):
            value = evaluate(formula, values)
            agrees = bool(abs(value - computed) <= _FIRST_ORDER * abs(value))
            notes = _notes(table, name, source)
            found.append(Line(table, name, source, formula, value, float(computed), agrees, notes))
    return found


# As they are shown: number and place, what is printed and what comes out, and why.
_DISCREPANCIES = """
[1] Table 1, K_xz, gamma2
printed a_zx; recomputed 1/a_zx
with a_zx Table 3 would say {misprinted:.0f} ppm, not {TABLE_3[K_xz]}

[2] Tables 2 and 3, K_xx
printed alpha2 {TABLE_2[K_xx][1]}; sum {TABLE_3[K_xx]} ppm; recomputed alpha2 {k_xx[1]:.1e}; sum {sum_k_xx:.1f} ppm
alpha3 is {ratio:.0f} times alpha2, the printed terms 40; they themselves sum to {printed_k_xx:.1f} ppm

[3] Tables 2 and 3, a0_x
printed alpha1 {TABLE_2[a0_x][0]}; sum {TABLE_3[a0_x]} mg; recomputed alpha1 {a0_x[0]:.1e} to {worst_a0_x[0]:.1e}; \
sum {sum_a0_x:.3f} mg
the printed terms themselves sum to {printed_a0_x:.3f} mg

[4] Table 3, K_yx and K_zx
printed {TABLE_3[K_yx]} ppm; recomputed {sum_k_yx:.0f} ppm
{plain_sum:.0f} is the plain sum of the two systematic terms, not the quadrature all others have

[5] Table 5, alpha1, alpha2, alpha4
printed {required[alpha1]}, {required[alpha2]}, {required[alpha4]} rad; \
recomputed {general[alpha1]:.3g}, {general[alpha2]:.3g}, {general[alpha4]:.3g} rad
a requirement is rounded up, past what (19) allows

[6] Table 5, noise
printed {noise:g} V used, {general[noise]:.0e} required; recomputed not met by one sample
'all requirements are met' takes the grouping: at least {samples} samples; {GROUP_SAMPLES} were taken

[7] (19), alpha4
printed dg/0.8; recomputed dg/{divisor_alpha4:.2f}
0.8 is the row of K_yy; Table 1's 0.4 for a0_x is stricter: {rule[3]:.3g} rad, not {general[alpha4]:.3g}

[8] Table 1, K_yy and Table 4, K1_yx: gamma2
printed a_xy and 1; recomputed -a_xy and -1
negative in the one geometry that makes all other signs right; limits are symmetric, so no number changes

[9] (19), alpha3
printed dg/a_ij = {general_mrad[2]:.0f} mrad; recomputed dg/(6 a_ij) = {rule_mrad[2]:.1f} mrad
after (7) alpha3 enters K_xx alone, with four sources ({quadrature_mrad:.1f} mrad in quadrature); \
at the printed limit alpha3^2/2 = {yaw_bias:.1e} of K_xx by itself exceeds dg/3

[10] (19), alpha2
printed dg/(5.2 a_ij) = {general_mrad[1]:.2f} mrad; recomputed dg/(6 a_ij) = {rule_mrad[1]:.1f} mrad
K_xx is stricter than K_yy when a_yx and a_zx are opposite

[11] Tables 1 and 4, gammas of +-1
printed 1; recomputed {k_yz_alpha2:.2f}, {k1_yx_alpha2:.2f} (see above)
they are ratios within a row, such as a_xy/a_zy: 1 only where misalignments are equal

[12] Table 1, K_yx and K_zx, gamma5
printed 0.25; recomputed {mean_of_two:.2f}
Table 4's 0.4 over sqrt(2), for the mean of two

[13] (10) and (11)
printed sqrt(3) |da_j|; K_ij left out; recomputed |da_j|; K_ij counts
the three a_j cannot all be g; and at Table 5's alpha4 the K_ij err by 0.55 alpha4 = {err_of_k:.1e}, of the order of dg

[14] Tables 1 and 4, gamma4 and gamma5
printed K_yy 0.15, 0.3; a0_x 0.4, 0.4; recomputed K_yy {k_yy_alpha4:.3f}, {squares[4]:.3f}; \
a0_x {a0_x_alpha4:.3f}, {squares[9]:.3f}
none follows from the formulas (3) and (7): independent errors of 18 positions add in quadrature to these

[15] Table 1, gamma5 among rows
printed K_yy 0.3, K_xy 0.55; K_xx 0.2, K_yx 0.25; a0_x 0.4, a0_y 0.2; \
recomputed {squares[4]:.3f}, {squares[1]:.3f}; {squares[0]:.3f}, {squares[3]:.3f}; {squares[9]:.3f} both
one combination of outputs, such as (3), serves all three channels: its noise cannot differ between them

[16] Tables 1 and 4, gamma4 without 1/a_ij
printed K_yz 0.55, K1_yx 0.4; recomputed {k_yz_alpha4:.2f}, {k1_yx_alpha4:.2f} (see above)
these depend on the ratio of two misalignments too, as number 11 does

[17] (14), (18), (19), noise
printed dg K_ii/3; recomputed dg |K_ii|/3
with the paper's K of -2 V/g the printed limit is negative

[18] text to Table 2
printed noise is decisive in every error; recomputed K_yx: alpha3 {k_yx[2]:.1e}, noise {k_yx[4]:.1e}
not in K_yx and K_zx, which the table leaves out

[19] conclusions
printed alpha3 and noise matter most; recomputed rows in which each is largest: {largest}
with (7) and 50 samples another angle is the largest source of {by_angles}
"""
_ONE = re.compile(r"\[(\d+)\] (.+)\nprinted (.+); recomputed (.+)\n(.+)\n")


def discrepancies() -> list[Discrepancy]:
    """All discrepancies, numbered from 1."""
    found = _ONE.findall(_DISCREPANCIES.format(**_figures()))
    return [Discrepancy(int(number), *texts) for number, *texts in found]


def _figures() -> dict[str, Any]:
    """The figures that _DISCREPANCIES names."""
    case, limit_g = _paper_case(), float(weights.LIMIT_20_G)
    averaged, refined = (weights.published(case, estimator) for estimator in ("averaged", "refined"))
    single, grouped = (dict(zip(NAMES, averaged * sizes)) for sizes in (_SIZES, _GROUPED))
    misprinted = grouped["K_xz"].copy()
    misprinted[1] = case.misalignment * _GROUPED[1]
    in_print = {name: np.array([float(one) for one in row]) / (1, 1, 1, 1, 7) for name, row in weights.TABLE_2.items()}
    general, rule = _general_requirements(), _rule_requirements().limits
    noise = _SIZES[SOURCES.index("noise")]
    k_yx = grouped["K_yx"]
    by_place = {(line.table, line.row, line.column): line.computed for line in lines()}
    largest = [SOURCES[int(np.argmax(row))] for row in refined * _GROUPED]
    return {
        "TABLE_2": weights.TABLE_2,
        "TABLE_3": weights.TABLE_3,
        "GROUP_SAMPLES": weights.GROUP_SAMPLES,
        "required": weights.TABLE_5_REQUIRED,
        "misprinted": _ppm(misprinted),
        "k_xx": single["K_xx"],
        "sum_k_xx": _ppm(grouped["K_xx"]),
        "ratio": single["K_xx"][2] / single["K_xx"][1],
        "printed_k_xx": _ppm(in_print["K_xx"]),
        "a0_x": single["a0_x"],
        "worst_a0_x": weights.published(case, "averaged", weights.WORST)[NAMES.index("a0_x")] * _SIZES,
        "sum_a0_x": 1e3 * np.linalg.norm(grouped["a0_x"]),
        "printed_a0_x": 1e3 * np.linalg.norm(in_print["a0_x"]),
        "sum_k_yx": _ppm(k_yx),
        "plain_sum": 1e6 * (k_yx[1] + k_yx[2]),
        "general": general,
        "general_mrad": [1e3 * size for size in general.values()],
        "rule": rule,
        "rule_mrad": 1e3 * rule,
        "noise": noise,
        "samples": samples_for(noise, general["noise"]),
        "divisor_alpha4": limit_g / rule[3],
        "quadrature_mrad": 1e3 * (limit_g / (6.0 * refined[0, 2])),
        "yaw_bias": general["alpha3"] ** 2 / 2.0,
        "err_of_k": 0.55 * general["alpha4"],
        "squares": np.linalg.norm(linear_gains(case.fitted, "averaged"), axis=1),  # as NAMES
        "mean_of_two": 0.4 / 2**0.5,
        "k_yz_alpha2": by_place["Table 1", "K_yz", "alpha2"],
        "k1_yx_alpha2": by_place["Table 4", "K1_yx", "alpha2"],
        "k_yy_alpha4": by_place["Table 1", "K_yy", "alpha4"],
        "a0_x_alpha4": by_place["Table 1", "a0_x", "alpha4"],
        "k_yz_alpha4": by_place["Table 1", "K_yz", "alpha4"],
        "k1_yx_alpha4": by_place["Table 4", "K1_yx", "alpha4"],
        "k_yx": single["K_yx"],
        "largest": ", ".join(f"{source} {largest.count(source)}" for source in SOURCES if source in largest),
        "by_angles": ", ".join(name for name, one in zip(NAMES, largest) if one not in ("alpha3", "noise")),
    }


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
        for text in (f"printed {one.printed}; recomputed {one.computed}", one.why):
            indented = textwrap.fill(text, tables.WIDTH, initial_indent="    ", subsequent_indent="    ")
            out.print(indented, markup=False)


def _cells(line: Line) -> list[str]:
    printed = [line.printed, f"{line.value:.3g}"] if line.table in _WEIGHTS else [line.printed]
    notes = " ".join(f"\\[{note}]" for note in line.notes)
    return [line.row, line.column, *printed, f"{line.computed:.4g}", "ok" if line.agrees else "differs", notes]
