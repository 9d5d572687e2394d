"""Does the result conform? The verdict, the rule that it follows, and what it rests on (ISO/IEC 17025:2017, 7.8.6)."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

from tumble.model.reliability import in_words as in_words_of
from tumble.model.stand_seen import NAMES
from tumble.report.source import (
    MISSING,
    NO_UNCERTAINTY,
    STANDARD_GRAVITY,
    Factor,
    Facts,
    Fixed,
    Inline,
    Path,
    Shown,
    Source,
    Table,
    aligned,
    joined,
    line,
    rounded,
)
from tumble.solving.decision import ASSUMPTIONS, UNCERTAINTY, Decision, in_words

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
    rest = in_words(source.solved.would_show or (), decision.limit_g)
    return Verdict(decision.word, Fixed(f"{decision.reason}. {rest}." if rest else decision.reason))


def findings(source: Source) -> Facts:
    """The three things that are judged, and how they came out."""
    check = ("verification",)
    in_si = source.scaled((*check, "limit_g"), _three_digits, source.gravity, power=3)
    limit = line(source.millionths(None, *check, "limit_g"), " µg = ", in_si, " mm/s²")
    largest = _largest(source)
    gravity = "passed" if source.flag(*check, "pass") else "FAILED"
    return [
        (Fixed("Gravity check"), line(gravity, ": largest |Δg| ", largest, ", limit ", limit)),
        (Fixed("Fit to the declared stand"), _fit(source)),
        (Fixed("Uncertainty at every attitude"), _uncertainty(source)),
    ]


def _largest(source: Source) -> Inline:
    """The largest error of gravity with its uncertainty, and at which position it is."""
    errors = [source.decimal("verification", "delta_g_g", i, "delta_g_g") for i in range(_count(source))]
    known = [(abs(error), place) for place, error in enumerate(errors) if error is not None]
    size: Path = ("verification", "max_abs_delta_g_g")
    if not known:
        return line(source.scaled(size, _three_digits, power=6), " µg")
    place = max(known)[1]
    shown, u = _delta_g(source, size, place)
    certain = Fixed(", no uncertainty") if u is NO_UNCERTAINTY else line(" (U = ", u, " µg)")
    return line(shown, " µg", certain, " at ", _label(source, place))


def _three_digits(value: Decimal) -> Shown:
    return rounded(value, 3)


def _delta_g(source: Source, value: Path, place: int, *times: Factor, power: int = _MICRO) -> tuple[Inline, Inline]:
    """Errors of gravity in millionths of g, or in another unit: `value`, and U at this place."""
    at: Path = ("verification", "delta_g_g", place)
    return source.with_uncertainty(value, (*at, "u_delta_g_g"), (*at, "k_delta_g"), *times, power=power, digits=3)


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
    gravity = "PASS where |Δg| = |(|a|² - 1)/2| is at most the limit at every measured position"
    if not source.table("fit"):
        return Fixed(f"{gravity}. No stand is declared: nothing is stated of other attitudes. {_AS_THEY_ARE}")
    factor = Decision.of(source.solved).coverage_factor
    stand = "the residuals fit the declared stand (chi-squared, at the confidence given)"
    if not source.table("decision"):
        return Fixed(f"{gravity}, and {stand}. Nothing is stated of other attitudes: {_OLDER}. {_AS_THEY_ARE}")
    everywhere = f", and {factor:g} times the standard uncertainty of |a| is at most the limit at every attitude"
    else_ = (
        ". Where only the last does not hold, conformity is not shown, which is no PASS. That uncertainty counts the "
    )
    else_ += "errors of the declared stand alone. "
    return Fixed(f"{gravity}, {stand}{everywhere}{else_}{_AS_THEY_ARE}")


def positions(source: Source) -> Table:
    """Every measured position: samples, error of gravity with its uncertainty, whether it is within the limit."""
    rows: list[tuple[Inline, ...]] = []
    limit = source.decimal("verification", "limit_g")
    for i in range(_count(source)):
        at: Path = ("verification", "delta_g_g", i)
        delta_g = source.decimal(*at, "delta_g_g")
        within = limit is None or delta_g is None or abs(delta_g) <= limit
        in_g = _delta_g(source, (*at, "delta_g_g"), i)
        in_si = _delta_g(source, (*at, "delta_g_g"), i, source.gravity, power=3)
        samples, k = source.told("means", i, "samples"), source.to_places(2, *at, "k_delta_g")
        told = (_label(source, i), source.told(*at, "use"), samples, *in_g, *in_si, k)
        rows.append((*told, Fixed("yes" if within else "NO")))
    head: tuple[str, ...] = ("Position", "Use", "Samples", "Δg, µg", "U, µg", "Δg, mm/s²", "U, mm/s²", "k")
    head += ("Within limit",)
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


def assumptions(source: Source) -> Facts:
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
    return Fixed(f"A value whose name ends in a mark is right only given: {', '.join(told)}.") if told else None


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


def unseen(source: Source) -> tuple[Table, Inline] | None:
    """What the run could not have shown: the sizes that cost most, and the names of what shows at no size. None where
    nothing is told of it: without a stand, and in older results."""
    rows: list[tuple[Inline, ...]] = []
    never: list[Inline] = []
    for i in range(len(source.array("reliability"))):
        at = ("reliability", i)
        pattern = str(source.at(*at, "pattern"))
        name = Fixed(in_words_of(pattern))
        if source.decimal(*at, "size") is None:
            never.append(name)
        else:
            error = source.millionths(1, *at, "norm_error_g")
            rows.append((name, source.rounded(2, *at, "size"), source.told(*at, "unit"), error))
    if not rows and not never:
        return None
    columns = ("Error of the block or stand", "Size", "Unit", "Error of |a| in µg")
    return Table(columns, rows[:_MOST_UNSEEN], left=(2,)), joined(never, "; ") if never else Fixed("none")
