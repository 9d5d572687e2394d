"""Has the block changed, only its seat, or neither?

The difference of twelve coefficients is that of nine parameters which stay when the block turns, and three angles of
the seat. So three questions are asked, each with the p of its test:

- whole: do the parameters differ, all together? Chi-squared of nine (with K2 and K3: more) degrees of freedom.
- alone: does any one of them? The smallest p, times their number. It sees a single change sooner.
- seat: chi-squared of the three angles, by generalised least squares of the twelve differences.

After Holm, so that two calibrations of a block that nobody touched come out as different in no more cases than the
confidence leaves. `whole` or `alone`: the block has changed, and those parameters are named that stand out by
themselves, after Holm among them. Parameters whose errors are alike may hide a change of one; so the one is told
whose change alone would explain the difference, if there is one. Else `seat`: nothing but the seat has.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.comparison.shared import Calibration
from tumble.comparison.statistics import Whitened, holm, normal_p, test_of, whitened
from tumble.documents.comparison import Test

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
