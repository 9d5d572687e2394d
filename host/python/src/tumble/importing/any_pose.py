"""Rests of which nobody knows the directions: every one is a pose of its own, for the estimator `norm`."""

from __future__ import annotations

import numpy as np

from tumble.errors import Remedy
from tumble.importing.attitudes import Fit
from tumble.importing.match import LEFT_OUT, NONE, TAKEN, Doubtful, Matched, UserChoices
from tumble.importing.rests import Rests
from tumble.model.norm import NINE, of_poses, roughly

MOST = 36  # as a schedule holds
POSES = of_poses([(number, 1) for number in range(1, MOST + 1)])


def matched(rests: Rests, user_choices: UserChoices) -> Matched:
    """In the order in which they were measured, but for those to leave out. Raises Doubtful for too few or many."""
    taken = np.array([number not in user_choices.leave_out for number in range(1, len(rests) + 1)])
    count = int(taken.sum())
    if count < len(NINE):
        said = f"{count} rests; nine poses are needed to determine all coefficients"
        raise Doubtful(f"{said}: measure more, or check whether --still, --drift or --min-rest hide some")
    if count > MOST:
        said = f"{count} rests, at most {MOST} poses are solved: --leave-out, or --min-rest for longer ones"
        shortest = np.argsort(np.where(taken, rests.samples, rests.samples.max() + 1), kind="stable")[: count - MOST]
        numbers = sorted({*user_choices.leave_out, *(shortest + 1).tolist()})
        raise Doubtful(said, Remedy({"leave_out": ",".join(map(str, numbers))}, "the shortest rests matter least"))
    positions = np.where(taken, np.cumsum(taken) - 1, NONE)
    n, one_g = roughly(rests.means, np.ones(3))
    fit = Fit(one_g * np.eye(3), rests.means.mean(axis=0), n, np.ones(len(n)))
    states = tuple(TAKEN if one else LEFT_OUT for one in taken.tolist())
    note = "directions: not checked; every rest counts as a pose of its own"
    return Matched(positions, states, np.zeros(len(rests)), 0.0, fit, (note,))
