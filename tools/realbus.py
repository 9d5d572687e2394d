#!/usr/bin/env python3
"""Run tests/realbus on virtual CAN interfaces: here, as root where the kernel has vcan, else inside user-mode Linux,
each file of tests in a machine of its own, as many side by side as there are processors. A test that failed there while
its processor was busy is run once more, when no other machine is beside it.

Exit 0 passed, 1 failed, 77 neither is to be had: the last line says why.
"""
import argparse
import os
import shlex
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / part) for part in ("host/python/src", "build/host/python")]

from tumble.errors import TumbleError  # noqa: E402
from tumble.world import uml  # noqa: E402

SKIPPED = 77
TOOLS = {"candump": "can-utils", "cangen": "can-utils", "ip": "iproute2"}
PROBE = "vcan999"
MEMORY_MB = 768
PRINTING = threading.Lock()
TESTS_FAILED, NO_END = 1, 3  # exit codes: pytest's, and of a machine that could not run it
TIMEOUT_S = {False: 1800.0, True: 3600.0}  # with --full, or not


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("report", metavar="REPORT.xml", type=Path, help="pytest's report, to be written")
    parser.add_argument("chosen", metavar="...", nargs=argparse.REMAINDER, help="arguments of pytest; default: none")
    asked = parser.parse_args(arguments)
    report, chosen = asked.report.resolve(), asked.chosen
    report.unlink(missing_ok=True)
    lacking = {package for tool, package in TOOLS.items() if shutil.which(tool, path=search_path()) is None}
    if lacking:
        print(f"tests on CAN interfaces need {', '.join(sorted(lacking))}")
        return SKIPPED
    if has_vcan():
        return subprocess.run(command(report, chosen), cwd=ROOT, env=environment(), check=False).returncode
    if (reason := uml.missing()) is not None:
        print(f"no virtual CAN interface here, and no user-mode Linux: {reason}")
        return SKIPPED
    return in_machines(report, chosen)


def search_path():
    return f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin"


def has_vcan():
    made = subprocess.run(["ip", "link", "add", "dev", PROBE, "type", "vcan"], capture_output=True, check=False,
                          env={**os.environ, "PATH": search_path()})
    if made.returncode == 0:
        subprocess.run(["ip", "link", "del", PROBE], check=False, env={**os.environ, "PATH": search_path()})
    return made.returncode == 0


def command(report, chosen):
    folder = [] if any(word.startswith("tests/") for word in chosen) else ["tests/realbus"]
    return [sys.executable, "-m", "pytest", "-q", "-ra", "--durations=10", f"--junitxml={report}", *folder, *chosen]


def environment():
    return {**os.environ, "PATH": search_path(), "PYTHONDONTWRITEBYTECODE": "1",
            "PYTHONPATH": f"{ROOT}/host/python/src:{ROOT}/build/host/python"}


def in_machines(report, chosen):
    """Side by side; the largest file, which takes longest, first."""
    files = [] if any(word.startswith("tests/") for word in chosen) else (ROOT / "tests/realbus").glob("test_*.py")
    parts = [[str(file.relative_to(ROOT))] for file in sorted(files, key=lambda file: -file.stat().st_size)] or [[]]
    whole = ElementTree.Element("testsuites")
    with ThreadPoolExecutor(os.cpu_count()) as machines:
        codes = list(machines.map(lambda part: in_uml(whole, [*part, *chosen]), parts))
    if held_up := [name for name, case in last_of(whole).items() if failed(case) and ran_again(case)]:
        codes.append(in_uml(whole, [*held_up, *(word for word in chosen if word.startswith("--"))]))
        for name in held_up:
            tell_again(last_of(whole)[name], "it failed beside another machine, and was run alone")
    ElementTree.ElementTree(whole).write(report)
    others = [code for code in codes if code != TESTS_FAILED]
    return max([TESTS_FAILED if any(map(failed, last_of(whole).values())) else 0, *others])


def last_of(whole):
    """Each test as it was run last, by the name that pytest takes."""
    cases = whole.iter("testcase")
    return {f"tests/realbus/{case.get('classname')}.py::{case.get('name')}": case for case in cases}


def failed(case):
    return case.find("failure") is not None or case.find("error") is not None


def ran_again(case):
    """Its processor was busy every time (tests/lib/busy_machine.py)."""
    return any(told.get("name") == "ran again" for told in case.iter("property"))


def tell_again(case, why):
    told = case.find("properties")
    told = ElementTree.SubElement(case, "properties") if told is None else told
    ElementTree.SubElement(told, "property", name="ran again", value=why)


def in_uml(whole, chosen):
    """Exit code of pytest in a machine of its own; what it reports goes into the whole."""
    with uml.work_folder() as name:
        folder = Path(name)
        words = shlex.join(command(folder / "report.xml", chosen))
        settings = shlex.join(f"{key}={value}" for key, value in environment().items()
                              if key.startswith("PYTHON") or key == "PATH")
        (folder / "tmp").mkdir()
        settings += f" TMPDIR={folder}/tmp HOME=/run"
        job = (f"mount -t tmpfs tmpfs {folder}/tmp\n"
               f"cd {shlex.quote(str(ROOT))} && env {settings} {words} >{folder}/output 2>&1\n")
        try:
            code, complaint = uml.run(job, folder, memory_mb=MEMORY_MB, timeout_s=TIMEOUT_S["--full" in chosen]), ""
        except TumbleError as error:
            code, complaint = NO_END, f"{shlex.join(chosen)}: {error}"
        output = folder / "output"
        with PRINTING:
            print(output.read_text(errors="replace") if output.exists() else "", complaint, flush=True)
            if (folder / "report.xml").exists():
                whole.extend(ElementTree.parse(folder / "report.xml").getroot())
        return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
