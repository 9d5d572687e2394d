"""Who, what, where and when, as [item] and [environment] of the stand file tell it.

ISO/IEC 17025:2017, 7.8.2.1, asks for each of these; what nobody told is said to be "not stated". Labels that are none
of these are given as they are.
"""

from __future__ import annotations

from typing import TypeAlias

from tumble.report.cells import MISSING, Facts, Fixed, Inline, joined
from tumble.report.source import Source

Names: TypeAlias = "dict[str, tuple[str, ...]]"

OF_THE_ITEM: tuple[str, ...] = ("item",)  # a serial number of the environment is that of a thermometer
TABLES: tuple[str, ...] = (*OF_THE_ITEM, "environment")
_SERIAL = "Serial number"
AUTHORISED, ISSUED = "Authorised by", "Date of issue"
PARTIES: Names = {
    "Customer": ("customer",),
    "Contact of the customer": ("contact", "customer_address"),
    "Laboratory": ("laboratory", "lab"),
    "Address of the laboratory": ("laboratory_address",),
    "Place of the calibration": ("location", "place"),
    "Measured by": ("operator",),
    AUTHORISED: ("authorised_by", "authorized_by"),
}
ITEM: Names = {
    "Item": ("description", "item", "name"),
    "Manufacturer": ("manufacturer",),
    "Type": ("type", "model"),
    _SERIAL: ("serial", "serial_number"),
    "Condition": ("condition",),
    "Received": ("received",),
}
DATES: Names = {"Date of the run": ("date", "run_date")}
TRACEABILITY: Names = {
    "Traceability of local gravity": ("gravity_traceability",),
    "Traceability of the table angle": ("angle_traceability",),
    "Traceability of the outputs' unit": ("voltage_traceability", "output_traceability"),
}
DEVIATIONS: Names = {"Deviations from the method": ("deviations",)}
_NUMBERS = {  # which the section on the method has
    ("environment", key)
    for key in ("gravity_m_s2", "u_gravity_m_s2", "temperature_c", "pressure_hpa", "humidity_percent")
}


def parties(source: Source) -> Facts:
    """Customer and laboratory."""
    return _facts(source, PARTIES)


def item(source: Source) -> Facts:
    """What was calibrated, its condition. The serial number is that of [block], and what the labels say beside it."""
    serial, labelled = source.at("serial"), _labels(source, ITEM[_SERIAL], OF_THE_ITEM)
    others = [source.told(*path) for path in labelled if source.at(*path) != serial]
    both = _listed([*([] if serial is None else [source.told("serial")]), *others])
    return [(name, both if name == Fixed(_SERIAL) else said) for name, said in _facts(source, ITEM, OF_THE_ITEM)]


def dates(source: Source, issued: Inline) -> Facts:
    """Of the run, of its result, of the report."""
    computed = (Fixed("Result computed (UTC)"), source.told("created"))
    return [*_facts(source, DATES), computed, (Fixed(ISSUED), issued)]


def issue(source: Source, issued: Inline) -> Facts:
    """What stands above the place to sign; who authorises may as well sign alone."""
    by = _labels(source, PARTIES[AUTHORISED], TABLES)
    authorised = [(Fixed(AUTHORISED), _listed([source.told(*path) for path in by]))] if by else []
    return [(Fixed(ISSUED), issued), *authorised]


def traceability(source: Source) -> Facts:
    """Of the references that the coefficients are expressed by."""
    return _facts(source, TRACEABILITY)


def deviations(source: Source) -> Facts:
    """From the method."""
    return _facts(source, DEVIATIONS)


def further_labels(source: Source) -> Facts:
    """Those of no other section, by their own names."""
    sections = [(names, TABLES) for names in (PARTIES, DATES, TRACEABILITY, DEVIATIONS)]
    sections.append((ITEM, OF_THE_ITEM))
    known = {(table, key) for names, tables in sections for table in tables for keys in names.values() for key in keys}
    return [
        (Fixed(key), source.told(table, key))
        for table in TABLES
        for key in source.table(table)
        if (table, _plain(key)) not in known and (table, key) not in _NUMBERS
    ]


def _facts(source: Source, names: Names, tables: tuple[str, ...] = TABLES) -> Facts:
    return [
        (Fixed(name), _listed([source.told(*path) for path in _labels(source, keys, tables)]))
        for name, keys in names.items()
    ]


def _labels(source: Source, keys: tuple[str, ...], tables: tuple[str, ...]) -> list[tuple[str, str]]:
    """Where labels of these names are, by table and key: the first name first, and of each [item] first."""
    return [(table, key) for wanted in keys for table in tables for key in source.table(table) if _plain(key) == wanted]


def _listed(said: list[Inline]) -> Inline:
    return joined(said, "; ") if said else MISSING


def _plain(key: str) -> str:
    """A label's name, however it is spelled: "Serial number" is serial_number."""
    return key.strip().lower().replace(" ", "_").replace("-", "_")
