"""From two results to a comparison: what of them can be compared, what they share, and what a person should know."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.comparison import shared
from tumble.comparison.shared import Calibration, OneStand
from tumble.comparison.statistics import is_covariance
from tumble.comparison.verdict import Found, Verdict, judge
from tumble.defaults import ANEW
from tumble.documents.result import Result
from tumble.errors import BadInput, file_name, quoted
from tumble.files.rows import Temperatures
from tumble.solving.coefficients import Coefficients, gravity_of
from tumble.solving.decision import GRAVITY, UNCERTAINTY, Decision
from tumble.solving.plausibility import TOLERANCE_C
from tumble.solving.result import stand_of
from tumble.terms import POWERS, Terms

_NOT_THEIRS = "with a schedule that is known (--schedule) does not give the uncertainties of both"
_DATES = ("date", "run_date")  # labels of the day of a run
_EXCHANGED = "exchanged? A is to be the earlier one"
_WORDS = {"alpha1": "axis tilt", "alpha2": "level"}  # of sources whose names are none


@dataclass(frozen=True)
class Side:
    """One of the two results: its `name`, its `document`, `complaints` about it, and
    its `calibration`."""

    name: str
    document: Result
    complaints: tuple[str, ...]
    calibration: Calibration

    @classmethod
    def of(cls, name: str, document: Result, complaints: Sequence[str] = ()) -> Side:
        """Raises BadInput for a singular K, and for a covariance that is none."""
        try:
            found = Coefficients.of(document)
        except ValueError as error:
            raise BadInput(str(error), name) from None
        covariance = None if document.covariance is None else found.covariance
        if covariance is not None and not is_covariance(covariance):
            raise BadInput("its covariance is none: of some mixture of the coefficients it is negative", name)
        return cls(name, document, tuple(complaints), Calibration(found.values, covariance, found.terms))

    @property
    def terms(self) -> Terms:
        """That it was solved with beside the twelve coefficients."""
        return () if self.document.extended is None else self.document.extended.terms

    @property
    def failures(self) -> tuple[str, ...]:
        """Why it did not pass; nothing passes that failed its gravity check."""
        told = Decision.of(self.document).failures
        return told if self.document.verification.passed or GRAVITY in told else (GRAVITY, *told)

    @property
    def failed(self) -> bool:
        """Whether it failed: the gravity check, or the fit to its stand. A limit that is only not shown says nothing
        against its numbers: their uncertainties are part of the comparison."""
        return bool(set(self.failures) - {UNCERTAINTY})

    @property
    def assumes(self) -> tuple[str, ...]:
        """What it rests on that nobody tested."""
        return self.document.assumes

    @property
    def temperature(self) -> Temperatures | None:
        """Of its run; None: not told."""
        told = self.document.temperature
        return None if told is None else Temperatures(told.min_c, told.max_c, "")

    @property
    def gravity(self) -> tuple[float | None, float | None]:
        """Where it was measured, with its standard uncertainty, m/s^2; None: not told."""
        return gravity_of(self.document.environment)

    def told_apart(self, one_stand: OneStand) -> shared.Apart | None:
        """What returns with every run on the stand, and what is its own; None where it is not its stand."""
        if self.calibration.covariance is None:
            return None
        own = stand_of(self.document, self.name)
        if own is not None and shared.is_one(own, one_stand.stand):
            one_stand = replace(one_stand, stand=own)
        return shared.told_apart(shared.Told(self.name, self.document, self.calibration, self.terms), one_stand)


@dataclass(frozen=True)
class Comparison:
    """B held against A. `terms`: K2 and K3 as far as both have them; `shared`: names of the errors that were counted
    once, None where no stand was named, or where it is not the stand of both."""

    a: Side
    b: Side
    found: Found
    terms: Terms
    shared: tuple[str, ...] | None
    one_stand: OneStand | None
    warnings: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def verdict(self) -> Verdict:
        """What may be said. Nothing firm of a result that failed: its numbers do not describe its own run."""
        return Verdict.CANNOT_TELL if self.a.failed or self.b.failed else self.found.verdict

    @property
    def assumes(self) -> tuple[str, ...]:
        """Names of what the one or the other rests on that nobody tested."""
        return tuple(dict.fromkeys((*self.a.assumes, *self.b.assumes)))


def compare(
    a: Side, b: Side, one_stand: OneStand | None, confidence: float, two_stands: bool = False, levelled: str = ANEW
) -> Comparison:
    """Hold B against A. `one_stand`: that both were measured on; without it the one that both results declare counts,
    `levelled` once for both or anew, unless there were `two_stands`. Raises BadInput where their units differ."""
    units = a.document.unit, b.document.unit
    if units[0] != units[1]:
        raise BadInput(f"outputs in {units[1]}, those of {file_name(a.name)} in {units[0]}: not compared", b.name)
    stand = one_stand if one_stand is not None or two_stands else _declared_by_both(a, b, levelled)
    terms = tuple(term for term in a.calibration.terms if term in b.calibration.terms)
    first, second, names = _with_in_common(a, b, stand)
    ratio, u_ratio = _gravities(a, b)
    found = judge(first.reduced(terms), second.reduced(terms).at_gravity(ratio), u_ratio, confidence)
    warnings, notes = [*_of_each(a, b), *_of_both(a, b)], _notes(a, b, ratio)
    if stand is not None and names is None and found.tests is not None:
        warnings.append(f"{file_name(stand.label)} {_NOT_THEIRS}: nothing is counted as shared")
    if found.tests is not None:
        notes.insert(0, _of_sharing(names, stand, two_stands))
    return Comparison(a, b, found, terms, names, stand, tuple(warnings), tuple(notes))


def _declared_by_both(a: Side, b: Side, levelled: str) -> OneStand | None:
    """The stand that both results declare, by the same name and as exact; None where they do not."""
    stand, other = stand_of(a.document, a.name), stand_of(b.document, b.name)
    if stand is None or other is None or not stand.name or stand.name != other.name or not shared.is_one(stand, other):
        return None
    return OneStand(stand.name, stand, None, (), levelled)


def _with_in_common(
    a: Side, b: Side, stand: OneStand | None
) -> tuple[Calibration, Calibration, tuple[str, ...] | None]:
    """Both calibrations with what they have in common told apart, and the names of its sources: None where no stand is
    that of both."""
    first, second = (None, None) if stand is None else (a.told_apart(stand), b.told_apart(stand))
    if first is None or second is None:
        return a.calibration, b.calibration, None
    names = tuple(name for name in first.returns if name in second.returns)
    split = [
        replace(side.calibration, covariance=apart.own, in_common=_stacked(apart, names, len(side.calibration.values)))
        for side, apart in ((a, first), (b, second))
    ]
    return split[0], split[1], names


def _stacked(apart: shared.Apart, names: tuple[str, ...], count: int) -> Floats:
    return np.concatenate([np.zeros((0, count)), *(apart.returns[name] for name in names)])


def _gravities(a: Side, b: Side) -> tuple[float, float]:
    """A's gravity over B's, and its relative standard uncertainty: of one place 1, and its error is in both."""
    (of_a, u_a), (of_b, u_b) = a.gravity, b.gravity
    if of_a is None or of_b is None or of_a == of_b:
        return 1.0, 0.0
    return of_a / of_b, float(np.hypot((u_a or 0.0) / of_a, (u_b or 0.0) / of_b))


def _of_each(a: Side, b: Side) -> list[str]:
    return [f"{file_name(side.name)}: {sentence}" for side in (a, b) for sentence in side.complaints]


def _of_both(a: Side, b: Side) -> list[str]:
    """Why the two may not be two calibrations of one block under one condition."""
    found = []
    for label, (one, other) in _labels(a, b).items():
        if one is not None and other is not None and one != other:
            found.append(f"{label} differs, {quoted(one)} and {quoted(other)}: not one block?")
    if a.document.run_sha256 is not None and a.document.run_sha256 == b.document.run_sha256:
        found.append("both are of one run: its noise is in both, but is counted as independent")
    warm = a.temperature, b.temperature
    if warm[0] is not None and warm[1] is not None:
        apart = max(warm[0].low_c - warm[1].high_c, warm[1].low_c - warm[0].high_c)
        if apart > TOLERANCE_C:
            found.append(f"A at {warm[0].text}, B at {warm[1].text}: temperature alone changes a block")
    dates = _run_date(a), _run_date(b)
    if all(dates) and dates[0] > dates[1]:
        found.append(f"A was measured on {dates[0]}, B before, on {dates[1]}: {_EXCHANGED}")
    for term in POWERS:
        if (term in a.terms) != (term in b.terms):
            which = "A" if term in a.terms else "B"
            found.append(f"{term} is in the model of {which} alone: the others mean something else with it")
    return found


def _run_date(side: Side) -> str:
    """The day of the run as its labels tell it, in the form of ISO 8601; empty where they do not."""
    tables = [side.document.item or {}, side.document.environment or {}]
    told = [str(one[key]) for one in tables for key in one if key.strip().lower().replace(" ", "_") in _DATES]
    return next((one[:10] for one in told if re.fullmatch(r"\d{4}-\d\d-\d\d([T ].*)?", one, re.ASCII)), "")


def _of_dates(a: Side, b: Side) -> list[str]:
    """That nothing tells which is the earlier one, or that it may be B: a run may also have been solved anew."""
    if _run_date(a) and _run_date(b):
        return []
    made = a.document.created, b.document.created
    if made[0] is None or made[1] is None:
        return ["Not both results are dated: that A is the earlier one is taken on trust."]
    return [f"A was solved after B, on {made[0][:10]} and {made[1][:10]}: {_EXCHANGED}"] if made[0] > made[1] else []


def _labels(a: Side, b: Side) -> dict[str, tuple[Any, Any]]:
    """What names the block: its serial number, and labels of [item] that speak of one."""
    items = a.document.item or {}, b.document.item or {}
    named = [label for label in items[0] if "serial" in label.lower()]
    return {
        "serial": (a.document.serial, b.document.serial),
        **{f"item.{label}": (items[0][label], items[1].get(label)) for label in named},
    }


def _of_sharing(names: tuple[str, ...] | None, one_stand: OneStand | None, two_stands: bool) -> str:
    """What was counted once."""
    if two_stands:
        return "Nothing is counted as shared, as they were measured on two stands."
    if names is None or one_stand is None:
        advice = " (--stand FILE)" if one_stand is None else ""
        return (
            "Nothing is counted as shared. That is right for two stands; on one, both have errors in common, which"
            f" cancel: u is too large then{advice}."
        )
    levelled = f"stand levelled {one_stand.levelled}"
    if not names:
        return f"Counted as shared: nothing, as nothing that this stand declares returns with every run ({levelled})."
    listed = ", ".join(_WORDS.get(name, name) for name in names)
    return f"Counted once, as both have it of one stand: {listed} ({levelled})."


def _notes(a: Side, b: Side, ratio: float) -> list[str]:
    """What the comparison rests on, and what it leaves out."""
    found = []
    gravities = a.gravity[0], b.gravity[0]
    if None in gravities:
        found.append("Taken to be measured at one gravity: not both results tell theirs.")
    elif ratio != 1.0:
        sure = all(side.gravity[1] is not None for side in (a, b))
        rest = "" if sure else ", whose uncertainty is not told and not counted"
        found.append(f"Gravity {gravities[0]:g} and {gravities[1]:g} m/s^2: B is given in A's g{rest}.")
    if "drift" in a.terms or "drift" in b.terms:
        found.append("A drift is the run's and not the block's: it is not compared.")
    if any(side.temperature is None for side in (a, b)):
        found.append("Not both results tell their temperature.")
    return found + _of_dates(a, b)
