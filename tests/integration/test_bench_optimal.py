"""tumble-bench with the stand-optimal estimator: the firmware's own record, its own result, and what it refuses."""

import csv
import json

import numpy as np
import pytest
from bench_program import bench, scenario
from documents import paper_stand

from tumble import core
from tumble.core import optimal as core_optimal
from tumble.reference import optimal
from tumble.solving import gain_record as record, gains
from tumble.stand import PAPER_STAND

SCHEDULE = core.CoreSchedule(core.paper_schedule())
NOMINAL_K = -(np.full((3, 3), 0.04) + 1.96 * np.eye(3))


def gain_record(folder, schedule=SCHEDULE.data):
    path = folder / "gains.bin"
    path.write_bytes(record.to_bytes(record.record_of(gains.optimal_table(schedule, NOMINAL_K, PAPER_STAND), schedule)))
    return path


def means_of(folder):
    """Means (18, 3) of a run folder's run.csv."""
    sums = {}
    with (folder / "run.csv").open(newline="") as file:
        for row in csv.DictReader(file):
            sample = [float(row[name]) for name in ("ux", "uy", "uz")]
            sums.setdefault((int(row["mounting"]), int(row["position"])), []).append(sample)
    return np.array([np.mean(sums[key], axis=0) for key in sorted(sums)])


def test_the_firmware_solves_with_the_record_and_agrees_with_core_and_witness(tmp_path):
    path = gain_record(tmp_path)
    run = tmp_path / "run"
    ended = bench(scenario(tmp_path, procedure__estimator="optimal"), "--gain-record", path, "--out", run, "--seed", 5)
    assert ended.returncode == 0, ended.stderr
    document = json.loads(ended.stdout or (run / "bench.json").read_text())
    assert document["estimator"] == "optimal"
    means = means_of(run)
    expected = core_optimal.optimal(path.read_bytes(), SCHEDULE, means)
    assert np.abs(np.array(document["K"]) - expected.k).max() < 1e-13
    assert np.abs(np.array(document["U0"]) - expected.u0).max() < 1e-13
    witness = optimal(SCHEDULE.data, means, PAPER_STAND, np.full(18, PAPER_STAND.samples), known_k=NOMINAL_K)
    assert np.abs((np.array(document["K"]) - witness.k) / witness.u_k).max() < 1e-6


@pytest.mark.slow
def test_it_is_closer_to_the_truth_than_refined(tmp_path):
    def rms(estimator, *options):
        path = scenario(tmp_path, f"{estimator}.txt", procedure__estimator=estimator)
        ended = bench(path, *options, "--runs", 400, "--summary", "--jobs", 2)
        assert ended.returncode == 0, ended.stderr
        document = json.loads(ended.stdout)
        return np.array(document["K"]["rms_error"] + document["U0"]["rms_error"])

    ratio = rms("refined") / rms("optimal", "--gain-record", gain_record(tmp_path))
    assert (ratio > 0.97).all()
    assert ratio[[0, 4, 8]].min() > 1.1  # the scale factors
    assert ratio[[10, 11]].min() > 1.4  # two of the biases


def test_what_is_wrong_is_said_and_nothing_runs(tmp_path):
    path, wanted = gain_record(tmp_path), scenario(tmp_path, procedure__estimator="optimal")
    data = path.read_bytes()
    (tmp_path / "short.bin").write_bytes(data[:3000])
    (tmp_path / "damaged.bin").write_bytes(data[:3000] + bytes([data[3000] ^ 1]) + data[3001:])
    (tmp_path / "large.bin").write_bytes(bytes(30_000))
    (tmp_path / "other").mkdir()
    other = gain_record(tmp_path / "other", type(SCHEDULE.data)(SCHEDULE.data.mountings, SCHEDULE.data.positions[1:]))
    cases = {
        (wanted,): f"{wanted}: procedure.estimator = optimal needs --gain-record",
        ("--gain-record", path): "the defaults: --gain-record is for procedure.estimator = optimal alone",
        (wanted, "--gain-record", "none.bin"): "none.bin: No such file or directory",
        (wanted, "--gain-record", tmp_path): f"{tmp_path}: Is a directory",
        (wanted, "--gain-record", tmp_path / "large.bin"): f"{tmp_path / 'large.bin'}: larger than any gain record",
        (wanted, "--gain-record", tmp_path / "short.bin"):
            f"{wanted}: the memory holds no gain record that this software reads",
        (wanted, "--gain-record", tmp_path / "damaged.bin"): f"{wanted}: a checksum does not agree",
        (wanted, "--gain-record", other): f"{wanted}: the gain table does not fit the schedule",
        (wanted, "--gain-record"): "--gain-record: needs a value",
    }
    for arguments, complaint in cases.items():
        ended = bench(*arguments)
        assert (ended.returncode, ended.stdout, ended.stderr) == (2, "", f"tumble-bench: {complaint}\n")


def test_a_stand_without_noise_is_weighed_by_its_converter(tumble, tmp_path):
    """Which stand and simulation have, whether or not the file declares it."""
    stand = paper_stand(tmp_path, noise_v=0)
    done = tumble("bench", "--estimator", "optimal", "--stand", stand, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
