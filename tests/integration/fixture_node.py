"""The played table of fixture_table.py as node 1 behind tumble-gateway: gateway_harness.c answers, a thread decides."""

import contextlib
import struct

import numpy as np
from fixture_table import PlayedTable, Refused
from played_behind_gateway import PlayedBehindGateway

ARGUMENT, COMMAND, ANGLE = (0x2002, 1), (0x2002, 2), (0x2002, 3)
STATE, ACTUAL, STAND = (0x2000, 0), (0x2003, 10), (0x2003, 12)
POSITION, SCHEDULE, AT_REST = 0x2150, 0x2151, 0x2152


class PlayedNode(PlayedBehindGateway):
    """Homes, turns and measures at once: a write is answered when all objects are as it makes them.

    `table`: PlayedTable; `memory`: whether there are 2150h to 2152h; `run`: the one that the node keeps, with its
    `schedule`; `spoils`: so many samples of every measurement; `stuck`: none comes.
    """

    def __init__(self, gateway, table=None, memory=True, run=None, schedule=None, spoils=0, stuck=False, serial=1):
        super().__init__(gateway)
        self.table, self.run_kept, self.schedule = table or PlayedTable(), run, schedule
        self.spoils, self.stuck, self.commands, self.measured, self.angle = spoils, stuck, [], [], 0.0
        for sub, number in enumerate((0, 0x54420001, 0x10000, serial), start=1):
            self.set(0x1018, sub, struct.pack("<I", number))
        self.set(*STATE, b"\0")
        self.show_stand()
        if memory:
            self.measure(0)
            self.select(0)
        self.begin()

    def show_stand(self):
        self.set(*ACTUAL, struct.pack("<d", self.table.read("Progress: Actual angle")))
        self.set(*STAND, bytes([self.table.read("Progress: Stand state")]))

    def take(self, entry, data):
        if entry == ANGLE:
            [self.angle] = struct.unpack("<d", data)
        elif entry == COMMAND:
            self.command(data[0])
        elif entry == (AT_REST, 1):
            self.measure(struct.unpack("<H", data)[0])
        elif entry == (POSITION, 1):
            self.select(data[0])

    def command(self, number):
        self.commands.append(number)
        with contextlib.suppress(Refused):  # to stop a table at rest
            self.table.command(number, angle_deg=self.angle)
        self.show_stand()

    def measure(self, count):
        """2152h, with all samples taken."""
        come = count >= 2 and not self.stuck
        numbers = [None] * 6
        if come:
            mean = self.table.mean(count)
            numbers = [*mean.value, *mean.scatter]
            self.measured.append(mean)
        self.put(AT_REST, 3, numbers)
        self.set(AT_REST, 9, struct.pack("<H", self.spoils if count else 0))
        self.set(AT_REST, 2, struct.pack("<H", count if come else 0))
        self.set(AT_REST, 1, struct.pack("<H", count))

    def select(self, index):
        """2150h and 2151h."""
        numbers, run = [None] * 6, self.run_kept
        if run is not None:
            place = self.schedule.positions[index]
            numbers = [*run.means[index], *run.scatter[index] / np.sqrt(run.samples[index])]
            self.set(SCHEDULE, 2, bytes([place.mounting]))
            self.set(SCHEDULE, 3, bytes([place.number]))
            self.set(POSITION, 2, struct.pack("<I", run.samples[index]))
        self.put(POSITION, 3, numbers)
        self.set(POSITION, 1, bytes([index]))

    def put(self, index, first, numbers):
        for sub, number in enumerate(numbers, start=first):
            self.set(index, sub, None if number is None else struct.pack("<d", number))


__all__ = ["ANGLE", "ARGUMENT", "AT_REST", "COMMAND", "POSITION", "PlayedNode"]
