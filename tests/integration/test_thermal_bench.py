"""A block that changes with its temperature, in a simulated chamber: from runs of the bench to its polynomials."""

import json

import loaded
import numpy as np
import pytest
from conftest import EXAMPLES
from test_thermal import worst_norm_error

import tumble as package
from tumble.api.thermal import solve_thermal
from tumble.documents.result import parse_result
from tumble.model.thermal import Polynomials

pytestmark = pytest.mark.python
STAND = EXAMPLES / "paper_stand.toml"
AT_C = (-40.0, -10.0, 15.0, 40.0, 60.0)  # a frame of the block tells -64 to 63.5 deg C
BLOCK = {  # 1e-4 per K of scale, 50 ug per K of bias, and quadratic parts
    "stand.of_seed": "7",
    "block.reference_c": "20",
    "block.scale_per_c": "1e-4",
    "block.bias_v_per_c": "1e-4 -8e-5 9e-5",
    "block.k_per_c": "0 2e-6 0 -3e-6 1e-5 0 0 4e-6 0",
    "block.k_per_c2": "3e-7 4e-8 0 0 -2e-7 0 -5e-8 0 1e-7",
    "block.bias_v_per_c2": "1e-6 2e-6 -1e-6",
}


def run(folder, seed, samples=50, **keys):
    given = {**BLOCK, **{f"block.{key}": f"{value:g}" for key, value in keys.items()}}
    options = [part for key, value in given.items() for part in ("--set", f"{key}={value}")]
    arguments = ["bench", "--stand", STAND, "--samples", samples, "--seed", seed, *options, "--out", folder]
    done = loaded.run([*map(str, arguments)], None, 120)
    assert done.returncode in (0, 1), done.stderr
    return done


@pytest.fixture(scope="module")
def five(tmp_path_factory):
    """Runs at five temperatures: the block and the axis are the same, all else is drawn anew."""
    folder = tmp_path_factory.mktemp("chamber")
    for seed, at_c in enumerate(AT_C, 1):
        run(folder / str(seed), seed, start_c=at_c, end_c=at_c)
    return folder


def truth_of(folder):
    told = parse_result((folder / "result.json").read_bytes(), "result.json").truth
    warm = told.over_temperature
    assert np.array_equal(warm.K[0], told.K) and np.array_equal(warm.U0[0], told.U0)
    return Polynomials(warm.reference_c, np.array(warm.K), np.array(warm.U0))


def test_the_truth_is_what_the_keys_say(five):
    found = truth_of(five / "3")
    k = found.k[0]
    assert found.reference_c == 20.0
    assert found.k[1] == pytest.approx(1e-4 * k + np.array([[0, 2e-6, 0], [-3e-6, 1e-5, 0], [0, 4e-6, 0]]), abs=1e-18)
    assert found.k[2].tolist() == [[3e-7, 4e-8, 0.0], [0.0, -2e-7, 0.0], [-5e-8, 0.0, 1e-7]]
    assert found.u0[1:].tolist() == [[1e-4, -8e-5, 9e-5], [1e-6, 2e-6, -1e-6]]
    others = [parse_result((five / f"{n}/result.json").read_bytes(), "").truth for n in (1, 5)]
    assert others[0].alpha1_rad == others[1].alpha1_rad and others[0].alpha2_rad != others[1].alpha2_rad
    assert np.array_equal(others[0].K, others[1].K) and others[0].alpha3_rad != others[1].alpha3_rad


def test_from_the_bench_to_the_polynomials(tumble, five, tmp_path):
    """Chi-squared of all 36 errors by their covariance; |a| over the range against one temperature alone."""
    files = [five / f"{seed}/run.csv" for seed in range(1, 6)]
    done = tumble("solve", *files, "--temperature", "quadratic", "--stand", STAND, "--out", tmp_path / "warm.json")
    assert done.returncode == 0 and done.stdout.startswith("PASS from -40 to 60 deg C")
    assert "1/run.csv alone, at -40 deg C: PASS" in done.stdout
    found, truth = package.load_thermal(tmp_path / "warm.json"), truth_of(five / "1")
    errors = [np.append(found.at(t)[0] - truth.at(t)[0], found.at(t)[1] - truth.at(t)[1]) for t in AT_C[::2]]
    to_powers = np.linalg.inv(np.vander(np.array(AT_C[::2]) - found.checked.reference_c, 3, increasing=True))
    of_powers = (to_powers @ np.array(errors)).ravel()
    covariance = found.checked.covariance
    size = np.sqrt(np.diag(covariance))
    chi_squared = of_powers / size @ np.linalg.solve(covariance / np.outer(size, size), of_powers / size)
    assert 12.0 < chi_squared < 74.0  # of 36 degrees of freedom: 1 in 10,000 on either side
    assert found.checked.fit.p > 1e-3
    alone, grid = package.solve(files[2], stand=STAND), np.linspace(-40.0, 60.0, 11)
    own, other = (worst_norm_error(one, truth.at, grid) for one in (found.at, lambda t: (alone.K, alone.U0)))
    print(f"worst error of |a|: {1e6 * own:.1f} ug, at one temperature {1e6 * other:.0f} ug")
    assert own < 5e-5 and other > 5e-3


def test_the_page_compares_with_the_block_as_it_was_in_the_run(tmp_path):
    done = run(tmp_path / "cold", 11, start_c=-40, end_c=-40)
    [line] = [one for one in done.stdout.splitlines() if one.startswith("Largest error against the truth")]
    assert float(line.split(": ")[1].split(" u")[0]) < 4.5


def test_a_chamber_that_soaks_and_one_that_goes_on_warming(tmp_path):
    """Temperatures within a run differ by position: each counts with its own."""
    profiles = [
        {"start_c": -35, "end_c": -38, "warm_s": 30},
        {"start_c": 5, "end_c": 5, "ramp_c_per_h": 300},
        {"start_c": 55, "end_c": 50, "warm_s": 20, "ramp_c_per_h": 100},
    ]
    for seed, profile in enumerate(profiles, 1):
        run(tmp_path / str(seed), seed, **profile)
    found = solve_thermal([tmp_path / f"{seed}/run.csv" for seed in (1, 2, 3)], temperature="quadratic", stand=STAND)
    felt = np.array([one.range_c for one in found.checked.runs])
    assert (felt[:, 1] - felt[:, 0] > 1.0).all() and felt[1, 0] < 6.5 and felt[1, 1] > 7.5
    truth = truth_of(tmp_path / "1")
    for t in (-35.0, 10.0, 50.0):
        apart = np.append(found.at(t)[0] - truth.at(t)[0], found.at(t)[1] - truth.at(t)[1])
        assert (np.abs(apart) < 5 * np.sqrt(np.diag(found.covariance_at(t)))).all()


def test_a_block_of_one_temperature_tells_no_polynomial(tumble, tmp_path):
    done = tumble("bench", "--samples", 10, "--seed", 3, "--out", tmp_path / "run")
    assert done.returncode == 0
    assert "over_temperature" not in json.loads((tmp_path / "run/result.json").read_text())["truth"]


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("block.k_per_c=1 2 3", "block.k_per_c must be 9 numbers from -1000000000 to 1000000000"),
        ("stand.of_seed=-1", "stand.of_seed must be"),
        ("block.ramp_c_per_h=warm", "block.ramp_c_per_h must be"),
    ],
)
def test_what_is_refused(refused, key, said):
    assert said in refused("bench", "--set", key)
