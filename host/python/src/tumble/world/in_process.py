"""A run of the bench inside this process, from power-on to the table at rest: watched, answered, recorded."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tumble.documents import bench
from tumble.documents.base import to_json
from tumble.documents.bench import Bench
from tumble.world.border import AVERAGED, CHANGE, ENDED, FOREVER_US, QUESTION, Border, Event, Refused

OnEvent = Callable[[Event], "str | None"]

_SLICE_US = 60_000_000  # of virtual time, until a signal is looked for
_NAP_S = 0.05  # of the machine's, with a pace
_ANGLE_US = 100_000  # from one event of a turning table to the next
_HEADER = "mounting,position,ux,uy,uz,cx,cy,cz,counter,timestamp,temperature,time_s\n"


@dataclass(frozen=True)
class Run:
    """`border`: the world; `on_event` is told what happens and returns the answer to a question, or None; `pace`:
    virtual seconds per second, 0: as fast as it can; `events`: bits of what it is told."""

    border: Border
    on_event: OnEvent
    pace: float = 0.0
    events: int = CHANGE | AVERAGED | QUESTION

    def to_its_end(self) -> bool:
        """Let it run. Returns whether it was interrupted: then the table has been stopped, and is at rest if it can
        be."""
        try:
            self._go()
            return False
        except KeyboardInterrupt:
            self.border.end("interrupted")
            self.border.advance(FOREVER_US, 0)
            return True

    def _go(self) -> None:
        began_s, began_us, told_us = time.monotonic(), 0, 0
        now_us, happened = 0, 0
        while not happened & ENDED:
            until_us = now_us + _SLICE_US
            if self.pace > 0.0:
                until_us = began_us + int((time.monotonic() - began_s) * self.pace * 1e6)
            happened = self.border.advance(until_us, self.events)
            now_us = self.border.now_us
            self._tell(happened)
            if happened & QUESTION:
                began_s, began_us = time.monotonic(), now_us  # a person takes his time
            elif self.pace > 0.0 and not happened:
                if now_us >= told_us + _ANGLE_US and (angle := self.border.event(0)) is not None:
                    told_us = now_us
                    self.on_event(angle)
                time.sleep(_NAP_S)

    def _tell(self, happened: int) -> None:
        for one in (CHANGE, AVERAGED, QUESTION):
            if happened & one and (event := self.border.event(one)) is not None:
                answer = self.on_event(event)
                if one == QUESTION:
                    self._answer(answer)

    def _answer(self, answer: str | None) -> None:
        """What is not accepted is asked for again."""
        while answer is not None:
            try:
                self.border.answer(answer)
                return
            except Refused as refused:
                answer = self.on_event({"event": "refused", "what": str(refused)})


def write(border: Border, folder: Path) -> Bench:
    """run.csv, bus.log and the document into a folder. Returns the document. Raises OSError."""
    found = border.document()
    _write(folder / "run.csv", _run_rows(border))
    _write(folder / "bus.log", _bus_lines(border.frames()))
    _write(folder / "bench.json", [to_json(bench.written(found))])
    return found


def _write(path: Path, lines: Iterable[str]) -> None:
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.writelines(lines)


def _run_rows(border: Border) -> Iterator[str]:
    """run.csv: volts with 17 digits, raw counts, and what else a sample tells; of the means that were kept."""
    step, places = border.step_v, border.positions()
    yield _HEADER
    for block_ms, counts, _, counter, timestamp, index, half_c in border.samples().tolist():
        x, y, z = counts
        yield (
            f"{places[index][0]},{places[index][1]},{x * step:.17g},{y * step:.17g},{z * step:.17g},{x},{y},{z},"
            f"{counter},{timestamp},{half_c / 2:.1f},{block_ms / 1000:.3f}\n"
        )


def _bus_lines(frames: Any, interface: str = "can0") -> Iterator[str]:
    """bus.log, as candump -L writes it."""
    for time_us, identifier, length, _, data in frames.tolist():
        seconds, rest = divmod(time_us, 1_000_000)
        yield f"({seconds:010}.{rest:06}) {interface} {identifier:03X}#{data[:length].hex().upper()}\n"
