"""A motor controller with holding registers, served by pymodbus: those of firmware/stand/positioner/positioner.h.

It shares nothing with the firmware, and turns the table of tumble-stand (present.drive = no). It lives in a thread.
"""

import asyncio
import threading
import time

from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

COUNTS_PER_DEG = 10000
SPEED_DEG_S = 720.0
IDENTITY, CYCLE_S, RAMPS_S = 0x5450, 0.005, 0.15
MOVING, IN_POSITION, HOMED, FAULT, WATCHED = 1, 2, 4, 8, 16
STOP, HOME, GO, RESET = range(4)
WRITE_REGISTERS, READ_REGISTERS = 16, 3


class ModbusPositioner:
    """From power-on until `close`. `port`: where it listens; `events`: what it was ordered, and did by itself."""

    def __init__(self, turn_table, speed_deg_s=SPEED_DEG_S):
        self.turn_table, self.speed_deg_s, self.events, self.spoilt = turn_table, speed_deg_s, [], {}
        self.start_deg = self.goal_deg = self.zero_deg = 11.0
        self.started = self.arrives = 0.0
        self.number, self.order, self.fault, self.homed, self.watched = 0, STOP, 0, False, False
        self.watch_until, self.silent = 0.0, False
        self.turn_table(self.start_deg, 1e4)
        self.loop, self.ready, self.port = None, threading.Event(), None
        self.thread = threading.Thread(target=lambda: asyncio.run(self.live()), daemon=True)
        self.thread.start()
        assert self.ready.wait(20), "its server does not start"

    def close(self):
        """Power off."""
        self.loop.call_soon_threadsafe(self.ended.set)
        self.thread.join(10)

    async def live(self):
        """Serve, and watch the time."""
        self.loop, self.ended = asyncio.get_running_loop(), asyncio.Event()
        registers = SimData(0, values=[0] * 22, datatype=DataType.REGISTERS)
        device = SimDevice(1, simdata=[registers], action=self.exchange)
        server = ModbusTcpServer(device, address=("127.0.0.1", 0))
        await server.serve_forever(background=True)
        self.port = server.transport.sockets[0].getsockname()[1]
        self.ready.set()
        while not self.ended.is_set():
            self.cycle()
            await asyncio.sleep(CYCLE_S)
        await server.shutdown()

    async def exchange(self, function, _, address, count, registers, values):
        """Somebody reads or writes."""
        while self.silent:
            await asyncio.sleep(CYCLE_S)
        if function == WRITE_REGISTERS and address == 0:
            self.watch_until = time.monotonic() + values[0] / 1e3
            if count == 5 and values[1] != self.number:
                self.take(*values[1:])
        elif function == READ_REGISTERS:
            registers[16:22] = self.report()

    def report(self):
        """Registers 16 to 21."""
        rests = time.monotonic() >= self.arrives
        there = rests and self.order in (HOME, GO) and not self.fault
        status = (0 if rests else MOVING) | (IN_POSITION if there else 0) | (HOMED if self.homed else 0)
        status |= (FAULT if self.fault else 0) | (WATCHED if self.watched else 0)
        angle = round((self.angle_deg() - self.zero_deg) * COUNTS_PER_DEG) & 0xFFFFFFFF
        values = {16: IDENTITY, 17: status, 18: self.number, 19: self.fault, 20: angle >> 16, 21: angle & 0xFFFF}
        return [*{**values, **self.spoilt}.values()]

    def take(self, number, order, high, low):
        """A new order."""
        self.number, self.order, self.watched = number, order, True
        if order == RESET:
            self.fault = 0
        if order == HOME and not self.fault:
            self.events.append("home")
            self.homed = False
            self.set_out(0.0)
        elif order == GO and self.homed and not self.fault:
            counts = (high << 16 | low) - (1 << 32 if high >> 15 else 0)
            self.events.append(counts / COUNTS_PER_DEG)
            self.set_out(counts / COUNTS_PER_DEG)
        else:
            self.stop()

    def angle_deg(self):
        """Where the table is by now."""
        now, way = time.monotonic(), self.arrives - self.started
        share = 1.0 if now >= self.arrives else (now - self.started) / way
        return self.start_deg + (self.goal_deg - self.start_deg) * share

    def set_out(self, goal_deg):
        """Turn to there."""
        self.start_deg, self.goal_deg, self.started = self.angle_deg(), goal_deg, time.monotonic()
        self.arrives = self.started + abs(goal_deg - self.start_deg) / self.speed_deg_s + RAMPS_S
        self.turn_table(goal_deg, self.speed_deg_s)

    def stop(self):
        """Where it is."""
        if time.monotonic() < self.arrives:
            self.start_deg = self.goal_deg = self.angle_deg()
            self.arrives = 0.0
            self.events.append("stop")
            self.turn_table(self.goal_deg, 1e4)

    def fail(self, code):
        """A fault of its own."""
        self.fault = code
        self.stop()

    def cycle(self):
        """The end of homing, and the watchdog."""
        if self.order == HOME and not self.homed and time.monotonic() >= self.arrives and not self.fault:
            self.homed, self.zero_deg = True, 0.0
        if self.watched and time.monotonic() > self.watch_until:
            self.watched, self.order = False, STOP
            self.events.append("watchdog")
            self.stop()
