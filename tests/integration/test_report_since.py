"""`tumble report --since`: what has changed since an earlier result, as `tumble compare` finds it."""

import html
import json
import re

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from conftest import EXAMPLES
from msgspec import structs
from report_reader import ascii_signs

import tumble as package
from tumble import model
from tumble.cli.main import main
from tumble.comparison import report
from tumble.report import make
from tumble.report.make import section as section_since
from tumble.report.pages import number_of

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
pytestmark = pytest.mark.python

HEADING = "Compared with an earlier result"
SCALED = NOMINAL_K * (1 + 4e-4 * np.eye(3)[1])[:, None]


@pytest.fixture
def results(tmp_path, monkeypatch):
    """old.json and new.json of a block whose scale factor y has changed, solved with the paper's stand."""
    monkeypatch.setattr(make, "pictures", lambda source, run: [])  # of the result alone: they have tests of their own
    monkeypatch.chdir(tmp_path)
    schedule = model.built_in("paper")
    for name, k in (("old", NOMINAL_K), ("new", SCALED)):
        run = write_run(tmp_path / f"{name}.csv", schedule, model.Geometry(schedule).outputs(k, np.zeros(3)))
        package.solve(run, stand=EXAMPLES / "paper_stand.toml").save(tmp_path / f"{name}.json")
    return tmp_path / "old.json", tmp_path / "new.json"


def compared(*results):
    """As it is given to a report."""
    return package.compare(*results).checked


def texts(page, tag):
    """What stands in the elements of this tag."""
    found = re.findall(rf"<{tag}[^>]*>(.*?)</{tag}>", page, re.DOTALL)
    return [html.unescape(re.sub(r"<[^>]+>", "", one)).strip() for one in found]


def test_the_report_says_what_compare_finds(results, capsysbinary):
    old, new = results
    assert main(["report", "new.json", "--since", "old.json", "--out", "r.html"]) == 0
    page = (new.parent / "r.html").read_text(encoding="utf-8")
    told = compared(old, new)
    assert told.verdict == "block" and told.changed == ("scale_y",)
    section = page[page.index('<section class="since">') :].split("</section>")[0]
    assert texts(section, "h2") == [HEADING]
    assert [*map(ascii_signs, texts(section, "strong"))] == [report.sentence(told)]
    numbers = [number_of(json.loads(path.read_text())) for path in results]
    assert [one.split(",")[0] for one in texts(section, "td")[:2]] == numbers and numbers[0] != numbers[1]
    rows = [texts(row, "t[hd]") for row in section.split("<tr>")[3:]]
    shown = map(report.cells, (*told.parameters, *told.seat, *told.coefficients))
    assert [tuple(map(ascii_signs, row)) for row in rows] == [report.COLUMNS, *shown]
    assert [*map(ascii_signs, texts(section, "li"))] == [*report.grounds(told), *told.warnings]
    assert "µrad" in section and not re.search(r"\bu(g|rad|V)\b", html.unescape(re.sub(r"<[^>]+>", " ", section)))
    assert section.count("<svg") == 1 and "The block has changed" in section


def test_an_option_of_compare_is_called_so(results):
    """The report has no --stand."""
    old, new = (json.loads(path.read_text()) for path in results)
    told = structs.replace(compared(*results), notes=("u is too large then (--stand FILE).",))
    assert "u is too large then (tumble compare --stand FILE)." in map(str, section_since(told, old, new)["grounds"])


def test_undated_results_are_told_of(results):
    """Neither their numbers nor their dates tell which is the earlier one."""
    for path in results:
        path.write_text(json.dumps({**json.loads(path.read_text()), "created": None}))
    old, new = (json.loads(path.read_text()) for path in results)
    told = compared(*results)
    assert any("Not both results are dated" in str(one) for one in section_since(told, old, new)["grounds"])


def test_python_writes_the_same_and_without_an_earlier_result_there_is_no_section(results, capsysbinary):
    old, new = results
    for since, name in ((old, "path.html"), (package.load(old), "object.html"), (None, "none.html")):
        package.load(new).report(name, since=since)
    by_path, by_object, without = ((new.parent / f"{name}.html").read_bytes() for name in ("path", "object", "none"))
    assert main(["report", "new.json", "--since", "old.json"]) == 0
    assert by_path == by_object == capsysbinary.readouterr().out
    assert HEADING.encode() in by_path and HEADING.encode() not in without


def test_an_earlier_result_that_cannot_be_compared_is_refused(results, capsys):
    old, _ = results
    (old.parent / "old.html").write_bytes(old.read_bytes())
    assert main(["report", "new.json", "--since", "old.html", "--out", "old.html"]) == 2
    old.write_text(json.dumps({**json.loads(old.read_text()), "unit": "mV"}))
    assert main(["report", "new.json", "--since", "old.json"]) == 2
    assert main(["report", "new.json", "--since", "none.json"]) == 2
    assert capsys.readouterr() == ("", "".join((
        "tumble: --out: 'old.html' is an input of this command\n",
        "tumble: this result: outputs in V, those of the earlier result in mV: not compared\n",
        "tumble: none.json: no such file or folder\n",
    )))  # fmt: skip
