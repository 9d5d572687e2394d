"""A fixture that the tests play: node 1 as tools/fixture sees it, a table with faults, a block on it in gravity."""

import sys
import time
from dataclasses import dataclass, field

import numpy as np
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools/fixture"))

from validation.instrument import ABORT, FAULT, HOME_AXIS, IN_POSITION, MOVING, READY
from validation.limits import read_limits
from validation.samples import Mean

from tumble.client import CommunicationError, Link, Refused

LIMITS = ROOT / "tools/fixture/limits.toml"
K = np.array([[-2.0, 0.03, -0.02], [0.01, -1.98, 0.04], [0.02, -0.03, -2.02]])
U0 = np.array([0.05, -0.02, 0.01])
COUNT_DEG = 0.001
QUICK = {"table__rest_s": "0.0", "table__settling_moves": "2", "settling__settling_s": "0.15"}


class PlayedTime:
    """In the place of the module time: a sleep passes at once, and a look at the clock takes a while."""

    LOOK_S = 2e-5

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        self.now += self.LOOK_S
        return self.now

    def sleep(self, seconds):
        self.now += seconds

    def __getattr__(self, name):
        return getattr(time, name)


@dataclass
class Faults:
    """All in the units of their names; 0: none."""

    noise_v: float = 3e-4
    alpha4_rad: float = 4e-5
    home_deg: float = 0.0  # standard deviation of where home is found
    backlash_deg: float = 0.0
    read_back_deg: float = 0.0
    slip_deg: float = 0.0  # at every turn to 360 deg
    stays: int = 0  # 2003h:12, whatever is commanded; 0: as it should be
    endless: bool = False
    silent: bool = False
    identity: dict = field(default_factory=dict)


class PlayedTable(Link):
    """Node 1 and all behind it; also the sampler of the block."""

    v_per_count = 10.0 / 2**23

    def __init__(self, seed=1, gravity=True, **faults):
        self.faults, self.random = Faults(**faults), np.random.default_rng(seed)
        self.sampler = self if gravity else None
        self.encoder, self.table, self.home_is = 0.0, 0.0, 0.0
        self.state, self.commands = READY, []

    def has(self, name):
        return False

    def read_together(self, *names):
        return [self._read(name) for name in names]

    def _read(self, name):
        if self.faults.silent:
            raise CommunicationError("node 1 does not answer: SDO timeout")
        values = {"State": 0, "Progress: Stand state": self.faults.stays or self.state,
                  "Progress: Actual angle": self.encoder + self.faults.read_back_deg,
                  "Identity object: Vendor-ID": 0, "Identity object: Product code": 0x54420001}
        return {**values, **self.faults.identity}[name]

    def write(self, name, value):
        raise Refused(name, 0x06020000)

    def wait_for_news(self):
        """It is always as it is."""

    def command(self, command, argument=0, angle_deg=None, proposal=0):
        self.commands.append(command)
        if command == ABORT:
            raise Refused("ABORT", 0x08000022)
        if self.faults.endless:
            self.state = MOVING
        elif command == HOME_AXIS:
            self.home_is = self.random.normal(0.0, 1.0) * self.faults.home_deg
            self.encoder = -5.0  # the mark is come to from below
            self.move(0.0)
        else:
            self.move(angle_deg)

    def move(self, angle):
        """The table lags behind its motor by the backlash when it goes down, and stops where alpha4 has it."""
        play = self.faults.backlash_deg if angle < self.encoder else 0.0
        if angle == 360.0:
            self.home_is += self.faults.slip_deg
        self.encoder, self.state = round(angle / COUNT_DEG) * COUNT_DEG, IN_POSITION
        error = np.degrees(self.random.normal(0.0, 1.0) * self.faults.alpha4_rad)
        self.table = self.encoder + play + error + self.home_is

    def mean(self, count):
        """Of so many samples, gravity turning about the block's axis x."""
        angle = np.radians(self.table)
        a = np.array([0.02, np.cos(angle), np.sin(angle)])
        samples = K @ a + U0 + self.random.normal(0.0, 1.0, (count, 3)) * self.faults.noise_v
        scatter = samples.std(axis=0, ddof=1)
        return Mean(samples.mean(axis=0), scatter / np.sqrt(count), scatter, count)

    def close(self):
        """Nothing."""


def limits(folder, **changes):
    """The limits of the example, quick; `section__key` changes one, None takes a line away."""
    lines, section = [], ""
    changes = {**QUICK, **changes}
    for line in LIMITS.read_text().splitlines():
        section = line[1:].split("]")[0] if line.startswith("[") else section
        key = f"{section}__{line.split('=')[0].strip()}" if section else line.split("=")[0].strip()
        if key in changes:
            line = "" if changes[key] is None else f"{line.split('=')[0]}= {changes[key]}"
        lines.append(line)
    path = folder / "limits.toml"
    path.write_text("\n".join(lines) + "\n")
    return path


__all__ = ["FAULT", "PlayedTable", "Refused", "limits", "read_limits"]
