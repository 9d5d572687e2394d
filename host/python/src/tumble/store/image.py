"""Read an image of the memory as the firmware would: the active set, everything else, and torn records."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timezone
from typing import TypeVar

from tumble.errors import BadInput
from tumble.files.rows import range_text
from tumble.store import codec

SECTORS = 8
MIN_SECTOR = 4096
FACTORY_PLACES, FACTORY_PITCH = 4, 512

_T = TypeVar("_T")


@dataclass
class Image:
    """The contents of an image. `torn`: places that are neither blank nor valid, with the reason. `newer`: places of
    valid sets that a newer version wrote."""

    factory: codec.CoefficientSet | None = None
    slots: dict[str, codec.CoefficientSet] = field(default_factory=dict)
    proposal: codec.CoefficientSet | None = None
    history: list[codec.HistoryEntry] = field(default_factory=list)  # newest first
    run: int | None = None  # fingerprint
    positions: dict[int, codec.Position] = field(default_factory=dict)
    torn: list[str] = field(default_factory=list)
    newer: list[str] = field(default_factory=list)

    @property
    def active_slot(self) -> str | None:
        return max(self.slots, key=lambda name: self.slots[name].sequence, default=None)

    @property
    def active(self) -> codec.CoefficientSet | None:
        slot = self.active_slot
        return self.factory if slot is None else self.slots[slot]


def read_image(image: bytes, sector: int = MIN_SECTOR, name: str = "image") -> Image:
    """Read an image of at least eight sectors. Raises BadInput."""
    if sector < MIN_SECTOR:
        raise BadInput(f"a sector has at least {MIN_SECTOR} bytes, not {sector}", name)
    if len(image) < SECTORS * sector or len(image) % sector:
        raise BadInput(f"{len(image)} bytes are not whole sectors of {sector} bytes, {SECTORS} at least", name)
    found = Image()
    _read_sets(image, sector, found)
    active, proposal = found.active, image[3 * sector : 3 * sector + codec.SET_BYTES]
    if found.slots and active and active.from_crc == int.from_bytes(proposal[-4:], "little"):
        found.proposal = None  # it has become active, and only has not been cleared
    _read_history(image, sector, found)
    _read_run(image, sector, found)
    return found


def _read(decode: Callable[[bytes], _T], bytes_: bytes, where: str, found: Image) -> _T | None:
    """Decode a place. None where it is blank or torn; a torn one is noted."""
    if bytes_.count(0xFF) == len(bytes_):
        return None
    try:
        return decode(bytes_)
    except codec.NewerVersion as reason:
        found.newer.append(f"{where}: {reason}")
    except codec.NotARecord as reason:
        found.torn.append(f"{where}: {reason}")
    return None


def _read_sets(image: bytes, sector: int, found: Image) -> None:
    def place(offset: int, where: str) -> codec.CoefficientSet | None:
        return _read(codec.decode_place, image[offset : offset + codec.PLACE_BYTES], where, found)

    for number in range(FACTORY_PLACES):
        found.factory = found.factory or place(number * FACTORY_PITCH, f"factory place {number + 1}")
    for number, name in ((1, "A"), (2, "B")):
        if (slot := place(number * sector, f"slot {name}")) is not None:
            found.slots[name] = slot
    found.proposal = place(3 * sector, "proposal")


def _read_history(image: bytes, sector: int, found: Image) -> None:
    for number in (4, 5):
        for cell in range(MIN_SECTOR // codec.ENTRY_BYTES):
            offset = number * sector + cell * codec.ENTRY_BYTES
            where = f"history, sector {number}, entry {cell + 1}"
            if (
                entry := _read(codec.decode_entry, image[offset : offset + codec.ENTRY_BYTES], where, found)
            ) is not None:
                found.history.append(entry)
    found.history.sort(key=lambda entry: -entry.number)


def _read_run(image: bytes, sector: int, found: Image) -> None:
    cells = [
        image[start : start + codec.CELL_BYTES]
        for base in (6 * sector, 7 * sector)
        for start in range(base, base + MIN_SECTOR, codec.CELL_BYTES)
    ]
    found.run = _read(codec.decode_run, cells[0], "checkpoint", found)
    for number, cell in enumerate(cells[1:], 1):
        if (run := found.run) is not None:
            where = f"checkpoint, position entry {number}"
            decode = functools.partial(codec.decode_position, fingerprint=run)
            if (position := _read(decode, cell, where, found)) is not None:
                found.positions[position.index] = position


def _date(date_utc_s: int | None) -> str:
    if date_utc_s is None:
        return "date unknown"
    try:
        return datetime.fromtimestamp(date_utc_s, timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    except (OverflowError, OSError, ValueError):
        return f"{date_utc_s} s UTC"


def _set_line(name: str, found: codec.CoefficientSet | None) -> str:
    if found is None:
        return f"{name}: none"
    diagonal = ", ".join(f"{found.k[i]:.9g}" for i in (0, 4, 8))
    parts = [
        f"sequence {found.sequence}",
        codec.ORIGINS[found.origin],
        f"block {found.serial!a}",
        _date(found.date_utc_s),
        f"K_xx, K_yy, K_zz {diagonal} V/g",
        f"U0 {', '.join(f'{u:.6g}' for u in found.u0)} V",
    ]
    where = range_text(*found.temperature_range_c) if found.temperature_range_c else ""
    if found.slopes is not None:
        parts += [f"degree {codec.degree_of(found.slopes)} over {where} about {found.temperature_c:.4g} deg C"]
        for power, numbers in enumerate(found.slopes[: codec.degree_of(found.slopes)], 1):
            per = "K" if power == 1 else f"K^{power}"
            parts += [f"slopes of K_xx, K_yy, K_zz {', '.join(f'{numbers[i]:.4g}' for i in (0, 4, 8))} V/g/{per}"]
            parts += [f"of U0 {', '.join(f'{u:.4g}' for u in numbers[9:])} V/{per}"]
    else:
        parts += [f"at {where}"] if where else []
    parts += [f"gravity check {max(found.check[:2]):.2g} of {found.check[2]:.2g} g"] if found.check else []
    parts += [f"reasons {found.reasons:#06x}"] if found.reasons else []
    parts += ["under other rules than the board's"] if found.other_rules else []
    return f"{name}: {', '.join(parts)}"


def describe(found: Image) -> list[str]:
    """Summarise an image in a few lines."""
    where = f" (slot {found.active_slot})" if found.slots else " (the factory set)" if found.factory else ""
    lines = [_set_line(f"active{where}", found.active), _set_line("factory", found.factory)]
    lines += [_set_line(f"slot {name}", found.slots[name]) for name in found.slots if name != found.active_slot]
    lines += [_set_line("proposal", found.proposal)]
    newest = found.history[0] if found.history else None
    since = newest and f"{len(found.history)}, the newest of {_date(newest.date_utc_s)} with sequence {newest.sequence}"
    lines += [f"history: {since or 'empty'}"]
    kept = f"run {found.run:#010x}, {len(found.positions)} positions" if found.run is not None else "no run is kept"
    lines += [f"checkpoint: {kept}", *(f"newer: {place}, which this one cannot read" for place in found.newer)]
    return [*lines, *(f"torn: {place}" for place in found.torn)]
