"""A disassembly, and what an instruction does to the stack: what thumb.py, a64.py and stack.py share."""
import re
from dataclasses import dataclass, field


class Unbounded(Exception):
    """The code does something that makes its stack impossible to bound; the message says what and where."""


@dataclass
class Instruction:
    mnemonic: str
    operands: str
    following: int


@dataclass
class Program:
    """A disassembly: instructions and data by address, and the names of functions."""
    code: dict = field(default_factory=dict)
    data: dict = field(default_factory=dict)
    labels: dict = field(default_factory=dict)

    def name_at(self, address):
        """The function that holds an address."""
        return self.labels[max(start for start in self.labels if start <= address)]


@dataclass
class Step:
    """What one instruction does."""
    ahead: list  # (address of an instruction that may come next, bytes by which the stack has grown by then)
    grown: int = 0  # bytes by which it grows the stack; None: nobody can tell
    callees: list = field(default_factory=list)
    indirect: bool = False  # it calls, or goes on to, what a register names


def parse(disassembly):
    """A Program from the text of `objdump -d --no-show-raw-insn`."""
    program, previous = Program(), None
    for line in disassembly.splitlines():
        if label := re.match(r"([0-9a-f]+) <(.+)>:$", line):
            program.labels[int(label[1], 16)] = label[2]
        elif item := re.match(r"\s*([0-9a-f]+):\t(\S+)(?:\t(.*))?$", line):
            address, mnemonic, operands = int(item[1], 16), item[2], re.split(r"\s*(?:[@;]|//)", item[3] or "")[0]
            if previous is not None:
                previous.following = address
            if mnemonic.startswith("."):
                program.data.update(_bytes_of(address, mnemonic, int(operands, 16)))
                previous = None
            else:
                previous = program.code[address] = Instruction(mnemonic, operands, -1)
    return program


def _bytes_of(address, directive, value):
    size = {".byte": 1, ".short": 2, ".word": 4, ".xword": 8}[directive]
    return {address + i: byte for i, byte in enumerate(value.to_bytes(size, "little"))}


def target_of(operands):
    """The address that a direct branch names."""
    return int(re.search(r"([0-9a-f]+) <", operands)[1], 16)
