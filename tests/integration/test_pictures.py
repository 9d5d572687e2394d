"""What pictures of a result draw: read back from them, it is what the result says, and by other means than theirs."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from conftest import EXAMPLES
from pictured import CASES, PAPER, U0, K, dots, force_of, labelled, rows_of, shares_of, solved

import tumble
from tumble import model, pictures
from tumble.errors import UsageError

pytestmark = [pytest.mark.python, pytest.mark.toolchain]

ALL = ["gravity_check", "residuals", "samples", "budget", "stand_seen", "correlation", "attitude"]
KINDS = [*ALL[:5], "inclinations", *ALL[5:]]  # the sixth is of a block that was inclined


# Which pictures there are.


def test_all_pictures_in_their_order():
    assert list(solved("paper")[3]) == ALL
    assert KINDS == list(pictures.kinds()) == list(pictures.CAPTIONS)


@pytest.mark.parametrize(("lacks", "told"), [
    ({"samples"}, {"stand": EXAMPLES / "paper_stand.toml"}),
    ({"samples", "budget"}, {}),
    ({"budget"}, {"run": tumble.read(EXAMPLES / "paper_stand.csv")}),
])
def test_an_older_document_has_those_that_it_has_what_it_takes_for(lacks, told):
    assert list(pictures.figures(older("paper"), **told)) == [one for one in ALL if one not in lacks]


def older(name):
    """A result that repeats neither its stand nor its schedule."""
    return msgspec.structs.replace(solved(name)[1].checked, stand=None, schedule=None)


def test_a_document_alone_has_all_but_the_samples():
    assert list(pictures.figures(solved("paper")[1].checked)) == [one for one in ALL if one != "samples"]


def test_what_its_stand_does_not_explain_is_left_out():
    """A computer with a record of gains states other uncertainties than its stand leaves a run that is solved alone."""
    told = solved("paper")[1].checked
    others = msgspec.structs.replace(told, covariance=2.0 * told.covariance)
    assert list(pictures.figures(others)) == [one for one in ALL if one not in ("samples", "budget")]


def test_a_result_without_a_stand():
    run = tumble.read(EXAMPLES / "six_faces.csv")
    result = tumble.solve(run, schedule=EXAMPLES / "six_faces.toml", estimator="least_squares")
    drawn = result.plot(run=run)
    assert list(drawn) == ["gravity_check", "residuals", "samples", "stand_seen"]
    assert not drawn["gravity_check"].axes[0].findobj(lambda one: "stand" in str(one.get_label()))
    noise, samples = (result.document[key] for key in ("noise", "means"))
    for channel, axes in enumerate(drawn["residuals"].axes):
        band = labelled(axes, "±2 u, noise of the samples alone").get_data()
        expected = [2e6 * noise["of_means"][channel] / np.sqrt(one["samples"]) for one in samples]
        assert band.values == pytest.approx(expected, rel=1e-12)


def test_means_alone_have_no_band_without_a_stand():
    drawn = tumble.solve(rows_of(force_of(PAPER) @ K.T + U0 + 1e-5)).plot()
    assert list(drawn) == ["gravity_check", "residuals", "stand_seen"]
    for figure in drawn.values():
        assert not figure.findobj(lambda one: "±2 u" in str(one.get_label()))
    assert [bar.get_label() for axes in drawn["stand_seen"].axes for bar in axes.containers] == ["seen"] * 3


@pytest.mark.parametrize(("kind", "needs"), [
    ("samples", "kind: samples needs the run (run=)"),
    ("budget", "kind: budget needs the stand and the schedule (stand=, schedule=)"),
    ("pie", "kind: 'pie' is not one of gravity_check, residuals, samples, budget, stand_seen, inclinations,"
     " correlation, attitude"),
])
def test_a_picture_that_cannot_be_drawn_says_what_it_needs(kind, needs):
    with pytest.raises(UsageError) as told:
        pictures.figures(older("paper"), kind=kind)
    assert str(told.value) == needs


def test_a_stand_of_which_the_result_knows_nothing():
    result = tumble.solve(EXAMPLES / "paper_stand.csv")
    with pytest.raises(UsageError, match=r"^stand: the result was solved without one$"):
        result.plot(stand=EXAMPLES / "paper_stand.toml")


# They are held against the result.


def test_another_stand_is_refused():
    said = r"^stand: not that of the result: of u\(K_xx\) the result has 2\.\d+e-05, this one leaves \d\.\d+e-05$"
    with pytest.raises(UsageError, match=said):
        solved("paper")[1].plot(stand=EXAMPLES / "lab_stand.toml")


def test_a_stand_that_is_only_a_little_different_is_refused():
    other = replace(tumble.read_stand(EXAMPLES / "paper_stand.toml").stand, level=2.001e-5)
    with pytest.raises(UsageError, match="not that of the result"):
        solved("paper")[1].plot(stand=other)


def test_another_schedule_is_refused():
    turned = replace(PAPER, positions=tuple(replace(one, angle_deg=one.angle_deg + 0.01) for one in PAPER.positions))
    for other, why in ((turned, "whose residuals are other ones on it"),
                       ("diagonal", "whose positions it lacks, or uses otherwise")):
        with pytest.raises(UsageError, match=f"^schedule: not that of the result, {why}$"):
            solved("paper")[1].plot(schedule=other)


def test_another_run_is_refused():
    with pytest.raises(UsageError, match=r"^run: not that of the result, which has another mean at position 1\.1$"):
        solved("paper")[1].plot(run=EXAMPLES / "lab_stand.csv")


@pytest.mark.parametrize("name", ["paper", "three_mountings", "diagonal"])
def test_a_built_in_schedule_is_found_by_the_residuals(name):
    drawn = solved(name)[3]
    found = pictures.figures(older(name), kind="residuals")["residuals"]
    for one, other in zip(found.axes, drawn["residuals"].axes):
        assert np.array_equal(dots(one), dots(other))


def test_a_schedule_of_the_users_is_not_guessed():
    with pytest.raises(UsageError, match=r"^kind: residuals needs the schedule"):
        pictures.figures(older("checks"), kind="residuals")
    assert list(pictures.figures(solved("checks")[1].checked, kind="residuals")) == ["residuals"]


# What is drawn.


@pytest.mark.parametrize("name", CASES)
def test_gravity_check(name):
    result, axes = solved(name)[1], solved(name)[3]["gravity_check"].axes[0]
    check = result.document["verification"]
    assert dots(axes) == pytest.approx([1e6 * one["delta_g_g"] for one in check["delta_g_g"]], rel=1e-15)
    assert [text.get_text() for text in axes.get_xticklabels()] == [
        f"{one['mounting']}.{one['position']}" for one in check["delta_g_g"]]
    limits = sorted(line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--")
    assert limits == pytest.approx([-1e6 * check["limit_g"], 1e6 * check["limit_g"]])
    assert labelled(axes, "limit").get_label() == "limit ±300 µg"
    assert axes.get_title(loc="left") == "Gravity check passed"
    checked = [place for place, one in enumerate(check["delta_g_g"]) if one["use"] == "check"]
    drawn = [line for line in axes.lines if line.get_label() == "check"]
    assert [line.get_xdata().tolist() for line in drawn] == ([checked] if checked else [])


def test_a_gravity_check_that_failed_shows_the_positions_beyond_the_limit():
    outputs = force_of(PAPER) @ K.T + U0
    outputs[4] *= 1.001
    axes = tumble.solve(rows_of(outputs)).plot(kind="gravity_check")["gravity_check"].axes[0]
    assert axes.get_title(loc="left") == "Gravity check FAILED"
    assert np.abs(dots(axes)).max() > 300.0 and axes.get_ylim()[1] > np.abs(dots(axes)).max()


@pytest.mark.parametrize("name", ["paper", "lab", "three_mountings"])
def test_residuals(name):
    run, result, _, drawn = solved(name)
    schedule = model.built_in(CASES[name][1].get("schedule", "paper"))
    means = np.array([run.outputs[(run.mounting == one.mounting) & (run.position == one.number)].mean(axis=0)
                      for one in schedule.positions])
    left = means - result.U0 - force_of(schedule) @ result.K.T
    for channel, axes in enumerate(drawn["residuals"].axes):
        scale = {"µV": 1e6, "mV": 1e3}[axes.get_ylabel().rpartition(" ")[2]]
        assert dots(axes) == pytest.approx(scale * left[:, channel], abs=scale * 1e-12)


def test_a_caption_speaks_of_a_declaration_where_there_is_one():
    told = solved("paper")[1].checked
    assert ["declared" in pictures.caption("stand_seen", one) for one in (told, older("paper"))] == [True, False]
    assert all(pictures.caption(name, told) == pictures.CAPTIONS[name] for name in ALL)


def test_stand_seen():
    result, axes = solved("paper")[1], solved("paper")[3]["stand_seen"].axes
    seen = result.document["stand_seen"]
    keys = ["alpha1_rad", "alpha2_plus_alpha3_rad", "alpha3_difference_rad", "alpha4_rad", "noise_v"]
    sigma = [2e-5, np.hypot(2e-5, 4e-4 / np.sqrt(2)), 4e-4 * np.sqrt(2), 4e-5, 3e-4]  # by the stand file
    assert [one.get_title(loc="left").rpartition(" ")[2] for one in axes] == ["µrad"] * 4 + ["µV"]
    for panel, key, declared in zip(axes, keys, sigma):
        pairs = {"seen, ±2 u": seen, "seen by least squares, ±2 u": seen["augmented"]}
        bars = {bar.get_label(): bar for bar in panel.containers}
        assert set(bars) == {label for label, pair in pairs.items() if key in pair}
        for label, bar in bars.items():
            value, u = 1e6 * pairs[label][key], 1e6 * pairs[label][f"u_{key}"]
            assert bar.lines[0].get_xdata() == pytest.approx([value])
            ends = bar.lines[2][0].get_segments()[0][:, 0]
            assert ends == pytest.approx([value - 2 * u, value + 2 * u])
        if key in keys[:3]:
            span = labelled(panel, "declared, ±2 u").get_extents().transformed(panel.transData.inverted())
            assert [span.x0, span.x1] == pytest.approx([-2e6 * declared, 2e6 * declared])
        else:
            assert labelled(panel, "declared u").get_xdata() == pytest.approx([1e6 * declared] * 2)


def test_three_mountings_have_two_changes_of_the_yaw():
    result, figure = solved("three_mountings")[1], solved("three_mountings")[3]["stand_seen"]
    titles = [one.get_title(loc="left") for one in figure.axes]
    assert titles[2:4] == [f"yaw change, mounting 1 less {other} / µrad" for other in (2, 3)]
    other = result.document["stand_seen"]["augmented"]["other_yaw_changes"][0]
    assert figure.axes[3].containers[0].lines[0].get_xdata() == pytest.approx([1e6 * other["alpha3_difference_rad"]])


def test_samples():
    run, _, _, drawn = solved("paper")
    windows = [(50 * index + 0.5, 50 * index + 50.5) for index in range(0, 18, 2)]
    for channel, axes in enumerate(drawn["samples"].axes):
        line = labelled(axes, "_outputs")
        assert np.array_equal(line.get_xdata(), np.arange(1, 901))
        assert np.array_equal(line.get_ydata(), run.outputs[:, channel])
        spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
        assert spans == windows
    names = [(text.get_text(), text.xy[0]) for text in drawn["samples"].axes[0].texts]
    assert names == [(one.label, 50 * index + 25.5) for index, one in enumerate(PAPER.positions)]
    assert [axes.get_ylabel() for axes in drawn["samples"].axes] == ["ux / V", "uy / V", "uz / V"]


def test_no_peak_of_a_long_run_is_lost():
    rows = np.repeat(rows_of(force_of(PAPER) @ K.T + U0), 3000, axis=0)
    rows[:, 2:] += np.random.default_rng(1).normal(size=(len(rows), 3)) * 3e-4
    for row, channel, by in ((31234, 0, 5e-3), (12345, 1, -4e-3), (53999, 2, 5e-3), (0, 2, -4e-3)):
        rows[row, 2 + channel] += by
    result = tumble.solve(rows)
    for channel, axes in enumerate(result.plot(run=rows, kind="samples")["samples"].axes):
        line = labelled(axes, "_outputs")
        assert len(line.get_xdata()) < 2600
        assert np.array_equal(line.get_ydata(), rows[line.get_xdata() - 1, 2 + channel])
        assert {31235, 12346, 54000, 1} <= set(line.get_xdata().tolist())
        for one in (np.min, np.max):
            assert one(line.get_ydata()) == one(rows[:, 2 + channel])


# Units.


@pytest.mark.parametrize(("unit", "per_volt", "shown"), [("mV", 1e3, "µV"), ("m/s^2", 1.0, "m/s^2")])
def test_other_units(unit, per_volt, shown):
    run = tumble.read(EXAMPLES / "paper_stand.csv")
    rows = np.column_stack([run.mounting, run.position, run.outputs * per_volt])
    told = tumble.read(rows, unit=unit)
    drawn = tumble.solve(told, stand=EXAMPLES / "paper_stand.toml").plot(run=told)
    assert drawn["residuals"].axes[0].get_ylabel() == f"x channel / {shown}"
    assert drawn["samples"].axes[0].get_ylabel() == f"ux / {unit}"
    scale = 1e6 if shown == "µV" else 1.0
    volts = dots(solved("paper")[3]["residuals"].axes[0]) / 1e6
    assert dots(drawn["residuals"].axes[0]) == pytest.approx(scale * volts, rel=1e-6)
    assert shares_of(drawn["budget"])["noise"] == pytest.approx(shares_of(solved("paper")[3]["budget"])["noise"])


def test_names_above_the_samples_keep_off_the_edge():
    """By a millimetre and more."""
    figure = solved("paper")[3]["samples"]
    top = max(one.get_window_extent().y1 for one in figure.axes[0].texts)
    assert top / figure.dpi <= figure.get_size_inches()[1] - 1.0 / 25.4
