"""From the messages of the bus to docs/bus/tumble.dbc; the block's frames come from docs/bus/block.dbc."""

from __future__ import annotations

import re
from pathlib import Path

from bus import Bus, Message, Signal

BLOCK = "docs/bus/block.dbc"
HEAD = """VERSION "1"

NS_ :

BS_:

BU_: {senders}

"""
ABOUT = "The whole bus: services of CiA 301, process data, the frames of the block. Written by tools/objects/generate."
TAIL = """BA_DEF_ BO_ "GenMsgCycleTime" INT 0 65535;
BA_DEF_DEF_ "GenMsgCycleTime" 0;
"""


def text(bus: Bus, root: Path) -> str:
    block = (root / BLOCK).read_text(encoding="utf-8")
    parts = [HEAD.format(senders=" ".join(bus.senders)), *(message_lines(one) for one in bus.messages)]
    parts += [match[0] for match in re.finditer(r"^BO_ .*?\n\n", block, re.MULTILINE | re.DOTALL)]
    comments = [f'CM_ "{ABOUT}";', *(line for one in bus.messages for line in comment_lines(one))]
    parts.append("\n".join([*comments, *lines_of(block, r"CM_ (?:BO_|SG_) .*"), "", ""]))
    cycles = [f'BA_ "GenMsgCycleTime" BO_ {one.identifier} {one.cycle_ms};' for one in bus.messages if one.cycle_ms]
    parts.append(TAIL + "\n".join([*cycles, *lines_of(block, "BA_ .*"), "", ""]))
    names = [line for one in bus.messages for line in value_lines(one)]
    parts.append("\n".join([*names, *lines_of(block, "VAL_ .*"), "", ""]))
    ranges = [line for one in bus.messages for line in range_lines(one)]
    return "".join(parts) + "\n".join([*ranges, ""])


def lines_of(block: str, pattern: str) -> list[str]:
    return re.findall(f"^{pattern}$", block, re.MULTILINE)


def message_lines(message: Message) -> str:
    head = f"BO_ {message.identifier} {message.name}: {message.size} {message.sender}"
    receivers = ",".join(message.receivers)
    return "\n".join([head, *(signal_line(signal, receivers) for signal in message.signals), "", ""])


def signal_line(signal: Signal, receivers: str) -> str:
    place = " M" if signal.selects else f" m{signal.of[0]}" if signal.of else ""
    low = -(1 << signal.bits - 1) if signal.signed else 0
    high = (1 << signal.bits - signal.signed) - 1
    sign = "-" if signal.signed else "+"
    return (f" SG_ {signal.name}{place} : {signal.first}|{signal.bits}@1{sign} (1,0) [{low}|{high}] "
            f'"{signal.unit}" {receivers}')


def comment_lines(message: Message) -> list[str]:
    said = [f'CM_ SG_ {message.identifier} {one.name} "{quoted(one.about)}";' for one in message.signals if one.about]
    return [f'CM_ BO_ {message.identifier} "{quoted(message.about)}";', *said]


def quoted(words: str) -> str:
    return words.replace('"', "'")


def value_lines(message: Message) -> list[str]:
    return [f"VAL_ {message.identifier} {signal.name} "
            + " ".join(f'{number} "{name}"' for number, name in sorted(signal.values.items())) + " ;"
            for signal in message.signals if signal.values]


def range_lines(message: Message) -> list[str]:
    """Of signals that are there at more than one value of the selector."""
    selector = next((signal.name for signal in message.signals if signal.selects), None)
    return [f"SG_MUL_VAL_ {message.identifier} {one.name} {selector} {', '.join(f'{n}-{n}' for n in one.of)};"
            for one in message.signals if len(one.of) > 1]
