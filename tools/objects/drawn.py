"""What the drawings of `tumble draw` show of firmware and bus: states and ways of a run, nodes and identifiers."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import run_table
from headers import headers_of
from model import Node, Pdo
from standard import PDO_INVALID

HEAD = '''"""States of a run, nodes of the bus. Written by tools/objects/generate from firmware and object tables;
not to be edited."""

from __future__ import annotations

'''
BLOCK = 3  # the node that sends samples, which are no PDOs
SAMPLES = ("TUMBLE_BLOCK_ID_XY", "TUMBLE_BLOCK_ID_Z")
SERVICES = ("TUMBLE_EMCY_ID", "TUMBLE_SDO_RESPONSE_ID", "TUMBLE_SDO_REQUEST_ID", "TUMBLE_HEARTBEAT_ID")  # + node


def module(root: Path, nodes: list[Node]) -> str:
    """tumble/firmware_tables.py."""
    states = run_table.states(root)
    return HEAD + "\n".join([
        "STATES = {  # name: what it does", *(f"    {text(name)}: {text(said)}," for name, said in states),
        "}", "", "WAYS = (  # from, to, by what, when", *(row(way) for way in run_table.ways(root)), ")", "",
        "NODES = (  # number, name, emergency, SDO answer, SDO request, heartbeat",
        *(row((node.id, node.settings["name"], *services(root, node.id))) for node in nodes),
        ")", "", "PROCESS_DATA = {  # node: identifiers of its PDOs, that it hears and that it sends",
        *(f"    {node.id}: ({numbers(identifiers(node.receive, node))}, {numbers(identifiers(node.transmit, node))}),"
          for node in nodes),
        "}", "", f"SAMPLES = {numbers([headers_of(root).value(name) for name in SAMPLES])}  # of node {BLOCK}", "",
        f"HEARTBEAT_MS = {max(node.settings['heartbeat_ms'] for node in nodes)}",
        f"CONSUMER_MS = {max(limit for node in nodes for _, limit in node.settings['consumers'])}", "",
    ])


def services(root: Path, node: int) -> list[int]:
    return [headers_of(root).value(name) + node for name in SERVICES]


def identifiers(pdos: list[Pdo], node: Node) -> list[int]:
    """Of those that are in use; the node's number is added where CiA 301 has it added."""
    used = [pdo.cob_id for pdo in pdos if not pdo.cob_id & PDO_INVALID]
    return [cob_id if cob_id & 0x7F else cob_id + node.id for cob_id in used]


def row(fields: Iterable[object]) -> str:
    return f"    ({', '.join(text(field) if isinstance(field, str) else str(field) for field in fields)}),"


def numbers(values: list[int]) -> str:
    return f"({', '.join(map(str, values))}{',' if len(values) == 1 else ''})"


def text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False)
