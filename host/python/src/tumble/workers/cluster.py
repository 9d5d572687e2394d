"""A cluster of Dask's. It repeats by itself what a lost worker had; TLS files are those of its own configuration."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any

from tumble._version import __version__
from tumble.errors import BenchFault, NotInstalled, TumbleError, UsageError, quoted
from tumble.workers.pieces import Job, Placed, Result, call, packed

_PATIENCE_S = 10.0  # for a scheduler to answer, and for its first worker
_AHEAD = 4  # pieces for each processor, so that none waits for the network
_FEWEST_AHEAD = 8  # also where more workers come later


class Cluster:
    """A scheduler and its workers."""

    def __init__(self, address: str):
        """Raises UsageError where nobody answers there, NotInstalled."""
        try:
            from distributed import Client
        except ImportError:
            raise NotInstalled("--cluster", "dask distributed", extra="cluster") from None
        logging.getLogger("distributed").setLevel(logging.CRITICAL)  # what is wrong is raised, in one line
        try:
            self._client: Any = Client(address, timeout=_PATIENCE_S)
        except (OSError, ValueError, TypeError, RuntimeError) as error:
            raise UsageError(f"--cluster: {quoted(address)}: no scheduler answers: {_words(error)}") from None
        try:
            self._client.wait_for_workers(1, timeout=_PATIENCE_S)
        except OSError:  # TimeoutError
            self._client.close()
            raise UsageError(f"--cluster: {quoted(address)}: its scheduler has no workers") from None

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """As they are done. Raises BenchFault where a piece kills whoever tries it."""
        from distributed import as_completed

        source, job_bytes, placed_of = iter(pieces), packed(job), {}

        def hand_out(count: int) -> list[Any]:
            futures = []
            for placed in islice(source, count):
                future = self._client.submit(call, __version__, job_bytes, placed[1].what, pure=False)
                placed_of[future] = placed
                futures.append(future)
            return futures

        completed = as_completed(hand_out(max(_FEWEST_AHEAD, _AHEAD * sum(self._client.ncores().values()))))
        for future in completed:
            placed = placed_of.pop(future)
            yield placed, self._result(future, placed)
            for more in hand_out(1):
                completed.add(more)

    def _result(self, future: Any, placed: Placed) -> Result:
        try:
            result: Result = future.result()
        except TumbleError:
            raise
        except Exception as error:  # what a foreign worker can raise has no end
            raise BenchFault(f"--cluster: {placed[1].name}: {_words(error)}") from None
        return result

    def close(self) -> None:
        """What is under way is let go."""
        self._client.close()


def _words(error: Exception) -> str:
    return quoted(f"{type(error).__name__}: {error}", 160)
