"""tumble-node's non-volatile memory, a file: made, kept to one process, and refused in one line when it is none."""

import subprocess

import pytest
from processes import HASTE, Node, scenario, wait_until

from tumble.world import programs

SIZE = 65536


def refused(bus, path, tmp_path):
    """What tumble-node says of such a file."""
    named = scenario(tmp_path, "named.txt", keeper__serial="TB-0001")
    command = [programs.find("tumble-node"), str(bus), str(named), "--nv", str(path)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    assert (ended.returncode, ended.stdout) == (2, "") and ended.stderr.count("\n") == 1, ended.stderr
    assert ended.stderr.startswith(f"tumble-node: {path}: ")
    return ended.stderr.removeprefix(f"tumble-node: {path}: ").strip()


def test_one_process_at_a_time(bus, started, tmp_path):
    path = tmp_path / "memory"
    node = Node(bus, scenario(tmp_path, **HASTE), "--nv", path, folder=tmp_path)
    started.append(node)
    wait_until(lambda: path.exists() and path.stat().st_size == SIZE)
    assert refused(bus, path, tmp_path) == "another process has it in use"
    node.signal()
    out, errors = node.process.communicate(timeout=10)
    assert (node.process.returncode, out) == (0, "")
    assert errors == f"tumble-node: node 1 on {bus}, memory {path}; waits for commands\n"
    assert path.stat().st_size == SIZE


@pytest.mark.parametrize("content, says", [
    (b"\0" * SIZE + b"\0", "is not a memory of 65536 bytes"),
    (b"\0" * (SIZE - 1), "is not a memory of 65536 bytes"),
    (None, "Is a directory"),
])
def test_what_is_no_memory(bus, tmp_path, content, says):
    path = tmp_path / "memory"
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    assert refused(bus, path, tmp_path) == says
    assert content is None or path.read_bytes() == content
    assert refused(bus, tmp_path / "none/memory", tmp_path) == "No such file or directory"


def test_a_medium_without_room(bus, tmp_path):
    """A file system of 16 kB."""
    small = tmp_path / "small"
    small.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", str(small)], check=True)
    try:
        assert refused(bus, small / "memory", tmp_path) == "No space left on device"
    finally:
        subprocess.run(["umount", str(small)], check=True)
