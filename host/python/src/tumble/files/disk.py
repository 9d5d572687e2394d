"""Files on disk, read and written as a whole or in blocks. Sizes are bounded, and a file of another kind is told so.

Errors are one line, and nothing half-written is left behind. What comes in, from a file or standard input, is
decompressed where gzip or zstd has compressed it: what it begins with tells, whatever the file's name is.
"""

from __future__ import annotations

import errno
import hashlib
import io
import itertools
import os
import re
import shutil
import stat
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from typing import Any, BinaryIO

from tumble.errors import BadInput, TumbleError, UsageError, file_name, needing, quoted

_HEAD_BYTES = 1 << 12
_MAGIC = {b"PK\x03\x04": "a ZIP or NPZ file", b"\x89PNG": "a PNG picture", b"%PDF": "a PDF file", b"PAR1": "Parquet"}
_TOML = re.compile(r"\[\[?\s*[\w.\"'-]+\s*\]\]?\s*(#.*)?$|[\w.\"'-]+\s*=\s*\S")
CSV, JSON, TOML = "CSV, such as a run file", "JSON, such as a result", "TOML, such as a stand or a schedule file"


def kind_of(data: bytes) -> str | None:
    """What the beginning of a file looks like, as a message calls it; None: nothing that is known."""
    found = next((kind for magic, kind in _MAGIC.items() if data.startswith(magic)), None)
    lines = data[:_HEAD_BYTES].decode("utf-8-sig", errors="replace").splitlines()
    filled = [line.strip() for line in lines if line.strip() and not line.startswith("#")]
    first = filled[0] if filled else ""
    if found is not None or not first:
        return found
    if first[0] == "{" or first == "[":
        return JSON
    if first[0] == "<":
        return "HTML or XML"
    if any(map(_TOML.match, filled)):  # the first line may be what is wrong with it
        return TOML
    return CSV if any(first.count(sign) >= 2 for sign in ",;\t") else None


MOST = 4 << 30  # bytes, beside what the process has


@contextmanager
def bounded(file: str) -> Iterator[None]:
    """While a library reads `file`, this process gets at most MOST bytes of address space more than it has. Raises
    BadInput where that is not enough. Only Linux has such a bound; elsewhere there is none."""
    try:
        import resource

        with open("/proc/self/statm", encoding="ascii") as sizes:
            limit = int(sizes.read().split()[0]) * resource.getpagesize() + MOST
    except (ImportError, OSError):
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    if soft == resource.RLIM_INFINITY or limit < soft:
        with suppress(OSError, ValueError):
            resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    try:
        yield
    except MemoryError:
        raise BadInput(f"needs more memory than such a file may ({MOST >> 30} GiB)", file) from None
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


RUN_FILE, RESULT_FILE = "run.csv", "result.json"  # in a run folder

# What a file that is held in memory as a whole may have, in bytes; docs/files.md lists what they are for.
MIB = 1 << 20
MOST_OF_DOCUMENT = 64 * MIB
MOST_OF_RECORDING = 1024 * MIB
LONGEST_LINE = MIB  # of a text that is read in pieces
_BLOCK = MIB
_REASONS = {errno.ENOENT: "no such file or folder", errno.EISDIR: "a folder, not a file"}


def path_of(file: object) -> str:
    """A path as text. Raises UsageError for what is none."""
    path = os.fspath(file) if isinstance(file, (str, os.PathLike)) else None
    if not isinstance(path, str):
        raise UsageError(f"a {type(file).__name__} is not the path of a file")
    return path


def read_bytes(
    file: str,
    within: str | None = None,
    most: int = MOST_OF_DOCUMENT,
    look: Callable[[bytes], None] = lambda _: None,
) -> bytes:
    """All of a file or a pipe, which may have `most` bytes. `within`: the file of a run folder to be advised where a
    folder is given; `look` sees how it begins before the rest is read. Raises BadInput."""
    if within is not None:
        require_no_folder_of(file, within)
    with opened(file) as stream:
        blocks = blocks_of(stream, file)
        look(first := next(blocks, b""))
        return joined(itertools.chain((first,), blocks), file, most)


def blocks_of(stream: BinaryIO, file: str, size: int = _BLOCK) -> Iterator[bytes]:
    """What is left to be read. Raises BadInput."""
    try:
        while block := stream.read(size):
            yield block
    except OSError as error:
        raise BadInput(reason(error), file) from None


def joined(blocks: Iterable[bytes], name: str, most: int) -> bytes:
    """All blocks. Raises BadInput as soon as there are more than `most` bytes of them."""
    found, size = [], 0
    for block in blocks:
        size += len(block)
        if size > most:
            raise BadInput(f"more than {size_text(most)}, which is the most that such a file may have", name)
        found.append(block)
    return b"".join(found)


def size_text(size: int) -> str:
    """A limit in bytes, as messages have it."""
    return f"{size // MIB} MiB" if size % MIB == 0 else f"{size} bytes"


def require_no_folder_of(file: str, within: str) -> None:
    """Raises BadInput for a run folder, where its file `within` is what is wanted."""
    if os.path.isfile(inner := os.path.join(path_of(file), within)):
        raise BadInput(f"a folder, not a file: give {file_name(inner)}", file)


def opened(file: str) -> BinaryIO:
    """A file to be read, which the caller closes. Raises BadInput."""
    path = path_of(file)
    try:
        return open(path, "rb")
    except OSError as error:
        raise BadInput(reason(error), file) from None
    except ValueError:  # a name with a zero byte
        raise BadInput("not a file name", file) from None


STANDARD_INPUT = "-"  # as the command line names it
MOST_IN_ALL = 4 << 30  # bytes, decompressed: of an input that is read in blocks
_GZIP, _ZSTD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"


def name_of(file: str) -> str:
    """As messages have it."""
    return "standard input" if file == STANDARD_INPUT else file


class Incoming:
    """An input, to be gone through once: `name` as messages have it; `sha256` of its bytes as they are, compressed or
    not, in hexadecimal digits, when all have been read. Raises BadInput, NotInstalled."""

    def __init__(self, file: str, block: int = _BLOCK):
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
                stream: Any = io.BufferedReader(_Whole(raw, self._hash.update), self._block)
                magic, size, source = stream.peek(4)[:4], 0, stream
                if magic.startswith(_GZIP):
                    import gzip

                    source = gzip.GzipFile(fileobj=stream)
                elif magic == _ZSTD:
                    source = self._zstd(stream)
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

    def _zstd(self, stream: BinaryIO) -> Any:
        try:
            from compression import zstd  # of Python 3.14
        except ImportError:
            with needing(f"{file_name(self.name)}: zstd", "backports.zstd", extra="zstd"):
                from backports import zstd
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
    """As Incoming: a name, a digest and blocks, but of bytes that are in memory."""

    def __init__(self, data: bytes, name: str, sha256: str | None = None):
        self.name, self.data = name, data
        self.sha256 = hashlib.sha256(data).hexdigest() if sha256 is None else sha256

    def __iter__(self) -> Iterator[bytes]:
        return (self.data[begin : begin + _BLOCK] for begin in range(0, len(self.data), _BLOCK))


def held(file: str) -> Held:
    """All of an input, decompressed. Raises BadInput, NotInstalled."""
    incoming = Incoming(file)
    data = joined(incoming, incoming.name, MOST_OF_RECORDING)
    return Held(data, incoming.name, incoming.sha256)


def write_text(file: str, text: str) -> None:
    """Write a text file, UTF-8, as `written` does."""
    write_bytes(file, text.encode("utf-8"))


def write_bytes(file: str, data: bytes) -> None:
    """Write a file as `written` does."""
    write_all({file: data})


def write_all(files: Mapping[str, bytes]) -> None:
    """Write several files: all of them or none. Raises BadInput."""
    with together() as them:
        for file in sorted(files, key=_is_special):  # what cannot be taken back comes last
            with them.written(file) as stream:
                stream.write(files[file])


@contextmanager
def written(file: str) -> Iterator[BinaryIO]:
    """A file to be written as a whole or not at all. Raises BadInput."""
    with together() as them, them.written(file) as stream:
        yield stream


@contextmanager
def together() -> Iterator[Together]:
    """Files that are written all or none: they are put in their places at the end, when all are there."""
    them = Together()
    try:
        yield them
        them.put_in_place()
    finally:
        them.discard()


class Together:
    """See `together`. Of files that were in these places before, one name is kept until all is done.

    A pipe or a device, such as /dev/stdout, cannot be replaced and is written to directly. See `refuse_link`.
    """

    def __init__(self) -> None:
        self._staged: list[tuple[str, str, str]] = []  # as the user calls it, where it is, where it belongs
        self._kept: list[str] = []

    @contextmanager
    def written(self, file: str) -> Iterator[BinaryIO]:
        """One of them: a temporary file beside it, to be renamed. Raises BadInput."""
        with _naming(file):
            target = os.path.realpath(file)
            refuse_link(file)
            if _is_special(target):
                with open(target, "wb") as stream:
                    yield stream
                return
            temporary = _beside(target, "tmp")
            handle = os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
            self._staged.append((file, temporary, target))
            with os.fdopen(handle, "wb") as stream:
                yield stream

    def put_in_place(self) -> None:
        """All of them; where one cannot be, none. Raises BadInput."""
        done: list[tuple[str, str | None]] = []
        last = len(self._staged) - 1
        try:
            for place, (file, temporary, target) in enumerate(self._staged):
                with _naming(file):
                    before = self._keep(target) if place < last else None
                    if os.path.exists(target):
                        os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
                    os.replace(temporary, target)
                if place < last:  # with the last one all is done: nothing is taken back any more
                    done.append((target, before))
        except BaseException:
            for target, before in done:
                if before is None:
                    os.unlink(target)
                else:
                    os.replace(before, target)
            raise

    def _keep(self, target: str) -> str | None:
        """Another name of the file that is there; None: there is none."""
        if not os.path.exists(target):
            return None
        other = _beside(target, "old")
        self._kept.append(other)
        try:
            os.link(target, other)
        except OSError:  # not every file system has links
            shutil.copy2(target, other)
        return other

    def discard(self) -> None:
        """What is not in its place, and what was kept."""
        for file in (*(temporary for _, temporary, _ in self._staged), *self._kept):
            with suppress(FileNotFoundError):
                os.unlink(file)


@contextmanager
def _naming(file: str) -> Iterator[None]:
    """What the system says becomes BadInput."""
    try:
        yield
    except OSError as error:
        raise BadInput(f"cannot be written: {reason(error)}", file) from None
    except TumbleError:
        raise
    except ValueError:
        raise BadInput("not a file name", file) from None


def refuse_link(file: str) -> None:
    """A symbolic link is no place for an output: whoever may put one there would choose which file is replaced. Those
    of the system, such as /dev/stdout, are. Raises BadInput."""
    if os.path.islink(file) and not os.path.abspath(file).startswith(("/dev/", "/proc/")):
        target = file_name(os.path.realpath(file))
        raise BadInput(f"cannot be written: a symbolic link to {target}: name that file itself", file)


def _is_special(file: str) -> bool:
    """Is it there, but no file that can be replaced?"""
    return os.path.exists(file) and not os.path.isfile(file)


def _beside(target: str, suffix: str) -> str:
    """A hidden file of this process."""
    folder, name = os.path.split(target)
    return os.path.join(folder, f".{name}.{os.getpid()}.{suffix}")


def refuse_overwriting(out: str | None, *sources: str | None, option: str = "--out") -> None:
    """An output, given by `option`, must not replace what it is made from, nor be a link. Raises UsageError,
    BadInput."""
    for source in sources:
        if out and source and _is_same(out, source):
            raise UsageError(f"{option}: {quoted(out)} is an input of this command")
    if out:
        refuse_link(out)


def pieces(blocks: Iterable[bytes], file: str) -> Iterator[bytes]:
    """The same bytes, cut where lines end. Raises BadInput for a line that does not end."""
    parts: list[bytes] = []
    held = 0
    for block in blocks:
        cut = block.rfind(b"\n") + 1 or block.rfind(b"\r", 0, len(block) - 1) + 1  # a last \r may be half an end
        if cut:
            yield b"".join((*parts, block[:cut]))
            parts, held = [], 0
        parts.append(block[cut:])
        held += len(block) - cut
        if held > LONGEST_LINE:
            raise BadInput(f"a line of more than {size_text(LONGEST_LINE)}", file)
    if last := b"".join(parts):
        yield last


def _is_same(one: str, other: str) -> bool:
    try:
        return os.path.realpath(one) == os.path.realpath(other)
    except (OSError, ValueError):  # the working folder is gone; a name with a zero byte
        return False


def reason(error: OSError) -> str:
    """Why the system refused, in a few words."""
    return _REASONS.get(error.errno or 0, (error.strerror or "cannot be read").lower())
