"""A recalibration from outside: python-canopen, the EDS file and the names that docs/canopen.md gives to numbers.

What it does is the same on the in-process bus and on a real interface; how time passes, and who mounts the block, the
bench says.
"""

import re
from pathlib import Path

import canopen

ROOT = Path(__file__).resolve().parents[2]
EDS = ROOT / "docs" / "eds" / "tumble_navcomp.eds"
NODE = 1


def numbers_of(name):
    """{name: number} of a list in docs/canopen.md, without the list's own name in front."""
    page = (ROOT / "docs" / "canopen.md").read_text(encoding="utf-8")
    body = page.split(f"`{name}_...`:")[1].split("\n`")[0]
    return {key: int(number) for number, key in re.findall(rf"^\| (\d+) \| `{name}_(\w+)` \|", body, re.MULTILINE)}


COMMANDS = numbers_of("TUMBLE_COMMAND")
STATES = numbers_of("TUMBLE_STATE")
OBJECTIONS = numbers_of("TUMBLE_OBJECTION")


def signature(text):
    """Four letters as 1010h and 1011h want them."""
    return int.from_bytes(text.encode("ascii"), "little")


class Computer:
    """The navigation computer as its EDS file shows it. `pass_ms(ms)` lets time pass; `mount(number)` mounts the block,
    and is true if whoever did it has confirmed it as well."""

    def __init__(self, network, pass_ms, mount, timeout=20.0):
        self.network = network
        self.node = network.add_node(NODE, str(EDS))
        self.node.sdo.RESPONSE_TIMEOUT = timeout
        self.pass_ms = pass_ms
        self.mount = mount

    def __getitem__(self, name):
        return self.node.sdo[name]

    def state(self):
        """Name of the state."""
        wanted = self["State"].raw
        return next(name for name, number in STATES.items() if number == wanted)

    def objections(self):
        """Names of those to the last result."""
        bits = self["Keeper"]["Objections"].raw
        return {name for name, number in OBJECTIONS.items() if bits >> number & 1}

    def command(self, name, argument=0):
        """The argument first, then the command."""
        self["Command"]["Argument"].raw = argument
        self["Command"]["Command"].raw = COMMANDS[name]

    def wait(self, condition, limit_ms=900_000, step_ms=100):
        """Until it holds."""
        for _ in range(limit_ms // step_ms):
            if condition():
                return
            self.pass_ms(step_ms)
        raise AssertionError(f"not in time: {self.state()}, reason {self['Reason'].raw}")

    def set_rules(self, uncertainty, drift, coverage=3.0, flags=3):
        """Commit rules, the same for all coefficients; saved, so that they are the board's."""
        self.unlock()
        self["Commit rules"]["Coverage"].raw = coverage
        self["Commit rules"]["Flags"].raw = flags
        for name, value in (("Uncertainty limits", uncertainty), ("Drift limits per month", drift)):
            for entry in entries_of(self[name]):
                entry.raw = value
        self.save()

    def unlock(self):
        """Open the service level, or prolong it."""
        self["Service level"]["Key"].raw = signature("serv")

    def accept(self):
        """The proposal that is there, by its name."""
        self["Command"]["Proposal"].raw = self["Proposal"]["Record CRC"].raw
        self.command("ACCEPT")

    def finish_run(self):
        """Mount whatever is asked for, until the run is done and judged."""
        while True:
            self.wait(lambda: self.state() in ("DONE", "FAULT", "ABORT", "WAIT_MOUNTING"))
            if self.state() != "WAIT_MOUNTING":
                break
            number = self["Progress"]["Mounting number"].raw
            if not self.mount(number):
                self.command("CONFIRM_MOUNTING", number)
            self.wait(lambda: self.state() != "WAIT_MOUNTING")
        assert self.state() == "DONE", self["Reason"].raw
        self.settle()

    def calibrate(self):
        """A run from its start."""
        self.command("START")
        self.finish_run()

    def settle(self):
        """Until what was to be stored is stored."""
        self.pass_ms(100)
        self.wait(lambda: self["Keeper"]["Verdict"].raw != 1 and not self["Keeper"]["Busy"].raw)

    def counter(self):
        """The calibration counter."""
        return self["Keeper"]["Calibration counter"].raw

    def coefficients(self, prefix=""):
        """K and U0, of the result or of a set ("Active set: ", ...)."""
        return [entry.raw for name in ("K", "U0") for entry in entries_of(self[prefix + name])]

    def save(self):
        """1010h, as long as the memory takes."""
        self.unlock()
        self["Store parameters"]["Save all parameters"].raw = signature("save")


def entries_of(item):
    """All values of a record or an array, without the number of them."""
    return [item[subindex] for subindex in item if subindex != 0]


def refusal_of(action, *arguments):
    """The abort code of what must be refused."""
    try:
        action(*arguments)
    except canopen.SdoAbortedError as refusal:
        return refusal.code
    raise AssertionError("was not refused")
