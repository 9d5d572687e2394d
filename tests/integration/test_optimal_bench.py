"""`tumble bench --estimator optimal`: the firmware evaluates a gain record that was made before the run."""

import dataclasses
import json

import numpy as np
import pytest
from conftest import EXAMPLES

from tumble.bench import gains
from tumble.cli.main import main
from tumble.solving import gain_record
from tumble.stand import PAPER_STAND


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


def test_the_record_is_among_the_inputs(tumble, tmp_path):
    bench(tumble, cwd=tmp_path)
    made = gain_record.from_bytes((tmp_path / "run/inputs/gains.bin").read_bytes())
    assert made.sigma.tolist() == [2e-5, 2e-5, 4e-4, 4e-5] and made.sigma_mean == pytest.approx(3e-4 / 50**0.5)
    assert made.k == pytest.approx(-2.0 * (np.eye(3) + 0.02 * (1 - np.eye(3))))


def test_the_samples_of_the_run_are_those_of_the_record(tumble, tmp_path):
    bench(tumble, "--samples", "8", cwd=tmp_path)
    made = gain_record.from_bytes((tmp_path / "run/inputs/gains.bin").read_bytes())
    assert made.sigma_mean == pytest.approx(3e-4 / 8**0.5)


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


def test_a_firmware_with_another_table_is_found_out(monkeypatch, capsys, tmp_path):
    sound = gains.record

    def other(setup):
        return sound(dataclasses.replace(setup, stand=dataclasses.replace(PAPER_STAND, angle=2e-4)))

    monkeypatch.setattr(gains, "record", other)
    assert main(["bench", "--estimator", "optimal", "--out", str(tmp_path / "run"), "--json"]) == 3
    captured = capsys.readouterr()
    assert captured.out == "" and "the firmware's K is not what the core makes of its means" in captured.err


def test_a_record_of_another_schedule_is_not_run(monkeypatch, capsys, tmp_path):
    from tumble.core import CoreSchedule

    sound = gains.record

    def other(setup):
        data = setup.schedule.data
        turned = dataclasses.replace(data.positions[3], angle_deg=134.0)
        positions = (*data.positions[:3], turned, *data.positions[4:])
        return sound(dataclasses.replace(setup, schedule=CoreSchedule(dataclasses.replace(data, positions=positions))))

    monkeypatch.setattr(gains, "record", other)
    assert main(["bench", "--estimator", "optimal", "--out", str(tmp_path / "run"), "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.count("\n") == 1 and not (tmp_path / "run").exists()
