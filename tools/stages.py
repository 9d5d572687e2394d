#!/usr/bin/env python3
"""The stages of tools/test, in the order of how soon they tell something."""
import signal
import subprocess
import sys
from pathlib import Path

from runner import SKIPPED, Outcome, Stage, ctest, gate, pytest, read_junit, run_stages, skipped

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build"
MISSING = BUILD / "setup" / "missing"  # written by tools/setup: name, tab, reason
PYTHON = sys.executable
VIRTUAL = "not real_time and not toolchain"  # markers of tests/integration


def main(arguments):
    if "--help" in arguments:
        return show_help()
    full, named = "--full" in arguments, {name for name in arguments if not name.startswith("--")}
    stages = every_stage() if named and not full else plan("full" if full else "real" if "--real" in arguments else "")
    if unknown := named - {stage.name for stage in stages}:
        print(f"test: no such stage: {', '.join(sorted(unknown))}", file=sys.stderr)
        return 2
    stages = [stage for stage in stages if not named or stage.name in named]
    return run_stages(stages, BUILD / "test", read_missing(), timeout_s=4 * 3600 if full else 2400)


def show_help():
    print("usage: tools/test [--real|--full] [STAGE...]\n\nRun the tests: all stages, or those that are named.")
    shown = set()
    for title, kind in (("In virtual time", ""), ("With --real also", "real"), ("With --full also", "full")):
        print(f"\n{title}:")
        stages = plan(kind)
        for stage in stages:
            if stage.name not in shown:
                print(f"  {stage.name:<12} {stage.about}")
        shown |= {stage.name for stage in stages}
    return 0


def read_missing():
    lines = MISSING.read_text(encoding="utf-8").splitlines() if MISSING.exists() else []
    return dict(line.split("\t", 1) for line in lines)


def tool(*command):
    """One of tools/, as a gate."""
    return lambda log: gate(log, [PYTHON, *command])


def build(log, preset, *options):
    return gate(log, ["cmake", "--preset", preset, *options], ["cmake", "--build", "--preset", preset])


def build_sanitized(log):
    """The unit tests and the extension module, instrumented. Without Unity the extension alone."""
    tests = "OFF" if "Unity" in read_missing() else "ON"
    return build(log, "sanitizers", f"-DTUMBLE_TESTS={tests}", "-DTUMBLE_PYTHON=ON", f"-DPython_EXECUTABLE={PYTHON}")


def unit(log):
    built = build_sanitized(log)
    return ctest(log, BUILD / "sanitizers") if built.passed else built


def paths(preset):
    return f"{ROOT}/host/python/src:{BUILD / preset / 'python'}"


def package(chosen, *arguments, shared="worksteal"):
    """The tests of the package and of its programs that a marker chooses, shared out to the processors."""
    options = ("tests/integration", "-m", chosen, *arguments)
    return lambda log: pytest(log, *options, env={"PYTHONPATH": paths("host")}, shared=shared)


def realbus(log, *arguments):
    report = log.path.with_suffix(".xml")
    status = log.run(PYTHON, "tools/realbus.py", str(report), *arguments)
    if status == SKIPPED:
        return skipped(log.text().splitlines()[-1])
    outcome = read_junit(report) if report.exists() else Outcome()
    if status and not outcome.failed:
        outcome.failed = 1
    return outcome


def sanitized(full):
    chosen = "not full and not slow" if full else "not full and not slow and not python and not toolchain"

    def run(log):
        built = build_sanitized(log)
        if not built.passed:
            return built
        environment = sanitizer_environment()
        environment["ASAN_OPTIONS"] += f":log_path={log.path}"  # a worker that is ended takes its output along
        for report in reports(log):
            report.unlink()
        outcome = pytest(log, "tests/integration", "-m", chosen, env=environment, shared="worksteal")
        log.add(*(report.read_text(encoding="utf-8", errors="replace") for report in reports(log)))
        return outcome

    def reports(log):
        return sorted(log.path.parent.glob(f"{log.path.name}.*"))

    return run


def sanitizer_environment():
    """What makes an ordinary interpreter run an instrumented module. CPython leaks by design, so leaks are off. The
    sanitizer looks for C++'s exceptions when it starts, and other modules throw some (matplotlib's fonts do)."""
    libraries = " ".join(library(name) for name in ("libasan.so", "libstdc++.so.6"))
    return {"PYTHONPATH": paths("sanitizers"), "TUMBLE_PRESET": "sanitizers", "LD_PRELOAD": libraries,
            "ASAN_OPTIONS": "detect_leaks=0", "UBSAN_OPTIONS": "print_stacktrace=1"}


def library(name):
    """Where the compiler's own is."""
    command = ["cc", f"-print-file-name={name}"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def built_to_budget(preset, board):
    """Build a preset whose images are held to boards/budget.csv, and show what they use."""

    def run(log):
        built = build(log, preset)
        tables = sorted(map(str, (BUILD / preset / "boards" / board).glob("budget_*.csv")))
        return gate(log, ["cmake", "-E", "cat", *tables]) if built.passed else built

    return run


def target(log):
    """What runs on the target itself, which QEMU emulates."""
    built = build(log, "cortex-m4-tests")
    return ctest(log, BUILD / "cortex-m4-tests") if built.passed else built


def canaries(full):
    skip = [] if full else ["--ignore=tests/canary/test_analysis.py", "--ignore=tests/canary/test_fuzz.py"]
    return lambda log: pytest(log, "tests/canary", *skip)


def plan(kind):
    """The stages of a run: "" in virtual time, "real", "full"."""
    return [
        *first_stages(),
        *([] if kind == "full" else [integration()]),
        *(target_stages(kind) if kind else []),
        *(long_stages() if kind == "full" else []),
        *(last_stages(kind) if kind else []),
    ]


def every_stage():
    """Those that may be named without --full, the long ones too."""
    named = {stage.name: stage for stage in (*plan("full"), *plan("real"))}
    return list(named.values())


def first_stages():
    return [
        Stage("rooms", "who includes whom, what firmware may not use, sizes of files and functions",
              tool("tools/rooms.py"), light=True),
        Stage("objects", "object dictionaries, EDS files and their page are what their table says",
              tool("tools/objects/generate", "--check"), light=True),
        Stage("style", "layout of C by clang-format, Python by ruff, types of the package by mypy",
              tool("tools/style.py"), light=True),
        Stage("unit", "Unity tests of firmware and simulation, with AddressSanitizer and UndefinedBehaviorSanitizer",
              unit, ("Unity",), light=True),
    ]


def integration():
    return Stage("integration", "the package and the command line, C against numpy", package(VIRTUAL))


def target_stages(kind):
    """What needs other compilers, emulators, an index of packages."""
    return [
        Stage("cortex-m4", "the firmware for the target: warnings; code, RAM and stack within boards/budget.csv",
              built_to_budget("cortex-m4", "mps2_an386"), ("gcc-arm-none-eabi",)),
        Stage("zcu102", "the firmware for the Cortex-A53, bare metal: the same, and images for the emulator",
              built_to_budget("zcu102", "zcu102"), ("gcc-aarch64-linux-gnu",)),
        Stage("target", "on a Cortex-M4 in QEMU: the core's Unity tests, the same bits as here, painted stacks",
              target, ("gcc-arm-none-eabi", "qemu-system-arm", "Unity")),
        Stage("toolchains", "what other compilers and packagers make of it, and the emulated boards",
              package("toolchain and not real_time", *(["--full"] if kind == "full" else []))),
        Stage("sanitized", "the package's tests that run C code and are not slow, with that code instrumented",
              sanitized(kind == "full")),
    ]


def long_stages():
    return [
        Stage("campaigns", "the package and the command line, C against numpy, the long versions",
              package(VIRTUAL, "--full")),
        Stage("mutation", "small defects of firmware and simulation: no fewer are found than tools/mutation.json has",
              tool("tools/mutation", "--check"), ("Unity",)),
        Stage("misra", "MISRA C of all firmware, by cppcheck; deviations: tools/misra_deviations.txt",
              tool("tools/analyse.py", "misra")),
        Stage("tidy", "clang-tidy of all firmware: bugprone, cert, clang-analyzer",
              tool("tools/analyse.py", "tidy"), ("clang-tidy-19",)),
        Stage("analyzer", "gcc -fanalyzer of all firmware", tool("tools/analyse.py", "analyzer")),
        Stage("bare", "every command of README and pages, on a bare Debian 12 that debootstrap makes",
              tool("tools/trial"), ("debootstrap",)),
        Stage("fuzz", "libFuzzer on all that comes from outside: block frames, CANopen, the whole computer",
              tool("tools/fuzz.py"), ("clang-19",)),
    ]


def last_stages(kind):
    """The canaries, which build where the stages before have built; and what is in real time."""
    full = ["--full"] if kind == "full" else []
    return [
        Stage("canaries", "a planted defect for every gate, which must reject it", canaries(kind == "full")),
        Stage("realtime", "programs that talk to each other in real time: gateway, guests on the bench, emulated board",
              package("real_time", *full, shared="loadfile")),
        Stage("realbus", "tumble-node and tumble-stand on CAN interfaces, in user-mode Linux where there are none",
              lambda log: realbus(log, *full)),
    ]


if __name__ == "__main__":
    # Whoever is started in the background ignores interrupts, and so would all that the tests interrupt.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
