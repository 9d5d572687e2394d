"""The stack that the board zcu102 really takes, in its emulator, against what tools/budget says of the same image.

Before the board starts, its whole stack is painted by the emulator's loader; when it has ended, its memory is a file.
The image knows nothing of this.
"""

import csv
import re
import subprocess

import pytest
from test_zcu102 import prepare

from tumble.world import emulator

pytestmark = pytest.mark.toolchain

PAINT = b"\xa5"
RAM_BYTES = 128 << 20  # as emulator.command has it
LEAST_SHARE = 0.5  # of the worst chain that some run must really take


@pytest.fixture(name="budgeted")
def fixture_budgeted():
    """The worst chain (B) of the image that replays, by its build."""
    if (lacking := emulator.missing("replay")) is not None:
        pytest.skip(f"the emulated board is not there: {lacking}")
    measured = emulator.image("replay").with_name("budget_replay.csv")
    if not measured.exists():
        pytest.skip("no budget_replay.csv beside the image: cmake --build --preset zcu102 writes it")
    with measured.open(newline="", encoding="utf-8") as file:
        return next(int(row["bytes"]) for row in csv.DictReader(file) if row["quantity"] == "stack")


def stack_place():
    """Address and size of the image's stack."""
    image = emulator.image("replay")
    listed = subprocess.run(["readelf", "-SW", image], capture_output=True, text=True, check=True).stdout
    address, size = re.search(r" \.stack\s+NOBITS\s+(\w+)\s+\w+\s+(\w+)", listed).groups()
    return int(address, 16), int(size, 16)


def painted_over(tumble, folder, monkeypatch, *options, spoilt_at=None):
    """Bench and replay a run; the bytes of the board's stack that are no paint afterwards, up to its top. For a canary,
    one byte of the paint is another one, `spoilt_at` below the top."""
    ended = tumble("bench", "--out", "run", *options, cwd=folder)
    assert ended.returncode == 0, ended.stderr
    gains = prepare(folder)
    address, size = stack_place()
    paint = bytearray(PAINT * size)
    if spoilt_at is not None:
        paint[-spoilt_at] ^= 1
    (folder / "paint").write_bytes(paint)
    painted = ["-device", f"loader,file={folder}/paint,addr={address:#x},force-raw=on"]
    kept = f"memory-backend-file,id=kept,size={RAM_BYTES},mem-path={folder}/memory,share=on"
    command = emulator.command
    monkeypatch.setattr(emulator, "command", lambda name, *more: [
        *command(name, *more), *painted, "-object", kept, "-machine", "memory-backend=kept"])
    told = emulator.replay(folder / "recording", folder / "record", gains)
    assert "K" in told, told
    with open(folder / "memory", "rb") as memory:
        memory.seek(address)
        return len(memory.read(size).lstrip(PAINT))


@pytest.mark.parametrize("options", [["--estimator", "optimal"], ["--estimator", "least_squares", "--limit", "1e-3"]],
                         ids=["optimal", "least squares"])
def test_no_more_is_painted_over_than_the_worst_chain(options, budgeted, tumble, tmp_path, monkeypatch):
    taken = painted_over(tumble, tmp_path, monkeypatch, *options)
    print(f"{taken} B of stack were painted over; the worst chain, with an exception on top, takes {budgeted} B")
    assert LEAST_SHARE * budgeted <= taken <= budgeted


def test_one_byte_below_the_worst_chain_is_seen(budgeted, tumble, tmp_path, monkeypatch):
    """Canary: what is counted is the board's memory."""
    assert painted_over(tumble, tmp_path, monkeypatch, spoilt_at=budgeted + 1) == budgeted + 1
