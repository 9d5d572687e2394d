"""tumble.records: what a frozen dataclass does, without a compiler."""

import copy
import dataclasses
import pickle

import pytest

from tumble.records import dataclass


@dataclass(frozen=True)
class Quick:
    """With a default of each kind."""

    name: str
    size: float = 1.0
    parts: list = dataclasses.field(default_factory=list)


@dataclasses.dataclass(frozen=True)
class Original:
    name: str
    size: float = 1.0
    parts: list = dataclasses.field(default_factory=list)


@dataclass(frozen=True)
class Key:
    row: int
    column: int


@dataclass(frozen=True, eq=False)
class Itself:
    row: int


CALLS = (
    (("a",), {}),
    (("a", 2.0), {"parts": [1]}),
    ((), {"size": 3.0, "name": "b"}),
    (("a", 2.0, [], 4), {}),
    (("a",), {"name": "b"}),
    (("a",), {"colour": "red"}),
    ((), {"size": 3.0}),
)


@pytest.mark.parametrize(("values", "named"), CALLS)
def test_it_takes_and_refuses_what_the_original_does(values, named):
    try:
        expected = dataclasses.asdict(Original(*values, **named))
    except TypeError:
        with pytest.raises(TypeError, match="Quick"):
            Quick(*values, **named)
    else:
        made = Quick(*values, **named)
        assert dataclasses.asdict(made) == expected
        assert repr(made) == repr(Original(*values, **named)).replace("Original", "Quick")


def test_defaults_are_not_shared():
    assert Quick("a").parts is not Quick("b").parts


def test_it_is_frozen():
    record = Quick("a")
    with pytest.raises(dataclasses.FrozenInstanceError):
        record.size = 2.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        del record.size
    assert record == Quick("a", 1.0)


def test_it_is_compared_and_hashed_by_value_unless_told_otherwise():
    assert Key(1, 2) == Key(1, 2) != Key(2, 1)
    assert {Key(1, 2): "found"}[Key(1, 2)] == "found"
    assert Key(1, 2) != (1, 2)
    one = Itself(1)
    assert {one: "found"}[one] == "found"
    assert one != Itself(1)


def test_tools_for_dataclasses_work_on_it():
    record = Quick("a", parts=[1])
    assert dataclasses.replace(record, size=2.0) == Quick("a", 2.0, [1])
    assert [field.name for field in dataclasses.fields(Quick)] == ["name", "size", "parts"]
    assert pickle.loads(pickle.dumps(record)) == copy.deepcopy(record) == record
