"""tumble-gateway as a program: options, exit codes, signals, its manager."""

import os
import re
import signal
import socket
import subprocess

import pytest
from simulated_bench import built

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]


@pytest.fixture
def gateway():
    """Run the program itself, as it is built; skips without it."""
    found = built("tumble-gateway")

    def run(*arguments):
        return subprocess.run([found, *map(str, arguments)], capture_output=True, text=True, timeout=20)

    return run


BAD = [
    ([], "--can: is missing: the CAN interface"),
    (["--can", "vcan0", "more"], "more: is no option; see --help"),
    (["--bogus"], "--bogus: no such option; see --help"),
    (["--bogus=3"], "--bogus: no such option; see --help"),
    (["-x"], "-x: no such option; see --help"),
    (["-xh"], "-x: no such option; see --help"),
    (["--can"], "--can: needs a value"),
    (["--help=3"], "--help: takes no value"),
    (["--allow-commands=3"], "--allow-commands: takes no value"),
    (["--can", "vcan0", "--unit", "0"], "--unit: must be a whole number from 1 to 247"),
    (["--can", "vcan0", "--unit", "248"], "--unit: must be a whole number from 1 to 247"),
    (["--can", "vcan0", "--node", "128"], "--node: must be a whole number from 1 to 127"),
    (["--can", "vcan0", "--poll", "49"], "--poll: must be a whole number from 50 to 3600000"),
    (["--can", "vcan0", "--idle", "0"], "--idle: must be a whole number from 1 to 86400"),
    (["--can", "vcan0", "--unlock", "x"], "--unlock: must be a whole number from 1 to 3600"),
    (["--can", "vcan0", "--tcp", "1502"], "--tcp: must be HOST:PORT, [ADDRESS]:PORT or none"),
    (["--can", "vcan0", "--tcp", ":1502"], "--tcp: must be HOST:PORT, [ADDRESS]:PORT or none"),
    (["--can", "vcan0", "--tcp", "::1:1502"], "--tcp: must be HOST:PORT, [ADDRESS]:PORT or none"),
    (["--can", "vcan0", "--tcp", "[]:1502"], "--tcp: must be HOST:PORT, [ADDRESS]:PORT or none"),
    (["--can", "vcan0", "--tcp", "h:"], "--tcp: port: must be a whole number from 0 to 65535"),
    (["--can", "vcan0", "--tcp", "h:65536"], "--tcp: port: must be a whole number from 0 to 65535"),
    (["--can", "vcan0", "--tcp", "h" * 300 + ":1"], "--tcp: must be HOST:PORT, [ADDRESS]:PORT or none"),
    (["--can", "vcan0", "--tcp", "none"], "--tcp none: needs --rtu, or there is nothing to serve"),
    (["--can", "vcan0", "--rtu", "tty"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--rtu", "tty,9600"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--rtu", "tty,9600,X"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--rtu", "tty,9600,"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--rtu", "tty,9600,EE"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--rtu", ",9600,E"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--rtu", "tty,123456789012,E"], "--rtu: must be DEVICE,BAUD,PARITY with parity N, E or O"),
    (["--can", "vcan0", "--log", "xml"], "--log: must be text or json"),
    (["--can", "vcan0", "--log-level", "loud"], "--log-level: must be error, warning, notice or info"),
    (["--can", "vcan0", "--log"], "--log: needs a value"),
    (["--can", "vcan0", "--rtu", "tty,300,E"], "--rtu: baud: must be a whole number from 1200 to 921600"),
]


@pytest.mark.parametrize("arguments, message", BAD, ids=[" ".join(row[0])[12:60] for row in BAD])
def test_bad_usage_is_one_line_and_exit_2(gateway, arguments, message):
    done = gateway(*arguments)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"tumble-gateway: {message}\n")


def test_help_names_every_option_and_exit_code(gateway):
    done = gateway("--help")
    assert (done.returncode, done.stderr) == (0, "")
    for option in ("can", "tcp", "rtu", "unit", "node", "poll", "idle", "allow-commands", "unlock", "log", "log-level"):
        assert f"  --{option}" in done.stdout
    assert "  -h, --help" in done.stdout and gateway("-h").stdout == done.stdout
    assert all(code in done.stdout for code in ("0 told", "2 bad", "3 it", "77 this"))
    assert max(map(len, done.stdout.splitlines())) <= 80


def test_an_interface_that_is_not_there(gateway):
    done = gateway("--can", "nocan0")
    assert (done.returncode, done.stdout) in ((2, ""), (77, ""))
    assert re.fullmatch(r"tumble-gateway: nocan0: .*\n", done.stderr)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it(launch, number):
    made = launch()
    assert re.fullmatch(r"tumble-gateway: node 1 on played, unit 1 at 127\.0\.0\.1:\d+, read only\n", made.line)
    client = made.connect()
    assert made.end(number) == (0, "")
    assert client.receive() == b""


def test_a_port_that_is_taken(launch):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        made = launch(tcp=f"127.0.0.1:{taken.getsockname()[1]}")
        assert made.line == "tumble-gateway: 127.0.0.1: Address already in use\n"
        assert made.end() == (3, "")


def test_a_host_that_is_none(launch):
    made = launch(tcp="256.1.1.1:1502")
    assert made.line.startswith("tumble-gateway: 256.1.1.1: ")
    assert made.end() == (3, "")


def test_a_serial_line_that_is_none(launch, tmp_path):
    made = launch("--rtu", f"{tmp_path}/tty,9600,N")
    assert made.line == f"tumble-gateway: {tmp_path}/tty: No such file or directory\n"
    assert made.end() == (3, "")


def test_it_listens_on_this_machine_alone(launch):
    """Unless told otherwise: the default of the program, looked at from the kernel's side."""
    made = launch(tcp="0.0.0.0:0")
    assert " at 0.0.0.0:" in made.line
    assert made.end() == (0, "")
    line = launch(tcp=None).line
    assert " at 127.0.0.1:1502, read only" in line or line == "tumble-gateway: 127.0.0.1: Address already in use\n"


@pytest.mark.parametrize("abstract", [False, True])
def test_its_manager_is_told(launch, tmp_path, monkeypatch, abstract):
    name = f"@tumble-{os.getpid()}" if abstract else str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(name.replace("@", "\0"))
        manager.settimeout(10)
        monkeypatch.setenv("NOTIFY_SOCKET", name)
        made = launch()
        assert manager.recv(100) == b"READY=1"
        assert made.end() == (0, "")
        assert manager.recv(100) == b"STOPPING=1"
