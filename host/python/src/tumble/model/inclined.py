"""The block bolted on once, the stand inclined: coefficients, and the inclinations that nobody measured.

At inclination k, whose true angle is beta_k and whose table angle has its zero at tau_k, channel i puts out

    U_i = U0_i + K_in sin beta_k + cos beta_k (K_ih sin(phi + tau_k) + K_iv cos(phi + tau_k))

The part of the outputs that does not turn with the table lies on a line, and says how far along it each inclination is;
the part that turns says how much of gravity is left across the axis. The square of the one is a parabola over the
other, and its vertex is the level axis. Here by least squares, polynomials and angles; the core has square roots alone.

Arrays may be complex: complex steps through `solve` give its derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import UsageError, listed
from tumble.model.geometry import STEP, Geometry
from tumble.schedule import Mounting, Position, Schedule

FEWEST = 3
_SAME = 1e-9
_ALIKE = 0.01  # of the way between the two inclinations that are farthest apart: nearer ones are one
_NOT_INCLINED = 1e-3  # of what turns with the table: a way that is shorter is none
EQUAL = np.ones(3)


class NotShown(ValueError):
    """The run contradicts its schedule; the text says how."""


@dataclass(frozen=True)
class Inclinations:
    """What a run says of its inclinations, in the order of `numbers`, those of their mountings: `beta` and `tau`
    (inclinations,) or (runs, inclinations), rad; the first tau is 0 by definition."""

    numbers: tuple[int, ...]
    beta: Floats
    tau: Floats


@dataclass(frozen=True)
class Layout:
    """The inclinations of a schedule: `slots`, indices of the fit positions of each; `highest`, `lowest`: places of the
    steepest ones; `matrix` (3, 3) of the bolting."""

    numbers: tuple[int, ...]
    slots: tuple[Integers, ...]
    parts: tuple[Floats, ...]  # by inclination (3, positions): means to their parts by sin phi, cos phi and 1
    highest: int
    lowest: int
    matrix: Floats


@lru_cache(64)
def layout(schedule: Schedule) -> Layout | None:
    """None where `inclined` does not solve it: three or more mountings of one bolting, on both sides of the level,
    whose fit positions divide a turn equally."""
    used = schedule.fitted_mountings
    boltings = {one.bolting for one in used}
    if len(used) < FEWEST or len(boltings) != 1 or None in boltings:
        return None
    matrices = np.array([one.matrix for one in used], dtype=float)
    tilts = np.round([one.tilt_deg - one.off_deg[0] for one in used], 9)  # as they were set: others are told by these
    slots = tuple(
        np.array([i for i in schedule.fit_indices if schedule.positions[i].mounting == one.number]) for one in used
    )
    phi = Geometry(schedule).phi
    designs = [np.stack([np.sin(phi[own]), np.cos(phi[own]), np.ones(len(own))]) for own in slots]
    spreads = [design @ design.T / len(design.T) for design in designs]
    enough = all(len(own) >= FEWEST for own in slots)
    equal = enough and all(np.allclose(spread, np.diag([0.5, 0.5, 1.0]), 0.0, _SAME) for spread in spreads)
    steep = np.abs(tilts).max() < 90.0 and tilts.max() > 0.0 > tilts.min()
    if not equal or not steep or np.abs(matrices - matrices[0]).max() > _SAME:
        return None
    parts = tuple(np.linalg.pinv(design.T) for design in designs)
    numbers = tuple(one.number for one in used)
    return Layout(numbers, slots, parts, int(tilts.argmax()), int(tilts.argmin()), matrices[0])


@dataclass(frozen=True)
class Parabola:
    """What becomes of the outputs as the block is inclined, by inclination, weighed: `along` (..., inclinations), how
    far the part that does not turn with the table has moved since the first; `across` (..., inclinations), the squared
    amplitude of the part that does. It is p + q along + r along^2 (..., 1 each), the largest at the level."""

    along: Floats
    across: Floats
    p: Floats
    q: Floats
    r: Floats

    @property
    def level(self) -> Floats:
        """`along` of a level axis (..., 1)."""
        return -self.q / (2.0 * self.r)

    @property
    def largest(self) -> Floats:
        """`across` of a level axis (..., 1): all of gravity."""
        return self.p - self.q**2 / (4.0 * self.r)


def parabola(schedule: Schedule, means: Floats, weights: Floats = EQUAL) -> Parabola:
    """Of means (..., positions, 3) of all positions, as `solve` takes them. Raises UsageError, NotShown."""
    of = _layout(schedule)
    return _parabola(of, *_parts(of, means), weights)


def solve(schedule: Schedule, means: Floats, weights: Floats = EQUAL) -> tuple[Floats, Floats, Inclinations]:
    """K (..., 3, 3) and U0 (..., 3) from means (..., positions, 3) of all positions, real or complex; K in the frame of
    the table at the first inclination. `weights` of the channels, best in proportion to 1 / noise. Raises UsageError
    for a schedule of another kind, NotShown."""
    of = _layout(schedule)
    s, c, b = _parts(of, means)
    beta = _inclinations(of, _parabola(of, s, c, b, weights))
    x = np.sin(beta)
    line = x - x.mean(axis=-1, keepdims=True)
    k_n = (line[..., None] * b).sum(axis=-2) / (line**2).sum(axis=-1)[..., None]
    u0 = b.mean(axis=-2) - k_n * x.mean(axis=-1)[..., None]
    h, v = s / np.cos(beta)[..., None], c / np.cos(beta)[..., None]
    tau = _turn(h, v, weights)
    sine, cosine = np.sin(tau)[..., None], np.cos(tau)[..., None]
    k_h, k_v = (h * cosine + v * sine).mean(axis=-2), (v * cosine - h * sine).mean(axis=-2)
    k = np.stack([k_h, k_n, k_v], axis=-1) @ of.matrix.T
    return k, u0, Inclinations(of.numbers, beta, tau)


def alike(schedule: Schedule, means: Floats, weights: Floats = EQUAL) -> str | None:
    """Of one run, which inclinations are alike, where no three are left that differ; None where there are three, or the
    schedule is of another kind."""
    of = layout(schedule)
    if of is None:
        return None
    s, c, b = _parts(of, means)
    apart = np.linalg.norm(weights * (b[:, None] - b), axis=-1)
    turning = float(np.sqrt((weights**2 * (s**2 + c**2)).sum(axis=-1).max()))
    near = apart <= max(_ALIKE * float(apart.max()), 0.0 if apart.max() > _NOT_INCLINED * turning else np.inf)
    groups = {tuple(np.flatnonzero(row).tolist()) for row in near}
    if len(groups) >= FEWEST:
        return None
    told = [listed([of.numbers[index] for index in group]) for group in sorted(groups) if len(group) > 1]
    return f"inclinations {', and '.join(told)} are alike"


def supposed(schedule: Schedule, means: Floats) -> tuple[Schedule, Floats]:
    """Of one run that shows no three inclinations, for figures: where they would be if the block's channels were alike
    and the first was inclined as it was set, and the sensitivity (3, 3) of such a block."""
    of = _layout(schedule)
    s, c, b = _parts(of, means)
    scale = float(np.sqrt((s**2 + c**2).sum(axis=-1).max() / 2.0))
    apart = b[of.highest] - b[of.lowest]
    moved = (b - b[0]) @ apart / ((np.linalg.norm(apart) or 1.0) * scale)
    first = next(one.tilt_deg for one in schedule.mountings if one.number == of.numbers[0])
    beta = np.arcsin(np.clip(np.sin(np.deg2rad(first)) + moved, -0.999, 0.999))
    return as_seen(schedule, Inclinations(of.numbers, beta, np.zeros_like(beta))), scale * np.eye(3)


def _layout(schedule: Schedule) -> Layout:
    of = layout(schedule)
    if of is None:
        raise UsageError("inclined: the schedule has no three inclinations of one bolting on both sides of the level")
    return of


def _parts(of: Layout, means: Floats) -> tuple[Floats, Floats, Floats]:
    """Of the outputs by inclination what follows the sine of the table angle, its cosine, and neither: each
    (..., inclinations, 3)."""
    waves = [np.einsum("hp,...pi->...hi", part, means[..., own, :]) for part, own in zip(of.parts, of.slots)]
    s, c, b = np.moveaxis(np.stack(waves, -3), -2, 0)
    return s, c, b


def _parabola(of: Layout, s: Floats, c: Floats, b: Floats, weights: Floats) -> Parabola:
    apart = weights * (b[..., of.highest, :] - b[..., of.lowest, :])
    along = apart / np.sqrt((apart**2).sum(axis=-1))[..., None]
    t = ((weights * (b - b[..., :1, :])) * along[..., None, :]).sum(axis=-1)
    square = ((weights * s) ** 2 + (weights * c) ** 2).sum(axis=-1)
    powers = np.stack([np.ones_like(t), t, t**2], axis=-1)
    turned = np.swapaxes(powers, -1, -2)
    p, q, r = np.moveaxis(np.linalg.solve(turned @ powers, turned @ square[..., None])[..., 0], -1, 0)[..., None]
    found = Parabola(t, square, p, q, r)
    if not ((np.real(r) < 0.0) & (np.real(found.largest) > 0.0)).all():
        raise NotShown("its outputs do not change as those of an inclined axis: inclinations alike?")
    return found


def _inclinations(of: Layout, found: Parabola) -> Floats:
    """beta (..., inclinations)."""
    x = np.sqrt(-found.r / found.largest) * (found.along - found.level)
    if not (np.abs(np.real(x)) < 1.0).all():
        raise NotShown("its outputs change more than gravity can: inclinations alike?")
    if not ((np.real(x[..., of.highest]) > 0.0) & (np.real(x[..., of.lowest]) < 0.0)).all():
        places = np.rad2deg(np.arcsin(np.real(x).reshape(-1, len(of.numbers))[0]))
        seen = ", ".join(f"{number} at {deg:+.1f}" for number, deg in zip(of.numbers, places))
        steepest = listed(sorted(of.numbers[index] for index in (of.highest, of.lowest)))
        raise NotShown(f"inclinations {steepest}, set to either side of the level, lie on one side of it: {seen} deg")
    beta: Floats = np.arcsin(x)
    return beta


def _turn(h: Floats, v: Floats, weights: Floats) -> Floats:
    """tau (..., inclinations): how far each zero of the table angle is from the first one."""
    square = weights**2
    along = (square * (h * h[..., :1, :] + v * v[..., :1, :])).sum(axis=-1)
    across = (square * (v * h[..., :1, :] - h * v[..., :1, :])).sum(axis=-1)
    tau: Floats = np.arctan(across / along)
    return tau + np.where(np.real(along) < 0.0, np.pi, 0.0)


def as_seen(schedule: Schedule, found: Inclinations) -> Schedule:
    """The schedule that the run was made on: with its inclinations, and table angles from their own zeros."""
    seen = {number: one for number, *one in zip(found.numbers, *np.rad2deg([found.beta, found.tau]).tolist())}

    def inclined(one: Mounting) -> Mounting:
        tilt, turn = seen.get(one.number, (one.tilt_deg, 0.0))
        return replace(one, tilt_deg=tilt, off_deg=(one.off_deg[0] + tilt - one.tilt_deg, one.off_deg[1] + turn))

    def turned(one: Position) -> Position:
        return replace(one, angle_deg=one.angle_deg + seen.get(one.mounting, (0.0, 0.0))[1])

    return Schedule(tuple(map(inclined, schedule.mountings)), tuple(map(turned, schedule.positions)))


def as_set(schedule: Schedule) -> Schedule:
    """The same, as if the stand had been set to these inclinations: runs that are drawn about them are off from
    here."""
    return replace(schedule, mountings=tuple(replace(one, off_deg=(0.0, 0.0)) for one in schedule.mountings))


@lru_cache(64)
def _derivatives(schedule: Schedule, k: bytes, weights: bytes) -> tuple[Floats, Floats]:
    means, fit = Geometry(schedule).outputs(np.frombuffer(k).reshape(3, 3), np.zeros(3)), schedule.fit_indices
    stepped = np.tile(means.astype(complex), (3 * len(fit), 1, 1))
    for row, (position, channel) in enumerate((position, channel) for position in fit for channel in range(3)):
        stepped[row, position, channel] += 1j * STEP
    by_k, by_u0, found = solve(schedule, stepped, np.frombuffer(weights))
    coefficients = np.concatenate([by_k.reshape(len(stepped), 9), by_u0], axis=1)
    inclinations = np.concatenate([found.beta, found.tau], axis=1)
    return np.imag(coefficients).T / STEP, np.imag(inclinations).T / STEP


def gains(schedule: Schedule, k: Floats, weights: Floats = EQUAL) -> Floats:
    """Derivatives (12, 3 x fit positions) of K row by row and U0 by the means, the channel running fastest, for a block
    of sensitivity `k` at the inclinations of the schedule. By complex steps."""
    return _derivatives(schedule, *(np.ascontiguousarray(one, dtype=float).tobytes() for one in (k, weights)))[0]


def gains_of_inclinations(schedule: Schedule, k: Floats, weights: Floats = EQUAL) -> Floats:
    """The same of what a run says of its inclinations: of every beta, then of every tau."""
    return _derivatives(schedule, *(np.ascontiguousarray(one, dtype=float).tobytes() for one in (k, weights)))[1]
