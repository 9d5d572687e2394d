"""Which schedules identify which coefficients: the core's pivots against the witness's singular values."""

import numpy as np
import pytest
from blocks import random_rotation, random_schedule

from tumble import core
from tumble.model.estimators import design as design_of, unidentified
from tumble.schedule import CHECK, Mounting, Position, Schedule

PAPER = core.paper_schedule()
ONE, TWO = PAPER.mountings
K = [f"K_{i}{j}" for j in "xyz" for i in "xyz"]
K_X, K_Y, K_Z = K[:3], K[3:6], K[6:]
U0 = ["U0_x", "U0_y", "U0_z"]


def turned(mountings, angles=range(0, 360, 45), use="fit"):
    """Every mounting at every angle."""
    positions = [
        Position(mounting.number, number + 1, float(angle), use)
        for mounting in mountings
        for number, angle in enumerate(angles)
    ]
    return Schedule(tuple(mountings), tuple(positions))


DEFICIENT = {
    "the first mounting alone": (turned([ONE]), K_Y),
    "the second mounting alone": (turned([TWO]), K_Z),
    "one mounting, axis tilted by a known angle": (turned([Mounting(1, ONE.matrix, 30.0)]), K_Y + U0),
    "one attitude": (turned([ONE], [0]), K + U0),
    "one attitude, a turn later again": (turned([ONE], [0, 360, 720]), K + U0),
    "up and down": (turned([ONE], [0, 180]), K_X + K_Y),
    "a half turn of each mounting apart": (turned([ONE, TWO], [0, 180]), K_X),
    "three positions": (turned([ONE], [0, 90, 180]), K_Y),
    "an oblique mounting": (turned([Mounting(1, random_rotation(np.random.default_rng(5)))]), K),
    "positions to check only": (turned([ONE, TWO], use=CHECK), K + U0),
}

SUFFICIENT = {
    "the paper's": PAPER,
    "six faces": Schedule(
        PAPER.mountings, tuple(p for p in PAPER.positions if p.label in ("1.1", "1.3", "1.5", "1.7", "2.1", "2.5"))
    ),
    "one mounting, two tilts of the axis": turned([ONE, Mounting(2, ONE.matrix, 30.0)]),
    "four positions": Schedule(
        (ONE, Mounting(2, ONE.matrix, 45.0)),
        (Position(1, 1, 0.0), Position(1, 2, 120.0), Position(1, 3, 240.0), Position(2, 1, 0.0)),
    ),
}


def core_names(schedule):
    try:
        core.CoreSchedule(schedule).identify()
    except core.CoreRefusal as refusal:
        assert refusal.name == "TUMBLE_E_RANK"
        return refusal.details["unidentified"]
    return []


@pytest.mark.parametrize("case", DEFICIENT)
def test_deficient_schedules_name_what_they_lack(case):
    schedule, lost = DEFICIENT[case]
    assert core_names(schedule) == lost
    assert unidentified(schedule) == lost
    with pytest.raises(core.CoreRefusal) as caught:
        core.estimate(core.CoreSchedule(schedule), np.zeros((len(schedule.positions), 3)), None, "least_squares")
    assert (caught.value.name, caught.value.details["unidentified"]) == ("TUMBLE_E_RANK", lost)


@pytest.mark.parametrize("case", SUFFICIENT)
def test_sufficient_schedules_are_accepted(case):
    assert core_names(SUFFICIENT[case]) == []
    assert unidentified(SUFFICIENT[case]) == []


def test_core_and_witness_agree_on_random_schedules(cases):
    """3000 with --full. Away from the threshold, where pivots and singular values may differ by a small factor."""
    rng = np.random.default_rng(31)
    compared = {True: 0, False: 0}
    for _ in range(cases(3000)):
        schedule = random_schedule(rng)
        design = design_of(schedule)
        singular = np.linalg.svd(design, compute_uv=False) / np.sqrt(max(len(design), 1) / 3)
        weakest = singular[-1] if len(singular) == 12 else 0.0
        if 1e-5 < weakest < 5e-3:
            continue
        names = core_names(schedule)
        assert names == unidentified(schedule)
        compared[bool(names)] += 1
    assert min(compared.values()) > cases(200)


def test_unmeasured_positions_do_not_count():
    measured = np.array([position.mounting == 1 for position in PAPER.positions])
    with pytest.raises(core.CoreRefusal) as caught:
        core.CoreSchedule(PAPER).identify(measured)
    assert caught.value.details["unidentified"] == K_Y
