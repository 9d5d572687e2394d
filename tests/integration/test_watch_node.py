"""tumble watch at a node: what it asks for, that it never writes, and what it makes of a node that goes and comes."""

import json
import logging
import socket
import struct
import threading

import documents
import pytest
from conftest import ROOT
from played_node import U0, K, PlayedCanNode

from tumble.client.link import CommunicationError, read_map
from tumble.documents.watch import Gravity, Mean, Snapshot
from tumble.watch.node_run import NodeRun
from tumble.watch.snapshot import Heard, Lost, Status, View, document

can = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytest.importorskip("pymodbus", reason="pymodbus is not installed")
pytestmark = pytest.mark.python
logging.getLogger("canopen").setLevel(logging.CRITICAL)
UPLOADS, ABORT = (0x40, 0x60, 0x70), 0x80  # begin, a segment with either toggle bit
READ_INPUT = 4


class PlayedLink:
    """A link to a node with these objects; the others are not known. `asked`: every name, in order."""

    def __init__(self, objects):
        self.objects, self.asked, self.closed, self.silent = objects, [], 0, False

    def has(self, _name):
        return True

    def read_together(self, *names):
        if self.silent:
            raise CommunicationError("node 1 does not answer")
        self.asked += names
        return [self.objects.get(name) for name in names]

    def of_one_moment(self, read):
        return read()

    def close(self):
        self.closed += 1

    def asked_now(self):
        found, self.asked = self.asked, []
        return found


def progress(**more):
    names = ("Position index", "Positions finished", "Samples taken", "Mounting number", "Position number",
             "Position count", "Attempt", "Samples wanted", "Target angle", "Stand state", "Actual angle",
             "Block temperature")
    values = (3, 3, 0, 1, 4, 18, 0, 50, 180.0, 4, 180.0, 49)
    return {f"Progress: {name}": value for name, value in zip(names, values)} | more


def averaging():
    mean = {f"{of}: {of} {axis}": value for of, one in (("Running mean", 1.0), ("Standard error", 1e-5))
            for axis, value in zip("xyz", (one, 2 * one, 3 * one))}
    return {"State": 7, "Reason": 0, "Run number": 2, **progress(**{"Progress: Samples taken": 34}), **mean,
            "Gravity check: Limit": 3e-4, "Gravity check: Fit positions judged": 0}


def with_result(objects):
    k = {f"K: K_{row}{column}": K[i][j] for i, row in enumerate("xyz") for j, column in enumerate("xyz")}
    gravity = {"Largest deviation on fit positions": 1e-4, "Limit": 3e-4, "Fit positions judged": 18,
               "Check positions judged": 0, "Pass": 1, "Largest deviation on check positions": 0.0}
    return {**objects, "State": 12, **k, **{f"U0: U0_{axis}": value for axis, value in zip("xyz", U0)},
            **{f"Gravity check: {name}": value for name, value in gravity.items()}}


def test_the_snapshot_of_a_node_that_averages_and_of_one_that_is_done():
    link = PlayedLink(averaging())
    run = NodeRun("any", lambda _: link)
    seen = Snapshot(
        state="AVERAGE", run=2, mounting=1, position=4, count=18, finished=3, attempt=0, samples=34, wanted=50,
        stand="IN_POSITION", angle_rad=3.141592653589793, target_rad=3.141592653589793, temperature_c=24.5,
        mean=Mean(1, 4, 34, 50, (1.0, 2.0, 3.0), (1e-5, 2e-5, 3 * 1e-5)), gravity=Gravity(None, None, 3e-4, None),
    )  # fmt: skip
    assert run.snapshot() == seen
    link.objects = with_result(link.objects)
    done = run.snapshot()
    assert (done.state, done.samples, done.mean, done.u_k_v_per_g) == ("DONE", None, seen.mean, None)
    assert (done.k_v_per_g, done.u0_v) == (tuple(map(tuple, K)), tuple(U0))
    assert done.gravity == Gravity(1e-4, None, 3e-4, True)
    documents.valid(json.dumps(document(View("any", 1, 1.0, done))), "watch")
    link.objects = {**averaging(), "Run number": 3, "Progress: Samples taken": 1}
    assert run.snapshot().mean is None  # of another run


def test_what_has_not_changed_is_not_asked_for_again():
    link = PlayedLink(averaging())
    run = NodeRun("any", lambda _: link)
    run.snapshot()
    assert any(name.startswith("K: ") for name in link.asked_now())
    status = ["State", "Reason", "Progress: Position index", "Progress: Positions finished", "Progress: Samples taken",
              "Run number"]
    table = ["Progress: Stand state", "Progress: Actual angle", "Progress: Block temperature"]
    run.snapshot()
    assert link.asked_now() == status + table
    link.objects["Progress: Samples taken"] = 36
    run.snapshot()
    means = [f"{of}: {of} {axis}" for of in ("Running mean", "Standard error") for axis in "xyz"]
    assert link.asked_now() == status + table + means


def test_the_angle_of_a_table_that_has_not_homed_is_unknown():
    for stand, known in enumerate((False, False, False, True, True, True, False)):
        link = PlayedLink({**averaging(), "Progress: Stand state": stand})
        assert (NodeRun("any", lambda _, link=link: link).snapshot().angle_rad is not None) == known, stand


def test_a_node_that_falls_silent_is_asked_anew():
    links = [PlayedLink(averaging()), PlayedLink(with_result(averaging()))]
    opened = iter(links)
    run = NodeRun("any", lambda _: next(opened))
    assert run.snapshot().state == "AVERAGE"
    links[0].silent = True
    with pytest.raises(Lost, match=r"^node 1 does not answer$"):
        run.snapshot()
    assert links[0].closed == 1
    assert run.snapshot().k_v_per_g is not None  # from another link, all of it again
    run.close()
    assert links[1].closed == 1


def test_what_is_heard_on_the_bus():
    now = [0.0]
    heard = Heard(lambda: now[0])
    assert (heard.status(), heard.run(), heard.emergencies()) == (None, None, {}) and heard.drive_has_changed()
    heard.frame(0x181, bytes([7, 0, 3, 2]) + struct.pack("<I", 70000))
    heard.frame(0x181, b"short")
    heard.frame(0x6C1, bytes([1, 0, 0]) + struct.pack("<I", 300))
    assert (heard.status(), heard.run()) == (Status(7, 0, 3, 2, 70000), 300)
    assert not heard.drive_has_changed()
    for data, changed in ((b"\1", True), (b"\1", False), (b"\2", True)):
        heard.frame(0x182, data)
        assert heard.drive_has_changed() == changed
    heard.frame(0x082, bytes.fromhex("1186000000000000"))
    assert heard.emergencies() == {"drive": "8611"}
    heard.frame(0x082, bytes(8))
    assert heard.emergencies() == {}
    now[0] = 2.6
    assert heard.status() is None  # too old to be true


@pytest.fixture
def spied():
    """A played node on a virtual bus, and every frame that goes over it."""
    node = PlayedCanNode()
    frames = []
    bus = can.Bus(interface="virtual", channel=node.channel)
    notifier = can.Notifier(bus, [frames.append], timeout=0.01)
    yield node, frames
    notifier.stop()
    bus.shutdown()
    node.close()


def test_over_can_only_uploads_are_sent(spied):
    node, frames = spied
    run = NodeRun(f"can:virtual@{node.channel}")
    assert run.snapshot().state == "IDLE"
    node.start(0)
    states = [run.snapshot().state for _ in range(3)]
    node.confirm_mounting(1)
    states += [run.snapshot().state for _ in range(3)]
    node.confirm_mounting(2)
    states += [run.snapshot().state for _ in range(3)]
    done = run.snapshot()
    run.close()
    assert states == ["PREFLIGHT", "WARM_UP", *["WAIT_MOUNTING"], "MOVE", "AVERAGE", "WAIT_MOUNTING", "MOVE", "AVERAGE",
                      "DONE"]
    assert (done.k_v_per_g, done.u0_v) == (tuple(map(tuple, K)), tuple(U0))
    sent = [(frame.arbitration_id, frame.data[0]) for frame in frames if frame.arbitration_id != 0x581]
    assert len(sent) > 100 and {identifier for identifier, _ in sent} == {0x601}
    assert {command for _, command in sent} <= {*UPLOADS, ABORT} and node.commands == []


class PlayedGateway:
    """A Modbus server that has input registers and answers to nothing else. `functions`: of all requests."""

    def __init__(self, values):
        self.words, self.functions, self.snapshot = {}, [], 0
        self.moves = 0  # so often, while a mean is read, and then there is another snapshot
        self.map = read_map().input
        own = {"Magic word": 0x54554D42, "Known number": 123456.0, "Link state": 1}
        for name, value in {**own, **values}.items():
            self.set(name, value)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def set(self, name, value):
        register = self.map[name][0]
        for place, word in enumerate(register.pack(value)):
            self.words[register.at + place] = word
        if register.valid is not None:
            at, bit = register.valid
            self.words[at] = self.words.get(at, 0) | 1 << bit

    def serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            with connection:
                while head := connection.recv(12):
                    self.answer(connection, head)

    def answer(self, connection, request):
        transaction, _, _, unit, function, at, count = struct.unpack(">HHHBBHH", request)
        self.functions.append(function)
        if at <= self.map["Snapshot number"][0].at < at + count:  # takes a new one
            self.snapshot += 1
            self.set("Snapshot number", self.snapshot)
            self.set("Snapshot held", self.snapshot)
        words = [self.words.get(at + place, 0) for place in range(count)]
        if self.moves and at == self.map["Running mean: Running mean x"][0].valid[0]:  # a request for the mean alone
            self.moves -= 1
            self.set("Snapshot held", self.snapshot + 1)
            self.set("Progress: Position number", 5)
            self.set("Running mean: Running mean x", 7.0)
        body = struct.pack(f">BBB{count}H", unit, function, 2 * count, *words)
        connection.sendall(struct.pack(">HHH", transaction, 0, len(body)) + body)

    def close(self):
        self.listener.close()


@pytest.fixture
def gateway():
    played = PlayedGateway({name: value for name, value in averaging().items() if value is not None})
    yield played
    played.close()


def test_over_modbus_only_input_registers_are_read(gateway):
    run = NodeRun(f"modbus:127.0.0.1:{gateway.port}")
    seen = run.snapshot()
    assert (seen.state, seen.run, seen.samples, seen.wanted, seen.stand) == ("AVERAGE", 2, 34, 50, "IN_POSITION")
    assert seen.mean.mean_v == (1.0, 2.0, 3.0) and seen.temperature_c == 24.5
    for name, value in with_result({}).items():
        gateway.set(name, value)
    done = run.snapshot()
    run.close()
    assert done.state == "DONE" and done.u_k_v_per_g is None
    assert [round(value, 7) for row in done.k_v_per_g for value in row] == [value for row in K for value in row]
    assert done.gravity.passed is True and done.gravity.max_check_g is None
    assert set(gateway.functions) == {READ_INPUT} and len(gateway.functions) > 10


def test_one_view_over_modbus_is_of_one_snapshot(gateway):
    run = NodeRun(f"modbus:127.0.0.1:{gateway.port}")
    before = gateway.snapshot
    for number in (1, 2):
        run.snapshot()
        assert gateway.snapshot == before + number
    run.close()


@pytest.mark.parametrize("times", [1, 9], ids=["now and then", "always, on a slow line"])
def test_a_view_of_two_snapshots_is_read_again(gateway, times):
    run = NodeRun(f"modbus:127.0.0.1:{gateway.port}")
    gateway.moves = times
    seen = run.snapshot()
    run.close()
    assert gateway.moves == (0 if times == 1 else times - 3)
    assert (seen.position, seen.mean.position, seen.mean.mean_v[0]) == (5, 5, 7.0)


def test_the_watcher_calls_nothing_that_writes():
    """Not by chance either: no module of it names a call of the client that commands or sets."""
    for path in sorted((ROOT / "host/python/src/tumble/watch").glob("*.py")):
        code = path.read_text(encoding="utf-8")
        for call in (".write(", ".command(", ".download(", "write_register", "write_coil", ".start()", ".unlock("):
            assert call not in code.replace("self._thread.start()", "").replace("self._live.start()", ""), (path, call)


class DisturbedLink(PlayedLink):
    """The first time that each of these is asked for, somebody else's answer comes."""

    def __init__(self, objects, **wrong):
        super().__init__(objects)
        self.wrong = wrong["wrong"]

    def read_together(self, *names):
        return [self.wrong.pop(name, value) for name, value in zip(names, super().read_together(*names))]

    def read(self, name):
        return self.read_together(name)[0]


def test_answers_to_somebody_else_are_not_kept():
    link = DisturbedLink(with_result(averaging()), wrong={"State": None, "K: K_xy": 77.0, "U0: U0_z": None})
    seen = NodeRun("any", lambda _: link).snapshot()
    assert (seen.state, seen.k_v_per_g, seen.u0_v) == ("DONE", tuple(map(tuple, K)), tuple(U0))
    assert link.wrong == {}
