"""What a run could not have shown: Baarda's reliability, from geodesy.

Of every pattern that no stand file declares: the size that its score test finds nine times in ten, and the error of |a|
that so much of it leaves, at the worst attitude. It follows from the schedule, the stand and the estimator alone, so it
is known before a run.

What no run of a schedule shows, whatever the size (seat_is_unseen, unseen_patterns): a tilt of the block against the
axis that is common to all mountings, and those of the block's own patterns, such as a third order, that lie in the span
of the coefficients.
"""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.distributions import noncentrality
from tumble.estimators import NORM
from tumble.model.coefficients import norm_gradient, spread_attitudes
from tumble.model.errors import brought, by_gains, declared, of_stand, unit_effect
from tumble.model.estimators import design, gains_at
from tumble.model.fit import CONFIDENCE, DOUBTS, WholeModel, basis, variance_of_means
from tumble.model.geometry import ideal_force
from tumble.model.patterns import BLOCK, BY_NAME, PATTERNS, Columns, Pattern, Scene
from tumble.model.propagation import Propagation
from tumble.schedule import Schedule
from tumble.stand import SOURCES, Stand
from tumble.terms import Terms, as_patterns

_SEEN = 1e-6  # of the effect, left by what explains it: rounding leaves 1e-14, any position that shows it a tenth
_SHOWN = 1e-2  # of a pattern: what the block's misalignments alone leave of it, as of cubes on inclines, is less
_COUNTS = 0.1  # of the largest change: less is the block's misalignment and no doubt worth a mark
_UNIT_SEAT = Stand(0.0, 0.0, 0.0, 0.0, 0.0, 1, "sigma1", seat=1.0, platform=1.0)


def seat_is_unseen(schedule: Schedule, k: Floats, terms: Terms = ()) -> bool:
    """Whether the fit positions show nothing of a common tilt of the block against the axis, beside coefficients, all
    other angles that positions share, and further `terms` of the model."""
    fitted, boltings = schedule.fitted, len(schedule.boltings)
    angles = [unit_effect(fitted, name).derivative(k) for name in ("alpha1", "alpha2", "alpha3", "inclination")]
    angles.append(unit_effect(fitted, "seat").derivative(k)[boltings:])
    others = np.concatenate(angles)
    explaining = np.column_stack([design(fitted, terms), others.reshape(len(others), -1).T])
    return _is_hidden(unit_effect(fitted, "platform").derivative(k).reshape(1, -1).T, explaining)


def moved_by_a_seat(schedule: Schedule, k: Floats, estimator: str, gains: Floats | None = None) -> dict[str, Floats]:
    """Standard deviations (12,) of K row by row and U0 that a seat of one radian would bring, drawn in every mounting,
    and a platform of one radian, to first order. `estimator`: one of estimators.LINEAR; `gains` (12, 3 x fit
    positions): in place of its own."""
    fitted = schedule.fitted
    errors = of_stand(fitted, k, _UNIT_SEAT, ("seat", "platform"))
    moved = brought(by_gains(fitted, gains_at(fitted, k, estimator) if gains is None else gains), errors)
    return {name: np.linalg.norm(draws, axis=0) for name, draws in moved.items()}


def unseen_patterns(schedule: Schedule, k: Floats, estimator: str, gains: Floats | None = None) -> dict[str, Flags]:
    """By name of a pattern of the block that no fit position shows, in one channel or more: the elements of K (3, 3)
    that it moves, where it moves any. `estimator`: one that needs no stand; `gains` as of moved_by_a_seat."""
    fitted, found = schedule.fitted, {}
    inclinations = unit_effect(fitted, "inclination").derivative(k)
    if estimator == NORM:  # what turns a pose shows nothing
        inclinations = unit_effect(fitted, "seat").derivative(k)
    explaining = np.column_stack([design(fitted), inclinations.reshape(len(inclinations), 3 * len(fitted.positions)).T])
    for pattern in (one for one in PATTERNS if one.whose == BLOCK):
        columns = [one.reshape(-1, 1) for one in pattern.columns(Scene(fitted, k))[0].values()]
        hidden = [one for one in columns if one.any() and _is_hidden(one, explaining, _SHOWN)]
        used = gains_at(fitted, k, estimator) if gains is None else gains
        moved = np.abs(used[:9] @ np.sum(hidden or [np.zeros_like(columns[0])], axis=0)).reshape(3, 3)
        if moved.max() > _SEEN * max(np.abs(one).max() for one in columns):  # else it is a bias
            found[pattern.name] = moved > _COUNTS * moved.max()
    return found


def _is_hidden(effect: Floats, explaining: Floats, seen: float = _SEEN) -> bool:
    """Whether the columns of an effect lie in the span of others, but for `seen` of it."""
    left = effect - explaining @ np.linalg.lstsq(explaining, effect, rcond=None)[0]
    return bool(np.linalg.norm(left, axis=0).max() <= seen * np.linalg.norm(effect))


FOUND = 0.9  # share of runs
BESIDE = 1  # tests by the samples, beside those of patterns
_ATTITUDES = 2500  # the error at the worst of them is within 1 % of the largest
_MOST_SIGNED = 8  # columns; of more, each alone
_HARMLESS = 1e-7  # error of |a| over what is added to the outputs, both in g
_WIDTH = 80


@dataclass(frozen=True)
class Undetected:
    """Of one `pattern`: `size` in its unit, and `norm_g`, the largest error of |a| at that size, g; both None where no
    size would have shown. `outputs` (positions, 3): what that size adds to the means of the fit positions."""

    pattern: Pattern
    size: float | None = None
    norm_g: float | None = None
    outputs: Floats | None = None


Reliability = tuple[Undetected, ...]  # the largest error first, None at the end


def reliability(given: Propagation, confidence: float = CONFIDENCE, rounding: float | Floats = 0.0) -> Reliability:
    """Of a run that is solved as `given`, or will be; `confidence` that of the fit, `rounding` as of variance_of_means.
    Raises UsageError."""
    schedule, k, stand, terms = given.schedule, given.k, given.stand, given.terms
    means, variance = ideal_force(schedule) @ k.T, variance_of_means(stand, given.samples, rounding)
    known = None if given.prior is None else (k, np.zeros(3))
    model = WholeModel(schedule, means, variance, stand, terms, known)
    tested = [one for one in model.patterns if one.name not in as_patterns(terms)]
    taken_up = {*DOUBTS, *(pattern for name in declared(stand, schedule) for pattern in SOURCES[name].patterns)}
    false_alarms = (1.0 - confidence) / (len(tested) + BESIDE)
    attitudes = spread_attitudes(_ATTITUDES)  # where |a| counts
    gradient, found = norm_gradient(k, attitudes, terms), []
    for pattern in tested:
        if pattern.name in taken_up:  # the uncertainties contain it
            continue
        variants = pattern.columns(model.scene)
        lasting: list[Columns | None] = [None] * len(variants)
        if pattern.lasts:
            lasting = [*pattern.columns(Scene(model.schedule, k, attitudes))]
        given_gains = model, k, given.gains, gradient
        places = [
            worst_of(*given_gains, pattern, columns, in_use, false_alarms / len(variants))
            for columns, in_use in zip(variants, lasting)
        ]
        found += worst_place(places)
    return in_order(found)


def worst_place(places: Iterable[Undetected | None]) -> list[Undetected]:
    """Of a pattern, by what it is at its places: the one that does most harm; none of none."""
    possible = [one for one in places if one is not None]
    return [max(possible, key=lambda one: np.inf if one.norm_g is None else one.norm_g)] if possible else []


def in_order(found: list[Undetected]) -> Reliability:
    """The largest error first."""
    return tuple(sorted(found, key=lambda one: -1.0 if one.norm_g is None else one.norm_g, reverse=True))


class ResidualModel(Protocol):
    """A model of a run, or of several at once: `whitened` as WholeModel has it."""

    def whitened(self, columns: Columns) -> Floats: ...


def worst_of(
    model: ResidualModel,
    k: Floats,
    gains: Floats,
    gradient: Floats,
    pattern: Pattern,
    columns: Columns,
    in_use: Columns | None,
    false_alarms: float,
) -> Undetected | None:
    """At one place, the size and the signs that leave the largest error, in the whole `model` of a run without errors,
    with the `gains` of its estimator and the `gradient` (attitudes, unknowns) of |a|; None for what neither shows nor
    does any harm. A block that is `in_use` goes on with what lasts. Its columns come one by one, or all alike with any
    signs."""
    count = len(columns)
    signs: list[tuple[int, ...]] = []
    if 1 < count <= _MOST_SIGNED:
        signs = [(1, *others) for others in itertools.product((1, -1), repeat=count - 1)]
    choices = np.concatenate([np.eye(count), np.array(signs, dtype=float).reshape(-1, count)])
    added = np.tensordot(choices, np.array(list(columns.values())), axes=1)
    shown = np.linalg.norm(model.whitened({str(i): one for i, one in enumerate(added)}), axis=0)
    of_norm = added.reshape(len(added), -1) @ gains.T @ gradient.T  # at all attitudes, by a unit of each choice, g
    if in_use is not None:
        of_norm = of_norm - choices @ np.einsum("cai,ai->ca", np.array(list(in_use.values())), gradient[:, 9:12])
    errors = np.abs(of_norm).max(axis=1)
    harmless = _HARMLESS * np.abs(added).max() / np.abs(k).max()
    if ((shown == 0.0) & (errors > harmless)).any():
        return Undetected(pattern)
    rank = basis(model.whitened(columns)).shape[1]
    if rank == 0:
        return None
    sizes = noncentrality(rank, false_alarms, FOUND) ** 0.5 / np.where(shown > 0.0, shown, np.inf)
    most = int((sizes * errors).argmax())
    size = float(sizes[most])
    return Undetected(pattern, size, size * float(errors[most]), size * added[most])


def largest(found: Reliability) -> float | None:
    """Of the errors of |a| that are known, g."""
    return max((one.norm_g for one in found if one.norm_g is not None), default=None)


def description_of(pattern: str) -> str:
    """A pattern by its name; one of a later version by its name alone."""
    return BY_NAME[pattern].description if pattern in BY_NAME else pattern


def amount(size: float, unit: str) -> str:
    """Three digits without an exponent; from 1e4 on in the next larger unit: 9 % instead of 9e+04 ppm."""
    if size >= 1e4 and unit == "ppm":
        size, unit = size * 1e-4, "%"
    elif size >= 1e4 and unit.startswith("u"):
        size, unit = size * 1e-3, f"m{unit[1:]}"
    return f"{np.format_float_positional(float(f'{size:.3g}'), trim='-')} {unit}"


def lines(found: Reliability, limit_g: float | None = None) -> list[str]:
    """For people: what costs most, and whether that is more than the limit, if there is one; what no size shows."""
    said, unseen = [], "; ".join(one.pattern.description for one in found if one.size is None)
    worst = found[0] if found else None
    if worst is not None and worst.size is not None and worst.norm_g is not None:
        beyond = ""
        if limit_g is not None and worst.norm_g > limit_g:
            beyond = ", more than the limit; the verdict assumes that there is none"
        said.append(
            f"{worst.pattern.description.capitalize()} below {amount(worst.size, worst.pattern.unit)} could go"
            f" unnoticed; it would change |a| by up to {amount(1e6 * worst.norm_g, 'ug')}{beyond}"
        )
    if unseen:
        said.append(f"A run like this cannot show, at any size: {unseen}")
    return [line for one in said for line in textwrap.wrap(one, _WIDTH, subsequent_indent="  ")]
