"""docs/operations.md explains every reason and every objection there is, under its number, and no others."""
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/operations.md").read_text(encoding="utf-8")


def names(header, macro):
    """The names of a closed list, in the order of their numbers."""
    text = (ROOT / header).read_text(encoding="utf-8")
    body = re.search(rf"#define {macro}\(X\)(.*?)\n\n", text, re.DOTALL)[1]
    return re.findall(r"X\((\w+),", body)


def rows(prefix, page=PAGE):
    """(number, name, what is said) of each row about a name with this prefix."""
    return [(int(number), name, said) for number, name, said in
            re.findall(rf"^\| (\d+) \| `({prefix}\w+)` \| (.+) \|$", page, re.MULTILINE)]


LISTS = [("firmware/procedure/states.h", "TUMBLE_REASON_LIST", "TUMBLE_REASON_"),
         ("firmware/include/tumble/sets.h", "TUMBLE_OBJECTION_LIST", "TUMBLE_OBJECTION_")]


@pytest.mark.parametrize("header, macro, prefix", LISTS)
def test_every_name_has_its_row(header, macro, prefix):
    expected = list(enumerate(names(header, macro)))
    assert len(expected) > 10
    assert [(number, name) for number, name, _ in rows(prefix)] == expected
    assert all(len(said) > 15 for _, _, said in rows(prefix))


def test_a_missing_row_is_noticed():
    page = PAGE.replace("| 12 | `TUMBLE_REASON_SLIP`", "| 12 | SLIP")
    assert page != PAGE
    assert len(rows("TUMBLE_REASON_", page)) == len(names(*LISTS[0][:2])) - 1


def test_commands_have_the_numbers_that_the_page_gives():
    numbers = {name: number for number, name in enumerate(names("firmware/navcomp/commands.h", "TUMBLE_COMMAND_LIST"))}
    said = re.findall(r"\b([A-Z]{4,}(?:_[A-Z]+)*)\**\s*\((?:command )?(\d+)\)", PAGE)
    commands = [(word, int(number)) for word, number in said if f"TUMBLE_COMMAND_{word}" in numbers]
    assert len(commands) >= 10
    assert all(numbers[f"TUMBLE_COMMAND_{word}"] == number for word, number in commands)
    assert {"HOME_AXIS", "TURN_AXIS"} <= {word for word, _ in commands}


def test_objects_that_the_page_names_exist():
    table = (ROOT / "docs/canopen.md").read_text(encoding="utf-8")
    for index in set(re.findall(r"\b(2[01][0-9A-F]{2})h", PAGE)):
        assert f"| {index}h |" in table, index
