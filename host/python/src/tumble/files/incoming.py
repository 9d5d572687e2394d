"""Data that come in: from files, packed or not, and from tables of other formats.

The bytes of an input in blocks, and their SHA-256: of a file or of standard input, decompressed where gzip or zstd
has compressed them. What they begin with tells, whatever the file's name is.

Files of tables other than CSV: Parquet, NumPy's NPZ and MATLAB's MAT, as tables that `frames` knows.

The libraries are loaded when such a file is read. Raises BadInput; NotInstalled where a library is not there.
"""

from __future__ import annotations

import hashlib
import io
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from typing import Any, BinaryIO

import numpy as np

from tumble.errors import BadInput, NotInstalled, file_name, quoted
from tumble.files.disk import MOST_OF_RECORDING, RUN_FILE, bounded, joined, opened, reason, require_no_folder_of

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
        if self._file != STANDARD_INPUT:
            require_no_folder_of(self._file, RUN_FILE)
        try:
            with nullcontext(sys.stdin.buffer) if self._file == STANDARD_INPUT else opened(self._file) as raw:
                stream = io.BufferedReader(_Whole(raw, self._hash.update), self._block)
                source, size = self._decompressed(stream), 0
                while block := source.read(self._block):
                    size += len(block)
                    if size > MOST_IN_ALL:
                        raise BadInput(f"more than {MOST_IN_ALL >> 30} GiB, decompressed", self.name)
                    yield block
                while stream.read(self._block):  # of what follows compressed data only the hash is taken
                    pass
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
