"""The sections of a report, from a result's document.

Labels: who, what, where and when, as [item] and [environment] of the stand file tell it. ISO/IEC 17025:2017, 7.8.2.1,
asks for each of these; what nobody told is said to be "not stated". Labels that are none of these are given as they
are. Then how the result was found: method, stand, schedule, environment.

Values: twelve coefficients, further terms of the model, intrinsic parameters, each with its uncertainty.

Conformity: the verdict, the rule that it follows, and what it rests on (ISO/IEC 17025:2017, 7.8.6).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from tumble.estimators import COEFFICIENTS
from tumble.files.stand_file import SERIALS, plain_key
from tumble.model.reliability import description_of
from tumble.model.stand_seen import NAMES
from tumble.report.pages import NUMBER
from tumble.report.source import (
    MISSING,
    NO_UNCERTAINTY,
    NU,
    STANDARD_GRAVITY,
    DocumentSource,
    Factor,
    Facts,
    Fixed,
    Inline,
    Number,
    Path,
    Shown,
    Source,
    Table,
    aligned,
    joined,
    line,
    plain,
    pointer,
    rounded,
    to_places,
)
from tumble.solving.decision import ASSUMPTIONS, UNCERTAINTY, Decision, marks, remedies_text
from tumble.solving.result import schedule_of
from tumble.solving.uncertainty import HANDS, NEARLY_INFINITE
from tumble.stand import SOURCES
from tumble.terms import ASYMMETRY, CROSS, KEYS, expanded, names
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
    _SERIAL: SERIALS,
    "Condition": ("condition",),
    "Received": ("received",),
}
DATES: Names = {"Date of the run": ("date", "run_date")}
TRACEABILITY: Names = {
    "Metrological traceability of local gravity": ("gravity_traceability",),
    "Metrological traceability of the table angle": ("angle_traceability",),
    "Metrological traceability of the outputs' unit": ("voltage_traceability", "output_traceability"),
}
DEVIATIONS: Names = {"Deviations from the method": ("deviations",)}
_IN_THE_HEAD: Names = {"Number": (NUMBER,)}
_NUMBERS = {  # which the section on the method has
    ("environment", key)
    for key in ("gravity_m_s2", "u_gravity_m_s2", "temperature_c", "pressure_hpa", "humidity_percent")
}


def facts(source: DocumentSource, names: Names, tables: tuple[str, ...] = TABLES) -> Facts:
    """What labels tell, by what a report calls them."""
    return [
        (Fixed(name), _listed([source.told(*path) for path in _labels(source, keys, tables)]))
        for name, keys in names.items()
    ]


def item(source: DocumentSource) -> Facts:
    """What was calibrated, its condition. The serial number is that of [block], and what the labels say beside it."""
    serial, labelled = source.at("serial"), _labels(source, ITEM[_SERIAL], OF_THE_ITEM)
    others = [source.told(*path) for path in labelled if source.at(*path) != serial]
    both = _listed([*([] if serial is None else [source.told("serial")]), *others])
    return [(name, both if name == Fixed(_SERIAL) else said) for name, said in facts(source, ITEM, OF_THE_ITEM)]


def dates(source: DocumentSource, issued: Inline) -> Facts:
    """Of the run, of its result, of the report."""
    computed = (Fixed("Result computed (UTC)"), source.told("created"))
    return [*facts(source, DATES), computed, (Fixed(ISSUED), issued)]


def issue(source: DocumentSource, issued: Inline) -> Facts:
    """What stands above the place to sign; who authorises may as well sign alone."""
    by = _labels(source, PARTIES[AUTHORISED], TABLES)
    authorised = [(Fixed(AUTHORISED), _listed([source.told(*path) for path in by]))] if by else []
    return [(Fixed(ISSUED), issued), *authorised]


def further_labels(source: DocumentSource) -> Facts:
    """Those of no other section, by their own names."""
    sections = [(names, TABLES) for names in (PARTIES, DATES, TRACEABILITY, DEVIATIONS, _IN_THE_HEAD)]
    sections.append((ITEM, OF_THE_ITEM))
    known = {(table, key) for names, tables in sections for table in tables for keys in names.values() for key in keys}
    return [
        (Fixed(key), source.told(table, key))
        for table in TABLES
        for key in source.table(table)
        if (table, plain_key(key)) not in known and (table, key) not in _NUMBERS
    ]


def _labels(source: DocumentSource, keys: tuple[str, ...], tables: tuple[str, ...]) -> list[tuple[str, str]]:
    """Where labels of these names are, by table and key: the first name first, and of each [item] first."""
    return [
        (table, key) for wanted in keys for table in tables for key in source.table(table) if plain_key(key) == wanted
    ]


def _listed(said: list[Inline]) -> Inline:
    return joined(said, "; ") if said else MISSING


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


def environment(source: DocumentSource) -> Facts:
    """Where and at what temperature."""
    low, high = source.told("temperature", "min_c"), source.told("temperature", "max_c")
    who = {"run_file": " (measured in the run)", "environment": " (as the stand file states)"}
    same = source.decimal("temperature", "min_c") == source.decimal("temperature", "max_c")
    span = low if same else line(low, " to ", high)
    temperature = line(span, " °C", who.get(str(source.at("temperature", "source")), ""))
    return [(Fixed("Temperature of the run"), MISSING if low is MISSING else temperature), *conditions(source)]


def conditions(source: DocumentSource) -> Facts:
    """Where, but for the temperature."""
    gravity, u = source.told("environment", "gravity_m_s2"), source.told("environment", "u_gravity_m_s2")
    return [
        (Fixed("Pressure"), _with_unit(source.told("environment", "pressure_hpa"), "hPa")),
        (Fixed("Relative humidity"), _with_unit(source.told("environment", "humidity_percent"), "%")),
        (Fixed("Local gravity, g"), _with_unit(gravity, "m/s²")),
        (Fixed("Standard uncertainty of local gravity"), _with_unit(u, "m/s²")),
    ]


def declared(source: Source) -> tuple[Inline, Table] | None:
    """The stand as it is declared: what its numbers are, and these; None without one."""
    schedule = schedule_of(source.solved, source.name) if source.table("stand") else None
    return declared_stand(source, schedule is not None and schedule.data.is_laid_by_hand)


def declared_stand(source: DocumentSource, by_hand: bool) -> tuple[Inline, Table] | None:
    """The same; `by_hand`: the block was laid by hand, without a rotary stand."""
    if not source.table("stand"):
        return None
    kind = str(source.at("stand", "limits"))
    about = line("Stand: ", source.told("stand", "name"), ". Its file declares ", _MEANING.get(kind, kind), ".")
    left = _LEFT if source.table("set_angles") else ()
    if left:
        about = line(about, " Set angles and zero: what the table of set angles leaves of them.")
    rows = []
    for one in SOURCES.values():  # what is not declared is 0 and left out, unless every rotary stand has it
        by_channel = isinstance(source.at("stand", one.key), list)
        places = [("stand", one.key, i) for i in range(3)] if by_channel else [("stand", one.key)]
        if any(source.decimal(*place) for place in places) or (one.required and not (by_hand and one.is_angle)):
            size = joined([source.rounded(3, *at) if one.key in left else source.told(*at) for at in places], ", ")
            rows.append((Fixed(one.words), size, Fixed(_unit(source, one.key))))
    return about, Table(("Source of error", "Declared", "Unit"), rows, left=(2,))


def seen(source: Source) -> Table:
    """The stand as the run shows it, with standard uncertainties."""
    rows: list[tuple[Inline, ...]] = []
    kind = str(source.at("stand", "limits"))
    meaning = "" if kind == "sigma1" else f" ({_MEANING.get(kind, kind)})"
    for key, name in _SEEN.items():
        unit, at = Fixed(_unit(source, key)), ("stand_seen", key)
        if key == "noise_v" and source.array("stand_seen", "noise_v_by_channel"):
            for i, axis in enumerate("xyz"):  # beside what the stand declares of each
                title = line(f"{name}, {axis}; declared ", source.told("stand", "noise_v", i), meaning)
                paths = [("stand_seen", f"{u}noise_v_by_channel", i) for u in ("", "u_")]
                rows.append((title, *source.with_uncertainty(paths[0], paths[1], None), unit))
        elif source.at(*at) is not None:
            value, u = source.with_uncertainty(at, ("stand_seen", f"u_{key}"), None)
            rows.append((Fixed(name), value, u, unit))
    schedule = schedule_of(source.solved, source.name)
    set_at = {} if schedule is None else {one.number: one.tilt_deg for one in schedule.data.mountings}
    for i, one in enumerate(source.array("inclinations")):
        number = one["mounting"]
        told = f"Inclination {number}" + (f"; set to {set_at[number]:g}" if number in set_at else "")
        value, u = source.with_uncertainty(("inclinations", i, "deg"), ("inclinations", i, "u_deg"), None)
        rows.append((Fixed(told), value, u, Fixed("deg")))
    return Table(("As this run shows it", "Value", "u (k = 1)", "Unit"), aligned(rows, 1, 2), left=(3,))


def unit_of_k(source: Source) -> Inline:
    """Of the elements of K."""
    return source.told("units", "K")


def _with_unit(said: Inline, unit: str) -> Inline:
    return said if said is MISSING else line(said, f" {unit}")


def _unit(source: DocumentSource, key: str) -> str:
    """Of an error of a stand, by the end of its key."""
    return "rad" if key.endswith("_rad") else noise_unit(str(source.at("unit")))


_LEFT = ("angle_rad", "level_rad")  # computed where set angles are corrected
_TWO_DIGITS, _THREE_DIGITS = partial(rounded, digits=2), partial(rounded, digits=3)
_MANY = 1000
_STUDENT = f" k is Student's t for {NU} effective degrees of freedom (Welch and Satterthwaite)."
_NO_GAIN = (
    " U contains no uncertainty of the measurement of the outputs, by voltmeter or converter: a gain error common to"
    " all channels changes K and U0 in the same ratio, and cancels in |a| and in the bias in g."
)
_DENIED = " But the run does not fit the declared stand, so that U may be too small."
_UNITS_OF_TERMS = {"k2": "g\u207b¹", "k3": "g\u207b²", ASYMMETRY: "1", CROSS: "g\u207b¹"}
_INTRINSIC: dict[str, tuple[Path, str, tuple[Path, Path] | None]] = {  # name: path within its tables, unit; "": that
    # of K; path in SI
    **{f"Scale {axis}": (("scale", i), "", (("scale", i), ("u_scale", i))) for i, axis in enumerate("xyz")},
    **{f"Angle {pair}": (("angle_rad", pair), "rad", None) for pair in ("xy", "xz", "yz")},
    **{f"Bias {axis}": (("bias_g", i), "g", (("bias", i), ("u_bias", i))) for i, axis in enumerate("xyz")},
}


@dataclass(frozen=True)
class Uncertainties:
    """Where a document has them: standard ones of K and U0 beneath `table`, factors k beneath "coverage", if `has_k`.
    `about`: what they are, to stand above the table."""

    table: Path
    has_k: bool
    about: Inline


def uncertainties(source: Source) -> Uncertainties:
    """Those of a declared stand, else those of the noise alone."""
    table: Path = () if source.array("u_K") else ("scatter_alone",) if source.table("scatter_alone") else ()
    has_k = bool(source.table("coverage"))
    if not source.array(*table, "u_K"):
        return Uncertainties(table, False, line("The values have no uncertainty: no stand is declared."))
    if table:
        return Uncertainties(table, has_k, _of_noise(source, has_k))
    if not has_k:
        return Uncertainties(table, has_k, Fixed("u are standard uncertainties (k = 1); no coverage factor is stated."))
    percent, factor = source.scaled(("coverage", "probability"), plain, power=2), coverage_factor(source)
    denied = _DENIED if source.table("fit") and not source.at("fit", "fits") else ""
    times = line("U = k u is the standard uncertainty multiplied by k", factor)
    covers = line(", which corresponds to a coverage probability of ", percent, " %.")
    return Uncertainties(table, has_k, line(times, covers, denied, _STUDENT, _NO_GAIN))


def coverage_factor(source: Source) -> Inline:
    """Behind "k" of the twelve coefficients: its value, or the smallest and the largest."""
    places = [("coverage", "k_K", *divmod(i, 3)) if i < 9 else ("coverage", "k_U0", i - 9) for i in range(12)]
    told = sorted((factor, place) for place in places if (factor := source.decimal(*place)) is not None)
    if not told:
        return Fixed("")
    least, most = (source.to_places(2, *place) for _, place in (told[0], told[-1]))
    is_one = to_places(told[0][0], 2) == to_places(told[-1][0], 2)
    return line(" = ", most) if is_one else line(" from ", least, " to ", most)


def _of_noise(source: Source, has_k: bool) -> Inline:
    """What uncertainties by noise alone say, and what they do not: nothing is claimed of the true value."""
    probability = source.told("coverage", "probability")
    factor = line("U = k u, with the coverage factor k", coverage_factor(source))
    moved = line(
        factor, ": noise by itself moves a value by at most U with a probability of ", probability, ".", _STUDENT
    )
    symbol = "U" if has_k else "u"
    only = (
        f" {symbol} contains the noise of the samples only: no stand is declared, so that its errors are NOT in"
        f" {symbol}, and {symbol} does not say how near a value is to the true one. {HANDS}"
    )
    return line(moved if has_k else "u (k = 1) are standard deviations.", only)


def coefficients(source: Source, given: Uncertainties) -> Table:
    """K row by row, and U0. A mark behind a name: it rests on an assumption that touches only some."""
    rows = []
    marked = marks(source.table("assumed_for"))
    for place, name in enumerate(COEFFICIENTS):
        at: Path = ("K", *divmod(place, 3)) if place < 9 else ("U0", place - 9)
        unit, twin = unit_of_k(source) if place < 9 else source.told("unit"), (f"u_{at[0]}", *at[1:])
        in_si = (at, twin) if place < 9 else None
        rows.append(_row(source, name + marked.get(name, ""), at, (*given.table, *twin), in_si, unit, given))
    return _table(source, rows, given)


def intrinsic(source: Source, given: Uncertainties) -> Table:
    """Lengths of K's rows, angles between them, biases in g: they do not depend on how the block sits."""
    rows = []
    given = replace(given, has_k=given.has_k and bool(source.table("u_intrinsic")))
    for name, (at, unit, in_si) in _INTRINSIC.items():
        said = Fixed(unit) if unit else unit_of_k(source)
        rows.append(_row(source, name, ("intrinsic", *at), ("u_intrinsic", *at), in_si, said, given))
    return _table(source, rows, given)


def further(source: Source) -> Table | None:
    """K2, K3, drift and so on, with standard uncertainties; None where the model has none."""
    rows = []
    for term in (term for term in KEYS if term in source.array("extended", "terms")):
        unit = _UNITS_OF_TERMS.get(term) or noise_unit(str(source.at("unit")))
        for i, label in enumerate(names(expanded((term,)))):
            value, u = source.with_uncertainty(("extended", KEYS[term], i), ("extended", f"u_{KEYS[term]}", i), None)
            rows.append((Fixed(label), value, u, Fixed(unit)))
    return Table(("", "Value", "u (k = 1)", "Unit"), aligned(rows, 1, 2), left=(3,)) if rows else None


def worst_norm(source: Source) -> Inline:
    """Of the length of the calibrated acceleration."""
    at = ("u_norm_g", "worst_g")
    worst, in_si = source.scaled(at, _TWO_DIGITS, power=6), source.scaled(at, _TWO_DIGITS, source.gravity, power=3)
    return NO_UNCERTAINTY if worst is MISSING else line(worst, " µg = ", in_si, " mm/s²")


def _row(
    source: Source,
    name: str,
    value: Path,
    u: Path,
    in_si: tuple[Path, Path] | None,
    unit: Inline,
    given: Uncertainties,
) -> tuple[Inline, ...]:
    """Of one value, by the paths of it and of its standard uncertainty, and of the same in m/s^2: None for what has no
    g in its unit."""
    k, freedom = (("coverage", f"{what}_{value[0]}", *value[1:]) for what in ("k", "freedom"))
    factor = k if given.has_k else None
    told: tuple[Inline, ...] = (Fixed(name), *source.with_uncertainty(value, u, factor), unit)
    if source.table("si") and in_si is None:
        told += (Fixed(""), Fixed(""), Fixed(""))
    elif source.table("si") and in_si is not None:
        of_si = source.told("si", "units", "bias" if in_si[0][0] == "bias" else "K")
        told += (*source.with_uncertainty(("si", *in_si[0]), ("si", *in_si[1]), factor), of_si)
    return (*told, source.to_places(2, *k), _freedom(source, freedom)) if given.has_k else told


def _freedom(source: Source, path: Path) -> Inline:
    """Degrees of freedom, whole ones where they are many; null is infinitely many, and so is what differs from it in
    no digit that is printed."""
    found = source.decimal(*path)
    is_infinite = found is None and source.at(*path[:2]) is not None
    if is_infinite or (found is not None and found > NEARLY_INFINITE):
        return Number(Shown("\u221e"), pointer(path))
    return source.rounded(3, *path) if found is None or found < _MANY else source.to_places(0, *path)


def _table(source: Source, rows: list[tuple[Inline, ...]], given: Uncertainties) -> Table:
    symbol, has_si = "U = k u" if given.has_k else "u (k = 1)", bool(source.table("si"))
    head: tuple[str, ...] = ("", "Value", symbol, "Unit")
    head += ("Value, SI", symbol, "Unit") if has_si else ()
    aligned_rows = aligned(rows, 1, 2, 4, 5) if has_si else aligned(rows, 1, 2)
    return Table((*head, "k", NU) if given.has_k else head, aligned_rows, left=(3, 6) if has_si else (3,))


_MICRO = 6
_MOST_UNSEEN = 6  # of the causes that cost most
_OLDER = "the result is older than the rule of the uncertainty"
_AS_THEY_ARE = "Numbers are compared before they are rounded."


@dataclass(frozen=True)
class Verdict:
    """`word`: PASS, NOT SHOWN or FAIL; `phrase`: what stands behind it."""

    word: str
    phrase: Inline


def verdict(source: Source) -> Verdict:
    """The decision, as on a terminal."""
    decision = Decision.of(source.solved)
    rest = remedies_text(source.solved.would_show or (), decision.limit_g)
    return Verdict(decision.word, Fixed(f"{decision.reason}. {rest}." if rest else decision.reason))


def findings(source: Source) -> Facts:
    """The three things that are judged, and how they came out; the unit in which they are told."""
    check = ("verification",)
    in_si = source.scaled((*check, "limit_g"), _THREE_DIGITS, source.gravity, power=3)
    limit = line(source.millionths(None, *check, "limit_g"), " µg = ", in_si, " mm/s²")
    largest = _largest(source)
    gravity = "passed" if source.at(*check, "pass") else "FAILED"
    local = source.rounded(3, "environment", "gravity_m_s2")
    micro_g = Fixed("which is not stated") if local is MISSING else line(local, " µm/s²")
    corrected = [(Fixed("Set angles"), set_angles(source))] if source.table("set_angles") else []
    prior = [(Fixed("Last calibration of the block"), _prior(source))] if source.table("prior") else []
    return [
        (Fixed("Gravity check"), line(gravity, ": largest |Δg| ", largest, ", limit ", limit)),
        (Fixed("Fit to the declared stand"), _fit(source)),
        (Fixed("Uncertainty at every attitude"), _uncertainty(source)),
        *corrected,
        *prior,
        (Fixed("One µg here"), line("a millionth of the local gravity, ", micro_g)),
    ]


def _largest(source: Source) -> Inline:
    """The largest error of gravity with its uncertainty, and at which position it is."""
    errors = [
        source.decimal("verification", "delta_g_g", i, "delta_g_g")
        for i in range(len(source.array("verification", "delta_g_g")))
    ]
    known = [(abs(error), place) for place, error in enumerate(errors) if error is not None]
    size: Path = ("verification", "max_abs_delta_g_g")
    if not known:
        return line(source.scaled(size, _THREE_DIGITS, power=6), " µg")
    place = max(known)[1]
    shown, u = _delta_g(source, size, place)
    certain = Fixed(", no uncertainty") if u is NO_UNCERTAINTY else line(" (U = ", u, " µg)")
    return line(shown, " µg", certain, " at ", _label(source, place))


def _delta_g(source: Source, value: Path, place: int, *times: Factor, power: int = _MICRO) -> tuple[Inline, Inline]:
    """Errors of gravity in millionths of g, or in another unit: `value`, and U at this place."""
    at: Path = ("verification", "delta_g_g", place)
    return source.with_uncertainty(value, (*at, "u_delta_g_g"), (*at, "k_delta_g"), *times, power=power, digits=3)


def _label(source: Source, place: int) -> Inline:
    """Of a measured position, such as 2.7."""
    at = ("verification", "delta_g_g", place)
    return line(source.told(*at, "mounting"), ".", source.told(*at, "position"))


def _fit(source: Source) -> Inline:
    if not source.table("fit"):
        return Fixed("not judged: no stand is declared")
    word = "fits" if source.at("fit", "fits") else "DOES NOT FIT"
    chi2, dof = source.rounded(3, "fit", "chi2"), source.told("fit", "dof")
    p, confidence = source.rounded(2, "fit", "p"), source.told("fit", "confidence")
    return line(word, ": χ² ", chi2, " with ", dof, " degrees of freedom, p ", p, "; confidence ", confidence)


def set_angles(source: DocumentSource) -> Inline:
    """By which table they were corrected."""
    learned = line("corrected by the table of ", source.told("set_angles", "learned"), ", learnt from ")
    expires = line(source.told("set_angles", "runs"), " runs, which expires on ", source.told("set_angles", "expires"))
    u = source.scaled(("set_angles", "u_rad"), _THREE_DIGITS, power=6)
    return line(learned, expires, "; u of its marks at most ", u, " µrad")


def _prior(source: Source) -> Inline:
    """Whether the run agrees with it, and what it is worth."""
    chi2, dof, p = source.rounded(3, "prior", "chi2"), source.told("prior", "dof"), source.rounded(2, "prior", "p")
    test = line(": χ² ", chi2, " with ", dof, " degrees of freedom, p ", p)
    of = line(", of ", source.told("prior", "created"), ", ", source.rounded(3, "prior", "days"), " days earlier")
    if not source.at("prior", "used"):
        return line("the run does NOT AGREE with it", of, test, "; the result is that of the run alone")
    worth = source.millionths(_places(source), "prior", "u_norm_worst_alone_g")
    return line("used", of, test, "; by it alone the worst u(|a|) is ", worth, " µg")


def _uncertainty(source: Source) -> Inline:
    """Of |a|, against the limit."""
    worst = source.decimal("u_norm_g", "worst_g")
    if worst is None:
        return Fixed("not judged: no stand is declared")
    u = line(source.millionths(_places(source), "u_norm_g", "worst_g"), " µg")
    if not source.table("decision"):
        return line(f"not judged: {_OLDER}. The worst u(|a|) is ", u)
    decision = Decision.of(source.solved)
    word = "within the limit" if UNCERTAINTY not in decision.failures else "NOT SHOWN to be within the limit"
    factor = source.told("decision", "coverage_factor")
    return line(word, ": the worst u(|a|) is ", u, ", which the decision rule takes times ", factor)


def _places(source: Source) -> int:
    """Digits behind the point of a micro-g, for four significant ones of the limit."""
    limit = source.decimal("verification", "limit_g")
    return 1 if not limit else max(0, 3 - (limit.adjusted() + _MICRO))


def rule(source: Source) -> Inline:
    """The decision rule in words."""
    gravity = (
        "PASS where |Δg| = |(|a|² - 1)/2| is at most the limit at every measured position (simple acceptance: no guard"
        " band)"
    )
    if not source.table("fit"):
        return Fixed(f"{gravity}. No stand is declared: nothing is stated of other attitudes. {_AS_THEY_ARE}")
    factor = Decision.of(source.solved).coverage_factor
    stand = "the residuals fit the declared stand (chi-squared, at the confidence given)"
    if not source.table("decision"):
        return Fixed(f"{gravity}, and {stand}. Nothing is stated of other attitudes: {_OLDER}. {_AS_THEY_ARE}")
    return Fixed(
        f"{gravity}, {stand}, and {factor:g} times the standard uncertainty of |a| is at most the limit at every"
        " attitude. Where only the last does not hold, conformity is not shown, which is no PASS. That uncertainty"
        f" counts the errors of the declared stand alone. {_AS_THEY_ARE}"
    )


def positions(source: Source) -> Table:
    """Every measured position: samples, error of gravity with its uncertainty, whether it is within the limit."""
    rows: list[tuple[Inline, ...]] = []
    limit = source.decimal("verification", "limit_g")
    for i in range(len(source.array("verification", "delta_g_g"))):
        at: Path = ("verification", "delta_g_g", i)
        delta_g = source.decimal(*at, "delta_g_g")
        within = limit is None or delta_g is None or abs(delta_g) <= limit
        in_g = _delta_g(source, (*at, "delta_g_g"), i)
        in_si = _delta_g(source, (*at, "delta_g_g"), i, source.gravity, power=3)
        samples, k = source.told("means", i, "samples"), source.to_places(2, *at, "k_delta_g")
        told = (_label(source, i), source.told(*at, "use"), samples, *in_g, *in_si, k)
        rows.append((*told, Fixed("yes" if within else "NO")))
    si = ("Δg, mm/s²", "U, mm/s²", "k", "Within limit")
    head: tuple[str, ...] = ("Position", "Use", "Samples", "Δg, µg", "U, µg", *si)
    if all(row[4] is NO_UNCERTAINTY for row in rows):
        head, rows = (*head[:6], head[8]), [(*row[:6], row[8]) for row in rows]
    last = len(head) - 1
    return Table(head, aligned(rows, *range(3, min(last, 7))), left=(1, last))


def about_positions(source: Source) -> Inline:
    """What the columns of `positions` mean."""
    u = "U = k u is the expanded uncertainty of Δg with the coverage factor k, by the noise of the position's mean: no"
    why = " error of the stand changes the length of gravity. "
    known = source.decimal("verification", "delta_g_g", 0, "u_delta_g_g") is not None
    told = Fixed(u + why if known else "The noise of the samples is not known: Δg has no uncertainty. ")
    return line(told, gravity(source))


def gravity(source: Source) -> Inline:
    """By what g is expressed in m/s^2."""
    local = source.told("environment", "gravity_m_s2")
    if local is MISSING:
        return Fixed(f"mm/s² are by standard gravity, {STANDARD_GRAVITY} m/s²: the local one is not stated.")
    return line("mm/s² are by the local gravity, ", local, " m/s².")


def assumptions(source: DocumentSource) -> Facts:
    """What the result rests on that nobody tested, and the coefficients that do."""
    rows: Facts = []
    for i, name in enumerate(source.array("assumes")):
        known = ASSUMPTIONS.get(str(name))
        whose = joined(source.each("assumed_for", str(name)) or [Fixed("all")], ", ")
        what = f"{known.phrase}: {known.why}. " if known else ""
        mark = f"{known.mark} " if known and source.array("assumed_for", str(name)) else ""
        rows.append((source.told("assumes", i), line(mark, what, "Rests on it: ", whose, ".")))
    return rows


def legend(source: Source) -> Inline | None:
    """What each mark behind a coefficient's name means; None where there is none."""
    of = source.table("assumed_for")
    told = [f"{one.mark} {one.phrase}" for name, one in ASSUMPTIONS.items() if one.mark and of.get(name)]
    return Fixed(f"A value whose name ends in a mark holds only assuming: {', '.join(told)}.") if told else None


def explanations(source: Source) -> Table | None:
    """What the run shows that is not declared; None where it shows nothing."""
    rows = []
    for i in range(len(source.array("fit", "explanations"))):
        at = ("fit", "explanations", i)
        size, u = source.with_uncertainty((*at, "size"), (*at, "u_size"), None)
        unit, column = source.told(*at, "unit"), source.told(*at, "column")
        patterns = [str(name) for name in source.array(*at, "patterns")]
        name = " or ".join(NAMES.get(pattern, pattern.replace("_", " ")) for pattern in patterns)
        said = line(name) if column is MISSING else line(name, " of ", column)
        rows.append((said, size, u, unit, source.rounded(2, *at, "p")))
    return Table(("The run shows", "Size", "u (k = 1)", "Unit", "p"), rows, left=(3,)) if rows else None


def unseen(source: DocumentSource) -> tuple[Table, Inline, Inline] | None:
    """What the run could not have shown: the sizes that cost most, the names of what shows at no size, and whether the
    largest error is beyond the limit. None where nothing is told of it: without a stand, and in older results."""
    rows: list[tuple[Inline, ...]] = []
    never: list[Inline] = []
    for i in range(len(source.array("reliability"))):
        at = ("reliability", i)
        pattern = str(source.at(*at, "pattern"))
        name = Fixed(description_of(pattern))
        if source.decimal(*at, "size") is None:
            never.append(name)
        else:
            error = source.scaled((*at, "norm_error_g"), _TWO_DIGITS, power=_MICRO)
            rows.append((name, source.rounded(2, *at, "size"), source.told(*at, "unit"), error))
    if not rows and not never:
        return None
    columns = ("Error of the block or stand", "Size", "Unit", "Error of |a| in µg")
    names = joined(never, "; ") if never else Fixed("none")
    return Table(columns, rows[:_MOST_UNSEEN], left=(2,)), names, _largest_unseen(source, rows)


def _largest_unseen(source: DocumentSource, rows: list[tuple[Inline, ...]]) -> Inline:
    """Of `rows` as `unseen` has them."""
    error, limit = source.decimal("reliability_norm_g"), source.decimal("verification", "limit_g")
    limit = source.decimal("decision", "limit_g") if limit is None else limit
    if not rows or error is None or limit is None:
        return Fixed("No such error has a known size.")
    name, size, unit, in_micro = rows[0]
    told = line("The largest: ", name, " below ", size, " ", unit, " could go unnoticed; it would change |a| by up to ")
    judged = "more than the limit: the verdict assumes that there is none" if error > limit else "within the limit"
    return line(told, in_micro, f" µg, {judged}.")
