"""What tumble-gateway reads from the node is what Modbus clients get: every register, whole snapshots, known or not."""

import random
import re
import shutil
import struct
import subprocess
import sys
import time

import pytest
from gateway_bench import (
    READ_HOLDING,
    ROOT,
    decode,
    end_of,
    register,
    registers,
    wait_until,
)  # fmt: skip

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]
NODE = [row for row in registers() if row["table"] == "input" and row["index"] is not None]
canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
DICTIONARY = canopen.import_od(str(ROOT / "docs/eds/tumble_navcomp.eds"))


def key(row):
    return row["index"], row["subindex"]


def variable(row):
    """The object as the EDS file has it: a witness of its type."""
    found = DICTIONARY[row["index"]]
    return found if isinstance(found, canopen.objectdictionary.ODVariable) else found[row["subindex"]]


def random_number(row, draw):
    kind = variable(row).data_type
    if kind in canopen.objectdictionary.FLOAT_TYPES:
        return draw.uniform(-2, 2)
    if kind == canopen.objectdictionary.VISIBLE_STRING:
        return "".join(draw.choices("ABCdef0123-", k=draw.randrange(1, 2 * row["words"] + 1)))
    bits = len(variable(row))
    if kind in canopen.objectdictionary.SIGNED_TYPES:
        return draw.randrange(-(1 << bits - 1), 1 << bits - 1)
    return draw.randrange(2 if kind == canopen.objectdictionary.BOOLEAN else 1 << bits)


def node_objects():
    """One row for each object of the node: the one that is not scaled."""
    return {key(row): row for row in NODE if row["scale"] is None}


def test_every_value_arrives_in_every_form(start):
    gateway, draw = start(), random.Random(7)
    numbers = {where: random_number(row, draw) for where, row in node_objects().items()}
    client = gateway.connect()
    gateway.wait_fresh(client)
    gateway.set_all({where: variable(row).encode_raw(numbers[where]) for where, row in node_objects().items()})
    gateway.wait_fresh(client)
    for row in NODE:
        wanted = numbers[key(row)]
        if row["scale"] is not None:
            wanted = round(wanted / row["scale"]) * row["scale"]
        elif row["type"] == "f32":
            [wanted] = struct.unpack("<f", struct.pack("<f", wanted))
        assert client.value(row) == wanted, row
    assert client.number("Values refused") > 0  # before it had them all


def test_word_order_can_be_told(start):
    client = start().connect()
    assert client.read(0, 5) == (0x5455, 0x4D42, 1, 0x47F1, 0x2000)
    assert client.number("Known number") == 123456.0


def test_what_the_node_does_not_know_is_not_there(start):
    gateway = start()
    client = gateway.connect()
    gateway.wait_fresh(client)
    for row in NODE:
        assert client.value(row) is None
    gateway.set(0x2020, 2, struct.pack("<d", -0.25))
    gateway.wait_fresh(client)
    valid = register("K: valid")["register"]
    assert client.read(valid, 5) == (2, 0, 0, 0xBE80, 0)
    gateway.set(0x2020, 2)
    gateway.wait_fresh(client)
    assert client.read(valid, 5) == (0, 0, 0, 0, 0)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf"), 1e39])
def test_no_register_is_ever_not_finite(start, number):
    gateway = start()
    gateway.set(0x2021, 1, struct.pack("<d", number))
    client = gateway.connect()
    gateway.wait_fresh(client)
    assert client.number("U0: U0_x") is None and client.number("U0: U0_x", scaled=True) is None


@pytest.mark.parametrize("units, fits", [(2**31 - 1, True), (2**31, False), (-(2**31), True), (-(2**31) - 1, False)])
def test_a_scaled_number_that_does_not_fit_is_not_there(start, units, fits):
    gateway, number = start(), units * 1e-8
    gateway.set(0x2020, 9, struct.pack("<d", number))
    client = gateway.connect()
    gateway.wait_fresh(client)
    assert client.number("K: K_zz", scaled=True) == (pytest.approx(number, rel=1e-15) if fits else None)
    assert client.number("K: K_zz") == pytest.approx(number, rel=1e-7)


@pytest.mark.parametrize("data", [b"\1", b"\1\2\3", b"\1\2\3\4\5"])
def test_an_object_of_another_size_is_not_there(start, data):
    gateway = start()
    gateway.set(0x2030, 1, data)
    client = gateway.connect()
    gateway.wait_fresh(client)
    assert client.number("Bus counters: Frames sent") is None


def read_all(client, step):
    """All input registers, in requests of `step` from 0 on."""
    words = ()
    while len(words) < end_of("input"):
        words += client.read(len(words), min(step, end_of("input") - len(words)))
    return words


@pytest.mark.parametrize("step", [7, 10, 50, 125])
def test_one_pass_over_all_registers_is_one_snapshot(start, step):
    """All coefficients of a generation are one number; generations come while the client reads."""
    gateway, generation = start(), 0
    client, seen = gateway.connect(), set()
    gateway.wait_fresh()
    k = [row for row in NODE if row["index"] in (0x2020, 0x2021)]

    def advance():
        nonlocal generation
        generation += 1
        data = struct.pack("<d", generation / 1024)
        gateway.set_all({key(row): data for row in k})

    for _ in range(12):
        advance()
        words = read_all(client, step)
        numbers = {decode(row, words[row["register"]:][: row["words"]]) for row in k if row["scale"] is None}
        scaled = {round(decode(row, words[row["register"]:][: row["words"]]) * 1024, 3) for row in k if row["scale"]}
        held = client.number("Snapshot held")
        assert held == decode(register("Snapshot number"), words[5:7])
        seen.add(held)
        assert len(numbers) == 1 and scaled == {number * 1024 for number in numbers}
        gateway.wait_fresh()
    assert len(seen) > 6 and gateway.process.poll() is None


def test_a_session_keeps_its_snapshot_until_it_asks(start):
    gateway = start()
    one, other = gateway.connect(), gateway.connect()
    gateway.set(0x2000, 0, b"\3")
    gateway.wait_fresh(one)
    first = other.snapshot()
    gateway.set(0x2000, 0, b"\7")
    gateway.wait_fresh(one)
    assert (one.number("State"), other.number("State")) == (7, 3)
    assert other.number("Snapshot held") == first < other.snapshot()
    assert other.number("State") == 7


def test_who_never_asks_for_a_snapshot_sees_no_old_state(start):
    gateway = start()
    client, state = gateway.connect(), register("State")
    gateway.set(0x2000, 0, b"\3")
    gateway.wait_fresh()
    assert client.value(state) == 3
    gateway.set(0x2000, 0, b"\7")
    wait_until(lambda: client.value(state) == 7, timeout=3.5)


def test_a_slow_pass_is_one_snapshot(start):
    """Each request goes on upwards from the one before; the next pass gets the next snapshot."""
    gateway = start()
    client, other, state = gateway.connect(), gateway.connect(), register("State")["register"]
    gateway.set(0x2000, 0, b"\3")
    gateway.wait_fresh(other)
    assert client.read(5, 2) and client.read(state, 1) == (3,)
    gateway.set(0x2000, 0, b"\7")
    gateway.wait_fresh(other)
    time.sleep(2.2)
    assert client.read(state - 1, 2) == (1, 7)  # not upwards: a new pass
    gateway.set(0x2000, 0, b"\10")
    gateway.wait_fresh(other)
    assert client.read(5, 2)
    gateway.set(0x2000, 0, b"\11")
    gateway.wait_fresh(other)
    for count in (1, 2):  # a pass of more than two seconds, whatever it reads of the holding registers
        time.sleep(1.2)
        assert client.read(state - 3 + count, 1) and client.read(0, 2, READ_HOLDING)
    assert client.read(state, 1) == (8,)
    assert client.read(state, 1) == (9,)


def test_a_silent_node_and_a_bus_that_is_down(start):
    gateway = start()
    client = gateway.connect()
    gateway.set(0x2000, 0, b"\3")
    gateway.wait_fresh(client)
    assert client.number("Link state") == 1 and client.number("Age of the snapshot") < 2000
    gateway.tell("silent 1")
    wait_until(lambda: client.number("Link state") == 2)
    held, failed = client.snapshot(), client.number("Polls failed")
    wait_until(lambda: client.number("Age of the snapshot") > 1500)
    assert client.snapshot() == held and client.number("State") == 3 and client.number("Polls failed") > failed
    gateway.tell("down 1")
    wait_until(lambda: client.number("Link state") == 3)
    gateway.tell("down 0")
    gateway.tell("silent 0")
    wait_until(lambda: client.number("Link state") == 1)
    wait_until(lambda: client.snapshot() > held)


def test_nothing_heard_yet(start):
    gateway = start("--poll", 3600000)
    gateway.tell("silent 1")
    client = gateway.connect()
    wait_until(lambda: client.number("Link state") in (1, 2))
    fresh = start("--poll", 3600000, "--node", 5)  # nobody plays node 5
    client = fresh.connect()
    assert client.number("Link state") == 0 and client.snapshot() == 0
    assert client.number("Age of the snapshot") == 0xFFFFFFFF and client.number("Node") == 5


def test_other_frames_on_the_bus_do_no_harm(start):
    gateway = start()
    gateway.tell("noise 100")
    gateway.set(0x2000, 0, b"\3")
    client = gateway.connect()
    gateway.wait_fresh(client)
    assert client.number("State") == 3


def test_pymodbus_reads_numbers_in_its_own_big_endian_order(start):
    client_module = pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    gateway = start()
    gateway.set(0x2020, 1, struct.pack("<d", 1.9950940721))
    gateway.wait_fresh()
    with client_module.ModbusTcpClient("127.0.0.1", port=gateway.port) as client:
        def number(row, kind):
            answer = client.read_input_registers(row["register"], count=row["words"], device_id=1)
            return client.convert_from_registers(answer.registers, kind, word_order="big")

        assert number(register("Known number"), client.DATATYPE.FLOAT32) == 123456.0
        assert number(register("Magic word"), client.DATATYPE.UINT32) == 0x54554D42
        client.read_input_registers(5, count=2, device_id=1)
        assert number(register("K: K_xx"), client.DATATYPE.FLOAT32) == pytest.approx(1.9950940721, rel=1e-7)
        assert number(register("K: K_xx", scaled=True), client.DATATYPE.INT32) == 199509407


def example(gateway, number=0):
    """What an example of docs/gateway.md prints, as it stands there: (exit code, standard output, standard error)."""
    page = (ROOT / "docs" / "gateway.md").read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.*?)```", page, re.DOTALL)[number]
    assert code.count("port=1502") == 1
    code = code.replace("port=1502", f"port={gateway.port}")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=20)
    return done.returncode, done.stdout, done.stderr


def test_the_example_of_the_page_reads_the_active_set(start):
    pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    gateway = start()
    gateway.set(0x2020, 1, struct.pack("<d", -7.0))  # of the last run
    gateway.set(0x2104, 1, struct.pack("<d", 1.5))
    gateway.set(0x2120, 2, struct.pack("<I", 12))
    gateway.wait_fresh()
    code, out, error = example(gateway)
    assert (code, error) == (0, "") and re.fullmatch(r"K_xx 1\.5 V/g, snapshot \d+\ncalibration counter 12\n", out), out
    gateway.set(0x2104, 1)
    gateway.wait_fresh()
    assert example(gateway)[:2] == (0, "no K is in force\ncalibration counter 12\n")
    silent = start("--poll", 3600000, "--node", 5)
    code, out, error = example(silent)
    assert (code, out) == (1, "") and error.endswith("AssertionError: the node does not answer\n")


def mbpoll(gateway, *arguments):
    """What mbpoll prints for registers: {register: text}."""
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")
    command = ["mbpoll", "-m", "tcp", "-p", gateway.port, "-a", 1, "-0", "-1", "-q", *arguments, "127.0.0.1"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=20)
    assert done.returncode == 0, done.stdout + done.stderr
    lines = [line for line in done.stdout.splitlines() if line.startswith("[")]
    return {int(line[1:].split("]")[0]): line.split(":", 1)[1].strip() for line in lines}


def test_mbpoll_reads_numbers(start):
    gateway = start()
    gateway.set(0x2021, 2, struct.pack("<d", 0.03125))
    gateway.wait_fresh()
    assert mbpoll(gateway, "-t", "3:hex", "-r", 0, "-c", 2) == {0: "0x5455", 1: "0x4D42"}
    assert mbpoll(gateway, "-t", "3:float", "-B", "-r", 3, "-c", 1) == {3: "123456"}
    assert mbpoll(gateway, "-t", "3:float", "-B", "-r", register("U0: U0_y")["register"], "-c", 1) == {183: "0.03125"}
    assert mbpoll(gateway, "-t", "3:int", "-B", "-r", 223, "-c", 1) == {223: "3125000"}
