"""Does the whole model fit a run? Generalised least squares on the exact geometry, dense, by orthogonal factors.

Unknown are the coefficients and every error that the stand declares, each with its variance as prior. The smallest sum
of the squares of all that is left, outputs and errors in units of their standard deviations, is r^T C^-1 r: with r the
residuals of the coefficients' fit, and C the covariance that the declared errors give the outputs. It is found by
Newton's way after Gauss, from a least-squares fit on the ideal stand; so it depends on no estimator.

If it does not fit (`judge`), uncertainties made from the declaration mean nothing. Every pattern of model.patterns is
tested by its own score; the smallest p, with Holm's correction, is the first explanation, unless its size is one that
its cause never has (`Pattern.largest`). Whatever remains is explained in the same way; an error at a position twice, as
two may be exchanged. A pattern may also show where the residuals as a whole still fit: it is told at the same
confidence.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.distributions import chi_squared_above, chi_squared_log_above
from tumble.documents.result import Explanation
from tumble.model.errors import NOISE, OF_OUTPUTS, Errors, declared, free, of_stand
from tumble.model.estimators import by_coefficients, design, estimate, null_space
from tumble.model.norm import TURNED
from tumble.model.patterns import BY_NAME, INCLINATION, STAND, Columns, Pattern, Scene, patterns_of
from tumble.model.prior import Prior
from tumble.model.stand_seen import ANGLES, Estimate, StandSeen
from tumble.schedule import Schedule
from tumble.stand import LARGEST_ERROR_RAD, Stand
from tumble.terms import Terms, as_patterns

PASSES = 4
_FLOOR_G = 1e-7  # times the largest element of its row of K: the noise of a mean never counts as less
_NULL = 1e-7
_INESTIMABLE = 1e-6
_SHOWN = 0.01


@dataclass(frozen=True)
class Score:
    """Of one pattern: degrees of `freedom` of its chi-squared, and the logarithm `log_p` of how often that is larger by
    chance; `sizes` with their standard uncertainties, by label, of those that are determined; `spread`: how large they
    are if they are random."""

    freedom: int
    log_p: float
    sizes: dict[str, tuple[float, float]]
    spread: float


class WholeModel:
    """The declared `stand`, in the unit of the `means` (positions, 3) of a schedule, all measured; `variance`
    (positions, 3), or (positions,) for channels that are alike, of each mean by its noise. `terms`: unknown too.
    `known`: K (3, 3) and U0 (3,), at which what the positions do not determine of the coefficients is held; with a
    `prior`, whose rows are then among the residuals, they are where it begins.

    `rest`: what no unknown explains, as independent numbers of variance 1; `chi_squared`: the sum of its squares, which
    is the smallest, at `k` and `u0`, and `freedom` its degrees of freedom: every declared error brings a square of its
    own. `patterns`: that it may show instead, and the `scene` that they are made from."""

    def __init__(
        self,
        schedule: Schedule,
        means: Floats,
        variance: Floats,
        stand: Stand,
        terms: Terms = (),
        known: tuple[Floats, Floats] | None = None,
        prior: Prior | None = None,
    ):
        self._given = schedule, means, variance, stand
        self._begun, self._prior = known, prior
        self.terms, self._further = terms, design(schedule, terms)[:, 12:]
        self._sizes = np.zeros(3 * len(terms))
        self.schedule, self._outputs = schedule.fitted, means[schedule.fit_indices]
        self.k, self.u0 = estimate(self.schedule, self._outputs, "least_squares") if known is None else known
        by_channel = np.broadcast_to(variance.reshape(len(means), -1), means.shape)[schedule.fit_indices]
        self._noise = np.maximum(np.sqrt(by_channel), _FLOOR_G * np.abs(self.k).max(axis=1))
        names = [*(name for name in declared(stand, schedule) if name != NOISE), *free(stand, schedule)]
        self._errors = Errors(self.schedule, of_stand(self.schedule, self.k, stand, names))
        self._sigma = self._errors.sigma
        self._known = np.flatnonzero(~self._errors.free)  # those that have a prior
        turned = np.eye(12)[list(TURNED)]  # of K: the block's frame is free to turn
        self._held = turned if "seat" in free(stand, schedule) else np.zeros((0, 12))
        if known is not None and prior is None:
            self._held = null_space(design(self.schedule))
        self._largest = np.full(len(self._sigma), LARGEST_ERROR_RAD)
        for name in set(OF_OUTPUTS) & set(names):
            self._largest[self._errors.of[name]] = np.inf
        self._x = np.zeros(len(self._sigma))  # rad, or as outputs are
        for _ in range(PASSES):
            self._linearise()
        self.chi_squared, self.freedom = float(self.rest @ self.rest), len(self.rest)
        self.scene, self.patterns = Scene(self.schedule, self.k), patterns_of(self.schedule, stand)

    def again(self, variance: Floats | None = None, angle: float | None = None) -> WholeModel:
        """The same run with other noise, or another standard deviation of set angles, rad."""
        schedule, means, of_means, stand = self._given
        stand = stand if angle is None else stand.with_sigma("angle", angle)
        of_means = of_means if variance is None else variance
        return WholeModel(schedule, means, of_means, stand, self.terms, self._begun, self._prior)

    def _linearise(self) -> None:
        """Solve the problem that is linear where the pass before ended. `_left`: the directions of `rest` among outputs
        and errors; `_coefficients`: those of the coefficients."""
        force = self._errors.force(self._x)
        by_unknown = np.hstack([by_coefficients(force), self._further])
        noise = self._noise.reshape(-1, 1)
        derivatives = self._errors.derivative(self.k, self._x).reshape(len(self._x), -1).T
        prior = np.eye(len(self._x), by_unknown.shape[1] + len(self._x), by_unknown.shape[1])[self._known]
        fixed = np.pad(self._held, ((0, 0), (0, prior.shape[1] - 12))) / self._noise.min()
        rows, of_rows = (np.zeros((0, 12)), np.zeros(0)) if self._prior is None else self._prior.rows(self.k, self.u0)
        rows = np.pad(rows, ((0, 0), (0, prior.shape[1] - 12)))
        system = np.vstack([np.hstack([by_unknown / noise, derivatives * self._sigma / noise]), prior, fixed, rows])
        sigma = np.where(self._sigma > 0.0, self._sigma, 1.0)
        shown = (self._outputs - self._errors.outputs(self.k, self.u0, self._x)).ravel() - self._further @ self._sizes
        left = shown / noise[:, 0]
        right = np.concatenate(
            [left, ((self._errors.mean - self._x) / sigma)[self._known], np.zeros(len(fixed)), of_rows]
        )
        length = np.sqrt((system**2).sum(axis=0))
        q, r = np.linalg.qr(system / length, mode="complete")
        unknowns = system.shape[1]
        change = np.linalg.solve(r[:unknowns], q[:, :unknowns].T @ right) / length
        self._coefficients, self._left = q[: len(left), :12], q[: len(left), unknowns:]
        self.rest = q[:, unknowns:].T @ right
        self.k = self.k + change[:9].reshape(3, 3)
        self.u0 = self.u0 + change[9:12]
        self._sizes = self._sizes + change[12 : by_unknown.shape[1]]
        self._x = np.clip(self._x + change[by_unknown.shape[1] :] * self._sigma, -self._largest, self._largest)

    def whitened(self, columns: Columns) -> Floats:
        """What the residuals show of a pattern: (freedom, columns), where they are independent and of variance 1. A
        column that the unknowns take up is 0. So is one of which the coefficients leave less than a hundredth: it shows
        only by the errors of the stand, as cubes do on the diagonals; or only by rounding, as a yaw does where gravity
        lies along its axis."""
        outputs = np.array([(column / self._noise).ravel() for column in columns.values()]).T
        return shown_by_residuals(outputs, self._left.T @ outputs, self._coefficients)

    def given(self, besides: Columns) -> tuple[Floats, Floats]:
        """The space of other patterns that are there `besides`, (freedom, their rank), and what remains of `rest`."""
        known = basis(self.whitened(besides)) if besides else np.zeros((len(self.rest), 0))
        return known, self.rest - known @ (known.T @ self.rest)

    def score(self, columns: Columns, beside: tuple[Floats, Floats]) -> Score:
        """The score test of a pattern, given others, as `beside` has them."""
        (known, rest), shown = beside, self.whitened(columns)
        if known.shape[1] > 0:
            length = np.linalg.norm(shown, axis=0)
            shown = shown - known @ (known.T @ shown)
            shown = np.where(np.linalg.norm(shown, axis=0) > _NULL * length, shown, 0.0)
        own = basis(shown)
        part = own.T @ rest
        freedom, squares = own.shape[1], float(part @ part)
        gain = float((shown**2).sum())  # what errors of variance 1 add to the squares, beside 1 for each by noise
        spread = math.sqrt(max(squares - freedom, 0.0) / gain) if gain else 0.0
        return Score(freedom, chi_squared_log_above(squares, freedom), _sizes(list(columns), shown, rest), spread)


def shown_by_residuals(outputs: Floats, shown: Floats, coefficients: Floats) -> Floats:
    """What the residuals have of columns of `outputs`, `shown`, without what they show by rounding, or of which the
    coefficients, whose directions these are, leave almost nothing."""
    length = np.linalg.norm(outputs, axis=0)
    beside = outputs - coefficients @ (coefficients.T @ outputs)
    seen = np.linalg.norm(shown, axis=0) > _NULL * length
    seen &= np.linalg.norm(beside, axis=0) > _SHOWN * length
    seen &= length > _NULL * length.max(initial=0.0)
    return np.where(seen, shown, 0.0)


def basis(columns: Floats) -> Floats:
    """Orthonormal, of the space that columns span, each taken at its own length."""
    length = np.linalg.norm(columns, axis=0)
    used = columns[:, length > 0.0] / length[length > 0.0]
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    space: Floats = left[:, singular > _NULL]
    return space


def _sizes(names: list[str], shown: Floats, rest: Floats) -> dict[str, tuple[float, float]]:
    """Estimate and standard uncertainty of every column's size, where the others leave it to be told."""
    length = np.linalg.norm(shown, axis=0)
    seen = np.flatnonzero(length)
    if len(seen) == 0:
        return {}
    left, singular, directions = np.linalg.svd(shown[:, seen] / length[seen], full_matrices=True)
    rank = int((singular > _NULL).sum())
    inverse = (directions[:rank].T / singular[:rank]) @ left[:, :rank].T
    found = {}
    for row, place in enumerate(seen):
        if np.abs(directions[rank:, row]).max(initial=0.0) < _INESTIMABLE:
            gains = inverse[row] / length[place]
            found[names[place]] = float(gains @ rest), float(np.linalg.norm(gains))
    return found


CONFIDENCE = 0.999
EXPLAINED = 0.01  # largest p, after Holm, of an explanation
ALIKE = 0.75  # patterns with a larger cosine may be taken for each other
_CONTAINED = 0.9999
_DIGITS = 9  # of log p: of patterns or places that show as much it is the first, whatever the rounding
_RAD = ("rad", "urad")  # units of angles
_POSITION = "position"  # found twice, for two that were exchanged
_SURE = 3.0  # standard uncertainties by which a size is too large
_TOLD = 2.0  # of them that a size exceeds, before it is told
NOISE_V = "noise_v"
SYSTEMATIC = tuple(f"{name}_rad" for name in ANGLES)
_DECLARED = (INCLINATION.name, *SYSTEMATIC)
DOUBTS = (*SYSTEMATIC, "alpha4_rad", NOISE_V)  # sources of a stand that a misfit may name


@dataclass(frozen=True)
class Sampled:
    """A pattern that samples show by themselves: `log_p`, how often they do by chance; `size`, `u_size` in `unit`, and
    the `column` it is of; `variance` (positions, 3) of the means with it."""

    name: str
    log_p: float
    size: float
    u_size: float
    unit: str
    column: str
    variance: Floats


@dataclass(frozen=True)
class Fit:
    """`chi_squared` with `freedom`; `p`: how often a run that fits comes out above; `confidence` asked for;
    `explanations`: each of patterns that cannot be told apart, the likeliest first."""

    chi_squared: float
    freedom: int
    p: float
    confidence: float
    explanations: tuple[Explanation, ...]

    @property
    def fits(self) -> bool:
        """Whether the declared stand explains the run."""
        return self.p >= 1.0 - self.confidence

    @property
    def misfit(self) -> float | None:
        """Rms of the residuals over what the stand declares; None without freedom."""
        return math.sqrt(self.chi_squared / self.freedom) if self.freedom else None

    @property
    def excuses_stand(self) -> bool:
        """Whether what explains most of it may be no fault of the stand: the block's, or that of this run."""
        likeliest = self.explanations[0].patterns if self.explanations else ()
        others = [name for name in likeliest if name != NOISE_V]
        return any(name not in BY_NAME or BY_NAME[name].whose != STAND for name in others)

    @property
    def stand_doubts(self) -> tuple[str, ...]:
        """The declared sources among the explanations."""
        named = [name for explanation in self.explanations for name in explanation.patterns]
        return tuple(name for name in DOUBTS if name in named)


def judge(model: WholeModel, confidence: float, seen: StandSeen, sampled: Sequence[Sampled] = ()) -> Fit:
    """The verdict on a run; `sampled`: what its samples show by themselves."""
    p = chi_squared_above(model.chi_squared, model.freedom)
    explanations = tuple(_Search(model, seen, sampled, confidence).run()) if model.freedom else ()
    return Fit(model.chi_squared, model.freedom, p, confidence, explanations)


def variance_of_means(stand: Stand, samples: Integers, rounding: float | Floats) -> Floats:
    """By the declared noise of `stand`, and standard deviations of `rounding`, (3,) or one, that averaging does not
    help."""
    return stand.mean_variance(samples) + rounding**2


@dataclass(frozen=True)
class _Candidate:
    """A pattern at the place where it shows most, out of `places`, beside what is known already; `log_p`: had any place
    been taken that shows more."""

    pattern: Pattern
    columns: Columns
    score: Score
    places: int
    log_p: float


class _Search:
    """The pattern with the smallest p, then with it in the model the next, until nothing shows: below EXPLAINED where
    the residuals do not fit, else as seldom as an honest run is refused.

    A pattern of random errors, such as set angles, has no shape: once it is found, the model has errors as large as the
    run shows, instead of free columns. Patterns of noise come from the samples, and not from the residuals.
    """

    def __init__(self, model: WholeModel, seen: StandSeen, sampled: Sequence[Sampled], confidence: float):
        self._model, self._seen, self._confidence = model, seen, confidence
        self._sampled = {one.name: one for one in sampled}
        self._known: Columns = {}
        self._left = [*(one.name for one in model.patterns if one.name not in as_patterns(model.terms)), *self._sampled]

    def run(self) -> Iterator[Explanation]:
        """Explanations, in the order in which they are found."""
        while True:
            rest = self._model.given(self._known)[1]
            fits = chi_squared_above(float(rest @ rest), self._model.freedom) >= 1.0 - self._confidence
            found = {one.pattern.name: one for one in map(self._candidate, self._model.patterns) if one is not None}
            log_p = {name: one.log_p for name, one in found.items() if name in self._left}
            if not fits:  # else samples speak for themselves: uncertainties count their noise, and a warning tells it
                log_p |= {name: one.log_p for name, one in self._sampled.items() if name in self._left}
            name = min(log_p, key=lambda one: round(log_p[one], _DIGITS), default=None)
            if name is None:
                return
            corrected = len(self._left) * math.exp(log_p[name])
            if corrected > (1.0 - self._confidence if fits else EXPLAINED):
                return
            alike = [other for other in found if name in found and self._may_be(found[name], found[other])]
            source = next((one for one in _DECLARED if one in alike), None)
            if source is not None:  # where either may be, the declared one is the simpler
                alike = [name, *(other for other in alike if other != source)]
                name, corrected = source, len(self._left) * math.exp(log_p[source])
            if name in self._sampled:
                one = self._sampled[name]
                yield Explanation((name,), corrected, one.size, one.u_size, one.unit, one.column or None)
            else:
                yield self._explanation(found[name], alike, corrected)
            self._take(name, found)

    def _candidate(self, pattern: Pattern) -> _Candidate | None:
        """None where the residuals cannot show it, or only by a size that is too large to be what it is called."""
        besides = dict(self._known)
        if pattern.random:  # it must not be blamed for what an angle of the whole run does
            for name in SYSTEMATIC:
                columns = BY_NAME[name].columns(self._model.scene)[0]
                besides |= {f"{name} {label}": one for label, one in columns.items()}
        beside = self._model.given(besides)  # of which a pattern may have many places
        tested = [(self._model.score(one, beside), one) for one in pattern.columns(self._model.scene)]
        shown = [
            (score, columns) for score, columns in tested if score.freedom > 0 and self._is_plausible(pattern, score)
        ]
        if not shown:
            return None
        score, columns = min(shown, key=lambda one: round(one[0].log_p, _DIGITS))
        return _Candidate(pattern, columns, score, len(shown), math.log(len(shown)) + score.log_p)

    def _is_plausible(self, pattern: Pattern, score: Score) -> bool:
        """May a cause of this kind be so large? An angle also where the linear theory holds."""
        told = self._of_whole_run(pattern)
        if told is not None:
            return abs(told.value) <= pattern.largest
        if pattern.random:
            return score.spread <= pattern.largest
        sure = 0.0 if pattern.unit in _RAD else _SURE
        return all(abs(size) - sure * u <= pattern.largest for size, u in score.sizes.values())

    def _of_whole_run(self, pattern: Pattern) -> Estimate | None:
        """An angle of the stand as it stands in the result."""
        return {"alpha4": self._seen.alpha4, **self._seen.angles}.get(pattern.name.removesuffix("_rad"))

    def _may_be(self, one: _Candidate, other: _Candidate) -> bool:
        """Whether another pattern explains what one explains: they look alike, and beside the other one the first is no
        longer needed. One that contains the first and more is no other explanation."""
        if one is other or one.pattern.random or other.pattern.random or other.pattern.name not in self._left:
            return False
        spaces = [basis(self._model.whitened(candidate.columns)) for candidate in (one, other)]
        angles = np.linalg.svd(spaces[0].T @ spaces[1], compute_uv=False)
        wider = spaces[1].shape[1] > spaces[0].shape[1] and bool((angles > _CONTAINED).all())
        besides = {**self._known, **{f"other {label}": column for label, column in other.columns.items()}}
        score = self._model.score(one.columns, self._model.given(besides))
        needed = len(self._left) * one.places * math.exp(score.log_p) <= EXPLAINED
        return not wider and not needed and float(angles.max(initial=0.0)) >= ALIKE

    def _take(self, name: str, found: dict[str, _Candidate]) -> None:
        """Make what has been found part of the model."""
        if name != _POSITION or any(one.startswith(f"{name} ") for one in self._known):
            self._left.remove(name)
        if name in self._sampled:
            self._model = self._model.again(variance=self._sampled[name].variance)
        elif found[name].pattern.random and self._seen.alpha4 is not None:
            self._model = self._model.again(angle=self._seen.alpha4.value)
        else:
            self._known |= {f"{name} {label}": one for label, one in found[name].columns.items()}

    def _explanation(self, one: _Candidate, alike: list[str], p: float) -> Explanation:
        unit, sizes = one.pattern.unit, one.score.sizes
        seen = self._of_whole_run(one.pattern)
        if seen is not None:
            return Explanation((one.pattern.name, *alike), p, seen.value, seen.u, unit, None)
        where = next(iter(one.columns)).partition(" ")[0] if one.pattern.name == _POSITION else ""
        known = {label: size for label, size in sizes.items() if abs(size[0]) > _TOLD * size[1]}
        column = max(known, key=lambda label: abs(known[label][0]) / known[label][1], default=where)
        found = known.get(column, (None, None))
        return Explanation((one.pattern.name, *alike), p, found[0], found[1], unit, column or None)
