"""What `tumble solve` takes of the processor and of memory, start of the interpreter included.

    tools/benchmark solve [--repeat N] [--rows N,...] [--packed | --table]

For runs of 900 to 10,000,000 rows: the least of N times of the processor (user and system) and the peak resident memory
of the whole command; beside it, measured in the same run and by turns, what one would write without it, with no checks
and no witness: Python's csv module and numpy, up to a million rows; pandas.read_csv and groupby where pandas is
installed; and the import of numpy alone, below which no way is. All run from compiled modules, whatever
PYTHONDONTWRITEBYTECODE says. `--packed`: the same of `tumble solve -` and of a file that gzip has compressed, against
the plain file. `--table`: as docs/performance.md has it; needs pandas, or exit 77.
"""

import argparse
import gzip
import importlib.util
import multiprocessing
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

ROWS = (900, 5_000, 100_000, 1_000_000, 10_000_000)
MOST_FOR_CSV = 1_000_000
EXIT_SKIPPED = 77

FORMULAS = """\
r = np.sqrt(2)
c, s, b = {}, {}, {}
for m in (1, 2):
    u1, u2, u3, u4, u5, u6, u7, u8, u9 = (u[m, l] for l in range(1, 10))
    c[m] = (u1 + u9 - 2 * u5 + r * (u2 + u8 - u4 - u6)) / 8
    s[m] = (2 * (u3 - u7) + r * (u2 + u4 - u6 - u8)) / 8
    b[m] = ((u1 + u9) / 2 + u2 + u3 + u4 + u5 + u6 + u7 + u8) / 8
K = np.column_stack([(s[1] - s[2]) / 2, c[2], c[1]])
K[1, 0], K[2, 0] = -s[2][1], s[1][2]
print(K, (b[1] + b[2]) / 2)
"""

CSV = """\
import csv, sys
import numpy as np
samples = {}
with open(sys.argv[1], newline="") as file:
    for row in csv.DictReader(file):
        key = int(row["mounting"]), int(row["position"])
        samples.setdefault(key, []).append([float(row["ux"]), float(row["uy"]), float(row["uz"])])
u = {key: np.mean(values, axis=0) for key, values in samples.items()}
"""

PANDAS = """\
import sys
import numpy as np, pandas
means = pandas.read_csv(sys.argv[1]).groupby(["mounting", "position"])[["ux", "uy", "uz"]].mean()
u = dict(zip(means.index, means.to_numpy()))
"""

RIVALS = {"import numpy": "import numpy", "csv and numpy": CSV + FORMULAS, "pandas": PANDAS + FORMULAS}


def written(outputs: np.ndarray) -> np.ndarray:
    """Numbers as text with seven decimals, ten bytes each: a sign or 0, and the digits."""
    units = np.rint(np.abs(outputs) * 1e7).astype(np.int64)
    text = np.full((*outputs.shape, 10), ord("."), dtype=np.uint8)
    text[..., 0] = np.where(outputs < 0, ord("-"), ord("0"))
    for place, digit in zip((1, *range(3, 10)), range(7, -1, -1)):
        text[..., place] = ord("0") + units // 10**digit % 10
    return text


def write_run(path: Path, rows: int) -> None:
    """A run of so many rows, position after position, with Gaussian noise and set angles off by 1e-5 rad."""
    rng, angles = np.random.default_rng(rows), np.arange(9) * np.pi / 4
    with open(path, "wb") as file:
        file.write(b"mounting,position,ux,uy,uz\n")
        for place in range(18):
            mounting, turn = divmod(place, 9)
            angle = angles[turn] + 1e-5 * rng.normal()
            h, v = np.sin(angle), np.cos(angle)
            mean = 0.01 + 2.0 * np.array([h, 0.0, v] if mounting == 0 else [-h, v, 0.0])
            own = (place + 1) * rows // 18 - place * rows // 18
            lines = np.full((own, 37), ord(","), dtype=np.uint8)
            lines[:, 0], lines[:, 2], lines[:, -1] = ord("1") + mounting, ord("1") + turn, ord("\n")
            for channel, text in enumerate(written(mean + 3e-4 * rng.normal(size=(own, 3))).swapaxes(0, 1)):
                lines[:, 4 + 11 * channel : 14 + 11 * channel] = text
            file.write(lines.tobytes())


def prepare(run: Path, packed: Path | None, rows: int) -> None:
    """Write a run, and what gzip makes of it, in another process: the peak of a process counts that of its parent."""
    process = multiprocessing.Process(target=write_run, args=(run, rows))
    process.start()
    process.join()
    if packed is not None:
        with open(run, "rb") as source, gzip.open(packed, "wb", compresslevel=6) as target:
            shutil.copyfileobj(source, target, 1 << 20)


def measure(command: list[str], source: str = os.devnull) -> tuple[float, float]:
    """Seconds of the processor and peak resident memory in MB of a command, given its standard input."""
    files = [(0, source, os.O_RDONLY), (1, os.devnull, os.O_WRONLY), (2, os.devnull, os.O_WRONLY)]
    actions = [(os.POSIX_SPAWN_OPEN, number, file, mode, 0) for number, file, mode in files]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    child = os.posix_spawnp(command[0], command, environment, file_actions=actions)
    _, status, usage = os.wait4(child, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        raise SystemExit(f"failed: {' '.join(command)}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def race(commands: dict[str, tuple[list[str], str]], repeat: int) -> dict[str, tuple[float, float]]:
    """The least of each, measured by turns. The first run of our own compiles its modules, and does not count."""
    measure(*commands["tumble solve"])
    rounds = [{name: measure(*given) for name, given in commands.items()} for _ in range(repeat)]
    return {name: tuple(map(min, zip(*(one[name] for one in rounds)))) for name in commands}


def raced(sizes: list[int], repeat: int, is_packed: bool) -> Iterator[tuple[int, dict[str, tuple[float, float]]]]:
    """For each size what every command took; `is_packed`: of our own alone, from other sources of the rows."""
    with tempfile.TemporaryDirectory() as folder:
        for rows in sizes:
            run, packed = Path(folder) / f"{rows}.csv", Path(folder) / f"{rows}.csv.gz"
            prepare(run, packed if is_packed else None, rows)
            commands = ours(run, packed) if is_packed else {**ours(run, None), **rivals(run, rows)}
            yield rows, race(commands, repeat)
            run.unlink()


def ours(run: Path, packed: Path | None) -> dict[str, tuple[list[str], str]]:
    """Commands of `tumble solve`, each with its standard input."""
    solve = [sys.executable, "-m", "tumble", "solve"]
    commands = {"tumble solve": ([*solve, str(run)], os.devnull)}
    if packed is not None:
        commands["tumble solve -"] = [*solve, "-"], str(run)
        commands["tumble solve, gzip"] = [*solve, str(packed)], os.devnull
    return commands


def rivals(run: Path, rows: int) -> dict[str, tuple[list[str], str]]:
    """Commands of the others that can be had here."""
    return {
        name: ([sys.executable, "-c", text, str(run)], os.devnull)
        for name, text in RIVALS.items()
        if (has_pandas() or not text.startswith(PANDAS)) and (rows <= MOST_FOR_CSV or not text.startswith(CSV))
    }


def has_pandas() -> bool:
    """Is it installed?"""
    return importlib.util.find_spec("pandas") is not None


def show(rows: int, found: dict[str, tuple[float, float]]) -> None:
    """A line for each, with the first one's ratio to it."""
    (first, (seconds, memory)), *_ = found.items()
    for name, (its_seconds, its_memory) in found.items():
        ratios = "" if name == first else f"  {seconds / its_seconds:>6.2f}  {memory / its_memory:>6.2f}"
        print(f"{rows:>9}  {name:<20}  {its_seconds:>8.2f} s  {its_memory:>5.0f} MB{ratios}", flush=True)


def row_of_page(rows: int, found: dict[str, tuple[float, float]]) -> str:
    """The row of the page: seconds and memory of each, and ratios of ours to the others."""
    seconds, memory = found["tumble solve"]
    cells = [f"{rows:,}", f"{seconds:.2f} s, {memory:,.0f} MB"]
    for name in ("pandas", "csv and numpy"):
        its = found.get(name)
        cells.append(f"{its[0]:.2f} s, {its[1]:,.0f} MB" if its else "")
        cells.append(f"{seconds / its[0]:.2f}, {memory / its[1]:.2f}" if its else "")
    cells.append(f"{seconds / found['import numpy'][0]:.2f}")
    return f"| {' | '.join(cells)} |"


def print_table(sizes: list[int], repeat: int) -> None:
    """The table of docs/performance.md, and what other sources of the rows cost."""
    print("| rows | tumble solve | pandas | ratios to it | csv | ratios to it | time to numpy's import |")
    print("|---|---|---|---|---|---|---|")
    for rows, found in raced(sizes, repeat, is_packed=False):
        print(row_of_page(rows, found), flush=True)
    for rows, found in raced(sizes[-1:], repeat, is_packed=True):
        taken = "; ".join(f"{name}: {seconds:.2f} s" for name, (seconds, _) in found.items())
        machine = f"{os.cpu_count()} processors, load {os.getloadavg()[1]:.1f} in the last five minutes"
        print(f"\n```text\n{rows:,} rows, {taken}\n{machine}\n```")


def main() -> int:
    """Measure and print a table. Returns the exit code."""
    parser = argparse.ArgumentParser(description="Measure `tumble solve` beside csv, numpy and pandas.")
    parser.add_argument("--repeat", type=int, default=3, help="the least of so many (default 3)")
    parser.add_argument("--rows", default=",".join(map(str, ROWS)), help="sizes (default %(default)s)")
    parser.add_argument("--packed", action="store_true", help="standard input and gzip instead of others")
    parser.add_argument("--table", action="store_true", help="for docs/performance.md")
    arguments = parser.parse_args()
    sizes = [int(size) for size in arguments.rows.split(",")]
    if arguments.table:
        if not has_pandas():
            print("needs pandas", file=sys.stderr)
            return EXIT_SKIPPED
        print_table(sizes, arguments.repeat)
        return 0
    print("     rows  what                  processor    memory    time  memory   (tumble solve to it)")
    for rows, found in raced(sizes, arguments.repeat, arguments.packed):
        show(rows, found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
