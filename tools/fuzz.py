#!/usr/bin/env python3
"""Fuzzing the seams of the firmware: builds the targets of tests/fuzz and lets libFuzzer run on each for a while.

    fuzz.py [--seconds N] [TARGET...]     exit 1 when something is found, 77 when clang's libFuzzer is not there

Every run begins with the seeds of tests/fuzz/seeds, which also hold every input that once failed; what is found beyond
them stays in build/fuzz/corpus/TARGET for the next run. An input that fails is left in build/fuzz and named.
"""
import argparse
import hashlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build/fuzz"
TARGETS = ["block_frames", "canopen", "navcomp"]
SECONDS = 20
LONGEST = 320  # bytes of an input
COMPILER = "clang-19"
FOUND, NOT_THERE = 1, 77


def main(arguments):
    parser = argparse.ArgumentParser(prog="fuzz.py")
    parser.add_argument("--seconds", type=int, default=SECONDS)
    parser.add_argument("target", nargs="*", choices=[*TARGETS, []], metavar="TARGET")
    options = parser.parse_args(arguments)
    if (lacking := what_lacks()) is not None:
        print(f"{lacking} is not installed")
        return NOT_THERE
    targets = options.target or TARGETS
    if not build(*(f"fuzz_{target}" for target in targets)):
        return FOUND
    # All of them, even when one has found something.
    return FOUND if [target for target in targets if not fuzz(target, options.seconds)] else 0


def what_lacks():
    """What stands in the way of a build: a name, or None."""
    if shutil.which(COMPILER) is None:
        return COMPILER
    source = "int LLVMFuzzerTestOneInput(const char *data, unsigned long size) { return data == 0 && size > 0; }"
    linked = subprocess.run([COMPILER, "-fsanitize=fuzzer,address", "-xc", "-", "-o", "/dev/null"], input=source,
                            text=True, capture_output=True)
    return f"libFuzzer of {COMPILER}" if linked.returncode else None


def build(*programs):
    configured = run("cmake", "--preset", "fuzz") == 0
    return configured and run("cmake", "--build", BUILD, "--target", *programs) == 0


def fuzz(target, seconds):
    """True: nothing was found."""
    program = f"fuzz_{target}"
    return run(*command(target, program, seconds, BUILD / "corpus" / target)) == 0


def command(target, program, seconds, corpus):
    """Of a run that ends by itself after `seconds` with status 0, or when something is found with another one."""
    return [BUILD / "tests/fuzz" / program, f"-max_total_time={seconds}", f"-max_len={LONGEST}",
            "-entropic_scale_per_exec_time=1", "-timeout=20", "-print_final_stats=1", "-verbosity=0",
            f"-error_exitcode={FOUND}", f"-artifact_prefix={BUILD}/{program}-", unpack(target, corpus)]


def unpack(target, folder):
    """The seeds as files, one each, which is how libFuzzer reads them."""
    folder.mkdir(parents=True, exist_ok=True)
    for seed in read_seeds(ROOT / f"tests/fuzz/seeds/{target}.txt"):
        (folder / hashlib.sha1(seed).hexdigest()).write_bytes(seed)
    return folder


def read_seeds(path):
    """Hexadecimal; an empty line ends a seed, # begins a comment,
    and a line with x9 at its end stands for nine of it."""
    text = re.sub(r"#.*", "", path.read_text(encoding="utf-8"))
    text = re.sub(r"(?m)^(.*) x(\d+)[ \t]*$", lambda line: line[1] * int(line[2]), text)
    return [bytes.fromhex(block) for block in re.split(r"\n[ \t]*\n", text) if block.strip()]


def run(*command):
    print("$", *command, flush=True)
    return subprocess.run([str(part) for part in command], cwd=ROOT, stderr=subprocess.STDOUT).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
