"""The results: twelve coefficients, further terms of the model, intrinsic parameters, each with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

from tumble.estimators import COEFFICIENTS
from tumble.report.method import unit_of_k
from tumble.report.source import (
    MISSING,
    NO_UNCERTAINTY,
    NU,
    Fixed,
    Inline,
    Number,
    Path,
    Shown,
    Source,
    Table,
    aligned,
    line,
    pointer,
    rounded,
    to_places,
)
from tumble.solving.decision import marks
from tumble.solving.uncertainty import HANDS, NEARLY_INFINITE
from tumble.terms import KEYS
from tumble.units import noise_unit

_MANY = 1000
_STUDENT = f" k is Student's t for {NU} effective degrees of freedom (Welch and Satterthwaite)."
_DENIED = " But the run does not fit the declared stand, so that U may be too small."
_TERMS = {"k2": ("K2", "g\u207b¹"), "k3": ("K3", "g\u207b²"), "drift": ("drift", "")}
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

    @property
    def symbol(self) -> str:
        """Of the column."""
        return "U = k u" if self.has_k else "u (k = 1)"


@dataclass(frozen=True)
class Where:
    """What stands where in a document, of one value: it, its standard uncertainty, its coverage factor and the degrees
    of freedom of this; and `in_si` the first two for accelerations in m/s^2, None for what has no g in its unit."""

    value: Path
    u: Path
    k: Path
    freedom: Path
    in_si: tuple[Path, Path] | None


def uncertainties(source: Source) -> Uncertainties:
    """Those of a declared stand, else those of the noise alone."""
    table: Path = () if source.array("u_K") else ("scatter_alone",) if source.table("scatter_alone") else ()
    has_k = bool(source.table("coverage"))
    known = bool(source.array(*table, "u_K"))
    if not known:
        return Uncertainties(table, False, line("The values have no uncertainty: no stand is declared."))
    if table:
        return Uncertainties(table, has_k, _of_noise(source, has_k))
    if not has_k:
        return Uncertainties(table, has_k, Fixed("u are standard uncertainties (k = 1); no coverage factor is stated."))
    probability, factor = source.told("coverage", "probability"), coverage_factor(source)
    expanded = line(
        "U = k u is the expanded uncertainty with the coverage factor k", factor, ": the value lies within U"
    )
    denied = _DENIED if source.table("fit") and not source.flag("fit", "fits") else ""
    return Uncertainties(
        table, has_k, line(expanded, " of the true one with a probability of ", probability, ".", denied, _STUDENT)
    )


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
        unit = unit_of_k(source) if place < 9 else source.told("unit")
        twin = (f"u_{at[0]}", *at[1:])
        where = Where(
            value=at,
            u=(*given.table, *twin),
            k=("coverage", f"k_{at[0]}", *at[1:]),
            freedom=("coverage", f"freedom_{at[0]}", *at[1:]),
            in_si=(at, twin) if place < 9 else None,
        )
        rows.append(_row(source, name + marked.get(name, ""), where, unit, given))
    return _table(source, rows, given)


def intrinsic(source: Source, given: Uncertainties) -> Table:
    """Lengths of K's rows, angles between them, biases in g: they do not depend on how the block sits."""
    rows = []
    given = replace(given, has_k=given.has_k and bool(source.table("u_intrinsic")))
    for name, (at, unit, in_si) in _INTRINSIC.items():
        where = Where(
            value=("intrinsic", *at),
            u=("u_intrinsic", *at),
            k=("coverage", "k_intrinsic", *at),
            freedom=("coverage", "freedom_intrinsic", *at),
            in_si=in_si,
        )
        rows.append(_row(source, name, where, Fixed(unit) if unit else unit_of_k(source), given))
    return _table(source, rows, given)


def further(source: Source) -> Table | None:
    """K2, K3 and drift, with standard uncertainties; None where the model has none."""
    terms = [term for term in _TERMS if term in source.array("extended", "terms")]
    rows = []
    for term in terms:
        name, unit = _TERMS[term]
        for i, axis in enumerate("xyz"):
            value, u = source.with_uncertainty(("extended", KEYS[term], i), ("extended", f"u_{KEYS[term]}", i), None)
            rows.append((Fixed(f"{name}_{axis}"), value, u, Fixed(unit or noise_unit(str(source.at("unit"))))))
    return Table(("", "Value", "u (k = 1)", "Unit"), aligned(rows, 1, 2), left=(3,)) if rows else None


def worst_norm(source: Source) -> Inline:
    """Of the length of the calibrated acceleration."""
    at = ("u_norm_g", "worst_g")
    two = partial(rounded, digits=2)
    worst = source.scaled(at, two, power=6)
    return (
        NO_UNCERTAINTY
        if worst is MISSING
        else line(worst, " µg = ", source.scaled(at, two, source.gravity, power=3), " mm/s²")
    )


def _row(source: Source, name: str, where: Where, unit: Inline, given: Uncertainties) -> tuple[Inline, ...]:
    k = where.k if given.has_k else None
    told: tuple[Inline, ...] = (Fixed(name), *source.with_uncertainty(where.value, where.u, k), unit)
    told += _in_si(source, where, k) if source.table("si") else ()
    return (*told, source.to_places(2, *where.k), _freedom(source, where.freedom)) if given.has_k else told


def _in_si(source: Source, where: Where, k: Path | None) -> tuple[Inline, Inline, Inline]:
    """Value, uncertainty and unit for accelerations in m/s^2; blanks for what has none."""
    if where.in_si is None:
        return Fixed(""), Fixed(""), Fixed("")
    value, u = (("si", *path) for path in where.in_si)
    unit = source.told("si", "units", "bias" if where.in_si[0][0] == "bias" else "K")
    return (*source.with_uncertainty(value, u, k), unit)


def _freedom(source: Source, path: Path) -> Inline:
    """Degrees of freedom, whole ones where they are many; null is infinitely many, and so is what differs from it in
    no digit that is printed."""
    found = source.decimal(*path)
    is_infinite = found is None and source.at(*path[:2]) is not None
    if is_infinite or (found is not None and found > NEARLY_INFINITE):
        return Number(Shown("\u221e"), pointer(path))
    return source.rounded(3, *path) if found is None or found < _MANY else source.to_places(0, *path)


def _table(source: Source, rows: list[tuple[Inline, ...]], given: Uncertainties) -> Table:
    head: tuple[str, ...] = ("", "Value", given.symbol, "Unit")
    if not source.table("si"):
        return Table((*head, "k", NU) if given.has_k else head, aligned(rows, 1, 2), left=(3,))
    head = (*head, "Value, SI", given.symbol, "Unit")
    return Table((*head, "k", NU) if given.has_k else head, aligned(rows, 1, 2, 4, 5), left=(3, 6))
