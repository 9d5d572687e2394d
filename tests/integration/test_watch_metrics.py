"""tumble watch --metrics, read by Prometheus' own parser."""

import subprocess
import sys
import urllib.error
import urllib.request

import pytest
from msgspec.structs import replace
from played_run import AVERAGING, DONE, FAULT, U0, U_K, U_U0, K, PlayedSource

from tumble.firmware_tables import STATES
from tumble.watch.runs import Follower
from tumble.watch.snapshot import Lost, View

prometheus = pytest.importorskip("prometheus_client", reason="prometheus-client is not installed")
pytest.importorskip("starlette", reason="starlette is not installed")

from prometheus_client.parser import text_string_to_metric_families  # noqa: E402

from tumble.watch import metrics  # noqa: E402
from tumble.watch.server import Server  # noqa: E402

pytestmark = pytest.mark.python


def families(text):
    return {family.name: family for family in text_string_to_metric_families(text.decode())}


def values(text):
    """By name of the sample and its labels."""
    return {(sample.name, *sorted(sample.labels.items())): sample.value
            for family in families(text).values() for sample in family.samples}  # fmt: skip


def of(snapshot, **more):
    return values(metrics.text(View("played", 1, 1e9, snapshot, **more)))


def by_channel(name, vector):
    return {(name, ("channel", axis)): value for axis, value in zip("xyz", vector)}


def by_axes(name, matrix):
    return {(name, ("axis", axis), ("channel", channel)): value
            for channel, row in zip("xyz", matrix) for axis, value in zip("xyz", row)}  # fmt: skip


def states(now):
    return {("tumble_state", ("state", name)): float(name == now) for name in STATES}


def test_a_run_that_averages():
    assert of(AVERAGING) == {
        ("tumble_up",): 1.0,
        ("tumble_last_change_timestamp_seconds",): 1e9,
        ("tumble_runs_total",): 3.0,
        **states("AVERAGE"),
        ("tumble_mounting",): 1.0,
        ("tumble_position",): 4.0,
        ("tumble_positions",): 18.0,
        ("tumble_positions_finished",): 3.0,
        ("tumble_attempt",): 0.0,
        ("tumble_position_samples",): 34.0,
        ("tumble_position_samples_wanted",): 50.0,
        ("tumble_table_angle_radians",): AVERAGING.angle_rad,
        ("tumble_table_target_radians",): AVERAGING.target_rad,
        ("tumble_block_temperature_celsius",): 24.5,
        ("tumble_virtual_time_seconds",): 11.9,
        ("tumble_over",): 0.0,
        **by_channel("tumble_mean_volts", AVERAGING.mean.mean_v),
        **by_channel("tumble_mean_standard_error_volts", AVERAGING.mean.standard_error_v),
        ("tumble_gravity_limit_g",): 3e-4,
    }


def test_a_run_that_is_done_and_one_that_failed():
    done = of(DONE)
    expected = {
        **states("DONE"),
        **by_axes("tumble_k_volts_per_g", K),
        **by_axes("tumble_k_standard_uncertainty_volts_per_g", U_K),
        **by_channel("tumble_u0_volts", U0),
        **by_channel("tumble_u0_standard_uncertainty_volts", U_U0),
        ("tumble_gravity_fit_deviation_g",): 5.79e-5,
        ("tumble_gravity_passed",): 1.0,
        ("tumble_over",): 1.0,
    }
    assert expected.items() <= done.items()
    fault = of(FAULT)
    assert fault[("tumble_reason", ("reason", "STALL"))] == 1.0
    assert fault[("tumble_emergency", ("code", "8611"), ("node", "drive"))] == 1.0
    odd = of(replace(FAULT, emergencies={'a "b"\\\n': "0001"}))
    assert odd[("tumble_emergency", ("code", "0001"), ("node", 'a "b"\\\n'))] == 1.0


def test_a_source_that_does_not_answer():
    assert values(metrics.text(View("x", 0, 5.0))) == {
        ("tumble_up",): 1.0, ("tumble_last_change_timestamp_seconds",): 5.0, ("tumble_over",): 0.0}  # fmt: skip
    lost = of(AVERAGING, lost_since=1e9, why="gone")
    assert lost[("tumble_up",)] == 0.0 and lost[("tumble_positions_finished",)] == 3.0


def test_every_family_has_its_kind_and_its_help():
    found = {**families(metrics.text(View("x", 1, 1.0, replace(DONE, mean=AVERAGING.mean)))),
             **families(metrics.text(View("x", 1, 1.0, AVERAGING)))}  # fmt: skip
    assert {name: family.type for name, family in found.items() if family.type != "gauge"} == {"tumble_runs": "counter"}
    assert all(family.documentation.endswith(".") for family in found.values())
    assert found["tumble_table_angle_radians"].documentation.startswith("Of the table; ")


@pytest.mark.parametrize("has_metrics", [True, False])
def test_the_page_serves_them_if_it_is_asked_to(has_metrics):
    follower = Follower(PlayedSource(AVERAGING, Lost("gone")), "played", 1.0)
    with Server(follower.view, "127.0.0.1", 0, has_metrics) as server:
        if not has_metrics:
            with pytest.raises(urllib.error.HTTPError, match="404"):
                urllib.request.urlopen(server.url + "metrics", timeout=20)
            return
        for up in (1.0, 0.0):
            follower.ask()
            with urllib.request.urlopen(server.url + "metrics", timeout=20) as answer:
                assert answer.headers["Content-Type"] == "text/plain; version=0.0.4; charset=utf-8"
                assert values(answer.read())[("tumble_up",)] == up


def test_without_the_package_one_line_says_so():
    code = ("import sys; sys.modules['prometheus_client'] = None; from tumble.cli.main import main; "
            "sys.exit(main(['watch', 'bench', '--metrics', '--http', '127.0.0.1:0']))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 77 and done.stdout == ""
    assert done.stderr == "tumble: --metrics needs prometheus-client: tools/setup watch\n"
