"""Power cuts at every operation of the store: all pairs of faults,
and planted bugs that the same campaign must find."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
STORE = ("memory", "store", "set_record", "thermal_record", "record", "history", "checkpoint")
FIRMWARE = ROOT / "firmware"
CAMPAIGN = ("flash", "store_power")
FLAGS = ["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra"]

# A bug of the firmware: its files, what stands there, what is planted, and at last what the campaign must say of it.
BUGS = {
    # The record's own checksum and ranges make up for the wrong order, so they have to go too.
    "marked before it is written, and the mark is believed": (
        "store.c",
        "CELL_BODY | IN_TARGET,\n                                   CELL_MARK | IN_TARGET, CELL_END",
        "CELL_MARK | IN_TARGET,\n                                   CELL_BODY | IN_TARGET, CELL_END",
        "store.c",
        "(tumble_get_u32(&mark[MARK_CRC]) == tumble_set_crc(bytes))",
        "(mark[MARK_CRC] != 1U)",
        "set_record.c",
        "return (status == TUMBLE_OK) ? tumble_set_read_fields(bytes, set) : status;",
        "return tumble_set_read_fields(bytes, set);",
        "set_record.c",
        "const tumble_status_t status = check_fields(bytes);",
        "(void)check_fields(bytes); const tumble_status_t status = TUMBLE_OK;",
        "must never be found",
    ),
    "not read back": ("memory.c", "if (cells->failed_to_hold) {", "if (false) {", "it is not|forbids"),
    "blank is not looked for": ("memory.c", "!is_blank(cells->chunk, size)", "false", "forbids"),
    "the active slot is overwritten": (
        "store.c",
        "aim(store, other_slot(active_region(store)));",
        "aim(store, (active_region(store) == SLOT_A) ? SLOT_A : SLOT_B);",
        "must never be found",
    ),
    "no checksum": ("record.c", "return tumble_get_u32(&bytes[size]) ==", "return 0U <=", "must never be found"),
    "the oldest set is active": (
        "store.c",
        "a->stamp.sequence > b->",
        "a->stamp.sequence < b->",
        "must never be found",
    ),
    "cleared before it is accepted": (
        "store.c",
        "accept[] = {CELL_LOAD | IN_PROPOSAL, CELL_ERASE | IN_TARGET,",
        "accept[] = {CELL_LOAD | IN_PROPOSAL, CELL_ERASE | IN_PROPOSAL, CELL_ERASE | IN_TARGET,",
        "must never be found",
    ),
    "an accepted proposal is held again": (
        "store.c",
        "return is_there(proposal) && is_slot(active) &&",
        "return false && is_there(proposal) && is_slot(active) &&",
        "must never be found",
    ),
    "a rollback without a copy": (
        "store.c",
        "CELL_LOAD | IN_SOURCE, CELL_ERASE | IN_PROPOSAL, CELL_BODY | IN_PROPOSAL,\n"
        "                                   CELL_MARK | IN_PROPOSAL, CELL_LOAD | IN_PROPOSAL,",
        "CELL_LOAD | IN_SOURCE,",
        "must never be found",
    ),
    "no scan after a job": (
        "store.c",
        "} else if (event != TUMBLE_CELLS_NOTHING) {",
        "} else if (event == TUMBLE_CELLS_FAILED) {",
        "must never be found",
    ),
    "the history erases the newest": (
        "history.c",
        "const uint32_t other = (history->sector == 0U) ? 1U : 0U;",
        "const uint32_t other = history->sector;",
        "must never be found",
    ),
    "a torn entry is written over": (
        "history.c",
        "history->used[sector] = (uint8_t)(within + 1U);",
        "history->used[sector] = valid ? (uint8_t)(within + 1U) : history->used[sector];",
        "forbids",
    ),
    "a torn position is written over": (
        "checkpoint.c",
        "    checkpoint->next = cells->at + 1U;\n",
        "    checkpoint->next = valid ? (uint8_t)(cells->at + 1U) : checkpoint->next;\n",
        "forbids",
    ),
}


def cc(*arguments):
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    assert compiler, "no C compiler: set CC"
    subprocess.run([compiler, *FLAGS, *arguments], check=True)


def compiled(source, folder):
    """The object of a source file."""
    there = folder / f"{source.stem}.o"
    cc("-c", f"-I{FIRMWARE}", f"-I{FIRMWARE}/include", f"-I{ROOT}/tests/lib", source, "-o", there)
    return there


@pytest.fixture(scope="module")
def objects(tmp_path_factory):
    """Of the whole campaign, by the name of the source file."""
    sources = [*(FIRMWARE / f"sets/{name}.c" for name in STORE), FIRMWARE / "core/arith.c", FIRMWARE / "core/count.c"]
    sources += [ROOT / "tests/integration/store_power_harness.c", *(ROOT / f"tests/lib/{n}.c" for n in CAMPAIGN)]
    folder = tmp_path_factory.mktemp("objects")
    return {source.name: compiled(source, folder) for source in sources}


def linked(objects, program):
    cc(*objects.values(), "-lm", "-o", program)
    return program


def part_of(file):
    """The part of the campaign that has to do with it."""
    return {"record.c": "checkpoint", "history.c": "history", "checkpoint.c": "checkpoint"}.get(
        file, "store"
    )


def planted(folder, file, good, bad):
    """A copy of the firmware's file with the bug in it, besides those that are there already."""
    wherever_broken = r"\s+".join(map(re.escape, good.split()))
    source = folder / file if (folder / file).exists() else FIRMWARE / "sets" / file
    text, places = re.subn(wherever_broken, lambda _: bad, source.read_text(encoding="utf-8"))
    assert places == 1, "the planted bug has lost its place"
    (folder / file).write_text(text, encoding="utf-8")
    return folder / file


@pytest.mark.slow
@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_is_found(bug, objects, tmp_path):
    *edits, complaint = BUGS[bug]
    with_bug = {edit[0]: compiled(planted(tmp_path, *edit), tmp_path) for edit in zip(*[iter(edits)] * 3)}
    program = linked({**objects, **with_bug}, tmp_path / "power")
    done = subprocess.run([program, part_of(edits[0])], capture_output=True, text=True, timeout=300)
    assert done.returncode == 1, done.stdout
    assert re.search(complaint, done.stderr), done.stderr


@pytest.mark.full
def test_all_pairs_of_faults_in_every_geometry(objects, tmp_path):
    program = linked(objects, tmp_path / "power")
    done = subprocess.run([program, "long"], capture_output=True, text=True, timeout=3600)
    print(done.stdout)
    assert done.returncode == 0, done.stderr
    cases, bad = map(int, re.search(r"^all: (\d+) cases, (\d+) bad$", done.stdout, re.MULTILINE).groups())
    assert cases > 1_000_000 and bad == 0
