"""tumble-gateway when there is no room for one more: all places taken, or no descriptors left."""

import os
import re
import resource
import time

import pytest
from gateway_bench import (
    GOOD,
    GOOD_ANSWER,
    MOST_CLIENTS,
    frame,
)  # fmt: skip

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]
CALM_S = 2.0  # GATEWAY_CALM_US


def is_open(client):
    """Nobody has closed it."""
    return client.receive(timeout=0.05) is None


def served_at_once(client):
    began = time.monotonic()
    return client.ask(GOOD) == GOOD_ANSWER and time.monotonic() - began < 0.5


def test_idle_clients_lock_nobody_out(start):
    """All places are one address's that has never asked anything. Newcomers get places in the order of idleness."""
    gateway = start()
    idle = [gateway.connect() for _ in range(MOST_CLIENTS)]
    newcomers = []
    for number in range(3):
        newcomers.append(newcomer := gateway.connect())
        assert served_at_once(newcomer)
        assert newcomer.number("Clients") == MOST_CLIENTS and newcomer.number("Connections displaced") == number + 1
        assert [is_open(client) for client in idle[: number + 2]] == (number + 1) * [False] + [True]
    assert newcomer.number("Connections refused") == 0 and all(is_open(client) for client in idle[3:])


def test_who_has_asked_of_late_keeps_its_place(start):
    """Then nobody gives way; after a time without a request the one that asked first does."""
    gateway = start()
    clients = [gateway.connect() for _ in range(MOST_CLIENTS)]
    assert all(client.ask(GOOD) == GOOD_ANSWER for client in clients)
    asked = time.monotonic()
    assert gateway.connect().receive() == b"" and time.monotonic() - asked < CALM_S
    assert clients[0].number("Connections refused") == 1  # and so asked last
    time.sleep(CALM_S + 0.1)
    newcomer = gateway.connect()
    assert served_at_once(newcomer)
    assert [is_open(client) for client in clients[:3]] == [True, False, True]


def test_who_is_busy_keeps_its_place(start):
    """In the middle of a request, silent for longer than all others."""
    gateway = start()
    busy = gateway.connect()
    busy.send(frame(GOOD)[:5])
    others = [gateway.connect() for _ in range(MOST_CLIENTS - 1)]
    time.sleep(CALM_S + 0.1)
    newcomers = [gateway.connect() for _ in range(MOST_CLIENTS - 1)]
    assert all(map(served_at_once, newcomers))
    assert not any(map(is_open, others))
    busy.send(frame(GOOD)[5:])
    assert busy.receive() == frame(GOOD_ANSWER)


def test_a_request_that_waits_is_heard_before_anybody_is_displaced(start):
    """What was asked just before the newcomer came, of a client that had been idle for longest, is answered."""
    gateway = start()
    clients = [gateway.connect() for _ in range(MOST_CLIENTS)]
    time.sleep(0.2)
    os.kill(gateway.process.pid, 19)  # SIGSTOP: both wait for it together, the newcomer's event first
    newcomer = gateway.connect()
    clients[0].send(frame(GOOD))
    os.kill(gateway.process.pid, 18)
    assert newcomer.ask(GOOD) == GOOD_ANSWER and clients[0].receive() == frame(GOOD_ANSWER)
    assert [is_open(client) for client in clients[:3]] == [True, False, True]


def test_an_address_loses_only_places_of_its_own(start):
    """Idle clients of another address stay, whoever comes from where; and one that holds more cannot take theirs."""
    gateway = start()
    few = [gateway.connect("127.0.0.2") for _ in range(4)]
    many = [gateway.connect() for _ in range(MOST_CLIENTS - 4)]
    newcomers = [gateway.connect(source) for source in ("127.0.0.1", "127.0.0.2", "127.0.0.3")]
    assert all(map(served_at_once, newcomers))
    assert [is_open(client) for client in many[:4]] == [False, False, False, True]
    assert all(map(is_open, few)) and all(map(is_open, many[4:]))


def test_an_address_with_many_busy_clients_takes_nobody_s_place(start):
    gateway = start()
    idle = [gateway.connect("127.0.0.2") for _ in range(4)]
    busy = [gateway.connect() for _ in range(MOST_CLIENTS - 4)]
    assert all(client.ask(GOOD) == GOOD_ANSWER for client in busy)
    assert gateway.connect().receive() == b""
    assert all(map(is_open, idle)) and busy[0].number("Connections refused") == 1
    assert served_at_once(gateway.connect("127.0.0.3"))  # from the address with most places, busy or not
    assert all(map(is_open, idle)) and [is_open(client) for client in busy[:3]] == [True, False, True]


def test_an_address_whose_clients_all_poll_locks_nobody_else_out(start):
    """All places are taken by clients of one address that have just asked: others get places, up to an equal share."""
    gateway = start()
    pollers = [gateway.connect() for _ in range(MOST_CLIENTS)]
    assert all(client.ask(GOOD) == GOOD_ANSWER for client in pollers)
    newcomers = [gateway.connect("127.0.0.2") for _ in range(MOST_CLIENTS // 2)]
    assert all(map(served_at_once, newcomers))
    half = MOST_CLIENTS // 2
    assert [is_open(client) for client in pollers] == half * [False] + half * [True]  # who asked first went first
    late = [gateway.connect(source) for source in ("127.0.0.2", "127.0.0.1")]  # nobody has fewer than the other now
    assert [client.receive() for client in late] == [b"", b""]
    assert served_at_once(gateway.connect("127.0.0.3"))
    counts = [pollers[-1].number(f"Connections {what}") for what in ("displaced", "refused")]
    assert counts == [half + 1, 2]


def processor_s(gateway):
    """Processor time that it has used."""
    with open(f"/proc/{gateway.process.pid}/stat", encoding="ascii") as file:
        user, system = file.read().rsplit(")", 1)[1].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def limit_descriptors(gateway, count):
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.prlimit(gateway.process.pid, resource.RLIMIT_NOFILE, (count, most))


def measured(gateway, seconds=3.0):
    """Processor time in such a while."""
    before = processor_s(gateway)
    time.sleep(seconds)
    return processor_s(gateway) - before


def test_out_of_descriptors_it_rests_and_says_so_once(launch):
    """And serves again when there are some, whether because a client has gone or from elsewhere."""
    gateway = launch("--poll", 1000)
    limits = resource.prlimit(gateway.process.pid, resource.RLIMIT_NOFILE)
    first = [gateway.connect() for _ in range(2)]
    assert all(map(served_at_once, first))
    calm_s = measured(gateway)
    limit_descriptors(gateway, 3)
    waiting = [gateway.connect() for _ in range(4)]
    for client in waiting:
        client.send(frame(GOOD))
    spent_s = measured(gateway)
    assert spent_s < calm_s + 0.15, (spent_s, calm_s)
    assert served_at_once(first[0])  # the others are, all the while
    assert all(map(is_open, waiting)) and 4 <= first[0].number("Connections put off") <= 20
    resource.prlimit(gateway.process.pid, resource.RLIMIT_NOFILE, limits)
    assert all(client.receive(timeout=2.0) == frame(GOOD_ANSWER) for client in waiting)

    used = len(os.listdir(f"/proc/{gateway.process.pid}/fd"))
    limit_descriptors(gateway, used)
    late = gateway.connect()
    late.send(frame(GOOD))
    assert late.receive(timeout=0.3) is None
    began = time.monotonic()
    first[1].close()
    assert late.receive(timeout=2.0) == frame(GOOD_ANSWER) and time.monotonic() - began < 0.4
    print(f"processor time in 3 s: {calm_s:.2f} s in calm, {spent_s:.2f} s out of descriptors")
    resource.prlimit(gateway.process.pid, resource.RLIMIT_NOFILE, limits)
    code, said = gateway.end()
    assert code == 0 and re.fullmatch(
        r"tumble-gateway: cannot accept connections: Too many open files; trying again\n", said)
