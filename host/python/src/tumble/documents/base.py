"""Kinds of values in documents, and how documents are read and written.

Unknown is null, never NaN. Numbers have as many digits as it takes to read back the same bits. A key that a type does
not know is passed over when it is read: a later version may have written it.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from inspect import cleandoc
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, TypeVar

import msgspec
import numpy as np
from msgspec import Meta

from tumble.arrays import Floats
from tumble.errors import BadInput, quoted
from tumble.files.disk import JSON, kind_of

LARGEST = 1e300  # of a number in an array: products of a few stay finite
END_OF_TEXT = r"$(?!\n)"  # the end of a text; what re means by $ alone may be followed by a line feed

Number = Annotated[float, Meta(gt=-LARGEST, lt=LARGEST)]
Size = Annotated[float, Meta(ge=0)]
Positive = Annotated[float, Meta(gt=0)]
Count = Annotated[int, Meta(ge=0)]
Share = Annotated[float, Meta(ge=0, le=1)]
PlaceNumber = Annotated[int, Meta(ge=1, le=255)]  # of a mounting, of a position


def exactly(pattern: str) -> Meta:
    """A text that is this from its beginning to its end."""
    return Meta(pattern=f"^{pattern}{END_OF_TEXT}")


class Document(msgspec.Struct):
    # No docstring, which types without one would inherit. A key without a default must be there; one that is UNSET
    # is not written.
    pass


class _Array(type):
    """Type of the arrays below: their shape (None: any length from `fewest` on) and the least that a number may be. Any
    array of numpy is an instance; `array_of` checks what is read."""

    shape: tuple[int | None, ...]
    least: float
    fewest: int

    def __new__(cls, name: str, shape: tuple[int | None, ...], least: float = -LARGEST, fewest: int = 0) -> _Array:
        made = super().__new__(cls, name, (), {})
        made.shape, made.least, made.fewest = shape, least, fewest
        return made

    def __init__(cls, name: str, shape: tuple[int | None, ...], least: float = -LARGEST, fewest: int = 0) -> None:
        super().__init__(name, (), {})

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, np.ndarray)


if TYPE_CHECKING:
    Vector: TypeAlias = Floats
    Matrix: TypeAlias = Floats
    Sizes: TypeAlias = Floats
    SizeMatrix: TypeAlias = Floats
    Six: TypeAlias = Floats
    SixSizes: TypeAlias = Floats
    Covariance: TypeAlias = Floats
    Square: TypeAlias = Floats
    Numbers: TypeAlias = Floats
    Interval: TypeAlias = Floats
    PerCoefficient: TypeAlias = Floats
    SizePerCoefficient: TypeAlias = Floats
    Gains: TypeAlias = Floats
    FurtherGains: TypeAlias = Floats
else:
    Vector = _Array("Vector", (3,))
    Matrix = _Array("Matrix", (3, 3))
    Sizes = _Array("Sizes", (3,), 0.0)
    SizeMatrix = _Array("SizeMatrix", (3, 3), 0.0)
    Six = _Array("Six", (6,))
    SixSizes = _Array("SixSizes", (6,), 0.0)
    Covariance = _Array("Covariance", (12, 12))
    Square = _Array("Square", (None, None))
    Numbers = _Array("Numbers", (None,))
    Interval = _Array("Interval", (2,))
    PerCoefficient = _Array("PerCoefficient", (12,))
    SizePerCoefficient = _Array("SizePerCoefficient", (12,), 0.0)
    Gains = _Array("Gains", (12, None), fewest=3)
    FurtherGains = _Array("FurtherGains", (None, None))
Three: TypeAlias = Annotated[tuple[Size, ...], Meta(min_length=3, max_length=3)]
ByChannel: TypeAlias = Size | Three  # one number for all channels, or one for each


def array_of(kind: Any, told: Any) -> Floats:
    """Of what JSON has. Raises ValueError for another shape, and for what is no number or none of its range."""
    return _array(told, kind, kind.shape)


def _array(told: Any, kind: Any, shape: tuple[int | None, ...]) -> Floats:
    length, *inner = shape
    if not isinstance(told, list) or not (len(told) >= kind.fewest if length is None else len(told) == length):
        raise ValueError("an array of another length")
    if inner:
        return np.array([_array(row, kind, tuple(inner)) for row in told]).reshape(len(told), -1)
    are_numbers = set(map(type, told)) <= {int, float}
    if told and not (are_numbers and kind.least <= min(told) and max(told) < LARGEST and all(map(math.isfinite, told))):
        raise ValueError("an array of something else")
    return np.array(told, dtype=float)


def described(kind: type[Document]) -> tuple[str, dict[str, str]]:
    """What the docstring of a type says: of it, and by key of those that do not tell for themselves, also of those that
    it has from another type."""
    encoded = dict(zip(kind.__struct_fields__, kind.__struct_encode_fields__))
    lead: list[str] = []
    base = kind.__base__
    named = described(base)[1] if base is not None and issubclass(base, Document) else {}
    for paragraph in re.split(r"\n(?=\S)", cleandoc(kind.__doc__ or "")):
        key, colon, text = " ".join(paragraph.split()).partition(": ")
        if colon and key in encoded:
            named[encoded[key]] = text
        else:
            lead.append(key + colon + text)
    return " ".join(lead).strip(), named


def written(document: Document | dict[str, Any], leaf: Callable[[Any], Any] = lambda one: one) -> dict[str, Any]:
    """As JSON has it: dicts, lists, texts and numbers; of these last two what `leaf` makes of them."""

    def plain(value: Any) -> Any:  # lists in place of tuples
        if isinstance(value, dict):
            return {name: plain(one) for name, one in value.items()}
        return [plain(one) for one in value] if isinstance(value, (tuple, list)) else leaf(value)

    found: dict[str, Any] = plain(msgspec.to_builtins(document, enc_hook=lambda one: one.tolist()))
    return found


def to_json(document: Document | dict[str, Any]) -> str:
    """A document as text, innermost arrays on one line. A NaN would be a programming error and raises ValueError."""
    text = json.dumps(written(document), indent=2, allow_nan=False)
    return re.sub(r"\[\n\s+([^\[\]{}]*?)\n\s+\]", lambda array: f"[{' '.join(array[1].split())}]", text) + "\n"


DocumentT = TypeVar("DocumentT", bound=Document)


def read(kind: type[DocumentT], name: str, data: bytes, file: str) -> DocumentT:
    """A document of schema `name`, read from the `data` of a `file`. Raises BadInput, which names the key."""
    return checked(kind, name, _parsed(data, file), file)


def checked(kind: type[DocumentT], name: str, told: dict[str, Any], file: str) -> DocumentT:
    """As `read`, of what JSON has made of the data."""
    if told.get("schema") != name:
        raise BadInput(f"not a result of schema {name}: {_found(told, ['schema'])}", file)
    try:
        return msgspec.convert(told, kind, dec_hook=array_of)
    except msgspec.ValidationError as error:
        raise BadInput(f"not a result of schema {name}: {_fault(told, str(error))}", file) from None


def _parsed(data: bytes, file: str) -> dict[str, Any]:
    def refuse_constant(name: str) -> None:
        raise ValueError(f"{name} is not a number")

    try:
        told = _decoded(data) or json.loads(data.decode("utf-8-sig"), parse_constant=refuse_constant)
    except json.JSONDecodeError as error:
        if (kind := kind_of(data)) not in (None, JSON):
            raise BadInput(f"is {kind}; a result of tumble solve (JSON) is expected", file) from None
        raise BadInput(f"not valid JSON: {error.msg.lower()}", file, error.lineno, str(error.colno)) from None
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not valid JSON: {quoted(error)}", file) from None
    if not isinstance(told, dict):
        raise BadInput("not a result: an object is expected", file)
    return told


def _decoded(data: bytes) -> Any:
    """Four times as fast as json, which tells what is wrong where this gives None."""
    try:
        return msgspec.json.decode(data)
    except (msgspec.DecodeError, RecursionError):
        return None


_PLACE = re.compile(r"^(?P<what>.*?)(?: - at `(?:key in )?\$(?P<path>.*)`)?$", re.DOTALL)
_MISSING = re.compile(r"Object missing required field `(.*)`")


def _fault(told: dict[str, Any], message: str) -> str:
    """What msgspec found, in our words: the key that is missing, or what stands there; the rest as the types say it."""
    found = _PLACE.match(message)
    assert found is not None  # it matches anything
    path = re.findall(r"\.([^.\[]+)|\[(\d+|\.\.\.)\]", found["path"] or "")
    keys = [key or (int(index) if index.isdigit() else index) for key, index in path]
    if (missing := _MISSING.fullmatch(found["what"])) is not None:
        return f"no {_spelled([*keys, missing[1]])}"
    return _found(told, keys) if keys else found["what"]


def _found(told: Any, keys: list[Any]) -> str:
    """Such as "K[0][1] is 'abc'"."""
    for key in keys:
        if key == "..." or not isinstance(told, (dict, list)):
            break
        if isinstance(told, dict) and key not in told:
            return f"no {_spelled(keys)}"
        told = told[key]
    return f"{_spelled(keys)} is {quoted(told)}"


def _spelled(keys: list[Any]) -> str:
    return "".join(f".{key}" if isinstance(key, str) and key != "..." else f"[{key}]" for key in keys).lstrip(".")
