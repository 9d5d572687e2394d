"""The register map of tumble-gateway as scripts find it, and the generator that writes it."""

import re
import shutil
import subprocess
import sys

import pytest
from gateway_bench import ROOT, registers
from test_gateway_registers import DICTIONARY, NODE, canopen, key, variable

pytestmark = pytest.mark.python

def test_the_table_for_scripts_names_every_register_once():
    rows = registers()
    for table in ("input", "holding", "setting"):
        places = [row["register"] + word for row in rows if row["table"] == table for word in range(row["words"])]
        assert table == "setting" or len(places) == len(set(places))
        names = [row["name"] for row in rows if row["table"] == table]
        assert len(names) == len(set(names)) > 0


def test_the_page_names_every_register_of_the_table_for_scripts():
    """In its own row, or in one for all that differ from it in their last part."""
    page = (ROOT / "docs/modbus.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+)(?:(?:-| to )(\d+))? \| \**([^|*]+?)\** \|", page, re.MULTILINE)
    told = {(number, name) for first, last, name in rows for number in range(int(first), int(last or first) + 1)}
    stems = {(number, re.sub(r"(\d+|[xyz]{1,2})( to \w+)?(?= \(scaled\)$|$)", "", name)) for number, name in told}
    for row in registers():
        place = row["register"]
        name, scaled, _ = row["name"].partition(" (scaled)")
        stem = re.sub(r"(\d+|[xyz]{1,2})$", "", name)
        assert {(place, row["name"]), (place, stem + scaled)} & (told | stems), row


def test_the_table_for_scripts_names_every_setting_as_the_dictionary_has_it():
    """All that the EDS lets an outsider write of node 1, but its communication,
    its commands and its picture of the drive."""
    rows = [row for row in registers() if row["table"] == "setting"]
    assert len({row["register"] for row in rows}) == len(rows) and all(0 < row["register"] < 65536 for row in rows)
    writable = {(item.index, item.subindex) for top in DICTIONARY.values()
                for item in ([top] if isinstance(top, canopen.objectdictionary.ODVariable) else top.values())
                if item.access_type in ("rw", "wo") and item.subindex
                and (item.index in (0x1010, 0x1011) or (item.index >= 0x2000 and item.index not in (0x2002, 0x2040)))}
    assert {key(row) for row in rows} == writable
    for row in rows:
        names = [one["name"] for one in NODE if key(one) == key(row)]
        assert names in ([], [row["name"]], [row["name"], f"{row['name']} (scaled)"])
        bits, real = int(row["type"][1:]), variable(row).data_type in canopen.objectdictionary.FLOAT_TYPES
        assert (bits, row["type"][0] == "f") == (len(variable(row)), real)


GENERATE = ROOT / "tools/objects/generate"
MISTAKES = [
    ("gateway.toml", "at = 2\n", "at = 1\n", "Modbus map: 'Magic word' and 'Map version' overlap at 1"),
    ("gateway.toml", '"Unit"', '"Node"', "Modbus map, input registers: the name Node is there twice"),
    ("gateway.toml", '"Result of"', '"Result"', "Modbus map, holding registers: the name Result is there twice"),
    ("gateway.toml", 'type = "u16"\n', 'type = "u8"\n', "gateway.toml: Map version: type is not one of u16,"),
    ("gateway.toml", "map_version = 1\n", "", "gateway.toml: must hold"),
    ("gateway.toml", "index = 0x1018", "index = 0x1019", "gateway.toml: no object 4121"),
    ("navcomp.toml", "modbus = { at = 110 }", "modbus = { at = 18 }", "an object lies among the gateway's own"),
    ("navcomp.toml", "modbus = { at = 110 }", "modbus = { at = 161 }", "'State: valid' and 'K: K_xx' overlap at 161"),
    ("navcomp.toml", "modbus = { at = 110 }", "modbus = { on = 110 }", "object 2000h: modbus may have the keys"),
    ("navcomp.toml", "modbus = { at = 110 }", "modbus = { scale = 1.0 }", "object 2000h: modbus needs at"),
    ("navcomp.toml", "modbus = { at = 110 }", "modbus = 110", "object 2000h: modbus has a value of the wrong type"),
    ("navcomp.toml", "scaled_at = 230, ", "", "object 2022h: modbus needs both scaled_at and scale, or neither"),
    ("navcomp.toml", "scale = 1e-9", "scale = 0", "object 2022h: modbus: scale is not above 0"),
    ("navcomp.toml", "marks = [1]", "marks = [11]", "object 2020h: modbus: marks what does not exist"),
    ("keeper.toml", "keys = [1, 3]", "keys = [1, 8]", "object 2160h: modbus: a key does not exist"),
    ("keeper.toml", "keys = [1, 3]", "kept = true", "object 2161h: modbus: with an object that has no keys"),
    ("keeper.toml", "keys = [1, 3]", "keys = [1], kept = true", "object 2160h: modbus: has two of keys, with and kept"),
    ("keeper.toml", "settings = 121", "settings = 111", "rest: Samples wanted' and 'History: Entry' are setting 111"),
    ("keeper.toml", "settings = 121", "settings = 0", "settings are not within 1 to 65535"),
    ("keeper.toml", "at = 1000, with", "at = 1000, settings = 7, with", "object 2151h: modbus: settings, and nothing"),
    ("navcomp.toml", "command = 0", "command = 1", "command objects: are not numbered from 0 on"),
    ("navcomp.toml", "modbus = { command = 0 }\n", "", "command objects: there is none"),
    ("navcomp.toml", "modbus = { at = 330 }", "modbus = { at = 65520 }", "Modbus map: ends beyond 65535"),
]  # fmt: skip


@pytest.mark.parametrize("table, old, new, message", MISTAKES, ids=[row[3][:40] for row in MISTAKES])
def test_a_mistake_in_the_tables_is_one_line(tmp_path, table, old, new, message):
    for path in GENERATE.parent.glob("*.toml"):
        shutil.copy(path, tmp_path)
    text = (tmp_path / table).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / table).write_text(text.replace(old, new, 1), encoding="utf-8")
    done = subprocess.run([sys.executable, GENERATE, "--check", "--tables", tmp_path], text=True, capture_output=True)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert message in done.stderr


@pytest.mark.parametrize("product", ["docs/modbus.md", "docs/modbus.csv", "host/gateway/registers.c"])
def test_a_new_key_makes_the_registers_stale(tmp_path, product):
    """The canary of the gate."""
    for path in GENERATE.parent.glob("*.toml"):
        shutil.copy(path, tmp_path)
    text = (tmp_path / "navcomp.toml").read_text(encoding="utf-8")
    (tmp_path / "navcomp.toml").write_text(text.replace("modbus = { at = 110 }", "modbus = { at = 1330 }"))
    done = subprocess.run([sys.executable, GENERATE, "--check", "--tables", tmp_path], text=True, capture_output=True)
    assert done.returncode == 1 and f"{product} is not what the tables say" in done.stderr
