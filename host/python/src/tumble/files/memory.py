"""A bound on the memory that a library may take for a file, whatever that declares or decompresses to."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress

from tumble.errors import BadInput

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
