"""What simulated runs take of one processor: tumble-bench, plain and built from a profile, and `tumble plan validate`.

    tools/benchmark simulation [--table] [--rounds N] [--runs N] [--validated N]

Calibrations on the paper's stand, by the program's own clock of the processor, the two builds by turns: medians of the
rounds, and the median of the ratios. The build from a profile is made by the presets `profile` and `profiled`, if gcc
is there; else exit 77. `plan validate`: all estimators, a table of gains for every run, medians of three.
"""

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

from campaign import STANDS, run_program, setup_of

ROOT = Path(__file__).resolve().parents[2]
PROFILED = ROOT / "build/profiled/host/bench/tumble-bench"
EXIT_SKIPPED = 77


def build_from_a_profile() -> bool:
    """By the two presets, as CONTRIBUTING.md says. False: no gcc here."""
    if shutil.which("gcc") is None or shutil.which("cmake") is None:
        return False
    for preset in ("profile", "profiled"):
        for command in (["cmake", "--preset", preset], ["cmake", "--build", "--preset", preset]):
            subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    return PROFILED.exists()


def calibrations_per_s(program: str | None, runs: int) -> float:
    """Of the processor."""
    if program is not None:
        os.environ["TUMBLE_BENCH"] = program
    else:
        os.environ.pop("TUMBLE_BENCH", None)
    setup, _ = setup_of(STANDS[0])
    return run_program(setup, "--runs", str(runs), "--summary", "--jobs", "1")[0]["calibrations_per_cpu_s"]


def builds(rounds: int, runs: int) -> str:
    """Rows of the builds."""
    pairs = [(calibrations_per_s(None, runs), calibrations_per_s(str(PROFILED), runs)) for _ in range(rounds)]
    plain, profiled = (statistics.median(side) for side in zip(*pairs))
    ratio = statistics.median(one / other for one, other in pairs)
    return (
        f"| tumble-bench, plain (`host`) | {plain:.0f} calibrations per second | 1 |\n"
        f"| tumble-bench, from a profile (`profiled`) | {profiled:.0f} calibrations per second | {ratio:.2f} |"
    )


def validated(runs: int) -> str:
    """The row of `plan validate`."""
    taken = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [sys.executable, "-m", "tumble", "plan", "validate", "--table", "run", "--json", "--runs", str(runs)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        taken.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    return f"| `plan validate --table run`, {runs:,} runs | {statistics.median(taken):.1f} s | |"


def main() -> int:
    """Measure and print. Returns the exit code."""
    parser = argparse.ArgumentParser(description="Simulated runs per second of the processor.")
    parser.add_argument("--table", action="store_true", help="for docs/performance.md: what is printed anyway")
    parser.add_argument("--rounds", type=int, default=9, help="pairs of the two builds (default 9)")
    parser.add_argument("--runs", type=int, default=1000, help="calibrations of each (default 1000)")
    parser.add_argument("--validated", type=int, default=50_000, help="runs of plan validate (default 50000)")
    arguments = parser.parse_args()
    if not build_from_a_profile():
        print("needs gcc and cmake", file=sys.stderr)
        return EXIT_SKIPPED
    print("| what | of the processor | time, to the plain build |\n|---|---|---|")
    print(builds(arguments.rounds, arguments.runs), flush=True)
    print(validated(arguments.validated))
    load = os.getloadavg()[1]
    print(f"\n```text\n{os.cpu_count()} processors, load {load:.1f} in the last five minutes\n```")
    return 0


if __name__ == "__main__":
    sys.exit(main())
