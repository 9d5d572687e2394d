"""tumble-gateway and clients that do everything wrong, on ASan and UBSan: exactly what comes back, and how long a
client that does nothing wrong waits meanwhile. What is printed is the table of docs/gateway.md (-rP shows it)."""

import contextlib
import random
import socket
import struct
import threading
import time

import pytest
from gateway_bench import (
    ADDRESS,
    FUNCTION,
    GOOD,
    GOOD_ANSWER,
    NO_PATH,
    READ_HOLDING,
    READ_INPUT,
    VALUE,
    WRITE_ONE,
    WRITE_SEVERAL,
    counter,
    end_of,
    frame,
    wait_until,
)  # fmt: skip

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]


def refusal(function, exception):
    return bytes((function | 0x80, exception))


def test_nothing_wrong(abused):
    abused.abuse, abused.came_back = "none: the client alone, for comparison", "-"
    time.sleep(1.0)


def expected_of_function(function):
    """Of a request with four bytes 0, 0, 0, 1 behind the function."""
    if function >= 0x80:
        return None
    if function in (READ_HOLDING, READ_INPUT):
        return bytes((function, 2)) + (b"\0\0" if function == READ_HOLDING else b"\x54\x55")
    if function == WRITE_SEVERAL:
        return refusal(function, VALUE)
    return refusal(function, FUNCTION)


def test_every_function_code(abused):
    for _ in abused.bystander.again():
        client = abused.connect()
        for function in range(256):
            client.send(frame(bytes((function, 0, 0, 0, 1)), transaction=function))
            client.send(frame(GOOD, transaction=0x4000))
            wanted = expected_of_function(function)
            if wanted is not None:
                assert client.receive() == frame(wanted, transaction=function), function
            assert client.receive() == frame(GOOD_ANSWER, transaction=0x4000), function
        client.close()
    abused.abuse = "function codes 0 to 255"
    abused.came_back = ("3, 4: answered; 6: exception 1 (read only); 16: exception 3 (its length); else exception 1; "
                        "from 128 on silence")


@pytest.mark.parametrize("function", [READ_HOLDING, READ_INPUT, WRITE_ONE, WRITE_SEVERAL, 0x2B])
def test_every_length(abused, function):
    """Of the MBAP header, with as many bytes behind it."""
    for _ in abused.bystander.again():
        for length in range(261):
            client = abused.connect()
            body = (bytes((1, function)) + b"\0\0\0\1" + bytes(260))[:length]
            client.send(struct.pack(">HHH", length, 0, length) + body)
            if length > 254:
                assert client.receive() == b"", length
            else:
                client.send(frame(GOOD, transaction=0x4000))
                if length >= 2:
                    right = length == 6 and function in (READ_HOLDING, READ_INPUT, WRITE_ONE)
                    wanted = expected_of_function(function) if right else refusal(
                        function, FUNCTION if function == 0x2B else VALUE)
                    assert client.receive() == frame(wanted, transaction=length), length
                assert client.receive() == frame(GOOD_ANSWER, transaction=0x4000), length
            client.close()
    abused.abuse = f"MBAP lengths 0 to 260 with as many bytes, function {function}"
    abused.came_back = ("0, 1: silence; the right one: answered as ever; other: exception 3 (1 where the function is "
                        "wrong); above 254: closed")


@pytest.mark.parametrize("function, table", [(READ_INPUT, "input"), (READ_HOLDING, "holding")])
def test_counts(abused, function, table):
    client, end = abused.connect(), end_of(table)
    for _ in abused.bystander.again():
        for at in (0, 1, end - 1, end, 65535):
            for count in (0, 1, 2, end, 124, 125, 126, 127, 128, 255, 256, 65535):
                answer = client.ask(struct.pack(">BHH", function, at, count))
                if not 1 <= count <= 125:
                    assert answer == refusal(function, VALUE), (at, count)
                elif at + count > end:
                    assert answer == refusal(function, ADDRESS), (at, count)
                else:
                    assert answer[:2] == bytes((function, 2 * count)) and len(answer) == 2 + 2 * count
    abused.abuse = f"counts 0, 1, 125, 126 to 65535 at the edges of the map, function {function}"
    abused.came_back = "1 to 125 within the map: answered; beyond it: exception 2; 0 and above 125: exception 3"


def test_every_unit(abused):
    for _ in abused.bystander.again():
        client = abused.connect()
        for unit in range(256):
            wanted = GOOD_ANSWER if unit in (1, 255) else refusal(READ_INPUT, NO_PATH)
            assert client.ask(GOOD, unit=unit) == wanted
        client.close()
    abused.abuse, abused.came_back = "units 0 to 255", "its own and 255: answered; else exception 10"


def test_other_protocols(abused):
    for _ in abused.bystander.again():
        client = abused.connect()
        for protocol in (1, 2, 0x100, 0x5555, 0xFFFF):
            client.send(frame(GOOD, protocol=protocol))
            assert client.ask(GOOD) == GOOD_ANSWER
        client.close()
    abused.abuse, abused.came_back = "MBAP protocol identifiers other than 0", "silence; the connection stays"


def test_what_is_wrong_is_counted(start):
    client = start().connect()
    for function in range(0x80):
        client.ask(bytes((function, 0, 0, 0, 1)))
    for unit in range(256):
        client.ask(GOOD, unit=unit)
    for _ in range(5):
        client.send(frame(GOOD, protocol=1))
    for size in (0, 1, 2, 3, 5, 6):
        client.ask(bytes((READ_INPUT,)) + bytes(size))
    client.send(struct.pack(">HHHHHHB", 0, 0, 0, 0, 0, 1, 1))
    names = ("Wrong function", "Wrong unit", "Wrong protocol", "Wrong length", "Wrong value", "Wrong address")
    assert [client.number(name) for name in names] == [0x80 - 4, 254, 5, 1 + 6 + 2, 0, 0]
    client.ask(struct.pack(">BHH", READ_INPUT, 0, 0))
    client.ask(struct.pack(">BHH", READ_INPUT, 60000, 1))
    assert [client.number(name) for name in names] == [0x80 - 4, 254, 5, 1 + 6 + 2, 1, 1]
    assert client.number("Requests") == client.number("Answers") + client.number("Exceptions") - 254 - 1


@pytest.mark.parametrize("data, came_back", [
    (b"GET / HTTP/1.1\r\nHost: gateway\r\n\r\n", b""),
    (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + bytes(500), None),  # other protocols; no functions
    (b"\xff" * 1000, b""),
    (b"SSH-2.0-OpenSSH_9.2\r\n", b""),
], ids=["http", "tls", "ones", "ssh"])  # fmt: skip
def test_another_protocol_altogether(abused, data, came_back):
    for _ in abused.bystander.again():
        client = abused.connect()
        with contextlib.suppress(OSError):  # closed already
            client.send(data)
        assert client.receive(timeout=0.3) == came_back
        client.close()
    abused.abuse = f"`{data[:12]!r}` and so on, {len(data)} bytes"
    abused.came_back = "silence" if came_back is None else "closed"


def test_truncated_frames(abused):
    for _ in abused.bystander.again():
        for size in range(len(frame(GOOD))):
            client = abused.connect()
            client.send(frame(GOOD)[:size])
            client.socket.shutdown(socket.SHUT_WR)
            assert client.receive() == b""
            client.close()
    wait_until(lambda: counter(abused, "Clients") == 2)
    abused.abuse = "frames that end after 0 to 11 bytes, then the end of the connection"
    abused.came_back = "silence, closed"


def test_noise(abused):
    """What comes back is not known, but the gateway is there all the same, and nothing is written."""
    draw = random.Random(20)
    for _ in abused.bystander.again():
        for _ in range(400):
            client = abused.connect()
            data = draw.randbytes(draw.randrange(1, 400))
            if draw.random() < 0.7:  # behind a good header
                data = struct.pack(">HHHB", 0, 0, min(len(data) + 1, 254), 1) + data
            client.send(data)
            client.close()
    wait_until(lambda: counter(abused, "Clients") == 2)
    assert abused.written.empty()
    abused.abuse = "400 connections with random bytes, most behind a good header"
    abused.came_back = "what their bytes happen to ask for"


def test_noise_with_commands_allowed(start):
    """Without the keys no random bytes reach the node."""
    gateway, draw = start("--allow-commands"), random.Random(21)
    client = gateway.connect()
    for _ in range(3000):
        pdu = bytes((draw.choice((WRITE_ONE, WRITE_SEVERAL)), 0, draw.randrange(16)))
        pdu += draw.randbytes(draw.randrange(20))
        answer = client.ask(pdu)
        assert len(answer) == 2 and answer[0] & 0x80, (pdu, answer)
    assert client.number("Access") == 1 and gateway.written.empty()


def test_requests_in_pieces(start):
    """However a stream of requests is cut, the answers are the same."""
    gateway, draw = start(), random.Random(22)
    client = gateway.connect()
    stream = b"".join(frame(struct.pack(">BHH", READ_INPUT, number % 5, 1 + number % 3), transaction=number)
                      for number in range(300))
    wanted = (0x5455, 0x4D42, 1, 0x47F1, 0x2000)
    writer = threading.Thread(target=send_in_pieces, args=(client, stream, draw), daemon=True)
    writer.start()
    for number in range(300):
        count = 1 + number % 3
        words = wanted[number % 5 :][:count]
        answer = client.receive()
        assert answer[:9] == frame(bytes((READ_INPUT, 2 * count)), transaction=number)[:5] + answer[5:9]
        assert struct.unpack(f">{len(words)}H", answer[9:9 + 2 * len(words)]) == words
    writer.join()


def send_in_pieces(client, stream, draw):
    while stream:
        size = draw.randrange(1, 40)
        client.send(stream[:size])
        stream = stream[size:]
        time.sleep(0.0005)
