"""Asks a source again and again, in a thread of its own, and keeps what it has found for all who look on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import replace

from tumble.watch.snapshot import Lost, Source, View


class Follower:
    """`with Follower(...)`: meanwhile the source is asked every `period_s` seconds. It is closed at the end.
    `on_change` is given every new view.

    A source that does not answer is asked again as if nothing had been; `view().lost_since` tells since when."""

    def __init__(
        self,
        source: Source,
        name: str,
        period_s: float,
        clock: Callable[[], float] = time.time,
        on_change: Callable[[View], None] | None = None,
    ):
        self._source = source
        self._period_s = period_s
        self._clock = clock
        self._on_change = on_change or (lambda _: None)
        self._view = View(name, 0, clock())
        self._failure: Exception | None = None
        self._asking = threading.Lock()
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="tumble watch", daemon=True)

    def __enter__(self) -> Follower:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join()
        self._source.close()

    def view(self) -> View:
        """The newest one. Its number grows with every change."""
        return self._view

    def is_over(self) -> bool:
        """Will nothing more come? Raises what the thread has ended by, which is a fault in this program."""
        if self._failure is not None:
            raise self._failure
        return self._view.snapshot is not None and self._view.snapshot.over

    def ask(self) -> View:
        """Ask once, now."""
        with self._asking:
            before, self._view = self._view, self._asked(self._view)
            if self._view is not before:
                self._on_change(self._view)
        return self._view

    def _asked(self, before: View) -> View:
        try:
            after = replace(before, snapshot=self._source.snapshot(), lost_since=None, why=None)
        except Lost as error:
            since = self._clock() if before.lost_since is None else before.lost_since
            after = replace(before, lost_since=since, why=str(error))
        if after == before and before.number:
            return before
        return replace(after, number=before.number + 1, time=self._clock())

    def _follow(self) -> None:
        try:
            while not self._stopped.is_set():
                self.ask()
                self._stopped.wait(self._period_s)
        except Exception as error:
            self._failure = error
