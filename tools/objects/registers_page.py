"""From the map of Modbus registers to docs/modbus.md."""

from __future__ import annotations

from kinds import Entry
from page import cell, families, family_name, span
from registers import OF_SCALED, Map, Register, Setting

HEAD = """\
# Modbus registers

<!-- Written by tools/objects/generate: change tools/objects/*.toml instead. -->

This page lists the registers that `tumble-gateway` serves, version {version} of the map. [gateway.md](gateway.md) says
how the gateway behaves; [modbus.csv](modbus.csv) is the same table for scripts.

- Registers are numbered from 0, as on the wire. For a tool that counts from 1, add 1.
- Input registers are read with function 04, holding registers with 03 and written with 06 or 16. Nothing else is
  served. A request may have up to 125 registers (16: up to 123) and may span registers that the table does not name:
  they read as 0.
- **Order of words and bytes**: big-endian throughout. A number of two or four registers has its high word first (ABCD).
  Texts have two characters in a register, the first in its high byte, and end in zeros. If you read the magic word as
  5455 4D42h and the known number as 123456.0, your order is right.
- **Unknown values**: each group begins with a register of validity bits: bit n is set if value n (from 0, in the order
  of the table) is known. Where the bit is 0 the value is 0 and means nothing: there is no result yet, the node refused
  it, or it does not fit the registers. No value is ever infinite or not a number.
- **Scaled numbers**: multiply the i32 by the scale. They resolve more than f32 does: 1e-8 V/g of 2 V/g against 1.2e-7.
- Neighbours that differ only in a number or an axis share a row here, matrices row by row; in modbus.csv each has a row
  of its own.
- In modbus.csv the column `table` says what a row is: an `input` or `holding` register, or a `setting`, with its number
  in the column `register`, the type of its object, and the same names as the registers have.
"""

SETTINGS = """\
To write a setting, stage its number in register {setting} and its value, an f64, in {value}; Execute writes it. The
type of the object must be able to hold the value: a whole number within the type's range, or a finite number, which is
rounded for an f32. The object says what else is allowed ([canopen.md](canopen.md)); the node refuses the rest. A
setting of level `service` is sent only for the session that has opened the service level: the one that wrote the key,
setting {key}, last ([client.md](client.md#the-service-level)).
"""


def page(registers: Map) -> str:
    lines = [HEAD.format(version=registers.version), "## Input registers", "", "### The gateway's own", ""]
    lines += own_table([register for register in registers.input if register.at < registers.gateway])
    lines += ["", "### The node's", "", "Objects and subindices are those of [canopen.md](canopen.md), which says what "
              "they mean; `valid` is register and bit.", ""]
    lines += ["| register | name | type | unit | object | valid |", "|---|---|---|---|---|---|"]
    own = [register for register in registers.input if register.at >= registers.gateway]
    lines += [node_row(alike) for alike in families(own, plain_name, register_columns)]
    lines += ["", "## Holding registers", "", "Written only with `--allow-commands`, in a session that is unlocked."]
    lines += [""]
    lines += own_table(registers.holding)
    lines += ["", "Command objects:", "", "| number | object | name |", "|---|---|---|"]
    lines += [f"| {number} | {item.index:04X}h | {item.name} |" for number, item in enumerate(registers.commands)]
    places = {one.name: one.place for one in registers.holding}
    lines += ["", SETTINGS.format(setting=places["Setting"], value=places["Value"], key=registers.service_key.number)]
    lines += ["| number | name | type | unit | object | level |", "|---|---|---|---|---|---|"]
    lines += [setting_row(alike) for alike in families(registers.settings, lambda one: one.name, setting_columns)]
    lines += ["", f"A snapshot is published only if these were the same before and after it was read: "
              f"{listed(registers.marks)}. The same holds of what selects values that it reads anew: "
              f"{listed(selectors(registers))}."]
    return "\n".join(lines) + "\n"


def selectors(registers: Map) -> list[Entry]:
    return [entry for entry in map(registers.selector, range(registers.groups)) if entry]


def listed(entries: list[Entry]) -> str:
    return ", ".join(f"{entry.name} ({entry.where})" for entry in entries)


def setting_row(alike: list[Setting]) -> str:
    first, entries = alike[0], [setting.entry for setting in alike]
    return (f"| {span([str(one.number) for one in alike])} | {cell(family_name([one.name for one in alike]))} "
            f"| {first.entry.type.key} | {cell(first.entry.unit)} | {objects(entries)} | {first.entry.level or ''} |")


def setting_columns(setting: Setting) -> tuple:
    entry = setting.entry
    return setting.number, (setting.number - entry.subindex, entry.index, entry.type.key, entry.unit, entry.level)


def objects(entries: list[Entry]) -> str:
    """Subindices of one object."""
    return span([entries[0].where, *(f":{entry.subindex}" for entry in entries[1:])])


def own_table(registers: list[Register]) -> list[str]:
    lines = ["| register | name | type | unit | access | meaning |", "|---|---|---|---|---|---|"]
    return lines + [f"| {one.place} | {one.name} | {number(one)} | {one.unit} | {one.access} | {cell(one.about)} |"
                    for one in registers]


def node_row(alike: list[Register]) -> str:
    first, last = alike[0], alike[-1]
    if first.entry is None:
        return f"| {first.place} | **{cell(first.name)}** | bits | | | |"
    place = first.place if first is last else f"{first.at}-{last.end - 1}"
    valid = span([f"{first.validity}.{first.bit}", *(f".{one.bit}" for one in alike[1:])])
    name = family_name([plain_name(one) for one in alike]) + first.name[len(plain_name(first)):]
    return (f"| {place} | {cell(name)} | {number(first)} | {cell(first.unit)} "
            f"| {objects([one.entry for one in alike])} | {valid} |")


def plain_name(register: Register) -> str:
    return register.name.removesuffix(OF_SCALED)


def register_columns(register: Register) -> tuple:
    """The place among the values of its object, and what else a row says."""
    entry = register.entry
    if entry is None:
        return register.at, None
    rest = register.bit - entry.subindex, entry.index, number(register), register.unit, register.validity
    return register.bit, rest


def number(register: Register) -> str:
    return register.type if register.scale is None else f"{register.type} x {register.scale:g}"
