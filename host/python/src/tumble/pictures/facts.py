"""What the pictures of one result are made from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.schedule import CHECK, Schedule
from tumble.solving.expected import Expected
from tumble.stand import Stand
from tumble.units import volts_per

MICRO = 1e6  # of a g, of a radian
_PREFIXES = ((1.0, ""), (1e3, "m"), (1e6, "µ"))


class Recorded(Protocol):
    """What `tumble.read` returns, as far as it is drawn."""

    @property
    def mounting(self) -> Integers: ...
    @property
    def position(self) -> Integers: ...
    @property
    def outputs(self) -> Floats: ...


@dataclass(frozen=True)
class Facts:
    """A `document` of schema tumble.result/1, and None for whatever is not known: the `run` that was solved, the
    `schedule` of its measured positions, the `stand` that was declared and what is `expected` of it."""

    document: dict[str, Any]
    run: Recorded | None
    schedule: Schedule | None
    stand: Stand | None
    expected: Expected | None

    @property
    def unit(self) -> str:
        """Of the outputs."""
        return str(self.document["unit"])

    @property
    def labels(self) -> list[str]:
        """Of the measured positions, such as "2.7"."""
        return [f"{one['mounting']}.{one['position']}" for one in self.document["means"]]

    @property
    def is_check(self) -> list[bool]:
        """Whether a measured position is only checked."""
        return [one["use"] == CHECK for one in self.document["means"]]

    @property
    def remounted(self) -> list[int]:
        """Indices of the positions before which the block was mounted anew."""
        mountings = [one["mounting"] for one in self.document["means"]]
        return [index for index in range(1, len(mountings)) if mountings[index] != mountings[index - 1]]


def three_figures(value: float) -> str:
    """Of a size, never with an exponent for a large one."""
    return f"{value:.0f}" if value >= 99.95 else f"{value:#.3g}"


def small(unit: str, values: Floats) -> tuple[float, str]:
    """Factor and unit that make numbers of the largest of `values`, in the `unit` of the outputs: multiples of the volt
    have smaller ones, others stay as they are."""
    largest = float(np.abs(values).max(initial=0.0))
    if volts_per(unit) == 1.0 and unit != "V":
        return 1.0, unit
    volts = volts_per(unit)
    factor, prefix = next((one for one in _PREFIXES if largest * volts * one[0] >= 1.0), _PREFIXES[-1])
    return volts * factor, f"{prefix}V"
