"""Numbers of the firmware's lists as names: states, reasons, objections, verdicts, commands."""

from __future__ import annotations

from dataclasses import dataclass

from tumble.client.tables import COMMANDS, OBJECTIONS, REASONS, STAND_STEPS, VERDICTS
from tumble.firmware_tables import STATES

COMMAND = {row[0]: number for number, row in enumerate(COMMANDS)}
STATE_NAMES = tuple(STATES)
STAND_STATES = ("offline", "not homed", "homing", "moving", "in position", "stopped", "in fault")  # 2003h:12


@dataclass(frozen=True)
class Reason:
    """Why a run stopped (2001h). `name`: as in `TUMBLE_REASON_...`. `remedy`: what to check (docs/operations.md)."""

    number: int
    name: str
    meaning: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.name}, {self.meaning}. Remedy: {self.remedy}" if self.number else "nothing is wrong"


@dataclass(frozen=True)
class Objection:
    """Why a result is held. `name`: as in `TUMBLE_OBJECTION_...`; `remedy`: what to do (docs/operations.md)."""

    bit: int
    name: str
    meaning: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.name}, {self.meaning}"


def command(number: int) -> str:
    """The name of a number of 2002h:2."""
    return COMMANDS[number][0] if number < len(COMMANDS) else f"command {number}"


def reason(number: int) -> Reason:
    """The reason of a number of 2001h. One that only newer firmware has is named by its number."""
    if number < len(REASONS):
        return Reason(number, *REASONS[number])
    return Reason(number, f"REASON_{number}", "not in the list of this version of tumble", "See the node's own manual.")


def objections(bits: int) -> tuple[Objection, ...]:
    """The objections of the bits of 2120h:6 and 15, or of 2102h:13."""
    known = [Objection(bit, *row) for bit, row in enumerate(OBJECTIONS) if bits >> bit & 1]
    further = [bit for bit in range(len(OBJECTIONS), bits.bit_length()) if bits >> bit & 1]
    unknown = ("not in the list of this version of tumble", "Do not accept.")
    return (*known, *(Objection(bit, f"OBJECTION_{bit}", *unknown) for bit in further))


def abort_code(code: int) -> str:
    """An SDO abort code as CiA 301 writes it."""
    return f"{code >> 16:04X} {code & 0xFFFF:04X}h"


def drive_refusal(index: int, subindex: int, code: int, step: int) -> str:
    """What the drive refused or did not do in time (2004h:6 to 2004h:9); "" for nothing."""
    if not index:
        return ""
    what = STAND_STEPS.get(step, f"step {step}")
    return f"drive object {index:04X}h:{subindex}, abort {abort_code(code)}, in {what}"


def state(number: int) -> str:
    """The name of a number of 2000h."""
    return STATE_NAMES[number] if number < len(STATE_NAMES) else f"STATE_{number}"


def stand(number: int) -> str:
    """The name of a number of 2003h:12."""
    return STAND_STATES[number] if number < len(STAND_STATES) else f"in state {number}"


def verdict(number: int | None) -> str | None:
    """The name of a number of 2120h:7; None if the node keeps no coefficients."""
    if number is None:
        return None
    return VERDICTS[number][0] if number < len(VERDICTS) else f"VERDICT_{number}"
