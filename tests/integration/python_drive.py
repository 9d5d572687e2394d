"""A drive of another make: CiA 402 on python-canopen's local node, with units, a sign and process data of its own.

It shares nothing with the simulated drive in C. 327680 counts a turn, counting downwards; velocities in tenths of a
revolution per minute, accelerations in tenths of a revolution per minute and second. Its process data lie in the third
receive PDO and the second transmit PDO. It will not be switched on until somebody has written 1 to 2100h.
"""

import struct
import time

import canopen
from canopen.objectdictionary import ODArray, ODRecord, ODVariable, datatypes

NODE = 2
COUNTS_PER_TURN = 327680
SIGN = -1
UNITS_PER_DEG_S = 10.0 / 6.0
CYCLE_S = 0.005
PROFILE = {  # how our firmware is told of it
    "present__drive": "no",
    "profile__counts_per_turn": COUNTS_PER_TURN,
    "profile__sign": SIGN,
    "profile__velocity_per_deg_s": UNITS_PER_DEG_S,
    "profile__acceleration_per_deg_s2": UNITS_PER_DEG_S,
    "profile__receive_pdo": "2 0x302 607A:0:32 6040:0:16 6060:0:8",
    "profile__transmit_pdo": "1 0x282 0 50 6061:0:8 6064:0:32 6041:0:16",
    "profile__write": "0x2100 0 1 1",
}

SWITCH_ON_DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP, FAULT = 0x40, 0x21, 0x23, 0x27, 0x07, 0x08
REACHED, ACKNOWLEDGED, ATTAINED = 0x0400, 0x1000, 0x1000

U8, U16, U32 = datatypes.UNSIGNED8, datatypes.UNSIGNED16, datatypes.UNSIGNED32
I8, I32 = datatypes.INTEGER8, datatypes.INTEGER32
SIZES = {U8: "<B", U16: "<H", U32: "<I", I8: "<b", I32: "<i"}

VARIABLES = {
    0x1000: (U32, 0x20192), 0x1001: (U8, 0), 0x1017: (U16, 0), 0x2100: (U8, 0), 0x603F: (U16, 0), 0x6040: (U16, 0),
    0x6041: (U16, 0), 0x6060: (I8, 0), 0x6061: (I8, 0), 0x6064: (I32, 0), 0x607A: (I32, 0), 0x6081: (U32, 0),
    0x6083: (U32, 0), 0x6084: (U32, 0), 0x6085: (U32, 0), 0x6098: (I8, 0), 0x609A: (U32, 0), 0x6502: (U32, 0x21),
}
RECORDS = {
    0x1016: [(U8, 1), (U32, 0)],
    0x1018: [(U8, 1), (U32, 0x99)],
    0x1402: [(U8, 2), (U32, 0x80000000), (U8, 255)],
    0x1602: [(U8, 0)] + 8 * [(U32, 0)],
    0x1801: [(U8, 5), (U32, 0x80000000), (U8, 255), (U16, 0), (U8, 0), (U16, 0)],
    0x1A01: [(U8, 0)] + 8 * [(U32, 0)],
    0x607D: [(U8, 2), (I32, 0), (I32, 0)],
    0x6099: [(U8, 2), (U32, 0), (U32, 0)],
}


def dictionary():
    """The object dictionary, all of it readable and writable."""
    objects = canopen.ObjectDictionary()
    for index, (kind, default) in VARIABLES.items():
        objects.add_object(variable(index, 0, kind, default))
    for index, members in RECORDS.items():
        record = (ODArray if index == 0x1016 else ODRecord)(f"{index:04X}", index)
        for subindex, (kind, default) in enumerate(members):
            record.add_member(variable(index, subindex, kind, default))
        objects.add_object(record)
    return objects


def variable(index, subindex, kind, default):
    """One object."""
    made = ODVariable(f"{index:04X}:{subindex}", index, subindex)
    made.data_type, made.default, made.access_type = kind, default, "rw"
    return made


class PythonDrive:
    """The drive on a bus with `turn_table`, from power-on, as long as `step` is called. `events`: what it did."""

    def __init__(self, bus):
        self.bus, self.events = bus, []
        self.state, self.mode_bits, self.word = SWITCH_ON_DISABLED, 0, 0
        self.start_deg = self.goal_deg = 11.0
        self.started, self.arrives, self.legs = 0.0, 0.0, []
        self.heard, self.sent, self.sent_at = time.monotonic(), None, 0.0
        self.silent, self.beaten_at = False, 0.0
        self.bus.turn_table(self.start_deg, 1e4)
        self.network = canopen.Network(bus)
        self.node = self.network.create_node(NODE, dictionary())
        self.node.add_write_callback(self.on_write)
        self.node.nmt.start_heartbeat = lambda _: None  # ours, which can fall silent, is in the cycle
        self.network.subscribe(0x701, self.on_master)
        self.node.nmt.send_command(129)
        self.network.send_message(0x700 + NODE, [0])
        self.node.nmt.send_command(128)

    def require_all_positions(self):
        """It was homed first, and sent to all of the paper's positions."""
        angles = [event for event in self.events[1:] if isinstance(event, float)]
        assert self.events[0] == "home" and {45.0 * number for number in range(9)} <= set(angles)

    def get(self, index, subindex=0):
        """A value from the dictionary."""
        entry = self.node.object_dictionary[index]
        entry = entry if isinstance(entry, ODVariable) else entry[subindex]
        return struct.unpack(SIZES[entry.data_type], self.node.get_data(index, subindex))[0]

    def put(self, index, value):
        """Into the dictionary, without anybody being told."""
        kind = self.node.object_dictionary[index].data_type
        self.node.data_store.setdefault(index, {})[0] = struct.pack(SIZES[kind], value)

    def on_write(self, index, subindex, od, data):
        """By SDO. python-canopen stores the value only after this."""
        self.node.data_store.setdefault(index, {})[subindex] = bytes(data)
        if index == 0x1402 and subindex == 1 and not self.get(0x1402, 1) >> 31:
            self.network.subscribe(self.get(0x1402, 1) & 0x7FF, self.on_receive_pdo)
        elif index == 0x6060 and not self.get(0x6040) & 0x100:
            self.take_mode()
        elif index == 0x6040:
            self.command()

    def take_mode(self):
        """6060h comes into force."""
        self.put(0x6061, self.get(0x6060))
        self.mode_bits = 0

    def on_receive_pdo(self, _, data, __):
        """Values as our own mapping says."""
        if self.node.nmt.state != "OPERATIONAL":
            return
        at = 0
        for subindex in range(1, self.get(0x1602, 0) + 1):
            entry = self.get(0x1602, subindex)
            size = (entry & 0xFF) // 8
            self.node.data_store.setdefault(entry >> 16, {})[0] = bytes(data[at : at + size])
            at += size
        if self.get(0x6060) != self.get(0x6061):
            self.take_mode()
        self.command()

    def on_master(self, *_):
        """The master's heartbeat."""
        self.heard = time.monotonic()

    def command(self):
        """A controlword has come."""
        word, before = self.get(0x6040), self.word
        self.word = word
        rising = word & ~before
        self.power(word, rising)
        if self.state != ENABLED:
            return
        if self.get(0x6061) == 6 and rising & 0x10:
            self.events.append("home")
            self.mode_bits, self.legs = 0, [-7.0, 0.0]
            self.set_out()
        elif self.get(0x6061) == 1:
            self.take_set_point(word, rising)

    def take_set_point(self, word, rising):
        """Bit 4 rises: a new target, acknowledged until bit 4 falls."""
        if rising & 0x10 and not self.mode_bits & ACKNOWLEDGED:
            target_deg = SIGN * self.get(0x607A) * 360.0 / COUNTS_PER_TURN
            self.events.append(round(target_deg, 3))
            self.mode_bits, self.legs = ACKNOWLEDGED, [target_deg]
            self.set_out()
        elif not word & 0x10:
            self.mode_bits &= ~ACKNOWLEDGED

    def power(self, word, rising):
        """The state machine."""
        if self.state == FAULT:
            if rising & 0x80:
                self.state = SWITCH_ON_DISABLED
        elif not word & 0x02:
            self.state = SWITCH_ON_DISABLED
            self.stop()
        elif not word & 0x04:
            self.stop()
            self.state = QUICK_STOP if self.state in (ENABLED, QUICK_STOP) else SWITCH_ON_DISABLED
        elif word & 0x0F == 0x06 and self.get(0x2100) == 1:
            self.state = READY
        elif word & 0x0F == 0x07 and self.state in (READY, ENABLED):
            self.state = SWITCHED_ON
        elif word & 0x0F == 0x0F and self.state in (SWITCHED_ON, QUICK_STOP):
            self.state = ENABLED

    def angle(self):
        """Where the table is by now."""
        now, way = time.monotonic(), self.arrives - self.started
        share = 1.0 if now >= self.arrives or way <= 0.0 else (now - self.started) / way
        return self.start_deg + (self.goal_deg - self.start_deg) * share

    def set_out(self):
        """To the next leg's end."""
        self.start_deg, self.goal_deg, self.started = self.angle(), self.legs.pop(0), time.monotonic()
        speed = self.get(0x6081) / UNITS_PER_DEG_S
        self.arrives = self.started + abs(self.goal_deg - self.start_deg) / speed + 0.15  # ramps of the table
        self.bus.turn_table(self.goal_deg, speed)

    def stop(self):
        """Where it is."""
        here = self.angle()
        if time.monotonic() < self.arrives:
            self.events.append("stop")
            self.bus.turn_table(here, 1e4)
        self.start_deg = self.goal_deg = here
        self.arrives, self.legs = 0.0, []

    def step(self):
        """What comes within a cycle's time; then motion, supervision, process data."""
        end = time.monotonic() + CYCLE_S
        while (message := self.bus.recv(max(0.0, end - time.monotonic()))) is not None:
            self.network.notify(message.arbitration_id, message.data, message.timestamp)
        at_rest = time.monotonic() >= self.arrives
        if at_rest and self.legs:
            self.set_out()
            at_rest = False
        self.put(0x6064, round(SIGN * self.angle() * COUNTS_PER_TURN / 360.0))
        homed = ATTAINED if self.get(0x6061) == 6 and self.events[-1:] == ["home"] and at_rest else 0
        reached = REACHED if at_rest else 0
        self.put(0x6041, 0x0200 | self.state | self.mode_bits | homed | reached)
        silence_s = (self.get(0x1016, 1) & 0xFFFF) / 1e3
        if silence_s and self.state == ENABLED and time.monotonic() - self.heard > silence_s:
            self.events.append("master lost")
            self.stop()
            self.state = FAULT
        if self.get(0x1017) and not self.silent and time.monotonic() - self.beaten_at > self.get(0x1017) / 1e3:
            self.beaten_at = time.monotonic()
            self.network.send_message(0x700 + NODE, [5 if self.node.nmt.state == "OPERATIONAL" else 127])
        self.report()

    def report(self):
        """The transmit PDO: when something has changed, or its time has come."""
        cob_id, event_s = self.get(0x1801, 1), self.get(0x1801, 5) / 1e3
        if cob_id >> 31 or self.node.nmt.state != "OPERATIONAL":
            return
        entries = [self.get(0x1A01, subindex) for subindex in range(1, self.get(0x1A01, 0) + 1)]
        data = b"".join(self.node.get_data(entry >> 16, entry >> 8 & 0xFF) for entry in entries)
        if data != self.sent or (event_s and time.monotonic() - self.sent_at > event_s):
            self.sent, self.sent_at = data, time.monotonic()
            self.network.send_message(cob_id & 0x7FF, data)
