"""From two results to a comparison: what of them can be compared, what they share, and what a person should know.

What two calibrations have in common comes from the stand that both were measured on. A result states the covariance of
all errors together. The declared stand tells them apart, and fixture.judge which of them return with every run; they
are propagated as the solve did it, on the schedule of each result. Stand and schedule are not taken on trust: all
sources together must give the covariance that the result states.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from msgspec import UnsetType

from tumble.arrays import Floats
from tumble.comparison.verdict import Calibration, Found, Verdict, is_covariance, judge, test_of
from tumble.core import MAX_SAMPLES, CoreRefusal, CoreSchedule
from tumble.defaults import ANEW, ONCE
from tumble.documents.result import Result
from tumble.errors import BadInput, UsageError, file_name, quoted
from tumble.estimators import ESTIMATORS, NORM
from tumble.files.rows import Temperatures
from tumble.fixture.judge import repeats
from tumble.model.propagation import Propagation
from tumble.schedule import Schedule
from tumble.solving.coefficients import Coefficients, gravity_of
from tumble.solving.decision import GRAVITY, UNCERTAINTY, Decision
from tumble.solving.plausibility import TOLERANCE_C
from tumble.solving.result import as_shown, schedule_of, stand_of
from tumble.stand import SOURCES, PerChannel, Stand, over
from tumble.terms import DRIFT, KEYS, Terms, expanded, model_of
from tumble.units import volts_per

_AGREEMENT = 1e-5  # of the standard uncertainties, in any direction: more than two computations differ by
_SAME = 1e-9  # relative: two ways of writing one standard deviation differ by less
_NOT_THEIRS = "with a schedule that is known (--schedule) does not give the uncertainties of both"
_DATES = ("date", "run_date")  # labels of the day of a run
_EXCHANGED = "exchanged? A is to be the earlier one"
_WORDS = {"alpha1": "axis tilt", "alpha2": "level"}  # of sources whose names are none

Draws = dict[str, Floats]  # by source: (draws, 12 + 3 x terms), one standard deviation of each


@dataclass(frozen=True)
class OneStand:
    """That both results were measured on: what is declared of it, the step of the converter (None: not known), the
    `schedules` that a result was measured by that does not tell its own, and whether it was `levelled` once for both or
    anew. `label`: what a person calls it. Of its `stand`, what is each run's own is as the result itself declares it,
    where it does."""

    label: str
    stand: Stand
    step_v: PerChannel | None
    schedules: Sequence[CoreSchedule]
    levelled: str


@dataclass(frozen=True)
class ComparedResult:
    """One of the two results: its `name`, its `document`, `complaints` about it, and its `calibration`."""

    name: str
    document: Result
    complaints: tuple[str, ...]
    calibration: Calibration

    @classmethod
    def of(cls, name: str, document: Result, complaints: Sequence[str] = ()) -> ComparedResult:
        """Raises BadInput for a singular K, for a covariance that is none, and for a result with a prior in it."""
        if not isinstance(document.prior, UnsetType) and document.prior.used:
            raise BadInput("rests on an earlier calibration, which hides a change: solve it without --prior", name)
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
        """That it was solved with beside the twelve coefficients, drift among them."""
        return () if self.document.extended is None else expanded(self.document.extended.terms)

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
    def temperature(self) -> Temperatures | None:
        """Of its run; None: not told."""
        told = self.document.temperature
        return None if told is None else Temperatures(told.min_c, told.max_c, "")

    @property
    def gravity(self) -> tuple[float | None, float | None]:
        """Where it was measured, with its standard uncertainty, m/s^2; None: not told."""
        return gravity_of(self.document.environment)

    def told_apart(self, one_stand: OneStand) -> tuple[Floats, Draws] | None:
        """Its covariance in two: its own, and what returns with every run on the stand; by the first schedule with
        which the stand explains the covariance. None where none does. Raises BadInput for a result whose own schedule
        is none."""
        if self.calibration.covariance is None:
            return None
        own_stand, schedule = stand_of(self.document, self.name), schedule_of(self.document, self.name)
        if own_stand is not None and _is_one(own_stand, one_stand.stand):
            one_stand = replace(one_stand, stand=own_stand)
        for one in one_stand.schedules if schedule is None else [schedule]:
            found = self._by_source(one_stand, one.data)
            beyond = None if found is None else self._beyond(found, one_stand.step_v is not None)
            if found is not None and beyond is not None:
                once = one_stand.levelled == ONCE
                returns = {name: draws for name, draws in found.items() if repeats(name, once)}
                own = [draws.T @ draws for name, draws in found.items() if name not in returns]
                return sum(own, beyond), returns
        return None

    def _by_source(self, one_stand: OneStand, schedule: Schedule) -> Draws | None:
        """None for a schedule that has other positions, or that this estimator cannot solve."""
        document, k = self.document, self.calibration.k
        samples = {(one.mounting, one.position, one.use): one.samples for one in document.means}
        places = [(position.mounting, position.number, position.use) for position in schedule.positions]
        counted = samples and all(0 < one <= MAX_SAMPLES for one in samples.values())
        if not counted or not samples.keys() <= set(places) or document.estimator not in (*ESTIMATORS, NORM):
            return None
        part = as_shown(schedule, document).part([place in samples for place in places])
        rows = np.array([samples[place] for place in places if place in samples])
        declared = one_stand.stand.without(self.terms).in_unit(document.unit)
        step = over(one_stand.step_v or 0.0, volts_per(document.unit))
        given = Propagation(part, k, declared, rows, document.estimator, step, self.terms)
        try:
            return {name: self._of_values(draws) for name, draws in given.brought().items()}
        except (CoreRefusal, UsageError, np.linalg.LinAlgError):
            return None

    def _of_values(self, sizes: Floats) -> Floats:
        """What draws bring to the calibration's values, by what they bring to the coefficients and to the sizes of all
        terms: a size is K_ii times K2. A drift is none of the values."""
        k, found = np.diag(self.calibration.k), [sizes[:, :12]]
        for place, term in enumerate(self.calibration.terms):
            value = self.calibration.values[12 + 3 * place : 15 + 3 * place]
            start = 12 + 3 * self.terms.index(term)
            found.append((sizes[:, start : start + 3] - value * sizes[:, [0, 4, 8]]) / k)
        return np.concatenate(found, axis=1)

    def _beyond(self, draws: Draws, knows_step: bool) -> Floats | None:
        """What the covariance that was stated has beyond these draws: noise that the run showed beyond the declared
        one, or steps of a converter that nobody tells. None where these draws cannot make it up."""
        stated = self.calibration.covariance
        assert stated is not None  # as the caller has seen to
        u = np.sqrt(np.diag(stated))
        if not (u > 0.0).all():
            return None
        scaled = np.concatenate(list(draws.values())) / u
        variance, directions = np.linalg.eigh(stated / np.outer(u, u) - scaled.T @ scaled)
        noise = self.document.noise
        is_told = noise is not None and not noise.above_declared and not noise.undithered
        if variance[0] < -_AGREEMENT or (knows_step and is_told and variance[-1] > _AGREEMENT):
            return None
        columns = directions * u[:, None]
        found: Floats = (columns * np.where(variance > _AGREEMENT, variance, 0.0)) @ columns.T
        return found


def _is_one(a: Stand, b: Stand) -> bool:
    """Whether two declarations may be of one stand: by the standard deviations of its axis and table, however these are
    written (`limits`). How many samples were averaged, noise, drift, and how the block was mounted are of each run and
    its block."""
    told = [source.attribute for source in SOURCES.values() if source.identifies]
    return all(math.isclose(a.sigma(source), b.sigma(source), rel_tol=_SAME) for source in told)


@dataclass(frozen=True)
class Comparison:
    """B held against A. `terms`: further ones as far as both have them; `shared`: names of the errors that were counted
    once, None where no stand was named, or where it is not the stand of both."""

    a: ComparedResult
    b: ComparedResult
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


def compare(
    a: ComparedResult,
    b: ComparedResult,
    one_stand: OneStand | None,
    confidence: float,
    two_stands: bool = False,
    levelled: str = ANEW,
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
    if NORM in (a.document.estimator, b.document.estimator) and found.tests is not None:  # whose frame is its own
        found = replace(found, tests=replace(found.tests, seat=test_of(0.0, 3)))
    warnings = [f"{file_name(compared.name)}: {sentence}" for compared in (a, b) for sentence in compared.complaints]
    warnings, notes = [*warnings, *_of_both(a, b)], _notes(a, b, ratio)
    if stand is not None and names is None and found.tests is not None:
        warnings.append(f"{file_name(stand.label)} {_NOT_THEIRS}: nothing is counted as shared")
    if found.tests is not None:
        notes.insert(0, _of_sharing(names, stand, two_stands))
    return Comparison(a, b, found, terms, names, stand, tuple(warnings), tuple(notes))


def _declared_by_both(a: ComparedResult, b: ComparedResult, levelled: str) -> OneStand | None:
    """The stand that both results declare, by the same name and as exact; None where they do not."""
    stand, other = stand_of(a.document, a.name), stand_of(b.document, b.name)
    if stand is None or other is None or not stand.name or stand.name != other.name or not _is_one(stand, other):
        return None
    return OneStand(stand.name, stand, None, (), levelled)


def _with_in_common(
    a: ComparedResult, b: ComparedResult, stand: OneStand | None
) -> tuple[Calibration, Calibration, tuple[str, ...] | None]:
    """Both calibrations with what they have in common told apart, and the names of its sources: None where no stand is
    that of both."""
    first, second = (None, None) if stand is None else (a.told_apart(stand), b.told_apart(stand))
    if first is None or second is None:
        return a.calibration, b.calibration, None
    names = tuple(name for name in first[1] if name in second[1])
    split = []
    for compared, (own, returns) in ((a, first), (b, second)):
        in_common = [np.zeros((0, len(compared.calibration.values))), *(returns[name] for name in names)]
        split.append(replace(compared.calibration, covariance=own, in_common=np.concatenate(in_common)))
    return split[0], split[1], names


def _gravities(a: ComparedResult, b: ComparedResult) -> tuple[float, float]:
    """A's gravity over B's, and its relative standard uncertainty: of one place 1, and its error is in both."""
    (of_a, u_a), (of_b, u_b) = a.gravity, b.gravity
    if of_a is None or of_b is None or of_a == of_b:
        return 1.0, 0.0
    return of_a / of_b, float(np.hypot((u_a or 0.0) / of_a, (u_b or 0.0) / of_b))


def _of_both(a: ComparedResult, b: ComparedResult) -> list[str]:
    """Why the two may not be two calibrations of one block under one condition."""
    found = []
    items = a.document.item or {}, b.document.item or {}
    named = [label for label in items[0] if "serial" in label.lower()]  # what speaks of the block
    labels: dict[str, tuple[Any, Any]] = {"serial": (a.document.serial, b.document.serial)}
    labels |= {f"item.{label}": (items[0][label], items[1].get(label)) for label in named}
    for label, (one, other) in labels.items():
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
    models = model_of(a.terms), model_of(b.terms)
    for term in (one for one in KEYS if one != DRIFT):
        if (term in models[0]) != (term in models[1]):
            which = "A" if term in models[0] else "B"
            found.append(f"{term} is in the model of {which} alone: the others mean something else with it")
    return found


def _run_date(compared: ComparedResult) -> str:
    """The day of the run as its labels tell it, in the form of ISO 8601; empty where they do not."""
    tables = [compared.document.item or {}, compared.document.environment or {}]
    told = [str(one[key]) for one in tables for key in one if key.strip().lower().replace(" ", "_") in _DATES]
    return next((one[:10] for one in told if re.fullmatch(r"\d{4}-\d\d-\d\d([T ].*)?", one, re.ASCII)), "")


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
    if not names:
        because = ", because the stand was levelled again" if one_stand.levelled == ANEW else ""
        return f"No stand error is common to both runs{because}."
    listed = ", ".join(_WORDS.get(name, name) for name in names)
    return f"Counted once, as both have it of one stand: {listed} (stand levelled {one_stand.levelled})."


def _notes(a: ComparedResult, b: ComparedResult, ratio: float) -> list[str]:
    """What the comparison rests on, and what it leaves out."""
    found = []
    if NORM in (a.document.estimator, b.document.estimator):
        found.append("A result by |a| alone has a frame of its own: the seat, and K element by element, say nothing.")
    gravities = a.gravity[0], b.gravity[0]
    if None in gravities:
        found.append("Assumed the same local gravity: at least one result does not state it.")
    elif ratio != 1.0:
        sure = all(compared.gravity[1] is not None for compared in (a, b))
        rest = "" if sure else ", whose uncertainty is unknown and not counted"
        found.append(f"Gravity {gravities[0]:g} and {gravities[1]:g} m/s^2: B is given in A's g{rest}.")
    if "drift" in a.terms or "drift" in b.terms:
        found.append("A drift is the run's and not the block's: it is not compared.")
    if any(compared.temperature is None for compared in (a, b)):
        found.append("Not both results tell their temperature.")
    if not (_run_date(a) and _run_date(b)):  # a run may also have been solved anew
        made = a.document.created, b.document.created
        if made[0] is None or made[1] is None:
            found.append("Not both results are dated: that A is the earlier one is taken on trust.")
        elif made[0] > made[1]:
            found.append(f"A was solved after B, on {made[0][:10]} and {made[1][:10]}: {_EXCHANGED}")
    return found
