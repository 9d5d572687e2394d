"""What python-canopen does to lead the simulated drive: process data, speeds, a move with its handshake."""

from bench_program import wait_until

COUNTS_PER_DEG = 1000.0


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
