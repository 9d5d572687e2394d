"""What the commands that simulate a lot have in common: who does it, what is kept of it, and how far it is."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from tumble.cli.options import Options, parse_whole
from tumble.errors import UsageError, quoted
from tumble.messages import on_terminal

if TYPE_CHECKING:
    from tumble.workers.over import Team

MOST_WORKERS = 256


def add_workers(parser: Options) -> None:
    """--workers, --cluster, --resume."""
    parser.add_argument(
        "--workers", metavar="N", help=f"so many processes, 1 to {MOST_WORKERS}, for the same result; default: 1"
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="a scheduler of Dask distributed, such as tcp://HOST:8786, or tls:// with the files of Dask's own"
        " configuration; needs the extra cluster",
    )
    parser.add_argument(
        "--resume",
        metavar="FILE.parquet",
        help="keep there what is done, and go on from what is there; needs the extra parquet",
    )


def workers_of(arguments: argparse.Namespace) -> int:
    """How many processes. Raises UsageError."""
    return 1 if arguments.workers is None else parse_whole(arguments.workers, "--workers", 1, MOST_WORKERS)


@contextmanager
def team_of(arguments: argparse.Namespace, campaign: str, **depends: Any) -> Iterator[Team]:
    """Who does it, by these options. `depends`: on what the results do, beside the program's version; as text it says
    all. Raises TumbleError."""
    count = workers_of(arguments)
    if arguments.cluster is not None and arguments.workers is not None:
        raise UsageError("--cluster: it has workers of its own, --workers is for this machine")
    if arguments.resume is not None and not arguments.resume.endswith(".parquet"):
        raise UsageError(f"--resume: {quoted(arguments.resume)} does not end in .parquet")

    from tumble.workers.over import Team

    team = Team()
    if arguments.resume is not None:
        from tumble.workers.over import Kept

        team.kept = Kept(arguments.resume, {"campaign": campaign, **depends})
    if arguments.cluster is not None:
        from tumble.workers.crews import Cluster

        team.crew = Cluster(arguments.cluster)
    elif count > 1:
        from tumble.workers.crews import Processes

        team.crew = Processes(count)
    with team:
        yield team


class Bar(Protocol):
    """Is told how much more is done; and of how much, if that is known only now."""

    def __call__(self, done: int, of: int | None = None) -> None: ...


@contextmanager
def progress_bar(what: str, total: int | None = None) -> Iterator[Bar]:
    """On a terminal a bar, with the time left."""
    if not on_terminal():
        yield _say_nothing
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=total)

        def advance(done: int, of: int | None = None) -> None:
            bar.update(task, advance=done, total=of)

        yield advance


def _say_nothing(done: int, of: int | None = None) -> None:
    pass
