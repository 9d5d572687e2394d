"""Pictures of `tumble history trend`: what stands where, and when there is none."""

import numpy as np
import pytest
from fleets import fleet, rows_of

from tumble import pictures
from tumble.history import History
from tumble.history.calibrations import PARAMETERS

pytest.importorskip("matplotlib")
pytestmark = pytest.mark.python


@pytest.fixture
def told(tmp_path):
    """Of a block whose bias x has jumped."""
    found = fleet(20, 8, 81)
    found.series.values[3, 4:, 6] += 1e-3
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows_of(found.series))
        return history.trend("B000003")


def test_every_parameter_has_its_points_and_alarms(told):
    axes = pictures.trend(told).axes
    assert [one.get_title(loc="left").partition(",")[0] for one in axes] == list(PARAMETERS)
    bias = axes[6]
    points, marked = bias.containers[0].lines[0], bias.lines[-1]
    assert points.get_ydata() == pytest.approx([one.value for one in told.points if one.parameter == "bias_x"])
    assert list(marked.get_ydata()) == [points.get_ydata()[4]] and marked.get_marker() == "D"
    assert all(len(one.lines[-1].get_ydata()) == 0 for place, one in enumerate(axes) if place != 6)


def test_the_control_charts_have_limits_and_names(told):
    (axes,) = pictures.control_chart(told).axes
    shown = {line.get_gid(): line.get_ydata() for line in axes.lines if line.get_gid()}
    z = [one.z for one in told.points if one.parameter == "bias_x"]
    assert shown["bias_x"][1:] == pytest.approx(z[1:]) and np.isnan(shown["bias_x"][0])
    assert [text.get_text() for text in axes.texts] == ["bias_x"]
    limits = [line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"]
    assert limits == pytest.approx([-told.control_limit, told.control_limit])


def test_the_command_draws_both(told, tumble, tmp_path):
    files = "--plot", "t.svg", "--chart", "c.png"
    done = tumble("history", "trend", "--serial", "B000003", *files, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "t.svg").read_bytes() == pictures.written(pictures.trend(told), "t.svg")
    assert (tmp_path / "c.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("arguments, line", [
    (("--plot", "t.svg"), "--plot, --chart: a picture is of one block: give --serial NAME"),
    (("--serial", "B000003", "--chart", "c.txt"), "--chart: 'c.txt' does not end in .png, .svg or .pdf"),
])  # fmt: skip
def test_what_cannot_be_drawn_is_refused(told, refused, tmp_path, arguments, line):
    assert refused("history", "trend", *arguments, cwd=tmp_path) == f"tumble: {line}\n"
