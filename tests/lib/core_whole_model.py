"""The whole-model test as a navigation computer takes it: in steps, from the averages of raw counts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from _tumble_core import ffi, lib
from core_averaging import Averaging

from tumble.core import record_of


@dataclass(frozen=True)
class Verdict:
    """What is told of a run, and how many `steps` it took."""

    chi_squared: float
    limit: float
    misfit: float
    freedom: int
    misfits: bool
    steps: int


def averages_of(counts):
    """Of one sample a position, `counts` (positions, 3) as int32."""
    averaging = Averaging()
    for index, row in enumerate(counts):
        averaging.begin(index)
        averaging.add(tuple(map(int, row)), index)
        averaging.finish()
    return averaging


def judge(schedule, averaging, k, u0, stand, v_per_count):
    """Begin with `k` (3, 3) and `u0` (3,), whatever estimate they are."""
    start = ffi.new("tumble_coefficients_t *", {"k_v_per_g": np.asarray(k).tolist(), "u0_v": np.asarray(u0).tolist()})
    record, work = record_of(stand), ffi.new("tumble_whole_work_t *")
    run = ffi.new("tumble_misfit_run_t *", [schedule.struct, averaging.state, start, record, v_per_count])
    lib.tumble_whole_begin(work)
    steps = 1
    while lib.tumble_whole_step(work, run):
        steps += 1
    assert work.known
    return Verdict(work.chi_squared, work.limit, work.misfit, work.freedom, work.misfits, steps)
