"""The C that docs/embedding.md shows: it is that of the files, it runs, and it finds the truth."""

import csv
import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

PAGE = (ROOT / "docs/embedding.md").read_text(encoding="utf-8")
PROGRAM = (EXAMPLES / "embed.c").read_text(encoding="utf-8")
OUTPUT = re.search(r"```text\n(K .*?)```", PAGE, re.DOTALL)[1]
STRICT = "-std=c11 -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow -Wstrict-prototypes".split()
STRICT += ["-Werror"]
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
needs_cc = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def run(*command, cwd=None, **more):
    done = subprocess.run([*map(str, command)], cwd=cwd, env=ENVIRONMENT, capture_output=True, text=True, **more)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_page_shows_the_file():
    assert f"```c\n{PROGRAM}```" in PAGE
    assert PROGRAM.count("\n") <= 60
    assert set(re.findall(r'#include "(.*?)"', PROGRAM)) == {"embed_board.h", "tumble/sets.h"}


def result(text):
    """K with U0 as a fourth column, their uncertainties, and the specific force of what the program says."""
    rows = [re.findall(r"[-+]?\d+\.\d+", line) for line in text.splitlines()]
    k, u0 = np.array(rows[0::2], float), np.array(rows[1::2], float)
    return np.c_[k[:, :3], u0[:, 0]], np.c_[k[:, 3:], u0[:, 1]], u0[:, 2]


def played():
    """The coefficients of the block that embed_board.c plays."""
    text = (EXAMPLES / "embed_board.c").read_text(encoding="utf-8")
    arrays = (re.search(rf"{name} = (.*?);", text)[1] for name in (r"K\[3\]\[3\]", r"U0\[3\]"))
    k, u0 = (re.findall(r"-?\d+\.\d+", array) for array in arrays)
    return np.c_[np.array(k, float).reshape(3, 3), np.array(u0, float)]


def is_true(found, u, truth):
    """Twelve errors of honest standard uncertainties: none beyond three, their mean square near 1."""
    errors = (found - truth) / u
    return bool(np.abs(errors).max() < 3.0 and 0.3 < np.mean(errors**2) < 2.2)


@pytest.mark.slow
@needs_cc
def test_the_program_finds_the_block_that_is_played(tmp_path):
    """By the page's own command, and with our warnings."""
    command = re.search(r"```console\n\$ (cc .*)\n", PAGE)[1]
    for folder in ("examples", "firmware"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    assert run("sh", "-c", command, cwd=tmp_path) == OUTPUT
    run("cc", *STRICT, "-Ifirmware/include", "-fsyntax-only", "examples/embed.c", "examples/embed_board.c",
        cwd=tmp_path)


FAULTY_BOARD = """
#define board_memory good_memory
#define board_sample good_sample
#include "embed_board.c"
#undef board_memory
#undef board_sample
#include <stdio.h>

int embed(void);
const tumble_sample_t *board_sample(uint8_t position);
extern const tumble_nv_t board_memory;
static int fails;

static tumble_status_t erase_or_fail(void *context, uint32_t offset)
{
    return (fails == 'e') ? TUMBLE_E_NV : erase(context, offset);
}

static tumble_status_t program_or_fail(void *context, uint32_t offset, const uint8_t *bytes, uint32_t size)
{
    return (fails == 'p') ? TUMBLE_E_NV : program(context, offset, bytes, size);
}

const tumble_nv_t board_memory = {NULL, sizeof flash, SECTOR, 8, erase_or_fail, program_or_fail, read};

const tumble_sample_t *board_sample(uint8_t position) /* a fault: mounting 2 is mounted 45 degrees off */
{
    return good_sample((uint8_t)(((fails == 'g') && (position > 9U)) ? (position - 1U) : position));
}

int main(int count, char **arguments)
{
    embed(); /* nothing fails: a set is kept */
    printf("then\\n");
    fails = arguments[count - 1][0];
    return embed();
}
"""


@pytest.mark.slow
@needs_cc
def test_what_fails_is_said_and_no_old_set_is_shown(tmp_path):
    """With a set in the memory, a new one that is not kept: a sentence, exit 1, and no coefficients."""
    (tmp_path / "board.c").write_text(FAULTY_BOARD)
    flags = ["-std=c11", "-ffp-contract=off", "-Iexamples", "-Ifirmware/include", "-Ifirmware"]
    sources = sorted([*(ROOT / "firmware/core").glob("*.c"), *(ROOT / "firmware/sets").glob("*.c")])
    run("cc", *flags, "-Dmain=embed", "-c", "examples/embed.c", "-o", tmp_path / "embed.o", cwd=ROOT)
    run("cc", *flags, tmp_path / "board.c", tmp_path / "embed.o", *sources, "-lm", "-o", tmp_path / "embed", cwd=ROOT)
    memory = "the non-volatile memory failed, or has no such place\n"
    sentences = {"erase": memory, "program": memory, "gravity": "the gravity check failed: nothing is kept\n"}
    for fault, sentence in sentences.items():
        done = subprocess.run([tmp_path / "embed", fault], env=ENVIRONMENT, capture_output=True, text=True)
        good, _, bad = done.stdout.partition("then\n")
        assert good == OUTPUT and bad == sentence, fault
        assert done.returncode == 1


def test_what_it_finds_is_the_truth_within_its_uncertainty():
    found, u, a_g = result(OUTPUT)
    assert is_true(found, u, played())
    assert np.linalg.norm(a_g) == pytest.approx(1.0, abs=3e-4)  # one sample, with its noise


@pytest.mark.parametrize("element", [(0, 0), (1, 2), (2, 3)])
def test_another_block_is_not_taken_for_it(element):
    """Canary."""
    found, u, _ = result(OUTPUT)
    wrong = played()
    wrong[element] += 4e-5
    assert not is_true(found, u, wrong)


def test_its_costs_are_those_of_the_budget():
    """Every row for the Cortex-M4, with the limits that builds are held to: where one is changed, change the page."""
    with open(ROOT / "boards/budget.csv", newline="", encoding="utf-8") as file:
        rows = [list(row.values()) for row in csv.DictReader(file) if row["target"] == "cortex-m4"]
    limits = {row[1]: row[2:] for row in rows}
    shown = re.findall(r"^\| `(\w+)` \| [^|]+ \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", PAGE, re.MULTILINE)
    assert {row[0]: list(row[1:]) for row in shown} == limits


@needs_cc
def test_the_mathematics_alone(tumble, tmp_path):
    """By the page's commands; from the means of a recorded run what the page shows, and of its first position what
    `solve` says. Without means, or with bad ones, exit code 1 and nothing else."""
    blocks = r"```c\n(.*?)```.*?```sh\n(.*?)```.*?```text\n(.*?)```"
    section = PAGE[PAGE.index("\n## The mathematics alone\n"):]
    program, commands, shown = re.search(blocks, section, re.DOTALL).groups()
    compile_it, _, run_it = commands.partition("\n")
    assert program.count("\n") <= 20
    (tmp_path / "main.c").write_text(program)
    for folder in ("firmware", "examples"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    run("sh", "-c", compile_it.replace("cc ", f"cc {' '.join(STRICT)} "), cwd=tmp_path)
    assert run("sh", "-c", run_it, cwd=tmp_path) == shown
    solved = json.loads(tumble("solve", EXAMPLES / "paper_stand.csv", "--json").stdout)
    text = "\n".join(" ".join(map(repr, mean["mean"])) for mean in solved["means"])
    assert run(tmp_path / "main", input=text) == shown
    rows = np.array(re.findall(r"[-+]\d+\.\d+", shown), float).reshape(3, 4)
    force = np.linalg.solve(solved["K"], np.subtract(solved["means"][0]["mean"], solved["U0"]))
    assert rows == pytest.approx(np.c_[solved["K"], force], abs=6e-7)
    truth = json.loads((EXAMPLES / "paper_stand.truth.json").read_text())
    assert rows[:, :3] == pytest.approx(np.array(truth["K"]), abs=1e-3)
    slipped = text.replace(text.splitlines()[4], text.splitlines()[3])  # the table has not turned
    for bad in ("1 2", "0 0 0\n" * 18, "\n".join(text.splitlines()[:17]), slipped):
        done = subprocess.run([tmp_path / "main"], input=bad, capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (1, "")
