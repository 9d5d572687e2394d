"""The one loop that all campaigns are: work cut into pieces by its seeds, results in the order of their pieces.

A job is a picklable object that is called with what a piece says. It travels as bytes, and a worker unpickles it once,
so what it prepares on its first piece serves the others as well.

What is done of a campaign, kept as Parquet: a row for each piece, its name and what it left.

The file says whose it is: a fingerprint of all that the results depend on, beside words for people. It is written as a
whole or not at all, every few seconds, and at the end.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, TypeAlias

import numpy as np

from tumble._version import __version__
from tumble.errors import BadInput, NotInstalled, quoted
from tumble.files.disk import bounded, refuse_link, written

Result = dict[str, Any]  # arrays (Floats, Integers) of one dimension, or text: fit for a row of Parquet

FORMAT = "tumble-done/1"  # of a table of Parquet, so no JSON schema stands for it
_NAME, _ABOUT = "piece", b"tumble"
_PAUSE_S, _SHARE = 5.0, 0.05  # between two writings at least; and no more of the time than this is spent on them


class Kept:
    """In a file, which need not be there yet. `depends`: on what the results do, by name."""

    def __init__(self, file: str, depends: dict[str, Any]):
        """Raises BadInput where the file is another campaign's, or none, or cannot be there; NotInstalled."""
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise NotInstalled("--resume", "pyarrow", extra="parquet") from None
        text = json.dumps({**depends, "tumble": __version__}, default=_as_text, sort_keys=True)
        self._about = {
            "schema": FORMAT,
            "campaign": str(depends["campaign"]),
            "fingerprint": hashlib.sha256(text.encode()).hexdigest(),
        }
        self._file = file
        refuse_link(file)
        if not os.access(os.path.dirname(os.path.realpath(file)), os.W_OK):  # told now, not after the first hours
            raise BadInput("cannot be written: its folder is not there, or nobody may write to it", file)
        self._done = self._read() if os.path.exists(file) else {}
        self._is_new = not self._done
        self._wait_until = time.monotonic() + _PAUSE_S

    def get(self, name: str) -> Result | None:
        """What a piece has left, None if it is not done."""
        return self._done.get(name)

    def add(self, name: str, result: Result) -> None:
        """A piece is done."""
        self._done[name] = result
        self._is_new = True
        if time.monotonic() >= self._wait_until:
            self.write()

    def write(self) -> None:
        """All that is done so far."""
        if not (self._is_new and self._done):
            return
        from pyarrow import Table, parquet

        started = time.monotonic()
        columns = {_NAME: list(self._done)}
        columns |= {name: [one[name] for one in self._done.values()] for name in next(iter(self._done.values()))}
        table = Table.from_pydict(columns).replace_schema_metadata({_ABOUT: json.dumps(self._about)})
        with written(self._file) as stream:
            parquet.write_table(table, stream, compression="zstd")
        self._is_new = False
        ended = time.monotonic()
        self._wait_until = ended + max(_PAUSE_S, (ended - started) / _SHARE)

    def _read(self) -> dict[str, Result]:
        from pyarrow import ArrowException, parquet

        try:
            with bounded(self._file):
                table = parquet.read_table(self._file)
            about = json.loads((table.schema.metadata or {}).get(_ABOUT, b"{}"))
        except (ArrowException, OSError, ValueError) as error:
            raise BadInput(f"not a Parquet file that can be read: {quoted(error)}", self._file) from None
        if about.get("schema") != FORMAT:
            raise BadInput(f"not a file of --resume (schema {FORMAT})", self._file)
        if about.get("campaign") != self._about["campaign"]:
            raise BadInput(f"what is done of another campaign: {quoted(about.get('campaign'))}", self._file)
        if about.get("fingerprint") != self._about["fingerprint"]:
            raise BadInput("what is done of a campaign with other inputs, options or version of tumble", self._file)
        rows = {name: table[name].to_pylist() for name in table.column_names}
        names = rows.pop(_NAME)
        return {
            piece: {name: _value(column[row], table.schema.field(name).type) for name, column in rows.items()}
            for row, piece in enumerate(names)
        }


def _as_text(value: Any) -> Any:
    """Of what JSON does not know; an array by its numbers, all of them."""
    return value.tolist() if isinstance(value, np.ndarray) else repr(value)


def _value(found: Any, kind: Any) -> Any:
    if isinstance(found, str):
        return found
    return np.array(found, dtype=float if "double" in str(kind) else int)


Job: TypeAlias = Callable[[Any], Result]
Progress = Callable[[int], None]


@dataclass(frozen=True)
class Piece:
    """`name`: its own within the campaign; `what`: for the job, picklable; `size`: what it counts for in progress;
    `halves`: cuts it in two, for who looks for the one seed that kills a process."""

    name: str
    what: Any
    size: int = 1
    halves: Callable[[], tuple[Piece, Piece]] | None = None


Placed: TypeAlias = tuple[int, Piece]  # with its place among the pieces


class Crew(Protocol):
    """Whoever does pieces beside this process."""

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """Every piece once, as they are done. What a job raises is raised here."""

    def close(self) -> None:
        """No more is wanted of it: what is under way is given up."""


@dataclass
class Team:
    """Who does it, None: this process; and where it is kept, if it is. `with` it: at the end, however that comes, what
    is done is kept and the crew goes home."""

    crew: Crew | None = None
    kept: Kept | None = None

    def __enter__(self) -> Team:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            if self.kept is not None:
                self.kept.write()
        finally:
            if self.crew is not None:
                self.crew.close()

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """Every piece once, as they are done."""
        if self.crew is not None:
            return self.crew.results(job, pieces)
        return ((placed, job(placed[1].what)) for placed in pieces)


ALONE = Team()


def over(
    pieces: Iterable[Piece], job: Job, team: Team = ALONE, progress: Progress = lambda size: None
) -> Iterator[Result]:
    """The results of all pieces, in their order. `progress` is told the size of each piece that is done.

    `pieces` are asked for as they are needed, a few ahead. What of them is kept is not done again.
    """
    ready: dict[int, Result] = {}

    def missing() -> Iterator[Placed]:
        for place, piece in enumerate(pieces):
            known = None if team.kept is None else team.kept.get(piece.name)
            if known is None:
                yield place, piece
            else:
                ready[place] = known
                progress(piece.size)

    due = 0
    for (place, piece), result in team.results(job, missing()):
        if team.kept is not None:
            team.kept.add(piece.name, result)
        progress(piece.size)
        ready[place] = result
        while due in ready:
            yield ready.pop(due)
            due += 1
    while due in ready:
        yield ready.pop(due)
        due += 1
