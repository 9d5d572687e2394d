"""tumble-gateway between Modbus clients and tumble-node on a CAN interface: whole recalibrations, and what may happen
to the bus. Needs libmodbus, pymodbus and mbpoll."""

import itertools
import json
import re
import shutil
import signal
import struct
import subprocess
import time

import numpy as np
import pytest
from gateway_bench import KEYS, ROOT, decode, register
from processes import HASTE, PATIENCE, Node, Stand, scenario, wait_until
from recalibration import refusal_of
from simulated_bench import built

client_module = pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
START, ACCEPT, DONE = 1, 9, 12
HELD, ACCEPTED = 3, 5  # verdicts
BY_HAND = 1 << 10
K = [f"K: K_{row}{column}" for row in "xyz" for column in "xyz"]
U0 = [f"U0: U0_{row}" for row in "xyz"]


class Served:
    """tumble-gateway, and a pymodbus client of it, which may be silent for minutes while others ask."""

    def __init__(self, bus, *options):
        program = built("tumble-gateway")
        command = [program, "--can", str(bus), "--tcp", "127.0.0.1:0", "--poll", "100", "--idle", "86400", *options]
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        self.line = self.process.stderr.readline()
        self.port = int(re.search(r" at 127\.0\.0\.1:(\d+)", self.line)[1])
        self.client = client_module.ModbusTcpClient("127.0.0.1", port=self.port, timeout=10)
        self.client.connect()

    def kill(self):
        self.client.close()
        self.process.kill()
        self.process.wait()

    def end(self):
        """Its last words."""
        self.client.close()
        self.process.send_signal(signal.SIGTERM)
        errors = self.process.communicate(timeout=20)[1]
        assert self.process.returncode == 0
        return errors

    def number(self, name, table="input", scaled=False):
        """Out of the newest snapshot; None: not valid."""
        row = register(name, table, scaled)
        read = self.client.read_input_registers if table == "input" else self.client.read_holding_registers
        if row["valid_register"] is not None:
            valid = read(row["valid_register"], count=1, device_id=1).registers[0]
            if not valid >> row["valid_bit"] & 1:
                return None
        return decode(row, read(row["register"], count=row["words"], device_id=1).registers)

    def renew(self):
        """Take the newest snapshot, and say its number."""
        return self.number("Snapshot number")

    def wait_for(self, name, number, timeout=60):
        """Until it is that in a new snapshot."""
        def is_there():
            self.renew()
            return self.number(name) == number

        try:
            wait_until(is_there, timeout)
        except AssertionError:
            told = (
                "State",
                "Reason",
                "Failure: State it failed in",
                "Failure: Status",
                "Link state",
                "Keeper: Verdict",
            )
            pytest.fail(f"{name} is not {number}: " + ", ".join(f"{one} {self.number(one)}" for one in told))

    def execute(self, *staged):
        """Command object, argument, angle (two words), command; in an unlocked session."""
        at = register("Command object", "holding")["register"]
        answer = self.client.write_registers(at, [*staged, 77], device_id=1)
        assert not answer.isError(), answer
        wait_until(lambda: self.number("Result", "holding") != 1)
        return self.number("Result", "holding"), self.number("Abort code", "holding")

    def accept(self):
        """The proposal as it is shown, by its name; in an unlocked session."""
        self.renew()
        row = register("Proposal: Record CRC")
        name = self.client.read_input_registers(row["register"], count=2, device_id=1).registers
        answer = self.client.write_registers(register("Proposal", "holding")["register"], name, device_id=1)
        assert not answer.isError(), answer
        return self.execute(0, 0, 0, 0, ACCEPT)

    def tell(self, name, value):
        """A setting, in an unlocked session: (result, abort code)."""
        words = struct.unpack(">4H", struct.pack(">d", value))
        answer = self.client.write_registers(register("Setting", "holding")["register"],
                                             [register(name, "setting")["register"], *words], device_id=1)
        assert not answer.isError(), answer
        answer = self.client.write_register(register("Execute", "holding")["register"], 78, device_id=1)
        assert not answer.isError(), answer
        wait_until(lambda: self.number("Result", "holding") != 1)
        return self.number("Result", "holding"), self.number("Abort code", "holding")


@pytest.fixture
def serve(bus, started):
    def run(*options):
        started.append(Served(bus, *options))
        return started[-1]

    return run


@pytest.fixture
def calibrating(bus, started, tmp_path):
    """tumble-stand with an operator who mounts and confirms, and tumble-node that waits for commands;
    what it finds waits for them, too."""
    path = scenario(tmp_path, **HASTE, **PATIENCE, keeper__commits="no")
    stand = Stand(bus, path, "--seed", 11)
    node = Node(bus, path, "--nv", tmp_path / "memory", folder=tmp_path)
    started.extend([stand, node])
    return stand, node


def mbpoll(served, *arguments):
    command = ["mbpoll", "-m", "tcp", "-p", served.port, "-a", 1, "-0", "-1", "-q", "-B", *arguments]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=30)
    assert done.returncode == 0, done.stdout + done.stderr
    return {int(line[1:].split("]")[0]): line.split(":", 1)[1].strip()
            for line in done.stdout.splitlines() if line.startswith("[")}


def mbpoll_number(served, name):
    row = register(name)
    kind = {"u16": "3", "f32": "3:float"}[row["type"]]
    return float(mbpoll(served, "-t", kind, "-r", row["register"], "-c", 1, "127.0.0.1")[row["register"]])


def test_pymodbus_and_mbpoll_each_drive_a_recalibration(calibrating, serve):
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")
    stand, node = calibrating
    served = serve("--allow-commands")
    served.wait_for("State", 0)
    assert all(served.number(name) is None for name in K + U0) and served.number("Known number") == 123456.0

    assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
    assert served.execute(0, 0, 0, 0, 99) == (3, 0x06090030)  # no such command
    answer = served.client.write_registers(register("Command", "holding")["register"], [START, 1], device_id=1)
    assert not answer.isError()
    wait_until(lambda: served.number("Result", "holding") == 2)
    served.wait_for("State", DONE)
    first = [served.number(name) for name in K + U0]
    scaled = [served.number(name, scaled=True) for name in K + U0]
    assert served.number("Gravity check: Pass") == 1 and served.number("Reason") == 0
    served.wait_for("Keeper: Verdict", HELD)
    assert served.number("Keeper: Objections") & BY_HAND and served.number("Keeper: Calibration counter") == 0
    served.wait_for("Proposal: K: K_xx", first[0])  # one reading later at most, where the memory was at work
    assert [served.number(f"Proposal: {name}") for name in K + U0] == first
    assert served.number("Active set: K: K_xx") is None
    assert served.accept() == (2, 0)
    served.wait_for("Keeper: Verdict", ACCEPTED)
    served.wait_for("Active set: K: K_xx", first[0])
    assert [served.number(f"Active set: {name}") for name in K + U0] == first
    assert served.number("Keeper: Calibration counter") == 1 and served.number("Proposal: K: K_xx") is None

    assert mbpoll_number(served, "State") == DONE
    mbpoll(served, "-t", "4", "-r", 0, "127.0.0.1", *KEYS, 0, 0, 0, 0, 0, START, 1)
    wait_until(lambda: mbpoll_number(served, "State") != DONE, 60)
    wait_until(lambda: mbpoll_number(served, "State") == DONE, 60)
    second = [mbpoll_number(served, name) for name in K + U0]
    wait_until(lambda: mbpoll_number(served, "Keeper: Verdict") == HELD, 60)
    assert [mbpoll_number(served, f"Active set: {name}") for name in K + U0] != second  # six digits may agree by chance
    at = register("Proposal: Record CRC")["register"]
    shown = [text.split()[0] for _, text in sorted(mbpoll(served, "-t", "3", "-r", at, "-c", 2, "127.0.0.1").items())]
    mbpoll(served, "-t", "4", "-r", 0, "127.0.0.1", *KEYS, 0, 0, 0, 0, 0, ACCEPT, 2, *9 * [0], *shown)
    wait_until(lambda: mbpoll_number(served, "Keeper: Verdict") == ACCEPTED, 60)
    wait_until(lambda: mbpoll_number(served, "Active set: K: valid") == 0x1FF)
    assert mbpoll_number(served, "Active set: K: K_xx") == second[0]
    served.renew()
    assert served.number("Keeper: Calibration counter") == 2
    assert second == pytest.approx([served.number(f"Active set: {name}") for name in K + U0], abs=5.1e-6)
    torn, failed = served.number("Polls torn"), served.number("Polls failed")
    print(f"polls {served.number('Polls')}, torn {torn}, failed {failed}")
    assert served.end() == ""

    node.signal()
    out, errors = node.process.communicate(timeout=60)
    documents = [json.loads(line) for line in out.splitlines()]
    assert node.process.returncode == 0 and [one["end"] for one in documents] == ["done", "done"], errors
    truth = np.concatenate([np.array(part).ravel() for part in map(stand.end()["truth"].get, ("K", "U0"))])
    for numbers, document in ((first, documents[0]), (second, documents[1])):
        exact = np.concatenate([np.array(document["K"]).ravel(), document["U0"]])
        assert np.abs(numbers - exact).max() < 5.1e-6  # mbpoll prints six digits
        assert np.abs(exact - truth).max() < 3e-3
    exact = np.concatenate([np.array(documents[0]["K"]).ravel(), documents[0]["U0"]])
    assert first == [struct.unpack("<f", struct.pack("<f", number))[0] for number in exact]
    assert np.abs(scaled - exact).max() <= 0.51e-8


TOLD = 2208988800  # 2040-01-01; the computer's own calendar is another
POSITION = ("Position: Samples", "Position: Mean x", "Position: Mean y", "Position: Standard error z")


def test_what_is_told_over_modbus_stands_in_the_set_that_a_run_commits(calibrating, serve):
    served = serve("--allow-commands")
    served.wait_for("State", 0)
    assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
    assert served.tell("Host: Calendar", TOLD) == (2, 0)
    assert served.tell("Recalibration: Gravity", 9.8125) == (2, 0)
    assert served.tell("Recalibration: Gravity", 1.0) == (3, 0x06090030)
    assert served.tell("Configuration: Samples per position", 12) == (2, 0)
    assert served.tell("Configuration: Samples per position", 12.5) == (5, 0)
    assert served.tell("Store parameters: Save all parameters", 0x65766173) == (6, 0)
    assert served.tell("Service level: Key", 0x76726573) == (2, 0)
    assert served.tell("Store parameters: Save all parameters", 0x65766173) == (2, 0)
    served.wait_for("Parameters: Saved", 1)
    assert served.number("Recalibration: Gravity") == 9.8125
    assert served.execute(0, 0, 0, 0, START) == (2, 0)
    assert served.tell("Recalibration: Gravity", 9.75) == (3, 0x08000022)
    assert served.tell("Measurement at rest: Samples wanted", 40) == (3, 0x08000022)
    served.wait_for("State", DONE)
    served.wait_for("Keeper: Verdict", HELD)
    assert served.accept() == (2, 0)
    served.wait_for("Keeper: Verdict", ACCEPTED)
    served.wait_for("Active set: Gravity", 9.8125)
    assert TOLD <= served.number("Active set: Date") <= TOLD + 300
    served.wait_for("History: Entries", 1)
    assert served.number("History: Date") == served.number("Active set: Date")
    assert served.number("History values: K_xx") == served.number("Active set: K: K_xx")
    seen = set()
    for index in (3, 0, 5):
        assert served.tell("Position: Position index", index) == (2, 0)
        served.wait_for("Position: Position index", index)
        numbers = [served.number(name) for name in POSITION]
        assert numbers[0] == 12 and abs(served.number("Position: Mean x", scaled=True) - numbers[1]) < 2e-7
        seen.add(tuple(numbers))
    assert len(seen) == 3
    assert served.tell("Measurement at rest: Samples wanted", 40) == (2, 0)
    served.wait_for("Measurement at rest: Samples taken", 40)
    assert 1e-5 < served.number("Measurement at rest: Standard deviation x") < 1e-2
    assert served.number("Measurement at rest: Samples spoilt") is not None


def polls_on(log):
    """Numbers of frames of the polls that candump saw: what comes without a break."""
    times = [float(line[1:].split(")")[0]) for line in log.read_text().splitlines()]
    begins = [0] + [at for at in range(1, len(times)) if times[at] - times[at - 1] > 0.4]
    return [behind - begin for begin, behind in itertools.pairwise(begins)]


def test_how_many_frames_a_poll_takes(bus, calibrating, serve, tmp_path):
    """With a result, an active set and a selected position, as docs/gateway.md says."""
    served = serve("--allow-commands")
    served.wait_for("State", 0)
    assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
    assert served.execute(0, 0, 0, 0, START) == (2, 0)
    served.wait_for("State", DONE)
    served.wait_for("Keeper: Verdict", HELD)
    assert served.accept() == (2, 0)
    served.wait_for("Keeper: Verdict", ACCEPTED)
    assert served.tell("Measurement at rest: Samples wanted", 40) == (2, 0)
    served.wait_for("Measurement at rest: Samples taken", 40)
    served.end()
    with open(tmp_path / "polls.log", "w") as log:
        dump = subprocess.Popen(["candump", "-L", f"{bus},401:7FF,381:7FF"], stdout=log)
        time.sleep(0.5)
        served = serve("--poll", "2000", "--allow-commands")
        served.wait_for("Link state", 1)
        time.sleep(6.5)
        assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
        assert served.tell("Position: Position index", 3) == (2, 0)
        time.sleep(6.5)
        dump.terminate()
        dump.wait()
    polls = polls_on(tmp_path / "polls.log")
    print(f"frames of the polls: {polls}")
    # One that is under way when a setting comes begins anew, and then reads the position's group as well.
    assert 900 < polls[0] < 1600 and min(polls) < 380 and sorted(polls)[-2] < 380 + 450, polls


def test_a_gateway_that_may_not_command_cannot(calibrating, serve):
    served = serve()
    assert served.line.endswith("read only\n")
    served.wait_for("State", 0)
    answer = served.client.write_registers(0, [*KEYS, 0, 0, 0, 0, 0, START, 1], device_id=1)
    assert answer.isError() and answer.exception_code == 1
    time.sleep(0.5)
    served.renew()
    assert served.number("State") == 0 and served.number("Locked") == 1


def test_the_node_and_the_interface_go_and_come_back(bus, started, serve, tmp_path):
    path = scenario(tmp_path, **HASTE)
    served = serve("--allow-commands")
    wait_until(lambda: served.number("Link state") == 2)  # nobody is there yet
    stand, node = Stand(bus, path, "--seed", 11), Node(bus, path, folder=tmp_path)
    started.extend([stand, node])
    wait_until(lambda: served.number("Link state") == 1)
    bus.down()
    wait_until(lambda: served.number("Link state") == 3)
    assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
    answer = served.client.write_registers(register("Command", "holding")["register"], [START, 1], device_id=1)
    assert answer.isError() and answer.exception_code == 11
    bus.up()
    wait_until(lambda: served.number("Link state") == 1)
    node.kill()
    wait_until(lambda: served.number("Link state") == 2)
    wait_until(lambda: served.number("Age of the snapshot") > 1000)
    assert served.end() == ""


def test_no_such_interface():
    program = built("tumble-gateway")
    done = subprocess.run([program, "--can", "can999"], capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stderr) == (2, "tumble-gateway: can999: there is no CAN interface of this name\n")


def test_the_service_level_of_the_bus_and_of_a_session(network, calibrating, serve):
    """Unlock, write, lock: over CAN and through the gateway, of the same node, at the same time."""
    level, limit = "Service level: Level", "Configuration: Gravity limit"
    node = network.add_node(1, str(ROOT / "docs/eds/tumble_navcomp.eds"))
    heard = []
    network.subscribe(0x6C1, lambda identifier, data, stamp: heard.append(struct.unpack("<BHI", data)))
    served = serve("--allow-commands")
    served.wait_for("State", 0)
    assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
    before = served.number(limit)
    assert served.tell(limit, 0.5) == (6, 0)
    assert served.tell("Service level: Key", 1) == (3, 0x06090030)
    assert served.tell("Service level: Key", 0x76726573) == (2, 0)
    assert served.tell(limit, 0.5) == (2, 0)
    served.wait_for(level, 1)
    served.wait_for(limit, 0.5)
    wait_until(lambda: heard and heard[-1][0] == 1)
    served.client.close()  # and with it the level
    wait_until(lambda: heard[-1][:2] == (0, 0))
    served.client.connect()
    assert not served.client.write_registers(0, list(KEYS), device_id=1).isError()
    assert served.tell(limit, before) == (6, 0)

    def write(value):
        node.sdo["Configuration"]["Gravity limit"].raw = value

    assert refusal_of(write, before) == 0x08000022
    node.sdo["Service level"]["Key"].raw = 0x76726573
    wait_until(lambda: heard[-1][0] == 1)
    write(before)
    node.sdo["Command"]["Command"].raw = START
    wait_until(lambda: heard[-1] == (0, 0, 1))
    assert refusal_of(write, 0.25) == 0x08000022
    assert refusal_of(setattr, node.sdo["Service level"]["Key"], "raw", 0x76726573) == 0x08000022
    assert node.sdo["Run number"].raw == 1
