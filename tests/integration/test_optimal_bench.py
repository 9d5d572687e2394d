"""The bench with the estimator `optimal`: the firmware evaluates a gain record that was made before the run."""

import dataclasses
import json

import core_functions
import gain_record
import numpy as np
import pytest
from conftest import EXAMPLES
from documents import paper_stand
from simulated_bench import bench as simulated, runs

import tumble as package
from tumble.cli.main import main
from tumble.core import CoreSchedule, paper_schedule
from tumble.model.optimal import optimal_estimate, optimal_table
from tumble.solving import optimal_run
from tumble.stand import PAPER_STAND
from tumble.world import setup
from tumble.world.border import Refused

SCHEDULE = CoreSchedule(paper_schedule())
NOMINAL_K = -(np.full((3, 3), 0.04) + 1.96 * np.eye(3))
OPTIMAL = {"procedure.estimator": "optimal"}
TURNED = dataclasses.replace(SCHEDULE.data.positions[3], angle_deg=134.0)


def record_for(schedule=SCHEDULE.data):
    return optimal_run.to_bytes(
        optimal_run.record_of(optimal_table(schedule, NOMINAL_K, PAPER_STAND), schedule))  # fmt: skip


RECORD = record_for()


def bench(tumble, *arguments, cwd):
    done = tumble("bench", *arguments, "--estimator", "optimal", "--out", "run", "--json", cwd=cwd)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)


def errors_over_u(result):
    parts = [(result[key], result["truth"][key], result[f"u_{key}"]) for key in ("K", "U0")]
    return np.concatenate([((np.array(found) - truth) / u).ravel() for found, truth, u in parts])


@pytest.mark.toolchain
@pytest.mark.slow
@pytest.mark.parametrize("name", ["paper", "angle", "lab"])
def test_runs_of_the_firmware_are_as_good_as_they_say(name, tumble, tmp_path):
    """A table for the nominal K serves the block of the file, whose misalignments have other sizes and signs."""
    scores = []
    for seed in range(1, 9):
        (tmp_path / str(seed)).mkdir()
        result = bench(tumble, "--seed", seed, "--stand", EXAMPLES / f"{name}_stand.toml", cwd=tmp_path / str(seed))
        assert result["estimator"] == "optimal" and result["verification"]["pass"] and result["misfit"] < 1.7
        scores.append(errors_over_u(result))
    assert 0.8 < np.sqrt(np.mean(np.square(scores))) < 1.25 and np.abs(scores).max() < 4.5


@pytest.mark.parametrize("options, samples", [((), 50), (("--samples", "8"), 8)])
def test_the_record_is_among_the_inputs(options, samples, tumble, tmp_path):
    bench(tumble, *options, cwd=tmp_path)
    made = gain_record.from_bytes((tmp_path / "run/inputs/gains.bin").read_bytes())
    assert made.sigma.tolist() == [2e-5, 2e-5, 4e-4, 4e-5] and made.sigma_mean == pytest.approx(3e-4 / samples**0.5)
    assert made.k == pytest.approx(-2.0 * (np.eye(3) + 0.02 * (1 - np.eye(3))))


def test_any_schedule_will_do(tumble, tmp_path):
    result = bench(tumble, "--schedule", EXAMPLES / "six_faces.toml", cwd=tmp_path)
    assert np.abs(errors_over_u(result)).max() < 5.0


def test_the_run_folder_solves_to_the_same(tumble, tmp_path):
    """From the recorded samples, with weights made for them: the same but for the choice of K."""
    stand = EXAMPLES / "angle_stand.toml"
    ran = bench(tumble, "--stand", stand, cwd=tmp_path)
    done = tumble("solve", "run/run.csv", "--stand", stand, "--estimator", "optimal", "--json", cwd=tmp_path)
    solved = json.loads(done.stdout)
    assert (np.abs(np.subtract(solved["K"], ran["K"])) < 0.3 * np.array(ran["u_K"])).all()
    assert np.array(solved["u_K"]) == pytest.approx(np.array(ran["u_K"]), rel=0.01)


OTHERS = {  # what the record is made for, exit code, what is said
    "stand": ({"stand": dataclasses.replace(PAPER_STAND, angle=2e-4)}, 3,
              "the firmware's K is not what the core makes of its means"),
    "schedule": ({"schedule": CoreSchedule(dataclasses.replace(
        SCHEDULE.data, positions=(*SCHEDULE.data.positions[:3], TURNED, *SCHEDULE.data.positions[4:])))}, 2,
                 "the gain table does not fit the schedule"),
}  # fmt: skip


@pytest.mark.parametrize("other", OTHERS)
def test_a_record_of_another_stand_or_schedule_is_found_out(other, monkeypatch, capsys, tmp_path):
    changed, code, said = OTHERS[other]
    sound = setup.gain_record
    monkeypatch.setattr(setup, "gain_record", lambda wanted: sound(dataclasses.replace(wanted, **changed)))
    assert main(["bench", "--estimator", "optimal", "--out", str(tmp_path / "run"), "--json"]) == code
    captured = capsys.readouterr()
    assert captured.out == "" and said in captured.err
    assert code == 3 or (captured.err.count("\n") == 1 and not (tmp_path / "run").exists())


def test_the_firmware_solves_with_the_record_and_agrees_with_core_and_witness(tmp_path):
    found = simulated(OPTIMAL, seed=5, gains=RECORD, out=tmp_path / "run")
    assert (found["exit"], found["estimator"]) == (0, "optimal")
    run = package.read(tmp_path / "run/run.csv")
    places = sorted(set(zip(run.mounting, run.position)))
    means = np.array([run.outputs[(run.mounting == m) & (run.position == p)].mean(axis=0) for m, p in places])
    expected = core_functions.optimal(RECORD, SCHEDULE, means)
    assert np.abs(np.array(found["K"]) - expected.k).max() < 1e-13
    assert np.abs(np.array(found["U0"]) - expected.u0).max() < 1e-13
    witness = optimal_estimate(SCHEDULE.data, means, PAPER_STAND, np.full(18, PAPER_STAND.samples), known_k=NOMINAL_K)
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
    "damaged": (OPTIMAL, RECORD[:3000] + bytes([RECORD[3000] ^ 1]) + RECORD[3001:], "a checksum is wrong"),
    "of another schedule": (
        OPTIMAL, record_for(dataclasses.replace(SCHEDULE.data, positions=SCHEDULE.data.positions[1:])),
        "the gain table does not fit the schedule"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_records_that_are_refused(name):
    keys, gains, complaint = REFUSED[name]
    with pytest.raises(Refused, match=complaint):
        simulated(keys, gains=gains)


def test_a_stand_without_noise_is_weighed_by_its_converter(tumble, tmp_path):
    """Which stand and simulation have, whether or not the file declares it."""
    assert bench(tumble, "--stand", paper_stand(tmp_path, noise_v=0), cwd=tmp_path)["pass"]
