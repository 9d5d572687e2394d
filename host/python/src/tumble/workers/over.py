"""The one loop that all campaigns are."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from types import TracebackType

from tumble.workers.kept import NOTHING, Nothing
from tumble.workers.pieces import Crew, Job, Piece, Placed, Result

Progress = Callable[[int], None]


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
