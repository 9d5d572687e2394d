"""Reading and writing whole files, with one-line errors and nothing half-written left behind."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO

from tumble.errors import BadInput, UsageError, quoted

_REASONS = {errno.ENOENT: "no such file or folder", errno.EISDIR: "a folder, not a file"}


def read_bytes(file: str) -> bytes:
    """All of a file. Raises BadInput."""
    with opened(file) as stream:
        try:
            return stream.read()
        except OSError as error:
            raise BadInput(reason(error), file) from None


def opened(file: str) -> BinaryIO:
    """A file to be read, which the caller closes. Raises BadInput."""
    try:
        return open(file, "rb")
    except OSError as error:
        raise BadInput(reason(error), file) from None
    except ValueError:  # a name with a zero byte
        raise BadInput("not a file name", file) from None


def write_text(file: str, text: str) -> None:
    """Write a text file, UTF-8, as `write_bytes` does."""
    write_bytes(file, text.encode("utf-8"))


def write_bytes(file: str, data: bytes) -> None:
    """Write a file as `written` does."""
    with written(file) as stream:
        stream.write(data)


@contextmanager
def written(file: str) -> Iterator[BinaryIO]:
    """A file to be written as a whole or not at all: into a temporary one beside it, then renamed. Raises BadInput.

    A pipe or a device, such as /dev/stdout, cannot be replaced and is written to directly.
    """
    try:
        with _opened(os.path.realpath(file)) as stream:
            yield stream
    except OSError as error:
        raise BadInput(f"cannot be written: {reason(error)}", file) from None
    except BadInput:
        raise
    except ValueError:
        raise BadInput("not a file name", file) from None


def refuse_overwriting(out: str | None, *sources: str | None, option: str = "--out") -> None:
    """An output, given by `option`, must not replace what it is made from. Raises UsageError."""
    for source in sources:
        if out and source and _is_same(out, source):
            raise UsageError(f"{option}: {quoted(out)} is an input of this command")


def _is_same(one: str, other: str) -> bool:
    try:
        return os.path.realpath(one) == os.path.realpath(other)
    except (OSError, ValueError):  # the working folder is gone; a name with a zero byte
        return False


@contextmanager
def _opened(target: str) -> Iterator[BinaryIO]:
    if os.path.exists(target) and not os.path.isfile(target):
        with open(target, "wb") as stream:
            yield stream
        return
    folder, name = os.path.split(target)
    temporary = os.path.join(folder, f".{name}.{os.getpid()}.tmp")
    handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        with os.fdopen(handle, "wb") as stream:
            yield stream
        if os.path.exists(target):
            os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
        os.replace(temporary, target)
    except BaseException:
        os.unlink(temporary)
        raise


def reason(error: OSError) -> str:
    """Why the system refused, in a few words."""
    return _REASONS.get(error.errno or 0, (error.strerror or "cannot be read").lower())
