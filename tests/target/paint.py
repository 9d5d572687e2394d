"""Hold the stack that was painted over on the target against what tools/budget says of the same code.

    python paint.py BUDGET_CSV HARNESS_BYTES TARGET_COMMAND...

BUDGET_CSV is what tools/budget measured. HARNESS_BYTES: what the harness itself puts between the paint and the code.
Exit 1 where more was painted over than the worst chain can take, or so little that it was not measured at all.
"""

import csv
import subprocess
import sys

LEAST_SHARE = 0.5  # of the worst chain that some call must really take


def main(budget_csv, harness_bytes, *command):
    with open(budget_csv, newline="", encoding="utf-8") as file:
        bound = next(int(row["bytes"]) for row in csv.DictReader(file) if row["quantity"] == "stack")
    result = subprocess.run(
        command, check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900
    )
    lines = [line.split() for line in result.stdout.splitlines() if line.startswith("stack ")]
    painted = {name: int(size) for _, name, size in lines}
    if not painted:
        print("paint: the target said nothing")
        return 1
    for name, size in painted.items():
        print(f"{name:16} {size:5} B painted over, {int(harness_bytes)} B of them at most the harness; "
              f"worst chain {bound} B")
    worst = max(painted.values())
    if worst > bound + int(harness_bytes):
        print(f"paint: {max(painted, key=painted.get)} takes {worst} B, more than the worst chain")
        return 1
    if worst < LEAST_SHARE * bound:
        print(f"paint: nothing takes even half of the worst chain: {worst} B")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
