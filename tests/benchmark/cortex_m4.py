"""What samples, estimators and steps cost on a Cortex-M4 without floating point hardware: instructions, code, stack.

    tools/benchmark cortex_m4 [-O s|2] [--json | --table]

Each candidate is linked alone with what it needs and run in QEMU (mps2-an386), which counts instructions, not cycles:
no time follows from them. The run and the gains are those of the paper's stand. `code` is the project's own, `library`
the soft floating point that comes with it, `data` constants beside the code (the schedule apart); stack is painted and
read back, below the call. Every result is compared with the host's. Steps of the navigation computer are those of a
whole calibration, with a bus, a drive and a block played beside it (tests/target/navcomp_steps.c). `formula` is what
the additions, multiplications and divisions of a row's formula cost in the compiler's library: their number
(arithmetic.py) times what one takes, measured in the same emulator. Beside them, what
tools/budget measured in the builds that are there: code, RAM and worst stack of whole parts, with their limits. Needs
the package to be importable, as in the tests; gcc for Arm and qemu-system-arm, or exit 77.
"""

import argparse
import csv
import json
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import costs_page as page
import numpy as np
from cortex_m4_data import OTHERS, write_data
from cortex_m4_formulas import formulas

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent / "cortex_m4"
TARGET = ROOT / "tests/target"
sys.path.insert(0, str(ROOT / "tools"))
from footprint import image  # noqa: E402

CANDIDATES = {
    "nothing": 0,
    "refined": 1,
    "least_squares: 4 unknowns": 2,
    "optimal, linear: table alone": 3,
    "optimal: table, 2nd order": 4,
    "checking the gain record": 5,
    "4 unknowns, shared normal matrix": 12,
    "12 unknowns, normal equations": 6,
    "12 unknowns, Householder QR": 7,
    "a loop over samples": 8,
    "a sample, without gates": 9,
    "a sample, with gates": 10,
    "division of the 54 means": 11,
    "uncertainties of `refined`": 13,
    "uncertainties of `least_squares`": 14,
    "uncertainties of `optimal`": 15,
    "a sample in blocks": 21,
    "the noise of a run": 18,
    "one of `refined`, noise above": 19,
    "one of `least_squares`, noise above": 20,
    "refined, three mountings": 16,
    "refined, diagonal": 17,
    "inclined": 22,
    "uncertainties of `inclined`": 23,
    "one of `inclined`": 24,
    "a calibration at a temperature": 25,
    "slopes, updated by a run": 26,
}
SAMPLES = 512  # in one loop, as benchmark.h has it
BUDGETS = "build/{0}/boards/*/budget_*.csv"  # by preset
PRESETS = ("cortex-m4", "zcu102")
SOURCES = ("firmware/**/*.[ch]", "boards/**/*.[chS]", "boards/**/CMakeLists.txt", "cmake/*")
KNOWN = {1: "refined", 2: "least_squares", 3: "linear", 4: "optimal"}
KNOWN |= dict.fromkeys((6, 7, 12), "least_squares")
KNOWN |= {13: "u refined", 14: "u least_squares", 15: "u optimal", 16: OTHERS[0], 17: OTHERS[1]}
KNOWN |= {22: "inclined", 23: "u inclined"}
LOOP = "a loop over samples"
SAMPLE_PATHS = ("a sample, without gates", "a sample, with gates", "a sample in blocks")
STEPS = {"idle": "an idle step", "sample": "a step with a sample", "other": "any other step"}
# The target's library rounds a sum wrongly, by one unit in the last place, where the exponents of its terms differ by
# 33 and the result falls below the power of two that the larger one is not below (1 - 1.55e-10, say; ieee754-df.S of
# libgcc 12). The cosines of small angles in `optimal` meet that; so results are compared to this part of the largest
# coefficient.
LAST_BITS = 4 * np.finfo(float).eps
UNITY = ("build/unity", "build/*/_deps/unity-src/src")
UNITY_FLAGS = """-DUNITY_INCLUDE_DOUBLE -DUNITY_SUPPORT_64 -DUNITY_OUTPUT_CHAR=target_put
                 -DUNITY_OUTPUT_CHAR_HEADER_DECLARATION=target_put(int)""".split()
PAGE_COLUMNS = ("instructions", "before", "goal", "formula", "code, B", "constants, B", "stack, B")
HONEST = """
Ratios are to `refined`, from means to coefficients; the division that makes the means stands apart, since all need it.
The honest comparison is with the shared normal matrix of four unknowns: what one would write who has thought about it,
for the same model and the same means. Dense rows for twelve unknowns do the same work several times over. Mind that
`refined` needs circles of nine or four positions and does not have the least noise; `least_squares` takes any schedule,
tells whether it has full rank, and corrects its solution once."""
REPEATS, INSTRUCTIONS_PER_TICK = 25, 40
NOT_THERE = 77
CMAKE_FLAGS = (ROOT / "cmake/flags.cmake").read_text(encoding="utf-8")
SMALL, FAST = (re.search(rf"set\({name} ([^)]*)\)", CMAKE_FLAGS)[1].split() for name in ("TUMBLE_SMALL", "TUMBLE_FAST"))
FAST_SOURCES = ("averaging_sample",)
FLAGS = """-std=c11 -ffp-contract=off -fno-math-errno -mcpu=cortex-m4 -mthumb -mfloat-abi=soft -ffunction-sections
           -fdata-sections -DNDEBUG -Wall -Wextra -Wconversion -Wdouble-promotion -Werror""".split()
LINK = "-nostdlib -nostartfiles -Wl,--gc-sections -Wl,--start-group -lgcc -lc -lm -lnosys -Wl,--end-group".split()
QEMU = """qemu-system-arm -M mps2-an386 -display none -monitor none -serial none
          -semihosting-config enable=on,target=native -icount shift=0,sleep=off -kernel""".split()


@dataclass
class Cost:
    """Instructions for one estimate; bytes of the project's code, of libraries, of constants, of stack; instructions of
    the formula's operations in the library, where it was counted."""

    instructions: int
    code: int
    library: int
    data: int
    stack: int
    formula: int | None = None


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("-O", dest="optimise", choices=("s", "2"), default="s", help="as flown (s), or for speed")
    shape = parser.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true")
    shape.add_argument("--table", action="store_true", help="the one of docs/performance.md")
    options = parser.parse_args()
    for program in ("arm-none-eabi-gcc", "qemu-system-arm"):
        if shutil.which(program) is None:
            print(f"{program} is not there", file=sys.stderr)
            return NOT_THERE
    with tempfile.TemporaryDirectory() as folder:
        costs = measure(Path(folder), f"-O{options.optimise}")
        operations = library_costs(Path(folder), f"-O{options.optimise}")
        add_formulas(costs, operations)
        if options.table:
            print(page_table(costs))
            return 0
        whole = whole_model(Path(folder), f"-O{options.optimise}")
        steps = navcomp_steps(Path(folder), f"-O{options.optimise}")
    if options.json:
        rows = {name: asdict(cost) for name, cost in costs.items()}
        print(json.dumps(rows | {"steps": steps, "whole_model": whole, "operations": operations}))
    else:
        parts = operation_lines(operations), whole_lines(whole), step_lines(steps), budget_lines()
        print(table(costs), *(line for lines in parts for line in lines), HONEST, sep="\n")
    return 0


def measure(folder, optimise):
    """The cost of every candidate, by name. Exits where the target's result is not the host's."""
    expected = write_data(folder / "data.c")
    objects = [compile_c(source, folder, optimise) for source in sorted((ROOT / "firmware/core").glob("*.c"))]
    objects += [compile_c(HERE / name, folder, optimise) for name in ("dense.c", "samples.c")]
    data = compile_c(folder / "data.c", folder, optimise)
    harness = [compile_c(TARGET / name, folder, optimise) for name in ("start.c", "measure.c")]
    costs, overhead = {}, Cost(0, 0, 0, 0, 0)
    for name, number in CANDIDATES.items():
        driver = compile_c(HERE / "main.c", folder, optimise, f"-DCANDIDATE={number}")
        cost, found = run(folder, objects, data, [*harness, driver])
        if number in KNOWN and np.abs(found - expected[KNOWN[number]]).max() > LAST_BITS * np.abs(found).max():
            sys.exit(f"{name}: the target's result is not the host's")
        cost.instructions -= overhead.instructions
        cost.stack -= overhead.stack
        if name == "nothing":
            overhead = cost
        else:
            costs[name] = cost
    loop = costs.pop(LOOP)
    for name in SAMPLE_PATHS:
        costs[name].instructions = round((costs[name].instructions - loop.instructions) / SAMPLES)
    return costs


def whole_model(folder, optimise):
    """The test of the whole model by schedule: [steps, instructions of all, of the longest, stack], after `measure`."""
    sources = [HERE / "whole_model.c", *(TARGET / name for name in ("start.c", "measure.c"))]
    (folder / "whole").mkdir()
    driver = [compile_c(source, folder / "whole", optimise) for source in sources]
    objects = [folder / f"{source.stem}.o" for source in sorted((ROOT / "firmware/core").glob("*.c"))]
    elf = folder / "whole.elf"
    command = ["arm-none-eabi-gcc", *FLAGS, f"-T{TARGET / 'link.ld'}", *driver, folder / "data.o", *objects, *LINK]
    subprocess.run([*command, "-o", elf], check=True)
    result = subprocess.run([*QEMU, elf], check=True, capture_output=True, text=True, timeout=120)
    lines = [line.split()[1:] for line in (result.stdout + result.stderr).splitlines() if line.startswith("whole ")]
    return {name: [*map(int, numbers)] for name, *numbers in lines}


def library_costs(folder, optimise):
    """Instructions of one operation of the library by its kind, after `measure`."""
    (folder / "library").mkdir()
    sources = [HERE / "library.c", *(TARGET / name for name in ("start.c", "measure.c"))]
    driver = [compile_c(source, folder / "library", optimise) for source in sources]
    elf = folder / "library.elf"
    command = ["arm-none-eabi-gcc", *FLAGS, f"-T{TARGET / 'link.ld'}", *driver, folder / "data.o"]
    objects = [folder / f"{source.stem}.o" for source in sorted((ROOT / "firmware/core").glob("*.c"))]
    subprocess.run([*command, *objects, *LINK, "-o", elf], check=True)
    result = subprocess.run([*QEMU, elf], check=True, capture_output=True, text=True, timeout=60)
    lines = [line.split()[1:] for line in (result.stdout + result.stderr).splitlines() if line.startswith("library ")]
    return {kind: int(instructions) for kind, instructions in lines}


def operation_lines(operations):
    """One operation of the library as text."""
    return ["", f"{'one in the library':32}{'instructions':>12}", *(f"{k:32}{n:12,}" for k, n in operations.items())]


def add_formulas(costs, operations):
    """What the operations of each formula cost that was counted."""
    for name, counted in formulas().items():
        costs[name].formula = sum(number * operations[kind] for kind, number in counted.items())


def whole_lines(whole):
    """The test of the whole model as text."""
    lines = ["", f"{'the whole model':32}{'instructions':>12}{'longest':>9}{'stack':>9}{'steps':>7}"]
    for name, (steps, instructions, longest, stack) in whole.items():
        lines.append(f"{name:32}{instructions:12,}{longest:9,}{stack:9}{steps:7}")
    return lines


def navcomp_steps(folder, optimise):
    """Instructions of a step by its kind: [steps, mean, least, most, the state after the longest].
    None without Unity."""
    unity = next((path for pattern in UNITY for path in ROOT.glob(pattern)), None)
    if unity is None:
        return None
    include = ["firmware", "firmware/include", "host", "tests/lib", "tests/target", unity.relative_to(ROOT)]
    options = [*FLAGS, optimise, *(SMALL if optimise == "-Os" else []), *UNITY_FLAGS]
    options += ["-DBENCH_LOG=64U", *(f"-I{ROOT / path}" for path in include)]
    rooms = ("core", "sample", "canopen", "stand", "procedure", "navcomp")
    sources = [source for room in rooms for source in (ROOT / "firmware" / room).rglob("*.c")]
    played = [*(TARGET / name for name in ("navcomp_steps.c", "measure.c", "start.c")), unity / "unity.c"]
    played.append(ROOT / "host/simulation/block_encode.c")
    played += [*(ROOT / "tests/lib").glob("scripted_*.c"), ROOT / "tests/lib/navcomp_bench.c"]
    objects = []
    for source in [*sources, *played]:
        more = ["-flto"] if source in sources else ["-Wno-error"]
        more += FAST if source.stem in FAST_SOURCES else []
        objects.append(folder / f"step_{source.parent.name}_{source.stem}.o")
        command = ["arm-none-eabi-gcc", *options, *more, "-c", source, "-o", objects[-1]]
        subprocess.run(command, check=True, capture_output=True)
    elf = folder / "steps"
    command = [
        "arm-none-eabi-gcc",
        *options,
        "-flto",
        "-flto-partition=one",
        f"-T{TARGET / 'link.ld'}",
        *objects,
        *LINK,
    ]
    subprocess.run([*command, "-o", elf], check=True)
    result = subprocess.run([*QEMU, elf], check=True, capture_output=True, text=True, timeout=120)
    lines = [line.split()[1:] for line in (result.stdout + result.stderr).splitlines() if line.startswith("step ")]
    return {STEPS[name]: [*map(int, numbers), state] for name, *numbers, state in lines}


def step_lines(steps):
    """The steps as text, or why there are none."""
    if steps is None:
        return ["", "steps of the navigation computer: LEFT OUT, Unity is not there (tools/setup test fetches it)"]
    lines = ["", f"{'navigation computer':32}{'instructions':>12}{'least':>9}{'most':>9}{'steps':>7}"]
    for name, (count, mean, least, most, state) in steps.items():
        lines.append(f"{name:32}{mean:12,}{least:9,}{most:9,}{count:7}  the longest led to {state}")
    return lines


def budget_lines():
    """What the last builds measured, of the limit; said where there is none, or an older one than the sources."""
    columns = ("code", "library", "static_ram", "stack")
    lines = ["", f"{'B, of the limit':32}" + "".join(f"{name:>16}" for name in columns)]
    changed = max(path.stat().st_mtime for pattern in SOURCES for path in ROOT.glob(pattern))
    for preset in PRESETS:
        paths = sorted(ROOT.glob(BUDGETS.format(preset)))
        if not paths:
            how = f"cmake --preset {preset} && cmake --build --preset {preset}"
            lines.append(f"{preset}: LEFT OUT, it is not built ({how})")
        for path in paths:
            with path.open(newline="", encoding="utf-8") as file:
                rows = {row["quantity"]: row for row in csv.DictReader(file)}
            cells = "".join(f"{rows[name]['bytes'] + ' / ' + rows[name]['limit_bytes']:>16}" for name in columns)
            old = "" if path.stat().st_mtime >= changed else "  older than the sources"
            lines.append(f"{rows['code']['target'] + ' ' + rows['code']['part']:32}{cells}{old}")
    return lines


def compile_c(source, folder, optimise, *more):
    target = folder / f"{source.stem}.o"
    include = f"-I{ROOT / 'firmware'}", f"-I{ROOT / 'firmware/include'}", f"-I{HERE}", f"-I{TARGET}"
    level = [optimise, *(SMALL if optimise == "-Os" else []), *(FAST if source.stem in FAST_SOURCES else [])]
    subprocess.run(["arm-none-eabi-gcc", *FLAGS, *level, *more, *include, "-c", source, "-o", target], check=True)
    return target


def run(folder, objects, data, harness):
    """Link and run one image: its cost, and its result (12,)."""
    elf, linker_map = folder / "image", folder / "image.map"
    command = [
        "arm-none-eabi-gcc",
        *FLAGS,
        f"-T{TARGET / 'link.ld'}",
        f"-Wl,-Map={linker_map}",
        *harness,
        data,
        *objects,
    ]
    subprocess.run([*command, *LINK, "-o", elf], check=True)
    result = subprocess.run([*QEMU, elf], check=True, capture_output=True, text=True, timeout=60)
    ticks, stack, status, *words = (int(word) for word in (result.stdout + result.stderr).split())
    if status != 0:
        sys.exit(f"the target refused with status {status}")
    text = linker_map.read_text(encoding="utf-8")
    code, constants, rest = (image.measure(text, group) for group in (objects, [data], harness))
    library = rest.library - code.code - constants.code
    instructions = round(ticks * INSTRUCTIONS_PER_TICK / REPEATS)
    return Cost(instructions, code.code, library, constants.code, stack), np.array(words, dtype="<u4").view("<f8")


def table(costs):
    """The costs as text, with the ratio of instructions to those of `refined`."""
    unit = costs["refined"].instructions
    lines = [f"{'':32}{'instructions':>12}{'ratio':>8}{'code':>7}{'library':>9}{'data':>7}{'stack':>7}"]
    for name, cost in costs.items():
        ratio = cost.instructions / unit
        lines.append(f"{name:32}{cost.instructions:12,}{ratio:8.2f}{cost.code:7}{cost.library:9}{cost.data:7}{cost.stack:7}")
    return "\n".join(lines)


def page_table(costs):
    """As docs/performance.md has it, with its goals, and what it said before."""
    said = page.rows_of(page.table_of(page.PAGE.read_text(encoding="utf-8"), "cortex_m4"))
    return page.markdown(PAGE_COLUMNS, {name: page_row(cost, said.get(name, {})) for name, cost in costs.items()})


def page_row(cost, said):
    """The cells of one row, from what was measured and what the page says of it."""
    now = {"instructions": cost.instructions, "code, B": cost.code, "constants, B": cost.data, "stack, B": cost.stack}
    earlier = page.before(cost.instructions, said.get("instructions", ""), said.get("before", ""))
    formula = "" if cost.formula is None else f"{cost.formula:,}"
    return {name: f"{value:,}" for name, value in now.items()} | {
        "before": earlier, "formula": formula, "goal": said.get("goal", "")}


if __name__ == "__main__":
    sys.exit(main())
