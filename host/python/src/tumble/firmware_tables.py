"""States of a run, nodes of the bus. Written by tools/objects/generate from firmware and object tables;
not to be edited."""

from __future__ import annotations

STATES = {  # name: what it does
    "IDLE": "waiting for a start command",
    "PREFLIGHT": "checking schedule, stand and block",
    "WARM_UP": "waiting for the block's temperature to settle",
    "WAIT_MOUNTING": "waiting for the operator to mount the block, or incline the stand, and confirm",
    "HOME": "homing the table",
    "MOVE": "turning the table",
    "SETTLE": "waiting for the table and the block to come to rest",
    "AVERAGE": "averaging samples",
    "NEXT": "choosing the next position",
    "SOLVE": "computing the coefficients",
    "VERIFY": "checking the result against gravity",
    "PROPOSE": "offering the result",
    "DONE": "finished",
    "FAULT": "stopped by a fault; can resume after a repair",
    "ABORT": "given up, table stopped",
}

WAYS = (  # from, to, by what, when
    ("IDLE", "PREFLIGHT", "START", ""),
    ("IDLE", "PREFLIGHT", "RESUME", ""),
    ("PREFLIGHT", "WARM_UP", "done", ""),
    ("PREFLIGHT", "FAULT", "fault", ""),
    ("PREFLIGHT", "ABORT", "ABORT", ""),
    ("WARM_UP", "NEXT", "done", ""),
    ("WARM_UP", "FAULT", "fault", ""),
    ("WARM_UP", "ABORT", "ABORT", ""),
    ("WAIT_MOUNTING", "HOME", "done", ""),
    ("WAIT_MOUNTING", "FAULT", "fault", ""),
    ("WAIT_MOUNTING", "ABORT", "ABORT", ""),
    ("WAIT_MOUNTING", "PREFLIGHT", "REPEAT", ""),
    ("WAIT_MOUNTING", "NEXT", "CONFIRM", ""),
    ("HOME", "MOVE", "done", ""),
    ("HOME", "FAULT", "fault", ""),
    ("HOME", "ABORT", "ABORT", ""),
    ("MOVE", "SETTLE", "done", ""),
    ("MOVE", "FAULT", "fault", ""),
    ("MOVE", "ABORT", "ABORT", ""),
    ("SETTLE", "AVERAGE", "done", ""),
    ("SETTLE", "SETTLE", "other", "another attempt"),
    ("SETTLE", "FAULT", "fault", ""),
    ("SETTLE", "ABORT", "ABORT", ""),
    ("SETTLE", "PREFLIGHT", "REPEAT", ""),
    ("AVERAGE", "NEXT", "done", ""),
    ("AVERAGE", "SETTLE", "other", "another attempt"),
    ("AVERAGE", "FAULT", "fault", ""),
    ("AVERAGE", "ABORT", "ABORT", ""),
    ("AVERAGE", "PREFLIGHT", "REPEAT", ""),
    ("NEXT", "WAIT_MOUNTING", "done", ""),
    ("NEXT", "SOLVE", "other", "nothing is left to measure"),
    ("SOLVE", "VERIFY", "done", ""),
    ("SOLVE", "FAULT", "fault", ""),
    ("SOLVE", "ABORT", "ABORT", ""),
    ("SOLVE", "PREFLIGHT", "REPEAT", ""),
    ("VERIFY", "PROPOSE", "done", ""),
    ("VERIFY", "FAULT", "fault", ""),
    ("VERIFY", "ABORT", "ABORT", ""),
    ("VERIFY", "PREFLIGHT", "REPEAT", ""),
    ("PROPOSE", "DONE", "done", ""),
    ("PROPOSE", "ABORT", "ABORT", ""),
    ("PROPOSE", "PREFLIGHT", "REPEAT", ""),
    ("DONE", "PREFLIGHT", "START", ""),
    ("DONE", "PREFLIGHT", "REPEAT", ""),
    ("FAULT", "ABORT", "ABORT", ""),
    ("FAULT", "PREFLIGHT", "REPEAT", ""),
    ("FAULT", "PREFLIGHT", "CONFIRM", ""),
    ("FAULT", "PREFLIGHT", "RESUME", ""),
    ("ABORT", "PREFLIGHT", "START", ""),
)

NODES = (  # number, name, emergency, SDO answer, SDO request, heartbeat
    (1, "navcomp", 129, 1409, 1537, 1793),
    (2, "drive", 130, 1410, 1538, 1794),
    (3, "block", 131, 1411, 1539, 1795),
)

PROCESS_DATA = {  # node: identifiers of its PDOs, that it hears and that it sends
    1: ((), (385, 1665, 1729)),
    2: ((514,), (386,)),
    3: ((), ()),
}

SAMPLES = (1667, 1683)  # of node 3

HEARTBEAT_MS = 100
CONSUMER_MS = 500
