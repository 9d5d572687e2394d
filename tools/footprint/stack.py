"""Worst-case stack of machine code, by walking every path of the disassembly and following the stack pointer.

The walk knows no function boundaries: a tail branch is simply followed, hand-written assembly and library code are read
like any other. What it cannot bound it refuses: recursion, a stack pointer set from a register, an indirect call of
which nobody says where it may lead (calls.py). What instructions mean is told by a module for their
set (thumb.py, a64.py).
"""
from .program import Unbounded

DEEPEST = 1 << 16  # beyond this a loop is pushing without end


class Walk:
    """Worst-case stack per function of one program."""

    def __init__(self, program, instructions, targets=lambda caller: None, start=None):
        """`instructions` is the module of the instruction set. `targets` gives, by the name of the caller, where its
        indirect calls may lead: addresses, or None. At `start` (address) the stack begins: that code may set its
        pointer."""
        self.program = program
        self._instructions = instructions
        self._targets = targets
        self.start = start
        self._known = {}
        self._open = []

    def worst(self, entry):
        """Bytes that the function at `entry` may use with all that it calls, and the chain of names that does."""
        if entry not in self._known:
            if entry in self._open:
                chain = [self.program.name_at(address) for address in [*self._open[self._open.index(entry):], entry]]
                raise Unbounded("recursion: " + " -> ".join(chain))
            self._open.append(entry)
            deepest, chain = 0, []
            for depth, callee in self._points(entry):
                below, names = self.worst(callee) if callee is not None else (0, [])
                if depth + below > deepest:
                    deepest, chain = depth + below, names
            self._open.pop()
            self._known[entry] = deepest, [(self.program.name_at(entry), deepest), *chain]
        return self._known[entry]

    def worst_exception(self, label):
        """The same for what an exception may lead to, by the label of their table."""
        table = next((address for address, name in self.program.labels.items() if name == label), None)
        if table is None:
            raise Unbounded(f"the image has no table of exceptions {label}")
        return max(self.worst(entry) for entry in self._instructions.exception_entries(table))

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
            grown, callees, successors = self._step(address, begins=entry == self.start and depth == 0)
            if depth + grown > DEEPEST:
                raise Unbounded(f"stack grows in a loop in {self.program.name_at(address)}")
            points |= {(depth, callee) for callee in callees} | {(depth, None), (depth + grown, None)}
            ahead += [(target, depth + change) for target, change in successors]
        return points

    def _step(self, address, begins):
        """Growth, callees and (successor, change of depth) pairs of the instruction at an address."""
        if address not in self.program.code:
            return 0, [], []  # data: reached only behind a call that does not return
        step = self._instructions.step(self.program, address)
        if step.grown is None and begins:
            return 0, [], [(target, 0) for target, _ in step.ahead]
        if step.grown is None:
            raise Unbounded(f"stack of unknown size in {self.program.name_at(address)} ({self._text(address)})")
        return step.grown, step.callees + (self._indirect(address) if step.indirect else []), step.ahead

    def _indirect(self, address):
        caller = self.program.name_at(address)
        targets = self._targets(caller)
        if targets is None:
            raise Unbounded(f"indirect call in {caller} ({self._text(address)})")
        return sorted(targets)

    def _text(self, address):
        instruction = self.program.code[address]
        return f"{address:#x}: {instruction.mnemonic} {instruction.operands}"
