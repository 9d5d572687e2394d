"""The conformance suite of port.h on SocketCAN: two sockets on one interface."""

import subprocess

from tumble.bench import programs


def run(interface):
    program = programs.built("tests/conformance/conformance-socketcan")
    return subprocess.run([program, str(interface)], capture_output=True, text=True, timeout=120, check=False)


def test_socketcan_conforms(bus):
    ended = run(bus)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    verdicts = [line.split()[0] for line in ended.stdout.splitlines()[:-2]]
    assert verdicts.count("passed") == 10 and verdicts.count("skipped") == 2 and len(verdicts) == 12, ended.stdout
    assert all(line.endswith("dropped by the kernel 0") for line in ended.stdout.splitlines()[-2:])


def test_an_interface_with_somebody_else_on_it_does_not(bus, started):
    """Canary: frames that neither port has sent."""
    noise = subprocess.Popen(["cangen", str(bus), "-g", "1", "-L", "8"])
    started.append(noise)
    ended = run(bus)
    assert ended.returncode == 1 and "FAILED" in ended.stdout
