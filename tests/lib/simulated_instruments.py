"""A rotary table with a block on it, and instruments that speak lines of text: over TCP, and on a pseudo-terminal.

No clock: after each motion the block swings for so many samples, however fast they are read.
"""

import contextlib
import os
import re
import socketserver
import threading
import tty

import numpy as np

from tumble.files.schedule_file import schedule_of
from tumble.model.geometry import Geometry

K = np.array([[2.0, 0.03, -0.02], [-0.02, 2.0, 0.03], [0.025, -0.037, 2.0]])
U0 = np.array([0.01, -0.01, 0.02])
NOISE = 1e-4


class Rig:
    """`mounting` and `angle_deg` are where it is; `commands` what it was told; `turn` may be replaced by a worse one;
    `swing` (V) dies out within some 200 samples."""

    def __init__(self, schedule="paper", swing=0.3, seed=1):
        self.schedule = schedule_of(schedule).data
        places = [(one.mounting, one.angle_deg) for one in self.schedule.positions]
        self._outputs = dict(zip(places, Geometry(self.schedule).force() @ K.T + U0))
        self.mounting, self.angle_deg, self.since, self.swing = places[0][0], 0.0, 0, swing
        self.commands, self.samples = [], 0
        self._rng = np.random.default_rng(seed)

    def mount(self, mounting):
        self.mounting = mounting.number

    def turn(self, angle_deg):
        self.angle_deg, self.since = angle_deg, 0

    def read(self):
        self.since += 1
        self.samples += 1
        swing = self.swing * np.exp(-self.since / 20.0) * np.sin(self.since)
        return self._outputs[self.mounting, self.angle_deg] + swing + NOISE * self._rng.standard_normal(3)

    def answer(self, line):
        """Of the table, and of a multimeter with three channels; None: none."""
        self.commands.append(line)
        if found := re.fullmatch(r"POS (-?[\d.]+)", line):
            self.turn(float(found[1]))
        elif line == "POS?":
            return f"{self.angle_deg:.4f}"
        elif line == "READ?":
            return ",".join(f"{one:+.6E}" for one in self.read())
        elif found := re.fullmatch(r"MEAS:VOLT:DC\? \(@10([123])\)", line):
            return f"{self.read()[int(found[1]) - 1]:+.6E}"
        return None


@contextlib.contextmanager
def over_tcp(rig):
    """Yields the port of a server that answers line by line."""

    class Handler(socketserver.StreamRequestHandler):
        def handle(self):
            for line in self.rfile:
                if (answer := rig.answer(line.decode().strip())) is not None:
                    self.wfile.write(answer.encode() + b"\n")

    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield server.server_address[1]
        finally:
            server.shutdown()
            thread.join()


@contextlib.contextmanager
def on_terminal(rig):
    """Yields the name of a pseudo-terminal on which lines come by themselves: a counter, then the outputs."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    ended = threading.Event()

    def send():
        with contextlib.suppress(OSError):
            while not ended.is_set():
                x, y, z = rig.read()
                os.write(ours, f"{rig.samples},{x:.6f},{y:.6f},{z:.6f}\r\n".encode())

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        ended.set()
        with contextlib.suppress(OSError):
            os.set_blocking(theirs, False)
            while thread.is_alive():
                with contextlib.suppress(BlockingIOError):
                    os.read(theirs, 1 << 16)
                thread.join(0.001)
        os.close(ours)
        os.close(theirs)
