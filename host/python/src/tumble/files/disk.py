"""Files on disk: read and written as a whole, bounded, and told what they are instead.

What a file looks like that is not what was expected: for messages alone, nothing is read by it.

A bound on the memory that a library may take for a file, whatever that declares or decompresses to.

Reading and writing whole files, with one-line errors and nothing half-written left behind.
"""

from __future__ import annotations

import errno
import itertools
import os
import re
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import BinaryIO

from tumble.errors import BadInput, TumbleError, UsageError, file_name, quoted

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
        try:
            look(first := stream.read(_BLOCK))
            return joined(itertools.chain((first,), iter(lambda: stream.read(_BLOCK), b"")), file, most)
        except OSError as error:
            raise BadInput(reason(error), file) from None


def read_head(file: str, size: int) -> bytes:
    """How a file begins, `size` bytes at most. Raises BadInput."""
    with opened(file) as stream:
        try:
            return stream.read(size)
        except OSError as error:
            raise BadInput(reason(error), file) from None


def joined(blocks: Iterable[bytes], name: str, most: int) -> bytes:
    """All blocks. Raises BadInput as soon as there are more than `most` bytes of them."""
    found, size = [], 0
    for block in blocks:
        size += len(block)
        if size > most:
            raise BadInput(f"more than {in_words(most)}, which is the most that such a file may have", name)
        found.append(block)
    return b"".join(found)


def in_words(size: int) -> str:
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


def write_text(file: str, text: str) -> None:
    """Write a text file, UTF-8, as `written` does."""
    write_bytes(file, text.encode("utf-8"))


def write_bytes(file: str, data: bytes) -> None:
    """Write a file as `written` does."""
    with written(file) as stream:
        stream.write(data)


def write_all(files: Mapping[str, bytes]) -> None:
    """Write several files: all of them or none. Raises BadInput."""
    with together() as them:
        for file in sorted(files, key=_is_special):  # what cannot be taken back comes last
            with them.written(file) as stream:
                stream.write(files[file])


@contextmanager
def written(file: str) -> Iterator[BinaryIO]:
    """A file to be written as a whole or not at all: into a temporary one beside it, then renamed. Raises BadInput.

    A pipe or a device, such as /dev/stdout, cannot be replaced and is written to directly. See `refuse_link`.
    """
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
    """See `together`. Of files that were in these places before, one name is kept until all is done."""

    def __init__(self) -> None:
        self._staged: list[tuple[str, str, str]] = []  # as the user calls it, where it is, where it belongs
        self._kept: list[str] = []

    @contextmanager
    def written(self, file: str) -> Iterator[BinaryIO]:
        """One of them. Raises BadInput."""
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


def _is_same(one: str, other: str) -> bool:
    try:
        return os.path.realpath(one) == os.path.realpath(other)
    except (OSError, ValueError):  # the working folder is gone; a name with a zero byte
        return False


def reason(error: OSError) -> str:
    """Why the system refused, in a few words."""
    return _REASONS.get(error.errno or 0, (error.strerror or "cannot be read").lower())
