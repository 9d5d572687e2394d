"""The campaign of hostile lives: with the mend of a hole taken out of a copy of the firmware, it finds the hole."""
import json
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import ROOT, planted

LIVES = 400  # within so many seeds; each hole comes up in one life of a hundred or oftener
ROOMS = ("firmware", "host/bench", "host/simulation", "boards")
OPTIONS = ("-std=gnu11", "-O1", "-w", "-ffp-contract=off", "-fno-math-errno", "-DTUMBLE_BLOCK_CRC_BITS=8")

# Invariant: (file, the mend, what stands there without it), one or more.
PLANTED = {
    "homing": [
        ("firmware/stand/drive402/position.c", "(drive->travel > drive->homing_counts)", "false"),
    ],
    "rest": [
        ("firmware/navcomp/step.c", "held = tumble_run_is_on(navcomp) || has_axis(navcomp);",
         "held = tumble_run_is_on(navcomp);"),
        ("firmware/navcomp/step.c", "server.service = tumble_service_is_open(navcomp);", "server.service = true;"),
        ("firmware/stand/drive402/stop.c",
         "return tumble_drive_is_stopping(drive) ? since_us(drive, drive->rung + 1U) : TUMBLE_NEVER;",
         "return TUMBLE_NEVER;"),
    ],
    "cable": [
        ("firmware/stand/drive402/position.c", "if (!is_plausible(drive, change)) {", "if (false) {"),
    ],
}


def sources_of(tree):
    """What tumble-bench is made of."""
    return sorted([*tree.glob("firmware/**/*.c"), *tree.glob("host/bench/*.c"), *tree.glob("host/simulation/*.c")])


def compile_file(tree, objects, source):
    target = objects / (source.relative_to(tree).as_posix().replace("/", "_") + ".o")
    includes = [f"-I{tree / room}" for room in ("firmware", "firmware/include", "host", "boards")]
    subprocess.run(["cc", *OPTIONS, *includes, "-c", source, "-o", target], check=True)


def link(objects, program):
    subprocess.run(["cc", *sorted(objects.glob("*.o")), "-lm", "-o", program], check=True)
    return program


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


def live(program, lives=LIVES):
    """The document of a campaign, and the lines about violations."""
    done = subprocess.run(
        [program, "--campaign", str(lives), "--seed", "1"], capture_output=True, text=True, timeout=300
    )
    document = json.loads(done.stdout)
    assert done.returncode == (3 if document["violated"] else 0), done.stderr
    return document, done.stderr.splitlines()


def plant(tree, objects, folder, defects):
    """The same program with the mends taken out."""
    own = folder / "objects"
    shutil.copytree(objects, own)
    with planted(tree, defects) as sources:
        for source in sources:
            compile_file(tree, own, source)
    return link(own, folder / "tumble-bench")


def test_the_firmware_as_it_is_violates_nothing(copied, tmp_path):
    _, objects = copied
    document, lines = live(link(objects, tmp_path / "tumble-bench"))
    assert (document["violated"], lines) == (0, [])


@pytest.mark.parametrize("kind", PLANTED)
def test_a_mend_taken_out_is_found(copied, tmp_path, kind):
    """Under its right name, and shrunk to a few events; the seed alone shows it again."""
    tree, objects = copied
    program = plant(tree, objects, tmp_path, PLANTED[kind])
    document, lines = live(program)
    assert document["violations"][kind] >= 1, document["violations"]
    assert len(lines) == document["violated"]
    first = next(found for found in document["first"] if found["kind"] == kind)
    assert 1 <= len(first["events"]) <= 6 and len(first["events"]) <= first["drawn"], first
    alone = subprocess.run([program, "--campaign", "1", "--seed", str(first["seed"])], capture_output=True, text=True)
    assert alone.returncode == 3 and json.loads(alone.stdout)["first"] == [first]
