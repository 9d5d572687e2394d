"""Asks a source again and again, in a thread of its own, and keeps what it has found for all who look on.

And two sources: a run of the bench, by its events and its document at the end; the folder of a run, finished or as the
bench is still writing it.
"""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from tumble.documents import base
from tumble.documents.bench import BENCH, NODE, Bench, Deviation, FirmwareRun, Node
from tumble.documents.result import RESULT, DeltaG, Result
from tumble.documents.watch import Gravity, Matrix, Mean, Snapshot, Vector
from tumble.errors import BadInput
from tumble.watch.snapshot import Heard, Lost, Source, View, without_prefix


class Follower:
    """Poll a source every `period_s` seconds within the `with` block, and close it at the end. Each of `on_change` is
    called with every new view. A source that does not answer is polled on; `view().lost_since` says since when it is
    lost."""

    def __init__(
        self,
        source: Source,
        name: str,
        period_s: float,
        clock: Callable[[], float] = time.time,
        on_change: Iterable[Callable[[View], None]] = (),
    ):
        self._source = source
        self._period_s = period_s
        self._clock = clock
        self._on_change = tuple(on_change)
        self._view = View(name, 0, clock())
        self._failure: Exception | None = None
        self._asking = threading.Lock()
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="tumble watch", daemon=True)

    def __enter__(self) -> Follower:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()
        self._source.close()

    def view(self) -> View:
        """The newest view. Its number grows with every change."""
        return self._view

    def is_over(self) -> bool:
        """Whether nothing more will come. Raises the exception that ended the thread, a fault of this program."""
        if self._failure is not None:
            raise self._failure
        return self._view.snapshot is not None and self._view.snapshot.over

    def ask(self) -> View:
        """Poll once, now."""
        with self._asking:
            before, self._view = self._view, self._asked(self._view)
            if self._view is not before:
                for tell in self._on_change:
                    tell(self._view)
        return self._view

    def _asked(self, before: View) -> View:
        try:
            after = replace(before, snapshot=self._source.snapshot(), lost_since=None, why=None)
        except Lost as error:
            since = self._clock() if before.lost_since is None else before.lost_since
            after = replace(before, lost_since=since, why=str(error))
        if after == before and before.number:
            return before
        return replace(after, number=before.number + 1, time=self._clock())

    def _follow(self) -> None:
        try:
            while not self._stopped.is_set():
                self.ask()
                self._stopped.wait(self._period_s)
        except Exception as error:
            self._failure = error


class BenchRun:
    """A run of the bench as a source. One thread passes it the events of the run (tumble.world.in_process), another
    polls it. `pace`: virtual seconds per second. `when_over` is called when the run is over."""

    def __init__(self, pace: float = 1.0) -> None:
        self.pace = pace
        self.when_over: Callable[[], object] = lambda: None
        self._snapshot = Snapshot()  # is only ever replaced as a whole

    def snapshot(self) -> Snapshot:
        """The state after the events so far."""
        return self._snapshot

    def close(self) -> None:
        """Nothing to close."""

    def __call__(self, event: dict[str, Any]) -> None:
        """Process an event."""
        self._snapshot = after_event(self._snapshot, event)

    def ended(self, document: FirmwareRun) -> None:
        """Process the run's document, after which nothing follows."""
        self._snapshot = replace(after_document(self._snapshot, document), over=True)
        self.when_over()

    def failed(self, why: str) -> None:
        """The run has ended without a document."""
        self._snapshot = replace(self._snapshot, over=True, trouble=why)
        self.when_over()


def after_event(before: Snapshot, event: dict[str, Any]) -> Snapshot:
    """The snapshot after an event."""
    kind = event["event"]
    if kind not in ("state", "average", "angle"):
        return before
    angle_deg = event.get("angle_deg")
    after = replace(
        before, virtual_s=event.get("virtual_s"), angle_rad=None if angle_deg is None else math.radians(angle_deg)
    )
    if kind == "angle":
        return after
    after = replace(
        after,
        state=without_prefix(event["state"]),
        reason=_reason(event["reason"]),
        **{name: event[name] for name in ("mounting", "position", "count", "finished", "attempt")},
    )
    if kind == "state":
        return replace(after, samples=None)
    return replace(after, samples=event["samples"], wanted=event["wanted"], mean=_mean(before, event))


def after_document(before: Snapshot, document: FirmwareRun | Result) -> Snapshot:
    """The snapshot after the document of a bench run or a result. A run with a result is done, even if its log lacks
    the last lines."""
    check = document.verification
    after = replace(
        before,
        k_v_per_g=matrix(document.K),
        u0_v=vector(document.U0),
        u_k_v_per_g=matrix(document.u_K),
        u_u0_v=vector(document.u_U0),
        gravity=None if check is None else _gravity(check.delta_g_g, check.limit_g, check.passed),
    )
    if isinstance(document, Result):
        return replace(after, state="DONE")
    return replace(after, reason=_reason(document.reason), state=without_prefix(document.state))


def _mean(before: Snapshot, event: dict[str, Any]) -> Mean | None:
    mean = vector(event["mean_v"])
    if mean is None:
        return before.mean
    place = event["mounting"], event["position"], event["samples"], event["wanted"]
    return Mean(*place, mean, vector(event["standard_error_v"]))


def _reason(name: str) -> str | None:
    name = without_prefix(name)
    return None if name == "NONE" else name


def _gravity(rows: Iterable[Deviation | DeltaG], limit_g: float, passed: bool) -> Gravity:
    worst: dict[str, list[float]] = {"fit": [], "check": []}
    for row in rows:
        worst[row.use].append(abs(row.delta_g_g))
    fit, checked = (max(worst[use], default=None) for use in ("fit", "check"))
    return Gravity(fit, checked, limit_g, passed)


def vector(numbers: Iterable[float] | None) -> Vector | None:
    """A list from a document as a tuple; None stays None."""
    return None if numbers is None else tuple(map(float, numbers))


def matrix(rows: Iterable[Iterable[float]] | None) -> Matrix | None:
    """A list of lists from a document as tuples; None stays None."""
    return None if rows is None else tuple(tuple(map(float, row)) for row in rows)


_DOCUMENTS = ("result.json", "fault.json", "bench.json")  # the last is the world's own
_LOG = "bus.log"
_FIELDS = 3  # of a line of candump -L: time, interface, ID#DATA


class FolderRun:
    """A run folder as a source: reads the new lines of bus.log, and the result once it exists. While a run goes on, its
    folder is .NAME.part beside NAME, or in it."""

    def __init__(self, path: Path):
        self._path = path
        self._offset = 0
        self._rest = ""
        self._heard = Heard(clock=lambda: 0.0)  # a log does not age
        self._last_s: float | None = None

    def is_there(self) -> bool:
        """Whether the folder exists, finished or not."""
        return any(place.is_dir() for place in self._places())

    def snapshot(self) -> Snapshot:
        """The state by the files. Raises Lost where there are none."""
        found = self._document()
        self._read_log()
        now = self._heard_so_far()
        return now if found is None else replace(after_document(now, found), over=True)

    def close(self) -> None:
        """Nothing to close: no file is kept open."""

    def _places(self) -> list[Path]:
        name = f".{self._path.resolve().name}.part"
        stages = self._path / name, self._path.resolve().parent / name
        return [self._path, *stages, *(stage / "bench" for stage in stages)]

    def _document(self) -> FirmwareRun | Result | None:
        for name in _DOCUMENTS:
            try:
                told = json.loads((self._path / name).read_text(encoding="utf-8"))
            except FileNotFoundError:
                continue
            except (OSError, ValueError) as error:
                raise Lost(f"{name} cannot be read: {error}") from None
            return _checked(told, name)
        return None

    def _read_log(self) -> None:
        logs = [place / name for place in self._places() for name in (_LOG, f"{_LOG}.part")]
        there = [log for log in logs if log.is_file()]
        if not there:
            raise Lost(f"there is no {_LOG} in the folder, or none yet")
        try:
            with there[0].open("rb") as log:
                log.seek(self._offset)
                added = log.read()
        except OSError as error:
            raise Lost(f"{_LOG} cannot be read: {error.strerror}") from None
        self._offset += len(added)
        *lines, self._rest = (self._rest + added.decode("ascii", "replace")).split("\n")
        for line in lines:
            self._take(line)

    def _take(self, line: str) -> None:
        fields = line.split()
        if len(fields) != _FIELDS or "#" not in fields[2]:
            return
        identifier, _, data = fields[2].partition("#")
        try:
            self._heard.frame(int(identifier, 16), bytes.fromhex(data))
            self._last_s = float(fields[0].strip("()"))
        except ValueError:
            return

    def _heard_so_far(self) -> Snapshot:
        status = self._heard.status()
        if status is None:
            return Snapshot(virtual_s=self._last_s)
        emergencies = self._heard.emergencies()
        return Snapshot(run=self._heard.run(), emergencies=emergencies, virtual_s=self._last_s, **status.told)


def _checked(told: Any, file: str) -> FirmwareRun | Result:
    """Raises Lost for any other document, such as a damaged one."""
    kinds: dict[str, type[FirmwareRun | Result]] = {RESULT: Result, BENCH: Bench, NODE: Node}
    name = told.get("schema") if isinstance(told, dict) else None
    if name not in kinds:
        raise Lost(f"{file} is not a result of a run")
    try:
        return base.checked(kinds[name], name, told, file)
    except BadInput as error:
        raise Lost(str(error)) from None
