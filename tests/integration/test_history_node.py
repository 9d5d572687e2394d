"""`tumble history add --node`: the history of a simulated computer, which a script has calibrated."""

import numpy as np
import pytest

from tumble import client
from tumble.documents.labels import iso
from tumble.history import History
from tumble.history.calibrations import PARAMETERS, numbers_of

pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytest.importorskip("sqlalchemy", reason="SQLAlchemy is not installed")
pytestmark = pytest.mark.python
DAY = "2026-05-06T07:08:09Z"


@pytest.fixture
def link(tmp_path):
    """A bus with a computer that has a memory, and has calibrated its block once."""
    from tumble.world.virtual_bus import VirtualBus

    (tmp_path / "scenario.txt").write_text("keeper.serial = TB-7\n")
    bus = VirtualBus(str(tmp_path / "scenario.txt"), memory=True, operator="on-confirm", script_time=True)
    with client.connect(bus) as node:
        node.settings["Host: Calendar"] = int(np.datetime64(DAY.removesuffix("Z"), "s").astype(int))
        node.start()
        while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=36000) == "WAIT_MOUNTING":
            node.confirm()
        result = node.result()
        assert node.accept(result) == "ACCEPTED"
    yield bus, result
    bus.shutdown()


def test_a_set_of_a_computer_is_a_calibration(link, tumble, tmp_path, monkeypatch):
    """With the coefficients, to 24 bits, and the uncertainties of the run; once, however often it is read."""
    bus, result = link
    connect = client.connect
    monkeypatch.setattr(client, "connect", lambda name: connect(bus if name == "can:x" else name))
    said = [tumble("history", "add", "--node", "can:x", "--serial", "TB-7", cwd=tmp_path) for _ in range(2)]
    assert [(one.returncode, one.stdout, one.stderr) for one in said] == [(0, "1 added\n", ""), (0, "0 added\n", "")]
    with History(tmp_path / "history.db") as history:
        columns = history.columns()
    covariance = None if result.u_K is None else np.diag(np.concatenate([result.u_K.ravel(), result.u_U0]) ** 2)
    expected = numbers_of(result.K, result.U0, covariance)
    for name in PARAMETERS:
        assert columns[name][0] == pytest.approx(expected[name], rel=1e-6, abs=1e-7)
        if covariance is not None:
            assert columns[f"u_{name}"][0] == pytest.approx(expected[f"u_{name}"], rel=1e-6)
    assert iso(columns["created_s"][0])[:10] == DAY[:10] and columns["serial"][0] == "TB-7"


@pytest.mark.parametrize("arguments, line", [
    ((), "give results, or --node LINK"),
    (("r.json", "--node", "can:x"), "give results, or --node LINK"),
    (("--node", "can:x", "--serial", "TB-7", "--date", "2026-01-01"),
     "--date: the sets in the history of a node have dates of their own: leave it out"),
    (("--node", "can:x"),
     "--node: give --serial NAME: a node does not say of which block the sets in its history are"),
])  # fmt: skip
def test_a_node_needs_the_name_of_its_block_and_no_date(refused, tmp_path, arguments, line):
    assert refused("history", "add", *arguments, cwd=tmp_path) == f"tumble: {line}\n"
