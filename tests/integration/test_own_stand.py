"""docs/porting.md, your own stand: its C is that of the files, its numbers are those of program and headers."""

import re
import subprocess

import pytest
from conftest import EXAMPLES, ROOT

from tumble.world import programs

PAGE = (ROOT / "docs/porting.md").read_text(encoding="utf-8").partition("\n## Your own stand\n")[2]
POSITIONER = ROOT / "firmware/stand/positioner"
SHOWN = [*POSITIONER.glob("*.[ch]"), ROOT / "tests/unit/stand/test_stand_rules.c"]
FORM = re.search(r'#define FORM "(.*)"', (ROOT / "host/node/positioner_option.c").read_text(encoding="utf-8"))[1]
pytestmark = pytest.mark.python


BLOCKS = re.findall(r"```c\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.split("\n")[0])
def test_its_c_is_that_of_a_file(block):
    assert any(block in path.read_text(encoding="utf-8") for path in SHOWN), block


def rows(first, last):
    """The cells of the page's table rows between two texts."""
    part = PAGE[PAGE.index(first):PAGE.index(last)]
    lines = [line.strip("|").split("|") for line in part.splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line] for line in lines]


def test_its_registers_are_those_of_the_header():
    """Number and name, in their order."""
    header = (POSITIONER / "positioner.h").read_text(encoding="utf-8")
    expected = re.findall(r"^ \*     (?:written|read|) +(\d+(?:, \d+)?) +(\w+) ", header, re.MULTILINE)
    shown = [(cells[0], cells[1]) for cells in rows("### 1.", "### 2.") if cells[0][:1].isdigit()]
    assert len(shown) == 9 and shown == expected


def test_its_defaults_are_those_of_the_option():
    source = (ROOT / "host/node/positioner_option.c").read_text(encoding="utf-8")
    expected = {name: float(value) for name, value in re.findall(r"^    \.(\w+) = ([0-9.]+),$", source, re.MULTILINE)}
    expected["unit"] = float(re.search(r"static uint8_t unit = (\d+);", source)[1])
    shown = {}
    for names, numbers, _ in rows("| name |", "An order may have to wait")[1:]:
        shown.update(zip(re.findall(r"`(\w+)`", names), map(float, numbers.split(", ")), strict=True))
    assert shown == expected and len(shown) == 10
    helps = (ROOT / "host/node/main.c").read_text(encoding="utf-8").replace('\\n"\n    "', " ")
    told = dict(re.findall(r"(\w+) +\(([0-9.]+)\)", helps[helps.index("--stand"):helps.index("--nv FILE")]))
    assert {name: float(value) for name, value in told.items()} == expected


def test_its_reasons_are_there():
    names = (ROOT / "firmware/procedure/states.h").read_text(encoding="utf-8")
    reasons = set(re.findall(r"TUMBLE_REASON_\w+", PAGE))
    assert len(reasons) >= 9 and all(reason in names for reason in reasons)


def refused(stand):
    """Exit code and message of tumble-node with such a --stand; it needs no interface to say it."""
    program = programs.find("tumble-node")
    command = [program, "nocan0", EXAMPLES / "none.txt", "--stand", f"modbus:{stand}"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    if "without libmodbus" in done.stderr:
        pytest.skip("tumble-node was built without libmodbus")
    return done.returncode, done.stderr


@pytest.mark.parametrize("wrong", ["h:0", "h:70000", "h:x", "h:", ":502", "h", "[::1:502", "::1:502", "[]:502"])
def test_an_address_that_none_can_have_is_refused_at_once(wrong):
    assert refused(wrong) == (2, f"tumble-node: --stand: {FORM}\n")


@pytest.mark.parametrize("numbers, says", [
    ("unit=1,unit=2", "has a number twice"),
    ("unit=1.5", "a number is out of its range, or no number; see --help"),
    ("units=1", "no such number of a stand; see --help"),
])
def test_numbers_of_a_stand_that_are_refused(numbers, says):
    assert refused(f"h:502,{numbers}") == (2, f"tumble-node: --stand: {says}\n")
