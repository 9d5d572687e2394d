"""Campaigns of tumble-bench in pieces: what one process of it would print, whoever the team is."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.bench import program
from tumble.bench.programs import last_words
from tumble.errors import EXIT_BAD_INPUT, EXIT_DISAGREEMENT, EXIT_LIMITS_FAILED, EXIT_PASS, BenchFault, UsageError
from tumble.workers.over import ALONE, Progress, Team, over
from tumble.workers.pieces import Piece, Result

_SEEDS = 100  # in a piece
_FIRST = 10  # violations that a campaign shrinks
_ENDS = (EXIT_PASS, EXIT_LIMITS_FAILED, EXIT_DISAGREEMENT)  # of a campaign that came to its end, from good to bad
_MICROSECOND = 1e-6


@dataclass(frozen=True)
class Ended:
    """A piece of a campaign: what was printed, what was said to people, and the exit code."""

    output: str
    said: str
    code: int


@dataclass(frozen=True)
class Campaign:
    """A job: so many seeds from one on. `options`: of tumble-bench, before these; `scenario`: on its standard input."""

    options: tuple[str, ...]
    count_option: str
    scenario: bytes = b""

    def __call__(self, seeds: tuple[int, int]) -> Result:
        first, count = seeds
        command = [program.find(), *self.options, self.count_option, str(count), "--seed", str(first), "--jobs", "1"]
        try:  # in a session of its own: Ctrl-C is for who has cut the campaign
            done = subprocess.run(command, input=self.scenario, capture_output=True, start_new_session=True)
        except OSError as error:
            raise BenchFault(f"tumble-bench cannot be started: {(error.strerror or 'unknown').lower()}") from None
        said = done.stderr.decode(errors="replace")
        if done.returncode == EXIT_BAD_INPUT:
            raise UsageError(f"this cannot be simulated: {last_words(said)}")
        if done.returncode not in _ENDS:
            raise BenchFault(f"tumble-bench failed ({done.returncode}): {last_words(said)}")
        return {"output": done.stdout.decode(), "said": said, "code": np.array([done.returncode])}

    def ended(
        self, seed: int, count: int, team: Team = ALONE, progress: Progress = lambda seeds: None
    ) -> Iterator[Ended]:
        """Of seeds from `seed` on, in their order. Raises UsageError, BenchFault."""
        for result in over(_pieces(seed, count), self, team, progress):
            yield Ended(result["output"], result["said"], int(result["code"][0]))


def _pieces(seed: int, count: int) -> Iterator[Piece]:
    for first in range(seed, seed + count, _SEEDS):
        here = min(_SEEDS, seed + count - first)
        yield Piece(f"seeds {first} to {first + here - 1}", (first, here), here)


def worse(one: int, other: int) -> int:
    """Of two exit codes."""
    return max(one, other, key=_ENDS.index)


def of_runs(scenario: bytes | None, with_means: bool) -> Campaign:
    """Calibrations: lines of JSON (host/bench/campaign.h). `scenario`: None for the paper's stand."""
    given = () if scenario is None else ("-",)
    return Campaign((*given, *(("--means",) if with_means else ())), "--runs", scenario or b"")


LIVES = Campaign((), "--campaign")  # hostile ones: a document of each piece (host/bench/hostile.h)


def merged(documents: list[str]) -> dict[str, Any]:
    """The document of all lives from those of their pieces, in order; `speed` is that of one process."""
    parts = [json.loads(document) for document in documents]
    tables = [part.pop("table") for part in parts]
    first_seed, virtual_us = parts[0]["first_seed"], sum(round(part["virtual_s"] / _MICROSECOND) for part in parts)
    found: dict[str, Any] = parts[0]
    for part in parts[1:]:
        found = _sum(found, part)
    speed = {**found["speed"], "jobs": 1, "ms_per_life": 1e3 * found["speed"]["cpu_s"] / found["runs"]}
    table = {
        "at_rest": all(one["at_rest"] for one in tables),
        "lowest_deg": min(one["lowest_deg"] for one in tables),
        "highest_deg": max(one["highest_deg"] for one in tables),
    }
    own = {"first_seed": first_seed, "table": table, "virtual_s": virtual_us * _MICROSECOND, "speed": speed}
    return {**found, **own}


def _sum(one: Any, other: Any) -> Any:
    if isinstance(one, dict):
        return {
            name: _sum(one[name], other[name]) if name in one and name in other else {**other, **one}[name]
            for name in {**one, **other}
        }
    if isinstance(one, list):
        return [*one, *other][:_FIRST]
    return one if isinstance(one, str) else one + other
