"""The one loop that all campaigns are: work cut into pieces by its seeds, results in the order of their pieces.

A job is a picklable object that is called with what a piece says. It travels as bytes, and a worker unpickles it once,
so what it prepares on its first piece serves the others as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, TypeAlias

from tumble.workers.kept import Kept, Result

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
