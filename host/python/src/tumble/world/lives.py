"""Hostile lives (host/world/lives.h, docs/campaign.md) one after the other, each as numbers that add."""

from __future__ import annotations

import contextlib
from typing import Any

from tumble.world.border import require_built, text

with contextlib.suppress(ImportError):  # which require_built tells of
    from _tumble_world import ffi, lib

_MICROSECOND = 1e-6
_STATE = "TUMBLE_STATE_"


class Lives:
    """Raises BenchFault where the extension is not built."""

    def __init__(self) -> None:
        require_built()
        self._lives = ffi.gc(lib.lives_new(), lib.lives_free)
        if self._lives == ffi.NULL:
            raise MemoryError

    def live(self, seed: int) -> dict[str, Any]:
        """The life of a seed, in the form of the document of many (schema tumble.hostile/1); `said`: what was
        violated, where something was."""
        violated = self._live(seed) is not None
        counted = self._counted()
        every = counted["all"]
        return {
            "runs": 1,
            "violated": int(violated),
            "violations": counted["violations"],
            "first": [],
            "faults": counted["faults"],
            "events": counted["events"],
            "flipped_bits": every["flipped_bits"],
            "excuses": counted["excuses"],
            "ends": {name: reasons for name, reasons in counted.items() if name.startswith(_STATE)},
            "homings": every["homings"],
            "sets": counted["sets"],
            "lives_with_commit": int(counted["sets"]["committed"] > 0),
            "table": self._table(),
            "virtual_us": every["virtual_us"],
            "frames": every["frames"],
            "steps": every["steps"],
            **({"said": self._violation()[1]} if violated else {}),
        }

    def shrunk(self, seed: int) -> dict[str, Any] | None:
        """The life of a seed that is violated, lived again with the fewest events that are enough; None: it was not
        drawn at all. Events go in halves, quarters and so on down to single ones."""
        kind, drawn = self._live(seed), len(self._lines()) - 1
        if drawn < 0:
            return None
        left, size = list(range(drawn)), (drawn + 1) // 2
        while True:
            before = len(left)
            left = self._fewer(seed, kind, left, size)
            if size == 1 and len(left) == before:
                break
            size = max(1, (size + 1) // 2)
        self._live(seed, left)
        at_us, what = self._violation()
        told = {"seed": seed, "kind": kind, "at_s": at_us * _MICROSECOND, "what": what, "drawn": drawn}
        world, *events = self._lines()
        return {**told, "world": world, "events": events}

    def _fewer(self, seed: int, kind: str | None, left: list[int], size: int) -> list[int]:
        """Without the pieces of this size that it takes no part of."""
        at = 0
        while at < len(left):
            fewer = left[:at] + left[at + size :]
            if self._live(seed, fewer) == kind:
                left = fewer
            else:
                at += size
        return left

    def _live(self, seed: int, events: list[int] | None = None) -> str | None:
        """Returns what was violated."""
        own = ffi.NULL if events is None else ffi.new("uint32_t[]", events)
        word = lib.lives_live(self._lives, seed, own, len(events or []))
        return None if word == ffi.NULL else text(word)

    def _lines(self) -> list[str]:
        found: list[str] = []
        while (line := lib.lives_line(self._lives, len(found))) != ffi.NULL:
            found.append(text(line))
        return found

    def _violation(self) -> tuple[int, str]:
        at_us = ffi.new("uint64_t *")
        what = text(lib.lives_violation(self._lives, at_us))
        return int(at_us[0]), what

    def _counted(self) -> dict[str, dict[str, int]]:
        found: dict[str, dict[str, int]] = {}
        name, value, row = ffi.new("const char **"), ffi.new("uint64_t *"), 0
        while (group := lib.lives_count(self._lives, row, name, value)) != ffi.NULL:
            found.setdefault(text(group), {})[text(name[0])] = int(value[0])
            row += 1
        return found

    def _table(self) -> dict[str, Any] | None:
        at_rest, way = ffi.new("bool *"), ffi.new("double[2]")
        if not lib.lives_travel(self._lives, at_rest, way, way + 1):
            return None
        return {"at_rest": bool(at_rest[0]), "lowest_deg": way[0], "highest_deg": way[1]}
