"""Worst-case stack of Thumb code, by walking every path of the disassembly and following the stack pointer.

The walk knows no function boundaries: a tail branch is simply followed, hand-written library code is read like any
other. What it cannot bound it refuses: recursion, a stack pointer set from a register, an indirect call of which nobody
says where it may lead (calls.py).
"""
import re
from dataclasses import dataclass, field

CONDITIONS = "eq ne cs hs cc lo mi pl vs vc hi ls ge lt gt le".split()
BASES = "b bl bx blx push pop ldmia ldm stmdb ldr ldrd str strd add addw sub subw mov".split()
MNEMONICS = {base + condition: (base, bool(condition)) for base in BASES for condition in [""] + CONDITIONS}
DEEPEST = 1 << 16  # beyond this a loop is pushing without end


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


def parse(disassembly):
    """A Program from the text of `objdump -d --no-show-raw-insn`."""
    program, previous = Program(), None
    for line in disassembly.splitlines():
        if label := re.match(r"([0-9a-f]+) <(.+)>:$", line):
            program.labels[int(label[1], 16)] = label[2]
        elif item := re.match(r"\s*([0-9a-f]+):\t(\S+)(?:\t(.*))?$", line):
            address, mnemonic, operands = int(item[1], 16), item[2], re.split(r"\s*[@;]", item[3] or "")[0]
            if previous is not None:
                previous.following = address
            if mnemonic.startswith("."):
                program.data.update(_bytes_of(address, mnemonic, int(operands, 16)))
                previous = None
            else:
                previous = program.code[address] = Instruction(mnemonic.split(".")[0], operands, -1)
    return program


def _bytes_of(address, directive, value):
    size = {".byte": 1, ".short": 2, ".word": 4}[directive]
    return {address + i: byte for i, byte in enumerate(value.to_bytes(size, "little"))}


def _registers(text):
    """How many registers a list such as {r4-r7, lr} names, and whether pc is one of them."""
    names = re.search(r"\{(.*)\}", text)[1].replace(" ", "").split(",")
    ranges = [re.fullmatch(r"r(\d+)-r(\d+)", name) for name in names]
    return sum(int(r[2]) - int(r[1]) + 1 if r else 1 for r in ranges), "pc" in names


def _growth(base, operands):
    """Bytes by which one instruction grows the stack, and whether it returns. None: it sets sp in another way."""
    if base in ("push", "pop"):
        count, returns = _registers(operands)
        return (4 * count if base == "push" else -4 * count), returns
    if base in ("stmdb", "ldmia", "ldm") and operands.startswith("sp!"):
        count, returns = _registers(operands)
        return (4 * count if base == "stmdb" else -4 * count), returns
    if moved := re.search(r"\[sp, #(-?\d+)\]!|\[sp\], #(-?\d+)", operands):
        return -int(moved[1] or moved[2]), base == "ldr" and operands.startswith("pc,")
    if base in ("add", "addw", "sub", "subw") and (moved := re.fullmatch(r"sp, (?:sp, )?#(\d+)", operands)):
        return int(moved[1]) * (1 if base.startswith("sub") else -1), False
    if operands.startswith(("sp,", "sp!")) and base not in ("str", "strd") or "[sp" in operands and "!" in operands:
        return None, False
    return 0, (base == "bx" and operands == "lr") or (base == "mov" and operands == "pc, lr")


class Walk:
    """Worst-case stack per function of one program."""

    def __init__(self, program, targets=lambda caller: None):
        """`targets` gives, by the name of the caller, where its indirect calls may lead: addresses, or None."""
        self.program = program
        self._targets = targets
        self._known = {}
        self._open = []

    def worst(self, entry):
        """Bytes that the function at `entry` may use with all that it calls, and the chain of names that does."""
        if entry not in self._known:
            if entry in self._open:
                chain = [self.program.name_at(address) for address in self._open[self._open.index(entry):] + [entry]]
                raise Unbounded("recursion: " + " -> ".join(chain))
            self._open.append(entry)
            deepest, chain = 0, []
            for depth, callee in self._points(entry):
                below, names = self.worst(callee) if callee is not None else (0, [])
                if depth + below > deepest:
                    deepest, chain = depth + below, names
            self._open.pop()
            self._known[entry] = deepest, [(self.program.name_at(entry), deepest)] + chain
        return self._known[entry]

    def own(self, entry, size):
        """Bytes that the function itself uses, read from its own instructions alone."""
        return max((depth for depth, callee in self._points(entry, range(entry, entry + size))), default=0)

    def _points(self, entry, bounds=None):
        """Every (depth, callee or None) that the code from `entry` can reach."""
        points, seen, ahead = set(), set(), [(entry, 0)]
        while ahead:
            address, depth = ahead.pop()
            if (address, depth) in seen or (bounds is not None and address not in bounds):
                continue
            seen.add((address, depth))
            grown, callees, successors = self._step(address)
            if depth + grown > DEEPEST:
                raise Unbounded(f"stack grows in a loop in {self.program.name_at(address)}")
            points |= {(depth, callee) for callee in callees} | {(depth, None), (depth + grown, None)}
            ahead += [(target, depth + change) for target, change in successors]
        return points

    def _step(self, address):
        """Growth, callees and (successor, change of depth) pairs of the instruction at an address."""
        if address not in self.program.code:
            return 0, [], []  # data: reached only behind a call that does not return
        instruction = self.program.code[address]
        name, operands, following = instruction.mnemonic, instruction.operands, instruction.following
        base, conditional = MNEMONICS.get(name, (name, False))
        skip = [(following, 0)] if conditional else []
        if base in ("b", "bl", "cbz", "cbnz"):
            return self._branch(base, operands, following, skip)
        if base in ("tbb", "tbh"):
            return 0, [], [(target, 0) for target in self._table(address, base)]
        if base == "blx" or (base == "bx" and operands != "lr") or re.match(r"pc, \[(?!sp)", operands):
            return 0, self._indirect(address), skip + ([(following, 0)] if base == "blx" else [])
        if base == "udf":
            return 0, [], []
        grown, returns = _growth(base, operands)
        if grown is None:
            where = f"{self.program.name_at(address)} ({address:#x}: {name} {operands})"
            raise Unbounded(f"stack of unknown size in {where}")
        return grown, [], skip + ([] if returns else [(following, grown)])

    def _indirect(self, address):
        caller, instruction = self.program.name_at(address), self.program.code[address]
        targets = self._targets(caller)
        if targets is None:
            where = f"{address:#x}: {instruction.mnemonic} {instruction.operands}"
            raise Unbounded(f"indirect call in {caller} ({where})")
        return sorted(targets)

    @staticmethod
    def _branch(base, operands, following, skip):
        target = int(re.search(r"([0-9a-f]+) <", operands)[1], 16)
        if base == "bl":
            return 0, [target], [(following, 0)]
        return 0, [], [(target, 0)] + ([(following, 0)] if base.startswith("cb") else skip)

    def _table(self, address, base):
        """Targets of a table branch; the table follows it and ends where the code goes on."""
        width, start = (1 if base == "tbb" else 2), address + 4
        targets, entry = set(), start
        while all(entry + i in self.program.data for i in range(width)):
            offset = sum(self.program.data[entry + i] << (8 * i) for i in range(width))
            targets.add(start + 2 * offset)
            entry += width
        return {target for target in targets if target >= entry}  # less what pads the table
