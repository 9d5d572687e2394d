"""tumble.client on a node that the tests play: the whole of a run, and every way in which it can end otherwise."""

import logging
import subprocess
import sys

import pytest
from played_node import U0, K, PlayedCanNode

from tumble import client
from tumble.errors import TumbleError, UsageError

pytest.importorskip("canopen", reason="python-canopen is not installed")
pytestmark = pytest.mark.python
logging.getLogger("canopen").setLevel(logging.CRITICAL)


@pytest.fixture
def played():
    """Make (node that is played, node that a client has)."""
    opened = []

    def begin(**keys):
        node = PlayedCanNode(**keys)
        opened.extend([node, client.connect(f"can:virtual@{node.channel}")])
        return opened[-2:]

    yield begin
    for one in reversed(opened):
        one.close()


def test_a_run_from_start_to_accept(played):
    theirs, node = played()
    assert (node.state, node.reason.name, node.run) == ("IDLE", "NONE", 0)
    assert node.start() == "PREFLIGHT"
    asked = []
    while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=30) == "WAIT_MOUNTING":
        asked.append(node.mounting)
        assert node.confirm() == "MOVE"
    result = node.result()
    assert asked == [1, 2] and result.run == 1
    assert result.K.tolist() == K and result.U0.tolist() == U0 and result.u_K.shape == (3, 3)
    assert (result.verdict, [one.name for one in result.objections]) == ("HELD", ["FIRST"])
    assert node.accept(result) == "ACCEPTED" and node.result().calibration_counter == 1
    assert theirs.commands == [("START", 0), ("CONFIRM_MOUNTING", 1), ("CONFIRM_MOUNTING", 2), ("ACCEPT", 0)]


def test_a_fault_says_why_and_what_to_do_and_a_resume_goes_on(played):
    _theirs, node = played(fails={1: "STALL"})
    node.start()
    node.wait(until="WAIT_MOUNTING", timeout=30)
    node.confirm()
    with pytest.raises(client.RunFailed, match=r"in FAULT: STALL, .* Remedy: The axis does not follow") as end:
        node.wait(timeout=30)
    assert (end.value.state, end.value.reason.name) == ("FAULT", "STALL") and isinstance(end.value, TumbleError)
    assert node.wait(until="FAULT") == "FAULT"
    assert node.resume() == "MOVE"
    with pytest.raises(client.RunFailed, match="the run is in ABORT: COMMAND, aborted by command"):
        node.abort()
        node.wait()


def test_waiting_ends_in_time_with_the_last_state(played):
    _theirs, node = played(stays="WARM_UP")
    node.start()
    with pytest.raises(TimeoutError, match=r"DONE did not come within 0\.2 s; the state is WARM_UP") as end:
        node.wait(timeout=0.2)
    assert isinstance(end.value, client.TimedOut) and end.value.state == "WARM_UP"
    with pytest.raises(UsageError, match="there is no state 'FINISHED'; there are IDLE, PREFLIGHT"):
        node.wait(until="FINISHED")


def test_what_the_state_does_not_allow_is_refused(played):
    theirs, node = played()
    for command in (node.abort, node.resume, node.confirm, node.discard):
        with pytest.raises(client.Refused, match=r"was refused: the state does not allow it \(0800 0022h\)"):
            command()
    with pytest.raises(client.NoResult, match="the node has no result; its state is IDLE"):
        node.result()
    assert theirs.commands == []


def test_the_package_loads_no_library_of_a_bus():
    program = "import sys, tumble.client; print({'can', 'canopen', 'pymodbus'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("set()\n", "")
