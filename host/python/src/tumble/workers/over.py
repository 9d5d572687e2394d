"""The one loop that all campaigns are: work cut into pieces by its seeds, results in the order of their pieces.

A job is a picklable object that is called with what a piece says. It travels as bytes, and a worker unpickles it once,
so what it prepares on its first piece serves the others as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Protocol, TypeAlias

from tumble.workers.kept import NOTHING, Nothing, Result

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
    """Whoever does pieces."""

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """Every piece once, as they are done. What a job raises is raised here."""

    def close(self) -> None:
        """No more is wanted of it."""


class Alone:
    """This process."""

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """One after the other."""
        for placed in pieces:
            yield placed, job(placed[1].what)

    def close(self) -> None:
        """Nobody else is here."""


@dataclass
class Team:
    """Who does it, and where it is kept. `with` it: at the end, however that comes, what is done is kept and the crew
    goes home."""

    crew: Crew = field(default_factory=Alone)
    kept: Nothing = NOTHING

    def __enter__(self) -> Team:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        try:
            self.kept.write()
        finally:
            self.crew.close()


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
            known = team.kept.get(piece.name)
            if known is None:
                yield place, piece
            else:
                ready[place] = known
                progress(piece.size)

    due = 0
    for (place, piece), result in team.crew.results(job, missing()):
        team.kept.add(piece.name, result)
        progress(piece.size)
        ready[place] = result
        while due in ready:
            yield ready.pop(due)
            due += 1
    while due in ready:
        yield ready.pop(due)
        due += 1
