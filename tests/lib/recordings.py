"""Recordings as a logger makes them of a block on a stand: rests, turning, settling, mounting by hand, its own clock.

The truth comes along: which rows are at rest at which position. Nothing here is taken from tumble.importing.
"""

import itertools
from dataclasses import dataclass, replace

import numpy as np

from tumble.model import Geometry
from tumble.schedule import Schedule


@dataclass
class Recorded:
    """`outputs` (rows, 3), `time_s` (rows,), `truth` (rows,): index of the position in the schedule, -1 elsewhere;
    `k`, `u0`: the block; `forces` (positions, 3): what it really felt; `noise`: of a sample, `step`: of the converter,
    both in g."""

    outputs: np.ndarray
    time_s: np.ndarray
    truth: np.ndarray
    k: np.ndarray
    u0: np.ndarray
    forces: np.ndarray
    noise: float
    step: float

    def csv(self, header="time,Ax,Ay,Az", digits=7):
        """As a file's text."""
        scale = np.abs(self.outputs).max()
        places = max(0, int(digits - np.floor(np.log10(scale))))
        row = f"%.6f,%.{places}f,%.{places}f,%.{places}f\n"
        return header + "\n" + "".join(row % values for values in zip(self.time_s.tolist(), *self.outputs.T.tolist()))


@dataclass
class Habits:
    """How the person and the logger work. Angles in rad, times in s."""

    rate_hz: float = 200.0
    rest_s: tuple = (2.0, 6.0)
    noise_g: float = 1e-3
    angle: float = 1e-4
    seat: float = 1e-3
    settling_s: float = 0.4
    bench: float = 0.5  # chance that the block lies on the bench for a while when it is mounted anew
    pause: float = 0.1  # chance of a pause half way between two positions
    gap: float = 0.3  # chance of lost samples, a stretch of them
    offset_s: float = 0.0
    jitter: float = 0.0  # of a time stamp, part of the interval
    step: float = 0.0  # of the converter, part of K


def recording(schedule, visits, k, u0, habits, rng):
    """A recording of `schedule` whose positions are visited in the order `visits` (indices)."""
    mountings = [one.number for one in schedule.mountings]
    forces = Geometry(schedule).force(
        alpha1=rng.normal(0, habits.angle),
        alpha2=rng.normal(0, habits.angle),
        alpha3=rng.normal(0, habits.seat, len(mountings)),
        delta=rng.normal(0, habits.angle, len(schedule.positions)),
        seat_h=rng.normal(0, habits.seat, len(mountings)),
        seat_n=rng.normal(0, habits.seat, len(mountings)),
    )
    path = _Path(habits, rng)
    path.by_hand(_unit(rng), forces[visits[0]])
    for now, after in zip(visits, [*visits[1:], None]):
        path.rest(forces[now], rng.uniform(*habits.rest_s), now)
        if after is None:
            path.by_hand(forces[now], _unit(rng))
        elif schedule.positions[now].mounting != schedule.positions[after].mounting:
            places = (mountings.index(schedule.positions[one].mounting) for one in (now, after))
            boltings = {schedule.mountings[place].bolting for place in places}
            move = path.by_hand if len(boltings) > 1 or None in boltings else path.incline
            move(forces[now], forces[after])
        else:
            path.turn(schedule, now, after, forces)
    felt, truth = np.concatenate(path.felt), np.concatenate(path.truth)
    _widen(felt, truth, forces, habits.noise_g)
    outputs = felt @ k.T + u0 + rng.normal(0, habits.noise_g, felt.shape) * np.abs(np.diag(k))
    if habits.step:
        step = habits.step * np.abs(np.diag(k))
        outputs = np.round(outputs / step) * step
    time_s = (
        habits.offset_s + (np.arange(len(felt)) + habits.jitter * rng.uniform(-0.5, 0.5, len(felt))) / habits.rate_hz
    )
    kept = np.ones(len(felt), dtype=bool)
    while rng.random() < habits.gap:
        begin = int(rng.integers(0, len(felt)))
        kept[begin : begin + int(rng.uniform(0.1, 3.0) * habits.rate_hz)] = False
    return Recorded(outputs[kept], time_s[kept], truth[kept], k, u0, forces, habits.noise_g, habits.step)


def _widen(felt, truth, forces, noise_g):
    """Rows before and after a rest that differ from it by less than the noise of a sample are at rest as well."""
    edges = np.flatnonzero(np.diff(np.concatenate([[-1], truth, [-1]])))
    for edge, step in [(edge, step) for edge in edges for step in (-1, 1)]:
        row = edge if step > 0 else edge - 1
        beside = row - step
        if not (0 <= row < len(truth) and 0 <= beside < len(truth)) or truth[beside] == -1 or truth[row] != -1:
            continue
        position = truth[beside]
        while 0 <= row < len(truth) and truth[row] == -1 and np.linalg.norm(felt[row] - forces[position]) < noise_g:
            truth[row] = position
            row += step


class _Path:
    """What the block feels, sample by sample, and at which position it is at rest."""

    def __init__(self, habits, rng):
        self.habits, self.rng, self.felt, self.truth = habits, rng, [], []

    def add(self, felt, position=-1):
        self.felt.append(felt)
        self.truth.append(np.full(len(felt), position))

    def count(self, seconds):
        return max(int(seconds * self.habits.rate_hz), 1)

    def rest(self, force, seconds, position):
        """At rest, after settling: a rocking that dies away."""
        rows = self.count(self.habits.settling_s)
        t = np.arange(rows) / self.habits.rate_hz
        across = np.cross(force, _unit(self.rng))
        rocking = 0.02 * np.exp(-8 * t / self.habits.settling_s) * np.cos(2 * np.pi * 7 * t)
        self.add(force + rocking[:, None] * across)
        self.add(np.tile(force, (self.count(seconds), 1)), position)

    def turn(self, schedule, now, after, forces):
        """The table turns, smoothly, from one angle to the next; now and then it is stopped on the way."""
        first, last = (schedule.positions[one].angle_deg for one in (now, after))
        stops = [first, last]
        if self.rng.random() < self.habits.pause:
            stops.insert(1, first + (last - first) * self.rng.uniform(0.35, 0.65))
        for begin, end in itertools.pairwise(stops):
            rows = self.count(max(abs(end - begin) / 45.0, 0.5))
            phase = np.linspace(0, 1, rows)
            angles = begin + (end - begin) * (phase - np.sin(2 * np.pi * phase) / (2 * np.pi))
            felt = _at(schedule, schedule.positions[now].mounting, angles)
            ends = (angles - first) / (last - first or 1.0)
            felt += (1 - ends)[:, None] * (forces[now] - _at(schedule, schedule.positions[now].mounting, [first])[0])
            felt += ends[:, None] * (forces[after] - _at(schedule, schedule.positions[now].mounting, [last])[0])
            self.add(felt)
            if end != last:
                self.add(np.tile(felt[-1], (self.count(self.rng.uniform(1, 3)), 1)))

    def incline(self, begin, end):
        """The frame is tilted while the table is turned back, not quite steadily; the block stays on the table."""
        rows = self.count(self.rng.uniform(3.0, 8.0))
        phase = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, rows))
        by_way_of = _unit(self.rng) * np.sin(np.pi * phase)[:, None]  # begin and end may be the same
        felt = begin + phase[:, None] * (end - begin) + 0.5 * by_way_of
        felt /= np.linalg.norm(felt, axis=1, keepdims=True)
        smooth = np.sin(np.linspace(0, np.pi, rows))[:, None]
        self.add(felt + 0.01 * smooth * self.rng.normal(0, 1, (rows, 3)))

    def by_hand(self, begin, end):
        """Carried about, unsteadily, by way of anywhere; sometimes laid down."""
        stops = [begin, *(_unit(self.rng) for _ in range(self.rng.integers(1, 4)))]
        if self.rng.random() < self.habits.bench:
            face = np.zeros(3)
            face[self.rng.integers(0, 3)] = self.rng.choice([-1, 1])
            tilt = np.cross(face, _unit(self.rng))
            lies = face + tilt * self.rng.uniform(0.01, 0.08)
            stops.append(lies / np.linalg.norm(lies))
        stops.append(end)
        for place, (one, other) in enumerate(itertools.pairwise(stops)):
            rows = self.count(self.rng.uniform(1.0, 3.0))
            phase = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, rows))
            felt = one + phase[:, None] * (other - one)
            felt /= np.linalg.norm(felt, axis=1, keepdims=True) + 1e-3
            tremor = np.cumsum(self.rng.normal(0, 1, (rows, 3)), axis=0)
            smooth = np.sin(np.linspace(0, np.pi, rows))[:, None]
            self.add(felt + 0.03 * smooth * (np.sin(0.3 * tremor) + self.rng.normal(0, 1, (rows, 3))))
            if place == len(stops) - 3 and len(stops) > 3 and self.rng.random() < 0.7:
                self.add(np.tile(other, (self.count(self.rng.uniform(1, 4)), 1)))


def inclined_anew(schedule, off, zero, bolting, rng):
    """The schedule as a stand has it that nobody measured: each inclination off by up to `off`, its zero of the table
    angle by up to `zero`, and the block turned on the table by up to `bolting` about each axis; rad."""
    tilts = {one.number: one.tilt_deg + np.rad2deg(rng.uniform(-off, off)) for one in schedule.mountings}
    zeros = {one.number: np.rad2deg(rng.uniform(-zero, zero)) for one in schedule.mountings}
    x, y, z = rng.uniform(-bolting, bolting, 3)
    turned = np.eye(3) + np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    left, _, right = np.linalg.svd(turned)
    bolted = left @ right  # the nearest rotation
    return Schedule(
        tuple(
            replace(one, tilt_deg=float(tilts[one.number]), matrix=tuple(map(tuple, np.array(one.matrix) @ bolted)))
            for one in schedule.mountings
        ),
        tuple(replace(one, angle_deg=float(one.angle_deg + zeros[one.mounting])) for one in schedule.positions),
    )


def _at(schedule, mounting, angles):
    mounted = next(one for one in schedule.mountings if one.number == mounting)
    phi, tilt = np.deg2rad(angles), np.deg2rad(mounted.tilt_deg)
    felt = [np.cos(tilt) * np.sin(phi), np.sin(tilt) + 0 * phi, np.cos(tilt) * np.cos(phi)]
    return np.stack(felt, axis=1) @ np.array(mounted.matrix).T


def _unit(rng):
    vector = rng.normal(size=3)
    return vector / np.linalg.norm(vector)


ORDERS = ("schedule", "reversed", "exchanged", "shuffled")


@dataclass
class Case:
    """A random recording, and what its user says: `order`, and `signs` or None."""

    recorded: Recorded
    kind: str
    order: str
    signs: tuple | None
    true_signs: tuple


def random_case(schedule, seed):
    """Any block, noise, rate, order, pace and accident; half of the blocks have channels that are upside down."""
    rng = np.random.default_rng(seed)
    rate = float(rng.choice([20, 50, 100, 200]))
    habits = Habits(
        rate_hz=rate,
        noise_g=10 ** rng.uniform(-5, -2),
        angle=10 ** rng.uniform(-5, -3),
        seat=10 ** rng.uniform(-5, -2.5),
        rest_s=(2.0, rng.uniform(3, 30 if rate <= 100 else 10)),
        offset_s=rng.choice([0.0, rng.uniform(0, 1e3), 1.7e9]),
        jitter=rng.choice([0.0, 0.3]),
        step=rng.choice([0.0, 10 ** rng.uniform(-5, -2.5)]),
    )
    signs = rng.choice([-1, 1], 3) if rng.random() < 0.5 else np.ones(3, dtype=int)
    scale = 10 ** rng.uniform(-3, 4)
    k = scale * (np.diag(signs * rng.uniform(0.7, 1.3, 3)) + rng.uniform(-0.05, 0.05, (3, 3)))
    kind = str(rng.choice(ORDERS, p=[0.4, 0.2, 0.2, 0.2]))
    visits = _visits(schedule, kind, rng)
    order = "schedule" if kind == "schedule" or rng.random() < 0.3 else "any"
    told = tuple(int(sign) for sign in signs) if rng.random() < 0.7 else None
    stand = schedule
    if schedule.mountings[0].bolting is not None:
        stand = inclined_anew(schedule, np.deg2rad(5.0), np.deg2rad(2.0), np.deg2rad(2.0), rng)
        habits = replace(habits, seat=0.0)  # that would be of a mounting
    recorded = recording(stand, visits, k, rng.uniform(-3, 3, 3) * scale, habits, rng)
    return Case(recorded, kind, order, told, tuple(int(sign) for sign in signs))


def _visits(schedule, kind, rng):
    places = range(len(schedule.positions))
    if kind == "reversed":
        return list(places)[::-1]
    blocks = [[p for p in places if schedule.positions[p].mounting == m.number] for m in schedule.mountings]
    if kind == "shuffled":
        blocks = [[int(p) for p in rng.permutation(block)] for block in blocks]
    if kind == "exchanged" or (kind == "shuffled" and rng.random() < 0.5):
        blocks.reverse()
    return sum(blocks, [])
