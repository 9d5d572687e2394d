"""What only a person at the stand can do, asked in lines that fit a terminal, and the answers."""

from __future__ import annotations

import sys
import textwrap

try:
    import termios
except ModuleNotFoundError:  # Windows
    termios = None  # type: ignore[assignment]

import numpy as np

from tumble import poses
from tumble.schedule import Mounting, Schedule

ABORT, DONE = "abort", "done"
_AXES = ("h (horizontal, across the axis)", "n (along the axis)", "v (up at table angle 0)")
_SEATED = "At table angle 0 deg, seen from the front (the block before the table):"
_TURNED = "At table angle {:g} deg, seen from the front (positive: counterclockwise):"
_STAYS = "The block stays bolted on as it is."
_WIDTH = 80


def mounting_text(mounting: Mounting) -> str:
    """How the block has to sit, as nearly as the axes of the table can tell."""
    parts = []
    for name, row in zip("xyz", np.array(mounting.matrix)):
        axis = int(np.argmax(np.abs(row)))
        nearly = "" if abs(row[axis]) > 0.999 else "nearly "
        parts.append(f"{name} {nearly}along {'-' if row[axis] < 0 else '+'}{_AXES[axis]}")
    return "; ".join(parts)


def inclining_text(mounting: Mounting) -> str:
    """What to do with the stand for an inclination of a block that is bolted on."""
    end = f", the {'far' if mounting.tilt_deg > 0.0 else 'near'} end of its axis up" if mounting.tilt_deg else ""
    angle = f"{mounting.tilt_deg:+g}" if mounting.tilt_deg else "0"
    return f"Incline the stand to about {angle} deg{end}, lock it, and confirm."


def to_mount(schedule: Schedule, number: int, on_table: int | None, answers: str) -> list[str]:
    """The block as a mounting says, or the stand inclined, when the mounting `on_table` was measured last."""
    by_number = {one.number: one for one in schedule.mountings}
    mounting, before = by_number[number], by_number.get(on_table or 0)
    is_bolted = before is not None and mounting.bolting is not None and before.bolting == mounting.bolting
    is_inclined = sum(one.bolting == mounting.bolting for one in schedule.mountings) > 1
    where = f"Mount the block as mounting {number} says: {mounting_text(mounting)}."
    todo = [_STAYS] if is_bolted else [where]
    todo += [inclining_text(mounting)] if mounting.bolting is not None and is_inclined else []
    turned = ["The table then turns to:", *poses.positions(schedule, mounting)]
    return asked(" ".join(todo), [_SEATED, *poses.sketch(mounting, 0.0), *turned], answers)


def to_turn(schedule: Schedule, number: int, angle_deg: float, answers: str) -> list[str]:
    """The table to an angle, with the block as the mounting of that number; 0: without one."""
    mounting = next((one for one in schedule.mountings if one.number == number), None)
    shown = [] if mounting is None else [_TURNED.format(angle_deg), *poses.sketch(mounting, angle_deg)]
    return asked(f"Turn the table to {angle_deg:g} degrees.", shown, answers)


def asked(question: str, shown: list[str], answers: str) -> list[str]:
    """A question, what is drawn of it, and its answers."""
    return [*_folded(question), *shown, *_folded(f"[{answers}]")]


def _folded(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, subsequent_indent="  ")


def read_answer() -> str:
    """A line of standard input in small letters, DONE for an empty one; its end is ABORT."""
    try:
        line = "" if sys.stdin is None else sys.stdin.readline()
    except (OSError, ValueError):  # a folder, a terminal that is gone, what is not text
        line = ""
    typed = " ".join(line.split()).lower()
    return ABORT if not line else typed or DONE


def forget_what_was_typed() -> None:
    """Before a question was put. Only of a terminal: a script may write all its answers at once."""
    if termios is not None and sys.stdin is not None and sys.stdin.isatty():
        termios.tcflush(sys.stdin, termios.TCIFLUSH)
