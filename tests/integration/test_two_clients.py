"""The long version of tests/unit/world/test_two_clients.c: 10,000 reads of a script beside the gateway."""

import os
import re
import subprocess
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[2] / "build/sanitizers/tests/unit/test_bench"
READS = 10_000


@pytest.mark.full
def test_ten_thousand_reads_beside_the_gateway():
    if not PROGRAM.exists():
        pytest.skip("the unit tests are not built: tools/test unit")
    environment = {**os.environ, "TWO_CLIENTS_READS": str(READS)}
    done = subprocess.run([PROGRAM], env=environment, capture_output=True, text=True, timeout=600)
    told = re.search(r"^two clients: (\d+) reads, (\d+) lost, (\d+) runs begun;.*$", done.stdout, re.MULTILINE)
    print(told[0])
    assert done.returncode == 0, done.stdout
    assert (int(told[1]), int(told[2])) == (READS, 0) and int(told[3]) > 5
