"""A run on a stand whose set angles are known: its means as they would be had the table come to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tumble.arrays import Floats
from tumble.estimators import NORM
from tumble.files.run_file import Run
from tumble.model.set_angles import turned_back
from tumble.schedule import Schedule
from tumble.stand import SetAngles


def unusable(table: SetAngles, schedule: Schedule, run: Run, estimator: str, today: str) -> str | None:
    """Why a table is not used for a run, `today` (as 2026-11-30), in words; None where it is."""
    of, counts = f"the table of set angles, learnt on {table.learned},", "angle_rad counts as declared"
    if today > table.expires:
        return f"{of} has expired on {table.expires}, so that {counts}: learn it anew"
    if estimator == NORM or schedule.is_inclined or schedule.is_laid_by_hand:
        return f"{of} is not used: it is for a level table that turns to set angles"
    missing = [one.angle_deg for one in schedule.part(run.measured).positions if one.mark not in table.by_mark]
    return f"{of} has no {missing[0]:g} deg, so that {counts}" if missing else None


def corrected(run: Run, schedule: Schedule, table: SetAngles, known: Floats | None = None) -> Run:
    """The run at the angles that were set, to which the table did not quite come; `known` as of turned_back."""
    part, means = schedule.part(run.measured), run.means.copy()
    errors = np.array([table.by_mark[one.mark] for one in part.positions])
    means[run.measured] = turned_back(part, means[run.measured], errors, known)
    return replace(run, means=means)
