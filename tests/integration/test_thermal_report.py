"""Reports and pictures of a calibration over temperature: numbers are the document's, the verdict, what is drawn."""

import io
import json

import numpy as np
import pytest
from conftest import EXAMPLES
from report_reader import Report, Truth, ascii_signs, plain, text_of
from test_report import rounded_as_it_should
from test_thermal import AT_C, T0, written

import tumble as package
from tumble import pictures
from tumble.api.thermal import load_thermal, solve_thermal
from tumble.errors import UsageError
from tumble.estimators import COEFFICIENTS

pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
pytestmark = pytest.mark.python


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    files = written(tmp_path_factory.mktemp("warm"), AT_C)
    return solve_thermal(files, temperature="quadratic", stand=EXAMPLES / "paper_stand.toml")


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """Without a stand, and a line where a parabola is needed."""
    return solve_thermal(written(tmp_path_factory.mktemp("bare"), AT_C))


@pytest.fixture(scope="module")
def report(result):
    return report_of(result)


@pytest.fixture
def undrawn(monkeypatch):
    """Pictures that cost nothing."""
    monkeypatch.setattr(pictures.thermal, "figures", lambda told: {})
    monkeypatch.setattr(pictures, "figures", lambda told, run=None: {})


def report_of(found, **options):
    return Report(found.reported("html", **options).decode("utf-8"))


@pytest.mark.parametrize("name", ["result", "bare"])
def test_every_number_is_the_document_s(name, request, undrawn):
    found = request.getfixturevalue(name)
    report, truth = report_of(found), Truth(found.to_json())
    numbers = [said for said in report.said if said.kind == "number"]
    assert len(numbers) > (110 if name == "result" else 70)
    assert not [said for said in numbers if not rounded_as_it_should(said, truth)]
    for said in report.said:
        if said.kind == "told":
            assert ascii_signs(said.text) == ascii_signs(truth.at(said.path))


def test_values_at_three_temperatures_with_uncertainties(result, report):
    told = result.checked
    assert [one.temperature_c for one in told.at] == [-40.0, T0, 70.0]
    for one in told.at:
        k, u0 = result.at(one.temperature_c)
        u = np.sqrt(np.diag(result.covariance_at(one.temperature_c)))
        assert np.array_equal(np.append(one.K, one.U0), np.append(k, u0))
        assert np.append(one.u_K, one.u_U0) == pytest.approx(u, rel=1e-9)
    rows = [row for row in report.rows if row and text_of(row[0]) in COEFFICIENTS]
    assert [text_of(row[0]) for row in rows] == [*COEFFICIENTS] * 2
    assert [said[0].path for said in rows[5][1:7]] == [f"/at/{i}/{u}K/1/2" for i in range(3) for u in ("", "u_")]
    assert all(said[0].digits <= 2 for row in rows for said in row[2:-1:2])
    assert [said[0].path for said in rows[13][1:5]] == ["/K/1/0/1", "/u_K/1/0/1", "/K/2/0/1", "/u_K/2/0/1"]


def test_the_verdict_its_rule_and_the_runs(result, report):
    text = plain(report.text)
    assert text.count("PASS from -40 to 70 °C, assuming a square seat") == 2
    assert "3 times the standard uncertainty of |a| is at most the limit at every attitude, at 9 temperatures" in text
    assert report.row("The same in all runs") == ["Axis not level"] and "Local gravity, g" in report.unsaid
    assert report.row("5")[:5] == ["70.0", "70.0 to 70.0", "18", "paper", "refined"]
    assert report.row("Run 5") == [f"run4.csv; SHA-256 {result.checked.runs[4].sha256}"]
    assert {"coefficients", "residuals", "uncertainty"} <= set(report.ids)


def test_what_does_not_pass_says_why(bare):
    report = report_of(bare)
    text = plain(report.text)
    assert text.count("FAIL from -40 to 70 °C: the gravity check") == 2 and "not judged: no stand is declared" in text
    assert "The values have no uncertainty: no stand is declared." in text and "No stand is declared." in text
    assert "uncertainty" not in report.ids and {"coefficients", "residuals"} <= set(report.ids)


def test_a_pass_without_a_stand_holds_at_the_measured_positions(tmp_path, undrawn):
    found = solve_thermal(written(tmp_path, AT_C), temperature="quadratic")
    said = "PASS from -40 to 70 °C at the 90 measured positions only: no stand declared, no uncertainty elsewhere"
    assert said in plain(report_of(found).text)


def test_a_document_of_an_earlier_version_has_its_values_all_the_same(result, tmp_path, undrawn):
    document = json.loads(result.to_json())
    del document["at"]
    for one in document["runs"]:
        del one["u_K"], one["u_U0"]
    (tmp_path / "old.json").write_text(json.dumps(document))
    rows = report_of(load_thermal(tmp_path / "old.json")).rows
    rows = [row for row in rows if row and text_of(row[0]) in COEFFICIENTS]
    assert len(rows) == 12 and rows[0][1][0].path == "/K/0/0/0"


CONTRADICTORY = {
    "degree": (lambda told: told | {"degree": 1}, "degree 1 needs 2 powers of K and U0"),
    "covariance": (lambda told: told | {"covariance": [[1.0]]}, "a covariance of another size"),
    "u": (lambda told: told | {"u_K": None}, "u_K and u_U0 must be both known or both null"),
    "pass": (lambda told: told | {"pass_reason": "gravity"}, "pass and pass_reason contradict each other"),
    "reason": (lambda told: told | {"pass_reason": "luck"}, "pass_reason is 'luck'"),
    "gravity": (lambda told: told | {"environment": {"gravity_m_s2": "x"}}, "environment.gravity_m_s2 is 'x'"),
    "singular": (lambda told: told | {"K": [np.zeros((3, 3)).tolist(), *told["K"][1:]]}, "K cannot be inverted"),
}


@pytest.mark.parametrize("case", CONTRADICTORY)
def test_a_document_that_contradicts_itself_is_refused(case, result, refused, tmp_path):
    changed, why = CONTRADICTORY[case]
    (tmp_path / "odd.json").write_text(json.dumps(changed(json.loads(result.to_json()))))
    said = refused("report", tmp_path / "odd.json", "--out", tmp_path / "odd.html")
    assert said == f"tumble: {tmp_path / 'odd.json'}: not a result of schema tumble.thermal/1: {why}\n"
    assert not (tmp_path / "odd.html").exists()


def test_by_command_as_pdf(tumble, refused, result, tmp_path):
    pypdf = pytest.importorskip("pypdf")
    pytest.importorskip("weasyprint")
    (tmp_path / "warm.json").write_text(result.to_json())
    options = ["--number", "N 7", "--issued", "2026-11-28"]
    done = tumble("report", tmp_path / "warm.json", "--out", tmp_path / "warm.pdf", *options, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    reader = pypdf.PdfReader(io.BytesIO((tmp_path / "warm.pdf").read_bytes()))
    text = plain("".join(page.extract_text() for page in reader.pages))
    assert "PASS from -40 to 70 °C, assuming a square seat" in text and "End of report N 7" in text
    assert reader.attachments["result.json"] == [result.to_json().encode()]
    for option in ("--run", "--since"):
        said = refused("report", tmp_path / "warm.json", option, tmp_path / "warm.json")
        assert said.endswith(f"{option} is for a result of one run, not for one over temperature\n")


def test_a_template_for_results_serves_both(result, tmp_path, undrawn):
    """One with a customer's heading extends report.html.j2, of whichever kind the document is."""
    block = '{% block identity %}<h2 id="mine">{{ document.unit }}</h2>{{ super() }}{% endblock %}'
    (tmp_path / "own.j2").write_text('{% extends "report.html.j2" %}' + block)
    for found in (result, package.solve(EXAMPLES / "paper_stand.csv")):
        assert "mine" in report_of(found, template=str(tmp_path / "own.j2")).ids


def curve(axes, label):
    (found,) = [line for line in axes.lines if line.get_label() == label]
    return found.get_xydata().T


def test_pictures_show_the_polynomials_and_the_runs(result):
    drawn = result.plot()
    assert list(drawn) == ["coefficients", "residuals", "uncertainty"]
    k0 = result.at(T0)[0]
    for axes, name in zip(drawn["coefficients"].axes, COEFFICIENTS):
        t, change = curve(axes, "all runs")
        i, j = ("xyz".index(one) for one in (name[2:] * 2)[:2]) if name[0] == "K" else ("xyz".index(name[-1]), None)
        scale = 1e6 / np.linalg.norm(k0[i])
        k, u0 = result.at(t)
        values = u0[:, i] if j is None else k[:, i, j]
        zero = result.at(T0)[1][i] if j is None else k0[i, j]
        assert change == pytest.approx(scale * (values - zero), abs=1e-6)
        assert (t[0], t[-1]) == (-40.0, 70.0) and axes.get_xlim() == pytest.approx((-53.2, 83.2))
        (bars,) = axes.containers
        points = bars.lines[0].get_xydata()
        assert points[:, 0].tolist() == [*AT_C]
        alone = [one.U0[i] if j is None else one.K[i, j] for one in result.checked.runs]
        assert points[:, 1] == pytest.approx(scale * (np.array(alone) - zero), abs=1e-6)
        assert axes.get_title(loc="left").startswith(f"{name} / {'µg' if j is None else 'ppm' if i == j else 'µrad'}")
    points = drawn["residuals"].axes[0].containers[0].lines[0].get_xydata()
    assert np.abs(points[:, 1]).max() < 60.0
    t, u = curve(drawn["uncertainty"].axes[0], "judged")
    assert u == pytest.approx([1e6 * one.worst_g for one in result.checked.u_norm_g])
    t, u = curve(drawn["uncertainty"].axes[0], "all runs")
    assert np.interp(T0, t, u) == pytest.approx(1e6 * result.checked.u_norm_g[4].worst_g, rel=1e-2)


def test_pictures_to_files_and_what_is_refused(result, bare, tmp_path):
    result.plot(tmp_path / "one.svg")
    assert "K_xx / ppm" in (tmp_path / "one.svg").read_text("utf-8")
    assert list(result.plot("uncertainty")) == ["uncertainty"] and list(bare.plot()) == ["coefficients", "residuals"]
    with pytest.raises(UsageError, match="kind: 'budget' is not one of coefficients, residuals, uncertainty"):
        result.plot(kind="budget")
    with pytest.raises(UsageError, match="kind: uncertainty needs runs that were solved with a stand"):
        bare.plot("uncertainty")


def test_python_writes_reports_too(result, tmp_path, undrawn):
    result.report(tmp_path / "warm.html", issued="2026-11-28", number="N 8")
    assert "N 8" in (tmp_path / "warm.html").read_text("utf-8")
    with pytest.raises(UsageError, match=r"does not end in \.html or \.pdf"):
        result.report(tmp_path / "warm.txt")
