"""tumble-node and tumble-gateway need no capability, as the units of the pages have it."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from processes import HASTE, Node, Stand, scenario, wait_until
from simulated_bench import built
from test_gateway import Served

DROP = "setpriv --inh-caps=-all --bounding-set=-all --no-new-privs"


@pytest.fixture
def unprivileged(tmp_path, monkeypatch):
    """From now on the program of that name is started by root without any of its capabilities."""
    if shutil.which("setpriv") is None:
        pytest.skip("setpriv is not installed (Debian: util-linux)")

    def wrap(name):
        real = built(name)
        wrapper = tmp_path / name
        wrapper.write_text(f'#!/bin/sh\nexec {DROP} "{real}" "$@"\n')
        wrapper.chmod(0o755)
        monkeypatch.setenv(name.upper().replace("-", "_"), str(wrapper))
        return Path(real).resolve()

    return wrap


def test_a_calibration_without_capabilities(bus, started, tmp_path, unprivileged):
    """The receive buffer is what the system's limit allows, and it is told; the run is as good."""
    program = unprivileged("tumble-node")
    unprivileged("tumble-gateway")
    path = scenario(tmp_path, **HASTE)
    stand = Stand(bus, path, "--seed", 7)
    node = Node(bus, path, "--start", "--nv", tmp_path / "nv.bin", folder=tmp_path)
    started += [stand, node]
    served = Served(bus)
    started.append(served)
    status = Path(f"/proc/{node.process.pid}/status")
    wait_until(lambda: Path(f"/proc/{node.process.pid}/exe").readlink() == program)  # setpriv has become it
    assert "\nCapEff:\t0000000000000000\n" in status.read_text(encoding="ascii")
    assert served.number("Link state") in (0, 1)
    code, document = node.wait()
    assert code == 0, document
    with open("/proc/sys/net/core/rmem_max", encoding="ascii") as file:
        limit = int(file.read())
    assert document["counters"]["receive_buffer_bytes"] == min(2 * limit, 8 * 2**20)
    assert document["counters"]["kernel_dropped"] == 0
    truth = stand.end()
    assert np.abs(np.array(document["K"]) - truth["truth"]["K"]).max() < 3e-3
    served.end()
