"""The conformance suite of port.h on SocketCAN, two sockets on one interface, and on the file of a memory."""

import subprocess

from tumble.world import programs


def run(interface, folder):
    program = programs.built("tests/conformance/conformance-socketcan")
    command = [program, str(interface), folder / "memory"]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


def test_socketcan_and_a_file_conform(bus, tmp_path):
    ended = run(bus, tmp_path)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    verdicts = [line.split()[0] for line in ended.stdout.splitlines()[:-2]]
    busy = "skipped  nv: BUSY" in ended.stdout  # a file that is never slow
    assert verdicts.count("passed") == 20 - busy and verdicts.count("skipped") == 2 + busy, ended.stdout
    assert len(verdicts) == 22
    assert all(line.endswith("dropped by the kernel 0") for line in ended.stdout.splitlines()[-2:])


def test_an_interface_with_somebody_else_on_it_does_not(bus, started, tmp_path):
    """Canary: frames that neither port has sent."""
    noise = subprocess.Popen(["cangen", str(bus), "-g", "1", "-L", "8"])
    started.append(noise)
    ended = run(bus, tmp_path)
    assert ended.returncode == 1 and "FAILED" in ended.stdout
