"""What a run has found, and what became of it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.client.errors import Refused
from tumble.client.link import Link, Value, number
from tumble.client.names import Objection, objections, verdict

_K = tuple(f"{{}}K_{row}{column}" for row in "xyz" for column in "xyz")
_U0 = tuple(f"{{}}U0_{row}" for row in "xyz")
_MORE = "Keeper: More objections"
_NUMBERS = (
    "Run number",
    "Keeper: Verdict",
    "Keeper: Objections",
    "Keeper: Calibration counter",
    "Proposal: Record CRC",
    "Gravity check: Pass",
    "Gravity check: Largest deviation on fit positions",
    "Gravity check: Largest deviation on check positions",
    "Gravity check: Limit",
)
NAMES = (
    *(name.format("K: ") for name in _K),
    *(name.format("U0: ") for name in _U0),
    *(f"u_K: {name.format('u_')}" for name in _K),
    *(f"u_U0: {name.format('u_')}" for name in _U0),
    *_NUMBERS,
)


@dataclass(frozen=True, eq=False)
class Result:
    """Of the last finished run. `run`: its number; `K` (3, 3), V/g, and `U0` (3,), V, with their standard uncertainties
    `u_K` and `u_U0`, None where the board declares no stand or has no memory.

    `passed`: the gravity check; `max_abs_delta_g_g`: its largest deviation; `limit_g`. `verdict`: COMMITTED, HELD,
    REPEATED, ACCEPTED, DISCARDED, ROLLED_BACK or FAILED, None on a board without memory; `objections`: why it is held;
    `proposal`: what accepting it names, None where nothing is held; `calibration_counter`: of the active set.
    """

    run: int
    K: Floats
    U0: Floats
    u_K: Floats | None  # as everywhere
    u_U0: Floats | None
    passed: bool
    max_abs_delta_g_g: float
    limit_g: float
    verdict: str | None
    objections: tuple[Objection, ...]
    proposal: int | None
    calibration_counter: int | None


def read(link: Link) -> Result | None:
    """None: there is no result."""
    values = link.read_together(*NAMES)
    k, u0, u_k, u_u0 = values[:9], values[9:12], values[12:21], values[21:24]
    run, verdict_number, bits, counter, crc, passed, fit, check, limit = values[24:]
    if None in k or None in u0:
        return None
    said = verdict(_whole(verdict_number))
    return Result(
        int(number(run)),
        np.reshape(_floats(k), (3, 3)),
        _floats(u0),
        None if None in u_k else np.reshape(_floats(u_k), (3, 3)),
        None if None in u_u0 else _floats(u_u0),
        bool(passed),
        max(float(number(fit)), float(number(check))),
        float(number(limit)),
        said,
        all_objections(link, said, _whole(bits) or 0),
        _whole(crc) if said == "HELD" else None,
        _whole(counter),
    )


def all_objections(link: Link, verdict: str | None, bits: int) -> tuple[Objection, ...]:
    """With those from 16 on, which an older node does not have; `bits`: those below it, of 2120h:6."""
    more = None
    if verdict == "HELD" and link.has(_MORE):
        with suppress(Refused):
            more = link.read(_MORE)
    return objections(bits | (_whole(more) or 0) << 16)


def _floats(values: list[Value]) -> Floats:
    return np.array([number(value) for value in values], dtype=float)


def _whole(value: Value) -> int | None:
    return None if value is None else int(number(value))
