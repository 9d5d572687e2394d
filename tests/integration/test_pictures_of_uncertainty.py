"""Pictures of uncertainties: bands, budget, correlation and the map of attitudes, by simulated runs, differences and
numpy's own; and what is left of all pictures without colours."""

import numpy as np
import pytest
from conftest import EXAMPLES
from matplotlib import colors
from pictured import CASES, EVERY_ERROR, PAPER, U0, K, force_of, labelled, rows_of, shares_of, solved

import tumble
from tumble import core, model, pictures
from tumble.core import estimate_runs
from tumble.estimators import COEFFICIENTS

pytestmark = [pytest.mark.python, pytest.mark.toolchain]

POINTS = len(PAPER.positions)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_the_bands_are_what_simulated_runs_leave(estimator, runs=6000):
    """Errors of every kind, on the exact geometry, solved by the core: the standard deviation of residuals and of
    delta_g is half the band, as far as so many runs tell it (4.5 sigma; for delta_g 2 % more: its second order)."""
    rng, geometry, stand = np.random.default_rng(11), model.Geometry(PAPER), EVERY_ERROR
    result = tumble.solve(rows_of(geometry.outputs(K, U0)), stand=stand, estimator=estimator)
    drawn = {kind: result.plot(kind=kind)[kind] for kind in ("residuals", "gravity_check")}

    def draws(count, sigma):
        return rng.normal(size=(runs, count)) * sigma

    angle = np.deg2rad([one.angle_deg for one in PAPER.positions])
    waves = np.array([np.sin(angle), np.cos(angle), np.sin(2 * angle), np.cos(2 * angle)])
    outputs = geometry.outputs(
        K, U0, alpha1=draws(1, stand.axis_tilt), alpha2=draws(1, stand.level), alpha3=draws(2, stand.remount),
        delta=draws(POINTS, stand.angle) + draws(4, stand.encoder) @ waves,
        seat_h=draws(2, stand.seat) + draws(1, stand.platform), seat_n=draws(2, stand.seat))
    outputs += rng.normal(size=outputs.shape) * stand.noise / np.sqrt(stand.samples)
    outputs += np.linspace(-0.5, 0.5, POINTS)[:, None] * draws(3, stand.drift)[:, None]
    found = estimate_runs(core.CoreSchedule(PAPER), outputs, estimator)
    k, above = found[:, :9].reshape(-1, 3, 3), outputs - found[:, None, 9:]
    left = above - force_of(PAPER) @ np.swapaxes(k, 1, 2)
    gravity = ((above @ np.swapaxes(np.linalg.inv(k), 1, 2)) ** 2).sum(axis=2) / 2.0 - 0.5
    chance = 4.5 / np.sqrt(2 * runs)
    for channel, axes in enumerate(drawn["residuals"].axes):
        scale = {"µV": 1e6, "mV": 1e3}[axes.get_ylabel().rpartition(" ")[2]]
        band = labelled(axes, "±2 u, declared stand").get_data()
        assert band.values == pytest.approx(2 * scale * np.std(left, axis=0)[:, channel], rel=chance)
        assert np.array_equal(band.baseline, -band.values)
        assert np.array_equal(band.edges, np.arange(POINTS + 1) - 0.5)
    band = labelled(drawn["gravity_check"].axes[0], "±2 u, declared stand").get_data()
    assert band.values == pytest.approx(2e6 * np.std(gravity, axis=0), rel=chance + 0.02)


def by_differences(schedule, k, estimator, **errors):
    """Variance of the coefficients by independent draws (draws, ...) of each of `errors`, their size its standard
    deviation: both signs of it, solved by the core."""
    geometry, found = model.Geometry(schedule), np.zeros(12)
    for name, draws in errors.items():
        for draw in draws:
            ends = [core.estimate(core.CoreSchedule(schedule), geometry.outputs(k, U0, **{name: sign * draw}),
                                  estimator=estimator) for sign in (1.0, -1.0)]
            one, other = (np.concatenate([end[0].ravel(), end[1]]) for end in ends)
            found += ((one - other) / 2.0) ** 2
    return found


@pytest.mark.parametrize(("name", "estimator"), [("paper", "refined"), ("diagonal", "least_squares")])
def test_the_budget_has_the_share_of_every_source(name, estimator):
    result, figure = solved(name)[1], solved(name)[3]["budget"]
    schedule, shares = model.built_in(name), shares_of(figure)
    mountings, points = len(schedule.mountings), len(schedule.positions)
    total = np.diag(result.covariance)
    expected = {
        "axis tilt α₁": {"alpha1": np.array([2e-5])},
        "level α₂": {"alpha2": np.array([2e-5])},
        "yaw α₃": {"alpha3": 4e-4 * np.eye(mountings)},
        "set angles α₄": {"delta": 4e-5 * np.eye(points)},
    }
    for title, errors in expected.items():
        share = by_differences(schedule, result.K, estimator, **errors) / total
        assert shares[title] == pytest.approx(100 * share, rel=1e-4, abs=1e-6)
    assert shares["noise"] == pytest.approx(100 - sum(shares[title] for title in expected), abs=1e-3)


@pytest.mark.parametrize("name", CASES)
def test_the_budget_is_whole_and_in_the_order_of_the_coefficients(name):
    result, axes = solved(name)[1], solved(name)[3]["budget"].axes[0]
    assert sum(shares_of(axes.figure).values()) == pytest.approx(np.full(12, 100.0))
    assert tuple(text.get_text() for text in axes.get_yticklabels()) == COEFFICIENTS
    u = [text.get_text().split() for text in axes.texts if text.get_text() != "u"]
    stated = [*result.u_K.ravel(), *result.u_U0]
    scale = {"mV": 1e3, "µV": 1e6}[u[0][1].removesuffix("/g")]
    assert [float(value) for value, _ in u] == pytest.approx(scale * np.array(stated), rel=5e-3)
    assert [unit for _, unit in u] == [u[0][1]] * 9 + [u[0][1].removesuffix("/g")] * 3
    for bars in zip(*axes.containers):  # one beside the other
        ends = [bar.get_x() + bar.get_width() for bar in bars]
        assert [bar.get_x() for bar in bars] == pytest.approx([0.0, *ends[:-1]])


def test_all_sources_have_a_place_in_the_budget():
    result = tumble.solve(rows_of(force_of(PAPER) @ K.T + U0), stand=EVERY_ERROR)
    shares = shares_of(result.plot(kind="budget")["budget"])
    assert list(shares) == ["axis tilt α₁", "level α₂", "yaw α₃", "set angles α₄", "noise", "seat", "platform",
                            "encoder", "drift"]
    assert all(share.max() > 0.0 for share in shares.values())


def test_the_noise_that_a_run_shows_counts_in_its_budget():
    rng, samples = np.random.default_rng(5), np.array([40, 60] * 9)
    rows = np.repeat(rows_of(force_of(PAPER) @ K.T + U0), samples, axis=0)
    drawn = []
    for size in (3e-4, 3e-3):
        rows[:, 2:] += rng.normal(size=(len(rows), 3)) * size
        result = tumble.solve(rows, stand=EXAMPLES / "paper_stand.toml")
        assert bool(result.document["noise"]["above_declared"]) == (size > 1e-3)
        drawn.append(shares_of(result.plot(kind="budget")["budget"]))
        assert sum(drawn[-1].values()) == pytest.approx(np.full(12, 100.0))
    assert (drawn[1]["noise"] > drawn[0]["noise"]).all() and drawn[1]["noise"].min() > 80.0


@pytest.mark.parametrize("name", ["paper", "lab", "diagonal"])
def test_correlation(name):
    result, axes = solved(name)[1], solved(name)[3]["correlation"].axes[0]
    root = np.linalg.cholesky(result.covariance)
    expected = np.corrcoef(np.hstack([root, -root]))
    assert np.asarray(axes.collections[0].get_array()).reshape(12, 12) == pytest.approx(expected, abs=1e-9)
    numbers = np.array([text.get_text().replace("\N{MINUS SIGN}", "-") for text in axes.texts], dtype=float)
    assert numbers.reshape(12, 12) == pytest.approx(expected, abs=5.001e-3)
    places = np.array([text.get_position() for text in axes.texts]).reshape(12, 12, 2)
    assert np.array_equal(places[3, 7], [7.5, 3.5]) and axes.yaxis_inverted()
    for ticks in (axes.get_xticklabels(), axes.get_yticklabels()):
        assert tuple(text.get_text() for text in ticks) == COEFFICIENTS


@pytest.mark.parametrize("name", ["paper", "lab", "three_mountings", "diagonal"])
def test_attitude(name):
    """On the drawn lines u^2 = g^T C g, with g by differences of |K^-1 (U - U0)|; its worst is that of the result."""
    result, axes = solved(name)[1], solved(name)[3]["attitude"].axes[0]
    star = labelled(axes, "worst")
    worst = result.document["u_norm_g"]
    assert float(star.get_label().split()[1]) == pytest.approx(1e6 * worst["worst_g"], rel=5e-3)
    assert star.get_label().startswith("worst: ") and star.get_label().endswith(" µg")
    a = direction(star.get_xdata()[0], star.get_ydata()[0])
    assert a == pytest.approx(np.array(worst["attitude"]), abs=1e-9)
    assert u_of_length(result, a) == pytest.approx(worst["worst_g"], rel=1e-5)
    lines = next(one for one in axes.collections if (one.get_facecolor().size == 0))
    drawn = [(level, path.vertices[::25]) for level, path in zip(np.sqrt(lines.levels), lines.get_paths())
             if len(path.vertices)]
    assert len(drawn) >= 4 and drawn[-1][0] > 0.85e6 * worst["worst_g"]
    for level, vertices in drawn:
        found = [1e6 * u_of_length(result, direction(*vertex)) for vertex in vertices]
        assert np.abs(np.array(found) - level).max() < 1e4 * worst["worst_g"]  # 1 % of the largest
    numbers = [float(text.get_text()) for text in axes.texts if text.get_text()[-1] not in "xyz"]
    assert len(numbers) > 3 and set(numbers) <= {float(f"{level:.9g}") for level, _ in drawn}


def direction(azimuth_deg, elevation_deg):
    azimuth, elevation = np.deg2rad([azimuth_deg, elevation_deg])
    return np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def u_of_length(result, a, step=1e-6):
    outputs, gradient = result.U0 + result.K @ a, np.zeros(12)
    for index in range(12):
        ends = []
        for sign in (1.0, -1.0):
            changed = np.concatenate([result.K.ravel(), result.U0])
            changed[index] += sign * step
            ends.append(np.linalg.norm(np.linalg.solve(changed[:9].reshape(3, 3), outputs - changed[9:])))
        gradient[index] = (ends[0] - ends[1]) / (2 * step)
    return float(np.sqrt(gradient @ result.covariance @ gradient))


@pytest.mark.filterwarnings("error")
def test_a_stand_without_errors():
    """Nothing to share, to correlate or to draw a line of."""
    perfect = tumble.Stand(0.0, 0.0, 0.0, 0.0, 0.0, 1, "sigma1")
    drawn = tumble.solve(rows_of(force_of(PAPER) @ K.T + U0), stand=perfect).plot()
    assert list(drawn) == ["gravity_check", "residuals", "stand_seen", "correlation", "attitude"]
    assert {text.get_text() for text in drawn["correlation"].axes[0].texts} == {"?"}
    assert not drawn["attitude"].axes[0].collections
    assert [pictures.svg(figure)[:4] for figure in drawn.values()] == ["<svg"] * 5


# Without colours.


def luminance(colour):
    """Relative, of WCAG 2.2."""
    rgb = np.array(colors.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one, other):
    """Of WCAG 2.2: 4.5 for text, 3 for what is not."""
    low, high = sorted([luminance(one), luminance(other)])
    return (high + 0.05) / (low + 0.05)


def test_bars_differ_by_their_hatches():
    """Of those without a hatch, by their greys."""
    result = tumble.solve(rows_of(force_of(PAPER) @ K.T + U0), stand=EVERY_ERROR)
    axes = result.plot(kind="budget")["budget"].axes[0]
    looks = [(bars[0].get_hatch(), bars[0].get_facecolor()) for bars in axes.containers]
    assert len({hatch for hatch, _ in looks if hatch}) == sum(bool(hatch) for hatch, _ in looks) == 7
    plain = [colour for hatch, colour in looks if not hatch]
    assert len(plain) == 2 and contrast(*plain) > 1.5


def test_dots_differ_by_their_markers():
    lines = {line.get_label(): line for line in solved("checks")[3]["gravity_check"].axes[0].lines}
    looks = [lines[name] for name in ("fit", "check")]
    assert [line.get_marker() for line in looks] == ["o", "D"]
    assert [contrast(line.get_markeredgecolor(), "white") > 3.0 for line in looks] == [True, True]
    marks = [bar.lines[0].get_marker() for bar in solved("paper")[3]["stand_seen"].axes[0].containers]
    assert marks == ["o", "s"]


@pytest.mark.parametrize("name", ["paper", "lab"])
def test_numbers_of_the_correlation_stand_out(name):
    figure = solved(name)[3]["correlation"]
    mesh = figure.axes[0].collections[0]
    cells = mesh.to_rgba(mesh.get_array().ravel())
    assert min(contrast(text.get_color(), cell) for text, cell in zip(figure.axes[0].texts, cells)) >= 4.5


def test_numbers_of_the_map_stand_out():
    filled = next(one for one in solved("lab")[3]["attitude"].axes[0].collections if one.get_facecolor().size)
    shades = [luminance(colour) for colour in filled.get_facecolor()]
    assert shades == sorted(shades, reverse=True) and contrast(filled.get_facecolor()[-1], "black") > 7.0
