"""The fault campaign: with a fix taken out of a copy of the firmware, it finds the hole."""
import json
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import ROOT, planted
from stages import PYTHON

sys.path.append(str(ROOT / "host/python/binding"))

from build_world import declarations

LIVES = 600  # within so many seeds; each hole comes up in one run of a hundred or oftener
ROOMS = ("firmware", "host/simulation", "host/world", "boards")
OPTIONS = ("-std=gnu11", "-O1", "-w", "-fPIC", "-ffp-contract=off", "-fno-math-errno", "-DTUMBLE_BLOCK_CRC_BITS=8")

BOUNDS = "firmware/stand/bounds.c"
WAY = (BOUNDS, "(here < bounds->lowest_mdeg) || (here > bounds->highest_mdeg)", "false")
TIME = (BOUNDS, "(late <= (uint32_t)INT32_MAX) && (late > margin_ms)", "late == UINT32_MAX")
STALL = (BOUNDS, "if (stalls(bounds, motion, here, now, margin_ms)) {",
         "if (stalls(bounds, motion, here, now, margin_ms) && false) {")
PACE = (BOUNDS, "return is_out_of_pace(", "return false && is_out_of_pace(")
SERVICE = "firmware/navcomp/service.c"
STORE = "firmware/sets/store.c"

# Hole: invariant, what one of its runs has among its events, and the mends taken out: (file, mend, what stands there
# without it).
PLANTED = {
    "homing_travel": ("homing", "homing_endless", [
        ("firmware/stand/drive402/axis.c", "(drive->travel > drive->homing_counts)", "false"), TIME, STALL]),
    "stop": ("rest", "", [
        ("firmware/navcomp/step.c", "held = tumble_run_is_on(navcomp) || has_axis(navcomp);",
         "held = tumble_run_is_on(navcomp);"),
        ("firmware/stand/drive402/axis.c",
         "return tumble_drive_is_stopping(drive) ? since_us(drive, drive->rung + 1U) : TUMBLE_NEVER;",
         "return TUMBLE_NEVER;")]),
    "garbled_position": ("cable", "forged positions", [
        ("firmware/stand/drive402/axis.c", "if (!is_plausible(drive, change)) {", "if (false) {"), WAY]),
    "runaway": ("cable", "fault runaway", [WAY]),
    "false_position": ("homing", "position", [TIME, STALL, PACE]),
    "set_point_by_sdo": ("foreign", "forged set-point 602h", [
        WAY, TIME, ("firmware/navcomp/navcomp_events.c", ") || commands_by_sdo(navcomp, frame);", ");")]),
    "near_positions": ("cable", "0.3 ms apart", [
        ("firmware/stand/drive402/axis.c",
         "drive->spare_counts = ((way - size) < most) ? (uint32_t)(way - size) : most;",
         "drive->spare_counts = most;"), WAY]),
    "read_back": ("speed", "6081h", [
        ("firmware/stand/drive402/drive402.c", "(drive->phase == (uint8_t)PHASE_IDLE) ? PHASE_VERIFY",
         "(drive->phase == (uint8_t)PHASE_IDLE) ? action"), PACE]),
    "key": ("level", "2006h:1", [(SERVICE, "if (key != TUMBLE_SERVICE_KEY) {", "if (key == 1U) {")]),
    "level_after_reset": ("level", "nmt", [
        ("firmware/navcomp/navcomp_events.c", "navcomp->service_until_us = 0; /* the node", "/* the node")]),
    "level_asked": ("level", "sdo_navcomp", [
        ("firmware/navcomp/step.c", "server.service = tumble_service_is_open(navcomp);", "server.service = true;")]),
    "run_number": ("run", "", [
        ("firmware/navcomp/navcomp_report.c", "if (!was_on && tumble_run_is_on(navcomp)) {",
         "if (tumble_run_is_on(navcomp)) {")]),
    "samples": ("mean", "", [
        ("firmware/procedure/procedure_states.c", "(samples >= procedure->config->samples)",
         "(samples > procedure->config->samples)")]),
    "proposal": ("proposal", "power off", [
        (STORE, "aim(store, active);\n    if (is_stale(store)) {",
         "aim(store, active);\n    if (is_there(&store->places[PROPOSAL])) {")]),
    "mark": ("decayed", "bits flipped", [
        (STORE, " && (tumble_get_u32(&mark[MARK_CRC]) == tumble_set_crc(bytes))", "")]),
    "record": ("decayed", "bits flipped", [
        ("firmware/sets/record.c",
         "return tumble_record_is_sealed(bytes, record->crc_at, crc_before) ? TUMBLE_OK : TUMBLE_E_CRC;",
         "return TUMBLE_OK;")]),
}

HUNT = """
import json, sys
from tumble.world.fault_campaign import FaultCampaign
campaign, (kind, opens) = FaultCampaign(), sys.argv[2:]
for seed in range(1, int(sys.argv[1]) + 1):
    found = campaign.run_seed(seed)["violated"] and campaign.shrunk(seed)
    if found and found["kind"] == kind and len(found["events"]) <= 6 and any(opens in one for one in found["events"]):
        campaign.run_seed(seed)
        sys.exit(print(json.dumps([found, campaign.shrunk(seed)])))
sys.exit("not found")
"""


def sources_of(tree):
    """What the runs of a campaign are made of."""
    rooms = ("firmware/**", "host/simulation", "host/world")
    return sorted(source for room in rooms for source in tree.glob(f"{room}/*.c") if source.name != "replay.c")


def compile_file(tree, objects, source):
    target = objects / (source.relative_to(tree).as_posix().replace("/", "_") + ".o")
    includes = [f"-I{tree / room}" for room in ("firmware", "firmware/include", "host", "boards")]
    subprocess.run(["cc", *OPTIONS, *includes, "-c", source, "-o", target], check=True)


def link(objects, folder):
    """The world as a module of Python's, in whose place the package takes it. Returns its folder."""
    library = folder / "world.so"
    subprocess.run(["cc", "-shared", *sorted(objects.glob("*.o")), "-lm", "-o", library], check=True)
    headers = [ROOT / "host/world" / name for name in ("border.h", "fault_campaign.h")]
    header = "".join(declarations(file.read_text()) for file in headers)
    module = f"import cffi\nffi = cffi.FFI()\nffi.cdef({header!r})\nlib = ffi.dlopen({str(library)!r})\n"
    (folder / "_tumble_world.py").write_text(module)
    return folder


@pytest.fixture(scope="module")
def copied(tmp_path_factory):
    """A copy of the sources and their objects, built once."""
    if shutil.which("cc") is None:
        pytest.skip("cc is not installed")
    tree = tmp_path_factory.mktemp("hostile")
    for room in ROOMS:
        shutil.copytree(ROOT / room, tree / room, ignore=shutil.ignore_patterns("*.py"))
    objects = tree / "objects"
    objects.mkdir()
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda source: compile_file(tree, objects, source), sources_of(tree)))
    return tree, objects


def python(world, *arguments):
    """A process in which this is the simulated world."""
    path = [world, ROOT / "host/python/src", ROOT / "build/host/python"]
    return subprocess.run([PYTHON, *map(str, arguments)], capture_output=True, text=True, timeout=300,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, path))})


def campaign(world, lives, seed=1):
    """The document, and the lines about violations."""
    done = python(world, "-m", "tumble", "campaign", "lives", "--lives", lives, "--seed", seed, "--workers", 2)
    document = json.loads(done.stdout)
    assert done.returncode == (3 if document["violated"] else 0), done.stderr
    return document, done.stderr.splitlines()


def plant(tree, objects, folder, defects):
    """The same world with the mends taken out."""
    own = folder / "objects"
    shutil.copytree(objects, own)
    with planted(tree, defects) as sources:
        for source in sources:
            compile_file(tree, own, source)
    return link(own, folder)


def test_the_firmware_as_it_is_violates_nothing(copied, tmp_path):
    _, objects = copied
    document, lines = campaign(link(objects, tmp_path), LIVES)
    assert (document["violated"], lines) == (0, [])


@pytest.mark.parametrize("hole", PLANTED)
def test_a_mend_taken_out_is_found(copied, tmp_path, hole):
    """Under its right name, with what opens the hole, and shrunk to a few events; the seed alone shows it again."""
    kind, opens, defects = PLANTED[hole]
    done = python(plant(*copied, tmp_path, defects), "-c", HUNT, LIVES, kind, opens)
    assert done.returncode == 0, done.stderr
    first, again = json.loads(done.stdout)
    assert first == again and 1 <= len(first["events"]) <= first["drawn"], first


def test_a_campaign_tells_of_violations(copied, tmp_path):
    """A line each, the first ten shrunk, whatever piece they are in; each is its seed's alone."""
    world = plant(*copied, tmp_path, PLANTED["run_number"][-1])
    document, lines = campaign(world, 120)
    assert document["violations"]["run"] == document["violated"] == len(lines) > 10 == len(document["first"])
    for one, line in zip(document["first"], lines):
        assert line.startswith(f"seed {one['seed']}: ") and line.endswith(f" of {one['drawn']} events are enough")
    last = document["first"][-1]
    assert campaign(world, 1, last["seed"])[0]["first"] == [last]
