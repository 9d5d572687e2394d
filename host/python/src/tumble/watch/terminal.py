"""The live view on a terminal, with rich, at 80 columns."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import TextIO

from rich import box
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from tumble.documents.watch import Gravity, Matrix, Snapshot, Vector
from tumble.watch.snapshot import View, with_sentences

_WIDTH = 80
_UPDATES_PER_SECOND = 4
_AXES = "xyz"
_NO = "-"
_GOOD, _BAD = "bright_blue bold", "yellow bold"  # told apart by colour-blind eyes; a word says the same


class Screen:
    """Redraw the view in place within the `with` block; the last one stays."""

    def __init__(self, view: Callable[[], View], stream: TextIO | None):
        console = Console(file=stream, highlight=False)
        self._live = Live(get_renderable=lambda: drawn(view()), console=console, refresh_per_second=_UPDATES_PER_SECOND)

    def __enter__(self) -> Screen:
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()


class Lines:
    """Print a line for each change of state, place and connection, where there is no terminal."""

    def __init__(self, stream: TextIO | None):
        self._stream = stream
        self._told = ""

    def __call__(self, view: View) -> None:
        said = line(view)
        if said != self._told and self._stream is not None:
            self._told = said
            print(_clock(view.time), said, file=self._stream, flush=True)


def drawn(view: View) -> RenderableType:
    """A view as rich draws it."""
    now = with_sentences(view.snapshot or Snapshot())
    parts: list[RenderableType] = [_state(now), *_trouble(now), *_lost(view)]
    parts += [Text(), _place(now), _samples(now), _angle(now), Text(), _means(now), Text()]
    parts += [_coefficients(now), Text(), _gravity(now.gravity)]
    title = Text(f" tumble watch {view.name} ", overflow="ellipsis")
    when = _clock(view.time) + ("" if now.virtual_s is None else f", {now.virtual_s:.1f} s of virtual time")
    return Panel(Group(*parts), title=title, subtitle=when, width=_WIDTH, box=box.ROUNDED)


def line(view: View) -> str:
    """State, place and connection, in one line."""
    now = with_sentences(view.snapshot or Snapshot())
    if view.lost_since is not None:
        return f"connection lost: {view.why}"
    reason = "" if now.reason is None else f" {now.reason}: {now.sentence}"
    return f"{now.state or 'state unknown'}{reason}, {_where(now)}"


def _clock(seconds: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(seconds))


def _state(now: Snapshot) -> Text:
    style = {"DONE": _GOOD, "FAULT": _BAD, "ABORT": _BAD}.get(now.state or "", "bold")
    text = Text((now.state or "state unknown").replace("_", " "), style=style)
    text.append("" if now.meaning is None else f"  {now.meaning}", style="not bold")
    return text.append("" if now.run is None else f"  (run {now.run})", style="not bold dim")


def _trouble(now: Snapshot) -> Iterator[Text]:
    if now.reason is not None:
        yield Text(f"! {now.reason}: {now.sentence or 'an unknown reason'}", style=_BAD)
        yield Text(f"  {now.remedy or ''}")
    if now.emergencies:
        yield Text(
            "! emergency " + ", ".join(f"{code}h of {node}" for node, code in now.emergencies.items()), style=_BAD
        )
    if now.trouble is not None:
        yield Text(f"! {now.trouble}", style=_BAD)


def _lost(view: View) -> Iterator[Text]:
    if view.lost_since is not None:
        yield Text(f"! connection lost since {_clock(view.lost_since)}: {view.why}; retrying", style=_BAD)


def _where(now: Snapshot) -> str:
    place = f"mounting {now.mounting}, position {now.position}" if now.position else "no position"
    attempt = f", attempt {now.attempt + 1}" if now.attempt else ""
    finished = "" if now.finished is None or now.count is None else f", {now.finished} of {now.count} finished"
    return place + attempt + finished


def _row(name: str, value: RenderableType, done: float | None = None) -> Table:
    row = Table.grid(padding=(0, 2, 0, 0))
    row.add_column(width=14, style="dim")
    row.add_column(width=58 if done is None else 42)
    bar = [] if done is None else [ProgressBar(total=1.0, completed=done, width=14)]
    row.add_row(name, value, *bar)
    return row


def _place(now: Snapshot) -> Table:
    return _row("place", _where(now), now.finished / now.count if now.finished is not None and now.count else None)


def _samples(now: Snapshot) -> Table:
    if now.samples is None or not now.wanted:
        return _row("samples", _NO)
    return _row("samples", f"{now.samples} of {now.wanted} at this position", now.samples / now.wanted)


def _angle(now: Snapshot) -> Table:
    parts = [_NO if now.angle_rad is None else f"{math.degrees(now.angle_rad):+.3f} deg"]
    parts += [] if now.target_rad is None else [f"target {math.degrees(now.target_rad):+.3f} deg"]
    parts += [] if now.temperature_c is None else [f"block {now.temperature_c:.1f} C"]
    return _row("table angle", ", ".join(parts))


def _numbers(heading: str, columns: list[str]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False, header_style="dim")
    table.add_column(heading, width=14, style="dim", no_wrap=True)
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True, min_width=9)
    return table


def _means(now: Snapshot) -> Table:
    mean = now.mean
    of = "" if mean is None else f"{mean.samples} samples of {mean.mounting}.{mean.position}"
    table = _numbers("running mean", ["x", "y", "z", of])
    table.add_row("mean, V", *_cells(None if mean is None else mean.mean_v, "{:+.6f}"))
    table.add_row("its error, V", *_cells(None if mean is None else mean.standard_error_v, "{:.1e}"))
    return table


def _coefficients(now: Snapshot) -> Table:
    with_u = now.u_k_v_per_g is not None
    table = _numbers("last run", ["K x, V/g", "K y, V/g", "K z, V/g", "U0, V"])
    for i, axis in enumerate(_AXES):
        table.add_row(axis, *_cells(_of(now.k_v_per_g, i), "{:+.6f}"), *_cells(_one(now.u0_v, i), "{:+.6f}", 1))
        if with_u:
            table.add_row("  u", *_cells(_of(now.u_k_v_per_g, i), "{:.1e}"), *_cells(_one(now.u_u0_v, i), "{:.1e}", 1))
    return table


def _cells(numbers: Vector | None, form: str, count: int = 3) -> list[str]:
    return [_NO] * count if numbers is None else [form.format(number) for number in numbers]


def _of(rows: Matrix | None, i: int) -> Vector | None:
    return None if rows is None else rows[i]


def _one(vector: Vector | None, i: int) -> Vector | None:
    return None if vector is None else (vector[i],)


def _gravity(check: Gravity | None) -> Table:
    if check is None or check.passed is None or check.worst_g is None or check.limit_g is None:
        limit = None if check is None else check.limit_g
        return _row("gravity check", "not made yet" + ("" if limit is None else f"; limit {limit:.1e} g"))
    verdict = Text("PASS" if check.passed else "FAIL", style=_GOOD if check.passed else _BAD)
    verdict.append(f"  {check.worst_g:.1e} g of at most {check.limit_g:.1e} g", style="not bold default")
    return _row("gravity check", verdict)
