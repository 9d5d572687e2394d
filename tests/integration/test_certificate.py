"""A result as a Digital Calibration Certificate, read by the toolkit of PTB and by the XML parser of Python."""

import base64
import datetime
import json
import os
import re
import xml.etree.ElementTree as ET
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from conftest import EXAMPLES
from report_reader import Report, plain, text_of
from test_further_terms import noisy

import tumble
from tumble.api.result import Result
from tumble.cli.main import main
from tumble.report.pages import number_of

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib

pytestmark = pytest.mark.python
IN = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
ITEM = {"customer": "Example Ltd."}
ENVIRONMENT = {
    "country": "DE",
    "laboratory": "Calibration laboratory",
    "operator": "N. N.",
    "date": "2026-11-20",
    "gravity_m_s2": 9.8106,
    "u_gravity_m_s2": 1e-5,
    "pressure_hpa": 1013,
}
FINDINGS = ("Gravity check", "Fit to the declared stand", "Uncertainty at every attitude", "One µg here")
FILES = "dcc.xsd, SI_Format.xsd, qudt.xsd and xmldsig-core-schema.xsd"
HOSTILE = "A & B <\"1\">, '2' ]]> \u00e4\u4e2d\U0001f600"
NAMES = [*(f"K_{i}{j}" for i in "xyz" for j in "xyz"), *(f"U0_{i}" for i in "xyz")]


def stand_with(item=ITEM, environment=ENVIRONMENT, serial="17"):
    """A stand of the examples, with these labels."""
    tables = tomllib.loads((EXAMPLES / "paper_stand.toml").read_text())
    tables["block"] |= {} if serial is None else {"serial": serial}
    return tables | {"item": item, "environment": environment}


def solved(**labels):
    return tumble.solve(EXAMPLES / "paper_stand.csv", stand=stand_with(**labels))


def without(table, *keys):
    return {key: text for key, text in table.items() if key not in keys}


def changed(result, **keys):
    return Result(json.dumps({**result.document, **keys}))


def texts(root, path):
    return [one.text for one in root.iterfind(path, IN)]


@pytest.fixture(scope="module")
def result():
    return solved()


@pytest.fixture(scope="module")
def certificate(result):
    return result.export("dcc")


def test_numbers_are_rounded_by_their_uncertainties(result, certificate):
    """U to two significant digits, the value to the same place, k to three digits, all half to even."""
    root, document = ET.fromstring(certificate), result.document
    quantities = root.findall(".//dcc:result/dcc:data/dcc:quantity", IN)
    assert [one.find("dcc:name/dcc:content", IN).text for one in quantities] == NAMES
    values = np.array(document["si"]["K"] + [document["U0"]]).ravel().tolist()
    u = np.array(document["si"]["u_K"] + [document["u_U0"]]).ravel().tolist()
    k = np.array(document["coverage"]["k_K"] + [document["coverage"]["k_U0"]]).ravel().tolist()
    read = {
        name: [Decimal(one) for one in texts(root, f".//dcc:result//si:{name}")]
        for name in ("value", "valueExpandedMU", "coverageFactor", "coverageProbability")
    }
    spreads = [Decimal(repr(one)) * Decimal(repr(factor)) for one, factor in zip(u, k)]
    assert read["valueExpandedMU"] == [Decimal(f"{one:.1e}") for one in spreads]
    places = [one.adjusted() - 1 for one in map(Decimal, read["valueExpandedMU"])]
    assert read["value"] == [round(Decimal(repr(one)), -place) for one, place in zip(values, places)]
    for shown, spread in zip(*(texts(root, f".//dcc:result//si:{name}") for name in ("value", "valueExpandedMU"))):
        assert Decimal(shown).as_tuple().exponent == Decimal(spread).as_tuple().exponent
        assert len(Decimal(spread).as_tuple().digits) == 2
    assert read["coverageFactor"] == [Decimal(f"{one:.2f}") for one in k]
    assert read["coverageProbability"] == [Decimal(repr(document["coverage"]["probability"]))] * 12


def test_the_whole_result_comes_along(result, certificate):
    root = ET.fromstring(certificate)
    (file,) = root.iterfind(".//dcc:result/dcc:data/dcc:byteData", IN)
    assert [one.tag.split("}")[1] for one in file] == ["fileName", "mimeType", "dataBase64"]
    assert [one.text for one in file][:2] == ["result.json", "application/json"]
    assert base64.b64decode(file[2].text, validate=True).decode() == result.to_json()


@pytest.mark.parametrize(("unit", "volts"), [("V", 1.0), ("mV", 1e-3), ("µV", 1e-6), ("uV", 1e-6), ("kV", 1e3)])
def test_units_are_those_of_the_si(result, unit, volts):
    """By the base units: 1 V s^2/m is 1 kg m/(A s)."""
    dsi_unit = pytest.importorskip("dsi_unit")
    read = texts(ET.fromstring(changed(result, unit=unit).export("dcc")), ".//dcc:result//si:unit")
    for units, base in ((read[:9], r"\kilogram\metre\second\tothe{-1}\ampere\tothe{-1}"), (read[9:], r"\volt")):
        assert len(set(units)) == 1 and dsi_unit.DsiUnit(units[0]).valid
        assert dsi_unit.DsiUnit(base).get_scale_factor(dsi_unit.DsiUnit(units[0])) == pytest.approx(volts, rel=1e-15)


@pytest.mark.parametrize(
    ("unit", "of_outputs", "of_k"),
    [("m/s^2", r"\metre\second\tothe{-2}", r"\one"), ("counts", r"\one", r"\second\tothe{2}\metre\tothe{-1}")],
)
def test_units_of_other_outputs(result, unit, of_outputs, of_k):
    read = texts(ET.fromstring(changed(result, unit=unit).export("dcc")), ".//dcc:result//si:unit")
    assert read == [of_k] * 9 + [of_outputs] * 3


def test_the_toolkit_finds_no_fault_in_its_content(certificate):
    pytest.importorskip("dcc_json_toolkit")
    from dcc_json_toolkit import DccSourceContent
    from dcc_json_toolkit.content_validation import validate_dcc_content

    assert validate_dcc_content(DccSourceContent(certificate)) == []
    broken = certificate.replace(r"\volt<", r"\voltage<").replace("2026-11-20", "2026-11-31")
    faults = validate_dcc_content(DccSourceContent(broken))
    assert len(faults) == 5 and sum("voltage" in one for one in faults) == 3  # of U0; and both dates


@pytest.fixture(scope="module")
def faults():
    """What the schema of PTB objects to in a text: by the copy in the folder TUMBLE_DCC_SCHEMA, else by the toolkit,
    which fetches it from PTB's server and keeps it."""
    if folder := os.environ.get("TUMBLE_DCC_SCHEMA"):
        xmlschema = pytest.importorskip("xmlschema")
        files = {ET.parse(one).getroot().get("targetNamespace"): one.as_uri() for one in Path(folder).glob("*.xsd")}
        schema = xmlschema.XMLSchema(files[IN["dcc"]], locations=files, use_location_hints=False, allow="local")
        assert schema.version == "3.3.0"
        return lambda text: [str(one) for one in schema.iter_errors(text)]
    toolkit, requests = pytest.importorskip("dcc_json_toolkit"), pytest.importorskip("requests")
    try:
        return toolkit.DccSchema("3.3.0").validate_dcc
    except requests.RequestException:
        pytest.skip(f"ptb.de cannot be reached for the schema, and TUMBLE_DCC_SCHEMA names no folder with {FILES}")


def test_the_schema_sees_what_is_wrong(faults, certificate):
    assert faults(certificate) == []
    for right, wrong in (
        ("<dcc:issuer>manufacturer", "<dcc:issuer>somebody"),
        ("<dcc:conformity>pass", "<dcc:conformity>PASS"),
        ("<si:valueExpandedMU>", "<si:valueExpandedMU>+-"),
        ("2026-11-20", "20.11.2026"),
    ):
        assert right in certificate and faults(certificate.replace(right, wrong))


KINDS = {
    "fail": {"pass": False, "pass_reason": "fit"},
    "not shown": {"pass": False, "pass_reason": "uncertainty"},
    "simulated, with a warning": {"bus": "inprocess", "warnings": ["a first <warning>"]},
    "of no version": {"tumble": None},
    "text that XML has not": {"serial": "a\x00b\x1bc\ufffe"},
    **{f"in {unit}": {"unit": unit} for unit in ("mV", "µV", "uV", "kV", "counts", "m/s^2")},
}


@pytest.mark.parametrize("keys", KINDS.values(), ids=KINDS)
def test_every_kind_follows_the_schema(keys, faults, result):
    assert faults(changed(result, **keys).export("dcc")) == []


@pytest.mark.parametrize("labels", [
    {"serial": HOSTILE, "item": dict.fromkeys(("customer", "description", "model", "contact"), HOSTILE)},
    {"serial": None, "item": {**ITEM, "serial number": " 1\n 8 ", "certificate number": " C 1 "}},
    {"environment": {**ENVIRONMENT, "place": "on site", "temperature_c": 21.5, "humidity_percent": 40}},
])  # fmt: skip
def test_any_labels_follow_the_schema(labels, faults):
    assert faults(solved(**labels).export("dcc")) == []


def test_any_text_comes_through():
    found = solved(serial=HOSTILE, item={**ITEM, "customer": HOSTILE, "description": HOSTILE, "model": HOSTILE})
    root = ET.fromstring(found.export("dcc"))
    assert texts(root, ".//dcc:item/dcc:name/dcc:content") == [HOSTILE]
    assert texts(root, ".//dcc:identification/dcc:value") == texts(root, ".//dcc:model") == [HOSTILE]
    assert texts(root, ".//dcc:customer/dcc:name/dcc:content") == [HOSTILE]
    lost = changed(found, serial="a\x00b\x1bc\ufffe")  # no XML can have these
    assert texts(ET.fromstring(lost.export("dcc")), ".//dcc:identification/dcc:value") == ["a\ufffdb\ufffdc\ufffd"]


def test_who_where_and_when(result, certificate):
    root = ET.fromstring(certificate)
    core = {one.tag.split("}")[1]: one.text for one in root.find(".//dcc:coreData", IN)}
    assert (
        core
        == {
            "countryCodeISO3166_1": "DE",
            "usedLangCodeISO639_1": "en",
            "mandatoryLangCodeISO639_1": "en",
            "uniqueIdentifier": number_of(result.document),  # as its report has it
            "beginPerformanceDate": "2026-11-20",
            "endPerformanceDate": "2026-11-20",
            "performanceLocation": "laboratory",
            "issueDate": result.document["created"][:10],
        }
    )
    assert datetime.date.fromisoformat(core["issueDate"])
    assert texts(root, ".//dcc:release") == [f"v{tumble.__version__}"] * 2  # PTB's Schematron asks for the letter
    assert texts(root, ".//dcc:respPerson/dcc:person/dcc:name/dcc:content") == ["N. N."]
    assert texts(root, ".//dcc:customer/dcc:location/dcc:further/dcc:content") == ["not stated"]
    conditions = zip(
        texts(root, ".//dcc:influenceCondition//dcc:content"), texts(root, ".//dcc:influenceCondition//si:value")
    )
    assert list(conditions) == [("Local gravity", "9.8106"), ("Air pressure", "1013")]
    assert texts(root, ".//dcc:influenceCondition//si:valueStandardMU") == ["1e-05"]
    told = dict(
        zip(
            texts(root, ".//dcc:metaData/dcc:name/dcc:content"),
            texts(root, ".//dcc:metaData/dcc:declaration/dcc:content"),
        )
    )
    assert told["run_sha256"] == result.document["run_sha256"] and told["item.customer"] == "Example Ltd."


def test_labels_that_may_be_missing():
    item = {**ITEM, "Serial number": "18", "certificate number": "C-1", "contact": "1 Harbour Road"}
    environment = {**ENVIRONMENT, "place": "on site", "authorised_by": "A. B.", "temperature_c": 21.5}
    root = ET.fromstring(solved(serial=None, item=item, environment=environment).export("dcc"))
    assert texts(root, ".//dcc:identification/dcc:value") == ["18"]
    assert texts(root, ".//dcc:uniqueIdentifier") == ["C-1"]
    assert texts(root, ".//dcc:performanceLocation") == ["other"]
    assert texts(root, ".//dcc:respPerson/dcc:person/dcc:name/dcc:content") == ["A. B."]
    assert texts(root, ".//dcc:customer/dcc:location/dcc:further/dcc:content") == ["1 Harbour Road"]
    assert texts(root, ".//dcc:influenceCondition//si:value") == ["9.8106", "1013", "21.5", "21.5"]


@pytest.mark.parametrize(
    ("keys", "conformity", "begins"),
    [
        ({}, "pass", "PASS, assuming "),
        ({"pass": False, "pass_reason": "uncertainty"}, "noPass", "NOT SHOWN: 3 u(|a|) is up to "),
        ({"pass": False, "pass_reason": "fit"}, "fail", "FAIL: the fit to the declared stand"),
    ],
)
def test_the_verdict_is_a_statement(result, keys, conformity, begins):
    root = ET.fromstring(changed(result, **keys).export("dcc"))
    statement = root.find(".//dcc:statements/dcc:statement", IN)
    assert statement.find("dcc:conformity", IN).text == conformity
    declared = statement.find("dcc:declaration/dcc:content", IN).text
    assert declared.startswith(begins)
    assert "3 times the standard uncertainty of |a| is at most the limit at every attitude." in declared


def test_the_decision_rule_is_that_of_the_report(result, certificate):
    """With the limit, the confidence and the numbers found."""
    declared = texts(ET.fromstring(certificate), ".//dcc:statement/dcc:declaration/dcc:content")[0]
    pytest.importorskip("jinja2")
    pytest.importorskip("matplotlib")
    report = Report(result.reported("html").decode())
    (rule,) = re.findall(r"Decision rule: .*?before they are rounded\.", plain(report.text))
    assert declared.startswith("PASS, assuming a square seat, volts and one temperature. ")
    assert f"temperature. {rule} Found: Gravity check: passed: largest |Δg| " in declared
    sentences = [f"{name}: {report.row(name)[0]}" for name in FINDINGS]
    assert declared.endswith(f"Found: {'; '.join(sentences)}.")
    assert "limit 300 µg" in declared and "confidence 0.999" in declared and "times 3" in declared
    assert declared.endswith("; One µg here: a millionth of the local gravity, 9.81 µm/s².")
    errors = [row[3] for row in report.rows if len(row) == 4 and row[0] == ["a scale drift"]]
    assert [text_of(one) for one in errors] == [f"{1e6 * result.document['reliability_norm_g']:.2g}"]


def test_assumptions_are_statements_with_their_coefficients(result, certificate):
    root = ET.fromstring(certificate)
    told = dict(zip(texts(root, ".//dcc:statement/dcc:name/dcc:content"),
                    texts(root, ".//dcc:statement/dcc:declaration/dcc:content")))  # fmt: skip
    document = result.document
    assert [name.removeprefix("Assumption: ") for name in told if name.startswith("Assumption")] == document["assumes"]
    assert told["Assumption: seat"] == (
        "a square seat: no position shows the block's tilt against the axis. "
        f"Rests on it: {', '.join(document['assumed_for']['seat'])}."
    )
    assert told["Assumption: temperature"].endswith("Rests on it: all.")


@pytest.mark.parametrize(
    ("limit_g", "said"),
    [(3e-4, "within the limit."), (5e-5, "more than the limit: the verdict assumes that there is none.")],
)
def test_what_the_run_could_not_have_shown_is_a_statement(result, limit_g, said):
    document = result.document
    found = changed(result, verification={**document["verification"], "limit_g": limit_g})
    root = ET.fromstring(found.export("dcc"))
    name, declared = (texts(root, f".//dcc:statement/{one}/dcc:content")[-1] for one in ("dcc:name", "dcc:declaration"))
    assert name == "What this run could not have shown"
    size = f"{1e6 * document['reliability_norm_g']:.2g}"
    unnoticed = f"could go unnoticed; it would change |a| by up to {size} µg, {said}"
    assert f"{unnoticed} Would not have shown at any size: " in declared


@pytest.mark.parametrize(
    ("label", "is_told"), [({"Serial number": "18"}, True), ({"serial": " 17"}, False), ({"block serial": "18"}, False)]
)
def test_two_serial_numbers_are_a_warning(label, is_told):
    found = solved(item={**ITEM, **label})
    warning = "[block] and [item] of the stand file have different serial numbers: a certificate takes that of [block]"
    root = ET.fromstring(found.export("dcc"))
    assert (warning in found.warnings) == is_told
    assert (warning in texts(root, ".//dcc:statement/dcc:declaration/dcc:content")) == is_told
    assert texts(root, ".//dcc:identification/dcc:value") == ["17"]


def test_warnings_and_a_simulated_run_are_statements(result, tmp_path, capsys):
    found = changed(result, bus="inprocess", warnings=["a first <warning>"])
    found.save(tmp_path / "result.json")
    assert main(["export", str(tmp_path / "result.json"), "--format", "dcc"]) == 0
    printed = capsys.readouterr()
    said = texts(ET.fromstring(printed.out), ".//dcc:statement/dcc:declaration/dcc:content")
    assert said[-2:] == ["a first <warning>", "The run was simulated: no block was measured."]
    assert "a first <warning>" in printed.err


def test_number_and_date_of_issue_may_be_given(result, tmp_path):
    result.save(tmp_path / "result.json")
    options = "--certificate-number", " C-7 ", "--issued", "2026-12-01", "--out", str(tmp_path / "dcc.xml")
    assert main(["export", str(tmp_path / "result.json"), "--format", "dcc", *options]) == 0
    text = (tmp_path / "dcc.xml").read_text()
    root = ET.fromstring(text)
    assert texts(root, ".//dcc:uniqueIdentifier") == ["C-7"] and texts(root, ".//dcc:issueDate") == ["2026-12-01"]
    assert result.export("dcc", certificate_number="C-7", issued="2026-12-01") == text


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("dcc", "--issued", "1.12.2026"), "--issued: '1.12.2026' is not a date such as 2026-11-28"),
        (("dcc", "--certificate-number", ""),
         "--certificate-number: '' is not a text of 1 to 64 characters on one line"),
        (("c", "--issued", "2026-12-01"), "--issued: is for --format dcc"),
        (("csv", "--certificate-number", "7"), "--certificate-number: is for --format dcc"),
    ],
)  # fmt: skip
def test_other_numbers_and_dates_are_refused(options, said, result, tmp_path, capsys):
    result.save(tmp_path / "result.json")
    assert main(["export", str(tmp_path / "result.json"), "--format", *options]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"tumble: {said}"
    name = options[1][2:].replace("-", "_")
    with pytest.raises(tumble.UsageError, match=f"^{name}: is"):
        result.export("c", **{name: "7"})


def test_a_report_has_the_number_of_the_certificate(result):
    found = solved(item={**ITEM, "Certificate number": "C-1"})
    assert number_of(found.document) == "C-1" != number_of(result.document)
    assert number_of(solved(item={**ITEM, "certificate_number": " "}).document).startswith("T-")
    with pytest.raises(tumble.UsageError, match=r"^certificate_number: 'x{37}\.\.\.' is not a text of 1 to 64 char"):
        solved(item={**ITEM, "certificate_number": "x" * 65}).export("dcc")


REFUSED = [
    *(({"environment": without(ENVIRONMENT, key)}, f"a certificate needs {key}: write it under [item] or "
       "[environment] of the stand file, and solve again") for key in ("country", "laboratory", "operator", "date")),
    ({"serial": None}, "a certificate needs serial: write it under [block] or [item] of the stand file, and solve "
     "again"),
    ({"environment": without(ENVIRONMENT, "country", "date")}, "a certificate needs country and date: write country "
     "and date under [item] or [environment] of the stand file, and solve again"),
    ({"item": {}, "serial": None}, "a certificate needs customer and serial: write customer under [item] or "
     "[environment], serial under [block] or [item] of the stand file, and solve again"),
    ({"environment": {**ENVIRONMENT, "country": "Germany"}}, "country is 'Germany', no code of ISO 3166-1 such as DE"),
    ({"environment": {**ENVIRONMENT, "date": "20.11.2026"}}, "date is '20.11.2026', no date such as 2026-11-20"),
    ({"environment": {**ENVIRONMENT, "date": "20261120"}}, "date is '20261120', no date such as 2026-11-20"),
    ({"environment": {**ENVIRONMENT, "pressure_hpa": 1013.0, "u_pressure_hpa": "<1 & a bit"}},
     "environment.u_pressure_hpa is '<1 & a bit', no number, which a certificate needs"),
    ({"environment": without(ENVIRONMENT, "u_gravity_m_s2")},
     "a certificate needs uncertainties: write u_gravity_m_s2 under [environment], and solve again"),
    ({"environment": without(ENVIRONMENT, "gravity_m_s2", "u_gravity_m_s2")},
     "no coefficients in m/s2: its environment has no gravity_m_s2; write the local gravity, such as "
     "gravity_m_s2 = 9.81, under [environment] of the stand file, and solve again"),
]  # fmt: skip


@pytest.mark.parametrize(("labels", "said"), REFUSED)
def test_what_is_missing_is_asked_for(labels, said, tmp_path, capsys):
    file = tmp_path / "result.json"
    solved(**labels).save(file)
    assert main(["export", str(file), "--format", "dcc"]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"tumble: {file}: {said}"


@pytest.mark.parametrize(
    ("keys", "options", "said"),
    [
        ({"u_K": None, "u_U0": None}, {}, "a certificate needs uncertainties: solve with stand="),
        ({"unit": "g"}, {}, "outputs in g: a certificate has units of the SI, and this is none"),
        ({}, {"unit": "g"}, "a certificate has units of the SI: leave out the unit g"),
    ],
)
def test_what_is_no_certificate_is_refused(result, keys, options, said):
    with pytest.raises(tumble.BadInput, match=r"^result: ") as refused:
        changed(result, **keys).export("dcc", **options)
    assert str(refused.value) == f"result: {said}"


def test_there_is_no_place_for_further_terms(tmp_path):
    found = tumble.solve(noisy(tmp_path), stand=stand_with(), estimator="optimal", model="k2")
    with pytest.raises(tumble.BadInput, match="a certificate holds twelve coefficients, no K2"):
        found.export("dcc")
