"""Messages in the words of whoever is told. Errors and warnings are the same for scripts and for the command line; they
advise options (--unit), which scripts know as arguments (unit=)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from tumble.errors import BadInput, TumbleError

_NAMES = "columns|decimal|delimiter|estimator|logo|model|number|run|schedule|stand|template|unit"
_COLUMNS = re.compile(r"--columns (\w+=[^\s,;)]+(?:,\w+=[^\s,;)]+)*)")
_WITH_VALUES = (
    (re.compile(r"--(estimator|model) (\w+(?:,\w+)*)"), r'\1="\2"'),
    (re.compile(r"--(unit) (\w+) or (\w+)"), r'\1="\2" or "\3"'),
    (re.compile(r"--(unit) (\S+?)(?=[,)]|$)"), r'\1="\2"'),
    (re.compile(r"--(decimal) ([.,])(?=\))"), r'\1="\2"'),
    (re.compile(r"--(stand) FILE"), r"\1="),
    (re.compile(rf"--({_NAMES}):"), r"\1:"),
    (re.compile(rf"--({_NAMES})(?![\w-])"), r"\1="),
)


def in_python(message: str) -> str:
    """A message with arguments in place of options, such as columns={'uy': 'NAME'} for --columns uy=NAME."""
    message = _COLUMNS.sub(lambda found: f"columns={_mapping(found[1])}", message)
    for pattern, argument in _WITH_VALUES:
        message = pattern.sub(argument, message)
    return message


def _mapping(columns: str) -> str:
    return str(dict(part.split("=", 1) for part in columns.split(",")))


@contextmanager
def told_in_python() -> Iterator[None]:
    """What is raised within tells of arguments. The names of files stay as they are."""
    try:
        yield
    except BadInput as error:
        where = str(error).removesuffix(error.fault)
        error.fault = in_python(error.fault)
        error.args = (where + error.fault,)
        raise
    except TumbleError as error:
        error.args = (in_python(str(error)),)
        raise
