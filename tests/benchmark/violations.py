"""What happens when a stand or a block does what the model leaves out: does `solve` tell, and of what?

    tools/benchmark violations [--runs N] [--stand NAME] [--schedule NAME] [ROW...]

Prints a table for every example stand; a row is a violation. For every built-in schedule, in per cent: how often the
stated uncertainties (k = 2) hold the true coefficients, mean and worst of the twelve, with `refined` (`inclined` on the
schedule of that name) and with `optimal`; runs that do not fit or are refused, by the product's own chi-squared; these
and runs with a warning of what they show; of them, those whose first explanation is right; runs that the best test
there can be would find, which knows the violation to the last digit and has 0.1 % of false alarms. Of samples a quarter
of the runs. Needs the package to be importable, as in the tests. """

import argparse
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))
from core_chi_squared import chi_squared
from violation_causes import Causes
from violation_noise import NoisyRuns
from violation_rows import U0, K, World, honest, rows

from tumble import core
from tumble.distributions import chi_squared_quantile
from tumble.errors import BadInput, Disagreement
from tumble.files.run_file import Run
from tumble.files.stand_file import read_stand
from tumble.model.fit import CONFIDENCE, WholeModel, variance_of_means
from tumble.model.propagation import Propagation
from tumble.solving.computation import LARGEST_MISFIT, estimator_for
from tumble.solving.plausibility import examine
from tumble.solving.solution import solve
from tumble.solving.uncertainty import standard_uncertainties

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STANDS = ("paper", "angle", "lab")
SCHEDULES = ("paper", "three_mountings", "diagonal", "inclined")
TRUTH = np.concatenate([K.ravel(), U0])
SEED = 1
FAR = 0.5  # V/g
EXAMINED = 5
CONFIRMED = 200
FEWER = 4  # times fewer runs of samples than of means
LEAST = 0.02  # of runs that are told, before it is said how many are rightly explained


@dataclass(frozen=True)
class Cell:
    """Shares of runs: `coverage` (estimators, 12) of k = 2; `failed`: no PASS; `told`: that, or a warning that names a
    pattern; `explained`: of those, rightly; `best`: that any test can find."""

    coverage: np.ndarray
    failed: float
    told: float
    explained: float
    best: float


class Case:
    """A stand file and a schedule."""

    def __init__(self, stand, schedule):
        self.file = read_stand(str(EXAMPLES / f"{stand}_stand.toml"))
        self.stand = self.file.stand
        self.schedule = core.CoreSchedule(core.built_in(schedule).fitted)
        positions = len(self.schedule)
        self.measured, self.samples = np.ones(positions, dtype=bool), np.full(positions, self.stand.samples)
        self.variance = variance_of_means(self.stand, self.samples, 0.0)
        self.causes = Causes(self.schedule.data, self.stand, K, U0)
        self.white = self.stand.sigma("noise") ** 2 / self.stand.samples
        self.limit = chi_squared_quantile(CONFIDENCE, self.causes.freedom)
        self.closed_form = "inclined" if self.schedule.data.is_inclined else "refined"
        names = (self.closed_form, "optimal")
        given = [Propagation(self.schedule.data, K, self.stand, self.samples, name) for name in names]
        self.estimate = {one.estimator: estimator_for(one) for one in given}
        self.u = {one.estimator: standard_uncertainties(one, self.schedule, self.measured) for one in given}
        self.differences = []

    def world(self, runs, seed=SEED):
        return World(self.schedule.data, self.stand, runs, np.random.default_rng(seed))

    def _squares(self, means, far):
        """Chi-squared of every run: linear, and by the core on the exact geometry for the first runs, which tell how
        much that matters, and where K is `far` from that of the block."""
        squares = (self.causes.rest(means) ** 2).sum(axis=1)
        exactly = far | (np.arange(len(means)) < CONFIRMED)
        given = self.measured, self.variance, self.stand
        whole = chi_squared_of_model if self.schedule.data.is_inclined else chi_squared
        exact = np.array([whole(self.schedule, one, *given)[0] for one in means[exactly]])
        judged = ~far[exactly] & (np.minimum(exact, squares[exactly]) < 2 * self.limit)
        self.differences.append(np.abs(exact - squares[exactly])[judged].max(initial=0.0))
        squares[exactly] = exact
        return squares

    def cell(self, row, runs):
        """Of the table."""
        return self._of_means(row, runs) if row.noise is None else self._of_samples(row, runs)

    def _of_samples(self, row, runs):
        found = NoisyRuns(self, row, math.ceil(runs / FEWER))
        covered = []
        for name in self.estimate:
            errors = np.abs(self.estimate[name](found.means) - TRUTH)
            covered.append((errors <= 2 * found.u(name, self.u[name])).mean(axis=0))
        failed, told = found.squares > self.limit, found.told
        explained = told.sum() / max(1, (failed | told).sum())
        return Cell(np.array(covered), failed.mean(), (failed | told).mean(), explained, math.nan)

    def _of_means(self, row, runs):
        world = self.world(runs)
        means = row.means(world)
        found = self._found(self.closed_form, means)
        far = ~(np.abs(found[:, :9] - TRUTH[:9]).max(axis=1) <= FAR)
        squares = self._squares(means, far)
        refused, unfit = far & self._refuses(means[far]), squares > self.limit
        solved = squares < LARGEST_MISFIT**2 * self.causes.freedom
        covered = np.array([self._covered(name, means[solved]) for name in self.estimate])
        named = self.causes.first(self.causes.rest(means), ~unfit, row.causes)
        told = unfit | refused | np.array([bool(names) for names in named])
        right = sum(bool(set(names) & set(row.causes)) for names in named)
        shift = np.linalg.norm(self.causes.shown(means - honest(world)), axis=1)
        best = np.mean([normal_above(3.0902 - one) for one in shift])
        return Cell(covered, (unfit | refused).mean(), told.mean(), right / max(1, told.sum()), best)

    def _covered(self, estimator, means):
        """Shares (12,) of coefficients within k = 2; not a number where no run has a result."""
        if not len(means):
            return np.full(12, np.nan)
        return (np.abs(self._found(estimator, means) - TRUTH) <= 2 * self.u[estimator]).mean(axis=0)

    def _found(self, estimator, means):
        """Coefficients (runs, 12); not numbers where a run is refused."""
        try:
            return self.estimate[estimator](means)
        except core.CoreRefusal:
            return np.vstack([self._lone(estimator, one) for one in means[:, None]])

    def _lone(self, estimator, means):
        try:
            return self.estimate[estimator](means)
        except core.CoreRefusal:
            return np.full((1, 12), np.nan)

    def _refuses(self, means):
        """Whether runs are refused for their K: a few tell for all."""
        return len(means) > 0 and all(self._refused(one) for one in means[:EXAMINED])

    def _refused(self, means):
        run = Run(self.samples, means, np.full(means.shape, self.stand.noise), "V", {})
        try:
            solution = solve(run, self.schedule, self.closed_form, self.file.delta_g_limit_g, None, "run.csv")
        except (BadInput, Disagreement):
            return True
        return examine(solution, self.file).refusal is not None


def chi_squared_of_model(schedule, means, _, variance, stand):
    """By numpy, where the core's own does not know of inclinations."""
    model = WholeModel(schedule.data, means, variance, stand)
    return model.chi_squared, model.freedom


def normal_above(x):
    return 0.5 * math.erfc(x / math.sqrt(2.0))


def per_cent(share):
    return "-" if math.isnan(share) else f"{100 * share:.0f}"


def columns(row, cell):
    """Two of the table: coverage, and who notices."""
    covered = [f"{per_cent(one.mean())}, {per_cent(one.min())}".replace("-, -", "-") for one in cell.coverage]
    explained = cell.explained if row.causes and cell.told > LEAST else math.nan
    shares = [cell.failed, cell.told, explained, cell.best]
    return "; ".join(covered), ", ".join(map(per_cent, shares))


def table(stand, schedules, wanted, runs):
    """Printed line by line."""
    cases = [Case(stand, name) for name in schedules]
    print(f"\n| `{stand}` | {' | '.join(f'`{name}`: coverage | noticed' for name in schedules)} |")
    print("|---" * (1 + 2 * len(cases)) + "|")
    for row in wanted:
        cells = [text for case in cases for text in columns(row, case.cell(row, runs))]
        print(f"| {' | '.join([row.name, *cells])} |", flush=True)
    for case, name in zip(cases, schedules):
        off = max(case.differences, default=0.0)
        print(f"{stand}, {name}: linear chi-squared {off:.2g} off at most", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", nargs="*", metavar="ROW", help="beginnings of their names")
    parser.add_argument("--runs", type=int, default=2000)
    parser.add_argument("--stand", choices=STANDS, action="append")
    parser.add_argument("--schedule", choices=SCHEDULES, action="append")
    options = parser.parse_args()
    wanted = [row for row in rows() if not options.rows or row.name.startswith(tuple(options.rows))]
    for stand in options.stand or STANDS:
        table(stand, options.schedule or SCHEDULES, wanted, options.runs)


if __name__ == "__main__":
    main()
