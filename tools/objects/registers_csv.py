"""From the map of Modbus registers to docs/modbus.csv."""

from __future__ import annotations

from registers import Map, Register, Setting

CSV_HEAD = "table,register,words,type,scale,access,unit,index,subindex,valid_register,valid_bit,name"


def csv(registers: Map) -> str:
    """What scripts read: registers by number from 0; numbers of more than one word have the high word first. Behind
    them the settings by theirs."""
    rows = [csv_row(register) for register in [*registers.input, *registers.holding]]
    return "\n".join([CSV_HEAD, *rows, *(setting_row(setting) for setting in registers.settings)]) + "\n"


def csv_row(register: Register) -> str:
    entry = register.entry
    return joined([register.table, register.at, register.words, register.type, register.scale, register.access,
                   register.unit, f"{entry.index:04X}" if entry else None, entry.subindex if entry else None,
                   register.validity, register.bit, register.name])


def setting_row(setting: Setting) -> str:
    entry = setting.entry
    return joined(["setting", setting.number, 4, entry.type.key, None, entry.access, entry.unit, f"{entry.index:04X}",
                   entry.subindex, None, None, setting.name])


def joined(cells: list[object]) -> str:
    return ",".join("" if cell is None else quoted(str(cell)) for cell in cells)


def quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"') else text
