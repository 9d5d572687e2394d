"""How a result was found: method, stand, schedule, environment.

Who, what, where and when, as [item] and [environment] of the stand file tell it.

ISO/IEC 17025:2017, 7.8.2.1, asks for each of these; what nobody told is said to be "not stated". Labels that are none
of these are given as they are.
"""

from __future__ import annotations

from typing import TypeAlias

from tumble.report.source import MISSING, Facts, Fixed, Inline, Source, Table, aligned, joined, line
from tumble.solving.result import schedule_of
from tumble.stand import SOURCES
from tumble.units import noise_unit

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


_MEANING = {  # of a stand file's `limits`
    "sigma1": "standard deviations",
    "sigma3": "three standard deviations",
    "uniform": "half-widths of a uniform law",
}
_SEEN = {
    "alpha1_rad": "Axis tilt",
    "alpha2_plus_alpha3_rad": "Zero of the angle, and mean yaw",
    "alpha3_difference_rad": "Yaw of the first mounting less that of the second",
    "alpha4_rad": "Standard deviation of a set angle",
    "noise_v": "Standard deviation of one sample",
}


def method(source: Source) -> Facts:
    """What was done with the run, and by what."""
    difference = source.rounded(2, "reference", "max_abs_difference_K")
    schedule = source.told("schedule", "name")
    own = "a schedule of its own" if source.table("schedule") else MISSING
    rows = source.told("counters", "rows")
    places = source.told("counters", "positions")
    model = joined([Fixed("linear, twelve coefficients"), *source.each("extended", "terms")], ", ")
    return [
        (Fixed("Model"), model),
        (Fixed("Estimator"), source.told("estimator")),
        (Fixed("Computed by"), line("tumble ", source.told("tumble"))),
        (
            Fixed("Confirmed by"),
            line("a second, independent computation: K differs by ", difference, " ", unit_of_k(source)),
        ),
        (
            Fixed("Schedule"),
            line(own if schedule is MISSING else schedule, ": ", rows, " samples at ", places, " positions"),
        ),
        (Fixed("Unit of the outputs"), source.told("unit")),
    ]


def environment(source: Source) -> Facts:
    """Where and at what temperature."""
    low, high = source.told("temperature", "min_c"), source.told("temperature", "max_c")
    who = {"run_file": " (measured in the run)", "environment": " (as the stand file states)"}
    same = source.decimal("temperature", "min_c") == source.decimal("temperature", "max_c")
    span = low if same else line(low, " to ", high)
    temperature = line(span, " °C", who.get(str(source.at("temperature", "source")), ""))
    gravity, u = source.told("environment", "gravity_m_s2"), source.told("environment", "u_gravity_m_s2")
    return [
        (Fixed("Temperature of the run"), MISSING if low is MISSING else temperature),
        (Fixed("Pressure"), _with_unit(source.told("environment", "pressure_hpa"), "hPa")),
        (Fixed("Relative humidity"), _with_unit(source.told("environment", "humidity_percent"), "%")),
        (Fixed("Local gravity, g"), _with_unit(gravity, "m/s²")),
        (Fixed("Standard uncertainty of local gravity"), _with_unit(u, "m/s²")),
    ]


def declared(source: Source) -> tuple[Inline, Table] | None:
    """The stand as it is declared: what its numbers are, and these; None without one."""
    if not source.table("stand"):
        return None
    kind, schedule = str(source.at("stand", "limits")), schedule_of(source.solved, source.name)
    by_hand = schedule is not None and schedule.data.is_laid_by_hand
    about = line("Stand: ", source.told("stand", "name"), ". Its file declares ", _MEANING.get(kind, kind), ".")
    rows = [
        (Fixed(one.words), _by_channel(source, one.key), Fixed(_unit(source, one.key)))
        for one in SOURCES.values()  # what is not declared is 0 and left out, unless every rotary stand has it
        if _is_declared(source, one.key) or (one.required and not (by_hand and one.is_angle))
    ]
    return about, Table(("Source of error", "Declared", "Unit"), rows, left=(2,))


def _by_channel(source: Source, key: str) -> Inline:
    """An error of the stand: one number, or those of x, y and z."""
    if isinstance(source.at("stand", key), list):
        return joined(source.each("stand", key), ", ")
    return source.told("stand", key)


def _is_declared(source: Source, key: str) -> bool:
    if isinstance(source.at("stand", key), list):
        return any(source.decimal("stand", key, i) for i in range(3))
    return bool(source.decimal("stand", key))


def seen(source: Source) -> Table:
    """The stand as the run shows it, with standard uncertainties."""
    rows = []
    for key, name in _SEEN.items():
        if key == "noise_v" and source.array("stand_seen", "noise_v_by_channel"):
            rows += [_noise_of(source, name, channel) for channel in range(3)]
            continue
        value, u = source.with_uncertainty(("stand_seen", key), ("stand_seen", f"u_{key}"), None)
        if value is not MISSING:
            rows.append((Fixed(name), value, u, Fixed(_unit(source, key))))
    return Table(("As this run shows it", "Value", "u (k = 1)", "Unit"), aligned(rows, 1, 2), left=(3,))


def _noise_of(source: Source, name: str, channel: int) -> tuple[Inline, Inline, Inline, Inline]:
    """Of a channel, beside what the stand declares of it."""
    paths = [("stand_seen", f"{u}noise_v_by_channel", channel) for u in ("", "u_")]
    value, u = source.with_uncertainty(paths[0], paths[1], None)
    kind = str(source.at("stand", "limits"))
    meaning = "" if kind == "sigma1" else f" ({_MEANING.get(kind, kind)})"
    title = line(f"{name}, {'xyz'[channel]}; declared ", source.told("stand", "noise_v", channel), meaning)
    return title, value, u, Fixed(_unit(source, "noise_v"))


def unit_of_k(source: Source) -> Inline:
    """Of the elements of K."""
    return source.told("units", "K")


def _with_unit(said: Inline, unit: str) -> Inline:
    return said if said is MISSING else line(said, f" {unit}")


def _unit(source: Source, key: str) -> str:
    """Of an error of a stand, by the end of its key."""
    return "rad" if key.endswith("_rad") else noise_unit(str(source.at("unit")))
