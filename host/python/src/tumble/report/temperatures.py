"""The sections of a report on a calibration over temperature that are not those of a single result: the verdict for the
range, values at three temperatures, the polynomials, the runs."""

from __future__ import annotations

from typing import Any

from tumble.documents.base import checked
from tumble.documents.thermal import THERMAL, Thermal
from tumble.estimators import COEFFICIENTS
from tumble.report.sections import Verdict, conditions, declared_stand, set_angles
from tumble.report.source import (
    MISSING,
    NO_UNCERTAINTY,
    DocumentSource,
    Facts,
    Fixed,
    Inline,
    Path,
    Table,
    aligned,
    joined,
    line,
    plain,
)
from tumble.schedule import WITH_STAND
from tumble.solving.decision import UNCERTAINTY
from tumble.solving.thermal import decision_of, verdict_of
from tumble.stand import SOURCES
from tumble.units import per_g

_MICRO = 6
_HEADINGS = ("at T0", "per K", "per K²")
_NOBODY_KNOWS = "not judged: no stand is declared"


class ThermalSource(DocumentSource):
    """A document of schema tumble.thermal/1, and the same by its types, `solved`. Raises BadInput."""

    def __init__(self, document: dict[str, Any], name: str):
        super().__init__(document, name)
        self.solved = checked(Thermal, THERMAL, document, name)


def verdict(source: ThermalSource) -> Verdict:
    """The decision, as on a terminal."""
    word, said = verdict_of(source.solved)
    return Verdict(word, Fixed(said))


def findings(source: ThermalSource) -> Facts:
    """The three things that are judged, and how they came out; what one temperature would be wrong by."""
    failures, factor = decision_of(source.solved).failures, source.told("decision", "coverage_factor")
    limit = source.scaled(("decision", "limit_g"), plain, power=_MICRO)
    largest = source.millionths(1, "max_abs_delta_g_g")
    gravity = "FAILED" if "gravity" in failures else "passed"
    fit: Inline = Fixed(_NOBODY_KNOWS)
    u: Inline = fit
    if source.table("fit"):
        word = "fit" if source.at("fit", "fits") else "DO NOT FIT"
        chi2, dof, p = source.rounded(3, "fit", "chi2"), source.told("fit", "dof"), source.rounded(2, "fit", "p")
        confidence = source.told("fit", "confidence")
        fit = line(word, ": χ² ", chi2, " with ", dof, " degrees of freedom, p ", p, "; confidence ", confidence)
        word = "NOT SHOWN to be within the limit" if UNCERTAINTY in failures else "within the limit"
        u = line(word, ": the worst u(|a|) is ", worst_norm(source), ", which the decision rule takes times ", factor)
    wrong = source.millionths(0, "at_one_temperature_g")
    reference = source.told("reference_c")
    return [
        (Fixed("Gravity check"), line(gravity, ": largest |Δg| ", largest, " µg, limit ", limit, " µg")),
        (Fixed("Fit of all runs to the declared stand"), fit),
        (Fixed("Uncertainty at every attitude and temperature"), u),
        *([(Fixed("Set angles"), set_angles(source))] if source.table("set_angles") else []),
        (
            Fixed("Without the polynomials"),
            line("|a| is wrong by up to ", wrong, " µg with the values at ", reference, " °C"),
        ),
    ]


def worst_norm(source: ThermalSource) -> Inline:
    """Of the length of the calibrated acceleration, over the range."""
    known = source.solved.u_norm_g
    if not known:
        return NO_UNCERTAINTY
    worst = max(range(len(known)), key=lambda i: known[i].worst_g)
    at = ("u_norm_g", worst)
    u = source.millionths(1, *at, "worst_g")
    return line(u, " µg, at ", source.rounded(3, *at, "temperature_c"), " °C")


def coefficients(source: ThermalSource) -> Table | None:
    """K row by row and U0 at the lowest, the reference and the highest temperature; None for a document without."""
    unit, rows = source.solved.unit, []
    if not source.solved.at:
        return None
    for place, name in enumerate(COEFFICIENTS):
        row: list[Inline] = [Fixed(name)]
        for i in range(len(source.array("at"))):
            row += source.with_uncertainty(("at", i, *_of(place)), ("at", i, *_of(place, "u_")), None)
        rows.append((*row, Fixed(per_g(unit) if place < 9 else unit)))
    head = [one for at in source.solved.at for one in (f"{at.temperature_c:.4g} °C", "u")]
    return Table(("", *head, "Unit"), aligned(rows, *range(1, len(head) + 1)), left=(len(head) + 1,))


def powers(source: ThermalSource) -> Table:
    """Of the polynomials; the values at the reference temperature only where `coefficients` has none."""
    unit, rows = source.solved.unit, []
    degrees = range(1 if source.solved.at else 0, source.solved.degree + 1)
    for place, name in enumerate(COEFFICIENTS):
        row: list[Inline] = [Fixed(name)]
        for power in degrees:
            (key, *at), (u_key, *_) = _of(place), _of(place, "u_")
            row += source.with_uncertainty((key, power, *at), (u_key, power, *at), None, power=_MICRO)
        rows.append((*row, Fixed(f"10⁻⁶ {per_g(unit) if place < 9 else unit}")))
    head = [one for power in degrees for one in (_HEADINGS[power], "u")]
    return Table(("", *head, "Unit"), aligned(rows, *range(1, len(head) + 1)), left=(len(head) + 1,))


def _of(place: int, u: str = "") -> Path:
    return (f"{u}K", *divmod(place, 3)) if place < 9 else (f"{u}U0", place - 9)


def about_values(source: ThermalSource) -> Inline:
    """What the numbers of `coefficients` and `powers` are."""
    about = line("K(T) and U0(T) are polynomials of T - T0, with T0 = ", source.told("reference_c"), " °C. ")
    if not source.array("u_K"):
        return line(about, "The values have no uncertainty: no stand is declared.")
    return line(about, "u are standard uncertainties (k = 1), by the errors of the declared stand and the noise.")


def runs(source: ThermalSource) -> Table:
    """Each as it was solved alone, and its largest error of gravity with the polynomials."""
    rows: list[tuple[Inline, ...]] = []
    for i, one in enumerate(source.solved.runs):
        at: Path = ("runs", i)
        low, high = source.rounded(3, *at, "range_c", 0), source.rounded(3, *at, "range_c", 1)
        alone = Fixed("PASS" if one.passed else f"no PASS: {one.pass_reason}")
        error = source.millionths(1, *at, "max_abs_delta_g_g")
        schedule = source.told(*at, "schedule")
        where = (schedule if schedule is not MISSING else Fixed("its own"), source.told(*at, "estimator"))
        mean, positions = source.rounded(3, *at, "mean_c"), source.told(*at, "positions")
        rows.append((Fixed(f"{i + 1}"), mean, line(low, " to ", high), positions, *where, alone, error))
    head = ("Run", "Mean, °C", "Range, °C", "Positions", "Schedule", "Estimator", "Alone", "|Δg|, µg")
    return Table(head, aligned(rows, 1, 7), left=(4, 5, 6))


def rule(source: ThermalSource) -> Inline:
    """The decision rule in words."""
    gravity = "PASS where |Δg| = |(|a|² - 1)/2| is at most the limit at every measured position, with K(T) and U0(T) of"
    gravity += " its temperature (simple acceptance: no guard band)"
    compared = "Numbers are compared before they are rounded."
    if not source.table("fit"):
        return Fixed(f"{gravity}. No stand is declared: nothing is stated of other attitudes. {compared}")
    return line(
        f"{gravity}, the residuals of all runs fit the declared stand (chi-squared, at the confidence given), and ",
        source.told("decision", "coverage_factor"),
        " times the standard uncertainty of |a| is at most the limit at every attitude, at"
        f" {len(source.solved.u_norm_g)} temperatures of the range. Where only the last does not hold, conformity is"
        " not shown, which is no PASS. That uncertainty counts the errors of the declared stand alone. Nothing is"
        f" stated outside the range. {compared}",
    )


def method(source: ThermalSource) -> Facts:
    """What was done with the runs, and by what; where and at what temperatures."""
    there = [SOURCES[name] for name in source.solved.kept if name in SOURCES]
    kept = [Fixed(one.words) for one in there if source.decimal("stand", one.key)]  # none of these has channels
    degree = ("linear", "quadratic")[source.solved.degree - 1]
    span = line(source.rounded(4, "range_c", 0), " to ", source.rounded(4, "range_c", 1), " °C")
    return [
        (Fixed("Model"), Fixed(f"twelve coefficients, each {degree} in the temperature")),
        (Fixed("Estimator"), Fixed("least squares of all runs at once, the errors of the stand among the unknowns")),
        (Fixed("The same in all runs"), joined(kept, "; ") if kept else MISSING),
        (Fixed("Computed by"), line("tumble ", source.told("tumble"))),
        (Fixed("Unit of the outputs"), source.told("unit")),
        (Fixed("Temperatures of the runs"), span),
        *conditions(source),
    ]


def declared(source: ThermalSource) -> tuple[Inline, Table] | None:
    """The stand as it is declared; None without one."""
    return declared_stand(source, all(one.schedule in WITH_STAND for one in source.solved.runs))


def data(source: ThermalSource) -> Facts:
    """The files of the runs, with their SHA-256."""
    found: Facts = []
    for i, one in enumerate(source.solved.runs):
        at = ("runs", i)
        file = source.told(*at, "file")
        said = file if one.sha256 is None else line(file, "; SHA-256 ", source.told(*at, "sha256"))
        found.append((Fixed(f"Run {i + 1}"), said))
    return found
