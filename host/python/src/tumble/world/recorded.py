"""run.csv and bus.log of a run in a simulated world."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tumble.world.border import Border

_HEADER = "mounting,position,ux,uy,uz,cx,cy,cz,counter,timestamp,temperature,time_s\n"


def run_rows(border: Border) -> Iterator[str]:
    """run.csv: volts with 17 digits, raw counts, and what else a sample tells; of the means that were kept."""
    report = border.report()
    step = report.v_per_count
    places = [(one.mounting, one.number) for one in (report.positions[i] for i in range(report.position_count))]
    yield _HEADER
    for block_ms, counts, _, counter, timestamp, index, half_c in border.samples().tolist():
        x, y, z = counts
        yield (
            f"{places[index][0]},{places[index][1]},{x * step:.17g},{y * step:.17g},{z * step:.17g},{x},{y},{z},"
            f"{counter},{timestamp},{half_c / 2:.1f},{block_ms / 1000:.3f}\n"
        )


def bus_lines(frames: Any, interface: str = "can0") -> Iterator[str]:
    """bus.log, as candump -L writes it."""
    for time_us, identifier, length, _, data in frames.tolist():
        seconds, rest = divmod(time_us, 1_000_000)
        yield f"({seconds:010}.{rest:06}) {interface} {identifier:03X}#{data[:length].hex().upper()}\n"
