"""Reports as PDF: A4, number and place on every page, the same bytes for the same result, nothing from elsewhere."""

import io
import json
import re

import pytest
from conftest import EXAMPLES
from report_reader import Report, plain
from test_report import drawn, labelled, misfit, solve  # noqa: F401 # a fixture

from tumble.api.result import Result
from tumble.cli.main import main
from tumble.errors import BadInput
from tumble.estimators import COEFFICIENTS
from tumble.report.pages import number_of

pypdf = pytest.importorskip("pypdf")
pytest.importorskip("jinja2")
pytest.importorskip("matplotlib")
try:
    import weasyprint  # noqa: F401
except (ImportError, OSError):
    pytest.skip("WeasyPrint, or Pango, is not installed", allow_module_level=True)
pytestmark = [pytest.mark.python, pytest.mark.toolchain]

A4_PT = (595.3, 841.9)


def pages_of(data):
    """Texts of the pages, each with single blanks."""
    return [plain(page.extract_text()) for page in pypdf.PdfReader(io.BytesIO(data)).pages]


def test_every_page_has_the_number_and_its_place(drawn):
    result = solve()
    data = result.reported("pdf")
    reader, texts = pypdf.PdfReader(io.BytesIO(data)), pages_of(data)
    assert len(texts) >= 3
    for place, (page, text) in enumerate(zip(reader.pages, texts), 1):
        assert tuple(map(float, page.mediabox[2:])) == pytest.approx(A4_PT, abs=0.5)
        assert number_of(result.document) in text and f"page {place} of {len(texts)}" in text
        assert "Not an accredited certificate" in text
    assert f"End of report {number_of(result.document)}" in texts[-1]
    assert reader.metadata.title == f"Calibration report {number_of(result.document)}"
    assert reader.metadata.creation_date.isoformat() == "2023-11-14T22:13:20+00:00"


@pytest.mark.parametrize("lines", range(24, 48, 3))
def test_the_statement_of_conformity_is_not_parted_from_its_table(lines, drawn):
    """Wherever on a page it comes to stand."""
    result = Result(json.dumps({**solve().document, "item": {f"label {i}": "told" for i in range(lines)}}))
    (page,) = [text for text in pages_of(result.reported("pdf")) if "Statement of conformity" in text]
    assert "Decision rule: PASS where" in page and "Position Use Samples" in page and "1.4 fit" in page


def catalog_of(data):
    return pypdf.PdfReader(io.BytesIO(data)).trailer["/Root"]


def test_it_is_tagged_for_readers_of_screens(drawn):
    """What `pdfinfo` calls Tagged, and what PDF/UA-1 asks of the catalog: language, title, who claims it."""
    catalog = catalog_of(solve().reported("pdf"))
    assert catalog["/MarkInfo"]["/Marked"] and catalog["/Lang"] == "en"
    assert catalog["/ViewerPreferences"]["/DisplayDocTitle"]
    assert b"pdfuaid:part" in catalog["/Metadata"].get_data()
    kinds = list(kinds_of(catalog["/StructTreeRoot"]["/K"][0]))
    assert {"/H1", "/H2", "/Table", "/TH", "/TD", "/P", "/Figure"} <= set(kinds)
    assert kinds.count("/H1") == 1


def kinds_of(element):
    """Of all structure elements below one; every picture has its text."""
    element = element.get_object()
    if isinstance(element, dict) and "/S" in element:
        yield element["/S"]
        assert element["/S"] != "/Figure" or element["/Alt"]
        for kid in element.get("/K", []):
            if not isinstance(kid, int):
                yield from kinds_of(kid)


def test_the_result_goes_with_it(drawn):
    """Byte by byte."""
    result = solve()
    attached = pypdf.PdfReader(io.BytesIO(result.reported("pdf"))).attachments
    assert attached == {"result.json": [result.to_json().encode()]}


def test_verdict_and_values_stand_on_page_1(drawn, tmp_path):
    for result in (solve(), solve(stand=False), labelled(tmp_path), misfit(tmp_path)):
        first = pages_of(result.reported("pdf"))[0]
        assert re.search("PASS|FAIL", first) and "issued 2023-11-14" in first
        assert [name for name in COEFFICIENTS if name not in first] == []


@pytest.mark.parametrize("lines", range(0, 60, 6))
def test_no_page_is_nearly_empty(lines, drawn):
    """Least of all the last one: whatever stands before, the end takes a picture along."""
    labels = {f"label {i}": "told" for i in range(lines)}
    reader = pypdf.PdfReader(io.BytesIO(Result(json.dumps({**solve().document, "item": labels})).reported("pdf")))
    last = reader.pages[-1].extract_text()
    assert "Attitudes." in last and "Name, signature" in last and "End of report" in last
    few = [text for page in reader.pages if (text := page.extract_text()).count("\n") < 10 and "Figure" not in text]
    assert few == []


def test_a_number_of_one_s_own_is_on_every_page(drawn):
    number = 'No. 7/2026 "A" \\ <b> é'
    assert all(number in text for text in pages_of(solve().reported("pdf", number=number)))


def test_it_says_what_the_html_says(drawn, tmp_path):
    """Every number and text of the document, in the same order, whatever stands between them."""
    result = labelled(tmp_path)
    text = re.sub(r"\s", "", "".join(pypdf_text(result.reported("pdf"))))
    said, place = Report(result.reported("html").decode()).said, 0
    assert len(said) > 100
    for one in said:
        wanted = re.sub(r"[\s^]", "", one.text)
        found = text.find(wanted, place)
        assert found >= 0, one
        place = found


def pypdf_text(data):
    """Of the pages without what stands in their margins."""
    margins = r"Calibration report|Not an accredited certificate|page \d+ of \d+|T-\d{8}-[0-9a-f]{12}"
    for page in pypdf.PdfReader(io.BytesIO(data)).pages:
        yield re.sub(margins, "", page.extract_text())


def test_the_same_result_gives_the_same_bytes(drawn):
    assert solve().reported("pdf") == solve().reported("pdf")


def test_the_command_writes_it(drawn, tmp_path, capfd):
    solve().save(tmp_path / "result.json")
    logo = tmp_path / "logo.svg"
    logo.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20"><path d="M0 0L40 20z"/></svg>')
    assert main(["report", str(tmp_path / "result.json"), "--out", str(tmp_path / "r.PDF"), "--logo", str(logo)]) == 0
    assert capfd.readouterr() == ("", "") and (tmp_path / "r.PDF").read_bytes().startswith(b"%PDF-")


@pytest.mark.parametrize(
    "wanted", ["http://127.0.0.1:9/a.png", "file:///etc/hostname", "a.png", "https://example.org/a.png"]
)  # fmt: skip
@pytest.mark.parametrize("place", ['<img src="{}" alt="">', '<link rel="stylesheet" href="{}">',
                                   '<p style="background: url({})">x</p>'])  # fmt: skip
def test_nothing_comes_from_elsewhere(place, wanted, drawn, tmp_path, capfd):
    """Not even with a template, or a logo, that asks for it."""
    template = tmp_path / "own.j2"
    template.write_text(place.format(wanted) + "<p>{{ number }}</p>")
    with pytest.raises(BadInput, match="a report takes nothing from elsewhere") as refused:
        solve().reported("pdf", template=str(template))
    assert str(template) in str(refused.value) and capfd.readouterr() == ("", "")


def test_a_logo_refers_to_nothing(drawn, tmp_path):
    logo = tmp_path / "logo.svg"
    image = '<image href="file:///etc/hostname" width="9" height="9"/>'
    logo.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9">{image}</svg>')
    with pytest.raises(BadInput, match="a report takes nothing from elsewhere"):
        solve().reported("pdf", logo=str(logo))


@pytest.mark.slow
def test_with_its_pictures(tmp_path):
    pytest.importorskip("tumble.pictures")
    result = solve()
    result.report(tmp_path / "r.pdf", run=EXAMPLES / "paper_stand.csv")
    texts = pages_of((tmp_path / "r.pdf").read_bytes())
    assert "Figure 7." in "".join(texts) and all(number_of(result.document) in text for text in texts)
