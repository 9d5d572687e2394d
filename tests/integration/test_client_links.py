"""What tumble.client.connect takes for a link, and which libraries it loads."""

import errno
import re
import subprocess
import sys

import pytest

from tumble import client
from tumble.errors import NotInstalled, Skipped, UsageError

can = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytestmark = pytest.mark.python


@pytest.mark.parametrize(
    ("link", "said"),
    [
        ("serial:x", "the link 'serial:x' is not can:INTERFACE, "),
        ("can:", "the link 'can:' is not "),
        ("modbus:localhost", "has no HOST:PORT"),
        ("modbus:localhost:99999", "has no HOST:PORT"),
        ("modbus-rtu:/dev/tty,9600,X", "with parity N, E or O"),
        ("modbus-rtu:/dev/tty,9600,E,1", "with parity N, E or O"),
    ],
)
def test_what_is_no_link(link, said):
    with pytest.raises(UsageError, match=re.escape(said)):
        client.connect(link)


@pytest.mark.parametrize("link", [
    "can:@", "can:virtual@", "can:@can0", "can:nosuch@x", "can:slcan@/dev/nonexistent", None, 5,
])
def test_a_link_that_cannot_be_opened_is_a_matter_of_usage(link):
    with pytest.raises(UsageError):
        client.connect(link)


@pytest.mark.parametrize(("error", "kind"), [
    (OSError(errno.EAFNOSUPPORT, "x"), Skipped),
    (OSError(errno.ENODEV, "x"), UsageError),
    (OSError("AF_CAN path/interface name too long"), UsageError),
    (can.CanInterfaceNotImplementedError("no driver"), Skipped),
    (can.CanInitializationError("no device"), UsageError),
])
def test_only_what_the_machine_lacks_is_a_skip(monkeypatch, error, kind):
    def fail(**_):
        raise error

    monkeypatch.setattr(can, "Bus", fail)
    with pytest.raises(kind, match="can:can7"):
        client.connect("can:can7")


@pytest.mark.parametrize("given", [{"server": 3}, {"server": 0}, {"node": 0}, {"node": 128}, {"node": "x"},
                                   {"unit": 256}, {"unit": None}])
def test_a_number_that_no_node_has_leaves_the_bus_free(given):
    with can.Bus(interface="virtual", channel="numbers") as bus:
        with pytest.raises(UsageError, match=f"{next(iter(given))} .* is not 1 to "):
            client.connect(bus, **given)
        with client.connect(bus), pytest.raises(UsageError, match="the bus has a client"):
            client.connect(bus)


@pytest.mark.parametrize("library", ["can", "canopen", "pymodbus"])
def test_a_library_that_is_missing_is_named_with_the_extra_that_has_it(monkeypatch, library):
    for name in [one for one in sys.modules if one.partition(".")[0] == library]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    link = "modbus:127.0.0.1:1" if library == "pymodbus" else "can:virtual@missing"
    with pytest.raises(NotInstalled, match=rf"needs (python-)?{library}: tools/setup watch"):
        client.connect(link)


def test_libraries_say_nothing_beside_the_exception():
    pytest.importorskip("pymodbus", reason="pymodbus is not installed")
    program = "import tumble.client as c\ntry: c.connect('modbus:127.0.0.1:1')\nexcept Exception as e: print(e)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("the gateway cannot be reached\n", "")


def test_the_package_loads_no_library_of_a_bus():
    program = "import sys, tumble.client; print({'can', 'canopen', 'pymodbus'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("set()\n", "")
