"""Node 1 as a client sees it on CAN, played in process: python-canopen's LocalNode on a virtual bus, and a run that
goes on by one state each time that its state is read. So a test runs at the pace of whoever asks."""

import struct
from itertools import count

import can
import canopen

from tumble import data
from tumble.client.names import COMMAND, STATE_NAMES
from tumble.client.tables import REASONS, VERDICTS

CHANNELS = count(1)
STATE = {name: number for number, name in enumerate(STATE_NAMES)}
REASON = {row[0]: number for number, row in enumerate(REASONS)}
VERDICT = {row[0]: number for number, row in enumerate(VERDICTS)}
FREE, ON = ("IDLE", "DONE", "ABORT"), ("WAIT_MOUNTING", "MOVE", "AVERAGE", "FAULT", "PREFLIGHT")
NO_DATA, BAD_STATE, BAD_VALUE = 0x08000024, 0x08000022, 0x06090030
HOMING = 2
KEY, PROPOSAL = 0x76726573, 0xBEEF0001
K = [[-2.0, 0.01, 0.02], [0.03, -2.01, 0.04], [0.05, 0.06, -2.02]]
U0 = [0.1, 0.2, 0.3]


class PlayedCanNode:
    """`mountings`: how many a run has; `fails`: reason with which the run of that number stops in MOVE; `memory`:
    whether it keeps coefficients; `stays`: a state that never ends. `commands`: (name, argument) of all obeyed."""

    def __init__(self, mountings=2, fails=None, memory=True, stays=None):
        self.channel = f"played{next(CHANNELS)}"
        self.network = canopen.Network(can.Bus(interface="virtual", channel=self.channel))
        self.network.NOTIFIER_CYCLE = 0.01
        self.network.connect()
        self.node = self.network.create_node(1, str(data.file("eds/tumble_navcomp.eds")))
        self.mountings, self.fails, self.memory, self.stays = mountings, fails or {}, memory, stays
        self.states, self.run, self.reason, self.mounting = ["IDLE"], 0, "NONE", 0
        self.bolted_once = False
        self.verdicts, self.counter, self.commands, self.level, self.silent = ["NONE"], 0, [], 0, False
        self.refusal, self.rung = (0, 0, 0, 0), 0  # 2004h:6 to 2004h:10
        self.node.add_read_callback(self.read)
        self.node.add_write_callback(self.write)
        self.computed = {
            (0x2000, 0): lambda: STATE[self.step(self.states)],
            (0x2001, 0): lambda: REASON[self.reason],
            (0x2003, 4): lambda: self.mounting,
            (0x2003, 12): lambda: HOMING,
            (0x2003, 13): lambda: self.mounting > 1 and self.bolted_once,
            (0x2003, 14): lambda: 45.0 * (self.mounting - 1),
            (0x2004, 10): lambda: self.rung,
            (0x2006, 2): lambda: self.level,
            (0x2007, 0): lambda: self.run,
            (0x2120, 2): lambda: self.counter,
            (0x2120, 6): lambda: 0x40,
            (0x2120, 7): lambda: VERDICT[self.step(self.verdicts)],
            (0x2102, 14): lambda: PROPOSAL,
            (0x2022, 1): lambda: 1e-4, (0x2022, 2): lambda: 2e-4, (0x2022, 3): lambda: 1e-3, (0x2022, 6): lambda: 1,
        }
        for place in range(4):
            self.computed[0x2004, place + 6] = lambda place=place: self.refusal[place]
        for place in range(9):
            self.computed[0x2020, place + 1] = lambda place=place: self.found(K[place // 3][place % 3])
            self.computed[0x2023, place + 1] = lambda: self.found(1e-5)
        for place in range(3):
            self.computed[0x2021, place + 1] = lambda place=place: self.found(U0[place])
            self.computed[0x2024, place + 1] = lambda: self.found(2e-5)

    @staticmethod
    def step(values):
        """The one now; the next time the one behind it, if there is one."""
        return values.pop(0) if len(values) > 1 else values[0]

    def found(self, value):
        if "DONE" not in self.states:
            raise canopen.SdoAbortedError(NO_DATA)
        return value

    def read(self, index, subindex, od):
        if index >= 0x2100 and not self.memory:
            raise canopen.SdoAbortedError(0x06020000)
        value = self.computed.get((index, subindex))
        if value is not None:
            return od.encode_raw(value())
        is_stored = subindex in self.node.data_store.get(index, {}) or od.default is not None
        return None if is_stored else od.encode_raw("" if od.data_type == 9 else 0)

    def write(self, index, subindex, od, data):
        if (index, subindex) == (0x2002, 2):
            self.obey(data[0])
        elif (index, subindex) == (0x2006, 1):
            [key] = struct.unpack("<I", data)
            self.refuse_unless(key in (0, KEY), BAD_VALUE)
            self.level = int(key == KEY)
        elif index in (0x2123, 0x2124, 0x2125, 0x2126) or (index, subindex) == (0x2050, 5):
            self.refuse_unless(self.level, BAD_STATE)

    @staticmethod
    def refuse_unless(allowed, code):
        if not allowed:
            raise canopen.SdoAbortedError(code)

    def obey(self, number):
        name = next(name for name, one in COMMAND.items() if one == number)
        argument = self.node.sdo["Command"]["Argument"].raw
        getattr(self, name.lower())(argument)
        self.commands.append((name, argument))

    def start(self, _argument):
        self.refuse_unless(self.states[-1] in FREE, BAD_STATE)
        self.run += 1
        self.mounting, self.reason, self.verdicts = 1, "NONE", ["NONE"]
        self.states = ["PREFLIGHT", "WARM_UP", self.stays or "WAIT_MOUNTING"]

    def confirm_mounting(self, argument):
        self.refuse_unless(self.states[-1] == "WAIT_MOUNTING", BAD_STATE)
        self.refuse_unless(argument == self.mounting, BAD_VALUE)
        if self.run in self.fails and self.mounting == 1:
            self.states, self.reason = ["NEXT", "MOVE", "FAULT"], self.fails[self.run]
            return
        self.go_on()

    def go_on(self):
        self.mounting += 1
        last = self.mounting > self.mountings
        self.states = ["MOVE", "AVERAGE", "DONE" if last else "WAIT_MOUNTING"]
        self.verdicts = ["WORKING", "WORKING", "HELD"] if last else self.verdicts

    def resume(self, _argument):
        self.refuse_unless(self.states[-1] == "FAULT", BAD_STATE)
        self.reason = "NONE"
        self.go_on()

    def abort(self, _argument):
        self.refuse_unless(self.states[-1] not in FREE, BAD_STATE)
        self.states, self.reason = ["ABORT"], "COMMAND"

    def home_axis(self, _argument):
        self.refuse_unless(False, BAD_STATE)  # the table is at it

    def clear_fault(self, _argument):
        self.refuse_unless(False, BAD_STATE)

    def accept(self, _argument):
        self.refuse_unless(self.verdicts[-1] == "HELD", BAD_STATE)
        self.refuse_unless(self.node.sdo["Command"]["Proposal"].raw == PROPOSAL, BAD_VALUE)
        self.verdicts, self.counter = ["WORKING", "ACCEPTED"], self.counter + 1

    def discard(self, _argument):
        self.refuse_unless(self.verdicts[-1] == "HELD", BAD_STATE)
        self.verdicts = ["WORKING", "DISCARDED"]

    def answer_as_second_server(self):
        """By 380h + node what comes by 400h + node; the list of identifiers on which something came."""
        import canopen.sdo

        heard = []
        server = canopen.sdo.SdoServer(0x401, 0x381, self.node)
        server.network = self.network
        self.network.subscribe(0x401, lambda identifier, *rest: (heard.append(identifier), server.on_request(
            identifier, *rest)))
        return heard

    def close(self):
        self.network.disconnect()
