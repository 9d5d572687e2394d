"""`tumble compare`: two calibrations of one block, against fractions, rotations, and what the reference propagates."""

import dataclasses
import json
import re
from fractions import Fraction

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block
from calibrations import U, result
from conftest import EXAMPLES, ROOT
from documents import valid

from tumble.comparison.verdict import Calibration, holm, is_covariance, judge, whitened
from tumble.distributions import chi_squared_above, chi_squared_quantile
from tumble.units import rounded

pytestmark = pytest.mark.python
U0 = np.array([0.01, -0.02, 0.03])
NAMES = [*(f"scale_{i}" for i in "xyz"), "angle_xy", "angle_xz", "angle_yz", *(f"bias_{i}" for i in "xyz")]
AGAIN = "tumble: warning: both are of one run: its noise is in both, but is counted as independent\n"


@pytest.fixture
def compare(tumble, tmp_path):
    """Hold two documents against each other: exit code, document, stderr."""

    def run(a, b, *options):
        for name, document in (("a", a), ("b", b)):
            (tmp_path / f"{name}.json").write_text(json.dumps(document))
        done = tumble("compare", "a.json", "b.json", "--json", *options, cwd=tmp_path)
        return done.returncode, valid(done.stdout, "comparison"), done.stderr

    return run


def rotation(vector):
    """By Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def covariance(rng, size=1e-5, rank=12):
    draws = rng.normal(size=(rank, 12)) * size * 10.0 ** rng.uniform(-1, 0, 12)
    return draws.T @ draws


def calibration(k, u0, joint):
    return Calibration(np.concatenate([np.asarray(k).ravel(), u0]), joint)


def solved_exactly(rows, right):
    """Gauss and Jordan, in fractions."""
    rows = [[*row, one] for row, one in zip(rows, right)]
    for i in range(len(rows)):
        pivot = next(j for j in range(i, len(rows)) if rows[j][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [value / rows[i][i] for value in rows[i]]
        for j in range(len(rows)):
            if j != i:
                rows[j] = [one - rows[j][i] * other for one, other in zip(rows[j], rows[i])]
    return [row[-1] for row in rows]


def test_differences_and_chi_squared_are_those_of_fractions(compare):
    """Diagonal covariances; seat and whole by normal equations in fractions, the block by what the seat leaves."""
    rng = np.random.default_rng(11)
    first, second = (np.concatenate([NOMINAL_K.ravel(), U0]) + rng.normal(size=12) * 3e-6 for _ in range(2))
    variances = [(rng.uniform(1e-6, 2e-5, 12)) ** 2 for _ in range(2)]
    files = [result(c[:9].reshape(3, 3), c[9:], np.diag(v)) for c, v in zip((first, second), variances)]
    code, found, said = compare(*files)
    a, b, v, w = ([Fraction(float(one)) for one in values] for values in (first, second, *variances))
    difference, variance = [y - x for x, y in zip(a, b)], [x + y for x, y in zip(v, w)]
    for row, d, s in zip(found["coefficients"], difference, variance):
        assert row["difference"] == pytest.approx(float(d), rel=1e-9)
        assert row["u"] ** 2 == pytest.approx(float(s), rel=1e-12)
        assert row["in_u"] ** 2 == pytest.approx(float(d * d / s), rel=1e-9)
    k = [[(a[3 * i + j] + b[3 * i + j]) / 2 for j in range(3)] for i in range(3)]
    turns = []  # K [phi]x: row i is K_i x e, as (K_i [e]x) = K_i cross e transposed
    for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        cross = [[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]]
        product = [sum(k[i][m] * cross[m][j] for m in range(3)) for i in range(3) for j in range(3)]
        turns.append(product + [Fraction(0)] * 3)
    normal = [[sum(x * y / s for x, y, s in zip(one, other, variance)) for other in turns] for one in turns]
    right = [sum(x * d / s for x, d, s in zip(one, difference, variance)) for one in turns]
    angles = solved_exactly(normal, right)
    whole = sum(d * d / s for d, s in zip(difference, variance))
    seat = sum(angle * one for angle, one in zip(angles, right))
    tests = found["tests"]
    assert tests["all"]["chi2"] == pytest.approx(float(whole), rel=1e-9) and tests["all"]["dof"] == 12
    assert tests["seat"]["chi2"] == pytest.approx(float(seat), rel=1e-9) and tests["seat"]["dof"] == 3
    assert tests["block"]["chi2"] == pytest.approx(float(whole - seat), rel=1e-4) and tests["block"]["dof"] == 9
    assert [row["difference"] for row in found["seat"]] == pytest.approx([1e6 * float(x) for x in angles], rel=1e-8)
    assert (code, said) == (0 if found["verdict"] != "block" else 1, "")


def test_the_derivatives_are_those_of_the_parameters():
    """Central differences, of a block with large misalignments."""
    k, u0 = random_block(np.random.default_rng(12), 0.3)
    at = Calibration(np.concatenate([k.ravel(), u0, [1e-4, 2e-4, 3e-4]]), None, ("k2",))
    steps = 1e-6 * np.abs(k).max() * np.eye(15)
    moved = [[dataclasses.replace(at, values=at.values + sign * step).parameters for sign in (1, -1)] for step in steps]
    slopes = np.array([(more - less) / (2 * step.max()) for (more, less), step in zip(moved, steps)]).T
    assert at.by_values == pytest.approx(slopes, rel=1e-6, abs=1e-8 * np.abs(slopes).max())


@pytest.mark.parametrize("angle", [1e-5, 1e-2, 2.0])
def test_a_turn_is_of_the_seat_and_nothing_else(angle):
    """However large: K R has the lengths, angles and biases of K, with the same uncertainties."""
    rng = np.random.default_rng(13)
    for _ in range(20):
        k, u0 = random_block(rng)
        turn = rng.normal(size=3)
        turn *= angle / np.linalg.norm(turn)
        joint = covariance(rng, 1e-8 * np.abs(k).max())
        to_turned = np.zeros((12, 12))
        to_turned[:9, :9], to_turned[9:, 9:] = np.kron(np.eye(3), rotation(turn).T), np.eye(3)
        a = calibration(k, u0, joint)
        b = calibration(k @ rotation(turn), u0, to_turned @ joint @ to_turned.T)
        found = judge(a, b, 0.0, 0.999)
        assert found.verdict.value == "seat" and not found.changed.any()
        assert np.abs(found.parameters.size).max() < 1e-14 * 100
        alone = np.sqrt(np.diag(a.by_values @ joint @ a.by_values.T))
        assert found.parameters.u == pytest.approx(np.sqrt(2) * alone, rel=1e-6)
        assert found.seat.size == pytest.approx(turn, rel=1e-6, abs=1e-9 * angle)


def test_b_with_a_is_a_with_b_the_other_way_round():
    rng = np.random.default_rng(14)
    for size in (1e-7, 1e-5, 1e-3):
        k, u0 = random_block(rng)
        size *= np.abs(k).max()
        moved = k + rng.normal(size=(3, 3)) * size, u0 + rng.normal(size=3) * size
        draws = rng.normal(size=(2, 2, 12)) * size
        own = [calibration(*one, covariance(rng, size)) for one in ((k, u0), moved)]
        pairs = [dataclasses.replace(one, in_common=both) for one, both in zip(own, draws)]
        forth, back = judge(*pairs, 1e-6, 0.999), judge(*pairs[::-1], 1e-6, 0.999)
        for name in ("coefficients", "parameters", "seat"):
            assert getattr(forth, name).size == pytest.approx(-getattr(back, name).size, rel=1e-12)
            assert getattr(forth, name).u == pytest.approx(getattr(back, name).u, rel=1e-6)
        for name in ("all_twelve", "block", "seat"):
            assert getattr(forth.tests, name).chi2 == pytest.approx(
                getattr(back.tests, name).chi2, rel=1e-6
            )
        assert (forth.verdict, forth.changed.tolist()) == (back.verdict, back.changed.tolist())


def test_a_result_is_the_same_as_itself(tumble, tmp_path):
    run, stand = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"
    assert tumble("solve", run, "--stand", stand, "--out", "r.json", cwd=tmp_path).returncode == 0
    done = tumble("compare", "r.json", "r.json", "--json", cwd=tmp_path)
    found = valid(done.stdout, "comparison")
    assert (done.returncode, done.stderr, found["verdict"], found["changed"]) == (0, AGAIN, "unchanged", [])
    rows = [*found["coefficients"], *found["parameters"], *found["seat"]]
    assert {(row["difference"], row["in_u"]) for row in rows} == {(0.0, 0.0)}
    assert {found["tests"][name]["chi2"] for name in ("all", "block", "seat")} == {0.0}
    text = tumble("compare", "r.json", "r.json", cwd=tmp_path)
    assert (text.returncode, text.stderr) == (0, AGAIN) and max(map(len, text.stdout.splitlines())) <= 80
    said = "UNCHANGED: no change of the block or of its seat is detectable."
    assert text.stdout.startswith(f"{said}\n\nA: r.json,")
    assert (
        "\n- Confidence: 99.9 % or more of untouched blocks are called unchanged, assuming\n"
        "  a square seat, volts and one temperature.\n"
    ) in text.stdout
    assert "Holm" not in text.stdout and "chi" not in text.stdout


CHANGES = {
    "scale_y": (lambda k, u0: (k * (1 + 2e-4 * np.eye(3)[1])[:, None], u0), 200.0, "ppm"),
    "bias_z": (lambda k, u0: (k, u0 + 5e-4 * np.linalg.norm(k[2]) * np.eye(3)[2]), 500.0, "ug"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_has_changed_is_named_with_its_size(name, compare, tumble, tmp_path):
    change, size, unit = CHANGES[name]
    k, u0 = NOMINAL_K, np.zeros(3)
    code, found, said = compare(result(k, u0, np.diag(U**2)), result(*change(k, u0), np.diag(U**2)))
    assert (code, said, found["verdict"], found["changed"]) == (1, "", "block", [name])
    row = found["parameters"][NAMES.index(name)]
    assert row["difference"] == pytest.approx(size, rel=2e-4) and row["unit"] == unit and row["changed"]
    u = {"ppm": 2e-5, "ug": 1e-5}[unit] * np.sqrt(2) / np.linalg.norm(k[0]) * 1e6
    assert row["u"] == pytest.approx(u, rel=2e-4)
    text = tumble("compare", "a.json", "b.json", cwd=tmp_path)
    assert text.returncode == 1
    places = 0 if u >= 10 else 1
    assert text.stdout.split("\n\n")[0] == (
        f"THE BLOCK HAS CHANGED: {name.replace('_', ' ')} {row['difference']:+.{places}f} +- {u:.{places}f} {unit}."
    )


def test_the_chances_are_those_that_the_verdict_is_made_of(compare, tumble, tmp_path):
    """In percent, beside the limit; the p of a parameter stands in its row."""
    k = NOMINAL_K * (1 + 4.5e-5 * np.eye(3)[1])[:, None]
    _, found, _ = compare(result(NOMINAL_K, U0, np.diag(U**2)), result(k, U0, np.diag(U**2)))
    text = tumble("compare", "a.json", "b.json", "--confidence", "0.99", cwd=tmp_path).stdout
    percent = {key: 100.0 * p for key, p in found["tests"]["after_holm"].items()}
    assert 1e-3 < percent["alone"] < 99.0 and percent["alone"] != percent["whole"]
    shown = re.findall(r"^(the block, all together|the block, any one alone|its seat) +([\d.]+) %$", text, re.MULTILINE)
    expected = [percent[key] for key in ("whole", "alone", "seat")]
    assert [float(one) for _, one in shown] == pytest.approx(expected, rel=0.06)
    assert "(a change: below 1 %):" in text
    (row,) = re.findall(r"^scale y .* ([\d.]+) %$", text, re.MULTILINE)
    assert float(row) == pytest.approx(100.0 * found["parameters"][1]["p"], rel=0.06)


def test_only_the_seat_is_no_change_of_the_block(compare):
    turned = NOMINAL_K @ rotation([3e-3, 0.0, 0.0])
    code, found, said = compare(result(NOMINAL_K, U0, np.diag(U**2)), result(turned, U0, np.diag(U**2)))
    assert (code, said, found["verdict"], found["changed"]) == (0, "", "seat", [])
    assert found["seat"][0]["difference"] == pytest.approx(3000.0, rel=1e-9)


def test_without_uncertainties_nobody_can_tell(compare, tumble, tmp_path):
    code, found, said = compare(result(NOMINAL_K, U0, np.diag(U**2)), result(1.5 * NOMINAL_K, U0))
    assert (code, said, found["verdict"], found["changed"], found["tests"]) == (1, "", "cannot tell", [], None)
    assert {row["u"] for row in found["parameters"]} == {None}
    assert found["parameters"][0]["difference"] == pytest.approx(1e6 * np.log(1.5))
    text = tumble("compare", "a.json", "b.json", cwd=tmp_path)
    assert (text.returncode, text.stdout.split("\n\n")[0].splitlines()) == (1, [
        "CANNOT TELL: b.json has no uncertainties: solve its run again with --stand FILE.",
        "A stand file (TOML) says how exact the stand is; to get one, copy",
        "examples/paper_stand.toml and put in the numbers of your own stand",
        "(docs/first-calibration.md, step 1).",
    ])  # fmt: skip
    assert (ROOT / "examples/paper_stand.toml").is_file()
    step = (ROOT / "docs/first-calibration.md").read_text().split("\n### 1. ")[1]
    assert step.startswith("Describe the stand\n") and "Copy `examples/diagonal_stand.toml`" in step
    both = tumble("compare", "b.json", "b.json", cwd=tmp_path).stdout.replace("\n", " ")
    assert both.startswith("CANNOT TELL: b.json and b.json have no uncertainties: solve their runs again with --stand")


def test_a_direction_without_variance_counts_only_where_something_is_in_it():
    """Rank five of twelve: chi-squared as by the pseudo-inverse; one part in a million outside is no chance."""
    rng = np.random.default_rng(15)
    draws = rng.normal(size=(5, 12))
    joint, inside = draws.T @ draws, rng.normal(size=5) @ draws
    found = whitened(joint, inside, np.full(12, 1e-13)).test
    assert found.dof == 5
    assert found.chi2 == pytest.approx(inside @ np.linalg.pinv(joint, hermitian=True) @ inside, rel=1e-8)
    outside = np.linalg.svd(draws)[2][-1]
    assert whitened(joint, inside + 1e-4 * outside, np.full(12, 1e-13)).test.p < 1e-9


def test_coefficients_without_any_uncertainty_are_compared_exactly():
    a = calibration(NOMINAL_K, U0, np.zeros((12, 12)))
    same, other = calibration(NOMINAL_K, U0, np.zeros((12, 12))), calibration(NOMINAL_K, U0 + 1e-9, np.zeros((12, 12)))
    assert judge(a, same, 0.0, 0.999).verdict.value == "unchanged"
    found = judge(a, other, 0.0, 0.999)
    assert found.verdict.value == "block" and np.flatnonzero(found.changed).tolist() == [6, 7, 8]


def test_what_is_no_covariance():
    joint = covariance(np.random.default_rng(17), rank=5)
    assert is_covariance(joint) and is_covariance(np.zeros((12, 12)))
    for place, factor in (((0, 1), 2.0), ((3, 3), -1.0), ((3, 3), 0.0), ((3, 3), 0.99)):
        other = joint.copy()
        other[place] *= factor
        assert not is_covariance(other), place


def test_holm():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.5, 0.9]) == pytest.approx([1.0, 1.0])
    assert holm([]) == []


def test_p_is_that_of_chi_squared(compare):
    """Nine degrees of freedom: just above the quantile of a third of 1e-3 the block has changed."""
    limit = chi_squared_quantile(1 - 1e-3 / 3, 9)
    for factor, verdict in ((1.001, "block"), (0.999, "unchanged")):
        a = calibration(2.0 * np.eye(3), np.zeros(3), np.diag(U**2))
        each = np.sqrt(factor * limit / 9)  # all nine of this many u: none stands out by itself
        u = U * np.sqrt(2)
        k = 2.0 * np.eye(3) + np.diag(each * u[:3])
        for i, j in ((0, 1), (0, 2), (1, 2)):
            k[i, j] = k[j, i] = each * u[0] / np.sqrt(2)
        b = calibration(k, each * u[9:], np.diag(U**2))
        found = judge(a, b, 0.0, 0.999)
        assert found.tests.block.chi2 == pytest.approx(factor * limit, rel=3e-4)
        assert found.verdict.value == verdict and not found.changed.any()
        assert found.tests.block.p == chi_squared_above(found.tests.block.chi2, 9)


def test_one_parameter_that_would_explain_it_is_told(compare, tumble, tmp_path):
    """Errors that all scale factors have in common hide the change of one in its u, but not in the three together."""
    rng, common = np.random.default_rng(16), np.zeros(12)
    common[[0, 4, 8]] = 2e-3
    joint = np.diag(np.full(12, 1e-6) ** 2) + np.outer(common, common)
    k = 2.0 * np.eye(3)
    code, found, _ = compare(result(k, np.zeros(3), joint), result(k + np.diag([0.0, 2e-5, 0.0]), np.zeros(3), joint))
    assert (code, found["verdict"], found["changed"]) == (1, "block", [])
    a, b = calibration(k, np.zeros(3), joint), calibration(k + np.diag([0.0, 2e-5, 0.0]), np.zeros(3), joint)
    both = sum(one.by_values @ joint @ one.by_values.T for one in (a, b))
    weights, difference = np.linalg.inv(both), b.parameters - a.parameters
    size, u = weights[1] @ difference / weights[1, 1], weights[1, 1] ** -0.5
    left = difference - size * np.eye(9)[1]
    told = found["explained_by"]
    assert (told["name"], told["unit"]) == ("scale_y", "ppm")
    assert (told["difference"], told["u"]) == pytest.approx((1e6 * size, 1e6 * u), rel=1e-5)
    assert told["p"] == pytest.approx(chi_squared_above(float(left @ weights @ left), 8.0), abs=1e-3)
    text = tumble("compare", "a.json", "b.json", cwd=tmp_path).stdout.split("\n\n")[0]
    assert text.replace("\n", " ").endswith(
        "no parameter by itself, but all together; scale y +10.00 +- 0.87 ppm alone would explain it."
    )
    moved = k + np.diag(rng.permutation([0.0, 2e-5, -3e-5]))
    assert compare(result(k, np.zeros(3), joint), result(moved, np.zeros(3), joint))[1]["explained_by"] is None


def test_gravity_of_another_place_is_taken_out(compare):
    here, there = {"gravity_m_s2": 9.78, "u_gravity_m_s2": 1e-5}, {"gravity_m_s2": 9.83, "u_gravity_m_s2": 2e-5}
    pair = [result(NOMINAL_K * g["gravity_m_s2"] / 9.8, U0, np.diag(U**2), environment=g) for g in (here, there)]
    code, found, _ = compare(*pair)
    assert (code, found["verdict"]) == (0, "unchanged")
    assert max(abs(row["difference"]) for row in found["parameters"]) < 1e-6
    relative = np.hypot(1e-5 / 9.78, 2e-5 / 9.83) * 1e6
    own = 2e-5 / np.linalg.norm(NOMINAL_K[0] * 9.78 / 9.8) * np.hypot(1.0, 9.78 / 9.83) * 1e6
    assert found["parameters"][0]["u"] == pytest.approx(np.hypot(relative, own), rel=1e-9)
    untold = [{**one, "environment": None} for one in pair]
    assert compare(*untold)[:2][0] == 1


@pytest.mark.parametrize(
    ("size", "u", "shown"),
    [
        (-37.4142, 19.96, ("-37", "20")),
        (0.123456, 0.0567, ("+0.123", "0.057")),
        (3.2e-5, 1.44e-5, ("+3.2e-05", "1.4e-05")),
        (1.2345e-3, 2.3e-5, ("+1.234e-03", "2.3e-05")),
        (-0.0234567, 4.4e-6, ("-2.34567e-02", "4.4e-06")),
        (2.1e-6, 2.3e-5, ("+2e-06", "2.3e-05")),
        (0.0, 2.3e-5, ("+0e+00", "2.3e-05")),
        (261376.4, 123.4, ("+261376", "123")),
        (1.23456, None, ("+1.23", "-")),
        (0.0, 0.0, ("+0", "0")),
    ],
)
def test_a_difference_has_the_digits_that_its_uncertainty_leaves(size, u, shown):
    assert rounded(size, u) == shown
