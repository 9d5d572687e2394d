"""What a history says of a block in a report, and of all blocks on the page of `tumble watch`."""

import http.client
import re
from xml.etree import ElementTree

import pytest
from fleets import fleet, rows_of

import tumble as door
from tumble.errors import BadInput
from tumble.history import History
from tumble.report import history as pages

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
pytestmark = pytest.mark.python
JUMPED = "B000003"


@pytest.fixture(scope="module")
def db(tmp_path_factory):
    """Of twenty blocks, of which one has jumped."""
    found = fleet(20, 8, 81)
    found.series.values[3, 4:, 6] += 1e-3
    where = tmp_path_factory.mktemp("history") / "history.db"
    with History(where) as history:
        history.add_rows(rows_of(found.series))
    return where


@pytest.fixture(scope="module")
def result():
    """Of a block that the history knows."""
    return of_block(JUMPED)


def of_block(serial):
    found = door.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml").document
    return door.load({**found, "serial": serial})


def texts(page):
    """The cells of the tables of a page of HTML."""
    cells = re.findall(r"<t[hd].*?</t[hd]>", page, re.DOTALL)
    return [" ".join(re.sub(r"<[^>]*>", "", one).split()) for one in cells]


def test_a_report_says_what_the_history_does(result, db):
    page = result.reported("html", history=db).decode()
    told = page[page.index('<section class="history">') :].partition("</section>")[0]
    with History(db) as history:
        trend, due = history.trend(JUMPED), history.due(result.document["verification"]["limit_g"], JUMPED)
    (block,), (alarm,) = due.blocks, trend.alarms
    shown = texts(told)
    assert f"due {block.due[:10]}: {pages.WHY['growth']}" in shown
    assert shown[shown.index("Calibrations that count") + 1].startswith("8, 2014-05-13 to ")
    at = shown.index(alarm.measured[:10])
    assert shown[at : at + 3] == [alarm.measured[:10], "bias_x", "jump"]
    assert float(shown[at + 3].removesuffix(" \u00b5g")) == pytest.approx(alarm.size, rel=5e-3)
    assert re.findall(r'<figure id="(\w+)"', told) == ["trend", "control_chart"]
    for svg in re.findall(r"<svg.*?</svg>", told, re.DOTALL):
        ElementTree.fromstring(svg)
    assert "History of block" not in result.reported("html").decode()


def test_a_report_needs_a_block_that_the_history_knows(db):
    with pytest.raises(BadInput, match=r"history\.db: no calibration of block 'Z9'"):
        of_block("Z9").reported("html", history=db)
    with pytest.raises(BadInput, match="names no block: write serial under"):
        of_block(None).reported("html", history=db)


def test_the_command_writes_the_section(result, db, tumble, refused, tmp_path):
    result.save(tmp_path / "r.json")
    done = tumble("report", "r.json", "--history", db, "--out", "r.html", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"History of block {JUMPED}" in (tmp_path / "r.html").read_text()
    line = refused("report", "r.json", "--history", "none.db", "--out", "s.html", cwd=tmp_path)
    assert line == "tumble: none.db: no such history; tumble history add makes it\n"
    assert not (tmp_path / "s.html").exists()


def test_the_page_lists_blocks_by_their_day(db):
    with History(db) as history:
        trend, due = history.trend(), history.due(3e-4)
    days = sorted(one.due[:10] for one in due.blocks)
    page = pages.page(trend, due, days[2])
    shown = texts(page)[6:]
    assert [one.partition(",")[0] for one in shown[1::6]] == days
    assert [one.endswith(", overdue") for one in shown[1::6]] == [True, True] + [False] * 18
    assert set(shown[5::6]) == {"none"}
    assert re.findall(r"history\?serial=(\w+)&amp;limit=0.0003", page) == [one.serial for one in due.blocks]


def test_watch_serves_the_page(db):
    """Of all blocks, of one, and why not."""
    pytest.importorskip("starlette")
    from tumble.cli.commands.watch import _history
    from tumble.watch.server import Server
    from tumble.watch.snapshot import View

    with Server(lambda: View("bench", 1, 1e9), "127.0.0.1", 0, history=_history(str(db))) as server:
        port = int(server.url.rpartition(":")[2].strip("/"))

        def asked(path):
            connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
            connection.request("GET", path)
            answer = connection.getresponse()
            return answer.status, answer.getheader("Content-Security-Policy"), answer.read().decode()

        assert '<a href="history">Calibrations of the blocks</a>' in asked("/")[2]
        status, policy, page = asked("/history")
        assert status == 200 and "script-src" not in policy and "default-src 'none'" in policy
        assert JUMPED in page and "<script" not in page
        status, _, page = asked(f"/history?serial={JUMPED}&limit=1e-3")
        assert status == 200 and "3 u(|a|) within 0.001 g" in page and page.count("<figure") == 2
        assert asked("/history?serial=%3Cscript%3E")[::2] == (400, f"{db}: no calibration of block '<script>'\n")
        assert asked("/history?limit=7")[::2] == (400, "limit: '7' is not a number of g\n")
    with Server(lambda: View("bench", 1, 1e9), "127.0.0.1", 0) as server:
        port = int(server.url.rpartition(":")[2].strip("/"))
        assert asked("/history")[0] == 404 and "Calibrations of the blocks" not in asked("/")[2]


def test_watch_refuses_a_history_that_is_none(refused, tmp_path):
    line = refused("watch", "bench", "--history", "none.db", cwd=tmp_path)
    assert line == "tumble: none.db: no such history; tumble history add makes it\n"
