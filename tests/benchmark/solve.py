"""How long `tumble solve` takes, start of the interpreter included, and how much memory.

    tools/benchmark solve [--repeat N]

For runs of 900, 5,000 and 1,000,000 rows: the best of N wall times and the peak resident memory of the whole command;
beside it, measured in the same run, what one would write without it: Python's csv module, numpy, formulas (3) and (7),
no checks, no witness. Needs the package to be importable, as in the tests.
"""

import argparse
import os
import random
import sys
import tempfile
import time
from pathlib import Path

ROWS = (900, 5_000, 1_000_000)

NAIVE = """\
import csv, sys
import numpy as np
samples = {}
with open(sys.argv[1], newline="") as file:
    for row in csv.DictReader(file):
        key = int(row["mounting"]), int(row["position"])
        samples.setdefault(key, []).append([float(row["ux"]), float(row["uy"]), float(row["uz"])])
u = {key: np.mean(values, axis=0) for key, values in samples.items()}
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


def write_run(path: Path, rows: int) -> None:
    """A run of so many rows, position after position, noise in the last digits."""
    rng, half = random.Random(rows), 0.5**0.5
    sines = [0, half, 1, half, 0, -half, -1, -half, 0]
    cosines = [1, half, 0, -half, -1, -half, 0, half, 1]
    with open(path, "w", encoding="ascii") as file:
        file.write("mounting,position,ux,uy,uz\n")
        for row in range(rows):
            mounting, turn = divmod(row * 18 // rows, 9)
            h, v = sines[turn], cosines[turn]
            a = (h, 0.0, v) if mounting == 0 else (-h, v, 0.0)
            u = (f"{0.01 + 2.0 * axis + rng.uniform(-5e-4, 5e-4):.7f}" for axis in a)
            file.write(f"{mounting + 1},{turn + 1},{','.join(u)}\n")


def measure(command: list[str], repeat: int) -> tuple[float, float]:
    """Best wall time in s, and peak resident memory in MB, of a command."""
    best, peak = float("inf"), 0
    for _ in range(repeat):
        start = time.perf_counter()
        child = os.posix_spawnp(
            command[0], command, os.environ, file_actions=[(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
        )
        _, status, usage = os.wait4(child, 0)
        best = min(best, time.perf_counter() - start)
        if os.waitstatus_to_exitcode(status) != 0:
            raise SystemExit(f"failed: {' '.join(command)}")
        peak = max(peak, usage.ru_maxrss)
    return best, peak / 1024


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description="Time `tumble solve` beside csv and numpy.")
    parser.add_argument("--repeat", type=int, default=3, help="the best of so many (default 3)")
    repeat = parser.parse_args().repeat
    print(f"{'rows':>9}  {'tumble solve':>20}  {'csv and numpy':>20}  {'time':>6}  {'memory':>6}")
    with tempfile.TemporaryDirectory() as folder:
        for rows in ROWS:
            run = Path(folder) / f"{rows}.csv"
            write_run(run, rows)
            ours, our_memory = measure([sys.executable, "-m", "tumble", "solve", str(run)], repeat)
            naive, naive_memory = measure([sys.executable, "-c", NAIVE, str(run)], repeat)
            print(
                f"{rows:>9}  {ours:>8.2f} s  {our_memory:>5.0f} MB  {naive:>8.2f} s  {naive_memory:>5.0f} MB"
                f"  {ours / naive:>6.2f}  {our_memory / naive_memory:>6.2f}"
            )


if __name__ == "__main__":
    main()
