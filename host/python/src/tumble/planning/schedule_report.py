"""The quickest schedule: for JSON, and for people."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from typing import Any

from tumble.model import reliability
from tumble.planning import model_cost, tables
from tumble.planning.case import SCHEMA
from tumble.planning.require import growing
from tumble.planning.schedule_search import Planned, Timed
from tumble.schedule import Mounting, Schedule
from tumble.solving.result import unseen_keys
from tumble.terms import Terms

_TABLE_AXES = "hnv"


def document(found: Planned, step_deg: float) -> dict[str, Any]:
    """The plan for JSON, schema tumble.plan/1. Times in seconds."""
    goal, case = found.goal, found.case
    wanted = {"norm_g": goal.norm_g, "limit_g": None, "probability": None}
    if goal.norm_g is None:
        wanted = {"norm_g": None, "limit_g": case.limit_g, "probability": goal.probability}
    return {
        "schema": SCHEMA,
        "plan": "schedule",
        "stand": case.stand.name,
        "block": {"scale_v_per_g": case.scale, "misalignment_rad": case.misalignment},
        "estimator": goal.estimator,
        "goal": wanted,
        "angles_deg": step_deg,
        "pace": {
            "velocity_deg_per_s": found.pace.velocity,
            "acceleration_deg_per_s2": found.pace.acceleration,
            "settling_s": found.pace.settling,
            "sample_rate_hz": found.pace.rate,
            "remounting_s": found.pace.remounting,
        },
        "schedule": {**_timed(found.best, case.terms), **_positions(found.best.schedule)},
        "u_norm_g": {"worst_g": found.u_norm_g, "attitude": found.attitude},
        "promise": growing(found.promise),
        **unseen_keys(found.unseen),
        **model_cost.document(found.further),
        "beside": {name: None if timed is None else _timed(timed, case.terms) for name, timed in found.beside.items()},
    }


def _timed(timed: Timed, terms: Terms) -> dict[str, Any]:
    return {
        "mountings": len(timed.schedule.mountings),
        "positions": len(timed.schedule.positions),
        "samples": timed.samples,
        "freedom": freedom(timed, terms),
        "seconds": timed.duration.total,
        **{f"{part}_s": seconds for part, seconds in asdict(timed.duration).items()},
    }


def _positions(schedule: Schedule) -> dict[str, Any]:
    return {
        "matrices": [[list(row) for row in mounting.matrix] for mounting in schedule.mountings],
        "angles_deg": [_angles(schedule, mounting) for mounting in schedule.mountings],
    }


def _angles(schedule: Schedule, mounting: Mounting) -> list[float]:
    return [position.angle_deg for position in schedule.positions if position.mounting == mounting.number]


def show(found: Planned, written: str | None, stand: str | None) -> None:
    """Print the plan on standard output. `written`: the file that it went to; `stand`: that of the stand."""
    out, goal, pace = tables.console(), found.goal, found.pace
    wanted = f"a worst u(|a|) of {1e6 * (goal.norm_g or 0.0):.4g} ug"
    if goal.norm_g is None:
        wanted = f"{found.case.limit_g:g} g with {100 * goal.probability:g} %"
    out.print(tables.heading(f"Quickest schedule found for {wanted}, estimator {goal.estimator}"))
    out.print(f"Stand: {found.case.stand.name or 'without a name'}")
    rows = [_row("found", found.best), *(_row(name, timed) for name, timed in found.beside.items())]
    headings = ("", "positions", "samples", "moving", "settling", "averaging", "in all, s")
    out.print(tables.table(headings, rows))
    out.print(f"positions: in so many mountings, {pace.remounting:g} s for each after the first (--remounting)")
    for mounting in found.best.schedule.mountings:
        axes = ", ".join(f"{axis} {_along(row)}" for axis, row in zip("xyz", mounting.matrix))
        angles = " ".join(f"{angle:g}" for angle in _angles(found.best.schedule, mounting))
        out.print(f"Mounting {mounting.number}: {axes} (h across, n along the axis, v up at 0);")
        out.print(f"  table at {angles} deg")
    out.print(
        f"Worst u(|a|): {1e6 * found.u_norm_g:.4g} ug;"
        f" {freedom(found.best, found.case.terms)} degrees of freedom check the model"
    )
    if found.further is not None:
        out.print(model_cost.sentence(found.further))
    if (note := found.case.rounding_sentence) is not None:
        out.print(note)
    out.print(found.promise.sentence)
    for line in reliability.lines(found.unseen):
        out.print(line)
    if written is not None:
        files = ["--schedule", written, *([] if stand is None else ["--stand", stand])]
        options = f"{shlex.join(files)} --samples {found.best.samples} --estimator {goal.estimator}"
        options += f" --model {','.join(found.case.terms)}" if found.case.terms else ""
        out.print(f"Run it: tumble bench {options}", soft_wrap=True)


def freedom(timed: Timed, terms: Terms = ()) -> int:
    """Of the residuals: what a fit, with further `terms`, leaves to show that the model holds."""
    return 3 * (len(timed.schedule.positions) - len(terms)) - 12


def _row(name: str, timed: Timed | None) -> tuple[str, ...]:
    if timed is None:
        return (name, *["-"] * 5, "out of reach")
    time = timed.duration
    positions = f"{len(timed.schedule.positions)} in {len(timed.schedule.mountings)}"
    seconds = (time.moving, time.settling, time.averaging, time.total)
    return (name, positions, str(timed.samples), *(f"{part:.1f}" for part in seconds))


def _along(row: tuple[float, ...]) -> str:
    """The table axis that a block axis lies along, as in "-h"."""
    index = max(range(3), key=lambda axis: abs(row[axis]))
    return ("-" if row[index] < 0 else "+") + _TABLE_AXES[index]
