"""A calibration in C for a computer without floating point: counts in, millionths of the force's unit out, by integers.

    force_i = (sum_j M_ij counts_j - C_i) / 2^shift, rounded

with M = K^-1 step / 10^-6 2^shift and C = M U0 / step, whole numbers: M of at most 30 bits, so that no sum of three
products with counts of 32 bits leaves 64 bits.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from tumble.solving.coefficients import Coefficients

FORCE_STEP = Fraction(1, 1_000_000)
_LARGEST_FACTOR = 2**29
_LARGEST_COUNT = 2**31
_LARGEST_SHIFT = 60

_FUNCTION = """
/* Fixed point. One count of the outputs is {step!r} {unit}, one of the force 1e-6 {force_unit}. */
#include <stdint.h>
#define TUMBLE_COUNT_SIZE ({step_literal}) /* {unit} */
#define TUMBLE_FIXED_SHIFT {shift}
#define TUMBLE_FIXED_MATRIX_INITIALIZER \\
    {matrix}
#define TUMBLE_FIXED_OFFSET_INITIALIZER \\
    {offset}

/* The specific force that counts of the outputs show, rounded to the nearest 1e-6 {force_unit}; what a force of 32 bits
 * cannot hold becomes the largest one of its sign. Whatever the counts are, nothing overflows. */
static inline void tumble_exported_force_fixed(const int32_t counts[3], int32_t force[3])
{{
    static const int32_t matrix[3][3] = TUMBLE_FIXED_MATRIX_INITIALIZER;
    static const int64_t offset[3] = TUMBLE_FIXED_OFFSET_INITIALIZER;
    const int64_t half = INT64_C(1) << (TUMBLE_FIXED_SHIFT - 1);
    for (int i = 0; i < 3; i++) {{
        int64_t sum = -offset[i];
        for (int j = 0; j < 3; j++) {{
            sum += (int64_t)matrix[i][j] * counts[j];
        }}
        int64_t rounded = sum >= 0 ? (sum + half) >> TUMBLE_FIXED_SHIFT : -((half - sum) >> TUMBLE_FIXED_SHIFT);
        rounded = rounded > INT32_MAX ? INT32_MAX : rounded < -INT32_MAX ? -INT32_MAX : rounded;
        force[i] = (int32_t)rounded;
    }}
}}
"""


def fixed_point_function(them: Coefficients, step: float) -> str:
    """The function and its constants; `step`: the size of a count, in the unit of the outputs. Raises ValueError."""
    if them.terms:
        raise ValueError("fixed point has no K2 and K3: export them as float or double")
    if not abs(them.values[9:12]).max() < _LARGEST_COUNT * step:
        raise ValueError(f"--step {step:g}: U0 has more counts than 32 bits hold")
    factors = [[Fraction(one) * Fraction(step) / FORCE_STEP for one in row] for row in them.inverse.tolist()]
    largest = max(abs(one) for row in factors for one in row)
    shift = next((s for s in range(_LARGEST_SHIFT, 0, -1) if largest * 2**s < _LARGEST_FACTOR), None)
    if shift is None:
        raise ValueError(f"--step {step:g}: a count is too large for a force in steps of 1e-6")
    matrix = [[round(one * 2**shift) for one in row] for row in factors]
    counts = [Fraction(one) / Fraction(step) for one in them.values[9:12].tolist()]
    offset = [round(sum(one * bias for one, bias in zip(row, counts))) for row in matrix]
    return _FUNCTION.format(
        step=step,
        step_literal=double_literal(step),
        unit=them.units[9],
        force_unit="g" if them.force_unit == "g" else "m/s^2",
        shift=shift,
        matrix="{ " + ", ".join("{ " + ", ".join(map(str, row)) + " }" for row in matrix) + " }",
        offset="{ " + ", ".join(f"INT64_C({one})" for one in offset) + " }",
    )


def double_literal(value: float) -> str:
    """A C double: 17 digits, and never an integer literal."""
    text = format(value, ".17g")
    return text if any(sign in text for sign in ".e") else text + ".0"


def float_literal(value: float) -> str:
    """A C float: 9 digits of the nearest one."""
    text = format(float(np.float32(value)), ".9g")
    return (text if any(sign in text for sign in ".e") else text + ".0") + "f"
