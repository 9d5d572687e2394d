"""The contents of a memory image as a document of schema tumble.store/1."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from msgspec import UNSET

from tumble.documents.base import DocumentT
from tumble.documents.store import Check, Checkpoint, Entry, KeptPosition, Range, Set, Slopes, Slots, Store
from tumble.store.codec import (
    HAS_TEMPERATURE,
    HAS_UNCERTAINTY,
    ORIGINS,
    CoefficientSet,
    HistoryEntry,
    Position,
    degree_of,
)
from tumble.store.image import Image

_DECAYED = {6: "decayed"}  # in the history alone


def document(found: Image) -> Store:
    """All contents of an image; unknown values are null."""
    positions = tuple(_position(found.positions[index]) for index in sorted(found.positions))
    return Store(
        active=found.active_slot or ("factory" if found.factory else None),
        factory=_set(found.factory),
        slots=Slots(*(_set(found.slots.get(name)) for name in "AB")),
        proposal=_set(found.proposal),
        history=tuple(map(_entry, found.history)),
        checkpoint=None if found.run is None else Checkpoint(found.run, positions),
        torn=tuple(found.torn),
        newer=tuple(found.newer),
    )


def _set(found: CoefficientSet | None) -> Set | None:
    if found is None:
        return None
    return _made(
        Set,
        found,
        origin=ORIGINS[found.origin],
        temperature=_range(found.temperature_range_c),
        check=None if found.check is None else Check(*found.check),
        **_coefficients(found.k + found.u0, None if found.u_k is None else found.u_k + (found.u_u0 or [])),
        slopes=UNSET if found.slopes is None else _slopes(found.slopes),
        **{key: getattr(found, key) or None for key in ("samples", "schedule_crc", "stand_crc")},
    )


def _slopes(slopes: list[list[float]]) -> Slopes:
    powers = [_coefficients(numbers, None) for numbers in slopes]
    return Slopes(degree_of(slopes), tuple(one["K"] for one in powers), tuple(one["U0"] for one in powers))


def _entry(entry: HistoryEntry) -> Entry:
    """An entry; a value that is not a number, under a valid checksum, becomes null."""
    return _made(
        Entry,
        entry,
        origin=(ORIGINS | _DECAYED).get(entry.origin),
        temperature_c=_finite([entry.temperature_c])[0] if entry.flags & HAS_TEMPERATURE else None,
        **_coefficients(_finite(entry.values), _finite(entry.u) if entry.flags & HAS_UNCERTAINTY else None),
    )


def _made(kind: type[DocumentT], found: object, **own: Any) -> DocumentT:
    """The fields of a record under the keys of a document; `own`: keys that the record does not have."""
    told = vars(found) | own
    return kind(**{key: told[key] for key in kind.__struct_fields__})


def _coefficients(values: Sequence[float | None], u: Sequence[float | None] | None) -> dict[str, Any]:
    """Coefficients from twelve numbers, K row by row, then U0, and their uncertainties."""
    u_k, u_u0 = (None, None) if u is None else (_rows(u), u[9:])
    return {"K": _rows(values), "U0": values[9:], "u_K": u_k, "u_U0": u_u0}


def _rows(numbers: Sequence[float | None]) -> list[Sequence[float | None]]:
    return [numbers[row : row + 3] for row in (0, 3, 6)]


def _position(position: Position) -> KeptPosition:
    scatter, temperature = _finite(position.scatter), _range(position.temperature_range_c)
    return KeptPosition(position.index, position.samples, tuple(position.sums), scatter, temperature)


def _range(range_c: list[float] | None) -> Range | None:
    return None if range_c is None else Range(*range_c)


def _finite(numbers: list[float]) -> tuple[float | None, ...]:
    return tuple(number if math.isfinite(number) else None for number in numbers)
