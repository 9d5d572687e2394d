"""What explains a misfit has a size that such a cause can have; mistakes of hands are named for what they are."""

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble
from tumble.model import Geometry, built_in
from tumble.model.patterns import BY_NAME

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib

pytestmark = pytest.mark.python

PAPER_STAND = {
    name: table
    for name, table in tomllib.loads((EXAMPLES / "paper_stand.toml").read_text()).items()
    if name in ("stand", "accept")
}
CHANGE_G, AT_1_G = 0.1, 0.05  # as docs/method.md has them
UNITS_G = {"ug": 1e-6, "ug/g": 1e-6, "ug/g^2": 1e-6, "ug/g^3": 1e-6, "ppm": 1e-6}
LARGEST = {
    **dict.fromkeys(("drift", "drift_exp", "step", "hysteresis"), CHANGE_G),
    **dict.fromkeys(("k2", "k3", "asymmetry", "cross_coupling", "scale_drift"), AT_1_G),
}


def explanations(name, change, stand=PAPER_STAND, noise_g=1e-5):
    """Of a run of a block of 1 V/g on this schedule; `change`: of the forces (positions, 3) that it feels."""
    schedule, rng = built_in(name), np.random.default_rng(0)
    rows = [
        [place.mounting, place.number, *(felt + rng.normal(0, noise_g, 3))]
        for place, felt in zip(schedule.positions, change(Geometry(schedule).force().copy()))
        for _ in range(20)
    ]
    found = tumble.solve(tumble.read(np.array(rows), unit="V"), schedule=name, stand=stand).document["fit"]
    assert not found["fits"]
    return [(one["patterns"], one["column"], one["size"], one["u_size"], one["unit"]) for one in found["explanations"]]


def crumb(place, rad):
    """A face lies on something: that position is tilted."""

    def tilted(force):
        axis = np.cross(force[place], [0.3, 0.5, 0.8])
        force[place] += rad * np.cross(axis / np.linalg.norm(axis), force[place])
        force[place] /= np.linalg.norm(force[place])
        return force

    return tilted


def exchanged(one, other):
    def swapped(force):
        force[[one, other]] = force[[other, one]]
        return force

    return swapped


def require_plausible(found):
    for patterns, _, size, u, unit in found:
        largest = LARGEST.get(patterns[0])
        if size is not None and largest is not None:
            assert abs(size) - 3 * u <= largest / UNITS_G[unit], (patterns, size)
        if size is not None and unit in ("rad", "urad"):
            assert abs(size) * {"rad": 1.0, "urad": 1e-6}[unit] <= 0.1, (patterns, size)
        if size is not None and unit != "rad":  # those of the whole run are told as the result has them
            assert abs(size) > 2 * u, (patterns, size, u)


@pytest.mark.parametrize("rad", [0.05, 0.1])
@pytest.mark.parametrize("place", range(6))
def test_a_crumb_under_a_face_is_no_third_order(place, rad):
    """It was k3 of -1.1 g/g^3."""
    found = explanations("hand_laid", crumb(place, rad), stand=None, noise_g=1e-4)
    require_plausible(found)
    assert "position" in found[0][0]
    assert not {"k2", "k3", "asymmetry"} & {name for patterns, *_ in found for name in patterns}


@pytest.mark.parametrize("name", ["paper", "diagonal"])
@pytest.mark.parametrize("rad", [0.005, 0.05, 0.3])
def test_a_crumb_on_a_stand_is_an_error_of_its_position(name, rad):
    found = explanations(name, crumb(2, rad))
    require_plausible(found)
    assert found[0][0][0] == "position" and found[0][1].startswith("1.3")


@pytest.mark.parametrize(
    ("name", "one", "other"),
    [("paper", 3, 4), ("paper", 2, 6), ("paper", 5, 12), ("diagonal", 3, 4), ("diagonal", 2, 6)],
)
def test_both_of_two_exchanged_positions_are_named_first(name, one, other):
    """They were a set angle of no size, an asymmetry of 0.16 g/g and more."""
    found = explanations(name, exchanged(one, other))
    require_plausible(found)
    labels = [place.label for place in built_in(name).positions]
    first = [(patterns, column.split()[0]) for patterns, column, *_ in found[:2]]
    assert sorted(first) == sorted((["position"], labels[place]) for place in (one, other))


@pytest.mark.parametrize(("per_g2", "is_named"), [(1e-3, True), (0.04, True), (0.2, False)])
def test_a_second_order_is_one_up_to_what_blocks_have(per_g2, is_named):
    found = explanations("paper", lambda force: force + per_g2 * force**2 * [0, 1, 0])
    require_plausible(found)
    patterns, column, *_ = found[0]
    assert ((patterns[0], column) == ("k2", "y")) == is_named


def test_the_table_is_that_of_the_page():
    micro = {name: one.largest * 1e-6 for name, one in BY_NAME.items() if name in LARGEST}
    assert micro == pytest.approx(LARGEST)
    angles = {one.largest * {"rad": 1.0, "urad": 1e-6}[one.unit] for one in BY_NAME.values() if "rad" in one.unit}
    assert list(angles) == [pytest.approx(0.1)] * len(angles)
    assert BY_NAME["position"].largest == np.inf
