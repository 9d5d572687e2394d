"""What two calibrations have in common by the stand that both were measured on.

A result states the covariance of all errors together. The declared stand tells them apart, and fixture.combination
which of them return with every run; they are propagated as the solve did it, on the schedule of each result. Stand and
schedule are not taken on trust: all sources together must give the covariance that the result states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.core import MAX_SAMPLES, CoreRefusal, CoreSchedule
from tumble.errors import BadInput, UsageError
from tumble.estimators import ESTIMATORS
from tumble.fixture.combination import repeats
from tumble.schedule import Mounting, Position, Schedule
from tumble.solving.many_runs import brought
from tumble.stand import COMMON, INDEPENDENT, LIMIT_KINDS, Stand
from tumble.terms import DRIFT, Terms
from tumble.units import volts_per

ONCE, ANEW = LEVELLED = ("once", "anew")
_LARGEST = 1e9  # of an error of a stand, as stand files have it
_AGREEMENT = 1e-5  # of the standard uncertainties, in any direction: more than two computations differ by


@dataclass(frozen=True)
class OneStand:
    """That both results were measured on: what is declared of it, the step of the converter (None: not known), the
    `schedules` that a result was measured by that does not tell its own, and whether it was `levelled` once for both or
    anew. `label`: what a person calls it."""

    label: str
    stand: Stand
    step_v: float | None
    schedules: Sequence[CoreSchedule]
    levelled: str


@dataclass(frozen=True)
class Told:
    """A result's own: its `name` and `document`, the coefficients `k` (3, 3) and `covariance` (12, 12), and the `terms`
    that it was solved with, drift among them."""

    name: str
    document: dict[str, Any]
    k: Floats
    covariance: Floats
    terms: Terms


Draws = dict[str, Floats]  # by source: (draws, 12), one standard deviation of each


def repeated(told: Told, one_stand: OneStand) -> Draws | None:
    """What returns with every run: by the first schedule with which the stand explains the covariance; None where none
    does. Raises BadInput for a result whose own schedule is none."""
    own = _schedule_of(told)
    for schedule in one_stand.schedules if own is None else [own]:
        found = _by_source(told, one_stand, schedule.data)
        if found is not None and _explains(told, found, one_stand.step_v is not None):
            once = one_stand.levelled == ONCE
            return {name: draws for name, draws in found.items() if repeats(name, once)}
    return None


def in_common(a: Draws, b: Draws) -> Floats:
    """Covariance (12, 12) of A's coefficients with B's."""
    shared = np.zeros((12, 12))
    for name in a.keys() & b.keys():
        shared += a[name].T @ b[name]
    return shared


def stand_of(document: dict[str, Any], name: str) -> Stand | None:
    """That a result declares; None where it tells none. Raises BadInput."""
    told = document.get("stand")
    if told is None:
        return None
    try:
        keys: dict[str, Any] = {attribute: float(told[key]) for attribute, key in _KEYS.items()}
        small = all(0.0 <= size < _LARGEST for size in keys.values())
        keys |= {"limits": told["limits"], "remounting": told["remount"], "name": told["name"] or ""}
        stand = Stand(**keys, samples=int(told["samples"]))
        if small and stand.limits in LIMIT_KINDS and stand.remounting in (INDEPENDENT, COMMON) and stand.samples > 0:
            return stand
    except (KeyError, TypeError, ValueError, OverflowError):
        pass
    raise BadInput("its stand is not as tumble solve writes it", name)


_KEYS = {  # of a result's stand, by the attributes of Stand
    "axis_tilt": "axis_tilt_rad",
    "level": "level_rad",
    "remount": "remount_rad",
    "angle": "angle_rad",
    "noise": "noise_v",
    "seat": "seat_rad",
    "platform": "platform_rad",
    "encoder": "encoder_rad",
    "drift": "drift_v",
}


def _schedule_of(told: Told) -> CoreSchedule | None:
    """The result's own; None where it does not tell it."""
    found = told.document.get("schedule")
    if found is None:
        return None
    try:
        mountings = tuple(
            Mounting(one["number"], tuple(map(tuple, one["matrix"])), one["axis_tilt_deg"]) for one in found["mounting"]
        )
        positions = tuple(
            Position(one["mounting"], one["position"], one["angle_deg"], one["use"]) for one in found["position"]
        )
        return CoreSchedule(Schedule(mountings, positions))
    except (KeyError, TypeError, ValueError, OverflowError, CoreRefusal):
        raise BadInput("its schedule is not as tumble solve writes it", told.name) from None


def _by_source(told: Told, one_stand: OneStand, schedule: Schedule) -> Draws | None:
    """None for a schedule that has other positions, or that this estimator cannot solve."""
    unit = told.document["unit"]
    try:
        means = told.document.get("means") or ()
        samples = {(one["mounting"], one["position"], one["use"]): int(one["samples"]) for one in means}
    except (KeyError, TypeError, ValueError, OverflowError):
        return None
    places = [(position.mounting, position.number, position.use) for position in schedule.positions]
    if not samples or not samples.keys() <= set(places) or not 0 < min(samples.values()) <= MAX_SAMPLES:
        return None
    if told.document["estimator"] not in ESTIMATORS:
        return None
    part = schedule.part([place in samples for place in places])
    rows = np.array([samples[place] for place in places if place in samples])
    declared = _as_solved(one_stand.stand, told.terms).in_unit(unit)
    step = (one_stand.step_v or 0.0) / volts_per(unit)
    try:
        return brought(part, told.k, declared, told.document["estimator"], rows, step, told.terms)
    except (CoreRefusal, UsageError, np.linalg.LinAlgError):
        return None


def _as_solved(stand: Stand, terms: Terms) -> Stand:
    """A drift that is an unknown is no error of the stand."""
    return stand.with_sigma("drift", 0.0) if DRIFT in terms else stand


def _explains(told: Told, draws: Draws, knows_step: bool) -> bool:
    """Whether these draws make up the covariance that was stated, or what is left can be noise that the run showed
    beyond the declared one, or steps of a converter that nobody tells."""
    u = np.sqrt(np.diag(told.covariance))
    if not (u > 0.0).all():
        return False
    scaled = np.concatenate(list(draws.values())) / u
    left = np.linalg.eigvalsh(told.covariance / np.outer(u, u) - scaled.T @ scaled)
    noise = told.document.get("noise")
    is_told = isinstance(noise, dict) and not noise.get("above_declared") and not noise.get("undithered")
    as_declared = knows_step and is_told
    return bool(left[0] > -_AGREEMENT and (left[-1] < _AGREEMENT or not as_declared))
