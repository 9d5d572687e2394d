"""Running stages of tests, counting what they say, and telling a person how it went."""
import os
import re
import subprocess
import sys
import textwrap
import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from xml.etree import ElementTree

SKIPPED = 77  # exit status of a command that could not do its check
TAIL_LINES = 40
TAIL_CHARACTERS = 200  # of each
PROGRESS_S = 2
CLEAR = "\r\033[K"  # the line of a terminal
BROKEN_CHARACTERS = 2000  # of why a test failed


@dataclass
class Outcome:
    """Tests of one stage, and why some of them were skipped."""
    passed: int = 0
    failed: int = 0
    skipped: int = 0
    reasons: Counter = field(default_factory=Counter)
    broken: list = field(default_factory=list)  # tests that failed, and why
    again: list = field(default_factory=list)  # tests in real time that ran again, and why

    @property
    def verdict(self):
        if self.failed or not (self.passed or self.skipped):
            return "FAILED"
        return "passed" if self.passed else "SKIPPED"


def skipped(reason):
    return Outcome(skipped=1, reasons=Counter([reason]))


@dataclass
class Stage:
    name: str
    about: str
    run: Callable  # run(log) -> Outcome
    needs: tuple = ()  # names of what tools/setup could not always install
    light: bool = False  # leaves processors idle: runs side by side with its light neighbours


class Log:
    """The log file of one stage, and the commands that write to it."""

    def __init__(self, path, timeout_s):
        self.path = path
        self._timeout_s = timeout_s
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.write_text("", encoding="utf-8")

    def run(self, *command, env=None):
        """Exit status of a command; what it prints goes to the log. A command that hangs counts as failed."""
        with open(self.path, "a", encoding="utf-8") as file:
            print("$", *command, file=file, flush=True)
            try:
                return subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                      env={**os.environ, **(env or {})}, timeout=self._timeout_s).returncode
            except subprocess.TimeoutExpired:
                print(f"no end after {self._timeout_s} s: stopped", file=file)
            except OSError as error:
                print(error, file=file)
            return 1

    def add(self, *lines):
        with open(self.path, "a", encoding="utf-8") as file:
            print(*lines, sep="\n", file=file)

    def text(self):
        return self.path.read_text(encoding="utf-8", errors="replace")

    def tail(self):
        return "\n".join("    " + line[:TAIL_CHARACTERS] for line in self.text().splitlines()[-TAIL_LINES:])


def gate(log, *commands, env=None):
    """One test: all of the commands, in order, must succeed. Exit status 77 of the last one run skips it."""
    for command in commands:
        status = log.run(*command, env=env)
        if status == SKIPPED:
            return skipped(log.text().splitlines()[-1])
        if status:
            return Outcome(failed=1)
    return Outcome(passed=1)


def pytest(log, *arguments, env=None, shared=None):
    """The tests that pytest ran, from its own report. `shared`: on every processor, shared out as xdist does by that
    name; numpy then has one thread for each. Many start Python, which compiles the package each time where the caller
    wants no bytecode."""
    report = log.path.with_suffix(".xml")
    report.unlink(missing_ok=True)
    command = [sys.executable, "-m", "pytest", "-q", "-ra", f"--junitxml={report}",
               "-o", "console_output_style=count"]
    env = {**(env or {}), "PYTHONDONTWRITEBYTECODE": ""}
    if shared is not None:
        command += ["-n", str(os.cpu_count()), "--dist", shared]
        env["OPENBLAS_NUM_THREADS"] = "1"
    status = log.run(*command, *arguments, env=env)
    outcome = read_junit(report) if report.exists() else Outcome()
    if status and not outcome.failed:  # crashed, interrupted, or found no test
        outcome.failed = 1
    return outcome


def read_junit(report):
    outcome = Outcome()
    cases = {(case.get("classname"), case.get("name")): case for case in ElementTree.parse(report).iter("testcase")}
    for (_, name), case in cases.items():  # of one that ran again, the last
        skip = case.find("skipped")
        outcome.again += [f"{name}: {told.get('value')}" for told in case.iter("property")
                          if told.get("name") == "ran again"]
        failure = next((found for kind in ("failure", "error") if (found := case.find(kind)) is not None), None)
        if failure is not None:
            outcome.failed += 1
            outcome.broken.append(f"{name}: {what_failed(failure)}")
        elif skip is not None:
            outcome.skipped += 1
            outcome.reasons[skip.get("message", "no reason given")] += 1
        else:
            outcome.passed += 1
    return outcome


def what_failed(failure):
    """What pytest marks with E in its account of a failure. The message beside it is cut: it may lack the assertion."""
    marked = [line[1:] for line in (failure.text or "").splitlines() if re.match(r"E(\s|$)", line)]
    return textwrap.dedent("\n".join(marked)).strip() or failure.get("message", "no reason given")


def ctest(log, directory):
    """The cases that the Unity programs of a build directory ran; a program that crashed counts as one failure."""
    status = log.run("ctest", "--test-dir", str(directory), "--no-tests=error", "--verbose", "-j", str(os.cpu_count()))
    text = log.text()
    totals = [tuple(map(int, line)) for line in re.findall(r"(\d+) Tests (\d+) Failures (\d+) Ignored", text)]
    ran, failed, ignored = (sum(column) for column in zip(*totals)) if totals else (0, 0, 0)
    programs_failed = re.search(r"(\d+) tests? failed out of", text)
    outcome = Outcome(ran - failed - ignored, max(failed, int(programs_failed[1]) if programs_failed else 0), ignored)
    for name in re.findall(r"Test +#\d+: (\S+) \.*\*\*\*Skipped", text):
        outcome.skipped += 1
        outcome.reasons[f"{name} skipped itself"] += 1
    if status and not outcome.failed:
        outcome.failed = 1
    if outcome.failed:
        log.add("Failed:", *re.findall(r"^\d+: (.*:FAIL.*)$", text, re.MULTILINE))
    return outcome


def run_stages(stages, log_folder, missing=None, timeout_s=1800):
    """Run the stages, print their results, and return the exit status: 0 only if something passed and nothing failed.

    `missing` maps the name of a thing that could not be installed to the reason.
    """
    missing = missing or {}
    print(f"{len(stages)} stages, logs in {os.path.relpath(log_folder)}:")
    for stage in stages:
        print(f"  {stage.name:12} {stage.about}")
    print(flush=True)
    total = Outcome()
    for group in side_by_side(stages):
        with progress(group, log_folder, sys.stdout), ThreadPoolExecutor(len(group)) as pool:
            # Of a stage alone an interrupt must end the command, which it does in this thread only.
            each = pool.map if len(group) > 1 else map
            ran = each(lambda stage: run_stage(stage, log_folder, missing, timeout_s), group)
            for stage, told in zip(group, ran, strict=True):
                add_up(total, stage, *told)
    for told in total.broken:
        print(f"\nFAILED: {without_middle(told, BROKEN_CHARACTERS)}")
    print(f"\n{total.passed} passed, {total.failed} failed, {total.skipped} skipped")
    return 0 if total.verdict == "passed" else 1


@contextmanager
def progress(group, log_folder, out):
    """At a terminal, a line that says every few seconds what runs, and how far it is; elsewhere nothing."""
    if not out.isatty():
        yield
        return
    begin, ended = time.monotonic(), threading.Event()

    def show():
        while not ended.wait(PROGRESS_S):
            running = ", ".join(stage.name + how_far(Path(log_folder) / f"{stage.name}.log") for stage in group)
            out.write(f"{CLEAR}  {time.monotonic() - begin:.0f} s: {running}")
            out.flush()

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        out.write(CLEAR)


def how_far(path):
    """What pytest, ctest or Ninja last said of it in a log, such as " 12/80", with what pytest has done since, a sign
    for each test; empty if none did."""
    end = path.read_text(encoding="utf-8", errors="replace")[-4000:] if path.exists() else ""
    told = re.findall(r"(?:\[|^) *(\d+)/(\d+)(?:\]| Test)", end, re.MULTILINE)
    since = re.search(r"(?:^[.sxXFER]+)?\Z", end, re.MULTILINE)
    return f" {int(told[-1][0]) + len(since[0])}/{told[-1][1]}" if told else ""


def side_by_side(stages):
    """Lists of stages that run at the same time."""
    for light, neighbours in groupby(stages, key=lambda stage: stage.light):
        neighbours = list(neighbours)
        yield from [neighbours] if light else ([stage] for stage in neighbours)


def add_up(total, stage, outcome, seconds, log):
    """Print how a stage went, and count it."""
    report(stage, outcome, seconds, log)
    total.passed += outcome.passed
    # A stage in which no test ran at all has failed, and the sum must say so.
    total.failed += outcome.failed or (outcome.verdict == "FAILED")
    total.skipped += outcome.skipped
    total.broken += [f"{stage.name}: {told}" for told in outcome.broken]


def run_stage(stage, log_folder, missing, timeout_s):
    """Outcome, seconds and log of a stage."""
    begin = time.monotonic()
    log = Log(Path(log_folder) / f"{stage.name}.log", timeout_s)
    lacking = [f"{need} is not installed ({missing[need]})" for need in stage.needs if need in missing]
    outcome = skipped(lacking[0]) if lacking else stage.run(log)
    return outcome, time.monotonic() - begin, log


def without_middle(told, most):
    """So many characters of its begin and its end: what was asserted stands behind what the test had to say of it."""
    if len(told) <= most:
        return told
    half = most // 2
    return f"{told[:half]}\n[... {len(told) - 2 * half} characters ...]\n{told[-half:]}"


def shortened(told):
    """The first line and the last of what a test said when it failed."""
    lines = told.splitlines()
    return lines[0] if len(lines) == 1 else f"{lines[0]} [...] {lines[-1].strip()}"


def report(stage, outcome, seconds, log):
    counts = f"{outcome.passed} passed"
    if sys.stdout.isatty():
        print(CLEAR, end="")
    counts += f", {outcome.failed} failed" if outcome.failed else ""
    counts += f", {outcome.skipped} skipped" if outcome.skipped else ""
    print(f"{outcome.verdict:8} {stage.name:12} {seconds:7.1f} s  {counts}")
    for reason, times in outcome.reasons.items():
        print(f"         SKIPPED: {reason}" + (f" ({times} times)" if times > 1 else ""))
    for told in outcome.again:
        print(f"         RAN AGAIN: {shortened(told)}")
    if outcome.verdict == "FAILED":
        print(f"  the end of {os.path.relpath(log.path)}:\n{log.tail()}")
    sys.stdout.flush()
