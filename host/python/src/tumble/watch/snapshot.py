"""What is known of a run at one moment. Unknown is None; every number has its unit in its name."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

from tumble.watch import words

SCHEMA = "tumble.watch/1"

Vector = tuple[float, ...]  # of the channels x, y, z
Matrix = tuple[Vector, ...]


class Lost(Exception):
    """The source does not answer; says why, in words that can follow "connection lost: "."""


@dataclass(frozen=True)
class Gravity:
    """The gravity check: the largest deviations from 1 g on positions that were fitted and on check positions, g.
    `limit_g`: what they are held to. `passed`: None while it has not been made."""

    max_fit_g: float | None
    max_check_g: float | None
    limit_g: float | None
    passed: bool | None

    @property
    def worst_g(self) -> float | None:
        """The larger of the two deviations."""
        known = [value for value in (self.max_fit_g, self.max_check_g) if value is not None]
        return max(known, default=None)


@dataclass(frozen=True)
class Mean:
    """The running mean of a position, and the standard error of it, V; of so many samples of `wanted`. The last one
    stays until there is another."""

    mounting: int | None
    position: int | None
    samples: int | None
    wanted: int | None
    mean_v: Vector
    standard_error_v: Vector | None


@dataclass(frozen=True)
class Snapshot:
    """Of a navigation computer and its run.

    `state`, `reason`, `stand`: names of the firmware without prefix, such as AVERAGE; `reason` is None where nothing is
    wrong. `trouble`: what the source itself says of it. `run`: its number. `mounting`, `position`: their numbers in the
    schedule; `finished` of `count` positions have a mean; `samples` of `wanted` are in the open one. `angle_rad`,
    `target_rad`: of the table. `temperature_c`: of the block. `k_v_per_g` (3 x 3), `u0_v`: of the last run, with their
    standard uncertainties. `emergencies`: by name of the node, the CiA 301 error code that it has raised, four
    hexadecimal digits. `virtual_s`: the time of a simulated run. `over`: nothing more will come.
    """

    state: str | None = None
    reason: str | None = None
    trouble: str | None = None
    run: int | None = None
    mounting: int | None = None
    position: int | None = None
    count: int | None = None
    finished: int | None = None
    attempt: int | None = None
    samples: int | None = None
    wanted: int | None = None
    stand: str | None = None
    angle_rad: float | None = None
    target_rad: float | None = None
    temperature_c: float | None = None
    mean: Mean | None = None
    k_v_per_g: Matrix | None = None
    u0_v: Vector | None = None
    u_k_v_per_g: Matrix | None = None
    u_u0_v: Vector | None = None
    gravity: Gravity | None = None
    emergencies: dict[str, str] = field(default_factory=dict)
    virtual_s: float | None = None
    over: bool = False


class Source(Protocol):
    """Something that a run can be seen at."""

    def snapshot(self) -> Snapshot:
        """What is known now. Raises Lost."""

    def close(self) -> None:
        """Ask nothing more."""


@dataclass(frozen=True)
class View:
    """What those who look on are shown: the last snapshot (None: there was none), and whether it is still true.

    `name`: of the source. `time`: when that was found out, `lost_since`: since when the source has not answered; both
    in seconds since 1970 UTC. `why` it does not."""

    name: str
    number: int
    time: float
    snapshot: Snapshot | None = None
    lost_since: float | None = None
    why: str | None = None


def document(view: View) -> dict[str, Any]:
    """A view as a document of schema tumble.watch/1. What is not finite is unknown."""
    lost = None if view.lost_since is None else {"since_unix_s": view.lost_since, "why": view.why}
    shown = None if view.snapshot is None else {**asdict(view.snapshot), **_in_words(view.snapshot)}
    found = {"source": view.name, "time_unix_s": view.time, "lost": lost, "snapshot": shown}
    return {"schema": SCHEMA, **_known(found)}


def _in_words(snapshot: Snapshot) -> dict[str, str | None]:
    of_reason = {"sentence": words.sentence(snapshot.reason), "remedy": words.remedy(snapshot.reason)}
    return {"meaning": words.meaning(snapshot.state), **of_reason}


def _known(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _known(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_known(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def without_prefix(name: str) -> str:
    """A name of the firmware as people say it: AVERAGE for TUMBLE_STATE_AVERAGE."""
    for prefix in ("TUMBLE_STATE_", "TUMBLE_REASON_", "TUMBLE_STAND_"):
        name = name.removeprefix(prefix)
    return name
