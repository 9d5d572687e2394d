"""What is known of a run, for Prometheus: the numbers of a snapshot under names with their units, and their help as
docs/bench.md and the schema tumble.watch/1 have it. What is unknown is left out.

Needs prometheus-client.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import SimpleNamespace
from typing import Any

from prometheus_client import CONTENT_TYPE_PLAIN_0_0_4, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric

from tumble.documents.base import described
from tumble.documents.watch import Gravity, Mean, Snapshot
from tumble.firmware_tables import STATES
from tumble.watch.snapshot import View

CONTENT_TYPE = CONTENT_TYPE_PLAIN_0_0_4
_GAUGES: dict[type, dict[str, str]] = {  # by key of a document: the name; vectors have labels
    Snapshot: {
        "mounting": "mounting",
        "position": "position",
        "count": "positions",
        "finished": "positions_finished",
        "attempt": "attempt",
        "samples": "position_samples",
        "wanted": "position_samples_wanted",
        "angle_rad": "table_angle_radians",
        "target_rad": "table_target_radians",
        "temperature_c": "block_temperature_celsius",
        "k_v_per_g": "k_volts_per_g",
        "u0_v": "u0_volts",
        "u_k_v_per_g": "k_standard_uncertainty_volts_per_g",
        "u_u0_v": "u0_standard_uncertainty_volts",
        "virtual_s": "virtual_time_seconds",
        "over": "over",
    },
    Mean: {"mean_v": "mean_volts", "standard_error_v": "mean_standard_error_volts"},
    Gravity: {
        "max_fit_g": "gravity_fit_deviation_g",
        "max_check_g": "gravity_check_deviation_g",
        "limit_g": "gravity_limit_g",
        "passed": "gravity_passed",
    },
}


def text(view: View) -> bytes:
    """In the text format 0.0.4."""
    return generate_latest(SimpleNamespace(collect=lambda: _families(view)))


def _families(view: View) -> Iterator[Metric]:
    yield GaugeMetricFamily("tumble_up", "Whether the source answers.", float(view.lost_since is None))
    yield GaugeMetricFamily("tumble_last_change_timestamp_seconds", "When anything was new.", view.time)
    now = view.snapshot or Snapshot()
    if now.run is not None:
        yield CounterMetricFamily("tumble_runs", "Runs since power-on.", now.run)
    if now.state is not None:
        states = {(one,): float(one == now.state) for one in STATES}
        yield _labelled("state", "1 for the state of the run.", states, "state")
    if now.reason is not None:
        yield _labelled("reason", "1 for what is wrong.", {(now.reason,): 1.0}, "reason")
    if now.emergencies:
        raised = dict.fromkeys(now.emergencies.items(), 1.0)
        yield _labelled("emergency", "1 for an emergency that a node has raised.", raised, "node", "code")
    for part in filter(None, (now, now.mean, now.gravity)):
        about = described(type(part))[1]
        for key, name in _GAUGES[type(part)].items():
            if (value := getattr(part, key)) is not None:
                found = _by_axes(value)
                labels = ("channel", "axis")[: len(next(iter(found)))]
                yield _labelled(name, about.get(key) or f"{key.capitalize()} of the run.", found, *labels)


def _by_axes(value: Any) -> dict[tuple[str, ...], float]:
    """A number, a vector by channel, a matrix by channel and axis."""
    if not isinstance(value, tuple):
        return {(): float(value)}
    return {(axis, *more): one for axis, part in zip("xyz", value) for more, one in _by_axes(part).items()}


def _labelled(name: str, about: str, values: Mapping[Any, float], *labels: str) -> Metric:
    family = GaugeMetricFamily(f"tumble_{name}", about, labels=labels)
    for told, value in values.items():
        family.add_metric(told, float(value))
    return family
