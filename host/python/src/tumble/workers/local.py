"""Processes of this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from tumble._version import __version__
from tumble.errors import BenchFault
from tumble.messages import tell
from tumble.workers.pieces import Job, Placed, Result, call, packed

_TRIES = 3  # of a piece that was under way when a process died: it may be what kills them
_AHEAD = 2  # pieces for each process, so that none waits for the next


class Processes:
    """So many processes. When one dies, the executor gives up all: then there are new ones, and what was under way is
    done again."""

    def __init__(self, count: int):
        self._count = count
        self._pool: ProcessPoolExecutor | None = None

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """As they are done. Raises BenchFault where a piece kills whoever tries it."""
        again: deque[Placed] = deque()
        tries: Counter[int] = Counter()
        source, job_bytes = iter(pieces), packed(job)
        under_way: dict[Future[Result], Placed] = {}
        while True:
            self._fill(under_way, again, source, job_bytes)
            if not under_way:
                return
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                placed = under_way.pop(future)
                if isinstance(future.exception(), BrokenProcessPool):
                    again.append(placed)
                else:
                    yield placed, future.result()
            if again:
                again.extend(under_way.values())  # the pool is broken: they can only fail
                under_way.clear()
                again = self._after_death(again, tries)

    def _fill(
        self, under_way: dict[Future[Result], Placed], again: deque[Placed], source: Iterator[Placed], job: bytes
    ) -> None:
        """Hand out, up to what is wanted ahead."""
        while len(under_way) < _AHEAD * self._count:
            placed = again.popleft() if again else next(source, None)
            if placed is None:
                return
            try:
                future = self._executor().submit(call, __version__, job, placed[1].what)
            except BrokenProcessPool as error:  # it has died since, and whatever is under way will say so, too
                future = Future()
                future.set_exception(error)
            under_way[future] = placed

    def _executor(self) -> ProcessPoolExecutor:
        if self._pool is None:
            spawn = multiprocessing.get_context("spawn")  # a fork would take the threads' locks along
            self._pool = ProcessPoolExecutor(self._count, spawn, _begin)
        return self._pool

    def _after_death(self, lost: deque[Placed], tries: Counter[int]) -> deque[Placed]:
        """What is to be done again, in order."""
        self.close()
        tries.update(place for place, _ in lost)
        ordered = sorted(lost, key=lambda placed: placed[0])
        spent = [piece.name for place, piece in ordered if tries[place] >= _TRIES]
        if spent:
            raise BenchFault(f"worker processes have died {_TRIES} times; under way each time: {', '.join(spent)}")
        tell(f"tumble: a worker process has died: new ones do again what was under way ({len(lost)} pieces)")
        return deque(ordered)

    def close(self) -> None:
        """What is under way is finished, and not taken."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None


def _begin() -> None:
    """A worker's first call. Ctrl-C is for whoever has started it, and it must not outlive that one."""
    for name in ("SIGINT", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)
