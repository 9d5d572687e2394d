"""The results: twelve coefficients, further terms of the model, intrinsic parameters, each with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, replace

from tumble.estimators import COEFFICIENTS
from tumble.report.cells import MISSING, NU, Fixed, Inline, Number, Table, aligned, line
from tumble.report.method import unit_of_k
from tumble.report.rounding import Shown
from tumble.report.source import Key, Source, pointer
from tumble.solving.coverage import HANDS, NEARLY_INFINITE
from tumble.terms import KEYS
from tumble.units import noise_unit

Path = tuple[Key, ...]
_MANY = 1000
_STUDENT = f". k is Student's t for {NU} effective degrees of freedom (Welch and Satterthwaite)."
_TERMS = {"k2": ("K2", "g\u207b¹"), "k3": ("K3", "g\u207b²"), "drift": ("drift", "")}
_INTRINSIC: dict[str, tuple[tuple[Key, ...], str]] = {  # name: path within its tables, unit; "": that of K
    **{f"Scale {axis}": (("scale", i), "") for i, axis in enumerate("xyz")},
    **{f"Angle {pair}": (("angle_rad", pair), "rad") for pair in ("xy", "xz", "yz")},
    **{f"Bias {axis}": (("bias_g", i), "g") for i, axis in enumerate("xyz")},
}


@dataclass(frozen=True)
class Uncertainties:
    """Where a document has them: standard ones of K and U0 beneath `table`, factors k beneath "coverage", if `has_k`.
    `about`: what they are, to stand above the table."""

    table: tuple[Key, ...]
    has_k: bool
    about: Inline

    @property
    def symbol(self) -> str:
        """Of the column."""
        return "U = k u" if self.has_k else "u (k = 1)"


def uncertainties(source: Source) -> Uncertainties:
    """Those of a declared stand, else those of the noise alone."""
    table: Path = () if source.array("u_K") else ("scatter_alone",) if source.table("scatter_alone") else ()
    has_k = bool(source.table("coverage"))
    known = bool(source.array(*table, "u_K"))
    if not known:
        return Uncertainties(table, False, line("Uncertainties are not stated: no stand is declared."))
    if table:
        return Uncertainties(table, has_k, _of_noise(source, has_k))
    probability = source.told("coverage", "probability")
    within = "U = k u is the expanded uncertainty: the value lies within U of the true one with a probability of "
    standard = Fixed("u are standard uncertainties (k = 1); no coverage factor is stated.")
    return Uncertainties(table, has_k, line(within, probability, _STUDENT) if has_k else standard)


def _of_noise(source: Source, has_k: bool) -> Inline:
    """What uncertainties by noise alone say, and what they do not: nothing is claimed of the true value."""
    probability = source.told("coverage", "probability")
    moved = line("U = k u: noise by itself moves a value by at most U with a probability of ", probability, _STUDENT)
    symbol = "U" if has_k else "u"
    only = (
        f" {symbol} contains the noise of the samples only: no stand is declared, so that its errors are NOT in"
        f" {symbol}, and {symbol} does not say how near a value is to the true one. {HANDS}"
    )
    return line(moved if has_k else "u (k = 1) are standard deviations.", only)


def coefficients(source: Source, given: Uncertainties) -> Table:
    """K row by row, and U0. A name that ends in * rests on an assumption that touches only some."""
    rows = []
    marked = starred(source)
    for place, name in enumerate(COEFFICIENTS):
        where: Path = ("K", *divmod(place, 3)) if place < 9 else ("U0", place - 9)
        unit = unit_of_k(source) if place < 9 else source.told("unit")
        u, k = (*given.table, f"u_{where[0]}", *where[1:]), ("coverage", f"k_{where[0]}", *where[1:])
        freedom = ("coverage", f"freedom_{where[0]}", *where[1:])
        rows.append(_row(source, name + "*" * (name in marked), where, u, k, freedom, unit, given))
    return _table(rows, given)


def starred(source: Source) -> set[str]:
    """Names of the coefficients that rest on an assumption that touches only some."""
    return {str(name) for names in source.table("assumed_for").values() for name in names}


def intrinsic(source: Source, given: Uncertainties) -> Table:
    """Lengths of K's rows, angles between them, biases in g: they do not depend on how the block sits."""
    rows = []
    given = replace(given, has_k=given.has_k and bool(source.table("u_intrinsic")))
    for name, (where, unit) in _INTRINSIC.items():
        paths = ("intrinsic", *where), ("u_intrinsic", *where), ("coverage", "k_intrinsic", *where)
        its_unit = Fixed(unit) if unit else unit_of_k(source)
        rows.append(_row(source, name, *paths, ("coverage", "freedom_intrinsic", *where), its_unit, given))
    if all(row[2] is MISSING for row in rows):  # nothing is stated of any
        short = [(row[0], row[1], row[3]) for row in rows]
        return Table(("", "Value, without uncertainty", "Unit"), aligned(short, 1), left=(2,))
    return _table(rows, given)


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
    worst = source.rounded(2, "u_norm_g", "worst_g")
    return MISSING if worst is MISSING else line(worst, " g")


def _row(
    source: Source, name: str, value: Path, u: Path, k: Path, freedom: Path, unit: Inline, given: Uncertainties
) -> tuple[Inline, ...]:
    shown, spread = source.with_uncertainty(value, u, k if given.has_k else None)
    told = (Fixed(name), shown, spread, unit)
    if not given.has_k:
        return told
    return (*told, source.to_places(2, *k), _freedom(source, freedom))


def _freedom(source: Source, path: Path) -> Inline:
    """Degrees of freedom, whole ones where they are many; null is infinitely many, and so is what differs from it in
    no digit that is printed."""
    found = source.decimal(*path)
    is_infinite = found is None and source.at(*path[:2]) is not None
    if is_infinite or (found is not None and found > NEARLY_INFINITE):
        return Number(Shown("\u221e"), pointer(path))
    return source.rounded(3, *path) if found is None or found < _MANY else source.to_places(0, *path)


def _table(rows: list[tuple[Inline, ...]], given: Uncertainties) -> Table:
    head = ("", "Value", given.symbol, "Unit")
    return Table((*head, "k", NU) if given.has_k else head, aligned(rows, 1, 2), left=(3,))
