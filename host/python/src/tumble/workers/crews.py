"""Who does pieces, beside this process: any executor of concurrent.futures, which Dask distributed has as well."""

from __future__ import annotations

import logging
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from typing import Any

from tumble._version import __version__
from tumble.errors import BenchFault, NotInstalled, TumbleError, UsageError, quoted
from tumble.messages import tell
from tumble.workers.over import Job, Piece, Placed, Result

_AHEAD = 2  # pieces for each process, so that none waits for the next
_AHEAD_ON_CLUSTER = 4  # for each processor, so that none waits for the network
_FEWEST_ON_CLUSTER = 8  # also where more workers come later
_PATIENCE_S = 10.0  # for a scheduler to answer, and for its first worker


class _Executed:
    """Whoever is an executor of concurrent.futures."""

    _executor: Executor
    _ahead: int

    def results(self, job: Job, pieces: Iterable[Placed]) -> Iterator[tuple[Placed, Result]]:
        """As they are done. Raises BenchFault where a piece kills whoever tries it."""
        source, packed = iter(pieces), pickle.dumps(job)
        self._under_way: dict[Future[Result], Placed] = {}
        while True:
            for placed in islice(source, self._ahead - len(self._under_way)):
                self._under_way[self._submit(packed, placed[1])] = placed
            if not self._under_way:
                return
            for future in wait(self._under_way, return_when=FIRST_COMPLETED).done:
                placed = self._under_way.pop(future)
                found = self._taken(future, packed, placed[1])
                if isinstance(found, Future):
                    self._under_way[found] = placed
                else:
                    yield placed, found

    def _submit(self, job: bytes, piece: Piece) -> Future[Result]:
        return self._executor.submit(_call, __version__, job, piece.what)

    def _taken(self, future: Future[Result], job: bytes, piece: Piece) -> Result | Future[Result]:
        """What it has come to, or another try at it."""
        return future.result()


class Processes(_Executed):
    """So many of this machine. When one dies, the executor gives up all: then there is a new one, and each piece that
    was under way is done again by a process of its own."""

    def __init__(self, count: int):
        self._count, self._ahead = count, _AHEAD * count
        self._executor = _processes(count)
        self._again: set[Future[Result]] = set()
        self._under_way = {}

    def _submit(self, job: bytes, piece: Piece) -> Future[Result]:
        try:
            return super()._submit(job, piece)
        except BrokenProcessPool:
            self._executor = _processes(self._count)
            return super()._submit(job, piece)

    def _taken(self, future: Future[Result], job: bytes, piece: Piece) -> Result | Future[Result]:
        try:
            return future.result()
        except BrokenProcessPool:
            if future in self._again:
                fatal = _fatal_part(job, piece).name
                raise BenchFault(f"{fatal}: the process that does it dies, also alone") from None
        tell(f"tumble: a worker process has died: {piece.name} was under way, and is done again alone")
        again = _alone(job, piece)
        self._again.add(again)
        return again

    def close(self) -> None:
        """What is under way is not waited for."""
        if self._under_way:
            for process in multiprocessing.active_children():
                process.terminate()
        self._executor.shutdown(cancel_futures=True)


def _processes(count: int) -> ProcessPoolExecutor:
    spawn = multiprocessing.get_context("spawn")  # a fork would take the threads' locks along
    return ProcessPoolExecutor(count, spawn, _begin)


def _alone(job: bytes, piece: Piece) -> Future[Result]:
    """By a process of its own, which ends with it."""
    executor = _processes(1)
    future = executor.submit(_call, __version__, job, piece.what)
    executor.shutdown(wait=False)
    return future


def _fatal_part(job: bytes, piece: Piece) -> Piece:
    """The smallest part of it, as far as it can be cut, of which a process dies."""
    while piece.halves is not None:
        fatal = next((half for half in piece.halves() if _dies(job, half)), None)
        if fatal is None:
            return piece
        piece = fatal
    return piece


def _dies(job: bytes, piece: Piece) -> bool:
    return isinstance(_alone(job, piece).exception(), BrokenProcessPool)


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


class Cluster(_Executed):
    """A scheduler of Dask's and its workers. It repeats by itself what a lost worker had; TLS files are those of its
    own configuration."""

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
        self._ahead = max(_FEWEST_ON_CLUSTER, _AHEAD_ON_CLUSTER * sum(self._client.ncores().values()))
        self._executor = self._client.get_executor(pure=False)

    def _taken(self, future: Future[Result], job: bytes, piece: Piece) -> Result:
        try:
            return future.result()
        except TumbleError:
            raise
        except Exception as error:  # what a foreign worker can raise has no end
            raise BenchFault(f"--cluster: {piece.name}: {_words(error)}") from None

    def close(self) -> None:
        """What is under way is let go."""
        self._client.close()


def _words(error: Exception) -> str:
    return quoted(f"{type(error).__name__}: {error}", 160)


_prepared = threading.local()  # a worker of Dask's may have threads, and a job what only one of them may use


def _call(version: str, job: bytes, what: Any) -> Result:
    """What a worker does. `version`: of who asks, whose numbers another one might not give."""
    if version != __version__:
        raise UsageError(f"a worker has tumble {__version__}, this is {version}")
    if getattr(_prepared, "packed", None) != job:
        _prepared.job, _prepared.packed = pickle.loads(job), job
    result: Result = _prepared.job(what)
    return result
