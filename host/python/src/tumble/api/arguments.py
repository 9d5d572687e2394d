"""What callers say, looked at before it is used: what cannot be meant is a UsageError that names the argument.

And what they are told, in their words (`in_python`): errors and warnings are the same for scripts and for the command
line; they advise options (--unit), which scripts know as arguments (unit=).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from numbers import Real
from typing import Any

import numpy as np

from tumble.errors import BadInput, TumbleError, UsageError, quoted
from tumble.files.run_layout import COLUMNS, DECIMALS, TEMPERATURE, LayoutOptions, is_delimiter
from tumble.schedule import BUILT_IN
from tumble.units import is_unit, spelled

_NAMES = (
    "accelerometer|at|columns|dbc|decimal|delimiter|estimator|growth|logo|"
    "model|number|prior|run|schedule|stand|temperature|template|unit"
)
_COLUMNS = re.compile(r"--columns (\w+=(?!:)[^\s,;)]+(?:,\w+=[^\s,;)]+)*)")
_OPTION = re.compile(r"--(?=[a-z])")
_WITH_VALUES = (
    (re.compile(r"--columns (\w+)=:"), r"columns: \1:"),
    (re.compile(r"--(estimator|model) (\w+(?:,\w+)*)"), r'\1="\2"'),
    (re.compile(r"--(unit) (\w+) or (\w+)"), r'\1="\2" or "\3"'),
    (re.compile(r"--(unit) (\S+?)(?=[,)]|$)"), r'\1="\2"'),
    (re.compile(r"--(decimal) ([.,])(?=\))"), r'\1="\2"'),
    (re.compile(rf"--(schedule) ({'|'.join(BUILT_IN)})(?![\w.-])"), r'\1="\2"'),
    (re.compile(r"--(dbc) FILE.dbc"), r"\1="),
    (re.compile(r"--(growth) SCALE,ANGLE,BIAS"), r"\1=(SCALE, ANGLE, BIAS)"),
    (re.compile(r"--(stand) FILE"), r"\1="),
    (re.compile(r"--(resume)(?![\w-])"), r"\1=True"),
    (re.compile(r"--(accelerometer) (\d+)"), r"\1=\2"),
    (re.compile(rf"--({_NAMES}):"), r"\1:"),
    (re.compile(rf"--({_NAMES})(?![\w-])"), r"\1="),
)


def in_python(message: str) -> str:
    """A message with arguments in place of options, such as columns={'uy': 'NAME'} for --columns uy=NAME."""
    message = _COLUMNS.sub(lambda found: f"columns={dict(one.split('=', 1) for one in found[1].split(','))}", message)
    for pattern, argument in _WITH_VALUES:
        message = pattern.sub(argument, message)
    return message


def import_in_python(message: str) -> str:
    """A message of an import, where `tumble.read` has an argument for all that it advises. Else it is about options of
    `tumble import`, and says so."""
    told = in_python(message)
    if "--stand" in message or _OPTION.search(told):
        return _OPTION.sub("tumble import --", message, count=1)
    return told


@contextmanager
def told_in_python(reword: Callable[[str], str] = in_python) -> Iterator[None]:
    """What is raised within is told with what `reword` makes of it. The names of files stay as they are."""
    try:
        yield
    except BadInput as error:
        where = str(error).removesuffix(error.fault)
        error.fault = reword(error.fault)
        error.args = (where + error.fault,)
        error.assumed = tuple(map(reword, error.assumed))
        raise
    except TumbleError as error:
        error.args = (reword(str(error)),)
        raise


def layout_options(
    columns: Any, unit: Any, delimiter: Any = None, decimal: Any = None, wanted: tuple[str, ...] = COLUMNS
) -> LayoutOptions:
    """What a caller says about the layout of data with the `wanted` columns. Raises UsageError."""
    if delimiter is not None and not is_delimiter(delimiter):
        raise UsageError(f"delimiter: {quoted(delimiter)} is not a single sign that can separate columns")
    if decimal is not None and not is_one_of(decimal, DECIMALS):
        raise UsageError(f"decimal: {quoted(decimal)} is neither a point nor a comma")
    unit = spelled(unit) if isinstance(unit, str) else unit
    require_unit(unit, "unit")
    return LayoutOptions(_names(columns, (*wanted, TEMPERATURE)), delimiter, decimal, unit, wanted)


def _names(columns: Any, known: tuple[str, ...]) -> dict[str, str]:
    if columns is None:
        return {}
    if not isinstance(columns, Mapping):
        raise UsageError(
            f"columns: a {type(columns).__name__} is no mapping of names, such as {{'{known[0]}': 'Name'}}"
        )
    for wanted, name in columns.items():
        if wanted not in known:
            raise UsageError(f"columns: {quoted(wanted)} is not one of {', '.join(known)}")
        if not isinstance(name, str) or not name:
            raise UsageError(f"columns: {quoted(name)} (for {wanted}) is no name of a column")
    return dict(columns)


def require_unit(unit: Any, argument: str) -> None:
    """Raise UsageError for what is no unit; None is none, and good."""
    if unit is not None and not is_unit(unit):
        raise UsageError(f"{argument}: {quoted(unit)} is not a unit such as V, mV or m/s^2")


def is_one_of(value: Any, known: Iterable[str]) -> bool:
    """Is this one of the known words? A value of any other type is not; == alone would compare an array by elements."""
    return isinstance(value, str) and value in known


def require_flag(value: Any, argument: str) -> None:
    """Raise UsageError for what is neither true nor false."""
    if not (isinstance(value, (Real, np.bool_)) and value in (0, 1)):
        raise UsageError(f"{argument}: {quoted(value)} is neither True nor False")


def as_number(value: Any) -> float:
    """NaN for what is no real number: outside every range."""
    try:
        return float(value) if isinstance(value, Real) else math.nan
    except OverflowError:
        return math.nan


def as_list(model: Any) -> str | None:
    """The terms of a model, one text or several, as --model takes them; None: none. Raises UsageError."""
    try:
        terms = [model] if isinstance(model, str) else list(model)
    except TypeError:
        terms = [model]
    if not all(isinstance(term, str) for term in terms):
        raise UsageError(f"model: {quoted(model)} is neither a text nor several")
    return ",".join(terms) or None
