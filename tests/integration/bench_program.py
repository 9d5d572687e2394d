"""The programs for the tests, above all tumble-bench: scenarios for it, a run of it, and one with guests on its bus."""

import json
import subprocess
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from tumble.bench import program, programs
from tumble.errors import BenchFault

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


def built(name, folder):
    """Where a program is that may not be there; skips without it."""
    try:
        return programs.find(name, folder)
    except BenchFault:
        return pytest.skip(f"{name} is not built" + ": pkg-config finds no libmodbus" * (name == "tumble-gateway"))


def bench(*arguments, timeout=120, **others):
    """tumble-bench itself, run to its end."""
    command = [program.find(), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=timeout, **others)


def scenario(folder, name="scenario.txt", **keys):
    """A scenario file; `__` in a name stands for the point, a list repeats its key."""
    lines = []
    for key, values in keys.items():
        for value in values if isinstance(values, list) else [values]:
            lines.append(f"{key.replace('__', '.')} = {value}\n")
    path = Path(folder) / name
    path.write_text("".join(lines))
    return path


class Served:
    """A run that others take part in. `document`: what it found, once it has ended."""

    def __init__(self, command):
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.document = None

    def wait(self, timeout=60):
        """Until the run has ended. Returns its exit code."""
        out, err = self.process.communicate(timeout=timeout)
        assert self.process.returncode != 2 and out, err
        self.document = json.loads(out)
        return self.process.returncode


@contextmanager
def served(scenario_path, *options, guests=1):
    """Start tumble-bench and give (run, path of its socket)."""
    with tempfile.TemporaryDirectory() as folder:  # short: a socket's path has little room
        socket = f"{folder}/s"
        command = [program.find(), scenario_path, "--listen", socket, "--guests", guests, *options]
        run = Served(list(map(str, command)))
        try:
            yield run, socket
        finally:
            run.process.kill()
            run.process.wait()


def wait_until(condition, timeout=60.0):
    """Look again and again. Fails when it takes too long."""
    end = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < end, "not in time"
        time.sleep(0.002)
