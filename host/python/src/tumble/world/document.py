"""What a run in a simulated world has found, as a document of schema tumble.bench/1 (docs/schemas), and its events."""

from __future__ import annotations

import math
from typing import Any

from tumble.errors import EXIT_DISAGREEMENT, EXIT_LIMITS_FAILED, EXIT_PASS, Interrupted
from tumble.world.border import ENDS, Border, text

Document = dict[str, Any]
_MICROSECOND = 1e-6


_WHOLE = 1e17  # below it a whole number is written without a point


def plain(value: Any) -> Any:
    """As it is written: unknown is null, a whole number has no point."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if isinstance(value, list):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return (
            None if not math.isfinite(value) else int(value) if value == int(value) and abs(value) < _WHOLE else value
        )
    return value


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


def _matrix(nine: Any) -> list[list[float]]:
    return [list(nine[3 * row : 3 * row + 3]) for row in range(3)]


def document(border: Border) -> Document:
    """All that is to be said of a run that has ended."""
    report = border.report()
    positions = [report.positions[i] for i in range(report.position_count)]
    found = {
        "schema": "tumble.bench/1",
        **_outcome(report),
        **_result(report, positions),
        "means": [
            {
                "mounting": one.mounting,
                "position": one.number,
                "samples": one.samples,
                "u_v": list(one.u_v),
                "standard_error_v": list(one.standard_error_v),
            }
            for one in positions
            if one.measured
        ],
        "counters": border.counters(),
        "truth": truth(report),
        "faults": [
            {"kind": text(report.faults[i].kind), "times": report.faults[i].times} for i in range(report.fault_count)
        ],
        "virtual_s": report.now_us * _MICROSECOND,
        "table": table(report),
    }
    told: Document = plain(found)
    return told


def _outcome(report: Any) -> Document:
    refusal = {
        "index": report.refused_index,
        "subindex": report.refused_subindex,
        "abort": report.refused_abort,
        "step": text(report.refused_step),
        "sentence": text(report.refused_sentence),
    }
    return {
        "seed": report.seed,
        "end": ENDS[report.end],
        "exit": exit_code(report),
        "state": text(report.state),
        "failed_in": text(report.failed_in),
        "reason": text(report.reason),
        "reason_number": report.reason_number,
        "reason_sentence": text(report.reason_sentence),
        "status": text(report.status),
        "drive_code": report.drive_code,
        "drive_refusal": refusal if report.refused_index else None,
    }


def _result(report: Any, positions: list[Any]) -> Document:
    known = report.has_result
    return {
        "estimator": text(report.estimator),
        "K": _matrix(report.k_v_per_g) if known else None,
        "U0": list(report.u0_v) if known else None,
        "u_K": _matrix(report.u_k_v_per_g) if report.has_uncertainty else None,
        "u_U0": list(report.u_u0_v) if report.has_uncertainty else None,
        "noise": _noise(report) if report.has_noise else None,
        "verification": _verification(report, positions) if known else None,
        "closure_g": list(report.closure_g[0 : report.mounting_count]) if known else None,
    }


def _noise(report: Any) -> Document:
    return {
        "block_samples": report.block_samples,
        "noise_v": list(report.noise_v),
        "declared_v": report.declared_v,
        "above_declared": [name for bit, name in enumerate("xyz") if report.above >> bit & 1],
    }


def _verification(report: Any, positions: list[Any]) -> Document:
    rows = [
        {
            "mounting": one.mounting,
            "position": one.number,
            "use": "fit" if one.fit else "check",
            "delta_g_g": one.delta_g_g,
        }
        for one in positions
    ]
    return {
        "delta_g_g": rows,
        "max_abs_delta_g_g": max(report.max_abs_fit_g, report.max_abs_check_g),
        "max_abs_fit_g": report.max_abs_fit_g,
        "max_abs_check_g": report.max_abs_check_g,
        "limit_g": report.limit_g,
        "pass": getattr(report, "pass"),
    }


def truth(report: Any) -> Document:
    """What was simulated."""
    mountings = report.mounting_count
    return {
        "K": _matrix(report.true_k_v_per_g),
        "U0": list(report.true_u0_v),
        "alpha1_rad": report.alpha1_rad,
        "alpha2_rad": report.alpha2_rad,
        "alpha3_rad": list(report.alpha3_rad[0:mountings]),
        "alpha4_rad": [report.positions[i].alpha4_rad for i in range(report.position_count)],
        "theta_h_rad": list(report.theta_h_rad[0:mountings]),
        "theta_n_rad": list(report.theta_n_rad[0:mountings]),
        "encoder_rad": list(report.encoder_rad),
        "drift_v": list(report.drift_v),
    }


def table(report: Any) -> Document:
    """How far the table has turned since power-on, by the simulation's truth."""
    return {"at_rest": report.at_rest, "lowest_deg": report.lowest_deg, "highest_deg": report.highest_deg}


# Events: what a person at a terminal, or a page that shows the run, is told while it goes on.


def _told(report: Any, name: str, own: Document) -> Document:
    event: Document = plain({"event": name, "virtual_s": report.now_us * _MICROSECOND, **own})
    return event


def _place(report: Any) -> Document:
    found = {name: getattr(report, name) for name in ("mounting", "position", "index", "count", "finished", "attempt")}
    return {"state": text(report.state), **found, "reason": text(report.reason), **_angle(report)}


def _angle(report: Any) -> Document:
    return {"angle_deg": report.angle_deg if report.has_angle else None}


def state(report: Any) -> Document:
    """The procedure has moved on."""
    return _told(report, "state", _place(report))


def angle(report: Any) -> Document:
    """The table turns."""
    return _told(report, "angle", _angle(report))


def average(report: Any) -> Document:
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


def question(report: Any) -> Document:
    """The firmware waits for a person."""
    kind = text(report.question)
    own: Document = {"kind": kind, "mounting": report.question_mounting}
    if kind == "angle":
        own["angle_deg"] = report.question_deg
    elif kind == "fault":
        own |= {"reason": text(report.question_reason), "sentence": text(report.question_sentence)}
    return _told(report, "question", own)
