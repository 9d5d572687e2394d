"""`tumble fixture check` as a command: what it prints for one run and for several, and what it refuses."""

import json
import re

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from conftest import EXAMPLES, ROOT
from documents import document_of, paper_stand, schema

from tumble import core
from tumble.distributions import chi_squared_cdf, chi_squared_quantile
from tumble.fixture.judge import Judge
from tumble.model import Geometry

pytestmark = pytest.mark.python
PAPER = core.paper_schedule()
U0 = np.array([0.02, -0.01, 0.03])
SOURCES = schema("fixture")["$defs"]["Sources"]["required"]


def check(tumble, *arguments, code):
    found = document_of(tumble("fixture", "check", *arguments, "--json", cwd=EXAMPLES), "fixture", (code,))
    assert found["pass"] == (code == 0)
    return found


@pytest.mark.parametrize("name", ["paper", "angle", "lab"])
def test_the_example_stands_pass(name, tumble):
    found = check(tumble, "--stand", f"{name}_stand.toml", f"{name}_stand.csv", code=0)
    assert found["combined"] is None and list(found["sources"]) == SOURCES
    assert found["assumes"] == ["seat", "unit", "temperature"]
    cross = ["K_yz", "K_zy"] if name == "lab" else ["K_xy", "K_xz", "K_yx", "K_yz", "K_zx", "K_zy"]
    assert found["assumed_for"] == {"seat": cross, "unit": [], "temperature": []}
    for source in found["sources"].values():
        assert (source["limit"], source["verdict"]) == tuple(source["declared"].values())


def test_another_stands_file_does_not(tumble):
    """The lab stand's run against the paper's stand: yaws, noise and set angles."""
    found = check(tumble, "--stand", "paper_stand.toml", "lab_stand.csv", code=1)
    missed = {name for name, source in found["sources"].items() if source["verdict"] == "does not meet"}
    assert {"alpha3_difference_rad", "alpha4_rad", "noise_v"} <= missed
    text = tumble("fixture", "check", "--stand", "paper_stand.toml", "lab_stand.csv", cwd=EXAMPLES)
    assert text.returncode == 1
    assert text.stdout.rstrip().split("\n\n")[-1] == (
        "FAIL: yaw change, set angle and noise do not meet what the stand declares."
    )


def test_inclinations_are_judged_where_they_are_declared(tumble, tmp_path):
    """Those of the example are off by 1 mrad and more, beside its level."""
    run = ("inclined_stand.csv", "--schedule", "inclined", "--estimator", "inclined")
    given = (EXAMPLES / "inclined_stand.toml").read_text()
    assert "inclination_rad" not in check(tumble, "--stand", "inclined_stand.toml", *run, code=0)["sources"]
    shown = tumble("fixture", "check", "--stand", "inclined_stand.toml", *run, cwd=EXAMPLES).stdout
    assert "Nothing is declared of inclinations (inclination_rad): no verdict" in shown
    stand = tmp_path / "stand.toml"
    for declared, code, verdict in ((2e-4, 1, "does not meet"), (1e-2, 0, "meets")):
        stand.write_text(given.replace("[stand]", f"[stand]\ninclination_rad = {declared}"))
        source = check(tumble, "--stand", stand, *run, code=code)["sources"]["inclination_rad"]
        assert (source["limit"], source["verdict"], source["freedom"]) == (declared, verdict, 4)
        assert source["needed"] == {"limit": None, "verdict": "meets"}
    shown = tumble("fixture", "check", "--stand", stand, *run, cwd=EXAMPLES).stdout
    assert "Inclination: how far those set are off" in shown and max(map(len, shown.splitlines())) <= 80


def test_the_limit_of_the_gravity_check_counts(tumble):
    found = check(tumble, "--stand", "lab_stand.toml", "lab_stand.csv", "--limit", "1e-4", code=1)
    assert found["runs"][0]["pass"] is False and found["delta_g_limit_g"] == 1e-4
    assert "does not meet" not in {source["verdict"] for source in found["sources"].values()}


def test_against_what_a_limit_needs(tumble):
    arguments = ["--stand", "angle_stand.toml", "angle_stand.csv", "--against", "needed", "--limit"]
    loose, tight = check(tumble, *arguments, "3e-3", code=0), check(tumble, *arguments, "1.3e-4", code=1)
    assert loose["sources"]["alpha4_rad"]["verdict"] == "meets"
    assert tight["sources"]["alpha4_rad"]["verdict"] == "does not meet"
    for found in (loose, tight):
        for source in found["sources"].values():
            assert (source["limit"], source["verdict"]) == tuple(source["needed"].values())
    ratio = loose["sources"]["alpha4_rad"]["limit"] / tight["sources"]["alpha4_rad"]["limit"]
    assert ratio == pytest.approx(3e-3 / 1.3e-4, rel=1e-6)


def test_a_stand_file_without_a_block_says_nothing_of_needs(tumble, refused, tmp_path):
    text = (EXAMPLES / "lab_stand.toml").read_text()
    stand = tmp_path / "stand.toml"
    stand.write_text(text[: text.index("[block]")])
    found = check(tumble, "--stand", stand, "lab_stand.csv", code=0)
    assert {source["needed"] for source in found["sources"].values()} == {None}
    asked = ("--stand", stand, EXAMPLES / "lab_stand.csv", "--against", "needed")
    assert "no table [block]" in refused("fixture", "check", *asked)


def test_a_run_of_lone_means_is_judged_by_the_declared_noise(tumble, tmp_path):
    lines = (EXAMPLES / "lab_stand.csv").read_text().splitlines()
    run = tmp_path / "run.csv"
    run.write_text("\n".join([lines[0], *lines[1::25]]) + "\n")
    stand = tmp_path / "stand.toml"
    stand.write_text((EXAMPLES / "lab_stand.toml").read_text().replace("samples = 25", "samples = 1"))
    found = check(tumble, "--stand", stand, run, "--limit", "1e-2", code=0)
    noise = found["sources"]["noise_v"]
    assert (noise["value"], noise["verdict"]) == (None, "cannot tell")
    assert found["sources"]["alpha4_rad"]["freedom"] == 16


def test_any_schedule_may_be_checked(tumble):
    """Six faces and check positions: what the positions cannot show is null, and cannot be told."""
    arguments = ("--stand", "paper_stand.toml", "--schedule", "six_faces.toml", "--estimator", "least_squares")
    found = check(tumble, "six_faces.csv", *arguments, code=0)
    assert found["sources"]["alpha3_difference_rad"]["value"] is None
    assert found["sources"]["alpha3_difference_rad"]["verdict"] == "cannot tell"
    check(tumble, "with_checks.csv", "--stand", "paper_stand.toml", "--schedule", "with_checks.toml", code=0)


def bench_runs(tumble, tmp_path, *options, seeds=(1, 2, 3)):
    folders = [tmp_path / str(seed) for seed in seeds]
    for seed, folder in zip(seeds, folders):
        done = tumble("bench", "--seed", seed, "--limit", "1e-2", *options, "--out", folder, "--json", cwd=EXAMPLES)
        assert done.returncode == 0, done.stderr
    return [folder / "run.csv" for folder in folders]


def test_several_runs_of_the_bench(tumble, tmp_path):
    """Each seed levels its stand anew, of one block; the text fits 80 columns and ends in one sentence."""
    runs = bench_runs(tumble, tmp_path, "--stand", "lab_stand.toml")
    found = check(tumble, "--stand", "lab_stand.toml", *runs, "--limit", "1e-2", code=0)
    assert found["levelled"] == "anew" and found["combined"]["consistent"] is True
    assert found["sources"]["alpha1_rad"]["freedom"] == 3 and found["sources"]["alpha4_rad"]["freedom"] == 48
    truth = json.loads((EXAMPLES / "lab_stand.truth.json").read_text())
    score = (np.array(found["combined"]["K"]) - truth["K"]) / found["combined"]["u_K"]
    assert np.abs(score).max() < 4
    once = check(tumble, "--stand", "lab_stand.toml", *runs, "--limit", "1e-2", "--levelled", "once", code=0)
    assert once["sources"]["alpha1_rad"]["freedom"] == 1 and once["combined"]["consistent"] is False
    assert {once["combined"][name] for name in ("K", "U0", "u_K", "u_U0")} == {None}
    text = tumble("fixture", "check", "--stand", "lab_stand.toml", *runs, "--limit", "1e-2", cwd=EXAMPLES).stdout
    assert max(map(len, text.splitlines())) <= 80
    assert text.splitlines()[-1].endswith(".") and "PASS, not conclusive: nothing exceeds" in text
    assert "cannot tell yet whether any source is as good as declared" in " ".join(text.split())
    assert "every source meets what 0.01 g needs" in " ".join(text.split())
    assert "Assuming a square seat:" in text and "axis (K_yz, K_zy)." in " ".join(text.split())
    assert [line.split()[0] for line in text.splitlines() if line.startswith("  K_") and "* " in line] == [
        "K_yz*",
        "K_zy*",
    ]
    arguments = ("--stand", "lab_stand.toml", *runs, "--limit", "1e-2", "--levelled", "once")
    text = tumble("fixture", "check", *arguments, cwd=EXAMPLES).stdout
    assert "There is no combined result." in text and "K_xx" not in text
    assert " ".join(text.split()).endswith("; the runs do not agree with each other.")


def test_a_bad_head_is_found_on_the_bench(tumble, tmp_path):
    """A stand whose set angles are three times worse than its file says."""
    worse = tmp_path / "worse.toml"
    worse.write_text((EXAMPLES / "lab_stand.toml").read_text().replace("angle_rad = 2e-4", "angle_rad = 6e-4"))
    runs = bench_runs(tumble, tmp_path, "--stand", worse, seeds=(7,))
    found = check(tumble, "--stand", "lab_stand.toml", *runs, "--limit", "1e-2", code=1)
    missed = [name for name, source in found["sources"].items() if source["verdict"] == "does not meet"]
    assert missed == ["alpha4_rad"]


def test_what_is_refused(refused, tmp_path):
    run, stand = EXAMPLES / "lab_stand.csv", EXAMPLES / "lab_stand.toml"
    mv = tmp_path / "mv.csv"
    mv.write_text(run.read_text().replace("ux,uy,uz", "ux [mV],uy [mV],uz [mV]"))
    cases = {
        ("--stand", stand, run, run): "is given twice",
        ("--stand", stand, run, mv): "mv.csv: outputs in mV, those of the runs before in V",
        ("--stand", stand, run, "--confidence", "1"): "--confidence: '1' is not a number from 0.5 to 0.9999",
        ("--stand", stand, run, "--limit", "-1"): "--limit: ",
        ("--stand", stand, run, "--limit", "0"): "--limit: '0' is not a number of g above 0",
        ("--stand", tmp_path / "no.toml", run): "no such file",
        ("--stand", stand, tmp_path / "no.csv"): "no such file",
        ("--stand", stand): "the following arguments are required: RUN.csv",
        (run,): "the following arguments are required: --stand",
    }
    for arguments, message in cases.items():
        assert message in refused("fixture", "check", *arguments), arguments
    assert "required: SUBJECT" in refused("fixture")


@pytest.mark.slow
def test_the_optimal_estimator_may_be_checked_and_combined(tumble, tmp_path):
    """Like the others, and sharper."""
    runs = bench_runs(tumble, tmp_path, "--stand", "lab_stand.toml")
    arguments = ("--stand", "lab_stand.toml", *runs, "--limit", "1e-2")
    refined = check(tumble, *arguments, code=0)["combined"]
    optimal = check(tumble, *arguments, "--estimator", "optimal", code=0)["combined"]
    truth = json.loads((EXAMPLES / "lab_stand.truth.json").read_text())
    assert np.abs((np.array(optimal["K"]) - truth["K"]) / optimal["u_K"]).max() < 4
    assert optimal["consistent"] and optimal["u_K"][0][0] < 0.7 * refined["u_K"][0][0]


def test_the_page_says_how_many_runs_a_verdict_takes():
    """The table, computed again from the distributions that the verdicts use."""
    page = (ROOT / "docs" / "method.md").read_text()
    rows = re.findall(r"^\| (\d?\.?\d*) ?(twice|times) (better|worse)[^|]*\| (\d+) \| (\d+) \|$", page, re.MULTILINE)
    assert len(rows) == 7
    for factor, twice, way, single, sixteen in rows:
        size = 2.0 if twice == "twice" else float(factor)
        ratio = size if way == "worse" else 1.0 / size
        assert (fewest_runs(ratio, 1), fewest_runs(ratio, 16)) == (int(single), int(sixteen))


def fewest_runs(ratio, freedom):
    """Until a standard deviation that is `ratio` times the limit gets its verdict in nine checks of ten."""
    p = Judge([], 0.95, False).verdict_confidence
    for runs in range(1, 200):
        nu = runs * freedom
        missed = 1 - chi_squared_cdf(chi_squared_quantile(p, nu) / ratio**2, nu)
        met = chi_squared_cdf(chi_squared_quantile(1 - p, nu) / ratio**2, nu)
        if (missed if ratio > 1 else met) >= 0.9:
            return runs
    raise AssertionError("never")


def test_an_unreachable_need_is_a_need_not_met_and_no_fault(tumble):
    """As many samples do not fit a position: what the file declares is judged all the same."""
    arguments = ("--stand", "paper_stand.toml", "paper_stand.csv", "--limit", "1e-9")
    found = check(tumble, *arguments, code=1)  # by the gravity check
    assert {source["declared"]["verdict"] for source in found["sources"].values()}.isdisjoint({"does not meet"})
    assert found["sources"]["noise_v"]["needed"]["verdict"] == "does not meet"


def test_a_common_yaw_needs_no_difference_of_yaws(tumble, tmp_path):
    stand = paper_stand(tmp_path, samples='50\nremount = "common"')
    done = tumble("fixture", "check", "--stand", stand, EXAMPLES / "paper_stand.csv", "--json")
    need = json.loads(done.stdout)["sources"]["alpha3_difference_rad"]["needed"]
    assert need == {"limit": None, "verdict": "meets"}


def test_runs_that_agree_only_if_levelled_anew_were(tumble, tmp_path):
    """Their axis tilts do not differ beyond chance, but the zero of the table angle must have moved."""
    stand = paper_stand(tmp_path, level_rad="5e-4")
    runs = bench_runs(tumble, tmp_path, "--stand", stand)
    once = check(tumble, "--stand", stand, *runs, "--limit", "1e-2", "--levelled", "once", code=1)
    found = check(tumble, "--stand", stand, *runs, "--limit", "1e-2", code=0)
    assert once["combined"]["consistent"] is False
    assert found["levelled"] == "anew" and found["combined"]["consistent"] is True
    text = tumble("fixture", "check", "--stand", stand, *runs, "--limit", "1e-2", "--levelled", "once").stdout
    assert "(--levelled)" in text


def test_perfect_runs_of_a_perfect_stand(tumble, tmp_path):
    zeros = re.sub("(_rad|noise_v) = .*", r"\1 = 0", (EXAMPLES / "paper_stand.toml").read_text().split("[block]")[0])
    (tmp_path / "stand.toml").write_text(zeros)
    perfect = Geometry(PAPER).outputs(NOMINAL_K, U0)
    runs = [write_run(tmp_path / f"{name}.csv", PAPER, perfect) for name in ("one", "other")]
    found = check(tumble, "--stand", tmp_path / "stand.toml", *runs, code=0)
    assert found["combined"]["consistent"] and np.array(found["combined"]["K"]) == pytest.approx(NOMINAL_K)
    perfect[4, 0] += 1e-5
    runs[1] = write_run(tmp_path / "off.csv", PAPER, perfect)
    assert check(tumble, "--stand", tmp_path / "stand.toml", *runs, code=1)["combined"]["consistent"] is False
