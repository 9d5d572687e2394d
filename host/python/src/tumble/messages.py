"""What is said on standard error. Where nobody can read it, it is dropped; results and exit codes stay the same."""

from __future__ import annotations

import io
import sys

from tumble.signs import signed_for


def tell(line: str) -> None:
    """One line."""
    try:
        print(signed_for(line, sys.stderr), file=sys.stderr or io.StringIO(), flush=True)
    except (OSError, ValueError):  # full, gone, or closed
        sys.stderr = None


def on_terminal() -> bool:
    """Is there a person who watches?"""
    return sys.stderr is not None and sys.stderr.isatty()
