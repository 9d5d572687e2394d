"""How many floating point operations the formulas of the estimators take, by evaluating them with numbers that count.

Each formula is written as one would by hand who wants few operations: sums that two functionals share are made once,
and nothing is made that the result does not need. A factor that is a power of two counts as nothing, a sign neither:
both are a change of bits. Neither is counted what a schedule or a gain record holds as a constant.
"""

import math
from collections import Counter
from typing import ClassVar

ROOT2 = math.sqrt(2.0)


class Counted:
    """A number that counts what is done to it in `done`, which all of them share."""

    done: ClassVar = Counter()

    def __init__(self, value):
        self.value = float(value)

    def __add__(self, other):
        return self._made("addition", self.value + value_of(other))

    def __sub__(self, other):
        return self._made("addition", self.value - value_of(other))

    def __mul__(self, other):
        factor = value_of(other)
        if not isinstance(other, Counted) and is_power_of_two(factor):
            return Counted(self.value * factor)
        return self._made("multiplication", self.value * factor)

    def __truediv__(self, other):
        return self._made("division", self.value / value_of(other))

    def __neg__(self):
        return Counted(-self.value)

    @classmethod
    def _made(cls, kind, value):
        cls.done[kind] += 1
        return Counted(value)


def value_of(number):
    """Of a number that counts, or of one that does not."""
    return number.value if isinstance(number, Counted) else float(number)


def is_power_of_two(number):
    """Or the negative of one."""
    return abs(math.frexp(number)[0]) == 0.5


def counted(formula, *arrays):
    """(operations by kind, values) of a formula that takes lists of lists of numbers and gives a flat list."""
    Counted.done = Counter()
    found = formula(*([[Counted(one) for one in row] for row in array] for array in arrays))
    return dict(Counted.done), [value_of(one) for one in found]


def means(sums):
    """S/n, times volts per count: [[S, n, scale], ...], one row a mean."""
    return [total / samples * scale for total, samples, scale in sums]


def linear(gains):
    """The formula of constant gains (unknowns, means): sums of gain times mean, without those that are zero."""

    def formula(column):
        u = [row[0] for row in column]
        found = []
        for row in gains:
            first, *others = [u[index] * gain for index, gain in enumerate(row) if gain != 0.0]
            found.append(sum(others, first))
        return found

    return formula


def refined(circles):
    """The closed form (7) on circles of nine or four positions, as the reference has them (`Circle`): K row by row, U0
    from means (positions, 3)."""
    holds = [[axis != circle.normal for axis in range(3)] for circle in circles]

    def tells(number, i, j):
        both = [one[i] and one[j] for one in holds]
        return both[number] if i != j and any(both) else holds[number][j]

    def formula(u):
        k, u0 = [[[] for _ in range(3)] for _ in range(3)], [[] for _ in range(3)]
        for number, circle in enumerate(circles):
            sine, cosine = (int(abs(circle.matrix[:, column]).argmax()) for column in (0, 2))
            for i in range(3):
                channel = [u[slot][i] for slot in circle.slots]
                needs = [tells(number, i, axis) for axis in (cosine, sine)]
                c, s, b = (nine if len(channel) == 9 else four)(channel, *needs)
                u0[i].append(b)
                for axis, column, amplitude in ((cosine, 2, c), (sine, 0, s)):
                    if amplitude is not None:
                        k[i][axis].append(-amplitude if circle.matrix[axis, column] < 0 else amplitude)
        return [mean(amplitudes) for row in k for amplitudes in row] + [mean(biases) for biases in u0]

    return formula


def mean(numbers):
    """One factor, whatever the count."""
    first, *others = numbers
    return sum(others, first) * (1.0 / len(numbers)) if others else first


def nine(u, needs_c, needs_s):
    """c, s, b (section 3 of the method) of one channel on a circle of nine positions; None where it is not needed."""
    u1, u2, u3, u4, u5, u6, u7, u8, u9 = u
    ends, upper, lower = u1 + u9, u2 + u8, u4 + u6
    c = (ends - u5 * 2.0 + (upper - lower) * ROOT2) * 0.125 if needs_c else None
    s = ((u3 - u7) * 2.0 + (u2 - u8 + (u4 - u6)) * ROOT2) * 0.125 if needs_s else None
    return c, s, (ends * 0.5 + upper + lower + u3 + u5 + u7) * 0.125


def four(u, needs_c, needs_s):
    """The same on four positions, 45, 135, 225 and 315 degrees."""
    u1, u2, u3, u4 = u
    if not (needs_c or needs_s):
        return None, None, (u1 + u2 + u3 + u4) * 0.25
    first, second, factor = u1 - u3, u2 - u4, 0.5 / ROOT2
    c = (first - second) * factor if needs_c else None
    s = (first + second) * factor if needs_s else None
    return c, s, (u1 + u2 + u3 + u4) * 0.25
