"""Objects that follow from the standard (CiA 301) and need no writing: PDO parameters, dummy objects."""

from __future__ import annotations

from headers import OWN
from kinds import TYPES

MAX_MAPPED = OWN.value("TUMBLE_MAX_MAPPED")
PDO_INVALID = 0x80000000


def dummy_objects() -> list[dict]:
    """Places that a receive PDO may skip: an object whose number is that of a data type (CiA 301, 7.4.7)."""
    return [
        {"index": TYPES[key].code, "name": f"Dummy {TYPES[key].name}", "type": key, "access": "wo", "home": "value",
         "value": 0, "map": "receive"}
        for key in ("u8", "u16", "u32")
    ]


def pdo_objects(pdos: list[dict], base: int, transmit: bool) -> list[dict]:
    """Communication parameter and mapping of every PDO."""
    tables = []
    for number, pdo in enumerate(pdos):
        communication = [
            {"sub": 1, "name": "COB-ID used by PDO", "type": "u32", "value": cob_id_default(pdo["cob_id"])},
            {"sub": 2, "name": "Transmission type", "type": "u8", "value": pdo["type"]},
        ]
        if transmit:
            communication += [
                {"sub": 3, "name": "Inhibit time", "type": "u16", "value": pdo.get("inhibit_100us", 0),
                 "unit": "100 us"},
                {"sub": 5, "name": "Event timer", "type": "u16", "value": pdo.get("event_ms", 0), "unit": "ms"},
            ]
        word = "Transmit" if transmit else "Receive"
        level = {"level": pdo["level"]} if "level" in pdo else {}
        about = {"about": pdo["about"]} if "about" in pdo else {}
        tables.append({"index": base + number, "name": f"{word} PDO {number + 1} parameter", "kind": "record",
                       "home": "communication", "access": "rw", "subs": communication} | level | about)
        slots = [{"name": f"Mapped object {slot + 1}", "value": 0} for slot in range(MAX_MAPPED)]
        tables.append({"index": base + 0x200 + number, "name": f"{word} PDO {number + 1} mapping", "kind": "record",
                       "home": "communication", "access": "rw", "type": "u32", "count_access": "rw",
                       "subs": slots} | level)
    return tables


def cob_id_default(cob_id: int) -> object:
    return f"$NODEID+0x{cob_id:X}" if cob_id & 0x7F == 0 and not cob_id & PDO_INVALID else cob_id
