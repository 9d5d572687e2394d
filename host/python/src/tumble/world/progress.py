"""Progress of a bench run, told to a person on stderr; and the questions that only a person can answer."""

from __future__ import annotations

from typing import Any

from tumble import prompts
from tumble.messages import tell
from tumble.schedule import Schedule

_HELP = "Enter or done: it is done; leave: do nothing; abort: stop here"
_HELP_FAULT = (
    "Enter or done: mended, go on; leave: do nothing; abort: stop here; repeat position INDEX; repeat mounting NUMBER"
)


def state_text(state: str) -> str:
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
            prompts.forget_what_was_typed()
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
        prompts.forget_what_was_typed()
        if event["kind"] == "mounting":
            lines = prompts.to_mount(self._schedule, event["mounting"], self._on_table, _HELP)
        elif event["kind"] == "angle":
            lines = prompts.to_turn(self._schedule, event["mounting"], event["angle_deg"], _HELP)
        else:
            lines = prompts.asked(f"Fault: {event['sentence']}.", [], _HELP_FAULT)
        for line in lines:
            self.say(line)
        return self.read_answer()

    def read_answer(self) -> str:
        """A line of standard input."""
        return prompts.read_answer()


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
        doing = state_text(event["state"])
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
