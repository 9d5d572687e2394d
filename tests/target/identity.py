"""Do this machine and the target give the same bits?  python identity.py HOST_PROGRAM TARGET_COMMAND...

Runs both, compares their hashes line by line, and prints what was compared. Exit 1 where a block of inputs differs, or
where a function hardly ever got as far as a result. The sums whose exponents differ by 33 are reported apart: see
docs/method.md.
"""

import subprocess
import sys
from collections import defaultdict

INPUTS_PER_BLOCK = 100
LEAST_INPUTS = 10_000


def main(host_program, *target_command):
    host, target = (read(command) for command in ([host_program], target_command))
    wrong = host.pop("misrounded"), target.pop("misrounded")
    if host.keys() != target.keys() or host["left_out"] != target.pop("left_out"):
        print("identity: not the same functions, or not the same left out")
        return 1
    ((left_out,),) = host.pop("left_out")
    faults = 0
    for function in host:
        ours, theirs = host[function], target[function]
        inputs, results = INPUTS_PER_BLOCK * len(ours), sum(int(results, 16) for _, results, _ in ours)
        different = [our[0] for our, their in zip(ours, theirs) if our != their]
        good = ours == theirs and inputs >= LEAST_INPUTS and results >= inputs / 4
        faults += not good
        said = f"blocks that differ: {', '.join(different) or 'none'}"
        print(f"{'equal' if good else 'FAILED':7}{function:15}{inputs:7} inputs, {results:7} results; {said}")
    (here,), (there,) = wrong
    sums = f"here {int(here[0], 16)}, target {int(there[0], 16)}"
    print(f"known  misrounded sums among 4096 with exponents 33 apart: {sums}")
    print(f"known  left out of gravity_check for that reason, |a| near 1e-5 g: {int(left_out, 16)} positions of all")
    return 1 if faults or int(here[0], 16) else 0


def read(command):
    """The lines that a program prints, by their first word."""
    lines = defaultdict(list)
    result = subprocess.run(
        command, check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900
    )
    for line in result.stdout.splitlines():
        name, *words = line.split()
        lines[name].append(tuple(words))
    return lines


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
