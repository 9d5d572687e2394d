"""The folder of a run as a source: finished, or as the bench is still writing it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from tumble.watch import snapshot
from tumble.watch.bench_run import NOT_THE_FORM, after_document
from tumble.watch.snapshot import Heard, Lost, Snapshot

_DOCUMENTS = ("result.json", "fault.json", "bench.json")  # the last is the world's own
_LOG = "bus.log"
_FIELDS = 3  # of a line of candump -L: time, interface, ID#DATA


class FolderRun:
    """Reads what has been added to bus.log since the last time, and the result once it is there.

    As long as a run goes on, its folder has another name: .NAME.part beside it, or in it."""

    def __init__(self, path: Path):
        self._path = path
        self._offset = 0
        self._rest = ""
        self._heard = Heard(clock=lambda: 0.0)  # a log does not age
        self._last_s: float | None = None

    def is_there(self) -> bool:
        """Whether there is such a folder, finished or not."""
        return any(place.is_dir() for place in self._places())

    def snapshot(self) -> Snapshot:
        """What the files tell. Raises Lost where there are none."""
        found = self._document()
        self._read_log()
        now = self._heard_so_far()
        return now if found is None else _ended(now, *found)

    def close(self) -> None:
        """No file is kept open."""

    def _places(self) -> list[Path]:
        name = f".{self._path.resolve().name}.part"
        stages = self._path / name, self._path.resolve().parent / name
        return [self._path, *stages, *(stage / "bench" for stage in stages)]

    def _document(self) -> tuple[str, Any] | None:
        """(name of the file, what is in it)."""
        for name in _DOCUMENTS:
            try:
                found = json.loads((self._path / name).read_text(encoding="utf-8"))
            except FileNotFoundError:
                continue
            except (OSError, ValueError) as error:
                raise Lost(f"{name} cannot be read: {error}") from None
            return name, found
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
        state = snapshot.state(status.state)
        return Snapshot(
            state=state,
            reason=snapshot.reason(status.reason),
            run=self._heard.run(),
            finished=status.finished,
            samples=status.samples if state == "AVERAGE" else None,
            emergencies=self._heard.emergencies(),
            virtual_s=self._last_s,
        )


def _ended(now: Snapshot, name: str, document: Any) -> Snapshot:
    """With what the document says. A result is of a run that is done, whether or not the log says so to its last line.
    Raises Lost for any other document, such as a damaged one."""
    try:
        after = after_document(now, document)
    except NOT_THE_FORM:
        raise Lost(f"{name} is no result of a run") from None
    return replace(after, state=after.state if "state" in document else "DONE", over=True)
