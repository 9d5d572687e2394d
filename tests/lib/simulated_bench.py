"""The simulated bench of the tests, in this process: a calibration, or many, by the keys of a scenario.

Keys are a mapping, in whose names `__` may stand for the point and a list repeats its key, or the lines of a scenario.
"""

import json
import time
from pathlib import Path

import pytest

from tumble.documents.bench import written
from tumble.errors import BenchFault
from tumble.workers.over import ALONE
from tumble.world import campaigns, in_process, programs
from tumble.world.border import Border

HASTY_STAND = """
[stand]
name = "hasty"
axis_tilt_rad = 1e-5
level_rad = 2e-5
remount_rad = 3e-5
angle_rad = 2e-5
noise_v = 3e-4
samples = 10
limits = "sigma1"
[motion]
velocity_deg_per_s = 720.0
acceleration_deg_per_s2 = 7200.0
settling_s = 0.05
[accept]
delta_g_limit_g = 1e-3
"""
QUICK = {"motion.settling_s": 0.05, "motion.speed_deg_s": 720, "motion.acceleration_deg_s2": 7200,
         "procedure.settle_ms": 100, "procedure.samples": 10, "operator.mount_s": 0.1}  # fmt: skip
DRIVE_FAULT = "drive_fault at=1.5 phase=move delay=0.05 value=30001"


def bench(keys=(), seed=1, gains=None, out=None):
    """The document of a run; `out`: a folder for run.csv, bus.log and bench.json. Raises Refused."""
    border = Border(seed, lines_of(keys), gains)
    in_process.Run(border, lambda event: None, events=0).to_its_end()
    if out is None:
        return written(border.document())
    out.mkdir()
    return written(in_process.write(border, out))


def runs(keys, count, seed=1, gains=None, team=ALONE):
    """The lines of as many runs, with their means."""
    job = campaigns.Runs(tuple(lines_of(keys)), "the scenario", True, gains)
    return [json.loads(line) for part in campaigns.ended(job, seed, count, team) for line in part.output.splitlines()]


def lines_of(keys):
    """Of a scenario."""
    if not isinstance(keys, dict):
        return list(keys)
    each = ((key, value if isinstance(value, list) else [value]) for key, value in keys.items())
    return [f"{key.replace('__', '.')} = {value}" for key, values in each for value in values]


def scenario(folder, name="scenario.txt", **keys):
    """A scenario file."""
    path = Path(folder) / name
    path.write_text("".join(f"{line}\n" for line in lines_of(keys)))
    return path


def built(name):
    """Where a program is that may not be there; skips without it."""
    try:
        return programs.find(name)
    except BenchFault:
        return pytest.skip(f"{name} is not built" + ": pkg-config finds no libmodbus" * (name == "tumble-gateway"))


def wait_until(condition, timeout=60.0):
    """Look again and again. Fails when it takes too long."""
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.002)
