"""Does the result conform? The verdict, the rule that it follows, and what it rests on (ISO/IEC 17025:2017, 7.8.6)."""

from __future__ import annotations

from dataclasses import dataclass

from tumble.report.cells import MISSING, Facts, Fixed, Inline, Table, joined, line
from tumble.report.source import Source
from tumble.solving.assumptions import ASSUMPTIONS, phrase
from tumble.solving.stand_seen import NAMES

_MICRO = 6
_REASONS = {"gravity": "the gravity check", "fit": "the fit to the declared stand"}


@dataclass(frozen=True)
class Verdict:
    """`word`: PASS or FAIL; `phrase`: what stands behind it."""

    word: str
    phrase: Inline


def verdict(source: Source) -> Verdict:
    """PASS, with what it assumes, or FAIL and why."""
    if source.flag("pass"):
        return Verdict("PASS", Fixed(phrase(source.array("assumes"))))
    reasons = str(source.at("pass_reason") or "gravity").split(" and ")
    return Verdict("FAIL", Fixed(f": {' and '.join(_REASONS.get(reason, reason) for reason in reasons)}"))


def findings(source: Source) -> Facts:
    """The two things that are judged, and how they came out."""
    check = ("verification",)
    limit = line(source.millionths(None, *check, "limit_g"), " µg")
    largest = line(source.millionths(_places(source), *check, "max_abs_delta_g_g"), " µg", _where(source))
    gravity = "passed" if source.flag(*check, "pass") else "FAILED"
    return [
        (Fixed("Gravity check"), line(gravity, ": largest |Δg| ", largest, ", limit ", limit)),
        (Fixed("Fit to the declared stand"), _fit(source)),
    ]


def _where(source: Source) -> Inline:
    """Behind the largest error, at which position it is."""
    errors = [source.decimal("verification", "delta_g_g", i, "delta_g_g") for i in range(_count(source))]
    known = [(abs(error), place) for place, error in enumerate(errors) if error is not None]
    return line(" at ", _label(source, max(known)[1])) if known else Fixed("")


def _count(source: Source) -> int:
    """Of measured positions."""
    return len(source.array("verification", "delta_g_g"))


def _label(source: Source, place: int) -> Inline:
    """Of a measured position, such as 2.7."""
    at = ("verification", "delta_g_g", place)
    return line(source.told(*at, "mounting"), ".", source.told(*at, "position"))


def _fit(source: Source) -> Inline:
    if not source.table("fit"):
        return Fixed("not judged: no stand is declared")
    word = "fits" if source.flag("fit", "fits") else "DOES NOT FIT"
    chi2, dof = source.rounded(3, "fit", "chi2"), source.told("fit", "dof")
    p, confidence = source.rounded(2, "fit", "p"), source.told("fit", "confidence")
    return line(word, ": χ² ", chi2, " with ", dof, " degrees of freedom, p ", p, "; confidence ", confidence)


def rule(source: Source) -> Inline:
    """The decision rule in words."""
    gravity = "PASS where |Δg| = |(|a|² - 1)/2| is at most the limit at every measured position"
    stand = " and the residuals fit the declared stand (chi-squared, at the confidence given)"
    simple = ". Simple acceptance: no guard band is kept from the limit. Numbers are compared before they are rounded."
    return Fixed(gravity + (stand if source.table("fit") else "") + simple)


def positions(source: Source) -> Table:
    """Every measured position: samples, error of gravity, whether it is within the limit."""
    rows, places = [], _places(source)
    limit = source.decimal("verification", "limit_g")
    for i in range(_count(source)):
        at = ("verification", "delta_g_g", i)
        delta_g = source.decimal(*at, "delta_g_g")
        within = limit is None or delta_g is None or abs(delta_g) <= limit
        samples = source.told("means", i, "samples")
        shown = source.millionths(places, *at, "delta_g_g")
        rows.append((_label(source, i), source.told(*at, "use"), samples, shown, Fixed("yes" if within else "NO")))
    return Table(("Position", "Use", "Samples", "Δg in µg", "Within the limit"), rows, left=(1, 4))


def _places(source: Source) -> int:
    """Digits behind the point of a micro-g, for four significant ones of the limit."""
    limit = source.decimal("verification", "limit_g")
    return 1 if not limit else max(0, 3 - (limit.adjusted() + _MICRO))


def assumptions(source: Source) -> Facts:
    """What the result rests on that nobody tested, and the coefficients that do."""
    rows: Facts = []
    for i, name in enumerate(source.array("assumes")):
        known = ASSUMPTIONS.get(str(name))
        whose = joined(source.each("assumed_for", str(name)) or [Fixed("all")], ", ")
        what = f"{known.phrase}: {known.why}. " if known else ""
        rows.append((source.told("assumes", i), line(what, "Rests on it: ", whose, ".")))
    return rows


def warnings(source: Source) -> list[Inline] | None:
    """The sentences that a user was told; None where they are not known."""
    if source.at("warnings") is None:
        return None
    return source.each("warnings")


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
