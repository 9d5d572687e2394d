"""The case to plan for: a stand, a block of nominal sensitivity, a schedule, an acceptance limit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.defaults import DEFAULT_COVERAGE_FACTOR, DEFAULT_LIMIT_G
from tumble.documents.plan import Block
from tumble.errors import BadInput
from tumble.estimators import OPTIMAL
from tumble.files.stand_file import StandFile
from tumble.model.errors import by_gains, covariance_of
from tumble.model.geometry import built_in
from tumble.model.optimal import mean_sigma
from tumble.model.propagation import Propagation
from tumble.model.reliability import Reliability, reliability
from tumble.schedule import Schedule
from tumble.stand import PAPER_STAND, PER_CHANNEL, PerChannel, Stand, by_channel
from tumble.terms import Terms

PAPER_BLOCK = 2.0, 0.02  # V/g, rad


@dataclass(frozen=True)
class Case:
    """`stand`: as declared, with a noise no smaller than what the converter's steps leave, and with rounding as
    planned. `scale`: V/g, one or three, of any sign, not 0. `misalignment`: radians, the same for all six. `step_v`: of
    the converter, 0 if unknown. `schedule`: None for the paper's. `limit_g`: of the stand file, else the paper's.
    `terms`: extended terms of the model, whose true sizes are 0. `coverage_factor`: of the decision rule."""

    stand: Stand
    scale: PerChannel
    misalignment: float
    step_v: PerChannel
    own_schedule: Schedule | None
    limit_g: float
    terms: Terms = ()
    coverage_factor: float = DEFAULT_COVERAGE_FACTOR

    @classmethod
    def of(cls, stand_file: StandFile | None, name: str | None, schedule: Schedule | None) -> Case:
        """Read the case from files. None stands for the paper's stand, block or schedule. Raises BadInput for a file
        without [block]."""
        if stand_file is None:
            return cls(PAPER_STAND, *PAPER_BLOCK, 0.0, schedule, DEFAULT_LIMIT_G)
        block = stand_file.block
        if block is None:
            raise BadInput("no table [block]: a plan needs scale_v_per_g and misalignment_rad", name or "")
        limit_g = DEFAULT_LIMIT_G if stand_file.delta_g_limit_g is None else stand_file.delta_g_limit_g
        nominal = block["scale_v_per_g"], block["misalignment_rad"]
        step_v = stand_file.step_v
        stand, factor = stand_file.stand.planned_with(step_v), stand_file.decided_by
        return cls(stand, *nominal, step_v, schedule, limit_g, coverage_factor=factor)

    @property
    def block(self) -> Block:
        """The block as a part of a plan."""
        return Block(self.scale, self.misalignment)

    @property
    def full_scale(self) -> dict[str, float]:
        """The scale, V/g, that relates noise and drift of the worst channel to 1 g."""
        sizes, profiles = np.abs(by_channel(self.scale)), {name: self.stand.profile(name) for name in PER_CHANNEL}
        with np.errstate(divide="ignore"):
            return {name: float((sizes / profile).min()) for name, profile in profiles.items()}

    @property
    def block_sentence(self) -> str:
        """The block as a sentence for people."""
        scales = ", ".join(f"{scale:g}" for scale in np.atleast_1d(self.scale).tolist())
        return f"Block: {scales} V/g, misalignments {self.misalignment:g} rad"

    @property
    def schedule(self) -> Schedule:
        """The schedule in use."""
        return built_in("paper") if self.own_schedule is None else self.own_schedule

    @property
    def fitted(self) -> Schedule:
        """The schedule without its check positions."""
        return self.schedule.fitted

    def mean_sigma(self, k: Floats) -> Floats:
        """Standard deviations (3,) of a position's mean for a block of sensitivity `k`: noise and rounding."""
        by_noise = mean_sigma(k, self.stand, self.step_v, self.stand.samples)[0]
        sigmas: Floats = np.hypot(by_noise, by_channel(self.stand.rounding))
        return sigmas

    def spread(self, gains: Floats, k: Floats) -> Floats:
        """Standard deviations (rows,) of an estimate with `gains` (rows, 3P) for a block of sensitivity `k`."""
        errors = self.propagation(OPTIMAL, k, fitted=True).errors(self.mean_sigma(k) ** 2)
        u: Floats = np.sqrt(np.diag(covariance_of(by_gains(self.fitted, gains), errors)))
        return u

    @property
    def rounding_sentence(self) -> str | None:
        """What rounding leaves in every mean where noise does not dither the converter, and the remedies; None where it
        averages out."""
        rounding = by_channel(self.stand.rounding)
        if not rounding.any():
            return None
        named = ", ".join(f"u{axis}" for axis, left in zip("xyz", rounding) if left > 0.0)
        return (
            f"Noise under half a step of the converter ({named}): rounding leaves {rounding.max():.2g} V in the mean of"
            " any number of samples; remedies: dither, more bits, a smaller range"
        )

    def reliability(self, estimator: str) -> Reliability:
        """The errors that no run of the nominal block shows. Raises UsageError where the schedule lacks positions."""
        return reliability(self.propagation(estimator))

    def propagation(self, estimator: str, k: Floats | None = None, fitted: bool = False) -> Propagation:
        """How errors propagate into the means of a run of a block of sensitivity `k`, by default the nominal one.
        `fitted`: on the schedule without check positions."""
        schedule = self.fitted if fitted else self.schedule
        lone, of = np.ones(len(schedule.positions), dtype=int), self.nominal_k() if k is None else k
        return Propagation(schedule, of, self.stand, lone, estimator, self.step_v, self.terms)

    def nominal_k(self, signs: Floats | None = None) -> Floats:
        """K (3, 3) of the nominal block. `signs` (3, 3): of the misalignments, the diagonal unused; default all +."""
        misaligned = self.misalignment * (np.ones((3, 3)) if signs is None else np.array(signs, dtype=float))
        np.fill_diagonal(misaligned, 1.0)
        nominal: Floats = by_channel(self.scale)[:, None] * misaligned
        return nominal
