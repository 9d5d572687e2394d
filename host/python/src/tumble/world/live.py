"""Progress of a bench run on a terminal, with rich: a bar, the place in the schedule, the running mean, time to go."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress as Bars, TextColumn, TimeRemainingColumn

from tumble.schedule import Schedule
from tumble.world.progress import Progress, in_words, volts


class LiveProgress(Progress):
    """The display is taken away when the run has ended."""

    def __init__(self, schedule: Schedule, interactive: bool):
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
        self._bars.update(self._task, description=_place(event), completed=done, mean=volts(event))

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
