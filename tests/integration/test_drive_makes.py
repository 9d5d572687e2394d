"""Drives of other makes: each is led to DONE by a profile that knows it, or refused with object, abort code and step.

One table. A variant is what the drive is like, the profile's keys, and what comes of it: None for a calibration, else
the refused object, its abort code, and the step in which that was.
"""

import pytest
from simulated_bench import bench

NO_OBJECT, READ_ONLY, WRONG_VALUE, TOO_LATE = 0x06020000, 0x06010002, 0x06090030, 0x05040000
STATUS_PDO = "0 0x182 0 100 0x6041:0:16"
SEEN_LATE, ON_CHANGE = "1 0x282 1000 100 0x6064:0:32", "1 0x282 0 0 0x6064:0:32"  # inhibit time 0.1 s; no timer
WITHOUT = {  # an object that the drive lacks: the profile that leaves it out, the subindex that is refused otherwise
    0x1016: ({"profile__heartbeat_timeout_ms": 0}, 1),
    0x1017: ({"profile__heartbeat_ms": 0}, 0),
    0x6007: ({}, None),
    0x603F: ({}, None),
    0x605A: ({}, None),
    0x607D: ({"profile__software_limits": "no"}, 1),
    0x6081: (None, 0),
    0x6083: (None, 0),
    0x6084: ({"profile__deceleration_deg_s2": 0}, 0),
    0x6085: ({"profile__quick_stop_deg_s2": 0}, 0),
    0x6098: ({"profile__homing_method": 0}, 0),
    0x6099: ({"profile__homing_fast_deg_s": 0, "profile__homing_slow_deg_s": 0}, 1),
    0x609A: ({"profile__homing_acceleration_deg_s2": 0}, 0),
}
UNTURNED = {"drive__power_on_deg": 0}  # without 6098h it homes where it stands
AT_MARK = {"drive__instant_homing": "yes", "drive__power_on_deg": 0}

VARIANTS = {
    "usual": ({}, {}, None),
    "two transmit PDOs, the position late": (
        {}, {"profile__transmit_pdo": [STATUS_PDO, SEEN_LATE], "profile__window_counts": 0}, None),
    "two transmit PDOs, the position late, a window": (
        {}, {"profile__transmit_pdo": [STATUS_PDO, SEEN_LATE], "profile__window_counts": 20}, None),
    "two transmit PDOs, the position on change alone": (
        {}, {"profile__transmit_pdo": [STATUS_PDO, ON_CHANGE], "profile__window_counts": 0}, None),
    "home at once": (AT_MARK, {}, None),
    "home at once, shown late": ({**AT_MARK, "drive__reaction_us": 20000}, {}, None),
    "bit 12 from enabling on": (
        {"drive__acknowledges_enabling": "yes"}, {"profile__acknowledges_enabling": "yes"}, None),
    "bit 12 from enabling on, not told of": (
        {"drive__acknowledges_enabling": "yes"}, {}, (0x6041, 0, TOO_LATE, "TARGET")),
    "PDOs that are fixed": ({"drive__fixed_pdos": "yes"}, {"profile__keeps_pdos": "yes"}, None),
    "PDOs that are fixed, not told of": (
        {"drive__fixed_pdos": "yes"}, {}, (0x1400, 1, READ_ONLY, "CONFIGURATION")),
    "PDOs that are fixed otherwise than told": (
        {"drive__fixed_pdos": "yes"},
        {"profile__keeps_pdos": "yes", "profile__transmit_pdo": f"{STATUS_PDO} 0x6061:0:8 0x6064:0:32"},
        (0x1A00, 2, WRONG_VALUE, "CONFIGURATION")),
    "everything that may be missing": (
        {**UNTURNED,
         "drive__lacks": " ".join(f"0x{index:04X}" for index, (known, _) in WITHOUT.items() if known is not None)},
        {key: value for known, _ in WITHOUT.values() for key, value in (known or {}).items()}, None),
}
for lacked, (known, refused) in WITHOUT.items():
    drive = {"drive__lacks": f"0x{lacked:04X}"}
    if known is not None:
        VARIANTS[f"without {lacked:04X}h"] = (drive | (UNTURNED if lacked == 0x6098 else {}), known, None)
    if refused is not None:
        VARIANTS[f"without {lacked:04X}h, not told of"] = (drive, {}, (lacked, refused, NO_OBJECT, "CONFIGURATION"))


@pytest.mark.parametrize("name", VARIANTS)
def test_each_is_led_or_refused_by_name(name):
    drive, profile, refused = VARIANTS[name]
    found = bench(drive | profile, seed=5)
    told = found["drive_refusal"]
    if refused is None:
        assert (found["exit"], found["state"], told) == (0, "TUMBLE_STATE_DONE", None), found["reason"]
        return
    index, subindex, abort, _ = refused
    assert (found["exit"], found["reason"]) == (3, "TUMBLE_REASON_STAND_PROTOCOL")
    assert (told["index"], told["subindex"], told["abort"], told["step"]) == refused
    code = f"{abort >> 16:04X} {abort & 0xFFFF:04X}h"
    assert told["sentence"].startswith(f"drive object {index:04X}h:{subindex}, abort {code} (")


def test_homing_at_the_mark_takes_no_minute():
    """It used to wait for bit 12 to be seen clear, until the homing's own time was over."""
    assert bench(AT_MARK, seed=5)["virtual_s"] < bench(UNTURNED, seed=5)["virtual_s"]
