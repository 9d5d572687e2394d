"""Campaigns by several workers: how much sooner, at what cost, and the same bits.

    tools/benchmark scaling [--table] [--rounds N] [--cluster-runs N]

The first table: seconds by the clock, and of the processor (all processes together), of 1, 2 and 4 workers, measured by
turns, each over those of one worker in the same round; medians of the rounds. The second: `tumble plan validate` on a
local cluster of two workers of Dask's, whole, with a worker killed in the middle, and in one process; the documents
must be the same bytes. The third: what a run and a piece cost those who hand them out. Needs dask and pyarrow.
"""

import argparse
import hashlib
import os
import pickle
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np

from tumble.planning.case import Case
from tumble.planning.validate import _Tallied, errors_of
from tumble.solving.many_runs import chunks
from tumble.workers.over import Piece, Team, over

EXIT_SKIPPED = 77
TUMBLE = [sys.executable, "-m", "tumble"]
VALIDATE = ["plan", "validate", "--json"]
SCALED = {
    "`plan validate --table run`, 60,000 runs": [*VALIDATE, *"--estimator optimal --table run --runs 60000".split()],
    "`campaign runs`, 4,000 calibrations": ["campaign", "runs", "--runs", "4000"],
    "`campaign lives`, 2,000 lives": ["campaign", "lives", "--lives", "2000"],
}
WORKERS = (1, 2, 4)
EMPTY = 2000


def timed(arguments):
    """(seconds by the clock, of the processor, SHA-256 of what it prints) of a command."""
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run([*TUMBLE, *arguments], stdout=subprocess.PIPE, check=False)
    wall_s, after = time.monotonic() - started, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        raise SystemExit(f"tumble {' '.join(arguments)}: exit {done.returncode}")
    cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall_s, cpu_s, hashlib.sha256(done.stdout).hexdigest()


def scaling(rounds):
    """Lines of the first table."""
    yield "| workers | " + " | ".join(f"{count}: clock, processor" for count in WORKERS) + " |"
    yield "|---|" + "---|" * len(WORKERS)
    for name, arguments in SCALED.items():
        ratios = {count: [] for count in WORKERS}
        for _ in range(rounds):
            found = {count: timed([*arguments, "--workers", str(count)]) for count in WORKERS}
            if "lives" not in arguments and len({digest for *_, digest in found.values()}) != 1:
                raise SystemExit(f"{name}: the number of workers changes the result")
            for count, (wall_s, cpu_s, _) in found.items():
                ratios[count].append((wall_s / found[1][0], cpu_s / found[1][1], wall_s, cpu_s))
        cells = []
        for count in WORKERS:
            clock, processor, wall_s, cpu_s = map(statistics.median, zip(*ratios[count]))
            cells.append(f"{wall_s:.1f}, {cpu_s:.1f} s" if count == 1 else f"{clock:.2f}, {processor:.2f}")
        yield f"| {name} | {' | '.join(cells)} |"


def on_cluster(runs, cluster):
    """Lines of the second table."""
    validated = [*VALIDATE, "--runs", str(runs)]
    yield f"| `plan validate --runs {runs}` | clock | document |"
    yield "|---|---|---|"
    digests = set()
    for name, options, kills in (
        ("one process", [], False),
        ("two workers", ["--cluster", cluster.scheduler_address], False),
        ("two workers, one killed", ["--cluster", cluster.scheduler_address], True),
    ):
        killed = []
        killer = threading.Thread(target=kill_in_the_middle, args=(cluster, runs // 4000, killed))
        if kills:
            killer.start()
        wall_s, _, digest = timed([*validated, *options])
        if kills:
            killer.join()
        digests.add(digest)
        done = f", process {len(killed)} of 1 by SIGKILL" if kills else ""
        yield f"| {name}{done} | {wall_s:.0f} s | {digest[:12]} |"
    if len(digests) != 1:
        raise SystemExit("the cluster gives another document")


def kill_in_the_middle(cluster, pieces, killed):
    """When half of the pieces have been given back, kill a worker that has one."""
    seen = set()
    until = time.monotonic() + 3600
    while time.monotonic() < until:
        tasks = list(cluster.scheduler.tasks.items())
        seen |= {name for name, _ in tasks}
        busy = [one.name for one in list(cluster.scheduler.workers.values()) if one.processing]
        if len(seen) > pieces and busy:
            killed.append(cluster.workers[busy[0]].pid)
            os.kill(killed[0], signal.SIGKILL)
            return
        time.sleep(0.02)


def nothing(_):
    """An empty job."""
    return {"nothing": np.zeros(1)}


def per_second(crew):
    """Empty pieces."""
    with Team(crew) as team:
        list(over([Piece("first", 0)], nothing, team))
        started = time.monotonic()
        list(over((Piece(str(number), number) for number in range(EMPTY)), nothing, team))
        return EMPTY / (time.monotonic() - started)


def costs(cluster):
    """Lines of the third table: sizes are exact, seconds are those of this machine."""
    from tumble.workers.crews import Cluster, Processes
    from tumble.workers.over import Kept

    case, runs = Case.of(None, None, None), 40_000
    job = _Tallied(case, ("averaged", "refined", "least_squares", "optimal"), "known")
    started = time.process_time()
    pieces = list(chunks(errors_of(case, case.nominal_k()), case.stand.limits, runs, 1))
    walk_s = time.process_time() - started
    yield "| what | measured |"
    yield "|---|---|"
    yield f"| a job (`plan validate`, four estimators), pickled | {len(pickle.dumps(job))} B |"
    yield f"| what a piece of 2,000 runs says, pickled | {len(pickle.dumps(pieces[1].what))} B |"
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "done.parquet")
        started = time.process_time()
        with Team(kept=Kept(file, {"campaign": "costs"})) as team:
            results = list(over(pieces, job, team))
        work_s = time.process_time() - started
        size = Path(file).stat().st_size / len(pieces)
    yield f"| what it leaves, pickled; as Parquet | {len(pickle.dumps(results[1]))} B; {size:.0f} B |"
    yield f"| processor for a run, by the worker | {1e6 * work_s / runs:.1f} us |"
    yield f"| processor for a run, by whoever cuts the stream | {1e6 * walk_s / runs:.2f} us |"
    yield f"| empty pieces a second by two processes | {per_second(Processes(2)):.0f} |"
    yield f"| empty pieces a second by two workers of Dask's | {per_second(Cluster(cluster.scheduler_address)):.0f} |"


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Campaigns by several workers.")
    parser.add_argument("--table", action="store_true", help="the tables of docs/performance.md; also the default")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--cluster-runs", type=int, default=1_000_000)
    arguments = parser.parse_args()
    try:
        from distributed import LocalCluster
    except ImportError:
        print("scaling: needs distributed", file=sys.stderr)
        return EXIT_SKIPPED
    print("\n".join(scaling(arguments.rounds)), end="\n\n", flush=True)
    options = {"threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": "CRITICAL"}
    with LocalCluster(n_workers=2, **options) as cluster:
        print("\n".join(costs(cluster)), end="\n\n", flush=True)
        print("\n".join(on_cluster(arguments.cluster_runs, cluster)), flush=True)
    load = os.getloadavg()[1]
    print(f"\n```text\n{os.cpu_count()} processors, load {load:.1f} in the last five minutes\n```")
    return 0


if __name__ == "__main__":
    sys.exit(main())
