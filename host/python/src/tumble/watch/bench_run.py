"""A run of the bench as a source: what its events have told, and its document at the end."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from tumble.watch.snapshot import Gravity, Matrix, Mean, Snapshot, Vector, without_prefix

NOT_THE_FORM = AttributeError, KeyError, OverflowError, TypeError, ValueError


class BenchRun:
    """Takes the events of a run (tumble.world.in_process) in one thread; is asked in another. `pace`: virtual seconds
    per second. `when_over` is called when the run is over."""

    def __init__(self, pace: float = 1.0) -> None:
        self.pace = pace
        self.when_over: Callable[[], object] = lambda: None
        self._lock = threading.Lock()
        self._snapshot = Snapshot()

    def snapshot(self) -> Snapshot:
        """What has been told so far."""
        with self._lock:
            return self._snapshot

    def close(self) -> None:
        """There is nothing to close."""

    def __call__(self, event: dict[str, Any]) -> None:
        """Take an event."""
        with self._lock:
            self._snapshot = after_event(self._snapshot, event)

    def ended(self, document: dict[str, Any]) -> None:
        """Take the run's document: nothing more will be told."""
        with self._lock:
            self._snapshot = replace(after_document(self._snapshot, document), over=True)
        self.when_over()

    def failed(self, why: str) -> None:
        """It has ended without a document."""
        with self._lock:
            self._snapshot = replace(self._snapshot, over=True, trouble=why)
        self.when_over()


def after_event(before: Snapshot, event: dict[str, Any]) -> Snapshot:
    """The snapshot with what an event tells."""
    kind = event["event"]
    if kind not in ("state", "average", "angle"):
        return before
    angle_deg = event.get("angle_deg")
    after = replace(
        before, virtual_s=event.get("virtual_s"), angle_rad=None if angle_deg is None else math.radians(angle_deg)
    )
    if kind == "angle":
        return after
    after = replace(
        after,
        state=without_prefix(event["state"]),
        reason=_reason(event["reason"]),
        **{name: event[name] for name in ("mounting", "position", "count", "finished", "attempt")},
    )
    if kind == "state":
        return replace(after, samples=None)
    return replace(after, samples=event["samples"], wanted=event["wanted"], mean=_mean(before, event))


def after_document(before: Snapshot, document: dict[str, Any]) -> Snapshot:
    """The snapshot with what the document of a bench run (tumble.bench/1) or a result (tumble.result/1) tells. Raises
    one of NOT_THE_FORM where it is neither."""
    check = document.get("verification")
    after = replace(
        before,
        k_v_per_g=matrix(document["K"]),
        u0_v=vector(document.get("U0")),
        u_k_v_per_g=matrix(document.get("u_K")),
        u_u0_v=vector(document.get("u_U0")),
        gravity=None if check is None else _gravity(check),
    )
    if "state" not in document:
        return after
    return replace(after, reason=_reason(document["reason"]), state=without_prefix(document["state"]))


def _mean(before: Snapshot, event: dict[str, Any]) -> Mean | None:
    mean = vector(event["mean_v"])
    if mean is None:
        return before.mean
    place = event["mounting"], event["position"], event["samples"], event["wanted"]
    return Mean(*place, mean, vector(event["standard_error_v"]))


def _reason(name: str) -> str | None:
    name = without_prefix(name)
    return None if name == "NONE" else name


def _gravity(check: dict[str, Any]) -> Gravity:
    worst: dict[str, list[float]] = {"fit": [], "check": []}
    for row in check["delta_g_g"]:
        worst[row["use"]].append(abs(row["delta_g_g"]))
    fit, checked = (max(worst[use], default=None) for use in ("fit", "check"))
    return Gravity(fit, checked, float(check["limit_g"]), check["pass"])


def vector(numbers: list[float] | None) -> Vector | None:
    """A list from a document; None stays."""
    return None if numbers is None else _three(numbers)


def matrix(rows: list[list[float]] | None) -> Matrix | None:
    """A list of lists from a document; None stays."""
    if rows is None:
        return None
    x, y, z = map(_three, rows)
    return x, y, z


def _three(numbers: list[float]) -> Vector:
    x, y, z = map(float, numbers)
    return x, y, z
