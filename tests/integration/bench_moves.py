"""What python-canopen does to lead the simulated drive: process data, speeds, moves with their handshake."""

import canopen
from conftest import ROOT
from simulated_bench import wait_until

COUNTS_PER_DEG = 1000.0
TARGETS_DEG = (90.0, -45.0, 12.345)


def axis(network):
    """The drive, a node of the network."""
    drive = network.add_node(canopen.BaseNode402(2, str(ROOT / "docs/eds/tumble_drive.eds")))
    drive.sdo.RESPONSE_TIMEOUT = 20.0
    return drive


def lead(drive):
    """Home it, move it to TARGETS_DEG, and leave it without a master, which it must take for a fault."""
    heartbeat = drive.network.send_periodic(0x701, [5], 0.1)
    configure(drive)
    drive.nmt.state = "OPERATIONAL"
    drive.setup_402_state_machine(read_pdos=False)
    drive.state = "OPERATION ENABLED"
    assert drive.homing(timeout=20)
    drive.op_mode = "PROFILED POSITION"
    for target_deg in TARGETS_DEG:
        move(drive, round(target_deg * COUNTS_PER_DEG))
    heartbeat.stop()
    wait_until(lambda: drive.sdo[0x6041].raw & 0x4F == 0x08)


def require_moved(table):
    """The truth of a table that was led: everywhere, and at rest now."""
    assert table["at_rest"] and table["highest_deg"] > 89.99 and table["lowest_deg"] < -44.99


def configure(drive):
    """Process data with all that a master wants to see, written by SDO; the master's heartbeat; speeds."""
    drive.pdo.read()
    maps = {drive.rpdo[1]: (0x6040, 0x6060, 0x607A), drive.tpdo[1]: (0x6041, 0x6061, 0x6064)}
    for pdo, objects in maps.items():
        pdo.clear()
        for index in objects:
            pdo.add_variable(index)
        pdo.enabled = True
        pdo.event_timer = None if pdo is drive.rpdo[1] else 50
        pdo.save()
    drive.sdo[0x1016][1].raw = 1 << 16 | 500
    drive.sdo[0x6098].raw = 34
    drive.sdo[0x6081].raw = round(360 * COUNTS_PER_DEG)
    drive.sdo[0x6083].raw = drive.sdo[0x6084].raw = round(1000 * COUNTS_PER_DEG)
    drive.sdo[0x6099][1].raw = round(45 * COUNTS_PER_DEG)
    drive.sdo[0x6099][2].raw = round(20 * COUNTS_PER_DEG)


def move(drive, counts):
    """One set-point with its handshake; arrived within a hundredth of a degree when the drive says so."""
    pdo = drive.rpdo[1]
    pdo["Target position"].raw = counts
    drive.controlword = 0x0F
    drive.controlword = 0x1F
    wait_until(lambda: drive.statusword & 0x1000)
    drive.controlword = 0x0F
    wait_until(lambda: not drive.statusword & 0x1000)
    # What a status report said before the move began may still be the last word heard, so the position counts as well.
    wait_until(lambda: drive.statusword & 0x0400 and abs(drive.sdo[0x6064].raw - counts) <= 10)
