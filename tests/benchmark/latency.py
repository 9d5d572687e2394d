"""How long tumble-node takes in real time, from a frame's arrival in the kernel to its answer on the bus.

    tools/benchmark latency [--requests N] [--period-ms T] [--busy N] [--flood N] [--json | --table]

tumble-node and tumble-stand run as built, without an option of their own, while the node averages the samples of the
simulated block. A client of the node's second SDO server reads 2003h at random moments. It takes both stamps from the
kernel, of its request and of the answer: so a figure contains the node's waking, the whole step that handles the frame,
up to the moment at which the kernel has the answer. That is more than from frame to step, never less.

Beside it, asked in turn in the same run, the least that can answer: a loop of read and write (latency/echo.c) on an
interface of its own. Its figures are what this kernel takes to wake a process; the ratio is the node's to it. Requests
do not wait for answers, so a process that is held up is asked as often as one that is not; one without an answer counts
as later than all others, and stands under "lost".

Each condition has its own node: without load, with a bus load by cangen, with busy processes, with both, and with both
while node and echo have the real-time priority of the service file (docs/gateway.md). What is outside of a real node
(the stand, the client, cangen) has a higher priority in each, since a frame from outside is an interrupt. It shares the
processors with the node all the same. In user-mode Linux that is one processor, and system calls cost ten times as
much as elsewhere; its clock leaves out what the machine outside holds it up beyond 10 ms at a time: how much that was
is printed. Needs root and vcan, or user-mode Linux, can-utils and a C compiler, or exit 77.
"""

import argparse
import json
import math
import os
import resource
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in ("tools", "tests/lib", "tests/integration", "tests/realbus")]

from busy_machine import processors  # noqa: E402
from latency_run import CONDITIONS, measure  # noqa: E402
from realbus import environment, has_vcan, search_path  # noqa: E402

from tumble.errors import TumbleError  # noqa: E402
from tumble.world import uml  # noqa: E402

HELPERS = ("ask", "echo")
TOOLS = ("cc", "cangen", "chrt", "ip")
SHARES = {"50 %": 500, "90 %": 900, "99 %": 990, "99.9 %": 999, "max": 1000}  # of 1000
PROGRAMS = ("node", "echo")
NOT_THERE = 77


def main():
    """Measure and print."""
    options = parse(sys.argv[1:])
    if options.here:
        Path(options.here, "found.json").write_text(json.dumps(measure(vars(options), Path(options.here))))
        return 0
    if (lacking := missing()) is not None:
        print(lacking, file=sys.stderr)
        return NOT_THERE
    try:
        found = run(options)
    except TumbleError as error:
        print(error, file=sys.stderr)
        return 1
    if options.json:
        print(json.dumps(summary(found)))
    else:
        print(*(page_lines(found) if options.table else table_lines(found)), sep="\n")
    return 0


def parse(arguments):
    parser = argparse.ArgumentParser(description="Measure the latency of tumble-node in real time.")
    for name, kind, least, most, default, about in (
        ("--requests", int, 1, 1_000_000, 5000, "to each program in each condition"),
        ("--period-ms", float, 0.1, 1000.0, 4.0, "between them, on average"),
        ("--busy", int, 0, 100, 2, "busy processes beside it"),
        ("--flood", int, 1, 10_000, 1000, "frames a second asked of cangen"),
    ):
        parser.add_argument(name, type=limited(kind, least, most), default=default, help=f"{about} (default {default})")
    parser.add_argument("--conditions", nargs="+", choices=CONDITIONS, default=list(CONDITIONS), metavar="NAME",
                        help=f"some of: {', '.join(CONDITIONS)}")
    parser.add_argument("--here", metavar="FOLDER", help=argparse.SUPPRESS)  # on this kernel's interfaces, as root
    shape = parser.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true")
    shape.add_argument("--table", action="store_true", help="as docs/performance.md has it")
    return parser.parse_args(arguments)


def limited(kind, least, most):
    """A type for argparse."""

    def read(text):
        value = kind(text)
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text} is not from {least} to {most}")
        return value

    read.__name__ = kind.__name__  # in the complaint about what is no number
    return read


def missing():
    """What keeps it from running here, or None."""
    lacking = [tool for tool in TOOLS if shutil.which(tool, path=search_path()) is None]
    if lacking:
        return f"not there: {', '.join(lacking)}"
    reason = None if has_vcan() else uml.missing()
    return f"no virtual CAN interface here, and no user-mode Linux: {reason}" if reason else None


def run(options):
    """What latency_run.measure found, and "outside", the machine: "taken_s" by its clock (None without user-mode
    Linux), its "processors", and the shares of their time that were "idle" and that "others" had."""
    with uml.work_folder() as name:
        folder = Path(name)
        build(folder)
        before, own = processors(), own_s()
        taken_s = here(options, folder) if has_vcan() else in_uml(options, folder)
        spent = {name: ticks - before[name] for name, ticks in processors().items()}
        own = (own_s() - own) * os.sysconf("SC_CLK_TCK")
        found = json.loads((folder / "found.json").read_text())
    shares = {"idle": spent["idle"] / spent["all"], "others": (spent["all"] - spent["idle"] - own) / spent["all"]}
    return {**found, "outside": {"taken_s": taken_s, "processors": os.cpu_count(), **shares}}


def own_s():
    """Processor time of this process and of the children that have ended."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def build(folder):
    """The programs ask and echo."""
    for name in HELPERS:
        source = ROOT / f"tests/benchmark/latency/{name}.c"
        subprocess.run(["cc", "-std=c11", "-O2", source, "-o", folder / name], check=True)


def command(options, folder):
    settings = {"requests": options.requests, "period-ms": options.period_ms, "busy": options.busy,
                "flood": options.flood, "here": folder}
    words = [word for name, value in settings.items() for word in (f"--{name}", str(value))]
    return [sys.executable, __file__, *words, "--conditions", *options.conditions]


def here(options, folder):
    """On this kernel, whose clock leaves out nothing."""
    subprocess.run(command(options, folder), env=environment(), check=True)


def in_uml(options, folder):
    """In user-mode Linux. Returns how long the measurement took by this machine's clock, s."""
    seen = {}

    def look():
        for mark in ("began", "ended"):
            if mark not in seen and (folder / mark).exists():
                seen[mark] = time.monotonic()

    given = {name: value for name, value in environment().items() if name == "PATH" or name.startswith("PYTHON")}
    settings = shlex.join(f"{name}={value}" for name, value in (given | {"HOME": "/run", "TMPDIR": "/run"}).items())
    words = shlex.join(map(str, command(options, folder)))
    job = f"cd {shlex.quote(str(ROOT))} && env {settings} {words} >{folder}/output 2>&1\n"
    if uml.run(job, folder, on_tick=look, memory_mb=256) != 0:
        raise SystemExit((folder / "output").read_text(errors="replace")[-2000:])
    return seen["ended"] - seen["began"]


def percentile(ordered, share):
    """The least of `ordered` that at least share/1000 of them do not exceed (nearest rank)."""
    rank = -(-len(ordered) * share // 1000)
    return ordered[max(rank, 1) - 1]


def latencies_us(pairs):
    """[(asked_ns, answered_ns)] in ascending order, us; infinite where there was no answer."""
    return sorted((answered - asked) / 1e3 if answered else math.inf for asked, answered in pairs)


def figures(pairs):
    """{"50 %": us, ..., "lost": requests}; a percentile is None where so many had no answer."""
    ordered = latencies_us(pairs)
    found = {name: percentile(ordered, share) for name, share in SHARES.items()}
    told = {name: value if math.isfinite(value) else None for name, value in found.items()}
    return told | {"lost": sum(map(math.isinf, ordered))}


def summary(found):
    """What --json prints: figures in us for what was stamped."""
    conditions = [
        {**condition, **{name: figures(condition[name]) for name in PROGRAMS}} for condition in found["conditions"]
    ]
    return {**found, "conditions": conditions}


def rows(found):
    """(condition, what, cells) of the table: us of node and echo, and the ratio."""
    for condition in summary(found)["conditions"]:
        node, echo = (condition[name] for name in PROGRAMS)
        for name, one in zip(PROGRAMS, (node, echo)):
            yield condition["name"], name, [whole(one[share]) for share in SHARES] + [str(one["lost"])]
        yield condition["name"], "ratio", [ratio(node[share], echo[share]) for share in SHARES] + [""]


def whole(value):
    return "none" if value is None else f"{value:,.0f}"


def ratio(ours, theirs):
    return "" if ours is None or theirs is None else f"{ours / theirs:.1f}"


def table_lines(found):
    """As text, at most 80 columns."""
    yield f"{'us from request to answer':25}" + "".join(f"{name:>10}" for name in SHARES) + f"{'lost':>5}"
    for condition, what, cells in rows(found):
        name = condition if what == "node" else ""
        yield f"{name:19}{what:6}" + "".join(map("{:>10}".format, cells[:-1])) + f"{cells[-1]:>5}"
    yield ""
    yield from machine_lines(found)


def page_lines(found):
    """As docs/performance.md has it."""
    yield "| us from request to answer | | " + " | ".join(SHARES) + " | lost |"
    yield "|---|---|" + "---|" * (len(SHARES) + 1)
    for condition, what, cells in rows(found):
        yield f"| {condition if what == 'node' else ''} | {what} | {' | '.join(cells)} |"
    yield from ("", "```text", *machine_lines(found), "```")


def machine_lines(found):
    """On what, with what load."""
    outside, count = found["outside"], found["processors"]
    where = "Linux" if outside["taken_s"] is None else "user-mode Linux"
    yield f"{where} {found['kernel']}, {count} processor{'s' * (count > 1)}; on a machine of {outside['processors']},"
    yield f"of whose time others had {max(0.0, outside['others']):.0%}, and {outside['idle']:.0%} was idle"
    if outside["taken_s"] is not None:
        left_out_s = max(outside["taken_s"] - found["inside_s"], 0.0)
        yield f"its clock left out {left_out_s:.0f} of {outside['taken_s']:.0f} s"
    for one in found["conditions"]:
        yield (f"{one['name'] + ':':20}{one['requests']} requests to each; {one['frames_per_s']:.0f} frames/s,"
               f" {one['bus_load']:.0%} of 500 kbit/s")
        if one["samples_lost"] or one["kernel_dropped"]:
            yield f"{'':20}lost by the node: {one['samples_lost']} samples, {one['kernel_dropped']} frames"
        if one["ended_by"] is not None:
            yield f"{'':20}the node's run ended early: {one['ended_by']}"


if __name__ == "__main__":
    sys.exit(main())
