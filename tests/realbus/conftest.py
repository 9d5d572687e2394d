"""Tests on CAN interfaces of Linux, each on a virtual one of its own. As root, where the kernel has vcan; tools/realbus
brings them into user-mode Linux where it has not.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/integration"), str(ROOT / "tests/lib")]

from processes import Interface  # noqa: E402

pytest_plugins = ["busy_machine", "hang_guards", "heeding_interrupts"]
os.environ["TUMBLE_NO_REPORT"] = "1"  # of every bench, for the time it takes
_number = iter(range(1, 1000))

# Neither requests to the second SDO server nor its answers, with which a gateway fills a virtual interface: that has no
# bit rate, python-canopen falls behind, and the kernel drops the answer that it waits for.
NOT_OF_THE_SECOND_SERVER = [
    {"can_id": group, "can_mask": 0x780} for group in range(0, 0x800, 0x80) if group not in (0x380, 0x400)
]


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="run the long ones too")


def pytest_collection_modifyitems(config, items):
    for item in items:
        item.add_marker(pytest.mark.real_time)
        if "full" in item.keywords and not config.getoption("--full"):
            item.add_marker(pytest.mark.skip(reason="takes long: --full runs it"))


@pytest.fixture
def bus():
    """A fresh interface, up; gone in the end."""
    interface = Interface(f"vcan{next(_number)}")
    yield interface
    interface.remove()


@pytest.fixture
def network(bus):
    """python-canopen on the interface."""
    canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
    made = canopen.Network()
    made.NOTIFIER_CYCLE = 0.01
    made.connect(interface="socketcan", channel=str(bus), can_filters=NOT_OF_THE_SECOND_SERVER)
    yield made
    made.disconnect()


@pytest.fixture
def started():
    """Processes to be killed in the end, if they have not ended by then."""
    processes = []
    yield processes
    for process in processes:
        process.kill()


@pytest.fixture
def tumble():
    """Run `tumble ...` in a process of its own."""

    def run(*arguments, **options):
        return subprocess.run([sys.executable, "-m", "tumble", *map(str, arguments)], capture_output=True, text=True,
                              env=dict(os.environ), timeout=120, **options)

    return run
