"""Data that come in: from files, packed or not, from tables of other formats, as lines of CSV.

The bytes of an input in blocks, and their SHA-256: of a file or of standard input, decompressed where gzip or zstd
has compressed them. What they begin with tells, whatever the file's name is.

Files of tables other than CSV: Parquet, NumPy's NPZ and MATLAB's MAT, as tables that `frames` knows.

The libraries are loaded when such a file is read. Raises BadInput; NotInstalled where a library is not there.

Rows of a CSV file whose layout is known, as numbers: fast where many lines are plain, carefully where one is not.

What a run file and measured data have in common. The fast way proves first, from the places of delimiters and line
ends, that every line has as many fields as the header; what it does not take for certain is left to the careful way,
line by line, which is the one that complains.
"""

from __future__ import annotations

import csv
import hashlib
import io
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, BinaryIO

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.core import MAX_MEAN
from tumble.errors import BadInput, NotInstalled, file_name, quoted
from tumble.files.disk import MOST_OF_RECORDING, RUN_FILE, bounded, joined, opened, reason, require_no_folder_of
from tumble.files.run_layout import NUMBER, Layout, decoded, split

STANDARD_INPUT = "-"  # as the command line names it
BLOCK = 1 << 20
MOST_IN_ALL = 4 << 30  # bytes, decompressed: of an input that is read in blocks
_GZIP, _ZSTD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"


def name_of(file: str) -> str:
    """As messages have it."""
    return "standard input" if file == STANDARD_INPUT else file


class Incoming:
    """An input, to be gone through once: `name` as messages have it; `sha256` of its bytes as they are, compressed or
    not, in hexadecimal digits, when all have been read. Raises BadInput, NotInstalled."""

    def __init__(self, file: str, block: int = BLOCK):
        self.name = name_of(file)
        self._file, self._block = file, block
        self._hash = hashlib.sha256()

    @property
    def sha256(self) -> str:
        """Of what has been read."""
        return self._hash.hexdigest()

    def __iter__(self) -> Iterator[bytes]:
        with self._opened() as raw, self._naming():
            stream = io.BufferedReader(_Whole(raw, self._hash.update), self._block)
            source, size = self._decompressed(stream), 0
            while block := source.read(self._block):
                size += len(block)
                if size > MOST_IN_ALL:
                    raise BadInput(f"more than {MOST_IN_ALL >> 30} GiB, decompressed", self.name)
                yield block
            while stream.read(self._block):  # of what follows compressed data only the hash is taken
                pass

    @contextmanager
    def _opened(self) -> Iterator[BinaryIO]:
        if self._file == STANDARD_INPUT:
            yield sys.stdin.buffer
            return
        require_no_folder_of(self._file, RUN_FILE)
        with opened(self._file) as raw:
            yield raw

    @contextmanager
    def _naming(self) -> Iterator[None]:
        """What the system or a decompressor says becomes BadInput."""
        try:
            yield
        except BadInput:
            raise
        except EOFError:
            raise BadInput("its compressed data end too early", self.name) from None
        except OSError as error:
            raise BadInput(reason(error) if error.errno else f"cannot be read: {quoted(error)}", self.name) from None
        except Exception as error:
            if type(error).__name__ not in ("error", "ZstdError"):  # of zlib and zstd, which are loaded when needed
                raise
            raise BadInput(f"its compressed data are damaged: {quoted(error)}", self.name) from None

    def _decompressed(self, stream: Any) -> Any:
        magic = stream.peek(4)[:4]
        if magic.startswith(_GZIP):
            import gzip

            return gzip.GzipFile(fileobj=stream)
        return self._zstd(stream) if magic == _ZSTD else stream

    def _zstd(self, stream: BinaryIO) -> Any:
        try:
            from compression import zstd  # of Python 3.14
        except ImportError:
            try:
                from backports import zstd
            except ImportError:
                raise NotInstalled(f"{file_name(self.name)}: zstd", "backports.zstd", extra="zstd") from None
        return zstd.ZstdFile(stream)


class _Whole(io.RawIOBase):
    """A stream that fills whatever it is given to fill, as a pipe does not, and shows `see` what it read."""

    def __init__(self, raw: BinaryIO, see: Callable[[memoryview], None]):
        self._raw, self._see = raw, see

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        view, filled = memoryview(buffer).cast("B"), 0
        while filled < len(view):
            count = self._raw.readinto(view[filled:])  # type: ignore[attr-defined]
            if not count:
                break
            filled += count
        self._see(view[:filled])
        return filled


class Held:
    """The same of bytes that are in memory."""

    def __init__(self, data: bytes, name: str, sha256: str | None = None):
        self.name, self.data = name, data
        self.sha256 = hashlib.sha256(data).hexdigest() if sha256 is None else sha256

    def __iter__(self) -> Iterator[bytes]:
        return (self.data[begin : begin + BLOCK] for begin in range(0, len(self.data), BLOCK))


def held(file: str) -> Held:
    """All of an input, decompressed. Raises BadInput, NotInstalled."""
    incoming = Incoming(file)
    data = joined(incoming, incoming.name, MOST_OF_RECORDING)
    return Held(data, incoming.name, incoming.sha256)


PARQUET = (".parquet", ".pq")
_NPZ, _MAT = ".npz", ".mat"
SUFFIXES = (*PARQUET, _NPZ, _MAT)


def suffix_of(file: str | os.PathLike[str]) -> str:
    """Of a file's name, in small letters."""
    return os.path.splitext(os.fspath(file))[1].lower()


def read_table_file(file: str) -> Any:
    """The table in a file with one of SUFFIXES."""
    suffix = suffix_of(file)
    reader = _read_npz if suffix == _NPZ else _read_mat if suffix == _MAT else _read_parquet
    try:
        with bounded(file):
            return reader(file)
    except (BadInput, NotInstalled):
        raise
    except OSError as error:
        raise BadInput(reason(error) if error.errno else f"cannot be read: {quoted(error)}", file) from None
    except Exception as error:  # each library has classes of its own for what is no file of its kind
        raise BadInput(f"not a {suffix[1:]} file that can be read: {quoted(error)}", file) from None


def _read_parquet(file: str) -> Any:
    with open(file, "rb"):
        pass  # the system's own complaint, whatever the library's is
    try:
        from pyarrow import parquet
    except ImportError:
        pass
    else:
        return parquet.read_table(file)
    try:
        import polars
    except ImportError:
        raise NotInstalled(f"{file_name(file)}: Parquet", "pyarrow", "polars", extra="parquet") from None
    return polars.read_parquet(file)


def _read_npz(file: str) -> dict[str, Any]:
    import zipfile

    if not zipfile.is_zipfile(file):
        with open(file, "rb"):
            raise BadInput("not an NPZ file", file)
    with np.load(file, allow_pickle=False) as arrays:
        return {name: np.ravel(arrays[name]) for name in arrays.files}


def _read_mat(file: str) -> dict[str, Any]:
    try:
        from scipy.io import loadmat
    except ImportError:
        raise NotInstalled(f"{file_name(file)}: MAT", "scipy", extra="mat") from None
    with open(file, "rb"):
        pass
    try:
        found = loadmat(file)
    except NotImplementedError:
        raise BadInput("MATLAB 7.3, which is HDF5: save it with -v7", file) from None
    return {name: np.ravel(values) for name, values in found.items() if not name.startswith("__")}


LARGEST_OUTPUT: float = MAX_MEAN  # of either sign: beyond, no output is believed
_NOT_FINITE = {"nan", "inf", "infinity"}
_DIGITS = re.compile(r"[+-]?\d*(e[+-]?\d+)?", re.IGNORECASE)  # what a decimal comma leaves on either side of it


class Refused(Exception):
    """What is wrong with a row, and in which column."""

    def __init__(self, message: str, column: str | None = None):
        super().__init__(message)
        self.column = column


class NotANumber(Refused):
    """A `text` that is none with the decimal mark of the file."""

    def __init__(self, text: str, column: str):
        super().__init__(f"{quoted(text)} is not a number" if text else "no value", column)
        self.text = text


def fast_numbers(data: bytes, body: int, layout: Layout) -> tuple[Floats, Flags] | None:
    """The wanted columns (rows, wanted) of all that follows byte `body`, where a line begins; and which of its lines
    (lines,) hold a row, what follows the last line end being one more. None where that is not plain or not in order."""
    if not _is_plain(data, body, layout):
        return None
    full = _full_lines(data, body, layout)
    if full is None:
        return None
    if layout.decimal == ",":
        data = data.replace(b",", b".")
    stream = io.BytesIO(data)
    stream.seek(body)
    try:
        values = np.loadtxt(
            stream, delimiter=layout.delimiter, usecols=layout.indices, comments=None, encoding="latin-1", ndmin=2
        )
    except ValueError:
        return None
    return values, full


def read_plain(data: bytes, layout: Layout) -> tuple[Floats, Integers, int] | None:
    """The numbers in the layout's columns, their lines, and how many blank lines there are; None where the file is not
    plain."""
    found = fast_numbers(data, _end_of_line(data, layout.header_row), layout)
    if found is None:
        return None
    values, full = found
    lines = layout.header_row + 1 + np.flatnonzero(full)
    blanks = int((~full).sum()) - (0 if full[-1] else 1)  # what follows the last line end is no line
    return values, lines, layout.blanks + blanks


def _end_of_line(data: bytes, row: int) -> int:
    """Where the line after line number `row` begins."""
    end = 0
    for _ in range(row):
        newline = data.find(b"\n", end)
        end = len(data) if newline < 0 else newline + 1
    return end


def body_of(data: bytes, layout: Layout) -> Iterable[tuple[int, str]]:
    """What follows the header: lines and their numbers."""
    lines = enumerate(io.StringIO(decoded(data), newline=None), start=1)
    return ((row, line) for row, line in lines if row > layout.header_row)


def _is_plain(data: bytes, body: int, layout: Layout) -> bool:
    """No quotes, comments or lone carriage returns; one decimal mark, and that not the delimiter."""
    unusual = [b'"', b"#"] + ([b"."] if layout.decimal == "," else [])
    return (
        not any(data.find(sign, body) >= 0 for sign in unusual)
        and data.count(b"\r") == data.count(b"\r\n")
        and layout.decimal != layout.delimiter
        and layout.delimiter.isascii()
    )


def _full_lines(data: bytes, body: int, layout: Layout) -> Flags | None:
    """Which lines of the body hold a row, what follows the last line end being one more; None unless each has as many
    fields as the header, or nothing."""
    signs = np.frombuffer(data, dtype=np.uint8)[body:]
    ends = np.append(np.flatnonzero(signs == ord("\n")), len(signs))
    delimiters = np.searchsorted(np.flatnonzero(signs == ord(layout.delimiter)), ends)
    lengths = np.diff(ends, prepend=-1) - 1
    carriage_returns = np.zeros(len(ends), dtype=bool)
    carriage_returns[lengths == 1] = signs[ends[lengths == 1] - 1] == ord("\r")
    empty: Flags = (lengths == 0) | carriage_returns
    full = np.diff(delimiters, prepend=0) == layout.width - 1
    return None if not (empty | full).all() or empty.all() else ~empty


def row_of_numbers(line: str, layout: Layout, columns: tuple[str, ...]) -> list[float]:
    """The wanted `columns` of one line. Raises Refused."""
    try:
        fields = split(line, layout.delimiter)
    except csv.Error as error:
        raise Refused(f"cannot be split into columns: {error}") from None
    if len(fields) != layout.width:
        raise Refused(wrong_width(fields, layout.width, layout.delimiter))
    return [_number(fields[index], column, layout) for column, index in zip(columns, layout.indices)]


def wrong_width(fields: list[str], width: int, delimiter: str, advice: str = "") -> str:
    """What to say of a row that has not as many fields as the header, with `advice` unless there is a better one."""
    if delimiter == "," and len(fields) > width and all(map(_DIGITS.fullmatch, fields)):
        advice = "; if some of its commas are decimal marks, write the file with semicolons or with decimal points"
    return f"{len(fields)} fields, but the header has {width}{advice}"


def _number(text: str, column: str, layout: Layout) -> float:
    if text.lower().lstrip("+-") in _NOT_FINITE:
        raise Refused(f"{quoted(text)} is not a finite number", column)
    pointed = text.replace(",", ".") if layout.decimal == "," and "." not in text else text
    if not NUMBER.fullmatch(pointed) or (layout.decimal == "," and "." in text):
        raise NotANumber(text, column)
    value = float(pointed)
    if abs(value) > LARGEST_OUTPUT:
        raise Refused(f"{quoted(text)} is out of range", column)
    return value
