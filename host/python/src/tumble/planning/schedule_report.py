"""The quickest schedule: for JSON, and for people."""

from __future__ import annotations

import shlex
from dataclasses import asdict
from typing import Any

import numpy as np

from tumble.documents import plan
from tumble.documents.plan import Quickest
from tumble.documents.result import WorstNorm
from tumble.model import reliability
from tumble.planning import model_cost, tables
from tumble.planning.model_cost import model_cost_part
from tumble.planning.promise import sentence
from tumble.planning.schedule_search import Planned, Timed
from tumble.schedule import Mounting, Schedule
from tumble.solving.result import unseen
from tumble.terms import Terms

_TABLE_AXES = "hnv"


def document(found: Planned, step_deg: float) -> Quickest:
    """The plan for JSON."""
    goal, case, pace, schedule = found.goal, found.case, found.pace, found.best.schedule
    wanted = plan.Goal(goal.norm_g, None, None)
    if goal.norm_g is None:
        wanted = plan.Goal(None, case.limit_g, goal.probability)
    return Quickest(
        stand=case.stand.name,
        block=case.block,
        estimator=goal.estimator,
        goal=wanted,
        angles_deg=step_deg,
        pace=plan.Pace(pace.velocity, pace.acceleration, pace.settling, pace.rate, pace.remounting),
        schedule=plan.FoundSchedule(
            **_timed(found.best, case.terms),
            matrices=tuple(np.array(mounting.matrix) for mounting in schedule.mountings),
            angles_deg=tuple(_angles(schedule, mounting) for mounting in schedule.mountings),
        ),
        u_norm_g=WorstNorm(found.u_norm_g, np.array(found.attitude)),
        promise=found.promise,
        reliability=None if found.unseen is None else unseen(found.unseen),
        reliability_norm_g=reliability.largest(found.unseen),
        extended=model_cost_part(found.further),
        beside=plan.Beside(
            **{
                name: None if timed is None else plan.Timed(**_timed(timed, case.terms))
                for name, timed in found.beside.items()
            }
        ),
    )


def _timed(timed: Timed, terms: Terms) -> dict[str, Any]:
    return {
        "mountings": len(timed.schedule.mountings),
        "positions": len(timed.schedule.positions),
        "samples": timed.samples,
        "freedom": freedom(timed, terms),
        "seconds": timed.duration.total,
        **{f"{part}_s": seconds for part, seconds in asdict(timed.duration).items()},
    }


def _angles(schedule: Schedule, mounting: Mounting) -> tuple[float, ...]:
    return tuple(position.angle_deg for position in schedule.positions if position.mounting == mounting.number)


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
    out.print(sentence(found.promise))
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
