"""Result documents: the schema, what the numbers mean, determinism, what is carried along, and the text output."""

import json
import math
import os
import re

import jsonschema
import numpy as np
import pytest
from conftest import EXAMPLES
from documents import document_of, paper_stand, schema, valid

pytestmark = pytest.mark.python

STANDS = ("paper_stand", "angle_stand", "lab_stand")
SOLVES = {
    **{f"{name}, {e}": [f"{name}.csv", "--stand", f"{name}.toml", "--estimator", e]
       for name in STANDS for e in ("averaged", "refined", "least_squares", "optimal")},
    "no stand": ["paper_stand.csv"],
    "six faces": ["six_faces.csv", "--schedule", "six_faces.toml", "--estimator", "least_squares"],
    "six faces of the paper's": ["six_faces.csv", "--estimator", "least_squares"],
    "checks": ["with_checks.csv", "--schedule", "with_checks.toml", "--stand", "paper_stand.toml"],
    "limit": ["paper_stand.csv", "--limit", "1e-6"],
}  # fmt: skip


def solve(tumble, *arguments):
    """The result document of a solve in the examples folder, checked against the schema."""
    unit = [] if "--unit" in arguments else ["--unit", "V"]
    done = tumble("solve", *arguments, *unit, "--json", cwd=EXAMPLES)
    result = document_of(done, codes=(0, 1))
    assert result["pass"] == (done.returncode == 0) == (result["pass_reason"] is None)
    return result


def known_by_noise(place, mean, result):
    """The uncertainty of a delta_g, by differences: a mean that is off by its standard error in one channel. Of that
    the declared noise counts, or the measured one where it is larger or the only one."""
    k, u0, stand, seen = np.array(result["K"]), np.array(result["U0"]), result["stand"], result["noise"]
    if stand is None and seen["of_means"] is None:
        return place["u_delta_g_g"] is None and place["k_delta_g"] is None

    def delta_g(outputs):
        force = np.linalg.solve(k, outputs - u0)
        return (force @ force - 1) / 2

    by_volt = [(delta_g(np.array(mean["mean"]) + one) - delta_g(np.array(mean["mean"]) - one)) / 2e-3
               for one in 1e-3 * np.eye(3)]  # fmt: skip
    if stand is None:
        sigma = np.array(seen["of_means"])
    elif seen["above_declared"] or seen["undithered"]:
        return place["u_delta_g_g"] > 0.0
    else:
        sigma = np.full(3, stand["noise_v"] / {"sigma1": 1.0, "sigma3": 3.0, "uniform": 3**0.5}[stand["limits"]])
    expected = float(np.linalg.norm(by_volt * sigma)) / mean["samples"] ** 0.5
    return place["u_delta_g_g"] == pytest.approx(expected, rel=1e-3) and 1.95 < place["k_delta_g"] < 13.0


@pytest.mark.parametrize("case", SOLVES)
def test_results_follow_the_schema_and_their_own_logic(case, tumble):
    result = solve(tumble, *SOLVES[case])
    verification, k, u0 = result["verification"], np.array(result["K"]), np.array(result["U0"])
    judged = verification["delta_g_g"]
    for place, mean in zip(judged, result["means"], strict=True):
        assert (place["mounting"], place["position"], place["use"]) == (mean["mounting"], mean["position"], mean["use"])
        force = np.linalg.solve(k, np.array(mean["mean"]) - u0)
        assert place["delta_g_g"] == pytest.approx((force @ force - 1) / 2, abs=1e-13)
        assert known_by_noise(place, mean, result)
    for use in ("fit", "check"):
        errors = [abs(place["delta_g_g"]) for place in judged if place["use"] == use]
        assert verification[f"max_abs_delta_g_{use}_g"] == (max(errors) if errors else None)
    largest = max(abs(place["delta_g_g"]) for place in judged)
    assert verification["max_abs_delta_g_g"] == largest
    assert verification["pass"] == (largest <= verification["limit_g"])
    assert result["intrinsic"]["scale"] == pytest.approx(np.linalg.norm(k, axis=1), rel=1e-14)
    assert result["intrinsic"]["bias_g"] == pytest.approx(u0 / np.linalg.norm(k, axis=1), rel=1e-14)
    assert result["counters"]["rows"] == sum(mean["samples"] for mean in result["means"])
    known = "--stand" in SOLVES[case]
    assert (result["u_K"] is not None) == (result["u_U0"] is not None) == known
    assert result["stand_seen"]["u_from"] == ("stand" if known else "run")
    assert result["reference"]["max_abs_difference_K"] <= 1e-12 * np.abs(k).max()
    assert result["reference"]["max_abs_difference_K"] == np.abs(result["reference"]["difference_K"]).max()


def test_the_schema_would_notice():
    document = schema("result")
    validator = jsonschema.Draft202012Validator(document)
    validator.check_schema(document)
    for key in document["required"]:
        assert not validator.is_valid({name: None for name in document["required"] if name != key})


def test_estimates_lie_where_their_uncertainties_say(tumble):
    """36 coefficients and 9 angles of three stands, each within four standard uncertainties of the truth."""
    for name in STANDS:
        truth = json.loads((EXAMPLES / f"{name}.truth.json").read_text())
        result = solve(tumble, f"{name}.csv", "--stand", f"{name}.toml")
        for key in ("K", "U0"):
            score = (np.array(result[key]) - truth[key]) / np.array(result[f"u_{key}"])
            assert np.abs(score).max() < 4, (name, key, score)
        seen = result["stand_seen"]
        expected = {
            "alpha1_rad": truth["alpha1_rad"],
            "alpha2_plus_alpha3_rad": truth["alpha2_rad"] + np.mean(truth["alpha3_rad"]),
            "alpha3_difference_rad": truth["alpha3_rad"][0] - truth["alpha3_rad"][1],
        }
        for key, value in expected.items():
            assert abs(seen[key] - value) < 4 * seen[f"u_{key}"], (name, key)
        stand = re.search(r"noise_v = (\S+)", (EXAMPLES / f"{name}.toml").read_text())[1]
        assert abs(seen["noise_v"] - float(stand)) < 4 * seen["u_noise_v"]


def test_unknown_is_null(tumble, tmp_path):
    """A run of six lone rows, no stand: nothing to say on scatter, uncertainty, angles, closure."""
    lines = (EXAMPLES / "six_faces.csv").read_text().splitlines()
    run = tmp_path / "run.csv"
    run.write_text("\n".join([lines[0], *lines[1::50]]) + "\n")
    result = valid(tumble("solve", run, "--estimator", "least_squares", "--json").stdout)
    assert result["u_K"] is result["u_U0"] is result["item"] is result["environment"] is None
    assert all(mean["scatter"] is None and mean["samples"] == 1 for mean in result["means"])
    assert set(result["stand_seen"].values()) == {None}
    assert result["verification"]["max_abs_delta_g_check_g"] is None
    assert result["verification"]["closure"] == []
    four_rows = tmp_path / "four.csv"
    four_rows.write_text("\n".join([lines[0], *(lines[1 + 50 * i] for i in (0, 1, 2, 4))]) + "\n")
    done = tumble("solve", four_rows, "--estimator", "least_squares", "--json")
    assert json.loads(done.stdout)["verification"]["residual_rms"] is None


def test_the_same_run_gives_the_same_bytes(tumble, tmp_path):
    arguments = ["solve", "paper_stand.csv", "--stand", "paper_stand.toml", "--json", "--out"]
    dated = {"SOURCE_DATE_EPOCH": "1700000000"}
    first, second = (tumble(*arguments, tmp_path / name, cwd=EXAMPLES, **dated) for name in ("a.json", "b.json"))
    assert first.stdout == second.stdout == (tmp_path / "a.json").read_text() == (tmp_path / "b.json").read_text()


def test_out_replaces_a_file_and_keeps_nothing_else(tumble, tmp_path):
    (tmp_path / "result.json").write_text("old")
    assert tumble("solve", "paper_stand.csv", "--out", tmp_path / "result.json", cwd=EXAMPLES).returncode == 0
    assert json.loads((tmp_path / "result.json").read_text())["schema"] == "tumble.result/1"
    assert [path.name for path in tmp_path.iterdir()] == ["result.json"]
    mask = os.umask(0)
    os.umask(mask)
    assert (tmp_path / "result.json").stat().st_mode & 0o777 == 0o666 & ~mask


def test_limits_come_from_the_option_then_the_stand_then_the_default(tumble, tmp_path):
    stand = paper_stand(tmp_path, delta_g_limit_g="2e-6")
    run = EXAMPLES / "paper_stand.csv"
    for options, limit, code in (
        ([], 3e-4, 0),
        (["--stand", stand], 2e-6, 1),
        (["--stand", stand, "--limit", "0.01"], 0.01, 0),
    ):
        done = tumble("solve", run, "--json", *options)
        assert (json.loads(done.stdout)["verification"]["limit_g"], done.returncode) == (limit, code)
    without = tmp_path / "without.toml"
    without.write_text(stand.read_text().split("[accept]")[0])
    assert json.loads(tumble("solve", run, "--json", "--stand", without).stdout)["verification"]["limit_g"] == 3e-4


def test_item_and_environment_are_carried_along(tumble, tmp_path):
    stand = paper_stand(
        tmp_path,
        '[item]\nserial = "\u041c-17 [ 3 ]"\noperator = "N. N."\ndate = 2024-05-17\ncharge = 4\n'
        '[environment]\ngravity_m_s2 = 9.8104\ntemperature_c = 21\nplace = "cellar"\n',
    )
    command = ["solve", EXAMPLES / "paper_stand.csv", "--stand", stand, "--json"]
    result = valid(tumble(*command, LC_ALL="C", PYTHONIOENCODING="ascii").stdout)
    assert result["item"] == {"serial": "\u041c-17 [ 3 ]", "operator": "N. N.", "date": "2024-05-17", "charge": 4}
    assert result["environment"] == {"gravity_m_s2": 9.8104, "temperature_c": 21, "place": "cellar"}


def test_units_follow_the_outputs(tumble):
    result = solve(tumble, "paper_stand.csv", "--unit", "counts")
    assert result["units"] == {"K": "counts/g", "U0": "counts", "u_K": "counts/g", "u_U0": "counts"}


@pytest.mark.parametrize("case", SOLVES)
def test_plain_text_has_the_numbers_of_the_result(case, tumble):
    """Every figure of the text is that of the result, rounded; 80 columns, ASCII."""
    result = solve(tumble, *SOLVES[case])
    text = tumble("solve", *SOLVES[case], "--unit", "V", "--details", cwd=EXAMPLES).stdout
    assert text.isascii() and max(map(len, text.splitlines())) <= 80
    rows = {line.split()[0].rstrip("*^"): line.split() for line in text.splitlines() if re.match(r"[KU]0?_", line)}
    assert len(rows) == 12 and (result["scatter_alone"] is not None) == ("u, scatter alone" in text)
    marked = [row[0].rstrip("*^") for row in rows.values() if row[0].endswith(("*", "^"))]
    assumed = {name for names in result["assumed_for"].values() for name in names}
    assert marked == [name for name in rows if name in assumed]
    u_k, u_u0 = (stated[key] for stated in [result["scatter_alone"] or result] for key in ("u_K", "u_U0"))
    for i, channel in enumerate("xyz"):
        for name, value, u in [
            *(
                (f"K_{channel}{a}", result["K"][i][j], u_k and u_k[i][j])
                for j, a in enumerate("xyz")
            ),
            (f"U0_{channel}", result["U0"][i], u_u0 and u_u0[i]),
        ]:
            assert float(rows[name][1]) == pytest.approx(value, abs=0.51e-9)
            assert rows[name][3] == ("unknown" if u is None else f"{u:.1e}")
    for place in result["verification"]["delta_g_g"]:
        label = f"{place['mounting']}.{place['position']}"
        bar = next(line for line in text.splitlines() if line.split()[:1] == [label])
        assert float(bar.split()[2]) == pytest.approx(place["delta_g_g"], rel=0.01)
        assert ("over" in bar) == (abs(place["delta_g_g"]) > result["verification"]["limit_g"])
    verdict = " ".join(text.partition("\n\n")[0].split())
    linearity = ", linearity" if "linear" in result["assumes"] else ""
    where = "" if result["u_K"] else f" at the {len(result['means'])} measured positions only"
    passed = f"PASS{where}, assuming a square seat{linearity} and one temperature: "
    not_shown = result["pass_reason"] == "uncertainty"
    assert verdict.startswith(passed if result["pass"] else "NOT SHOWN: " if not_shown else "FAIL: ")
    assert ("--stand" in text) == (result["u_K"] is None)


def test_bars_are_in_proportion(tumble):
    text = tumble("solve", "paper_stand.csv", "--limit", "5e-5", "--details", cwd=EXAMPLES).stdout
    bars = [line for line in text.splitlines() if re.match(r" +\d\.\d ", line)]
    errors = [abs(float(bar.split()[2])) for bar in bars]
    cells = [bar.count("#") for bar in bars]
    for error, filled in zip(errors, cells):
        assert filled == pytest.approx(36 * error / max(errors), abs=1.01)
    marks = {bar[26:].index("|") for bar in bars}
    assert len(marks) == 1 and math.isclose(marks.pop(), 36 * 5e-5 / max(errors), abs_tol=1.5)
