"""The measurement of latency.py, on CAN interfaces of the kernel that it runs on, as root."""

import json
import os
import platform
import socket
import subprocess
import time
from contextlib import ExitStack

from processes import HASTE, PATIENCE, Interface, Stand, scenario, wait_until

from tumble.world import programs

# What is beside the node, and whether it has the real-time priority of the service file.
CONDITIONS = {
    "alone": (),
    "bus-load": ("flood",),
    "busy": ("busy",),
    "busy,bus-load": ("busy", "flood"),
    "busy,bus-load,fifo": ("busy", "flood", "fifo"),
}
OUTSIDE, SERVICE = 40, 20  # priorities: of what stands for the world outside; CPUSchedulingPriority of docs/gateway.md
FLOOD_ID = "110"  # outranks all of ours but NMT's
BARE_BITS = 47  # of a frame without data, and without stuff bits, with the interframe space
BITS_PER_S = 500_000
PROGRESS = 0x181  # node 1's transmit PDO 3: state, reason, position, finished, samples
# One position that is averaged for as long as the measurement takes, however slow the machine is.
LONG = {
    **HASTE,
    **dict.fromkeys(PATIENCE, 60000),
    "procedure__samples": 1048576,
    "procedure__average_timeout_ms": 4000000000,
    "procedure__sample_timeout_ms": 1150,  # the most, with a heartbeat of 100 ms
}
BUS, ASIDE = "vcan810", "vcan811"


def measure(settings, folder):
    """{"kernel", "processors", "inside_s", "conditions": [...]}, as `one` has them. `folder` has the programs ask and
    echo; the files began and ended appear in it."""
    path = scenario(folder, **LONG)
    (folder / "began").touch()
    began = time.monotonic()
    conditions = [one(settings, folder, path, name) for name in settings["conditions"]]
    inside_s = time.monotonic() - began
    (folder / "ended").touch()
    return {"kernel": platform.release(), "processors": os.cpu_count(), "inside_s": inside_s, "conditions": conditions}


def one(settings, folder, path, name):
    """One condition: its name, the load, what the node lost; node and echo: [asked_ns, answered_ns] by request."""
    beside = CONDITIONS[name]
    with ExitStack() as stack:
        bus, aside = (interface(stack, each) for each in (BUS, ASIDE))
        node, echo = start_programs(stack, folder, path, bus, aside)
        for process in (node, echo) if "fifo" in beside else ():
            raise_to(process.pid, SERVICE)
        with ExitStack() as load:
            start_load(load, settings, bus, beside)
            before, began = counted(bus), time.monotonic()
            pairs = ask(settings, folder, bus, aside)
            taken_s, after = time.monotonic() - began, counted(bus)
        ended_early = node.poll() is not None
        node.terminate()
        document = json.loads(node.communicate(timeout=60)[0])
    frames, octets = (now - then for now, then in zip(after, before))
    return {"name": name, "requests": settings["requests"], "frames_per_s": frames / taken_s,
            "bus_load": (BARE_BITS * frames + 8 * octets) / taken_s / BITS_PER_S, **pairs,
            **{counter: document["counters"][counter] for counter in ("samples_lost", "kernel_dropped")},
            "ended_by": document["reason"] if ended_early else None}


def interface(stack, name):
    made = Interface(name)
    stack.callback(made.remove)
    return made


def started(stack, *command, **options):
    """A process that is killed in the end, if it has not ended by then."""
    process = subprocess.Popen([str(word) for word in command], **options)
    stack.callback(process.wait)
    stack.callback(process.kill)
    return process


def start_programs(stack, folder, path, bus, aside):
    """Node and echo; the stand has put the block on, and the node averages."""
    echo = started(stack, folder / "echo", aside)
    stand = Stand(bus, path, "--seed", 1)
    stack.callback(stand.kill)
    if stand.process.poll() is not None:
        raise SystemExit(f"tumble-stand: {stand.process.communicate()[1]}")
    raise_to(stand.process.pid, OUTSIDE)
    with socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as watching:
        watching.bind((str(bus),))
        watching.settimeout(1.0)
        program = programs.find("tumble-node")
        node = started(stack, program, bus, path, "--start", stdout=subprocess.PIPE, text=True)
        wait_until(lambda: node.poll() is not None or has_samples(watching.recv(16)), timeout=60)
    return node, echo


def has_samples(frame):
    """Is it the node's progress, with samples of a position?"""
    return int.from_bytes(frame[:4], "little") == PROGRESS and any(frame[12:16])


def raise_to(pid, priority):
    os.sched_setscheduler(pid, os.SCHED_FIFO, os.sched_param(priority))


def start_load(stack, settings, bus, beside):
    for _ in range(settings["busy"] if "busy" in beside else 0):
        started(stack, "sh", "-c", "while :; do :; done")
    if "flood" in beside:
        gap_ms = 1e3 / settings["flood"]
        flood = started(stack, "cangen", bus, "-g", f"{gap_ms:.3f}", "-I", FLOOD_ID, "-L", "8", "-D", "r")
        raise_to(flood.pid, OUTSIDE)


def counted(bus):
    """Frames and bytes that the interface has had."""
    folder = f"/sys/class/net/{bus}/statistics"
    return [int(open(f"{folder}/{name}", encoding="ascii").read()) for name in ("tx_packets", "tx_bytes")]


def ask(settings, folder, bus, aside):
    """{"node": [[asked_ns, answered_ns], ...], "echo": likewise}; answered_ns is 0 where there was no answer."""
    numbers = settings["requests"], round(1e3 * settings["period_ms"])
    command = ["chrt", "-f", OUTSIDE, folder / "ask", bus, aside, *numbers]
    asked = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True).stdout
    pairs = {"0": [], "1": []}
    for line in asked.splitlines():
        target, *stamps = line.split()
        pairs[target].append([int(stamp) for stamp in stamps])
    return {"node": pairs["0"], "echo": pairs["1"]}
