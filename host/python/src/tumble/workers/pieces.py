"""What is handed out, and what comes back.

A job is a picklable object that is called with what a piece says. It travels as bytes, and a worker unpickles it once,
so what it prepares on its first piece serves the others as well.
"""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

from tumble._version import __version__
from tumble.errors import UsageError

Result = dict[str, Any]  # arrays (Floats, Integers) of one dimension, or text: fit for a row of Parquet
Job: TypeAlias = Callable[[Any], Result]


@dataclass(frozen=True)
class Piece:
    """`name`: its own within the campaign; `what`: for the job, picklable; `size`: what it counts for in progress."""

    name: str
    what: Any
    size: int = 1


Placed: TypeAlias = tuple[int, Piece]  # with its place among the pieces


class Crew(Protocol):
    """Whoever does pieces."""

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """Every piece once, as they are done. What a job raises is raised here."""

    def close(self) -> None:
        """No more is wanted of it."""


_prepared = threading.local()  # a worker of Dask's may have threads, and a job what only one of them may use


def packed(job: Job) -> bytes:
    """For `call`."""
    return pickle.dumps(job)


def call(version: str, job: bytes, what: Any) -> Result:
    """What a worker does. `version`: of who asks, whose numbers another one might not give."""
    if version != __version__:
        raise UsageError(f"a worker has tumble {__version__}, this is {version}")
    if getattr(_prepared, "packed", None) != job:
        _prepared.job, _prepared.packed = pickle.loads(job), job
    result: Result = _prepared.job(what)
    return result
