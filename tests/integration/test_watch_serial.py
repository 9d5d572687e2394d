"""tumble watch modbus-rtu:... at tumble-gateway, over a pair of pseudo terminals, before a node that the test plays."""

import subprocess
import sys

import documents
import pytest
from played_node import STATE, U0, K
from simulated_bench import wait_until
from test_watch_node import averaging, with_result

from tumble import data

canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
pytest.importorskip("pymodbus", reason="pymodbus is not installed")
pytest.importorskip("serial", reason="pyserial is not installed")
pytestmark = [pytest.mark.slow, pytest.mark.python, pytest.mark.real_time]


def objects(values):
    """{(index, subindex): bytes} of objects by name."""
    dictionary, found = canopen.import_od(str(data.file("eds/tumble_navcomp.eds"))), {}
    for name, value in values.items():
        record, _, entry = name.partition(": ")
        variable = dictionary[record][entry] if entry else dictionary[record]
        found[variable.index, variable.subindex] = variable.encode_raw(value)
    return found


@pytest.fixture
def watched(serve, far_end):
    """(gateway whose node is in DONE, what watch is told); in the end nobody has written anything."""
    gateway = serve("--allow-commands", parity="N")  # pseudo terminals have none, and pyserial insists
    gateway.set_all(objects(with_result(averaging())))
    gateway.wait_fresh()
    yield gateway, f"modbus-rtu:{far_end},19200,N"
    assert gateway.written.empty()


def watch(source, *arguments):
    return [sys.executable, "-m", "tumble", "watch", source, *arguments]


def test_one_snapshot(watched):
    _gateway, source = watched
    done = subprocess.run(watch(source, "--json"), capture_output=True, text=True, timeout=60)
    seen = documents.document_of(done, "watch")["snapshot"]
    assert (seen["state"], seen["run"], seen["mounting"], seen["position"]) == ("DONE", 2, 1, 4)
    for row, wanted in zip([*seen["k_v_per_g"], seen["u0_v"]], [*K, U0], strict=True):
        assert row == pytest.approx(wanted, abs=1e-6)  # as fine as its registers are


def test_a_run_as_it_goes(watched, tmp_path):
    gateway, source = watched
    with open(tmp_path / "lines", "w+", encoding="utf-8") as file:
        process = subprocess.Popen(watch(source, "--every", "0.1"), stdout=file, stderr=subprocess.STDOUT)
        try:
            for state in ("DONE", "PREFLIGHT", "WAIT_MOUNTING"):
                gateway.set(0x2000, 0, bytes([STATE[state]]), boot=False)
                wait_until(lambda state=state: f" {state}" in (tmp_path / "lines").read_text(encoding="utf-8"))
        finally:
            process.kill()
            process.wait()


def test_a_line_that_nobody_answers_on(far_end):
    done = subprocess.run(watch(f"modbus-rtu:{far_end},19200,N", "--json"), capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (3, "") and far_end in done.stderr and len(done.stderr.splitlines()) == 1
