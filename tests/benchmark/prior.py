"""Measure `tumble solve --prior` on simulated blocks: u(|a|), coverage, changes that are noticed, false alarms.

    tools/benchmark prior [--stand NAME]... [--runs N] [--changed N] [--growth SCALE,ANGLE,BIAS] [--table]

Of every block a calibration is simulated with the paper's schedule on the exact geometry and solved by `optimal`; in
the year after it the block changes as --growth says, in ppm, urad and ug a year; then a run is simulated, of one
mounting or of both, and solved with the calibration as its prior. A changed block has changed besides in one parameter,
by so many standard uncertainties of the difference of run and prior in it.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from tumble.files.stand_file import read_stand
from tumble.history.due import sensitive_axes
from tumble.model.coefficients import norm_gradient, worst_norm
from tumble.model.errors import exact_outputs
from tumble.model.geometry import built_in, ideal_force
from tumble.model.optimal import optimal_estimate
from tumble.model.prior import PARAMETERS, Given, Growth, Prior, by_parameters, estimate_with_prior, parameters
from tumble.model.propagation import Propagation

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
PAPER, POSITIONS = built_in("paper"), {"one mounting": 9, "both": 18}
SIZES = (1.0, 2.0, 3.0, 4.0, 6.0)
CONFIDENCE, NORMAL_95 = 0.999, 1.959963984540054
DAYS = 365.25


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--stand", action="append", choices=("paper", "angle", "lab"), help="default: all three")
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--changed", type=int, default=1000, help="changed blocks of each size")
    parser.add_argument("--growth", default="50,20,50")
    parser.add_argument("--table", action="store_true", help="as Markdown")
    options = parser.parse_args(arguments)
    growth = Growth.declared(*(float(one) * 1e-6 for one in options.growth.split(",")))
    if options.table:
        print("| stand, run | what | |\n|---|---|---|")
    for stand in options.stand or ["paper", "angle", "lab"]:
        for kind in POSITIONS:
            for name, value in measured(stand, kind, growth, options.runs, options.changed).items():
                print(
                    f"| `{stand}`, {kind} | {name} | {value} |"
                    if options.table
                    else f"{stand:6} {kind:13} {name:44} {value}"
                )
    return 0


def block(values, turn, hand=1.0):
    """K and U0 with these parameters, turned so."""
    scale = np.exp(values[:3])
    k = hand * scale[:, None] * sensitive_axes(values[None, 3:6])[0] @ turn
    return k, values[6:] * scale


def turn_of(k):
    """By which the axes of a block are turned from those of sensitive_axes."""
    scale = np.linalg.norm(k, axis=1)
    return np.linalg.solve(sensitive_axes(parameters(k, np.zeros(3))[None, 3:6])[0], k / scale[:, None])


class Blocks:
    """Blocks of an example stand, one after the other."""

    def __init__(self, stand, kind, growth, seed=39):
        told = read_stand(str(EXAMPLES / f"{stand}_stand.toml"))
        self.stand, self.k, self.u0 = told.stand, np.array(told.truth["K"]), np.array(told.truth["U0"])
        self.values, self.turn = parameters(self.k, self.u0), turn_of(self.k)
        self.samples = np.full(18, self.stand.samples)
        self.part = PAPER.part(np.arange(18) < POSITIONS[kind])
        self.growth = growth.after(DAYS)
        self.rng = np.random.default_rng(seed)
        self.first = Propagation(PAPER, self.k, self.stand, self.samples, "optimal")

    @property
    def given(self):
        return Given(self.part, self.stand, self.samples[: len(self.part.positions)])

    def outputs(self, schedule, k, u0):
        count = len(schedule.positions)
        found = Propagation(schedule, k, self.stand, self.samples[:count], "optimal").errors()
        draws = self.rng.standard_normal((1, sum(len(one.sigma) for one in found.values())))
        return exact_outputs(schedule, k, u0, found, draws)[0]

    def prior(self, values):
        """By a simulated calibration of a block with these parameters."""
        k, u0 = block(values, self.turn)
        found = optimal_estimate(PAPER, self.outputs(PAPER, k, u0), self.stand, self.samples)
        return self.prior_of(found.k, found.u0, found.covariance)

    def prior_of(self, k, u0, covariance):
        by = by_parameters(k, u0)
        own = by @ covariance @ by.T + np.diag(self.growth**2)
        return Prior(parameters(k, u0), own, k, u0, "", "", DAYS, self.growth, np.zeros(9), "declared")

    def expected(self):
        """Of the block as its stand file has it: the prior, and the covariance with it."""
        prior = self.prior_of(self.k, self.u0, self.first.covariance())
        return prior, self.given.covariance(self.k, self.u0, prior, None)

    def joint_u(self):
        """Standard uncertainties (9,) of a change, if that alone has happened."""
        prior, _ = self.expected()
        test = estimate_with_prior(self.given, self.part_means(), prior).test
        return test.u_change

    def part_means(self):
        return ideal_force(self.part) @ self.k.T + self.u0

    def solved(self, change=0.0):
        """An estimate, and the truth (12,)."""
        prior = self.prior(self.values)
        now = self.values + self.growth * self.rng.standard_normal(9) + change
        k, u0 = block(now, self.turn)
        return estimate_with_prior(self.given, self.outputs(self.part, k, u0), prior), np.concatenate([k.ravel(), u0])


def measured(stand, kind, growth, runs, changed):
    """Figures by name, as text."""
    blocks = Blocks(stand, kind, growth)
    prior, covariance = blocks.expected()
    alone = (
        "unknown" if kind == "one mounting" else f"{worst_norm(blocks.k, blocks.first.covariance()).worst_g * 1e6:.1f}"
    )
    told = {
        "worst u(|a|), ug: prior, run alone, both": f"{prior.worst_norm.worst_g * 1e6:.1f}, {alone},"
        f" {worst_norm(blocks.k, covariance).worst_g * 1e6:.1f}"
    }
    told |= coverage(blocks, runs)
    for size in SIZES if changed else ():
        told[f"changed by {size:g} u: noticed, named first"] = noticed(blocks, size, changed)
    return told


def coverage(blocks, runs):
    """Of k = 1.96: least and largest of the nine parameters, of the twelve coefficients, of |a| where it is least
    certain; and false alarms."""
    attitude = worst_norm(blocks.k, blocks.expected()[1]).attitude
    inside, alarms = [], 0
    for _ in range(runs):
        found, truth = blocks.solved()
        off = np.concatenate([found.k.ravel(), found.u0]) - truth
        by = by_parameters(found.k, found.u0)
        of_parameters = parameters(found.k, found.u0) - parameters(truth[:9].reshape(3, 3), truth[9:])
        gradient = norm_gradient(found.k, attitude)
        z = np.concatenate([
            of_parameters / np.sqrt(np.diag(by @ found.covariance @ by.T)),
            off / np.sqrt(np.diag(found.covariance)),
            [gradient @ off / np.sqrt(gradient @ found.covariance @ gradient)],
        ])  # fmt: skip
        inside.append(np.abs(z) < NORMAL_95)
        alarms += found.test.p < 1.0 - CONFIDENCE
    share = 100.0 * np.mean(inside, axis=0)
    spans = [f"{one.mean():.1f} ({one.min():.1f} to {one.max():.1f})" for one in (share[:9], share[9:21])]
    return {
        "parameters within 1.96 u, %": spans[0],
        "coefficients within 1.96 u, %": spans[1],
        "worst |a| within 1.96 u, %": f"{share[21]:.1f}",
        "false alarms": f"{alarms} of {runs}",
    }


def noticed(blocks, size, count):
    """Share of changes of one parameter, in turn each that the run shows, that are noticed and named first."""
    found_ones = named = 0
    u = blocks.joint_u()
    shown = np.flatnonzero(np.isfinite(u))
    for number in range(count):
        place = shown[number % len(shown)]
        change = np.zeros(9)
        change[place] = size * u[place] * blocks.rng.choice([-1.0, 1.0])
        test = blocks.solved(change)[0].test
        alarm = test.p < 1.0 - CONFIDENCE
        found_ones += alarm
        named += alarm and bool(test.changes) and test.changes[0].parameter == PARAMETERS[place]
    return f"{100.0 * found_ones / count:.1f} %, {100.0 * named / count:.1f} %"


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
