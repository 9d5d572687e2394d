"""docs/schemas: a schema for every document that says which it is, found by that name; and documents of the programs.
Those of the command line are held against theirs where it is tested, node, stand and log in tests/realbus."""

import json
import re
import subprocess
import sys

import jsonschema
import pytest
from conftest import ROOT
from documents import SCHEMAS, document_of, schema, valid, validator
from schema_folder import BASE, faults
from simulated_bench import DRIVE_FAULT, QUICK, bench, scenario

from tumble import data
from tumble.documents import base
from tumble.documents.bench import Node, Stand, written
from tumble.watch.runs import FolderRun
from tumble.world.outcome import with_stand

pytestmark = pytest.mark.python
KINDS = sorted(path.name.split("-")[0].removeprefix("tumble.") for path in SCHEMAS.glob("*.json"))
SOURCES = ("host/world", "host/node", "host/programs", "host/stand", "host/python/src/tumble")


def test_nothing_is_wrong_with_them():
    assert faults() == []


def test_those_of_types_are_what_the_types_make(tmp_path):
    subprocess.run([sys.executable, ROOT / "tools/schemas.py", tmp_path], check=True)
    made = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert made and made == {name: (SCHEMAS / name).read_text() for name in made}


def test_no_type_harms_the_garbage_collector():
    """msgspec makes what reads a type when it is first used. A union of a float with limits and a tuple of a fixed
    length has made that such that the next collection crashed."""
    code = (
        "import gc, sys; sys.path.insert(0, sys.argv[1]); import schemas\n"
        "from tumble.documents.base import checked\n"
        "from tumble.errors import BadInput\n"
        "for name, (kind, _) in schemas.DOCUMENTS.items():\n"
        "    for one in kind.__subclasses__() or [kind]:\n"
        "        try: checked(one, name, {'schema': name}, 'f')\n"
        "        except BadInput: gc.collect(); print(name)\n"
    )
    done = subprocess.run([sys.executable, "-c", code, ROOT / "tools"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "") and len(done.stdout.split()) >= len(list(SCHEMAS.glob("*"))) // 2


def test_every_name_that_the_sources_write_has_one_and_no_other():
    """In C and in Python; a document says its name under "schema"."""
    written, name = set(), re.compile(r'(?:"schema"[,:] |[A-Z]+(?:: Final)? = )"(tumble\.\w+/\d+)"')
    for folder in SOURCES:
        for path in (ROOT / folder).rglob("*"):
            if path.suffix in (".c", ".py"):
                written |= set(name.findall(path.read_text()))
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


def on_a_real_bus(document):
    """What tumble-node and tumble-stand would say of the run of a simulated world."""
    of_stand = ("truth", "faults", "table")
    firmware = {name: value for name, value in document.items() if name not in of_stand}
    node = {**firmware, "schema": "tumble.node/1", "interface": "vcan0", "cause": None}
    own = {"angle_deg": 1.5, "operator": {"answers": 2, "refusals": 0}, "counters": {"sent": 9}}
    stand = {name: document[name] for name in ("seed", "virtual_s", *of_stand)}
    return node, {"schema": "tumble.stand/1", "interface": "vcan0", **stand, **own}


def test_documents_of_a_real_bus_alone_and_together(run, tmp_path):
    """What the programs say is valid and read, as is what becomes of both; watch shows the folder of either."""
    node, stand = on_a_real_bus(run[1])
    assert valid(json.dumps(node), "node") == node and valid(json.dumps(stand), "stand") == stand
    both = with_stand(base.checked(Node, "tumble.node/1", node, "n"), base.checked(Stand, "tumble.stand/1", stand, "s"))
    joined = valid(json.dumps(written(both)), "node")
    assert joined == {**node, **{name: stand[name] for name in ("truth", "faults", "table")},
                      "counters": {**node["counters"], "stand_sent": 9}}  # fmt: skip
    for name, document in (("bench.json", node), ("fault.json", joined)):
        (tmp_path / "bus.log").touch()
        (tmp_path / name).write_text(json.dumps(document))
        shown = FolderRun(tmp_path).snapshot()
        assert (shown.state, shown.over, shown.k_v_per_g) == ("DONE", True, tuple(map(tuple, node["K"])))
        (tmp_path / name).unlink()


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "run"
    return folder, bench(QUICK, seed=2, out=folder)


def required_of(kind, document):
    """Without any one of what its schema demands, the document is not valid."""
    spec = schema(kind)
    demanded = spec["required"]
    for key in demanded:
        with pytest.raises(jsonschema.ValidationError):
            validator(kind).validate({name: value for name, value in document.items() if name != key})
    assert len(demanded) > 5


def test_the_document_of_a_run(run):
    folder, document = run
    assert document["end"] == "done" and valid((folder / "bench.json").read_text(), "bench") == document
    assert set(document) == set(schema("bench")["properties"])
    required_of("bench", document)


def test_of_a_fault(tmp_path):
    bench(QUICK | {"fault": DRIVE_FAULT}, out=tmp_path / "run")
    document = valid((tmp_path / "run/bench.json").read_text(), "bench")
    assert (document["exit"], document["K"], document["faults"][0]["times"]) == (3, None, 1)


def test_the_document_of_a_replay(run, tumble):
    folder, found = run
    path = scenario(folder, **QUICK)
    shown = tumble("replay", folder / "bus.log", "--scenario", path, "--json")
    document = valid(shown.stdout, "replay")
    assert document["K"] == found["K"] and shown.returncode == 0
    for key in document:
        assert not validator("replay").is_valid({name: value for name, value in document.items() if name != key})


@pytest.mark.parametrize(("fault", "code"), [((), 0), ([DRIVE_FAULT], 3)])
def test_the_summary_of_a_campaign(fault, code, tumble, tmp_path):
    path = scenario(tmp_path, **QUICK, fault=list(fault))
    done = tumble("campaign", "runs", path, "--runs", 3, "--summary")
    document = valid(done.stdout, "campaign")
    assert (done.returncode, document["exits"][str(code)], document["runs"]) == (code, 3, 3)
    assert (document["K"]["mean_error"][0] is None) == (code == 3)
    required_of("campaign", document)


def test_a_campaign_of_hostile_lives(tumble):
    document = document_of(tumble("campaign", "lives", "--lives", 2), "hostile")
    assert document["runs"] == 2
    required_of("hostile", document)
