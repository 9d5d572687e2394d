"""tumble-node whose documents or progress nobody reads: the run goes on, and a signal ends the node."""

import fcntl
import json
import os
import subprocess

import pytest
from processes import HASTE, PATIENCE, Stand, scenario, wait_until

from tumble.world import programs

LEAST_BYTES = 4096
NOT_WRITTEN = "tumble-node: standard output cannot be written\n"


@pytest.fixture
def full():
    """A pipe that has no room, and whose other end stays open."""
    ends = os.pipe()
    fcntl.fcntl(ends[1], fcntl.F_SETPIPE_SZ, LEAST_BYTES)
    os.set_blocking(ends[1], False)
    assert os.write(ends[1], bytes(LEAST_BYTES)) == LEAST_BYTES
    os.set_blocking(ends[1], True)
    yield ends[1]
    for end in ends:
        os.close(end)


@pytest.fixture
def begin(bus, started, tmp_path):
    """Start a run; the process."""

    def run(stdout, progress_fd):
        path = scenario(tmp_path, **HASTE, **PATIENCE)
        started.append(Stand(bus, path, "--seed", 7))
        command = [programs.find("tumble-node"), str(bus), str(path), "--start", "--log", "json"]
        process = subprocess.Popen([*command, "--progress-fd", str(progress_fd)], stdout=stdout, stderr=subprocess.PIPE,
                                   text=True, pass_fds=(progress_fd,))
        started.append(process)
        return process

    return run


def test_progress_that_nobody_reads_holds_up_no_run(begin, full):
    out, _errors = begin(subprocess.PIPE, full).communicate(timeout=120)
    assert json.loads(out)["end"] == "done"


def test_a_document_that_nobody_reads_waits_for_a_signal(begin, full, tmp_path):
    with open(tmp_path / "progress", "w", encoding="utf-8") as file:
        process = begin(full, file.fileno())
    wait_until(lambda: '"event":"end"' in (tmp_path / "progress").read_text(encoding="utf-8"), 120)
    assert process.poll() is None
    process.terminate()
    errors = process.communicate(timeout=60)[1]
    assert process.returncode == 3 and errors.endswith(NOT_WRITTEN)
