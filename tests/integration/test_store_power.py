"""Power cuts at every operation of the store: all pairs of faults,
and planted bugs that the same campaign must find."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
STORE = (
    "store",
    "store_job",
    "slots",
    "set_record",
    "record",
    "nv_writer",
    "regions",
    "log",
    "history",
    "history_entry",
    "checkpoint",
)
FLAGS = ["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra"]

# A bug of the firmware: its files, what stands there, what is planted, and at last what the campaign must say of it.
BUGS = {
    # The record's own checksum and ranges make up for the wrong order, so they have to go too.
    "marked before it is written, and the mark is believed": (
        "store.c",
        "SLOT_BODY | IN_TARGET,\n                                   SLOT_MARK | IN_TARGET, SLOT_END",
        "SLOT_MARK | IN_TARGET,\n                                   SLOT_BODY | IN_TARGET, SLOT_END",
        "store_job.c",
        "(tumble_get_u32(&mark[MARK_CRC]) == tumble_set_crc(bytes))",
        "(mark[MARK_CRC] != 1U)",
        "set_record.c",
        "return (status == TUMBLE_OK) ? check_fields(bytes) : status;",
        "return (status == TUMBLE_OK) ? status : TUMBLE_OK;",
        "must never be found",
    ),
    "not read back": ("nv_writer.c", "if (!chunk_is_right(writer, size))", "if (false)", "it is not|forbids"),
    "blank is not looked for": ("nv_writer.c", "tumble_nv_is_blank(writer->chunk, size)", "true", "forbids"),
    "the active slot is overwritten": (
        "store.c",
        "return (active == (uint8_t)TUMBLE_REGION_SLOT_A) ?",
        "return (active != (uint8_t)TUMBLE_REGION_SLOT_A) ?",
        "must never be found",
    ),
    "no checksum": ("record.c", "return tumble_get_u32(&bytes[size]) ==", "return 0U <=", "must never be found"),
    "the oldest set is active": (
        "store_job.c",
        "a->stamp.sequence > b->",
        "a->stamp.sequence < b->",
        "must never be found",
    ),
    "cleared before it is accepted": (
        "store.c",
        "accept[] = {PLAN_LOAD | IN_PROPOSAL, SLOT_ERASE | IN_TARGET,",
        "accept[] = {PLAN_LOAD | IN_PROPOSAL, SLOT_ERASE | IN_PROPOSAL, SLOT_ERASE | IN_TARGET,",
        "must never be found",
    ),
    "an accepted proposal is held again": (
        "store_job.c",
        "return proposal->valid && tumble_store_is_slot(active) &&",
        "return false && proposal->valid && tumble_store_is_slot(active) &&",
        "must never be found",
    ),
    "a rollback without a copy": (
        "store.c",
        "PLAN_LOAD | IN_SOURCE, SLOT_ERASE | IN_PROPOSAL, SLOT_BODY | IN_PROPOSAL,\n"
        "                                   SLOT_MARK | IN_PROPOSAL, PLAN_STAMP,",
        "PLAN_LOAD | IN_SOURCE, PLAN_STAMP,",
        "must never be found",
    ),
    "no scan after a job": (
        "store_job.c",
        "    tumble_slots_begin(&store->slots, NULL);\n    tumble_store_begin_scan(store);",
        "    tumble_slots_begin(&store->slots, NULL);",
        "must never be found",
    ),
    "the history erases the newest": (
        "history.c",
        "const uint32_t other = (history->sector == 0U) ? 1U : 0U;",
        "const uint32_t other = history->sector;",
        "must never be found",
    ),
    "a torn entry is written over": (
        "log.c",
        "    log->used[log->at_cell / cells] = ",
        "    log->used[log->at_cell / cells] = !valid ? log->used[log->at_cell / cells] : ",
        "forbids",
    ),
    "a torn position is written over": (
        "checkpoint.c",
        "    checkpoint->next = log->at_cell + 1U;\n",
        "    checkpoint->next = valid ? (uint8_t)(log->at_cell + 1U) : checkpoint->next;\n",
        "forbids",
    ),
}


def build(firmware, program):
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    assert compiler, "no C compiler: set CC"
    sources = [firmware / f"sets/{name}.c" for name in STORE] + [firmware / "core/arith.c", firmware / "core/count.c"]
    subprocess.run(
        [
            compiler,
            *FLAGS,
            f"-I{firmware}",
            f"-I{firmware}/include",
            f"-I{ROOT}/tests/lib",
            ROOT / "tests/integration/store_power_harness.c",
            ROOT / "tests/lib/flash.c",
            ROOT / "tests/lib/store_power.c",
            *sources,
            "-lm",
            "-o",
            program,
        ],
        check=True,
    )
    return program


def part_of(file):
    """The part of the campaign that has to do with it."""
    return {"record.c": "checkpoint", "history.c": "history", "log.c": "history", "checkpoint.c": "checkpoint"}.get(
        file, "store"
    )


def plant(firmware, file, good, bad):
    source = firmware / "sets" / file
    wherever_broken = r"\s+".join(map(re.escape, good.split()))
    text, places = re.subn(wherever_broken, lambda _: bad, source.read_text(encoding="utf-8"))
    assert places == 1, "the planted bug has lost its place"
    source.write_text(text, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("bug", BUGS)
def test_a_planted_bug_is_found(bug, tmp_path):
    *edits, complaint = BUGS[bug]
    for room in ("core", "include", "sets"):
        shutil.copytree(ROOT / "firmware" / room, tmp_path / "firmware" / room)
    for edit in zip(*[iter(edits)] * 3):
        plant(tmp_path / "firmware", *edit)
    program = build(tmp_path / "firmware", tmp_path / "power")
    done = subprocess.run([program, part_of(edits[0])], capture_output=True, text=True, timeout=300)
    assert done.returncode == 1, done.stdout
    assert re.search(complaint, done.stderr), done.stderr


@pytest.mark.full
def test_all_pairs_of_faults_in_every_geometry(tmp_path):
    program = build(ROOT / "firmware", tmp_path / "power")
    done = subprocess.run([program, "long"], capture_output=True, text=True, timeout=3600)
    print(done.stdout)
    assert done.returncode == 0, done.stderr
    cases, bad = map(int, re.search(r"^all: (\d+) cases, (\d+) bad$", done.stdout, re.MULTILINE).groups())
    assert cases > 1_000_000 and bad == 0
