"""What the tools of others say of an EDS file: Lely's dcfchk and dcfgen, python-canopen; and CANopenEditor's rules."""

import configparser
import logging
import os
import re
import subprocess
import sys
import warnings
from datetime import datetime
from pathlib import Path

import pytest

NODES = {"navcomp": 1, "navcomp_without_sets": 1, "drive": 2, "block": 3}
EDS = {name: Path(__file__).resolve().parents[2] / f"docs/eds/tumble_{name}.eds" for name in NODES}
MASTER = 127
PLACE = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?")
ACCESSES = {"ro", "wo", "rw", "const", "rwr", "rww"}
COMMENT = "; "


def lely(program, *arguments, cwd=None):
    """A run of dcfchk or dcfgen; skips where dcf-tools is not installed."""
    package = {"dcfchk": "dcf", "dcfgen": "dcfgen"}[program]
    pytest.importorskip(package, reason="dcf-tools is not installed")
    quiet = {**os.environ, "PYTHONWARNINGS": "ignore:pkg_resources"}  # of a package that dcfgen is loaded with
    return subprocess.run([sys.executable, "-m", f"{package}.cli", *map(str, arguments)], cwd=cwd, env=quiet,
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120)


def dcfchk(path, node):
    """What it complains of; empty: it takes the file and has nothing to remark."""
    done = lely("dcfchk", "-n", node, path)
    return done.stderr if done.returncode == 0 else done.stderr or f"exit code {done.returncode}"


def dcfgen(folder, sheets):
    """Master's file of a network of {name: (EDS file, node)}, and what dcfgen complains of."""
    lines = ["options:", '  dcf_path: ""', "master:", f"  node_id: {MASTER}", "  baudrate: 500"]
    for name, (path, node) in sheets.items():
        lines += [f"{name}:", f'  dcf: "{path}"', f"  node_id: {node}"]
    (folder / "network.yml").write_text("\n".join(lines) + "\n")
    done = lely("dcfgen", "-r", "network.yml", cwd=folder)
    return folder / "master.dcf", done.stderr if done.returncode == 0 else done.stderr or f"exit {done.returncode}"


class _Records(logging.Handler):
    def __init__(self):
        super().__init__(logging.WARNING)
        self.said = []

    def emit(self, record):
        self.said.append(record.getMessage())


def canopen_faults(path, node):
    """Warnings and log records of python-canopen as it loads the file, and numbers that it takes for others."""
    canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
    handler = _Records()
    logging.getLogger("canopen").addHandler(handler)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            dictionary = canopen.import_od(str(path), node)
    finally:
        logging.getLogger("canopen").removeHandler(handler)
    faults = handler.said + [str(one.message) for one in caught]
    reals = canopen.objectdictionary.datatypes.FLOAT_TYPES
    for item in dictionary.values():
        variables = [item] if isinstance(item, canopen.objectdictionary.ODVariable) else item.values()
        for one in variables:
            if one.data_type in reals and (one.min, one.max) != (None, None):
                faults.append(f"{one.index:04X}sub{one.subindex:X}: bits of a real number taken for a whole one")
    return faults


def editor_faults(path):
    """By the rules of CANopenEditor (libEDSsharp, Parseline and ParseEDSentry): lines it understands, keys that it
    demands, types that it knows; every listed object is there and every object is listed."""
    lines = Path(path).read_text(encoding="ascii").splitlines()
    faults = [f"line {number}: neither section, key nor comment: {line}" for number, line in enumerate(lines, 1)
              if line and not line.startswith(COMMENT) and not re.match(r"\[[A-Za-z0-9]+\]$|[A-Za-z0-9_]+ *=", line)]
    try:
        parser = configparser.RawConfigParser(strict=True)
        parser.optionxform = str
        parser.read_string("\n".join(lines))
    except configparser.Error as error:  # a section or a key is there twice
        return [*faults, str(error)]
    return faults + _head_faults(parser) + _object_faults(parser) + _listing_faults(parser)


def _head_faults(parser):
    info, faults = parser["FileInfo"], []
    for kind in ("Creation", "Modification"):
        try:
            datetime.strptime(f"{info[f'{kind}Time']} {info[f'{kind}Date']}", "%I:%M%p %m-%d-%Y")
        except ValueError as error:
            faults.append(str(error))
    for key in ("FileVersion", "FileRevision"):
        faults += [] if info[key].isdigit() and int(info[key]) < 256 else [f"{key} is not a byte"]
    return faults


def _object_faults(parser):
    faults, seen = [], set()
    for section in filter(PLACE.fullmatch, parser.sections()):
        keys, kind = parser[section], int(parser[section].get("ObjectType", "0x7"), 0)
        index, sub = PLACE.fullmatch(section).groups()
        needed = {"ParameterName", *(("DataType", "AccessType") if kind == 7 else ("SubNumber",))}
        faults += [f"[{section}]: no {key}" for key in sorted(needed - set(keys))]
        faults += [f"[{section}]: no such ObjectType"] * (kind not in (7, 8, 9))
        faults += [f"[{section}]: unknown AccessType"] * (keys.get("AccessType", "ro") not in ACCESSES)
        faults += [f"[{section}]: stands before [{index}]"] * (sub is not None and index not in seen)
        faults += [f"[{section}]: not N+$NODEID or $NODEID+N"] * (not _of_a_node(keys.get("DefaultValue", "")))
        subs = [name for name in parser.sections() if name.startswith(f"{section}sub")] if sub is None else []
        faults += [f"[{section}]: SubNumber is not {len(subs)}"] * (len(subs) != int(keys.get("SubNumber", "0"), 0))
        seen.add(section)
    return faults


def _of_a_node(value):
    return "$" not in value or re.fullmatch(r"\$NODEID\+0x[0-9A-F]+|0x[0-9A-F]+\+\$NODEID", value) is not None


def _listing_faults(parser):
    faults, listed = [], []
    for group in ("Mandatory", "Optional", "Manufacturer"):
        keys = parser[f"{group}Objects"]
        names = [f"{int(keys[str(number)], 0):04X}" for number in range(1, int(keys["SupportedObjects"]) + 1)]
        faults += [f"{name} is listed and is not there" for name in names if name not in parser]
        listed += names
    objects = [name for name in parser.sections() if re.fullmatch("[0-9A-F]{4}", name)]
    return faults + [f"[{name}] is not listed once" for name in objects if listed.count(name) != 1]
