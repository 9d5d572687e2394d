"""The bench with the stand-optimal estimator: the firmware's own record, its own result, and what it refuses."""

import numpy as np
import pytest
from documents import paper_stand
from simulated_bench import bench, runs

import tumble as package
from tumble import core
from tumble.bench.border import Refused
from tumble.core import optimal as core_optimal
from tumble.reference import optimal
from tumble.solving import gain_record as record, gains
from tumble.stand import PAPER_STAND

SCHEDULE = core.CoreSchedule(core.paper_schedule())
NOMINAL_K = -(np.full((3, 3), 0.04) + 1.96 * np.eye(3))
OPTIMAL = {"procedure.estimator": "optimal"}


def record_for(schedule=SCHEDULE.data):
    return record.to_bytes(record.record_of(gains.optimal_table(schedule, NOMINAL_K, PAPER_STAND), schedule))


RECORD = record_for()


def test_the_firmware_solves_with_the_record_and_agrees_with_core_and_witness(tmp_path):
    found = bench(OPTIMAL, seed=5, gains=RECORD, out=tmp_path / "run")
    assert (found["exit"], found["estimator"]) == (0, "optimal")
    run = package.read(tmp_path / "run/run.csv")
    places = sorted(set(zip(run.mounting, run.position)))
    means = np.array([run.outputs[(run.mounting == m) & (run.position == p)].mean(axis=0) for m, p in places])
    expected = core_optimal.optimal(RECORD, SCHEDULE, means)
    assert np.abs(np.array(found["K"]) - expected.k).max() < 1e-13
    assert np.abs(np.array(found["U0"]) - expected.u0).max() < 1e-13
    witness = optimal(SCHEDULE.data, means, PAPER_STAND, np.full(18, PAPER_STAND.samples), known_k=NOMINAL_K)
    assert np.abs((np.array(found["K"]) - witness.k) / witness.u_k).max() < 1e-6


@pytest.mark.slow
def test_it_is_closer_to_the_truth_than_refined():
    def rms(estimator, gains=None):
        lines = runs({"procedure.estimator": estimator}, 400, gains=gains)
        assert {line["exit"] for line in lines} == {0}
        found, true = ([one["K"] + one["U0"] for one in side] for side in (lines, [line["truth"] for line in lines]))
        return np.sqrt(((np.array(found) - true) ** 2).mean(axis=0))

    ratio = rms("refined") / rms("optimal", RECORD)
    assert (ratio > 0.97).all()
    assert ratio[[0, 4, 8]].min() > 1.1  # the scale factors
    assert ratio[[10, 11]].min() > 1.4  # two of the biases


REFUSED = {
    "none": (OPTIMAL, None, "procedure.estimator = optimal needs "),
    "one that nobody asked for": ({}, RECORD, " is for procedure.estimator = optimal alone"),
    "short": (OPTIMAL, RECORD[:3000], "the memory holds no gain record that this software reads"),
    "large": (OPTIMAL, bytes(30_000), "the memory holds no gain record that this software reads"),
    "damaged": (OPTIMAL, RECORD[:3000] + bytes([RECORD[3000] ^ 1]) + RECORD[3001:], "a checksum does not agree"),
    "of another schedule": (
        OPTIMAL, record_for(type(SCHEDULE.data)(SCHEDULE.data.mountings, SCHEDULE.data.positions[1:])),
        "the gain table does not fit the schedule"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_records_that_are_refused(name):
    keys, gains, complaint = REFUSED[name]
    with pytest.raises(Refused, match=complaint):
        bench(keys, gains=gains)


def test_a_stand_without_noise_is_weighed_by_its_converter(tumble, tmp_path):
    """Which stand and simulation have, whether or not the file declares it."""
    stand = paper_stand(tmp_path, noise_v=0)
    done = tumble("bench", "--estimator", "optimal", "--stand", stand, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
