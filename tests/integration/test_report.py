"""Calibration reports: every number is the document's, rounded once; the verdict; texts are texts; one file.

Pictures have tests of their own: here they are two lines, but where a test says otherwise.
"""

import json
import re
import sys
import types

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import paper_stand
from report_reader import Report, Said, Truth, ascii_signs, plain, text_of

import tumble as package
from tumble.api.result import Result
from tumble.documents.base import to_json
from tumble.errors import BadInput, UsageError
from tumble.estimators import COEFFICIENTS
from tumble.files.schedule_file import read_schedule
from tumble.report import make, sections
from tumble.report.pages import number_of
from tumble.report.source import Source

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
pytestmark = pytest.mark.python

LABELS = """
[item]
serial_number = "A-17 <b>"
Condition = "as received & clean"
customer = "Müller GmbH"
"<script>alert(1)</script>" = "<script>alert(2)</script>"
seal = 4711

[environment]
temperature_c = 21.5
gravity_m_s2 = 9.8106
u_gravity_m_s2 = 1e-5
laboratory = "Lab <i>1</i>"
gravity_traceability = "certificate G-12"
rig = "B"
"""
DRAWN = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9"><title>T</title><path d="M0 0L9 9"/></svg>'


@pytest.fixture
def drawn(monkeypatch):
    """Pictures that cost nothing. What they were asked for."""
    asked = []
    room = types.ModuleType("tumble.pictures")

    def figures(solved, run=None):
        asked.append((solved, run))
        return {"gravity_check": 1, **({"samples": 2} if run is not None else {}), "attitude": 3}

    room.mountings = lambda schedule: "M"
    room.figures, room.svg = figures, lambda figure: DRAWN.replace("T<", f"T{figure}<")
    captions = {"gravity_check": "Errors < of gravity.", "samples": "Samples.", "attitude": "Attitudes."}
    room.caption = lambda name, document: captions[name]
    monkeypatch.setitem(sys.modules, "tumble.pictures", room)
    monkeypatch.setattr(package, "pictures", room, raising=False)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    return asked


def solve(name="paper_stand", stand=True, **more):
    return package.solve(EXAMPLES / f"{name}.csv", stand=EXAMPLES / f"{name}.toml" if stand else None, **more)


def labelled(folder):
    return package.solve(EXAMPLES / "paper_stand.csv", stand=paper_stand(folder, LABELS, 'serial = "B-9"\n'))


def misfit(folder):
    """A run that its stand file does not explain."""
    return package.solve(EXAMPLES / "lab_stand.csv", stand=paper_stand(folder), limit_g=1e-3)


def coarse(folder):
    """Uncertainties of hundreds: outputs in counts."""
    run = folder / "counts.csv"
    lines = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    body = [row.split(",") for row in lines[1:]]
    scaled = [",".join([*row[:2], *(str(float(one) * 1e6) for one in row[2:5])]) for row in body]
    run.write_text("\n".join(["mounting,position,ux [LSB],uy [LSB],uz [LSB]", *scaled]) + "\n")
    stand = paper_stand(folder, noise_v=300.0, scale_v_per_g=2e6, K="[[2e6, 0, 0], [0, 2e6, 0], [0, 0, 2e6],")
    stand.write_text(re.sub(r"(?s)\[block\.true\].*?\[accept\]", "[accept]", stand.read_text()))
    return package.solve(run, stand=stand)


RESULTS = {
    "with a stand": lambda folder: solve(),
    "without": lambda folder: solve(stand=False),
    "failing": lambda folder: solve(limit_g=1e-6),
    "misfit": misfit,
    "not shown": lambda folder: solve("lab_stand"),
    "labelled": labelled,
    "three mountings": lambda folder: solve("three_mountings_stand", schedule="three_mountings"),
    "checks": lambda folder: package.solve(EXAMPLES / "with_checks.csv", schedule=EXAMPLES / "with_checks.toml"),
    "more terms": lambda folder: solve(estimator="optimal", model="k2,drift"),
    "counts": coarse,
}  # fmt: skip


_solved = {}  # results do not change: each is solved once


def solved(name, folder):
    if name not in _solved:
        _solved[name] = RESULTS[name](folder)
    return _solved[name]


@pytest.fixture(params=RESULTS)
def result(request, tmp_path, drawn):
    """Results of all kinds."""
    return solved(request.param, tmp_path)


def report_of(result, **options):
    return Report(result.reported("html", **options).decode("utf-8"))


def row_of(report, name):
    """The cells of the one row that this begins."""
    (found,) = [row for row in report.rows if row and text_of(row[0]).rstrip("*^") == name]
    return found


def rounded_as_it_should(said, truth):
    """Half to even, to the unit of the last digit that is printed."""
    if said.text == "\u221e":
        return truth.at(said.path) is None or truth.at(said.path) > 10**6
    (found, unit), exact = said.number, truth.number(said)
    off = abs(found - exact)
    return off < unit / 2 or (off == unit / 2 and found / unit % 2 == 0)


def test_every_number_is_the_document_s(result):
    report, truth = report_of(result), Truth(result.to_json())
    numbers = [said for said in report.said if said.kind == "number"]
    assert len(numbers) > 60
    wrong = [said for said in numbers if not rounded_as_it_should(said, truth)]
    assert not wrong
    for said in report.said:
        if said.kind == "told":
            assert ascii_signs(said.text) == ascii_signs(truth.at(said.path))


def test_no_number_stands_in_a_table_without_its_path(result):
    """But for the names of things, those that begin a row, headings, U0; and the date of issue."""
    for row in report_of(result).rows:
        for part in [part for cell in row[1:] for part in cell]:
            assert isinstance(part, Said) or not re.search(r"\d", part.replace("U0", "").replace("2023-11-14", "")), (
                part
            )


def test_every_coefficient_has_its_uncertainty(result):
    """k u, two digits at most, and the value ends where it does."""
    report, document = report_of(result), result.document
    alone = document["scatter_alone"]
    prefix = "/scatter_alone" if document["u_K"] is None and alone else ""
    for place, name in enumerate(COEFFICIENTS):
        path = f"/K/{place // 3}/{place % 3}" if place < 9 else f"/U0/{place - 9}"
        (row,) = [row for row in report.rows if row and text_of(row[0]).rstrip("*^") == name and len(row) > 4]
        value, u = row[1][0], row[2][0]
        assert value.path == path
        if document["u_K"] is None and alone is None:
            assert text_of(row[2]) == "no uncertainty"
            continue
        table, rest = path[1:].split("/", 1)
        assert (u.path, u.times) == (f"{prefix}/u_{table}/{rest}", (f"/coverage/k_{table}/{rest}",))
        assert 1 <= u.digits <= 2 and u.number[1] == value.number[1]
    names = [name for row in report.rows for name in [text_of(row[0])] if name.rstrip("*^") in COEFFICIENTS]
    for mark, assumption in {"*": "seat", "^": "linear"}.items():
        marked = [name.rstrip("*^") for name in names if mark in name]
        assert marked == list(document["assumed_for"].get(assumption, []))
    is_marked = any(name[-1] in "*^" for name in names)
    assert ("whose name ends in a mark holds only assuming: " in plain(report.text)) == is_marked


def test_intrinsic_parameters_likewise(drawn):
    report, document = report_of(solve()), solve().document
    for name, path in {"Scale y": "scale/1", "Angle xz": "angle_rad/xz", "Bias z": "bias_g/2"}.items():
        row = row_of(report, name)
        assert row[1][0].path == f"/intrinsic/{path}"
        assert (row[2][0].path, row[2][0].times) == (f"/u_intrinsic/{path}", (f"/coverage/k_intrinsic/{path}",))
        assert row[1][0].number[1] == row[2][0].number[1]
    u, k = document["u_intrinsic"]["bias_g"][2], document["coverage"]["k_intrinsic"]["bias_g"][2]
    assert float(report.row("Bias z")[1]) == float(f"{k * u:.1e}")


def test_the_points_of_numbers_are_beneath_each_other(drawn):
    """With blanks as wide as a digit: so many characters stand behind every point of a column."""
    source = solve().reported("html").decode()
    (table,) = [one for one in source.split("</table>") if "K_xx" in one and "U = k u" in one]
    for column in ("/K/", "/U0/"), ("/u_K/", "/u_U0/"):
        begins = tuple(f'<span class="number" data-path="{one}' for one in column)
        cells = [cell for cell in re.findall(r"<td>(.*?)</td>", table) if cell.startswith(begins)]
        behind = {len(re.sub(r"<[^>]*>", "", cell).partition(".")[2]) for cell in cells}
        assert len(cells) == 12 and len(behind) == 1


def test_freedom_beyond_a_million_is_infinite(drawn):
    document = solve().document
    document["coverage"]["freedom_U0"] = [392471701697.0, 1e6, None]
    rows = [row_of(report_of(Result(json.dumps(document))), f"U0_{one}") for one in "xyz"]
    assert [text_of(row[-1]) for row in rows] == ["\u221e", "1000000", "\u221e"]


def test_without_a_stand_it_says_so(drawn):
    assert report_of(solve(stand=False)).row("Angle xy")[1:] == ["no uncertainty", "rad"]
    assert "over all attitudes: no uncertainty." in plain(report_of(solve(stand=False)).text)
    text = plain(report_of(solve(stand=False)).text)
    assert "noise by itself moves a value by at most U with a probability of 0.95" in text
    assert "U contains the noise of the samples only: no stand is declared, so that its errors are NOT in U" in text
    assert "For faces laid by hand the real uncertainty can be over 100 times larger" in text
    assert "coverage probability" not in text
    assert "Fit to the declared standnot judged: no stand is declared" in text.replace("\n", "")
    assert "No stand is declared." in text


def test_a_run_that_does_not_fit_its_stand_makes_no_claim(tmp_path, drawn):
    text = plain(report_of(solved("misfit", tmp_path)).text)
    assert "a coverage probability of 95 %. But the run does not fit the declared stand" in text
    assert "so that U may be too small." in text


def test_a_claim_on_the_true_value_takes_a_stand(drawn):
    document = solve().document
    text = plain(report_of(solve()).text)
    assert (
        "U = k u is the standard uncertainty multiplied by k = 1.96, which corresponds to a coverage probability of 95"
        " %."
        in text
        and "noise of the samples" not in text
    )
    assert "U contains no uncertainty of the measurement of the outputs, by voltmeter or converter" in text
    assert "(simple acceptance: no guard band)" in text and "a millionth of the local gravity" in text
    assert "counts the errors of the declared stand alone" in text and "U may be too small" not in text
    lacks_k = Result(json.dumps({**document, "coverage": None, "u_K": None, "u_U0": None, "covariance": None,
                                 "scatter_alone": {"u_K": document["u_K"], "u_U0": document["u_U0"]}}))  # fmt: skip
    text = plain(report_of(lacks_k).text)
    assert "u (k = 1) are standard deviations. u contains the noise of the samples only" in text
    assert "coverage probability" not in text and "uncertainty can be over 100 times larger" in text


VERDICTS = {
    "with a stand": "PASS, assuming a square seat, volts and one temperature",
    "failing": "FAIL: the gravity check and the uncertainty",
    "without": "PASS at the 18 measured positions only: no stand declared, no uncertainty elsewhere; assuming a square"
    " seat, volts and one temperature",
    "not shown": "NOT SHOWN: 3 u(|a|) is up to 0.00045 g, limit 0.0003 g. It would be shown by --estimator optimal"
    " (0.00011 g) or a stand and noise 1.52 times better.",
    "misfit": "FAIL: the fit to the declared stand",
    "labelled": "PASS, assuming a square seat and volts",
    "three mountings": "PASS, assuming one temperature",
}


@pytest.mark.parametrize("name", VERDICTS)
def test_the_verdict(name, tmp_path, drawn):
    result = solved(name, tmp_path)
    text, document = plain(report_of(result).text), result.document
    assert VERDICTS[name] in text
    assert ("gravity" in str(document["pass_reason"])) == ("FAILED: largest |\u0394g|" in text)
    assert ("DOES NOT FIT" in text) == (document["pass_reason"] is not None and "fit" in document["pass_reason"])
    check = document["verification"]
    over = [abs(one["delta_g_g"]) > check["limit_g"] for one in check["delta_g_g"]]
    places = gravity_rows(report_of(result))
    assert [text_of(row[-1]) == "NO" for row in places] == over and len(over) == len(document["means"])
    worst = max(check["delta_g_g"], key=lambda one: abs(one["delta_g_g"]))
    assert f"\u00b5g) at {worst['mounting']}.{worst['position']}, limit" in text
    for warning in document["warnings"]:
        assert ascii_signs(plain(warning)) in ascii_signs(text)
    assert text.count(VERDICTS[name]) == 2  # in the box and in the statement of conformity, in one form


@pytest.mark.parametrize("stand", [True, False])
def test_of_a_result_that_is_older_than_the_rule_the_uncertainty_is_not_judged(stand, tumble, tmp_path):
    """lab, refined: 3 u is beyond its limit, and it passed all the same."""
    document = {**solve("lab_stand", stand).document, "pass": True}
    for key in ("decision", "would_show", "pass_reason"):
        document.pop(key)
    (tmp_path / "old.json").write_text(json.dumps(document))
    done = tumble("report", tmp_path / "old.json", "--out", tmp_path / "old.html", timeout=300)
    assert done.returncode == 0, done.stderr
    text = plain(Report((tmp_path / "old.html").read_text(encoding="utf-8")).text)
    assert "within the limit:" not in text and "PASS" in text
    assert ("not judged: the result is older than the rule" in text) == stand
    assert ("not judged: no stand is declared" in text) != stand
    assert "standard uncertainty of |a| is at most" not in text


def gravity_rows(report):
    """Those of the gravity check."""
    return [row for row in report.rows if len(row) > 5 and text_of(row[1]) in ("fit", "check")]


def test_every_delta_g_has_its_uncertainty(result):
    """In µg and in mm/s², rounded alike; the box has that of the largest."""
    report, judged = report_of(result), result.document["verification"]["delta_g_g"]
    gravity = "/environment/gravity_m_s2" if (result.document["environment"] or {}).get("gravity_m_s2") else "9.80665"
    for i, (row, one) in enumerate(zip(gravity_rows(report), judged, strict=True)):
        at = f"/verification/delta_g_g/{i}"
        assert row[3][0].path == row[5][0].path == f"{at}/delta_g_g" and row[5][0].times == (gravity,)
        assert (row[3][0].power, row[5][0].power) == (6, 3)
        assert one["u_delta_g_g"] > 0.0 and row[4][0].path == row[6][0].path == f"{at}/u_delta_g_g"
        assert (row[4][0].times, row[6][0].times) == ((f"{at}/k_delta_g",), (f"{at}/k_delta_g", gravity))
        assert row[3][0].number[1] == row[4][0].number[1] and row[7][0].path == f"{at}/k_delta_g"
    place = max(range(len(judged)), key=lambda i: abs(judged[i]["delta_g_g"]))
    (in_box,) = [said for said in report.said if said.path == "/verification/max_abs_delta_g_g"]
    following = report.said[report.said.index(in_box) + 1]
    assert following.path == f"/verification/delta_g_g/{place}/u_delta_g_g"


def test_a_delta_g_without_uncertainty_says_so(drawn):
    """As of one mean a position and no stand."""
    document = solve(stand=False).document
    for one in document["verification"]["delta_g_g"]:
        one |= {"u_delta_g_g": None, "k_delta_g": None}
    report = report_of(Result(json.dumps(document)))
    rows = gravity_rows(report)
    assert len(rows) == 18 and all(text_of(row[4]) == "no uncertainty" and len(row) == 7 for row in rows)
    text = plain(report.text)
    assert "\u00b5g, no uncertainty at 2.1, limit" in text and "\u0394g has no uncertainty" in text


def test_the_coverage_factor_is_named_with_its_value(tmp_path, drawn):
    assert "multiplied by k = 1.96, which corresponds to" in plain(report_of(solve()).text)
    several = plain(report_of(solved("misfit", tmp_path)).text)
    assert "multiplied by k from 1.96 to 1.97, which corresponds to" in several
    assert "with the coverage factor k = 1.96: noise by itself" in plain(report_of(solve(stand=False)).text)


def test_values_stand_right_behind_the_verdict(result):
    text = plain(report_of(result).text)
    places = [text.index(one) for one in ("Gravity check", "K_xx", "U0_z", "Item, customer", "Intrinsic", "Decision")]
    assert places == sorted(places)


def test_si_units_stand_beside_g(tmp_path, drawn):
    """With the local gravity also of K, scale and bias; else of what a standard one is good enough for."""
    report = report_of(labelled(tmp_path))
    for name, path in {"K_xy": "K/0/1", "Scale z": "scale/2", "Bias x": "bias/0"}.items():
        row = row_of(report, name)
        assert row[4][0].path == f"/si/{path}" and row[5][0].path == f"/si/u_{path}"
        assert text_of(row[6]) == ("m/s\u00b2" if name == "Bias x" else "V/(m/s\u00b2)")
    assert text_of(row_of(report, "U0_x")[4]) == "" and "by the local gravity, 9.8106 m/s\u00b2" in report.text
    plainly = plain(report_of(solve()).text)
    assert "limit 300 \u00b5g = 2.94 mm/s\u00b2" in plainly and "not stated: no values in SI units." in plainly
    assert "by standard gravity, 9.80665 m/s\u00b2: the local one is not stated." in plainly


def test_it_is_dated_and_has_a_place_to_sign(drawn):
    report = report_of(solve())
    assert report.rows.count([["Date of issue"], ["2023-11-14"]]) == 2 and ", issued 2023-11-14" in plain(report.text)
    assert "Name, signature" in report.text
    assert report_of(solve(), issued="2026-02-28").rows.count([["Date of issue"], ["2026-02-28"]]) == 2
    signed = Result(json.dumps({**solve().document, "environment": {"authorised_by": "M. M."}}))
    name = Said("told", "/environment/authorised_by", (), 0, "M. M.")
    assert report_of(signed).rows.count([["Authorised by"], [name]]) == 2


@pytest.mark.parametrize("date", ["2026-02-30", "28.2.2026", "20260228", "", 7])
def test_what_is_no_date_of_issue_is_refused(date, drawn):
    with pytest.raises(UsageError, match="is not a date such as 2026-11-28"):
        solve().reported("html", issued=date)


def test_warnings_stand_in_the_box_with_the_verdict(drawn):
    """A PASS of exchanged columns is none to trust."""
    odd = "columns ux and uy look exchanged <all>"
    shown = report_of(Result(json.dumps({**solve().document, "warnings": [odd, "another"]}))).source
    box = shown[shown.index('<section class="verdict pass">') : shown.index("</section>")]
    assert "<strong>Warning:</strong> " in box and "exchanged &lt;all&gt;" in box and "another" in box
    calm = report_of(Result(json.dumps({**solve().document, "warnings": []}))).source
    assert "Warning:" not in calm[: calm.index("</section>")]


def test_what_it_must_have(result):
    """ISO/IEC 17025, 7.8.2 and 7.8.4: said, or said to be not stated."""
    report, document = report_of(result), result.document
    text = plain(report.text)
    for name in (
        "Condition",
        "Customer",
        "Laboratory",
        "Date of the run",
        "Serial number",
        "Temperature of the run",
        "Metrological traceability of local gravity",
        "Metrological traceability of the table angle",
        "Deviations from the method",
    ):
        (said,) = report.row(name)
        assert said, name
    assert text.count(number_of(document)) == 2 and text.endswith(f"End of report {number_of(document)} ")
    assert "Decision rule: PASS where" in text and "not an accredited certificate" in text
    assert report.row("SHA-256 of the run file") == [document["run_sha256"] or "not stated"]
    assert report.row("Computed by") == [f"tumble {package.__version__}"]
    assert report.row("Result computed (UTC)") == ["2023-11-14T22:13:20Z"]
    assert report.row("Estimator") == [document["estimator"]]
    known = [one for one in document["assumes"] if report.row(one)]
    assert known == document["assumes"]


def test_what_is_not_stated_is_a_sentence_of_each_section(drawn):
    """And no row of a table."""
    source = report_of(solve()).source
    assert '<td><span class="missing">' not in source.split("<h2>Item")[1].split("</section>")[0]
    first, second = re.findall(r'<p class="unsaid">(.*?)</p>', source, re.DOTALL)
    names = [re.findall("<span>(.*?)</span>", one) for one in (first, second)]
    assert {"Condition", "Customer", "Laboratory", "Date of the run"} < set(names[0])
    angle = "Metrological traceability of the table angle"
    assert {"Deviations from the method", "Local gravity, g", angle} < set(names[1])
    assert all(plain(one).startswith("Not stated: <span>") and one.strip().endswith(".") for one in (first, second))


def test_labels_are_said_where_they_belong(tmp_path, drawn):
    """And are text, whatever is in them."""
    report = report_of(labelled(tmp_path))
    assert report.row("Serial number") == ["B-9; A-17 <b>"]
    assert report.row("Condition") == ["as received & clean"]
    assert report.row("Customer") == ["Müller GmbH"]
    assert report.row("Laboratory") == ["Lab <i>1</i>"]
    assert report.row("Metrological traceability of local gravity") == ["certificate G-12"]
    assert report.row("Metrological traceability of the table angle") == ["not stated"]
    assert report.row("Temperature of the run") == ["21.5 \u00b0C (as the stand file states)"]
    assert report.row("Local gravity, g") == ["9.8106 m/s\u00b2"]
    assert report.row("<script>alert(1)</script>") == ["<script>alert(2)</script>"]
    assert (report.row("seal"), report.row("rig")) == (["4711"], ["B"])
    assert not {"script", "b", "i"} & set(report.tags)


def test_labels_of_the_environment_are_not_the_blocks(drawn):
    document = solve().document
    document["environment"] = {"serial": "THERMO-7", "model": "chamber", "operator": "N. N."}
    report = report_of(Result(json.dumps({**document, "item": {"serial": "A-17"}})))
    assert report.row("Serial number") == ["A-17"] and report.row("Type") == ["not stated"]
    assert (report.row("serial"), report.row("model")) == (["THERMO-7"], ["chamber"])
    assert report.row("Measured by") == ["N. N."]


def test_a_drift_is_in_volts_whatever_the_outputs_are_in(drawn):
    """As the document has it."""
    run = package.read(EXAMPLES / "paper_stand.csv")
    told = {"mounting": run.mounting, "position": run.position} | dict(zip(("ux", "uy", "uz"), 1e3 * run.outputs.T))
    by_unit = {}
    for unit, rows in (("V", run), ("mV", package.read(told, unit="mV"))):
        result = package.solve(rows, stand=EXAMPLES / "paper_stand.toml", estimator="least_squares", model="drift")
        by_unit[unit] = report_of(result).row("drift_x")
    assert by_unit["V"] == by_unit["mV"] and by_unit["V"][-1] == "V"


def test_nothing_comes_from_elsewhere(result):
    report = report_of(result)
    assert not {"script", "link", "iframe", "object", "embed", "base"} & set(report.tags)
    assert not [link for link in report.links if not link.startswith(("data:", "#"))]
    assert "url(" not in report.style and "@import" not in report.style
    assert len(set(report.ids)) == len(report.ids)


def test_the_same_result_gives_the_same_bytes(result):
    assert result.reported("html") == Result(result.to_json()).reported("html")


def test_pictures_stand_in_their_order(drawn):
    run = package.read(EXAMPLES / "paper_stand.csv")
    result = solve()
    report = report_of(result, run=run)
    assert re.findall(r"<title>T(\d)</title>", report.source) == ["1", "2", "3"]
    assert [one for one in report.ids if one != "number"] == ["mountings", "gravity_check", "samples", "attitude"]
    assert "Figure 2. Errors < of gravity." in report.text and "Figure 4. Attitudes." in report.text
    assert to_json(drawn[-1][0]) == result.to_json() and drawn[-1][1] is run
    assert [one for one in report_of(result).ids if one != "number"] == ["mountings", "gravity_check", "attitude"]


def test_a_table_is_no_fact_where_no_stand_is_declared(drawn):
    """Faces may have been laid by hand."""
    shown = [plain(report_of(solve(stand=stand)).text) for stand in (True, False)]
    assert ["How the block sat in each mounting with the table at angle zero" in one for one in shown] == [True, False]
    assert ["A block that was laid by hand had the same faces up, without a table." in one for one in shown] == [
        False,
        True,
    ]


def test_the_run_of_another_result_is_refused(drawn):
    with pytest.raises(BadInput, match=r"lab_stand\.csv: is not the run of result: its SHA-256 is another"):
        solve().reported("html", EXAMPLES / "lab_stand.csv")


def test_a_range_of_temperatures_is_told(drawn):
    told = {"min_c": 20.25, "max_c": 23.0, "source": "run_file"}
    result = Result(json.dumps({**solve().document, "temperature": told}))
    assert report_of(result).row("Temperature of the run") == ["20.25 to 23 \u00b0C (measured in the run)"]


def test_a_bench_run_is_said_to_be_simulated(drawn):
    document = solve().document
    result = Result(json.dumps({**document, "seed": 7, "bus": "inprocess", "firmware": "host"}))
    assert "Simulated on the bench, seed 7" in plain(report_of(result).text)
    assert "Simulated" not in report_of(solve()).text


def test_faces_laid_by_hand_have_no_table(tmp_path):
    """Neither in the picture nor in the list of what is declared; and one number gets no figure of its own."""
    schedule = read_schedule(str(EXAMPLES / "hand_laid_faces.toml")).data
    faces = np.array([one.matrix for one in schedule.mountings])[:, :, 2]
    outputs = 9.81 * (faces * [1.001, 0.999, 1.0] + [0.01, -0.02, 0.03])
    rows = [[mounting, 1, *place] for mounting, place in enumerate(outputs, 1) for _ in range(2)]
    run = np.array(rows) + np.resize([0.01, -0.01], (12, 1)) * [0, 0, 1, 1, 1]
    told = {"stand": EXAMPLES / "hand_laid.toml", "schedule": schedule, "estimator": "least_squares"}
    result = package.solve(package.read(run, unit="m/s^2"), **told)
    source = Source(result.document, "result")
    (picture,) = make._mountings(source)
    assert picture[2].startswith("How the block lay in each mounting") and "able at angle" not in picture[1]
    _, listed = sections.declared(source)
    named = ["Noise of one sample", "Seat not square, in a mounting", "Drift over a run"]
    assert [row[0].text for row in listed.rows] == named
    assert "stand_seen" not in result.plot()
    turned = Source(solve().document, "result")
    assert "Table at angle 0" in make._mountings(turned)[0][1] and len(sections.declared(turned)[1].rows) == 5
