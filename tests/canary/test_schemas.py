"""Planted defects of a folder of schemas, which must be found; docs/schemas itself is accepted."""

import shutil
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/lib"))

from documents import SCHEMAS
from schema_folder import faults

NODE, BENCH = "tumble.node-1.schema.json", "tumble.bench-1.schema.json"
DEFECTS = {  # name: (file, what is replaced, by what, what must be said)
    "an $id twice": (NODE, '/tumble.node/1"', '/tumble.bench/1"', "tumble.invalid/tumble.bench/1 is the $id of two"),
    "no $id": (NODE, '"$id"', '"id"', f"{NODE}: $id is not https://schemas.tumble.invalid/tumble.node/1"),
    "another document's name": (NODE, '"const": "tumble.node/1"', '"const": "tumble.node/2"', 'is not tumble.node/1'),
    "a reference to nobody": (NODE, '"#/$defs/Mean"', '"#/$defs/Meter"', "$defs/Meter leads nowhere"),
    "a reference to the network": (NODE, '"#/$defs/Mean"', '"https://example.org/bench#/$defs/Mean"', "leads nowhere"),
    "another draft": (BENCH, "2020-12", "2019-09", f"{BENCH}: $schema is not"),
    "a type that is none": (BENCH, '"type": "boolean"', '"type": "flag"', f"{BENCH}: not valid: 'flag'"),
}  # fmt: skip


def test_accepts_the_folder_itself():
    assert faults() == []


@pytest.mark.parametrize("name", DEFECTS)
def test_rejects(name, tmp_path):
    file, old, new, message = DEFECTS[name]
    shutil.copytree(SCHEMAS, tmp_path / "schemas")
    text = (tmp_path / "schemas" / file).read_text()
    assert old in text
    (tmp_path / "schemas" / file).write_text(text.replace(old, new))
    assert message in "\n".join(faults(tmp_path / "schemas"))
