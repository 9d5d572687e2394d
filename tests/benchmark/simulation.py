"""What simulated runs take of one processor: worlds, campaigns of them, and `tumble plan validate`.

    tools/benchmark simulation [--table] [--rounds N] [--runs N] [--validated N]

Calibrations on the paper's stand, each a world of its own that keeps every frame, held by a script and as `tumble
campaign runs` has them, by turns: medians of the rounds. `plan validate`: all estimators, a table of gains for every
run, the median of three.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

from tumble import World
from tumble.world import campaigns


def held(runs: int) -> None:
    """So many worlds."""
    for seed in range(1, runs + 1):
        World(seed).run()


def in_a_campaign(runs: int) -> None:
    """So many lines."""
    for _ in campaigns.ended(campaigns.of_runs(None, "the defaults", False), 1, runs):
        pass


def per_s(calibrate: Callable[[int], None], runs: int) -> float:
    """Calibrations, of the processor."""
    began_s = time.process_time()
    calibrate(runs)
    return runs / (time.process_time() - began_s)


def validated_s(runs: int) -> float:
    """Of the processor, for `plan validate`."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "tumble", "plan", "validate", "--table", "run", "--json", "--runs", str(runs)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Simulated runs per second of the processor.")
    parser.add_argument("--table", action="store_true", help="for docs/performance.md: what is printed anyway")
    parser.add_argument("--rounds", type=int, default=9, help="of calibrations (default 9)")
    parser.add_argument("--runs", type=int, default=500, help="calibrations of a round (default 500)")
    parser.add_argument("--validated", type=int, default=50_000, help="runs of plan validate (default 50000)")
    arguments = parser.parse_args()
    print("| what | of the processor |\n|---|---|")
    rounds = [[per_s(one, arguments.runs) for one in (held, in_a_campaign)] for _ in range(arguments.rounds)]
    for name, speeds in zip(("World(seed).run()", "tumble campaign runs"), zip(*rounds)):
        print(f"| `{name}` | {statistics.median(speeds):.0f} calibrations per second |", flush=True)
    taken_s = statistics.median(validated_s(arguments.validated) for _ in range(3))
    print(f"| `plan validate --table run`, {arguments.validated:,} runs | {taken_s:.1f} s |")
    load = os.getloadavg()[1]
    print(f"\n```text\n{os.cpu_count()} processors, load {load:.1f} in the last five minutes\n```")


if __name__ == "__main__":
    main()
