"""The instructions of A64 (AArch64), as far as the stack and the way through the code are concerned.

Code that jumps through a table is not followed, but refused as an indirect call: it is compiled with -fno-jump-tables.
"""
import re

from .program import Step, target_of

# What the linker leaves in an image, by the names that readelf prints (cut off after 22 characters for some).
BRANCHES = {"R_AARCH64_CALL26", "R_AARCH64_JUMP26", "R_AARCH64_CONDBR19", "R_AARCH64_TSTBR14"}
HARMLESS = BRANCHES | {"R_AARCH64_NONE", "R_AARCH64_PREL32"}
WORD, WORD_BYTES = "R_AARCH64_ABS64", 8
MADE_IN_CODE = {"R_AARCH64_ADR_PREL_LO21", "R_AARCH64_ADR_PREL_PG_HI21", "R_AARCH64_ADD_ABS_LO12_NC"}
MADE_IN_CODE |= {f"R_AARCH64_LDST{bits}_ABS_LO12_NC" for bits in (8, 16, 32, 64, 128)}

EXCEPTIONS, EXCEPTION_BYTES = 16, 0x80  # of the table that VBAR_ELx points at

NUMBER = r"#(-?(?:0x[0-9a-f]+|\d+))"


def function_at(value):
    """The address of the function that a pointer of this value may mean."""
    return value


def exception_entries(table):
    """The instructions that a table of exceptions leads to."""
    return [table + i * EXCEPTION_BYTES for i in range(EXCEPTIONS)]


def step(program, address):
    """What the instruction at an address does."""
    instruction = program.code[address]
    name, operands, following = instruction.mnemonic, instruction.operands, instruction.following
    if name == "bl":
        return Step([(following, 0)], callees=[target_of(operands)])
    if name == "b":
        return Step([(target_of(operands), 0)])
    if name.startswith("b.") or name in ("cbz", "cbnz", "tbz", "tbnz"):
        return Step([(target_of(operands), 0), (following, 0)])
    if name in ("blr", "br"):
        return Step([(following, 0)] if name == "blr" else [], indirect=True)
    if name in ("ret", "eret", "udf", "brk"):
        return Step([])
    grown = _growth(name, operands)
    return Step([(following, grown)], grown)


def _growth(name, operands):
    """Bytes by which one instruction grows the stack. None: it sets sp in another way."""
    if moved := re.search(rf"\[sp, {NUMBER}\]!|\[sp\], {NUMBER}", operands):
        return -int(moved[1] or moved[2], 0)
    if name in ("add", "sub") and (moved := re.fullmatch(rf"sp, sp, {NUMBER}(?:, lsl #(\d+))?", operands)):
        return (int(moved[1], 0) << int(moved[2] or 0)) * (1 if name == "sub" else -1)
    other_stack = name == "msr" and "spsel" in operands
    return None if other_stack or operands.startswith("sp,") or re.search(r"\[sp.*\]!|\[sp\],", operands) else 0
