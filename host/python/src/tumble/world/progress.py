"""Progress of a bench run, told to a person on stderr; and the questions that only a person can answer."""

from __future__ import annotations

import sys
import textwrap
from typing import Any

try:
    import termios
except ModuleNotFoundError:  # Windows
    termios = None  # type: ignore[assignment]

import numpy as np

from tumble import poses
from tumble.messages import tell
from tumble.schedule import Mounting, Schedule

_AXES = ("h (horizontal, across the axis)", "n (along the axis)", "v (up at table angle 0)")
_HELP = "Enter or done: it is done; leave: do nothing; abort: stop here"
_HELP_FAULT = (
    "Enter or done: mended, go on; leave: do nothing; abort: stop here; repeat position INDEX; repeat mounting NUMBER"
)
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


def in_words(state: str) -> str:
    """A state of the firmware by its name."""
    return state.removeprefix("TUMBLE_STATE_").lower().replace("_", " ")


class Progress:
    """Told every event of a run; one line on stderr whenever another mounting begins. Base of the live display."""

    def __init__(self, schedule: Schedule, interactive: bool):
        self._schedule = schedule
        self._interactive = interactive
        self._mounting = 0
        self._on_table = 0  # mounting that was measured last

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def __call__(self, event: dict[str, Any]) -> str | None:
        """Take an event. Returns the answer if it is a question for a person."""
        kind = event["event"]
        if event.get("state") == "TUMBLE_STATE_AVERAGE":
            self._on_table = event["mounting"]
        if kind == "state":
            self.on_state(event)
        elif kind == "average":
            self.on_average(event)
        elif kind == "question" and self._interactive:
            return self.ask(event)
        elif kind == "refused":
            _forget_what_was_typed()
            self.say(f"not accepted: {event['what']}")
            return self.read_answer()
        return None

    def on_state(self, event: dict[str, Any]) -> None:
        """The procedure is in another state."""
        if event["state"] == "TUMBLE_STATE_AVERAGE" and event["mounting"] != self._mounting:
            self._mounting = event["mounting"]
            place = f"position {event['finished'] + 1} of {event['count']}"
            self.say(f"mounting {self._mounting}: {place}, {event['virtual_s']:.0f} s")

    def on_average(self, event: dict[str, Any]) -> None:
        """A position's running mean."""

    def say(self, line: str) -> None:
        """One line."""
        tell(line)

    def ask(self, event: dict[str, Any]) -> str:
        """Put a question, return the answer as the program takes it. What was typed before it was put is no answer."""
        _forget_what_was_typed()
        by_number = {mounting.number: mounting for mounting in self._schedule.mountings}
        if event["kind"] == "mounting":
            mounting, on_table = by_number[event["mounting"]], by_number.get(self._on_table)
            is_bolted = on_table is not None and mounting.bolting is not None and on_table.bolting == mounting.bolting
            is_inclined = sum(one.bolting == mounting.bolting for one in by_number.values()) > 1
            where = f"Mount the block as mounting {mounting.number} says: {mounting_text(mounting)}."
            todo = [_STAYS] if is_bolted else [where]
            todo += [inclining_text(mounting)] if mounting.bolting is not None and is_inclined else []
            turned = ["The table then turns to:", *poses.positions(self._schedule, mounting)]
            self._put(" ".join(todo), [_SEATED, *poses.sketch(mounting, 0.0), *turned], _HELP)
        elif event["kind"] == "angle":
            angle_deg, number = event["angle_deg"], event["mounting"]
            shown = [_TURNED.format(angle_deg), *poses.sketch(by_number[number], angle_deg)] if number else []
            self._put(f"Turn the table to {angle_deg:g} degrees.", shown, _HELP)
        else:
            self._put(f"Fault: {event['sentence']}.", [], _HELP_FAULT)
        return self.read_answer()

    def _put(self, question: str, shown: list[str], answers: str) -> None:
        """A question, what is drawn of it, and its answers, in lines that fit a terminal."""
        for line in (*_folded(question), *shown, *_folded(f"[{answers}]")):
            self.say(line)

    def read_answer(self) -> str:
        """A line of standard input; its end is an abort."""
        try:
            line = "" if sys.stdin is None else sys.stdin.readline()
        except (OSError, ValueError):  # a folder, a terminal that is gone, what is not text
            line = ""
        words = " ".join(line.split()).lower()
        return "abort" if not line else words or "done"


def _forget_what_was_typed() -> None:
    """Only of a terminal: a script may write all its answers at once."""
    if termios is not None and sys.stdin is not None and sys.stdin.isatty():
        termios.tcflush(sys.stdin, termios.TCIFLUSH)


def _folded(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH, subsequent_indent="  ")


class LiveProgress(Progress):
    """With rich: a bar, the place in the schedule, the running mean, time to go. It is taken away at the end."""

    def __init__(self, schedule: Schedule, interactive: bool):
        from rich.console import Console
        from rich.progress import BarColumn, Progress as Bars, TextColumn, TimeRemainingColumn

        super().__init__(schedule, interactive)
        columns = (
            TextColumn("{task.description}"),
            BarColumn(12),
            TextColumn("ETA"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[mean]}"),
        )
        console = Console(stderr=True, highlight=False)
        self._bars = Bars(*columns, console=console, transient=True, refresh_per_second=20)
        self._task = self._bars.add_task("preparing", total=len(schedule.positions), mean="")

    def __enter__(self) -> LiveProgress:
        self._bars.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bars.stop()

    def on_state(self, event: dict[str, Any]) -> None:
        """The place in the schedule and what is being done there."""
        doing = in_words(event["state"])
        self._bars.update(self._task, description=f"{_place(event)}, {doing}", completed=event["finished"], mean="")

    def on_average(self, event: dict[str, Any]) -> None:
        """The running mean and its error, and how far the position is."""
        done = event["finished"] + event["samples"] / event["wanted"]
        self._bars.update(self._task, description=_place(event), completed=done, mean=_volts(event))

    def say(self, line: str) -> None:
        """Above the display."""
        self._bars.console.print(line, markup=False)

    def read_answer(self) -> str:
        """Without a display that runs over what is being typed."""
        self._bars.stop()
        try:
            return super().read_answer()
        finally:
            self._bars.start()


def _place(event: dict[str, Any]) -> str:
    number = min(event["finished"] + 1, event["count"])
    return f"position {number} of {event['count']}, mounting {event['mounting']}"


def _volts(event: dict[str, Any]) -> str:
    """The running mean and its standard error, V."""
    if event["mean_v"] is None:
        return ""
    means = zip("xyz", event["mean_v"], event["standard_error_v"])
    return "  ".join(f"{axis} {mean:+.5f}({error:.0e})" for axis, mean, error in means) + " V"
