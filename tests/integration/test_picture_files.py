"""Pictures as files and in pages; what they need, and what they leave alone; a result in a notebook."""

import html.parser
import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from itertools import pairwise, product

import matplotlib
import numpy as np
import pytest
from conftest import EXAMPLES
from PIL import Image

import tumble
from tumble import pictures
from tumble.errors import BadInput, NotInstalled, Skipped, UsageError

pytestmark = [pytest.mark.python, pytest.mark.toolchain]

RUN, STAND = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"
SVG = "{http://www.w3.org/2000/svg}"
LIGHT = """
import sys, tumble
result = tumble.solve(sys.argv[1], stand=sys.argv[2])
result._repr_html_()
import tumble.pictures
print(sorted(name for name in sys.modules if name.partition(".")[0] == "matplotlib"))
figures = result.plot()
print("matplotlib" in sys.modules, "matplotlib.pyplot" in sys.modules)
import hashlib
print(hashlib.sha256("".join(map(tumble.pictures.svg, figures.values())).encode()).hexdigest())
"""


@pytest.fixture(scope="module")
def result():
    return tumble.solve(RUN, stand=STAND)


@pytest.fixture(scope="module")
def drawn(result):
    return result.plot(run=RUN)


@pytest.fixture(scope="module")
def texts(drawn):
    return {name: pictures.svg(figure) for name, figure in drawn.items()}


# In a page.


def test_each_is_an_element_with_a_title(texts):
    for text in texts.values():
        assert text.startswith("<svg ") and text.rstrip().endswith("</svg>") and "<!DOCTYPE" not in text
        root = ET.fromstring(text)
        assert root.tag == f"{SVG}svg" and root.get("role") == "img" and root.get("viewBox").startswith("0 0 48")
        titles = [one.text for one in root.iter(f"{SVG}title")]
        assert len(titles) == 1 and len(titles[0]) > 5
        assert "<metadata" not in text and not re.search(r"\b\d{4}-\d\d-\d\d", text)
        assert len(text) < 250_000  # characters: seven in a page are read at once


def test_names_are_unique_in_a_page_of_all_and_lead_somewhere(texts):
    page = "\n".join(texts.values())
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert len(ids) == len(set(ids)) and all(re.fullmatch(r"\S+", one) for one in ids)
    led = set(re.findall(r'href="#([^"]*)"', page) + re.findall(r"url\(#([^)]*)\)", page))
    assert len(led) > 30 and led <= set(ids)


def test_the_style_of_a_picture_is_not_that_of_the_page(texts):
    for text in texts.values():
        (root,) = re.findall(r'^<svg id="([^"]*)"', text)
        assert re.findall(r"<style[^>]*>([^{]*)\{", text) == [f"#{root} *"]


def test_a_page_of_all_is_read_as_html(texts):
    opened = []

    class Reader(html.parser.HTMLParser):
        def handle_starttag(self, tag, attrs):
            opened.append(tag)

    Reader().feed(f"<!doctype html><title>all</title>{''.join(texts.values())}")
    assert opened.count("svg") == len(texts)


def test_the_same_text_every_time(result, drawn, texts):
    for name, figure in drawn.items():
        assert pictures.svg(figure) == texts[name], name
    for name in ("residuals", "samples", "attitude"):
        assert pictures.svg(result.plot(kind=name, run=RUN)[name]) == texts[name]


@pytest.mark.toolchain
def test_in_another_process_and_what_is_loaded_there(result):
    lines = []
    for seed in ("1", "2"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "SOURCE_DATE_EPOCH": seed}
        command = [sys.executable, "-c", LIGHT, str(RUN), str(STAND)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr
        lines.append(done.stdout.splitlines())
    assert lines[0][:2] == ["[]", "True False"] and lines[0] == lines[1]


def test_what_the_user_has_set_is_neither_used_nor_changed(result, texts):
    before = dict(matplotlib.rcParams)
    with matplotlib.rc_context({"font.size": 30.0, "axes.facecolor": "black", "svg.hashsalt": "x"}):
        set_by_user = dict(matplotlib.rcParams)
        assert pictures.svg(result.plot(kind="budget")["budget"]) == texts["budget"]
        assert dict(matplotlib.rcParams) == set_by_user
    assert dict(matplotlib.rcParams) == before


# On paper.


def test_as_wide_as_a_page_and_not_too_small_to_read(drawn):
    for name, figure in drawn.items():
        figure.draw_without_rendering()
        assert figure.get_size_inches()[0] * 25.4 == pytest.approx(170.0)
        assert figure.get_size_inches()[1] * 25.4 < 200.0
        written = [text for text in figure.findobj(matplotlib.text.Text) if text.get_text() and text.get_visible()]
        assert len(written) > 10 and min(text.get_fontsize() for text in written) >= 8.0, name
        assert not any("$" in text.get_text() for text in written), "an index would be smaller"


@pytest.fixture(scope="module")
def with_checks():
    """Of a run with check positions."""
    return tumble.solve(EXAMPLES / "with_checks.csv", stand=STAND, schedule=EXAMPLES / "with_checks.toml").plot()


def test_nothing_is_written_over_something_else(drawn, with_checks):
    """Labels of ticks, legends and titles."""
    for name, figure in [*drawn.items(), *with_checks.items()]:
        figure.draw_without_rendering()
        page = figure.bbox
        for axes in figure.axes:
            low, high = axes.get_xlim()
            ticks = [text for text in axes.get_xticklabels() if low <= text.get_position()[0] <= high]
            texts = [text for text in (*ticks, *axes.texts, axes.xaxis.label, axes.yaxis.label) if text.get_text()]
            legends = figure.findobj(matplotlib.legend.Legend)
            titles = [text for text in axes.findobj(matplotlib.text.Text)
                      if text.get_text() and text.get_text() == axes.get_title(loc="left")]
            for title, legend in product(titles, legends):
                assert not title.get_window_extent().overlaps(legend.get_window_extent()), name
            for box in [artist.get_window_extent() for artist in (*texts, *legends)]:
                assert box.x0 >= page.x0 - 1 and box.x1 <= page.x1 + 1 and box.y1 <= page.y1 + 1, (name, box)
            boxes = [text.get_window_extent() for text in ticks]
            assert all(one.x1 < other.x0 for one, other in pairwise(boxes)), name


def test_axes_have_units_and_no_offsets(drawn):
    without = {"mounting.position", "number of the sample", "", "correlation"}
    for name, figure in drawn.items():
        for axes in figure.axes:
            labels = {axes.get_xlabel(), axes.get_ylabel(), axes.get_title(loc="left")} - without
            units = [label.rpartition(" / ")[2] for label in labels if " / " in label]
            assert set(units) <= {"µg", "µV", "mV", "V", "%", "µrad", "deg"} and (units or name == "correlation"), name
            for axis in (axes.xaxis, axes.yaxis):
                assert axis.get_offset_text().get_text() == ""


# Files.


@pytest.mark.parametrize(("suffix", "begins"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("PDF", b"%PDF")])
def test_files(result, tmp_path, suffix, begins):
    files = [tmp_path / f"{number}.{suffix}" for number in range(2)]
    for file in files:
        assert list(result.plot(file, "attitude")) == ["attitude"]
    assert files[0].read_bytes().startswith(begins) and files[0].read_bytes() == files[1].read_bytes()


def test_without_a_kind_it_is_the_gravity_check(result, tmp_path):
    assert list(result.plot(tmp_path / "x.png")) == ["gravity_check"]
    with Image.open(tmp_path / "x.png") as image:
        assert image.width == pytest.approx(170 / 25.4 * 150, abs=1)
        assert len(image.convert("L").getcolors()) > 20


def test_another_suffix_is_refused(result, tmp_path):
    with pytest.raises(UsageError, match=r"^file: 'x\.gif' does not end in \.png, \.svg or \.pdf$"):
        result.plot("x.gif")
    with pytest.raises(UsageError, match=r"^kind: samples needs the run \(run=\)$"):
        result.plot(tmp_path / "x.png", "samples")
    with pytest.raises(BadInput, match=r"x\.png: cannot be written: no such file or folder$"):
        result.plot(tmp_path / "none/x.png")
    assert not list(tmp_path.iterdir())


def test_a_result_from_a_file_knows_its_stand(result, texts, tmp_path):
    result.save(tmp_path / "solved.json")
    (budget,) = tumble.load(tmp_path / "solved.json").plot(kind="budget").values()
    assert pictures.svg(budget) == texts["budget"]


def test_an_older_result_is_told_its_stand(result, texts, tmp_path):
    document = {key: value for key, value in result.document.items() if key not in ("stand", "schedule")}
    (tmp_path / "older.json").write_text(json.dumps(document))
    loaded = tumble.load(tmp_path / "older.json")
    with pytest.raises(UsageError, match=r"^kind: budget needs the stand and the schedule"):
        loaded.plot(kind="budget")
    (budget,) = loaded.plot(kind="budget", stand=STAND).values()
    assert pictures.svg(budget) == texts["budget"]


def test_without_matplotlib(result, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    for arguments, needed in (((), "a picture"), ((tmp_path / "x.png",), "file")):
        with pytest.raises(NotInstalled) as told:
            result.plot(*arguments)
        assert str(told.value) == f"{needed} needs matplotlib: tools/setup plot"
        assert isinstance(told.value, Skipped) and isinstance(told.value, ImportError)


# In a notebook.


def cells_of(text):
    root = ET.fromstring(f"<div>{text}</div>")
    return "".join(root.find("p").itertext()), [[cell.text or "" for cell in row] for row in root.find("table")]


def test_a_notebook_shows_the_verdict_and_the_coefficients(result):
    verdict, rows = cells_of(result._repr_html_())
    assert verdict.startswith("PASS, assuming a square seat")
    assert rows[0] == ["", "value", "std uncertainty", "unit"]
    names = [f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"]
    assert [row[0].rstrip("*") for row in rows[1:]] == names
    assert {row[0] for row in rows if row[0].endswith("*")} == {"K_xy*", "K_xz*", "K_yx*", "K_yz*", "K_zx*", "K_zy*"}
    assert [row[3] for row in rows[1:]] == ["V/g"] * 9 + ["V"] * 3
    values, u = [*result.K.ravel(), *result.U0], [*result.u_K.ravel(), *result.u_U0]
    for row, value, sigma in zip(rows[1:], values, u):
        assert abs(float(row[1]) - value) <= 0.05 * sigma and float(row[2]) == pytest.approx(sigma, rel=0.05)


def test_a_notebook_without_a_stand_and_with_a_failure():
    rows = np.loadtxt(RUN, delimiter=",", skiprows=1)
    rows[:50, 4] *= 1.01
    verdict, cells = cells_of(tumble.solve(tumble.read(rows, unit="m/s^2"))._repr_html_())
    assert verdict == "FAIL: the gravity check"
    assert {row[2] for row in cells[1:]} == {"unknown"} and cells[1][3] == "(m/s^2)/g"
