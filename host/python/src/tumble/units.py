"""Units of a block's outputs: the volt, its multiples, and whatever a run file names. And how many digits a number in
them has beside its uncertainty or a limit."""

from __future__ import annotations

import math
import re

UNIT = re.compile(r"[A-Za-z0-9µΩ°%/^·._ +-]{1,16}")
SI = "m/s2"  # of accelerations, as --unit of apply and export have it
_PER_S2 = (
    r"[ *.\u00b7]*(/ ?(s|sec)( ?\*\* ?2| ?\^ ?\(?2\)?|2|\u00b2|/(s|sec))|(s|sec) ?\^? ?(-2|\(-2\)|\u207b\u00b2)|ps2)"
)
_SPELLINGS = {  # by the unit, patterns of what people write for it, brackets taken away where that changes nothing
    "m/s^2": rf"(?i:m(et(er|re)s?)?{_PER_S2})",
    "mm/s^2": rf"(?i:mm{_PER_S2})",
    "cm/s^2": rf"(?i:cm{_PER_S2}|gal)",
    "g": r"(?i:g|gee|gees|g[ _]?n|g[ _]?0|standard gravity)",
    "mg": r"(?i:mg|milli-?g)",
    "\u00b5g": r"\u03bcg|[u\u00b5\u03bc]G|(?i:micro-?g)",
    "V": r"(?i:v|volts?)( ?(?i:dc))?",
    "mV": r"(m[vV]|(?i:milli-?volts?))( ?(?i:dc))?",
    "\u00b5V": r"\u03bcV|(?i:micro-?volts?)",
    "counts": r"(?i:counts?)",
}
_PER_G = {"m/s^2": 9.81, "g": 1.0, "mg": 1000.0}  # what 1 g gives in units of acceleration
_LOOKS_LIKE = {  # and what says so; sensors of 1 V/g are common, of 9.81 V/g they are not
    "m/s^2": "m/s^2: --unit m/s^2",
    "g": "g, or volts of a sensor of 1 V/g: --unit g or V",
    "mg": "mg, or mV of a sensor of 1 V/g: --unit mg or mV",
}
ANOTHER_UNIT = "another unit (--unit)"
_NO_VOLTS = 100.0  # per g, no sensor gives
_ROUGHLY = 1.5  # a factor by which no scale of an accelerometer is off
_NEAR = 1.05  # of that, a factor: closer than most sensors come by chance
_VOLTS_PER_UNIT = {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "µV": 1e-6, "kV": 1e3}
_LEAST = 1e-3  # of an uncertainty without an exponent
_ALL_DIGITS = 17
_KNOWN_BESIDE_VOLTS = {**_PER_G, "ug": 1e6, "µg": 1e6, "mm/s^2": 9810.0, "cm/s^2": 981.0}


def is_unit(text: object) -> bool:
    """Can this be the name of a unit?"""
    return isinstance(text, str) and UNIT.fullmatch(text) is not None and text == text.strip()


def spelled(text: str) -> str:
    """A unit as Tumble writes it, of the several ways in which people do; one that is not known stays as it is."""
    bare = re.sub(r"\(([a-z]+(?:\^-?2|\u00b2|\*\*2|2))\)", r"\1", text)  # m/(s^2)
    return next((unit for unit, pattern in _SPELLINGS.items() if re.fullmatch(pattern, bare)), text)


def is_known(text: str) -> bool:
    """Is it a unit of voltage or acceleration, or counts, in whatever spelling?"""
    return spelled(text) == "counts" or _known(spelled(text)) is not None


def force_unit(text: object) -> object:
    """The unit of an acceleration, "g" or SI, in whatever spelling; what is neither stays as it is."""
    return SI if isinstance(text, str) and spelled(text) == "m/s^2" else text


def per_g_of(unit: str) -> float:
    """What 1 g gives in a unit of acceleration, roughly."""
    return _PER_G[spelled(unit)]


def looks_like(per_g: float) -> str | None:
    """What the unit of outputs may be, and the option that says so, where 1 g comes out as so much; None: any."""
    unit = _acceleration(per_g)
    if unit is None:
        return "counts of a converter: --unit counts" if per_g > _NO_VOLTS else None
    return _LOOKS_LIKE[unit]


def contradicts(per_g: float, unit: str) -> str | None:
    """The unit that outputs look to be in, as "m/s^2 (--unit m/s^2)", where they are told to be in another `unit` of
    acceleration and 1 g comes out as so much; None where nothing speaks against it."""
    if unit not in _KNOWN_BESIDE_VOLTS or _is_roughly(per_g, _KNOWN_BESIDE_VOLTS[unit]):
        return None
    seen = next((other for other, size in _KNOWN_BESIDE_VOLTS.items() if _is_roughly(per_g, size)), None)
    return f"{seen} (--unit {seen})" if seen else ANOTHER_UNIT


def looks_as_applied(length_g: float, unit: str) -> str | None:
    """The unit that data look to be in, where a result for outputs in `unit` makes rests of this length of them; None:
    none that is known."""
    sizes = {other: volts_per(unit) / size for other, size in _VOLTS_PER_UNIT.items()}
    if unit not in _VOLTS_PER_UNIT:
        sizes = {other: size / _PER_G[unit] for other, size in _PER_G.items()} if unit in _PER_G else {}
    return next((other for other, size in sizes.items() if size / _NEAR < length_g < size * _NEAR), None)


def _is_roughly(per_g: float, size: float) -> bool:
    return size / _ROUGHLY < per_g < size * _ROUGHLY


def _acceleration(per_g: float) -> str | None:
    return next((unit for unit, size in _PER_G.items() if size / _NEAR < per_g < size * _NEAR), None)


def are_at_odds(one: str, other: str) -> bool:
    """Are these two units that are known, and not the same?"""
    return _known(one) is not None and _known(other) is not None and _known(one) != _known(other)


def _known(unit: str) -> tuple[str, float] | None:
    """What a unit measures, and its size; None for a name that may be anything."""
    if unit in _VOLTS_PER_UNIT:
        return "voltage", _VOLTS_PER_UNIT[unit]
    return ("acceleration", _KNOWN_BESIDE_VOLTS[unit]) if unit in _KNOWN_BESIDE_VOLTS else None


def volts_per(unit: str) -> float:
    """Size in volts of a unit of the outputs; 1 for a unit that is no multiple of the volt, which takes the volt's
    place in the stand file and in the result."""
    return _VOLTS_PER_UNIT.get(unit, 1.0)


def unit_of(volts: float) -> str | None:
    """The unit of this size; None where the volt has no such multiple."""
    return next((unit for unit, size in _VOLTS_PER_UNIT.items() if math.isclose(size, volts)), None)


def noise_unit(unit: str) -> str:
    """The unit that noise is declared and reported in, for outputs in `unit`."""
    return "V" if unit in _VOLTS_PER_UNIT else unit


def per_g(unit: str) -> str:
    """The unit of K for outputs in `unit`."""
    return f"({unit})/g" if "/" in unit else f"{unit}/g"


def per_m_s2(unit: str) -> str:
    """The same for an acceleration in m/s^2."""
    return f"({unit})/(m/s^2)" if "/" in unit else f"{unit}/(m/s^2)"


def rounded(size: float, u: float | None) -> tuple[str, str]:
    """A number and its standard uncertainty, both to the second digit of this; "-" for one that is unknown."""
    if u is None or u == 0.0:
        return f"{size:+.3g}", "-" if u is None else "0"
    if u < _LEAST:
        finest = math.floor(math.log10(u)) - 1
        digits = max(0, math.floor(math.log10(abs(size))) - finest) if size else 0
        return f"{size:+.{digits}e}", f"{u:.1e}"
    places = max(0, 1 - math.floor(math.log10(u)))
    return f"{size:+.{places}f}", f"{u:.{places}f}"


def on_its_side(value: float, other: float, digits: int = 2) -> str:
    """A number with so many digits, or more until it is above, at or below the other one as it is in full."""
    for count in range(digits, _ALL_DIGITS):
        text = f"{value:.{count}g}"
        if (float(text) > other, float(text) < other) == (value > other, value < other):
            return text
    return f"{value:.{_ALL_DIGITS}g}"
