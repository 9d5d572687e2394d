"""Campaigns of simulated runs, and the fault campaign, in pieces: the same numbers with any team."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.documents import base
from tumble.documents.campaign import HOSTILE, Campaign, ErrorsOfK, ErrorsOfU0, Exits, Hostile
from tumble.documents.result import Table
from tumble.errors import EXIT_DISAGREEMENT, EXIT_LIMITS_FAILED, EXIT_PASS, UsageError
from tumble.workers.over import ALONE, Job, Piece, Progress, Result, Team, over
from tumble.world.border import ENDED, FOREVER_US, Border, Refused
from tumble.world.fault_campaign import FaultCampaign

_SEEDS = 100  # in a piece
_FIRST = 10  # violations that a campaign shrinks
_ENDS = (EXIT_PASS, EXIT_LIMITS_FAILED, EXIT_DISAGREEMENT)  # of a campaign that came to its end, from good to bad
_MICROSECOND = 1e-6


@dataclass(frozen=True)
class Ended:
    """A piece of a campaign: what is to be printed, what to be said to people, and the exit code. `kept`: nobody has
    done it now."""

    output: str
    said: str
    code: int
    cpu_s: float | None = None  # unknown of what an earlier version has kept
    kept: bool = False


@dataclass(frozen=True)
class Runs:
    """A job: calibrations, a line of JSON each. `lines`: of a scenario called `file`; `with_means`: those of all
    positions too; `gains`: the record of the estimator `optimal`."""

    lines: tuple[str, ...]
    file: str
    with_means: bool
    gains: bytes | None = None

    def __call__(self, seeds: tuple[int, int]) -> Result:
        first, count = seeds
        cpu_s = time.process_time()
        found = [self._run(seed) for seed in range(first, first + count)]
        code = max((line["exit"] for line in found), key=_ENDS.index)
        output = "".join(_text(line) + "\n" for line in found)
        cpu_s = time.process_time() - cpu_s
        return {"output": output, "said": "", "code": np.array([code]), "cpu_s": np.array([cpu_s])}

    def _run(self, seed: int) -> dict[str, Any]:
        try:
            border = Border(seed, self.lines, self.gains, records=False)
        except Refused as refused:
            hint = "; a scenario file is wanted, not a stand file" if self.file.endswith(".toml") else ""
            raise UsageError(f"this cannot be simulated: {refused.where(self.file)}{hint}") from None
        while not border.advance(FOREVER_US, 0) & ENDED:
            pass
        found, none = border.told(), {"pass": False, "max_abs_delta_g_g": None}
        check, truth = found["verification"] or none, found["truth"]
        line = {
            "seed": seed,
            **{name: found[name] for name in ("exit", "state", "reason")},
            "pass": check["pass"],
            "K": found["K"] and [element for row in found["K"] for element in row],
            "U0": found["U0"],
            "max_abs_delta_g_g": check["max_abs_delta_g_g"],
            "truth": {"K": [element for row in truth["K"] for element in row], "U0": truth["U0"]},
            "virtual_s": found["virtual_s"],
            "frames": found["counters"]["bus_frames"],
            "table": found["table"],
        }
        if self.with_means:
            means = {(one["mounting"], one["position"]): one["u_v"] for one in found["means"]}
            line["means"] = [volt for one in border.positions() for volt in means.get(one, (None, None, None))]
        return line


def _text(value: Any) -> str:
    """JSON on one line, numbers with 17 digits: so equal bytes are equal bits, and programs that compare lines of
    earlier versions find them the same."""
    if isinstance(value, dict):
        return "{" + ",".join(f'"{name}":{_text(one)}' for name, one in value.items()) + "}"
    if isinstance(value, list):
        return f"[{','.join(map(_text, value))}]"
    return f"{value:.17g}" if isinstance(value, float) else json.dumps(value)


class Summary:
    """Statistics of calibrations, schema tumble.campaign/1, from their lines; `jobs`: how many did them."""

    def __init__(self, first_seed: int, jobs: int):
        self._first_seed, self._jobs = first_seed, jobs
        self._began_s = time.perf_counter()
        self._cpu_s: float | None = 0.0
        self._runs = self._known = self._frames = 0
        self._done_now = self._frames_now = 0
        self._virtual_s = 0.0
        self._exits, self._reasons = dict.fromkeys(("0", "1", "3"), 0), Counter[str]()
        self._tables: list[dict[str, Any]] = []
        self._sum, self._square_sum = np.zeros(12), np.zeros(12)

    def add(self, ended: Ended) -> None:
        """The lines of a piece."""
        self._cpu_s = None if self._cpu_s is None or ended.cpu_s is None else self._cpu_s + ended.cpu_s
        for line in map(json.loads, ended.output.splitlines()):
            self._runs += 1
            self._exits[str(line["exit"])] += 1
            self._reasons[line["reason"]] += 1
            self._frames += line["frames"]
            self._done_now += not ended.kept
            self._frames_now += 0 if ended.kept else line["frames"]
            self._virtual_s += line["virtual_s"]
            self._tables = [_travelled([*self._tables, line["table"]])]
            if line["K"] is not None:
                truth = line["truth"]
                error = np.array([*line["K"], *line["U0"]]) - np.array([*truth["K"], *truth["U0"]])
                self._known += 1
                self._sum += error
                self._square_sum += error**2

    def document(self) -> Campaign:
        """All of it."""
        wall_s = time.perf_counter() - self._began_s
        mean: list[float | None] = [None] * 12
        rms = mean
        if self._known:
            mean, rms = (self._sum / self._known).tolist(), np.sqrt(self._square_sum / self._known).tolist()
        return Campaign(
            runs=self._runs,
            first_seed=self._first_seed,
            exits=Exits(*self._exits.values()),
            reasons=dict(self._reasons),
            K=ErrorsOfK(tuple(mean[:9]), tuple(rms[:9])),
            U0=ErrorsOfU0(tuple(mean[9:]), tuple(rms[9:])),
            frames=self._frames,
            virtual_s=self._virtual_s,
            table=Table(**self._tables[0]),
            jobs=self._jobs,
            wall_s=wall_s,
            cpu_s=self._cpu_s,
            calibrations_per_s=self._done_now / wall_s,
            frames_per_s=self._frames_now / wall_s,
            calibrations_per_cpu_s=self._runs / self._cpu_s if self._cpu_s else None,
            frames_per_cpu_s=self._frames / self._cpu_s if self._cpu_s else None,
        )


class FaultCampaignJob:
    """A job: runs of the fault campaign (host/world/fault_campaign.h), a document of each piece."""

    def __call__(self, seeds: tuple[int, int]) -> Result:
        first, count = seeds
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        campaign, said = FaultCampaign(), []
        parts: list[dict[str, Any]] = []
        for seed in range(first, first + count):
            part = campaign.run_seed(seed)
            if part["violated"]:
                shrunk = campaign.shrunk(seed) if sum(len(one["first"]) for one in parts) < _FIRST else None
                part["first"] = [] if shrunk is None else [shrunk]
                enough = f"; {len(shrunk['events'])} of {shrunk['drawn']} events are enough" if shrunk else ""
                said.append(f"seed {seed}: {part.pop('said')}{enough}\n")
            parts.append(part)
        found = _total(parts)
        found["speed"] = {"wall_s": time.perf_counter() - wall_s, "cpu_s": time.process_time() - cpu_s}
        code = EXIT_DISAGREEMENT if found["violated"] else EXIT_PASS
        return {"output": json.dumps(found), "said": "".join(said), "code": np.array([code])}


def ended(
    job: Job, seed: int, count: int, team: Team = ALONE, progress: Progress = lambda seeds: None
) -> Iterator[Ended]:
    """Of seeds from `seed` on, in their order. Raises UsageError."""
    kept: list[bool] = []

    def pieces() -> Iterator[Piece]:
        for piece in _pieces(seed, count):
            kept.append(team.kept is not None and team.kept.get(piece.name) is not None)
            yield piece

    for place, result in enumerate(over(pieces(), job, team, progress)):
        cpu_s = float(result["cpu_s"][0]) if "cpu_s" in result else None
        yield Ended(result["output"], result["said"], int(result["code"][0]), cpu_s, kept[place])


def _pieces(seed: int, count: int) -> Iterator[Piece]:
    for first in range(seed, seed + count, _SEEDS):
        yield piece(first, min(_SEEDS, seed + count - first))


def piece(first: int, count: int) -> Piece:
    """Seeds from `first` on."""
    if count == 1:
        return Piece(f"seed {first}", (first, 1))
    half = count // 2
    return Piece(
        f"seeds {first} to {first + count - 1}",
        (first, count),
        count,
        lambda: (piece(first, half), piece(first + half, count - half)),
    )


def worse(one: int, other: int) -> int:
    """Of two exit codes."""
    return max(one, other, key=_ENDS.index)


def of_runs(scenario: bytes | None, file: str, with_means: bool) -> Runs:
    """Calibrations by a scenario called `file`; None: the paper's stand."""
    lines = () if scenario is None else tuple(scenario.decode("ascii", "replace").split("\n"))
    return Runs(lines, file, with_means)


def merged(first_seed: int, documents: list[str]) -> Hostile:
    """The document of all runs, tumble.hostile/1, from those of their pieces, in order; `speed` is that of one
    process."""
    found = _total([json.loads(one) for one in documents])
    found |= {"schema": HOSTILE, "first_seed": first_seed, "virtual_s": found["virtual_us"] * _MICROSECOND}
    found["speed"] |= {"jobs": 1, "ms_per_life": 1e3 * found["speed"]["cpu_s"] / found["runs"]}
    found["ends"] = {state: {name: n for name, n in reasons.items() if n} for state, reasons in found["ends"].items()}
    return base.checked(Hostile, HOSTILE, found, "the lives")


def _total(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Of documents alike: sums, but for the first violations and how far the tables have turned."""
    own: dict[str, Callable[[list[Any]], Any]] = {
        "first": lambda found: [one for part in found for one in part][:_FIRST],
        "table": _travelled,
    }
    return {name: own.get(name, _sum)([part[name] for part in parts]) for name in parts[0]}


def _sum(values: list[Any]) -> Any:
    if isinstance(values[0], dict):
        return {name: _sum([value[name] for value in values]) for name in values[0]}
    return sum(values)


def _travelled(tables: list[dict[str, Any]]) -> dict[str, Any]:
    """Of several tables."""
    return {
        "at_rest": all(bool(one["at_rest"]) for one in tables),
        "lowest_deg": min((one["lowest_deg"] for one in tables), default=0.0),
        "highest_deg": max((one["highest_deg"] for one in tables), default=0.0),
    }
