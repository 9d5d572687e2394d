"""tumble-gateway and clients that are slow, silent or many, on ASan and UBSan.
Further rows of the table of test_gateway_abuse.py."""

import socket
import struct
import threading
import time

import pytest
from gateway_bench import (
    FUNCTION,
    GOOD,
    GOOD_ANSWER,
    KEYS,
    MOST_CLIENTS,
    READ_INPUT,
    VALUE,
    counter,
    frame,
    wait_until,
)  # fmt: skip

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]


def test_an_unfinished_request_is_not_waited_for_forever(abused):
    client = abused.connect()
    client.send(frame(GOOD)[:9])
    began = time.monotonic()
    assert client.receive(timeout=9.0) == b"" and 4.5 < time.monotonic() - began < 8.0
    abused.abuse, abused.came_back = "a request begun and not ended", "closed after 5 s"


@pytest.mark.parametrize("asked_before", [False, True])
def test_bytes_that_trickle_in_do_not_prolong_a_request(start, asked_before):
    """The 5 s are those since its first byte, however many come in between."""
    client = start().connect()
    assert not asked_before or client.ask(GOOD) == GOOD_ANSWER
    began = time.monotonic()
    for byte in frame(GOOD)[:-1]:
        client.send(bytes((byte,)))
        if client.receive(timeout=1.0) == b"":
            break
    assert 4.5 < time.monotonic() - began < 6.0


def test_a_slow_writer(abused):
    client = abused.connect()
    for _ in range(3):
        for byte in frame(GOOD):
            client.send(bytes((byte,)))
            time.sleep(0.05)
        assert client.receive() == frame(GOOD_ANSWER)
    abused.abuse, abused.came_back = "a writer of one byte every 50 ms", "answered"


def test_many_slow_writers(abused):
    clients = [abused.connect() for _ in range(MOST_CLIENTS - 2)]
    for byte in frame(GOOD):
        for client in clients:
            client.send(bytes((byte,)))
        time.sleep(0.02)
    assert all(client.receive() == frame(GOOD_ANSWER) for client in clients)
    abused.abuse, abused.came_back = f"{len(clients)} writers of one byte every 20 ms at a time", "answered"


def test_a_client_that_does_not_read(abused):
    client, sent = abused.connect(), 0
    client.socket.setblocking(False)
    request = frame(struct.pack(">BHH", READ_INPUT, 0, 125))
    end = time.monotonic() + 2.0
    while time.monotonic() < end:
        try:
            sent += client.socket.send(request * 100)
        except BlockingIOError:
            time.sleep(0.01)
    assert sent > 100000
    wait_until(lambda: counter(abused, "Clients") == 2, timeout=15)
    assert counter(abused, "Connections idle") == 1
    abused.abuse = "a client that asks without end and takes no answer"
    abused.came_back = "not listened to meanwhile; closed after 5 s"


def test_a_flood_of_requests(abused):
    for _ in abused.bystander.again():
        client, count = abused.connect(), 20000
        threading.Thread(target=client.send, args=(frame(GOOD) * count,), daemon=True).start()
        for _ in range(count):
            assert client.receive() == frame(GOOD_ANSWER)
        client.close()
    abused.abuse, abused.came_back = f"{count} requests in one piece", "answered, all"


def test_requests_in_one_piece_whose_answers_need_more_room_than_there_is(start):
    client, count = start().connect(), 40
    client.send(b"".join(frame(struct.pack(">BHH", READ_INPUT, 0, 125), transaction=i) for i in range(count)))
    for i in range(count):
        answer = client.receive()
        assert answer[:6] == struct.pack(">HHH", i, 0, 253) and len(answer) == 259


def asked(gateway, count):
    """A client that has asked so much and not yet read an answer."""
    client = gateway.connect()
    client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
    client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 20)
    client.socket.settimeout(20)
    client.send(b"".join(frame(struct.pack(">BHH", READ_INPUT, 0, 125), transaction=i) for i in range(count)))
    return client


def test_who_says_that_it_asks_no_more_gets_its_answers(start):
    """As many as there is room for on the way, and some that the gateway has to keep for it until it reads."""
    gateway = start()
    for _ in range(3):  # the kernel's room is another the first time
        before = counter(gateway, "Requests")
        endless = asked(gateway, 20000)
        time.sleep(1.0)
        room = counter(gateway, "Requests") - before - 1
        endless.close()
    assert room < 20000
    for count in range(room - 2, room + 7, 2):
        client = asked(gateway, count)
        client.socket.shutdown(socket.SHUT_WR)
        time.sleep(0.5)
        for i in range(count):
            answer = client.receive()
            assert answer[:6] == struct.pack(">HHH", i, 0, 253), (i, room)
        assert client.receive() == b""
        client.close()
    wait_until(lambda: counter(gateway, "Clients") == 1)


def test_who_asks_no_more_and_takes_nothing_is_closed(start):
    gateway = start("--idle", 2)
    client = gateway.connect()
    client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.socket.setblocking(False)
    request, end = frame(struct.pack(">BHH", READ_INPUT, 0, 125)), time.monotonic() + 0.5
    while time.monotonic() < end:
        try:
            client.socket.send(request * 100)
        except BlockingIOError:
            time.sleep(0.01)
    client.socket.shutdown(socket.SHUT_WR)
    wait_until(lambda: counter(gateway, "Connections idle") == 1, timeout=15)


def test_a_silent_client(start):
    gateway = start("--idle", 2)
    silent, talking = gateway.connect(), gateway.connect()
    began = time.monotonic()
    assert talking.ask(GOOD) == GOOD_ANSWER
    while silent.receive(timeout=0.2) is None:
        assert talking.ask(GOOD) == GOOD_ANSWER
    assert 1.5 < time.monotonic() - began < 5.0
    assert talking.number("Connections idle") == 1 and talking.number("Clients") == 1
    talking.socket.settimeout(5)
    assert talking.receive(timeout=5) == b""  # silent itself by now


def test_silent_clients_do_no_harm(abused):
    silent = [abused.connect() for _ in range(10)]
    time.sleep(1.0)
    assert all(client.receive(timeout=0.01) is None for client in silent)
    abused.abuse, abused.came_back = "10 clients that say nothing", "closed after 10 s, or `--idle` if that is less"


def test_fifty_connections(abused):
    assert counter(abused, "Clients") == 2
    wait_until(lambda: counter(abused, "Clients") == 2)
    for _ in abused.bystander.again():
        before = [counter(abused, f"Connections{what}") for what in ("", " refused", " displaced")]
        clients = [abused.connect() for _ in range(50)]
        answers = []
        for client in reversed(clients):
            try:
                answers.append(client.ask(GOOD))
            except OSError:
                answers.append(b"")
        assert answers == (MOST_CLIENTS - 1) * [GOOD_ANSWER] + (50 - MOST_CLIENTS + 1) * [b""]
        last = clients[-1]
        assert last.number("Clients") == MOST_CLIENTS
        after = [last.number(f"Connections{what}") for what in ("", " refused", " displaced")]
        assert [b - a for a, b in zip(before[1:], after[1:])] == [0, 50 - MOST_CLIENTS + 1]
        assert after[0] - before[0] >= 50
        for client in clients:
            client.close()
        wait_until(lambda: counter(abused, "Clients") == 2)
    abused.abuse = "50 connections at a time"
    abused.came_back = f"{MOST_CLIENTS} in all are served: the last to come, and who has asked"


def test_connections_that_come_and_go(abused):
    for _ in abused.bystander.again():
        for number in range(300):
            client = abused.connect()
            client.send(frame(GOOD))
            if number % 3 == 0:  # reset instead of the end of the connection
                client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            elif number % 3 == 1:
                assert client.receive() == frame(GOOD_ANSWER)
            client.close()
    wait_until(lambda: counter(abused, "Clients") == 2)
    abused.abuse, abused.came_back = "300 connections that are closed or reset at once", "answered where one listens"


def test_unlock_of_one_is_no_unlock_of_others(start):
    gateway = start("--allow-commands")
    one, others = gateway.connect(), [gateway.connect() for _ in range(10)]
    one.unlock()
    assert all(other.write(4, 1) == FUNCTION for other in others)
    assert one.write(4, 1) is None and one.write(0, KEYS[0], 0) == VALUE
