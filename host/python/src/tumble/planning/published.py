"""The numbers of the paper, as printed (decimal points for decimal commas): its weights, tables and requirements.

M. Chernyak, V. Rybak, V. Paliushok, "Ensuring the given accuracy of calibrating a three-axis block of navigation
accelerometers on a single-axis rotary stand" (in Ukrainian). Formulas are kept as printed, with a_ij for the
misalignments, K_ij for the coefficients, g = 1 and dg for the acceptance limit; `evaluate` gives their value.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable

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
TABLE_3 = {
    "K_xx": "9",
    "K_yy": "9",
    "K_zz": "9",
    "a0_x": "0.01",
    "a0_y": "0.01",
    "a0_z": "0.01",
    "K_xy": "1600",
    "K_xz": "1600",
    "K_yx": "10500",
    "K_yz": "590",
    "K_zx": "10500",
    "K_zy": "590",
}

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
