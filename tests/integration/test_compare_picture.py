"""The picture of a comparison: what stands where, and how it is drawn."""

import json

import numpy as np
import pytest
from blocks import NOMINAL_K
from calibrations import U, result

import tumble as package
from tumble import pictures

matplotlib = pytest.importorskip("matplotlib")
pytestmark = pytest.mark.python
U0 = np.array([0.01, -0.02, 0.03])
JOINT = np.diag(U**2)


def test_the_picture_shows_every_difference_where_it_is():
    a = package.Result(json.dumps(result(NOMINAL_K, U0, JOINT)))
    b = package.Result(json.dumps(result(NOMINAL_K, U0 + np.array([1.0, 2e-5, 0.0]), JOINT)))
    document = package.compare(a, b).checked
    axes = pictures.comparison(document).axes[0]
    shown = {line.get_gid(): line for line in axes.lines if line.get_gid() in {"U0_x", "U0_y", "bias_x", "K_xx"}}
    reach = axes.get_xlim()[1]
    assert shown["U0_y"].get_xdata()[0] == pytest.approx(2e-5 / (1e-5 * np.sqrt(2)))
    assert shown["U0_x"].get_xdata()[0] == reach and shown["U0_x"].get_marker() == ">"
    assert shown["bias_x"].get_color() != shown["U0_x"].get_color() and shown["K_xx"].get_xdata()[0] == 0.0
    unknown = package.compare(a, package.Result(json.dumps(result(NOMINAL_K, U0)))).checked
    assert not [line for line in pictures.comparison(unknown).axes[0].lines if line.get_gid() == "U0_x"]


def test_the_picture_is_drawn_as_all_are_whatever_the_user_has_set():
    document = package.compare(*(package.Result(json.dumps(result(NOMINAL_K, U0, JOINT))),) * 2).checked
    figure = pictures.comparison(document)
    expected = pictures.svg(figure)
    with matplotlib.rc_context({"font.size": 30.0, "axes.facecolor": "black", "lines.markersize": 20.0}):
        before = dict(matplotlib.rcParams)
        assert pictures.svg(pictures.comparison(document)) == expected
        assert dict(matplotlib.rcParams) == before
    assert figure.get_size_inches()[0] * 25.4 == pytest.approx(170.0)
    texts = [text for text in figure.findobj(matplotlib.text.Text) if text.get_text() and text.get_visible()]
    assert len(texts) > 24 and min(text.get_fontsize() for text in texts) >= 8.0


def test_the_picture_says_why_nobody_can_tell():
    sure = package.Result(json.dumps(result(NOMINAL_K, U0, JOINT)))
    others = {
        "Unchanged (99.9 %)": result(NOMINAL_K, U0, JOINT),
        "Nobody can tell: no uncertainties": result(NOMINAL_K, U0),
        "Nobody can tell: a result failed its check": {**result(NOMINAL_K, U0, JOINT), "pass": False},
    }
    for title, other in others.items():
        drawn = pictures.comparison(package.compare(sure, package.Result(json.dumps(other))).checked)
        assert drawn.axes[0].get_title(loc="left") == title
