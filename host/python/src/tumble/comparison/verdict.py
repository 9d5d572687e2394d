"""Has the block changed, only its seat, or neither?

The difference of twelve coefficients is that of nine parameters which stay when the block turns, and three angles of
the seat. So three questions are asked, each with the p of its test:

- whole: do the parameters differ, all together? Chi-squared of nine (with further terms: more) degrees of freedom.
- alone: does any one of them? The smallest p, times their number. It sees a single change sooner.
- seat: chi-squared of the three angles, by generalised least squares of the twelve differences.

After Holm, so that two calibrations of a block that nobody touched come out as different in no more cases than the
confidence leaves. `whole` or `alone`: the block has changed, and those parameters are named that stand out by
themselves, after Holm among them. Parameters whose errors are alike may hide a change of one; so the one is told
whose change alone would explain the difference, if there is one. Else `seat`: nothing but the seat has.

A block that sits turned by a small vector phi has K (I + [phi]x) in place of K: the lengths of K's rows, the angles
between them and U0 stay (`Calibration.parameters`). A difference is tested by its covariance, also where that has
directions without any variance (`whitened`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.distributions import chi_squared_above
from tumble.documents.comparison import Test
from tumble.model.coefficients import PAIRS, by_intrinsic
from tumble.solving.coefficients import POWERS_OF_TWELVE
from tumble.terms import POWERS, Terms, names

NAMES = (
    *(f"scale_{axis}" for axis in "xyz"),
    *(f"angle_{pair}" for pair in ("xy", "xz", "yz")),
    *(f"bias_{axis}" for axis in "xyz"),
)
UNITS = ("ppm",) * 3 + ("urad",) * 3 + ("ug",) * 3
_UNITS_OF_TERMS = {1: "ug/g", 2: "ug/g^2", 3: "ug/g^3"}  # by their power


@dataclass(frozen=True)
class Calibration:
    """`values` (12 + 3 x terms,): K row by row, U0, then the values of `terms`, of POWERS, in the unit of the
    outputs and g. Their `covariance`, None where it is unknown: all of it, or without `in_common`, (draws, 12 + 3 x
    terms): errors that the other calibration has as well, draw by draw, one standard deviation of each."""

    values: Floats
    covariance: Floats | None
    terms: Terms = ()
    in_common: Floats | None = None

    @property
    def k(self) -> Floats:
        """K (3, 3)."""
        return self.values[:9].reshape(3, 3)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Of `parameters`."""
        return NAMES + names(self.terms)

    @property
    def parameter_units(self) -> tuple[str, ...]:
        """Of a millionth of each parameter."""
        return UNITS + tuple(_UNITS_OF_TERMS[POWERS[term]] for term in self.terms for _ in "xyz")

    @property
    def parameters(self) -> Floats:
        """What does not depend on the seat (9 + 3 x terms,): the logarithms of the lengths of K's rows, so that a
        difference is a relative one, the angles between the rows xy, xz, yz in rad, U0 over the lengths in g; K2 and
        K3."""
        length = np.linalg.norm(self.k, axis=1)
        axis = self.k / length[:, None]
        angles = [np.arctan2(np.linalg.norm(np.cross(axis[i], axis[j])), axis[i] @ axis[j]) for i, j in PAIRS]
        return np.concatenate([np.log(length), angles, self.values[9:12] / length, self.values[12:]])

    @property
    def by_values(self) -> Floats:
        """Derivatives of `parameters` by `values`, (9 + 3 x terms, 12 + 3 x terms)."""
        found = np.zeros((len(self.values) - 3, len(self.values)))
        found[:9, :12] = by_intrinsic(self.k, self.values[9:12])
        found[:3] /= np.linalg.norm(self.k, axis=1)[:, None]
        found[9:, 12:] = np.eye(len(self.values) - 12)
        return found

    def reduced(self, terms: Terms) -> Calibration:
        """With these of its terms alone."""
        kept = [*range(12), *(12 + 3 * self.terms.index(term) + axis for term in terms for axis in range(3))]
        covariance = None if self.covariance is None else self.covariance[np.ix_(kept, kept)]
        in_common = None if self.in_common is None else self.in_common[:, kept]
        return Calibration(self.values[kept], covariance, terms, in_common)

    def at_gravity(self, ratio: float) -> Calibration:
        """For accelerations in units of another gravity, so many times that of its own place."""
        factor = ratio**self.powers
        covariance = None if self.covariance is None else factor[:, None] * self.covariance * factor
        in_common = None if self.in_common is None else self.in_common * factor
        return replace(self, values=self.values * factor, covariance=covariance, in_common=in_common)

    @property
    def powers(self) -> Floats:
        """Of the gravity in `values`."""
        return np.concatenate([POWERS_OF_TWELVE, np.repeat([POWERS[term] - 1.0 for term in self.terms], 3)])


_NONE = 1e-12  # variance of a direction, in units of the standard uncertainties: what is left of rounding
_ASYMMETRY = 1e-6  # in the same units: more than a file of fifteen digits leaves, or of fewer
_BEYOND = 1e-5  # of a difference in such a direction, in the same units: more than rounding


def test_of(chi_squared: float, freedom: int) -> Test:
    """How often it is as large by chance: 1 without freedom."""
    return Test(chi_squared, freedom, chi_squared_above(chi_squared, freedom) if freedom else 1.0)


@dataclass(frozen=True)
class Whitened:
    """A difference in coordinates (n,) that are independent, of variance 1: `rows` (n, n) times it. `freedom`: how many
    of them count."""

    rows: Floats
    difference: Floats
    freedom: int

    @property
    def test(self) -> Test:
        """Of the whole difference."""
        return test_of(float(self.difference @ self.difference), self.freedom)


def whitened(covariance: Floats, difference: Floats, rounding: Floats) -> Whitened:
    """Of a difference (n,) with this covariance (n, n); `rounding` (n,): sizes below which it is nothing.

    A direction without variance counts where the difference has more in it than rounding leaves, which no chance
    explains. Else it is no degree of freedom, and the difference is taken to be 0 there.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0) + rounding**2)
    variance, directions = np.linalg.eigh((covariance + np.diag(rounding**2)) / np.outer(size, size))
    shown = directions.T @ (difference / size)
    counts: Flags = (variance > _NONE) | (np.abs(shown) > _BEYOND)
    scale = np.sqrt(np.maximum(variance, _NONE))
    rows: Floats = (directions / scale).T / size
    return Whitened(rows, np.where(counts, shown / scale, 0.0), int(counts.sum()))


def is_covariance(matrix: Floats) -> bool:
    """Whether a matrix (n, n) is symmetric, and has no direction with less variance than rounding leaves."""
    variance = np.diag(matrix)
    if (variance < 0.0).any() or matrix[variance == 0.0].any():
        return False
    size = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    scaled = matrix / np.outer(size, size)
    return bool(np.abs(scaled - scaled.T).max() < _ASYMMETRY and np.linalg.eigvalsh(scaled).min() > -_ASYMMETRY)


def normal_p(difference: Floats, u: Floats) -> Floats:
    """How often differences (n,) of these standard uncertainties (n,), above 0, are as large by chance."""
    return np.array([chi_squared_above(float(one), 1.0) for one in (difference / u) ** 2])


def holm(p: Sequence[float]) -> list[float]:
    """Each p such that any is below a level, where nothing is there, in no more runs than that level says (Holm 1979):
    times the number of those that are no smaller, and no less than what a smaller one came to."""
    found, worst = [1.0] * len(p), 0.0
    for rank, place in enumerate(sorted(range(len(p)), key=lambda one: p[one])):
        worst = max(worst, min(1.0, (len(p) - rank) * p[place]))
        found[place] = worst
    return found


EXPLAINED = 0.01  # p of what an explanation leaves, at least
_ROUNDING = 1e-13  # of the largest coefficient; of the parameters, which are numbers of size 1, themselves


class Verdict(str, Enum):
    """What two calibrations say of one block."""

    UNCHANGED = "unchanged"
    SEAT = "seat"
    BLOCK = "block"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class Differences:
    """B less A, `size` (n,), with standard uncertainties `u` (n,), None where they are unknown."""

    size: Floats
    u: Floats | None

    @property
    def in_u(self) -> Floats | None:
        """Sizes over u; infinite where there is no uncertainty, but a difference."""
        if self.u is None:
            return None
        with np.errstate(divide="ignore", invalid="ignore"):
            found: Floats = np.where(self.size == 0.0, 0.0, self.size / self.u)
        return found


@dataclass(frozen=True)
class Explanation:
    """The one parameter, by its `index`, whose change alone comes nearest to the difference: by `size` with standard
    uncertainty `u`, and the `p` of what that leaves, as often as chance leaves more."""

    index: int
    size: float
    u: float
    p: float


@dataclass(frozen=True)
class Tests:
    """`all_twelve`: of the whole difference; `block`: of the parameters; `alone`: p of the one that stands out most,
    times their number; `seat`: of its angles. `p_parameters`: of every parameter, after Holm among them; `nearest`:
    what comes nearest to explaining it by one parameter."""

    all_twelve: Test
    block: Test
    alone: float
    seat: Test
    p_parameters: Floats
    nearest: Explanation

    @property
    def adjusted(self) -> dict[str, float]:
        """The p of the three questions after Holm."""
        return dict(zip(("whole", "alone", "seat"), holm([self.block.p, self.alone, self.seat.p])))


@dataclass(frozen=True)
class Found:
    """`coefficients`: (12,) and K2, K3; `parameters`: as Calibration.parameters has them; `seat` (3,): rad about x, y
    and z of the block, by which it sits turned in B against A; `tests`: None without uncertainties."""

    coefficients: Differences
    parameters: Differences
    seat: Differences
    tests: Tests | None
    confidence: float

    @property
    def verdict(self) -> Verdict:
        """One of the four."""
        if self.tests is None:
            return Verdict.CANNOT_TELL
        p = self.tests.adjusted
        if min(p["whole"], p["alone"]) < 1.0 - self.confidence:
            return Verdict.BLOCK
        return Verdict.SEAT if p["seat"] < 1.0 - self.confidence else Verdict.UNCHANGED

    @property
    def explanation(self) -> Explanation | None:
        """Of a block that has changed: the one parameter that would do; None where none does."""
        if self.tests is None or self.verdict is not Verdict.BLOCK or self.tests.nearest.p < EXPLAINED:
            return None
        return self.tests.nearest

    @property
    def changed(self) -> Flags:
        """Which parameters have changed (n,); none of a block that has not."""
        if self.tests is None or self.verdict is not Verdict.BLOCK:
            return np.zeros(len(self.parameters.size), dtype=bool)
        found: Flags = self.tests.p_parameters < 1.0 - self.confidence
        return found


def judge(a: Calibration, b: Calibration, gravity: float, confidence: float) -> Found:
    """Hold B against A, of the same terms, and with the same draws in common. `gravity`: relative standard uncertainty
    of the ratio of the two gravities."""
    size, parameters = b.values - a.values, b.parameters - a.parameters
    turned = _turned((a.k + b.k) / 2.0)
    if a.covariance is None or b.covariance is None:
        fitted: Floats = np.asarray(np.linalg.lstsq(turned, size[:12], rcond=None)[0], dtype=float)
        alone = Differences(size, None), Differences(parameters, None), Differences(_vector(fitted), None)
        return Found(*alone, None, confidence)
    by_gravity = gravity * a.powers * (a.values + b.values) / 2.0
    moved = replace(b, covariance=b.covariance + np.outer(by_gravity, by_gravity))
    covariance = _of_difference(a, moved, np.eye(len(size)), np.eye(len(size)))
    of_parameters = _of_difference(a, moved, a.by_values, b.by_values)
    rounding = np.full(len(size), _ROUNDING * float(np.abs(np.concatenate([a.values[:12], b.values[:12]])).max()))
    twelve = whitened(covariance[:12, :12], size[:12], rounding[:12])
    angles, u_angles, seat = _fitted(twelve.rows @ turned, twelve.difference)
    flat = np.full(len(parameters), _ROUNDING)
    block = whitened(of_parameters, parameters, flat)
    each = normal_p(parameters, np.hypot(_roots(of_parameters), flat))
    return Found(
        Differences(size, _roots(covariance)),
        Differences(parameters, _roots(of_parameters)),
        Differences(_vector(angles), u_angles),
        Tests(
            all_twelve=twelve.test,
            block=block.test,
            alone=min(1.0, len(each) * float(each.min())),
            seat=seat,
            p_parameters=np.array(holm(each.tolist())),
            nearest=_nearest(block),
        ),
        confidence,
    )


def _nearest(block: Whitened) -> Explanation:
    """By the score of each parameter: generalised least squares of the difference on it alone."""
    length = np.linalg.norm(block.rows, axis=0)
    scores = block.rows.T @ block.difference / length
    best = int(np.abs(scores).argmax())
    left = test_of(max(0.0, block.test.chi2 - float(scores[best] ** 2)), max(0, block.freedom - 1))
    return Explanation(best, float(scores[best] / length[best]), float(1.0 / length[best]), left.p)


def _turned(k: Floats) -> Floats:
    """Derivatives (12, 3) of the coefficients by the angles of a turn about x, y and z: K [phi]x row by row.

    With `k` halfway between K and K R this holds for a turn R of any size, phi being twice the tangent of half its
    angle (Cayley): K R - K = (K + K R)/2 [phi]x.
    """
    found = np.zeros((12, 3))
    for axis, unit in enumerate(np.eye(3)):
        cross = np.array([[0.0, -unit[2], unit[1]], [unit[2], 0.0, -unit[0]], [-unit[1], unit[0], 0.0]])
        found[:9, axis] = (k @ cross).ravel()
    return found


def _vector(angles: Floats) -> Floats:
    """The turn (3,) in rad, of twice the tangent of half its angle."""
    length = float(np.linalg.norm(angles))
    return angles if length == 0.0 else angles * (2.0 * np.arctan(length / 2.0) / length)


def _of_difference(a: Calibration, b: Calibration, by_a: Floats, by_b: Floats) -> Floats:
    """Covariance of the difference of what has these derivatives by A's and B's values. What both have in common is
    subtracted draw by draw, so that rounding leaves no variance below 0."""
    assert a.covariance is not None and b.covariance is not None  # or nothing is judged
    found: Floats = by_a @ a.covariance @ by_a.T + by_b @ b.covariance @ by_b.T
    if a.in_common is not None and b.in_common is not None:
        left = b.in_common @ by_b.T - a.in_common @ by_a.T
        found = found + left.T @ left
    return (found + found.T) / 2.0


def _roots(covariance: Floats) -> Floats:
    """Standard uncertainties; rounding may leave less than nothing of what cancels."""
    found: Floats = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return found


def _fitted(own: Floats, seen: Floats) -> tuple[Floats, Floats, Test]:
    """Angles (3,), their standard uncertainties, and their test, from whitened columns (12, 3) and difference."""
    left, singular, right = np.linalg.svd(own, full_matrices=False)
    part = left.T @ seen
    angles = right.T @ (part / singular)
    u = np.sqrt(((right.T / singular) ** 2).sum(axis=1))
    return angles, u, test_of(float(part @ part), 3)
