"""Pytest plugin: a test in real time that failed while the machine was busy is run again, and the run says so.

Tests marked `real_time` wait for processes that answer within a time. A machine that lets them wait, because others use
its processors or its host takes them away, makes such a test fail without a defect. So the machine is watched; where a
marked test failed and the machine was busy in its time, the test is run again, up to `TRIES` times in all and after the
machine has come to rest. On a machine that was not busy a failure is a failure at once, and what fails every time has
failed.

A test that also says within what time its own processes must answer (`answers_within`) is skipped, with the times told,
where a thread of its process waited longer than that for a processor in each of these tries: it asks what such a
machine cannot give. One whose process was let run has failed.

Inside user-mode Linux that is the processor in there, which an emulated board may fill, by its own clock: that one
stands still while the machine outside holds it up (host/uml/uml_clock.c). `TUMBLE_WATCH` is `no`: nothing is
watched.
"""

import os
import threading
import time
from pathlib import Path

import pytest

TRIES = 4
REST_S, REST_MOST_S = (
    2.0,
    30.0,
)  # before the next try: how long the machine must not be busy, and how long to wait for that
PERIOD_S = 0.05
LATE_S = 0.1  # a thread that slept came back so much later
WINDOW_S = 1.0
IDLE_LEAST = 0.1  # of all processors, in a window
STOLEN_MOST = 0.05  # of all processors, by the machine's host


class Watch(threading.Thread):
    """When the machine was busy: [(time.monotonic(), why)]."""

    def __init__(self):
        super().__init__(daemon=True)
        self.seen = []

    def run(self):
        """Until the process ends."""
        window, before = time.monotonic(), processors()
        while True:
            begin = time.monotonic()
            time.sleep(PERIOD_S)
            now = time.monotonic()
            if (late := now - begin - PERIOD_S) > LATE_S:
                self._tell(f"late by {late:.2f} s")
            if now - window >= WINDOW_S:
                window, after = now, processors()
                self._judge(before, after)
                before = after

    def _judge(self, before, after):
        spent = {name: after[name] - before[name] for name in after}
        if spent["all"] > 0 and spent["idle"] < IDLE_LEAST * spent["all"]:
            self._tell(f"{spent['idle'] / spent['all']:.0%} idle")
        if spent["stolen"] > STOLEN_MOST * spent["all"]:
            self._tell(f"{spent['stolen'] / spent['all']:.0%} taken by its host")

    def _tell(self, why):
        self.seen.append((time.monotonic(), why))


def processors():
    """Time of all processors since boot, in ticks; nothing where the system does not tell."""
    try:
        ticks = [int(word) for word in Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0].split()[1:9]]
    except (OSError, ValueError):
        ticks = [0] * 8
    _, _, _, idle, waiting, _, _, stolen = ticks
    return {"all": sum(ticks), "idle": idle + waiting, "stolen": stolen}


def rest(watch):
    """Wait until the machine is not busy."""
    begin = time.monotonic()
    while (now := time.monotonic()) - begin < REST_MOST_S:
        if now - begin >= REST_S and not busy(watch, now - REST_S):
            return
        time.sleep(PERIOD_S)


def busy(watch, since):
    """Why the machine was busy at some time since then, or None."""
    return next((why for when, why in reversed(watch.seen) if when >= since), None)


class Sleeper(threading.Thread):
    """How much later than it asked for a thread of this process was woken, at most."""

    def __init__(self):
        super().__init__(daemon=True)
        self._worst_s, self._ended = 0.0, threading.Event()
        self.start()

    def run(self):
        """Until the end."""
        ended = False
        while not ended:
            begin = time.monotonic()
            ended = self._ended.wait(PERIOD_S)
            self._worst_s = max(self._worst_s, time.monotonic() - begin - PERIOD_S)

    def end(self):
        """Seconds."""
        self._ended.set()
        self.join()
        return self._worst_s


class Retried:
    """One test's tries."""

    def __init__(self, item):
        self._item = item
        self.begin = time.monotonic()
        self._waited_s = []

    def again(self, error):
        """Is the test to be run again? One that passed is asked about as well, without an error."""
        if error is None:
            return False
        watch = self._item.config.stash[WATCH]
        if busy(watch, self.begin) is None:
            time.sleep(1.5 * WINDOW_S)  # the window in which it failed had not ended
        if (why := busy(watch, self.begin)) is None:
            return False
        rest(watch)
        self._item.user_properties.append(("ran again", f"the machine was busy ({why}): {error}"))
        return True

    def failed(self, waited_s, limit_s):
        """A try whose process waited so long; skip the test if none could answer in time."""
        self._waited_s.append(waited_s)
        if len(self._waited_s) == TRIES and min(self._waited_s) > limit_s:
            waited = ", ".join(f"{one:.2f}" for one in self._waited_s)
            pytest.skip(f"{TRIES} tries waited {waited} s for a processor, and {limit_s} s is what the test can bear")


WATCH = pytest.StashKey()
RETRIED = pytest.StashKey()


def pytest_configure(config):
    """Watch, or read what is watched outside."""
    config.addinivalue_line("markers", "real_time: waits in real time; run again where it failed on a busy machine")
    config.addinivalue_line("markers", "answers_within(seconds): its own processes must; not judged where none can")
    config.stash[WATCH] = Watch()
    if os.environ.get("TUMBLE_WATCH") != "no":
        config.stash[WATCH].start()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items):
    """A marked test may be run again, under its condition."""
    for item in items:
        if item.get_closest_marker("real_time") is not None:
            item.stash[RETRIED] = Retried(item)
            item.add_marker(pytest.mark.flaky(reruns=TRIES - 1, condition=item.stash[RETRIED].again))


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Each try has its own time."""
    if (retried := item.stash.get(RETRIED, None)) is not None:
        retried.begin = time.monotonic()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """Measure how long the process of a test that must answer in time waits."""
    marker, retried = item.get_closest_marker("answers_within"), item.stash.get(RETRIED, None)
    if marker is None or retried is None:
        return (yield)
    sleeper = Sleeper()
    try:
        return (yield)
    except AssertionError:
        retried.failed(sleeper.end(), *marker.args)
        raise
    finally:
        sleeper.end()
