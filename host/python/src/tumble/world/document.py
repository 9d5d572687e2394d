"""What a run in a simulated world has found, as tumble.documents.bench has it, and its events."""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec import UNSET

from tumble.arrays import Floats
from tumble.documents.bench import (
    Bench,
    Deviation,
    Fault,
    GravityCheck,
    Mean,
    NoiseOnBoard,
    Refusal,
    Truth,
    written,
)
from tumble.documents.result import Table
from tumble.errors import EXIT_DISAGREEMENT, EXIT_LIMITS_FAILED, EXIT_PASS, Interrupted
from tumble.world.border import ENDS, Border, text

Event = dict[str, Any]
_MICROSECOND = 1e-6


def exit_code(report: Any) -> int:
    """Of a program with this run."""
    end = ENDS[report.end]
    if end == "interrupted":
        return Interrupted.exit_code
    if end == "left":
        return EXIT_PASS
    if end != "done" or not report.has_result:
        return EXIT_DISAGREEMENT
    return EXIT_PASS if getattr(report, "pass") else EXIT_LIMITS_FAILED


def document(border: Border) -> Bench:
    """All that is to be said of a run that has ended."""
    report = border.report()
    positions = [report.positions[i] for i in range(report.position_count)]
    known, stated = report.has_result, report.has_uncertainty
    refusal = Refusal(
        report.refused_index,
        report.refused_subindex,
        report.refused_abort,
        text(report.refused_step),
        text(report.refused_sentence),
    )
    means = (
        Mean(one.mounting, one.number, one.samples, np.array(list(one.u_v)), np.array(list(one.standard_error_v)))
        for one in positions
        if one.measured
    )
    return Bench(
        seed=report.seed,
        end=ENDS[report.end],
        exit=exit_code(report),
        state=text(report.state),
        failed_in=text(report.failed_in),
        reason=text(report.reason),
        reason_number=report.reason_number,
        reason_sentence=text(report.reason_sentence),
        status=text(report.status),
        drive_code=report.drive_code,
        drive_refusal=refusal if report.refused_index else None,
        estimator=text(report.estimator),
        K=_matrix(report.k_v_per_g) if known else None,
        U0=np.array(list(report.u0_v)) if known else None,
        u_K=_matrix(report.u_k_v_per_g) if stated else None,
        u_U0=np.array(list(report.u_u0_v)) if stated else None,
        noise=_noise(report) if report.has_noise else None,
        verification=_verification(report, positions) if known else None,
        closure_g=tuple(report.closure_g[0 : report.mounting_count]) if known else None,
        means=tuple(means),
        counters=border.counters(),
        truth=truth(report),
        faults=tuple(Fault(text(one.kind), one.times) for one in report.faults[0 : report.fault_count]),
        virtual_s=report.now_us * _MICROSECOND,
        table=table(report),
    )


def _matrix(nine: Any) -> Floats:
    found: Floats = np.array(list(nine)).reshape(3, 3)
    return found


def _noise(report: Any) -> NoiseOnBoard:
    above = tuple(name for bit, name in enumerate("xyz") if report.above >> bit & 1)
    return NoiseOnBoard(report.block_samples, np.array(list(report.noise_v)), report.declared_v, above)


def _verification(report: Any, positions: list[Any]) -> GravityCheck:
    rows = (Deviation(one.mounting, one.number, "fit" if one.fit else "check", one.delta_g_g) for one in positions)
    return GravityCheck(
        tuple(rows),
        max(report.max_abs_fit_g, report.max_abs_check_g),
        report.max_abs_fit_g,
        report.max_abs_check_g,
        report.limit_g,
        getattr(report, "pass"),
    )


def truth(report: Any) -> Truth:
    """What was simulated."""
    mountings, positions = range(report.mounting_count), range(report.position_count)
    return Truth(
        K=_matrix(report.true_k_v_per_g),
        U0=np.array(list(report.true_u0_v)),
        alpha1_rad=report.alpha1_rad,
        alpha2_rad=report.alpha2_rad,
        alpha3_rad=tuple(report.alpha3_rad[i] for i in mountings),
        alpha4_rad=tuple(report.positions[i].alpha4_rad for i in positions),
        theta_h_rad=tuple(report.theta_h_rad[i] for i in mountings),
        theta_n_rad=tuple(report.theta_n_rad[i] for i in mountings),
        encoder_rad=tuple(report.encoder_rad),
        drift_v=tuple(report.drift_v),
        beta_rad=tuple(report.beta_rad[i] for i in mountings) if report.inclines else UNSET,
        tau_rad=tuple(report.tau_rad[i] for i in mountings) if report.inclines else UNSET,
    )


def table(report: Any) -> Table:
    """How far the table has turned since power-on, by the simulation's truth."""
    return Table(report.at_rest, report.lowest_deg, report.highest_deg)


# Events: what a person at a terminal, or a page that shows the run, is told while it goes on.


def _told(report: Any, name: str, own: Event) -> Event:
    event: Event = written({"event": name, "virtual_s": report.now_us * _MICROSECOND, **own})
    return event


def _place(report: Any) -> Event:
    found = {name: getattr(report, name) for name in ("mounting", "position", "index", "count", "finished", "attempt")}
    return {"state": text(report.state), **found, "reason": text(report.reason), **_angle(report)}


def _angle(report: Any) -> Event:
    return {"angle_deg": report.angle_deg if report.has_angle else None}


def state(report: Any) -> Event:
    """The procedure has moved on."""
    return _told(report, "state", _place(report))


def angle(report: Any) -> Event:
    """The table turns."""
    return _told(report, "angle", _angle(report))


def average(report: Any) -> Event:
    """A position's running mean."""
    known = report.has_mean
    own = {
        **_place(report),
        "samples": report.samples,
        "wanted": report.wanted,
        "mean_v": list(report.mean_v) if known else None,
        "standard_error_v": list(report.standard_error_v) if known else None,
    }
    return _told(report, "average", own)


def question(report: Any) -> Event:
    """The firmware waits for a person."""
    kind = text(report.question)
    own: Event = {"kind": kind, "mounting": report.question_mounting}
    if kind == "angle":
        own["angle_deg"] = report.question_deg
    elif kind == "fault":
        own |= {"reason": text(report.question_reason), "sentence": text(report.question_sentence)}
    return _told(report, "question", own)
