"""Where the paper's printed numbers do not follow from its printed formulas, or these from the geometry.

Every figure is computed when it is asked for, none is copied.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.model.estimators import linear_gains
from tumble.planning import paper, weights
from tumble.planning.published import GROUP_SAMPLES, LIMIT_20_G, NAMES, SOURCES, TABLE_2, TABLE_3, TABLE_5_REQUIRED
from tumble.planning.require import samples_for

_Found = tuple[int, str, str, str, str]


@dataclass(frozen=True)
class Discrepancy:
    """`number` as the lines of paper.lines refer to it; `where` in the paper; what is `printed`, what is `computed`,
    and why, each in a few words."""

    number: int
    where: str
    printed: str
    computed: str
    why: str


def discrepancies() -> list[Discrepancy]:
    """All of them, numbered from 1."""
    found = [*_of_the_tables(), *_of_the_requirements(), *_of_the_weights(), *_of_the_words()]
    return sorted((Discrepancy(*one) for one in found), key=lambda one: one.number)


def _row(gamma: Floats, name: str, grouped: bool = False) -> Floats:
    """Terms (5,) of one coefficient."""
    terms: Floats = gamma[NAMES.index(name)] * paper.sizes(grouped)
    return terms


def _of_the_tables() -> list[_Found]:
    case = paper.paper_case()
    averaged = weights.published(case, "averaged")
    worst = weights.published(case, "averaged", weights.WORST)
    k_xx, a0_x, k_yx = (_row(averaged, name, True) for name in ("K_xx", "a0_x", "K_yx"))
    misprinted = _row(averaged, "K_xz", True)
    misprinted[1] = case.misalignment * paper.sizes(True)[1]
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
    case, limit_g = paper.paper_case(), float(LIMIT_20_G)
    general, rule = paper.general_requirements(), paper.rule_requirements().limits
    noise = paper.sizes(False)[SOURCES.index("noise")]
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
    squares = np.linalg.norm(linear_gains(paper.paper_case().fitted, "averaged"), axis=1)
    k_yy, k_xy, k_xx, k_yx, bias = (squares[NAMES.index(name)] for name in ("K_yy", "K_xy", "K_xx", "K_yx", "a0_x"))
    printed = {(line.table, line.row, line.column): line for line in paper.lines()}
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
    averaged = weights.published(paper.paper_case(), "averaged")
    refined = weights.published(paper.paper_case(), "refined")
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
