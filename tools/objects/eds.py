"""From a node of the object table to its electronic data sheet (CiA 306)."""

from __future__ import annotations

import struct
from pathlib import PurePath

from kinds import Entry
from model import Node, Object

MANDATORY = (0x1000, 0x1001, 0x1018)
VAR, ARRAY, RECORD = 0x7, 0x8, 0x9
FIRST_OBJECT = 0x1000
FIRST_OF_MAKER, LAST_OF_MAKER = 0x2000, 0x5FFF
DUMMIES = range(1, 8)
# A comment: of a real number, python-canopen takes the digits that CiA 306 asks for as a whole number, and dcfchk
# refuses any other.
LIMITS = "; Limits"


def section(name: str, pairs: dict[str, object]) -> list[str]:
    return [f"[{name}]", *(f"{key}={value}" for key, value in pairs.items()), ""]


def file_info(node: Node) -> dict[str, object]:
    """Without dates of the day: the same table gives the same bytes."""
    return {
        "FileName": node.settings["eds"].split("/")[-1],
        "FileVersion": 1,
        "FileRevision": 1,
        "EDSVersion": "4.0",
        "Description": node.settings["about"],
        "CreationTime": "12:00PM",
        "CreationDate": "01-01-2024",
        "CreatedBy": "tools/objects/generate",
        "ModificationTime": "12:00PM",
        "ModificationDate": "01-01-2024",
        "ModifiedBy": "tools/objects/generate",
    }


def device_info(node: Node) -> dict[str, object]:
    settings = node.settings
    rates = {f"BaudRate_{rate}": int(rate == 500) for rate in (10, 20, 50, 125, 250, 500, 800, 1000)}
    return {
        "VendorName": "Tumble",
        "VendorNumber": f"0x{settings['vendor']:08X}",
        "ProductName": settings["device_name"],
        "ProductNumber": f"0x{settings['product']:08X}",
        "RevisionNumber": f"0x{settings['revision']:08X}",
        "OrderCode": PurePath(settings["eds"]).stem.removeprefix("tumble_"),
        **rates,
        "SimpleBootUpMaster": int(any(item.index == 0x1280 for item in node.objects)),
        "SimpleBootUpSlave": 1,
        "Granularity": 8,
        "DynamicChannelsSupported": 0,
        "GroupMessaging": 0,
        "NrOfRXPDO": len(node.receive),
        "NrOfTXPDO": len(node.transmit),
        "LSS_Supported": 0,
    }


def listing(name: str, objects: list[Object]) -> list[str]:
    numbered = {str(number + 1): f"0x{item.index:04X}" for number, item in enumerate(objects)}
    return section(name, {"SupportedObjects": len(objects)} | numbered)


def access_type(entry: Entry) -> str:
    """rww and rwr say which kind of PDO a variable may be mapped into."""
    if entry.home == "value" and entry.access in ("ro", "const"):
        return "const"
    if entry.access == "rw" and entry.map in ("receive", "transmit"):
        return {"receive": "rww", "transmit": "rwr"}[entry.map]
    return entry.access


def number(entry: Entry, value: object) -> str:
    """A real number as CiA 306 has it: the hexadecimal digits of its bits."""
    if entry.type.is_real:
        return f"0x{struct.pack('>d' if entry.size == 8 else '>f', float(value)).hex().upper()}"
    if isinstance(value, str):
        return value
    if entry.index < FIRST_OF_MAKER and entry.type.key == "u32":
        return f"0x{value:08X}"
    return str(int(value))


def variable(entry: Entry) -> dict[str, object]:
    pairs: dict[str, object] = {
        "ParameterName": entry.name,
        "ObjectType": f"0x{VAR:X}",
        "DataType": f"0x{entry.type.code:04X}",
        "AccessType": access_type(entry),
    }
    if entry.low is not None and entry.type.is_real:
        pairs[LIMITS] = f"{float(entry.low)!r} to {float(entry.high)!r}"
    elif entry.low is not None:
        pairs |= {"LowLimit": number(entry, entry.low), "HighLimit": number(entry, entry.high)}
    if entry.value is not None:
        pairs["DefaultValue"] = number(entry, entry.value)
    pairs["PDOMapping"] = int(entry.map is not None)
    return pairs


def sections_of(item: Object) -> list[str]:
    name = f"{item.index:04X}"
    if item.is_var:
        return section(name, variable(item.entries[0]))
    kind = ARRAY if item.kind == "array" else RECORD
    lines = section(
        name, {"ParameterName": item.name, "ObjectType": f"0x{kind:X}", "SubNumber": len(item.entries)}
    )
    for entry in item.entries:
        lines += section(f"{name}sub{entry.subindex:X}", variable(entry))
    return lines


def comments(node: Node) -> dict[str, object]:
    tables = [node.path.name, *([node.extension["table"]] if node.extension else [])]
    return {"Lines": 1, "Line1": f"Written from {' and '.join(f'tools/objects/{table}' for table in tables)}"}


def text(node: Node) -> str:
    objects = [item for item in node.objects if item.index >= FIRST_OBJECT]
    mandatory = [item for item in objects if item.index in MANDATORY]
    maker = [item for item in objects if FIRST_OF_MAKER <= item.index <= LAST_OF_MAKER]
    optional = [item for item in objects if item not in mandatory and item not in maker]
    dummies = {item.index for item in node.objects if item.index < FIRST_OBJECT}
    lines = section("FileInfo", file_info(node))
    lines += section("DeviceInfo", device_info(node))
    lines += section("DummyUsage", {f"Dummy{code:04X}": int(code in dummies) for code in DUMMIES})
    lines += section("Comments", comments(node))
    for name, group in (("Mandatory", mandatory), ("Optional", optional), ("Manufacturer", maker)):
        lines += listing(f"{name}Objects", group)
        for item in group:
            lines += sections_of(item)
    return "\n".join(lines)
