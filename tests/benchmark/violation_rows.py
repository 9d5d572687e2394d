"""What real stands and blocks do that the model leaves out: simulated runs, thousands at a time, a row a violation.

A row knows nothing of the patterns that the product looks for, but the names that rightly explain it. Sizes that may
have either sign are drawn with either, channel by channel.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.model import Geometry
from tumble.model.optimal import mean_sigma, shared_errors

K = np.full((3, 3), 0.04) + 1.96 * np.eye(3)  # the nominal block: 2 V/g, every misalignment +0.02
U0 = np.array([0.01, -0.02, 0.03])
MICRO = 1e-6


@dataclass
class World:
    """So many `runs` on a stand: `errors` as Geometry takes them, all drawn; `noise` (runs, positions, 3) of the means;
    the positions' `time` from 0 to 1 and table angle `phi`."""

    schedule: object
    stand: object
    runs: int
    rng: np.random.Generator

    def __post_init__(self):
        self.geometry = Geometry(self.schedule)
        self.mountings, self.positions = len(self.schedule.mountings), len(self.schedule.positions)
        self.time = np.linspace(0.0, 1.0, self.positions)
        self.phi = np.deg2rad([position.angle_deg for position in self.schedule.positions])
        found = shared_errors(self.schedule, K, self.stand)
        sigma = np.concatenate([source.sigma for source in found.values()])
        shared = self.rng.standard_normal((self.runs, len(sigma))) * sigma
        level = 2 + len(found["alpha3"].sigma)
        tilt, zero, yaws, _ = np.split(shared, [1, 2, level], axis=1)
        angles = self.rng.standard_normal((self.runs, self.positions)) * self.stand.sigma("angle")
        seats = {name: np.zeros((self.runs, self.mountings)) for name in ("seat_h", "seat_n")}
        self.errors = {"alpha1": tilt, "alpha2": zero, "alpha3": yaws, "delta": angles, **seats}
        sigma_mean = mean_sigma(K, self.stand, 0.0, self.stand.samples)[0]
        self.noise = sigma_mean * self.rng.standard_normal((self.runs, self.positions, 3))

    @property
    def signs(self):
        """+1 or -1 for every run and channel: (runs, 1, 3)."""
        return self.rng.choice([-1.0, 1.0], (self.runs, 1, 3))

    @property
    def sign(self):
        """+1 or -1 for every run: (runs, 1)."""
        return self.rng.choice([-1.0, 1.0], (self.runs, 1))

    @property
    def places(self):
        """From a place within the run on, another for each: (runs, positions)."""
        return np.arange(self.positions) >= self.rng.integers(1, self.positions, (self.runs, 1))

    def force(self, **more):
        """Specific force with the errors drawn and `more`: (runs, positions, 3)."""
        return self.geometry.force(**{name: error + more.get(name, 0.0) for name, error in self.errors.items()})

    def means(self, force, added=0.0):
        """Mean outputs; `added` (runs, positions, 3) to the force that a channel shows, g."""
        return force @ K.T + U0 + np.diag(K) * added + self.noise


def honest(world):
    """Nothing that the stand does not declare."""
    return world.means(world.force())


def added(shape):
    """Of `shape` (world, force), g, which every channel has for itself with either sign."""

    def means(world):
        force = world.force()
        return world.means(force, world.signs * shape(world, force))

    return means


def cross_coupling(size):
    """Each channel feels the products of its own axis with the other two."""

    def means(world):
        force = world.force()
        products = [np.roll(force, turn, axis=2) * force * world.signs for turn in (1, 2)]
        return world.means(force, size * (products[0] + products[1]))

    return means


def angles(error):
    """Of `error` (world), errors of the geometry by name."""
    return lambda world: world.means(world.force(**error(world)))


def _remembered(world, _):
    """The sign that the sine of the table angle had last."""
    turned = np.round(np.rad2deg(world.phi), 6)
    return np.where((turned <= 180.0) | (turned == 360.0), 1.0, -1.0)[:, None]


def _seats(size):
    return lambda world: {
        name: size * world.rng.standard_normal((world.runs, world.mountings)) for name in ("seat_h", "seat_n")
    }


def moved(size):
    """The block moves on the platform within the run, about any axis, and stays so until it is mounted anew."""

    def means(world):
        axis = world.rng.standard_normal((world.runs, 3))
        turn = size * axis / np.linalg.norm(axis, axis=1, keepdims=True)
        place = world.rng.integers(1, world.positions, (world.runs, 1))
        mounting = world.geometry.mounting_index
        after = (np.arange(world.positions) >= place) & (mounting == mounting[place])
        names = ("alpha3", "seat_h", "seat_n")
        displaced = world.force(**{name: turn[:, [i]] for i, name in enumerate(names)})
        return world.means(np.where(after[..., None], displaced, world.force()))

    return means


def exchanged(first, second):
    """Two channels."""

    def means(world):
        order = [{first: second, second: first}.get(channel, channel) for channel in range(3)]
        return honest(world)[..., order]

    return means


def remounted(world):
    """Mounting 2 measured in place of mounting 1, and 1 in place of 2."""
    mounting = world.geometry.mounting_index
    order = np.concatenate([np.flatnonzero(mounting == m) for m in (1, 0, *range(2, world.mountings))])
    return honest(world)[:, order]


def exchanged_within(world):
    """Channels y and z, from a place within the run on."""
    means = honest(world)
    return np.where(world.places[..., None], means[..., [0, 2, 1]], means)


def autoregressive(rho):
    """AR(1), anew in every position."""

    def noise(rng, shape):
        x = rng.standard_normal(shape)
        for t in range(1, shape[2]):
            x[:, :, t] = rho * x[:, :, t - 1] + math.sqrt(1 - rho**2) * x[:, :, t]
        return x

    return noise


def flicker(rng, shape):
    """1/f through all positions of a run, with the scatter within a position that is declared."""
    runs, positions, samples, channels = shape
    length = positions * samples
    frequency = np.fft.rfftfreq(2 * length)
    frequency[0] = np.inf
    white = np.fft.rfft(rng.standard_normal((runs, channels, 2 * length)))
    x = np.fft.irfft(white / np.sqrt(frequency), 2 * length)[..., :length].reshape(runs, channels, positions, samples)
    return np.moveaxis(x / np.sqrt(x.var(axis=3, ddof=1).mean()), 1, 3)


def white(rng, shape):
    """As declared."""
    return rng.standard_normal(shape)


@dataclass(frozen=True)
class Row:
    """`causes`: names of patterns that explain it rightly; `means` (world) of a run. Of samples: `noise` (rng, shape)
    of unit variance along the last axis but one, rounded to `step` in units of the declared noise, which the stand
    file `declares` or not."""

    name: str
    causes: tuple[str, ...]
    means: Callable = honest
    noise: Callable | None = None
    step: float = 0.0
    declares: bool = False


def _sizes(words, sizes, cause, shape):
    """The same shape in several sizes, millionths of a g or of a rad."""
    return [Row(f"{words} {size:g}", cause, added(lambda w, a, s=size: s * MICRO * shape(w, a))) for size in sizes]


def _turns(words, size, cause, error):
    return Row(f"{words} {size:g}", cause, angles(lambda w: {"delta": size * MICRO * error(w)}))


def rows():
    """Sizes in ug, ug/g, ug/g^2, ug/g^3 or urad."""
    return [
        Row("nothing", (), honest),
        *_sizes("drift", (20, 100, 500), ("drift",), lambda w, a: w.time[:, None]),
        *_sizes("warm-up", (100, 500), ("drift_exp",), lambda w, a: np.exp(-w.time / 0.15)[:, None]),
        *_sizes("step", (100,), ("step",), lambda w, a: w.places[..., None]),
        *_sizes("scale drift", (100,), ("scale_drift",), lambda w, a: w.time[:, None] * a),
        *_sizes("K2", (10, 30, 100, 300), ("k2",), lambda w, a: a**2),
        *_sizes("K3", (100, 300), ("k3",), lambda w, a: a**3),
        *_sizes("asymmetry", (100,), ("asymmetry",), lambda w, a: np.abs(a)),
        Row("cross-coupling 100", ("cross_coupling",), cross_coupling(100 * MICRO)),
        *_sizes("hysteresis", (50,), ("hysteresis",), _remembered),
        _turns("once per turn", 100, ("once_per_turn",), lambda w: w.sign * np.sin(w.phi + _phase(w))),
        _turns("once per turn", 500, ("once_per_turn",), lambda w: w.sign * np.sin(w.phi + _phase(w))),
        _turns("twice per turn", 100, ("twice_per_turn",), lambda w: np.sin(2 * w.phi + _phase(w))),
        _turns("twice per turn", 500, ("twice_per_turn",), lambda w: np.sin(2 * w.phi + _phase(w))),
        _turns("stepper, a move", 20, ("lost_steps",), lambda w: w.sign * np.arange(w.positions)),
        _turns("stepper, a move", 100, ("lost_steps",), lambda w: w.sign * np.arange(w.positions)),
        *(
            Row(f"platform {size:g}", ("seat",), angles(lambda w, s=size: {"seat_h": s * MICRO * w.sign}))
            for size in (100, 300, 1000, 2000)
        ),
        *(Row(f"seats {size:g}", ("seat",), angles(_seats(size * MICRO))) for size in (100, 300, 1000)),
        *(Row(f"slip {size:g}", ("slip",), moved(size * MICRO)) for size in (200, 1000)),
        Row("noise AR(1) 0.5", ("correlated_noise",), noise=autoregressive(0.5)),
        Row("noise AR(1) 0.9", ("correlated_noise",), noise=autoregressive(0.9)),
        Row("noise 1/f", ("correlated_noise",), noise=flicker),
        Row("undithered, declared", ("undithered",), noise=white, step=5.0, declares=True),
        Row("undithered, not declared", ("undithered",), noise=white, step=5.0),
        Row("channels y, z exchanged", (), exchanged(1, 2)),
        Row("mountings 1, 2 exchanged", (), remounted),
        Row("y, z exchanged within the run", (), exchanged_within),
    ]


def _phase(world):
    return 2 * math.pi * world.rng.random((world.runs, 1))
