"""tumble-gateway on a serial line: pseudo terminals, with mbpoll, pymodbus and raw bytes as the line's master."""

import random
import shutil
import struct
import subprocess
import time

import pytest
from gateway_bench import KEYS, READ_INPUT, WRITE_SEVERAL, Line, register, whole
from simulated_bench import wait_until

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]
PAUSE_S = 0.25  # longer than a busy machine lets the gateway wait, by and large
GOOD = struct.pack(">BBHH", 1, READ_INPUT, 0, 2)
ANSWER = b"\1\4\4\x54\x55\x4d\x42"


def test_a_request_is_answered(serve, line):
    serve()
    assert line.ask(GOOD) == whole(ANSWER)
    assert line.ask(GOOD) == whole(ANSWER)


@pytest.mark.parametrize("pause_s", [0.001, 0.01])
def test_a_request_byte_by_byte(serve, line, pause_s):
    serve()
    for byte in whole(GOOD):
        line.send(bytes((byte,)))
        time.sleep(pause_s)
    assert line.receive() == whole(ANSWER)


def test_exceptions(serve, line):
    serve()
    assert line.ask(struct.pack(">BBHH", 1, READ_INPUT, 0, 126)) == whole(b"\1\x84\3")
    assert line.ask(struct.pack(">BBHH", 1, READ_INPUT, 60000, 1)) == whole(b"\1\x84\2")
    assert line.ask(struct.pack(">BBHH", 1, 6, 3, 1)) == whole(b"\1\x86\1")
    assert line.ask(b"\1\x07") == whole(b"\1\x87\1")  # not served; its length is known by the gap
    assert line.ask(b"\1\x2b\x0e\1\0") == whole(b"\1\xab\1")
    assert line.ask(GOOD) == whole(ANSWER)


def test_every_function_code(serve, line):
    """An unknown function's length is known by the gap behind it."""
    serve()
    for function in range(256):
        answer = line.ask(bytes((1, function, 0, 0, 0, 1))) if function < 128 else None
        if function in (3, 4):
            assert answer[:3] == bytes((1, function, 2))
        elif function == 16:  # nine bytes and more are a request of 16: with eight the gap ends it
            assert answer == whole(b"\1\x90\3")
        elif function < 128:
            assert answer == whole(bytes((1, function | 0x80, 1))), function
    for function in (128, 132, 255):
        line.send(whole(bytes((1, function, 0, 0, 0, 1))))
        assert line.receive(timeout=0.1) == b""
    assert line.ask(GOOD) == whole(ANSWER)


def test_silence_for_others_and_for_broken_frames(serve, line):
    gateway = serve()
    broken = [whole(GOOD)[:size] for size in range(1, 8)] + [GOOD + b"\0\0", whole(GOOD)[:-1] + b"\xff"]
    for data in broken:
        line.send(data)
        time.sleep(PAUSE_S)
        assert line.ask(GOOD) == whole(ANSWER)
    for unit in (0, 2, 247, 255):
        line.send(whole(bytes((unit,)) + GOOD[1:]))
        assert line.receive(timeout=0.1) == b""
        assert line.ask(GOOD) == whole(ANSWER)
    client = gateway.connect()
    assert client.number("Serial CRC") == len(broken) and client.number("Wrong unit") == 4


def test_the_talk_of_other_units_on_the_line(serve, line):
    """Their requests and answers go by, without any gap, and the request for us behind them is answered."""
    gateway = serve()
    others = [
        whole(b"\2\3\0\0\0\2") + whole(b"\2\3\4\1\4\0\0"),
        whole(b"\2\6\0\1\0\2") + whole(b"\2\6\0\1\0\2"),
        whole(b"\2\x10\0\1\0\1\2\0\7") + whole(b"\2\x10\0\1\0\1"),
        whole(b"\2\3\0\0\0\x7e") + whole(b"\2\x83\3"),
        whole(b"\2\4\0\0\0\x7d") + whole(b"\2\4\xfa" + whole(GOOD) * 31 + b"\0\0"),  # what looks like a request to us
    ]
    for talk in others:
        line.send(talk + whole(GOOD))
        assert line.receive() == whole(ANSWER)
    assert gateway.connect().number("Serial CRC") == 0


def test_noise_on_the_line(serve, line):
    serve()
    draw = random.Random(5)
    for _ in range(30):
        line.send(draw.randbytes(draw.randrange(1, 600)))
        time.sleep(PAUSE_S)
        line.receive(timeout=0.0)
        assert line.ask(GOOD) == whole(ANSWER)


def test_the_line_has_a_session_of_its_own(serve, line):
    gateway = serve("--allow-commands", "--unlock", 2)
    client = gateway.connect()
    client.unlock()
    command = struct.pack(">BBHHBHH", 1, WRITE_SEVERAL, register("Command", "holding")["register"], 2, 4, 5, 1)
    assert line.ask(command) == whole(b"\1\x90\1")
    assert line.ask(struct.pack(">BBHHBHH", 1, WRITE_SEVERAL, 0, 2, 4, *KEYS)) == whole(b"\1\x10\0\0\0\2")
    assert line.ask(command) == whole(command[:6])
    assert [gateway.written.get(timeout=5) for _ in range(2)] == ["write 2002 1 00", "write 2002 2 05"]
    time.sleep(2.1)
    assert line.ask(command) == whole(b"\1\x90\1")


def test_a_line_that_goes_away_and_comes_back(start, tmp_path):
    first = Line()
    name = tmp_path / "tty"
    name.symlink_to(first.name)
    gateway = start("--rtu", f"{name},9600,N")
    gateway.wait_fresh()
    assert first.ask(GOOD) == whole(ANSWER)
    first.close()
    client = gateway.connect()
    wait_until(lambda: client.number("Serial faults") >= 1)
    second = Line()
    name.unlink()
    name.symlink_to(second.name)
    time.sleep(1.5)
    assert second.ask(GOOD) == whole(ANSWER)
    second.close()


def test_mbpoll(serve, far_end):
    if shutil.which("mbpoll") is None:
        pytest.skip("mbpoll is not installed")
    gateway = serve()
    gateway.set(0x2020, 5, struct.pack("<d", 2.25))
    gateway.wait_fresh()
    at = register("K: K_yy")["register"]
    for table, number, wanted in (("3:float", 3, "123456"), ("3:float", at, "2.25")):
        command = ["mbpoll", "-m", "rtu", "-b", "19200", "-P", "even", "-a", "1", "-0", "-1", "-q", "-B"]
        command += ["-t", table, "-c", "1"]
        for _ in range(2):  # the first one may be from an older snapshot: mbpoll does not read its number
            done = subprocess.run([*command, "-r", str(number), far_end], capture_output=True, text=True, timeout=20)
            time.sleep(2.1 if wanted not in done.stdout else 0)
        assert done.returncode == 0 and f"[{number}]: \t{wanted}\n" in done.stdout, done.stdout


def test_pymodbus(serve, far_end):
    client_module = pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    pytest.importorskip("serial", reason="pyserial is not installed")
    gateway = serve("--allow-commands", parity="N")  # pseudo terminals have none, and pyserial insists
    with client_module.ModbusSerialClient(far_end, baudrate=19200, parity="N") as client:
        for _ in range(20):
            assert client.read_input_registers(0, count=5, device_id=1).registers == [0x5455, 0x4D42, 1, 0x47F1, 0x2000]
        assert client.read_input_registers(0, count=125, device_id=1).registers[:2] == [0x5455, 0x4D42]
        assert not client.write_registers(0, [*KEYS, 0, 0, 3, 0, 0, 4, 9], device_id=1).isError()
        row = register("Result", "holding")
        wait_until(lambda: client.read_holding_registers(row["register"], count=2, device_id=1).registers == [2, 9])
    assert [gateway.written.get(timeout=5) for _ in range(3)][::2] == ["write 2002 1 03", "write 2002 2 04"]


def test_the_line_alone(start, line):
    gateway = start("--rtu", f"{line.name},115200,O", tcp="none")
    assert f"unit 1 at {line.name}, read only" in gateway.line
    assert line.ask(GOOD) == whole(ANSWER)
