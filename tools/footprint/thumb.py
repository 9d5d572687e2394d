"""The instructions of Thumb-2 (Cortex-M), as far as the stack and the way through the code are concerned."""
import re

from .program import Step, target_of

# What the linker leaves in an image: direct branches, words, and references of the unwinding tables.
BRANCHES = {"R_ARM_THM_CALL", "R_ARM_THM_JUMP24", "R_ARM_THM_JUMP19", "R_ARM_THM_JUMP11", "R_ARM_THM_JUMP8",
            "R_ARM_CALL", "R_ARM_JUMP24"}
HARMLESS = BRANCHES | {"R_ARM_NONE", "R_ARM_PREL31"}
WORD, WORD_BYTES = "R_ARM_ABS32", 4
MADE_IN_CODE = set()  # addresses are held as words alone

CONDITIONS = "eq ne cs hs cc lo mi pl vs vc hi ls ge lt gt le".split()
BASES = "b bl bx blx push pop ldmia ldm stmdb ldr ldrd str strd add addw sub subw mov".split()
MNEMONICS = {base + condition: (base, bool(condition)) for base in BASES for condition in ["", *CONDITIONS]}


def function_at(value):
    """The address of the function that a pointer of this value may mean; None: no function."""
    return value & ~1 if value & 1 else None


def exception_entries(table):
    """The instructions that a table of exceptions leads to: here it holds addresses, which the list of calls names."""
    raise ValueError(f"the exceptions of this processor do not begin in a table of code ({table:#x})")


def step(program, address):
    """What the instruction at an address does."""
    instruction = program.code[address]
    operands, following = instruction.operands, instruction.following
    name = instruction.mnemonic.split(".")[0]
    base, conditional = MNEMONICS.get(name, (name, False))
    skip = [(following, 0)] if conditional else []
    if base in ("b", "bl", "cbz", "cbnz"):
        return _branch(base, operands, following, skip)
    if base in ("tbb", "tbh"):
        return Step([(target, 0) for target in _table(program, address, base)])
    if base == "blx" or (base == "bx" and operands != "lr") or re.match(r"pc, \[(?!sp)", operands):
        return Step(skip + ([(following, 0)] if base == "blx" else []), indirect=True)
    if base == "udf":
        return Step([])
    grown, returns = _growth(base, operands)
    return Step(skip + ([] if returns else [(following, grown)]), grown)


def _branch(base, operands, following, skip):
    target = target_of(operands)
    if base == "bl":
        return Step([(following, 0)], callees=[target])
    return Step([(target, 0)] + ([(following, 0)] if base.startswith("cb") else skip))


def _table(program, address, base):
    """Targets of a table branch; the table follows it and ends where the code goes on."""
    width, start = (1 if base == "tbb" else 2), address + 4
    targets, entry = set(), start
    while all(entry + i in program.data for i in range(width)):
        offset = sum(program.data[entry + i] << (8 * i) for i in range(width))
        targets.add(start + 2 * offset)
        entry += width
    return {target for target in targets if target >= entry}  # less what pads the table


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
    if (operands.startswith(("sp,", "sp!")) and base not in ("str", "strd")) or ("[sp" in operands and "!" in operands):
        return None, False
    return 0, (base == "bx" and operands == "lr") or (base == "mov" and operands == "pc, lr")


def _registers(text):
    """How many registers a list such as {r4-r7, lr} names, and whether pc is one of them."""
    names = re.search(r"\{(.*)\}", text)[1].replace(" ", "").split(",")
    ranges = [re.fullmatch(r"r(\d+)-r(\d+)", name) for name in names]
    return sum(int(r[2]) - int(r[1]) + 1 if r else 1 for r in ranges), "pc" in names
