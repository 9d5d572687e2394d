"""What the candidates of cortex_m4.py get: a run, its stand and its gains, as C, and what the host makes of them."""

import sys
from pathlib import Path

import numpy as np

from tumble import core
from tumble.model import Geometry
from tumble.model.optimal import optimal_table
from tumble.solving import optimal_run
from tumble.stand import PAPER_STAND

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))
from core_functions import estimate_gains, optimal as optimal_of

OTHERS = ("three_mountings", "diagonal")  # schedules beside the paper's


def write_data(path):
    """Write the run, its stand and its record as C; return what the host makes of them, (12,) by estimator."""
    schedule = core.CoreSchedule(core.paper_schedule())
    rng = np.random.default_rng(1)
    k = np.full((3, 3), 0.04) + 1.96 * np.eye(3)
    errors = {"alpha1": 2e-5, "alpha2": -2e-5, "alpha3": [4e-4, -4e-4], "delta": 4e-5 * rng.normal(size=18)}
    means = Geometry(schedule.data).outputs(k, np.array([0.01, -0.02, 0.03]), **errors) + 4e-5 * rng.normal(
        size=(18, 3)
    )
    others = {name: Geometry(core.built_in(name)).outputs(k, np.array([0.01, -0.02, 0.03])) for name in OTHERS}
    inclined = Geometry(core.built_in("inclined")).outputs(k, np.array([0.01, -0.02, 0.03]))
    written = optimal_run.record_of(optimal_table(schedule.data, k, PAPER_STAND), schedule.data)
    sigmas = ", ".join(
        PAPER_STAND.sigma(source).hex() for source in ("axis_tilt", "level", "remount", "angle", "noise")
    )
    path.write_text(
        optimal_run.to_c_header(written)
        + f"""#include "data.h"
const tumble_means_t benchmark_means = {{.u_v = {{{rows_of(means)}}},
    .measured = {{{", ".join(["true"] * 18)}}}}};
{"".join(means_as_c(name, outputs) for name, outputs in others.items())}
{means_as_c("inclined", inclined)}
const tumble_gain_record_t *const benchmark_record = &tumble_optimal_gains.head;
const tumble_gain_table_t benchmark_table = {{tumble_optimal_gains.gains[0], 18, 0.0}};
const tumble_stand_record_t benchmark_stand = {{
    {sigmas}, 0.0, {PAPER_STAND.samples}, false, 0.0, 0.0, 0.0, 0.0, {{0.0}}, {{0.0}}}};
const tumble_coefficients_t benchmark_coefficients = {{.k_v_per_g = {{{rows_of(k)}}}}};
"""
    )
    data = optimal_run.to_bytes(written)
    optimal = optimal_of(data, schedule, means)
    found = {name: core.estimate(schedule, means, None, name) for name in ("refined", "least_squares")}
    found |= {"linear": estimate_gains(schedule, written.gains, means), "optimal": (optimal.k, optimal.u0)}
    once = np.ones(18, dtype=int)
    for name in ("refined", "least_squares"):
        found[f"u {name}"] = core.uncertainties(schedule, k, PAPER_STAND, once, name)
    bolted_once, each = core.CoreSchedule.built_in("inclined"), np.ones(len(inclined), dtype=int)
    found["inclined"] = core.estimate(bolted_once, inclined, None, "inclined")
    found["u inclined"] = core.uncertainties(bolted_once, k, PAPER_STAND, each, "inclined")
    for name, outputs in others.items():
        found[name] = core.estimate(core.CoreSchedule.built_in(name), outputs)
    found["u optimal"] = core.uncertainties_of_gains(schedule, k, PAPER_STAND, once, written.gains)
    return {name: np.concatenate([k.ravel(), u0]) for name, (k, u0) in found.items()}


def means_as_c(name, means):
    measured = ", ".join(["true"] * len(means))
    return f"const tumble_means_t benchmark_{name} = {{.u_v = {{{rows_of(means)}}}, .measured = {{{measured}}}}};\n"


def rows_of(matrix):
    return ",\n    ".join("{" + ", ".join(map(float.hex, map(float, row))) + "}" for row in matrix)
