"""docs/client.md, the service level: its commands do what it says, over CAN and over Modbus."""

import contextlib
import io
import re
import struct

import pytest
from canopen_bridge import ROOT, program, start  # noqa: F401
from gateway_bench import start as start_gateway
from test_canopen_recalibration import bench  # noqa: F401
from test_gateway_commands import mbpoll_write, written

pytestmark = pytest.mark.real_time

PAGE = (ROOT / "docs/client.md").read_text(encoding="utf-8").partition("\n## The service level\n")[2]
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
MBPOLL = re.findall(r"^    mbpoll .* -r 0 127\.0\.0\.1 ([\d ]+)$", PAGE, re.MULTILINE)
start_gateway = pytest.fixture(name="serve")(start_gateway.__wrapped__ if hasattr(start_gateway, "__wrapped__")
                                             else start_gateway.__pytest_wrapped__.obj)
KEY, LOCK = "write 2006 1 73657276", "write 2006 1 00000000"
LIMIT = "write 2050 5 " + struct.pack("<d", 1e-3).hex().upper()


def printed(block, **names):
    """What a block of the page prints, run with these names."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(compile(block, "docs/client.md", "exec"), names)
    return out.getvalue()


def test_python_canopen(bench):
    """Settings changed and saved, a proposal accepted by its name; the proposal that is no longer there is not."""
    computer, node = bench.computer, bench.computer.node
    assert printed(BLOCKS[0], node=node) == "level 0 flags 3\n"
    bench.power_cycle()
    assert computer["Commit rules"]["Flags"].raw == 3  # it was saved
    computer.set_rules(1e-3, 1e-4, flags=1)
    computer.calibrate()
    assert computer.objections() == {"FIRST"} and computer["Run number"].raw == 1
    read_before = computer["Proposal"]["Record CRC"].raw
    bench.drift(1000)
    computer.calibrate()
    assert computer["Run number"].raw == 2 and computer["Proposal"]["Record CRC"].raw != read_before
    stale = BLOCKS[1].replace('node.sdo["Proposal"]["Record CRC"].raw', str(read_before))
    with pytest.raises(Exception, match="0x06090030"):
        printed(stale, node=node)
    assert computer.counter() == 0
    assert printed(BLOCKS[1], node=node) == "objections 0x40\n"
    computer.settle()
    assert computer.counter() == 1


def test_rules_that_are_not_saved_hold_a_result(bench):
    """The row of the page about limits for one run."""
    computer = bench.computer
    computer.set_rules(1e-3, 1e-4)
    computer.calibrate()
    assert computer.counter() == 1 and computer.objections() == set()
    computer.unlock()
    computer["Configuration"]["Gravity limit"].raw = 1.0
    bench.drift(1000)
    computer.calibrate()
    assert computer.objections() == {"OTHER_RULES"} and computer.counter() == 1
    assert computer["Proposal"]["Flags"].raw & 0x40 and not computer["Active set"]["Flags"].raw & 0x40


def test_the_level_in_time_and_over_start(bench):
    computer, limit = bench.computer, bench.computer["Configuration"]["Gravity limit"]
    for _ in range(2):
        with pytest.raises(Exception, match="0x08000022"):
            limit.raw = 1e-3
        computer.unlock()
        limit.raw = 1e-3
        bench.bus.let_pass(59_000)
        limit.raw = 2e-3
        assert computer["Service level"]["Seconds left"].raw == 1
        bench.bus.let_pass(1_100)
    with pytest.raises(Exception, match="0x08000022"):
        limit.raw = 1e-3
    computer.unlock()
    computer.command("START")
    with pytest.raises(Exception, match="0x08000022"):
        limit.raw = 1e-3
    with pytest.raises(Exception, match="0x08000022"):
        computer.unlock()
    bench.bus.let_pass(100)
    told = [line for line in bench.bus.log if line.startswith("081#")]
    assert told == ["081#30FF810100000000", "081#0000000000000000"] * 3
    last = next(line for line in reversed(bench.bus.log) if line.startswith("6C1#"))
    assert struct.unpack("<BHI", bytes.fromhex(last[4:])) == (0, 0, 1)


def test_can_utils(start):
    """Frame by frame."""
    ours = start("navcomp")
    steps = re.findall(r"^(581#\w{16})  <- cansend can0 (601#\w{16}) ", PAGE, re.MULTILINE)
    assert len(steps) == 6
    for answer, request in steps:
        before = len(ours.bus.log)
        ours.bus.tell(request)
        ours.bus.let_pass(10)
        assert [line for line in ours.bus.log[before:] if line.startswith("581#")] == [answer]


def test_pymodbus(serve):
    pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    gateway = serve("--allow-commands")
    gateway.wait_fresh()
    out = printed(BLOCKS[2].replace("port=1502", f"port={gateway.port}"))
    assert out == "gravity limit, locked: 6\nkey: 2\ngravity limit: 2\nlocked: 2\n"
    assert written(gateway, 3) == [KEY, LIMIT, LOCK]


def test_mbpoll(serve):
    gateway = serve("--allow-commands")
    gateway.wait_fresh()
    protected, accept = (line.split() for line in MBPOLL)
    assert mbpoll_write(gateway, 0, *protected) == ""
    assert written(gateway, 3) == [KEY, "write 2123 2 03", LOCK]
    assert mbpoll_write(gateway, 0, *accept) == ""
    assert written(gateway, 4) == ["write 2002 1 00", "write 2002 3 0000000000000000", "write 2002 4 78563412",
                                   "write 2002 2 09"]
