"""examples/try_gateway.sh, exactly that file, on a CAN interface."""

import os
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT
from simulated_bench import built

from tumble.store.image import MIN_SECTOR, read_image
from tumble.world import programs

SCRIPT = ROOT / "examples/try_gateway.sh"
PAGE = ROOT / "docs/operations.md"
NUMBER = r"[-+.e0-9]+"


@pytest.fixture
def try_gateway(tmp_path):
    """Run it, with the programs that these tests run."""
    for program in ("mbpoll", "awk"):
        if shutil.which(program) is None:
            pytest.skip(f"{program} is not installed")
    found = {"TUMBLE_GATEWAY": built("tumble-gateway")}
    found |= {f"TUMBLE_{name.upper()}": programs.find(f"tumble-{name}") for name in ("node", "stand")}
    command = tmp_path / "tumble"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m tumble "$@"\n')
    command.chmod(0o755)

    def run(*arguments):
        return subprocess.run([SCRIPT, *map(str, arguments)], capture_output=True, text=True, timeout=120,
                              env={**os.environ, **found, "TUMBLE": str(command)})

    return run


def shape(text):
    """Lines without what differs from run to run: numbers, and the order of what two programs say."""
    return re.sub(rf"(?<![\w]){NUMBER}(?![\w])", "#", text).splitlines()


def test_a_calibration_over_modbus_as_the_page_shows_it(bus, try_gateway, tmp_path):
    done = try_gateway(bus, tmp_path / "run")
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout)
    shown = [[float(word) for word in line.split(":")[1].split()] for line in done.stdout.splitlines()
             if re.match(" +(K, V/g|U0, V): ", line)]
    proposal, active = shown[:4], shown[4:]
    image = read_image((tmp_path / "run/memory").read_bytes(), MIN_SECTOR, "memory")
    kept = image.active
    wanted = [[*map(float, kept.k[at : at + 3])] for at in (0, 3, 6)] + [[*map(float, kept.u0)]]
    assert proposal == active and active == [pytest.approx(row, rel=1e-5, abs=1e-8) for row in wanted]
    on_page = re.search(r"^tumble-stand, tumble-node and tumble-gateway run on .*?^checkpoint: [^\n]*$",
                        PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)[0]
    assert shape(on_page) == shape(done.stdout.replace(str(bus), "vcan0").rstrip())


def test_a_folder_that_is_in_use_and_an_interface_that_is_not_there(bus, try_gateway, tmp_path):
    done = try_gateway(bus, tmp_path)
    assert (done.returncode, done.stderr) == (2, f"try_gateway: {tmp_path} is not empty\n")
    done = try_gateway("can999", tmp_path / "run")
    last = "try_gateway: a program has ended by itself while waiting for the gateway"
    assert done.returncode == 2 and done.stderr.splitlines()[-1] == last
    assert re.search("tumble-(node|stand): can999: there is no CAN interface of this name", done.stderr)
