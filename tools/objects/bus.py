"""Every message of the bus, from the nodes' tables, the drive profile, firmware/'s headers and bus.toml."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from headers import headers_of
from kinds import Entry, TableError
from model import Node, Pdo, read_toml
from rules import check, slug
from standard import PDO_INVALID

PROFILE = "firmware/navcomp/standard.c"
MASTER, DRIVE = 1, 2
NODE_BITS = 0x7F


@dataclass
class Signal:
    """Little endian. `values`: a name for each number; `of`: of a selector's values those at which it is there."""

    name: str
    first: int
    bits: int
    signed: bool = False
    unit: str = ""
    about: str = ""
    values: dict[int, str] = field(default_factory=dict)
    of: tuple[int, ...] = ()
    selects: bool = False


@dataclass
class Message:
    identifier: int
    name: str
    size: int
    sender: str
    receivers: list[str]
    about: str
    signals: list[Signal]
    cycle_ms: int = 0


@dataclass
class Bus:
    senders: list[str]
    messages: list[Message]


def read(path: Path, nodes: list[Node], root: Path) -> Bus:
    """Raises TableError."""
    table = read_toml(path)
    for service in ("nmt", "heartbeat", "emcy", "sdo_request", "sdo_response", "second_sdo_server"):
        check(isinstance(table.get(service), dict), path.name, f"needs [{service}]")
    messages = _Messages(table, nodes, root)
    found = [*messages.services(), *messages.process_data()]
    identifiers = [message.identifier for message in found]
    for message in found:
        check(identifiers.count(message.identifier) == 1, path.name, f"{message.identifier:03X}h is there twice")
        check_bits(message, path.name)
    return Bus([*messages.names.values(), table["outsider"]], sorted(found, key=lambda one: one.identifier))


def check_bits(message: Message, where: str) -> None:
    """No bit of a message is left over, none is two things at once."""
    selector = next((signal for signal in message.signals if signal.selects), None)
    for value in range(1 << selector.bits) if selector else [0]:
        there = [signal for signal in message.signals if not signal.of or value in signal.of]
        bits = sorted(bit for signal in there for bit in range(signal.first, signal.first + signal.bits))
        check(bits == list(range(8 * message.size)), where, f"{message.name}: not every bit is of one signal")


class _Messages:
    def __init__(self, table: dict, nodes: list[Node], root: Path):
        self.table, self.nodes, self.root = table, nodes, root
        self.headers = headers_of(root)
        self.names = {node.id: node.settings["name"].upper() for node in nodes}
        self.words = {word["index"]: word["bits"] for word in table["word"]}

    def services(self) -> list[Message]:
        nmt = self.headers.value("TUMBLE_NMT_ID")
        found = [self.service("nmt", nmt, "NMT", self.names[MASTER], size=2)]
        for node in self.nodes:
            name = self.names[node.id]
            emcy, heartbeat = (self.headers.value(f"TUMBLE_{one}_ID") + node.id for one in ("EMCY", "HEARTBEAT"))
            found.append(self.service("emcy", emcy, f"{name}_EMCY", name, size=8))
            found.append(self.service("heartbeat", heartbeat, f"{name}_HEARTBEAT", name, size=1))
            found[-1].cycle_ms = node.settings["heartbeat_ms"]
            ids = [self.headers.value(f"TUMBLE_SDO_{one}_ID") + node.id for one in ("REQUEST", "RESPONSE")]
            found += self.server(f"{name}_SDO", name, ids, "")
        second = self.table["second_sdo_server"]
        name, node = self.names[second["node"]], second["node"]
        ids = [second["request"] + node, second["response"] + node]
        return found + self.server(f"{name}_SDO_2", name, ids, f" {second['about']}")

    def server(self, name: str, server: str, identifiers: list[int], further: str) -> list[Message]:
        outsider = self.table["outsider"]
        client = self.names[MASTER] if server == self.names[DRIVE] else outsider
        pair = [self.service("sdo_request", identifiers[0], f"{name}_REQUEST", client, size=8),
                self.service("sdo_response", identifiers[1], f"{name}_RESPONSE", server, size=8)]
        for message in pair:
            message.about += further
        return pair

    def service(self, key: str, identifier: int, name: str, sender: str, size: int) -> Message:
        table = self.table[key]
        signals = [self.signal(row) for row in table["signals"]]
        if "selector" in table:
            signals.insert(0, self.signal(table["selector"]))
            signals[0].selects = True
        return Message(identifier, name, size, sender, self.others(sender), table["about"], signals)

    def signal(self, row: dict) -> Signal:
        names = {int(number): text for number, text in row.get("values", {}).items()}
        for constant in row.get("codes", []):
            names[self.headers.value(constant)] = slug(constant.removeprefix("TUMBLE_").replace("EMCY_", ""))
        return Signal(row["name"], *row["at"], about=row.get("about", ""), values=names, of=tuple(row.get("of", ())))

    def others(self, sender: str) -> list[str]:
        return [name for name in [*self.names.values(), self.table["outsider"]] if name != sender]

    def process_data(self) -> list[Message]:
        """The drive's as the profile has them, with the computer as the other end; those of the others as they are."""
        found = []
        for node in self.nodes:
            if node.id == DRIVE:
                found += [self.of_profile(node, kind) for kind in ("receive", "transmit")]
                continue
            for number, pdo in enumerate(node.transmit, 1):
                if not pdo.cob_id & PDO_INVALID:
                    identifier = pdo.cob_id if pdo.cob_id & NODE_BITS else pdo.cob_id + node.id
                    found.append(self.pdo(node, f"TPDO{number}", identifier, pdo))
        return found

    def of_profile(self, drive: Node, kind: str) -> Message:
        name = self.table[f"{kind}_profile"]
        text = (self.root / PROFILE).read_text(encoding="utf-8")
        body = re.search(rf"tumble_drive_pdo_t {name}\[\] = \{{(.*?)\n\}};", text, re.DOTALL)
        check(body is not None and body[1].count(".cob_id") == 1, PROFILE, f"{name} is not one PDO")
        identifier = int(re.search(r"\.cob_id = (\w+)", body[1])[1], 0)
        event = re.search(r"\.event_ms = (\d+)", body[1])
        keys = [(int(index, 0), int(sub)) for index, sub in re.findall(r"TUMBLE_MAP\((\w+), (\d+),", body[1])]
        entries = {(entry.index, entry.subindex): entry for entry in drive.entries}
        pdo = Pdo(identifier, 255, 0, int(event[1]) if event else 0, [entries[key] for key in keys])
        return self.pdo(drive, "RPDO1" if kind == "receive" else "TPDO1", identifier, pdo)

    def pdo(self, node: Node, kind: str, identifier: int, pdo: Pdo) -> Message:
        own = self.names[node.id]
        sender = self.names[MASTER] if kind[0] == "R" else own
        signals: list[Signal] = []
        for entry in pdo.map:
            signals += self.mapped(node, entry, sum(signal.bits for signal in signals))
        said = ", ".join(f"{self.name(node, entry)} ({entry.where})" for entry in pdo.map)
        only = f" {node.extension['only'].split(' (')[0]}." if pdo.further else ""
        return Message(identifier, f"{own}_{kind}", sum(signal.bits for signal in signals) // 8, sender,
                       self.others(sender), f"{said}.{only}", signals, pdo.event_ms)

    def mapped(self, node: Node, entry: Entry, first: int) -> list[Signal]:
        if entry.index in self.words:
            bits = [self.signal(row) for row in self.words[entry.index]]
            for bit in bits:
                bit.first += first
            return bits
        check(entry.type.is_integer, node.path.name, f"{entry.where} in a PDO is no whole number")
        item = next(item for item in node.objects if item.index == entry.index)
        names = node.lists.get(item.values or "", [])
        values = {number: slug(name.removeprefix(f"{item.values}_")) for number, (name, _) in enumerate(names)}
        return [Signal(slug(self.name(node, entry)), first, 8 * entry.size, entry.type.key[0] == "i", entry.unit,
                       entry.about, values if item.is_var else {})]

    def name(self, node: Node, entry: Entry) -> str:
        item = next((item for item in node.objects if item.index == entry.index), None)
        if item is None:
            raise TableError(f"{node.path.name}: {entry.where} is mapped and is not there")
        return item.name if item.is_var else entry.name
