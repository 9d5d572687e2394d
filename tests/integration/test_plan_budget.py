"""Error budgets: reference values worked out independently, weights against brute force, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from blocks import random_schedule, usable_schedule
from conftest import EXAMPLES
from documents import document_of, paper_stand
from hypothesis import given, strategies as st

from tumble import model
from tumble.files.stand_file import read_stand
from tumble.planning import weights
from tumble.planning.budget import budget
from tumble.planning.case import Case
from tumble.planning.validate import validate
from tumble.planning.weights import NAMES, SOURCES

pytestmark = pytest.mark.python

ESTIMATORS = ("averaged", "refined", "least_squares", "optimal")
PAPER = Case.of(None, None, None)

# In ppm of K_xx; K_yy, K_zz; K_xy, K_xz; K_yx, K_zx; K_yz, K_zy; then in ug a0_x; a0_y, a0_z.
REFERENCE = {
    ("averaged", "independent"): (11.8, 14.1, 1368, 10030, 497, 8.4, 12.5),
    ("refined", "independent"): (11.8, 14.1, 1368, 1480, 497, 8.4, 12.5),
    ("averaged", "common"): (10.3, 14.1, 1368, 9829, 497, 8.4, 12.5),
    ("refined", "common"): (10.3, 14.1, 1368, 1480, 497, 8.4, 12.5),
}
COLUMN = {"xx": 0, "yy": 1, "zz": 1, "xy": 2, "xz": 2, "yx": 3, "zx": 3, "yz": 4, "zy": 4}


def plan(tumble, *arguments):
    """A JSON document of tumble plan, valid by its schema."""
    return document_of(tumble("plan", *arguments, "--json"), "plan")


@pytest.mark.parametrize(("estimator", "remounting"), REFERENCE)
def test_reference_rows(estimator, remounting):
    case = replace(PAPER, stand=replace(PAPER.stand, remounting=remounting))
    table = REFERENCE[estimator, remounting]
    expected = [table[COLUMN[i + j]] for i in "xyz" for j in "xyz"] + [table[5], table[6], table[6]]
    assert 1e6 * budget(case, "derived", estimator).total == pytest.approx(np.array(expected), rel=0.01)


def test_a_budget_is_what_a_run_would_state():
    """The document, against the uncertainties that numpy gives a run with this K."""
    for estimator in ("averaged", "refined", "least_squares"):
        found, k = budget(PAPER, "derived", estimator), PAPER.nominal_k()
        covariance = model.Propagation(PAPER.schedule, k, PAPER.stand, np.ones(18, int), estimator).covariance()
        u_k, u_u0 = model.by_coefficient(covariance)
        assert found.total[:9] == pytest.approx((u_k / np.abs(k)).ravel(), rel=1e-9)
        assert found.total[9:] == pytest.approx(u_u0 / np.abs(np.diag(k)), rel=1e-9)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_json_of_every_estimator(estimator, tumble):
    document = plan(tumble, "budget", "--stand", EXAMPLES / "lab_stand.toml", "--estimator", estimator)
    assert (document["schema"], document["plan"], document["estimator"]) == ("tumble.plan/1", "budget", estimator)
    assert list(document["terms"]) == list(NAMES)
    totals = [value for row in document["u_K_relative"] for value in row] + document["u_a0_g"]
    for total, terms in zip(totals, document["terms"].values()):
        assert total == pytest.approx(sum(term**2 for term in terms) ** 0.5, rel=1e-12)


def test_any_schedule_check_positions_left_out(tumble):
    """They are judged all the same, so the promise knows them."""
    with_checks = plan(tumble, "budget", "--schedule", EXAMPLES / "with_checks.toml")
    promised = with_checks["promise"]
    assert with_checks == {**plan(tumble, "budget"), "block": with_checks["block"], "promise": promised}
    faces = plan(tumble, "budget", "--schedule", EXAMPLES / "six_faces.toml", "--estimator", "least_squares")
    assert faces["u_K_relative"][0][0] > with_checks["u_K_relative"][0][0]


@given(st.integers(0, 2**32 - 1))
def test_weights_on_any_schedule_are_those_of_complex_steps(seed):
    rng = np.random.default_rng(seed)
    schedule = random_schedule(rng)
    if not (fit := schedule.fit_indices):
        return
    common, k = bool(rng.random() < 0.5), rng.normal(size=(3, 3))
    gains = rng.normal(size=(4, 3 * len(fit)))
    mountings = len(schedule.mountings)
    units = {"alpha1": np.ones((1, 1)), "alpha2": np.ones((1, 1)), "delta": np.eye(len(schedule.positions))}
    units["alpha3"] = np.ones((1, mountings)) if common else np.eye(mountings)
    geometry, squares = model.Geometry(schedule), {"noise": (gains**2).sum(axis=1)}
    for name, draws in units.items():
        outputs = geometry.force(**{name: 1e-30j * draws}).imag[:, fit] / 1e-30 @ k.T
        squares[name] = ((outputs.reshape(len(draws), -1) @ gains.T) ** 2).sum(axis=0)
    squares["alpha4"] = squares.pop("delta")
    expected = np.sqrt([squares[source] for source in SOURCES]).T
    found = weights.absolute_weights(schedule.fitted, common, k, gains)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-11 * expected.max())


def test_optimal_is_never_worse():
    rng = np.random.default_rng(81)
    for _ in range(20):
        case = replace(PAPER, own_schedule=usable_schedule(rng).data)
        better, ordinary = (budget(case, "derived", name).total for name in ("optimal", "least_squares"))
        assert (better <= ordinary * (1 + 1e-6)).all()


def test_zero_coefficients_have_no_relative_error(tumble, tmp_path):
    straight = paper_stand(tmp_path, misalignment_rad=0)
    for which in ("derived", "published"):
        document = plan(tumble, "budget", "--stand", straight, "--weights", which)
        assert [[value is None for value in row] for row in document["u_K_relative"]] == (
            ~np.eye(3, dtype=bool)
        ).tolist()
        assert document["terms"]["K_xy"] == [None] * 5
        assert None not in document["u_a0_g"]


def test_a_large_yaw_is_flagged(tumble, tmp_path):
    assert plan(tumble, "budget")["second_order"]["matters"] is False
    yaw = paper_stand(tmp_path, remount_rad="15e-3")
    flagged = plan(tumble, "budget", "--stand", yaw)["second_order"]
    assert flagged["matters"] and flagged["bias_K_xx_relative"] == pytest.approx(0.015**2 / 2)
    shown = tumble("plan", "budget", "--stand", yaw)
    assert "Beware" in shown.stdout and shown.stderr == ""


@pytest.mark.parametrize("subject", ["budget", "require", "paper"])
def test_tables_fit_80_columns(subject, tumble):
    done = tumble("plan", subject)
    assert (done.returncode, done.stderr) == (0, "")
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert tumble("plan", subject, PYTHONIOENCODING="ascii").returncode == 0


def test_a_row_of_a_budget_is_one_line_with_all_sources(tumble, tmp_path):
    lab = (EXAMPLES / "lab_stand.toml").read_text().replace("limits", "seat_rad = 1e-4\nplatform_rad = 1e-4\nlimits")
    (tmp_path / "stand.toml").write_text(lab)
    lines = tumble("plan", "budget", "--stand", tmp_path / "stand.toml").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    of_yz = next(line.split() for line in lines if "K_yz" in line)
    assert of_yz == ["K_yz,", "ppm", "0", "500", "0", "93.5", "1170", "5000", "5000", "7190"]


NO_BLOCK = '[stand]\naxis_tilt_rad=0\nlevel_rad=0\nremount_rad=0\nangle_rad=0\nnoise_v=0\nsamples=1\nlimits="sigma1"\n'
ONE_TURN = "[[mounting]]\nnumber = 1\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n" + "".join(
    f"[[position]]\nmounting = 1\nposition = {number}\nangle_deg = {60 * number}\n" for number in range(1, 7)
)
SIX_FACES = EXAMPLES / "six_faces.toml"
REFUSED = {
    "no subject": ([], "required"),
    "unknown subject": (["forecast"], "invalid choice"),
    "unknown estimator": (["budget", "--estimator", "best"], "invalid choice"),
    "unknown weights": (["require", "--weights", "guessed"], "invalid choice"),
    "no such stand": (["budget", "--stand", "nowhere.toml"], "nowhere.toml: no such file"),
    "no block": (["budget", "--stand", "no_block.toml"], "no_block.toml: no table [block]"),
    "schedule of deficient rank": (
        ["budget", "--schedule", "one_turn.toml"],
        "one_turn.toml: these positions cannot identify K_xy",
    ),
    **{
        f"{subject} harmonic on six faces": (
            [subject, "--schedule", SIX_FACES, "--estimator", "refined"],
            f"{SIX_FACES}: lacks positions that refined needs; least_squares solves any schedule",
        )
        for subject in ("budget", "require")
    },
    "published of optimal": (["budget", "--weights", "published", "--estimator", "optimal"], "averaged and refined"),
    "published on six faces": (
        ["budget", "--weights", "published", "--schedule", SIX_FACES, "--estimator", "refined"],
        "for its own 2 x 9 positions",
    ),
    "limit of zero": (["require", "--limit", "0"], "--limit: '0' is not a number of g above 0, at most 1"),
    "negative limit": (["require", "--limit=-1e-4"], "--limit: '-1e-4' is not a number of g above 0, at most 1"),
    "limit that is no number": (["require", "--limit", "nan"], "--limit: 'nan' is not"),
    "limit of 2 g": (["require", "--limit", "2"], "at most 1"),
    "unreachable": (["require", "--limit", "1e-9"], "unreachable"),
    "unreachable with optimal": (["require", "--limit", "1e-9", "--estimator", "optimal"], "unreachable"),
    "split of nothing": (["require", "--split", "alpha5=1"], "--split: 'alpha5=1' is not SOURCE=PART"),
    "split without a part": (["require", "--split", "noise"], "--split: 'noise' is not SOURCE=PART"),
    "split of zero": (["require", "--split", "noise=0"], "--split: '0' is not a number above 0"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refusals(case, refused, tmp_path):
    (tmp_path / "no_block.toml").write_text(NO_BLOCK)
    (tmp_path / "one_turn.toml").write_text(ONE_TURN)
    arguments, message = REFUSED[case]
    assert message in refused("plan", *arguments, cwd=tmp_path)


@pytest.mark.parametrize("key, source", [("axis_tilt_rad", "alpha1"), ("level_rad", "alpha2")])
def test_a_large_tilt_or_level_is_flagged_but_not_for_optimal(key, source, tumble, tmp_path):
    """They shorten every scale factor by half their square, which Monte Carlo confirms."""
    stand = paper_stand(tmp_path, **{key: "15e-3"})
    flagged = plan(tumble, "budget", "--stand", stand)["second_order"]
    assert flagged["matters"] and {shift["source"] for shift in flagged["shifts"]} == {source}
    own = {shift["coefficient"]: shift for shift in flagged["shifts"]}
    for shift in (own["K_xx"], own["K_yy"], own["K_zz"]):
        assert shift["bias_relative"] == pytest.approx(0.015**2 / 2, rel=1e-3)
        assert shift["bias_relative"] > shift["limit"]
    assert "second order shifts K_" in tumble("plan", "budget", "--stand", stand).stdout
    optimal = plan(tumble, "budget", "--stand", stand, "--estimator", "optimal")["second_order"]
    assert not optimal["matters"] and optimal["shifts"] == []
    case = Case.of(read_stand(stand), "", None)
    bias = validate(case, ("refined",), 20000, 1)[0].tally.bias
    assert bias[[0, 4, 8]] == pytest.approx(np.diag(case.nominal_k()) * -(0.015**2) / 2, rel=0.1)
