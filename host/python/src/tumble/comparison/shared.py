"""What two calibrations have in common by the stand that both were measured on.

A result states the covariance of all errors together. The stand file tells them apart, and fixture.combination which of
them return with every run; they are propagated as the solve did it, for the schedule that both results know by the
numbers of its positions. That it was this stand and this schedule is not taken on trust: all sources together must
give the covariance that the result states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.core import CoreRefusal, CoreSchedule
from tumble.errors import UsageError
from tumble.files.stand_file import StandFile
from tumble.fixture.combination import repeats
from tumble.schedule import Schedule
from tumble.solving.many_runs import brought
from tumble.stand import Stand
from tumble.terms import DRIFT, Terms
from tumble.units import volts_per

_AGREEMENT = 1e-5  # of the standard uncertainties, of directions too: more than two computations differ by


@dataclass(frozen=True)
class Told:
    """A result's own: what its `document` says, the coefficients `k` (3, 3) and `covariance` (12, 12), and the `terms`
    that it was solved with, drift among them."""

    document: dict[str, Any]
    k: Floats
    covariance: Floats
    terms: Terms


@dataclass(frozen=True)
class Repeated:
    """What returns with every run, of one result: by source, draws (n, 12) of one standard deviation each; `schedule`:
    the one that the result was solved on."""

    schedule: str
    draws: dict[str, Floats]


def repeated(told: Told, stand: StandFile, schedules: Sequence[CoreSchedule], levelled_once: bool) -> Repeated | None:
    """By the first of the `schedules` with which the stand explains the covariance; None where none does."""
    for schedule in schedules:
        found = _by_source(told, stand, schedule.data)
        if found is not None and _explains(told, found):
            draws = {name: one for name, one in found.items() if repeats(name, levelled_once)}
            return Repeated(schedule.name or "", draws)
    return None


def in_common(a: Repeated, b: Repeated) -> Floats:
    """Covariance (12, 12) of A's coefficients with B's."""
    shared = np.zeros((12, 12))
    for name in a.draws.keys() & b.draws.keys():
        shared += a.draws[name].T @ b.draws[name]
    return shared


def _by_source(told: Told, stand: StandFile, schedule: Schedule) -> dict[str, Floats] | None:
    """None for a schedule that has other positions, or that this estimator cannot solve."""
    means, unit = told.document.get("means"), told.document["unit"]
    try:
        samples = {(one["mounting"], one["position"], one["use"]): int(one["samples"]) for one in means or ()}
    except (KeyError, TypeError, ValueError):
        return None
    places = [(position.mounting, position.number, position.use) for position in schedule.positions]
    if not samples or not samples.keys() <= set(places):
        return None
    part = schedule.part([place in samples for place in places])
    rows = np.array([samples[place] for place in places if place in samples])
    declared = _as_solved(stand.stand, told.terms).in_unit(unit)
    given = part, told.k, declared, told.document["estimator"], rows, stand.step_v / volts_per(unit), told.terms
    try:
        return brought(*given)
    except (CoreRefusal, UsageError, np.linalg.LinAlgError):
        return None


def _as_solved(stand: Stand, terms: Terms) -> Stand:
    """A drift that is an unknown is no error of the stand."""
    return stand.with_sigma("drift", 0.0) if DRIFT in terms else stand


def _explains(told: Told, draws: dict[str, Floats]) -> bool:
    """Whether these draws make up the covariance that was stated, or what is left can be noise that the run showed
    beyond the declared one."""
    u = np.sqrt(np.diag(told.covariance))
    if not (u > 0.0).all():
        return False
    scaled = np.concatenate(list(draws.values())) / u
    left = np.linalg.eigvalsh(told.covariance / np.outer(u, u) - scaled.T @ scaled)
    noise = told.document.get("noise")
    as_declared = isinstance(noise, dict) and not noise.get("above_declared") and not noise.get("undithered")
    return bool(left[0] > -_AGREEMENT and (left[-1] < _AGREEMENT or not as_declared))
