"""docs/schemas: a schema for every document that says which it is, found by that name; and documents of the programs.
Those of the command line are held against theirs where it is tested, node, stand and log in tests/realbus."""

import json
import re

import jsonschema
import pytest
from bench_program import bench, scenario
from conftest import ROOT
from documents import SCHEMAS, schema, valid, validator
from schema_folder import BASE, faults

from tumble import data

pytestmark = pytest.mark.python
KINDS = sorted(path.name.split("-")[0].removeprefix("tumble.") for path in SCHEMAS.glob("*.json"))
SOURCES = ("host/bench", "host/gateway", "boards/linux", "host/python/src/tumble")
QUICK = {"motion__settling_s": 0.05, "motion__speed_deg_s": 720, "motion__acceleration_deg_s2": 7200,
         "procedure__settle_ms": 100, "procedure__samples": 10, "operator__mount_s": 0.1}


def test_nothing_is_wrong_with_them():
    assert faults() == []


def test_every_name_that_the_sources_write_has_one_and_no_other():
    """In C and in Python; a document says its name under "schema"."""
    written = set()
    for folder in SOURCES:
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in (".c", ".py"):
                written |= set(re.findall(r'(?:"schema", |[A-Z]+ = )"(tumble\.\w+/\d+)"', path.read_text()))
    assert written == {f"tumble.{kind}/1" for kind in KINDS}


@pytest.mark.parametrize("kind", KINDS)
def test_a_name_leads_to_its_schema(kind):
    name = f"tumble.{kind}/1"
    path = data.schema(name)
    assert json.loads(path.read_text())["$id"] == data.SCHEMAS + name == BASE + name
    assert f"schemas/{path.name}" in data.names()


@pytest.mark.parametrize("name", ["tumble.result/2", "result", "", "../eds/tumble_block.eds"])
def test_no_other_name_does(name):
    with pytest.raises(FileNotFoundError):
        data.schema(name)


@pytest.mark.parametrize("kind", KINDS)
def test_a_schema_would_notice_what_is_not_there(kind):
    """Not of a document of nothing, and not of one of another kind."""
    other = next(one for one in KINDS if one != kind)
    for document in ({}, {"schema": f"tumble.{kind}/1"}, {"schema": f"tumble.{other}/1"}):
        assert not validator(kind).is_valid(document)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    path = scenario(folder, **QUICK)
    done = bench(path, "--seed", 2, "--out", folder / "run")
    return folder / "run", path, done


def required_of(kind, document):
    """Without any one of what its schema demands, the document is not valid."""
    spec = schema(kind)
    demanded = {*spec.get("required", []), *spec.get("$defs", {}).get("firmware", {}).get("required", [])}
    for key in demanded:
        with pytest.raises(jsonschema.ValidationError):
            validator(kind).validate({name: value for name, value in document.items() if name != key})
    assert len(demanded) > 5


def test_the_document_of_tumble_bench(run):
    folder, _, done = run
    document = valid(done.stdout, "bench")
    assert document["end"] == "done" and valid((folder / "bench.json").read_text(), "bench") == document
    required_of("bench", document)


def test_of_a_fault(tmp_path):
    path = scenario(tmp_path, **QUICK, fault="drive_fault at=1.5 phase=move delay=0.05 value=30001")
    done = bench(path, "--out", tmp_path / "run")
    document = valid(done.stdout, "bench")
    assert done.returncode == 3 and document["K"] is None and document["faults"][0]["times"] == 1


def test_the_document_of_a_replay(run, tumble):
    folder, path, done = run
    shown = tumble("replay", folder / "bus.log", "--scenario", path, "--json")
    document = valid(shown.stdout, "replay")
    assert document["K"] == json.loads(done.stdout)["K"] and shown.returncode == 0
    for key in document:
        assert not validator("replay").is_valid({name: value for name, value in document.items() if name != key})


@pytest.mark.parametrize("faulty", [False, True])
def test_the_summary_of_runs(tmp_path, faulty):
    faults_ = {"fault": "drive_fault at=1.5 phase=move delay=0.05 value=30001"} if faulty else {}
    done = bench(scenario(tmp_path, **QUICK, **faults_), "--runs", 2, "--jobs", 1, "--summary")
    document = valid(done.stdout, "campaign")
    assert document["exits"] == ({"0": 0, "1": 0, "3": 2} if faulty else {"0": 2, "1": 0, "3": 0})
    required_of("campaign", document)


def test_a_campaign_of_hostile_lives():
    done = bench("--campaign", 2, "--seed", 1, "--jobs", 1)
    document = valid(done.stdout, "hostile")
    assert document["runs"] == 2
    required_of("hostile", document)

