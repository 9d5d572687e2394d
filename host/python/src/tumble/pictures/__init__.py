"""Pictures, with matplotlib, which is loaded when one is drawn.

comparison     two calibrations of one block
"""

from __future__ import annotations

import io
import os
from typing import Any

from tumble.errors import NotInstalled, UsageError, quoted
from tumble.pictures.comparison import comparison

__all__ = ["comparison", "require_format", "written"]
FORMATS = (".png", ".svg", ".pdf")


def require_format(file: str, option: str) -> None:
    """Raises UsageError for a file that is not of FORMATS, NotInstalled where matplotlib is not there. `option`: what
    the user calls it."""
    if os.path.splitext(file)[1].lower() not in FORMATS:
        raise UsageError(f"{option}: {quoted(file)} does not end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    try:
        import matplotlib  # type: ignore[import-not-found, unused-ignore] # noqa: F401
    except ImportError:
        raise NotInstalled(option, "matplotlib", extra="plot") from None


def written(figure: Any, file: str) -> bytes:
    """The picture in the format that the file's name says."""
    kind = os.path.splitext(file)[1][1:].lower()
    target = io.BytesIO()
    no_dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    figure.savefig(target, format=kind, dpi=150, metadata=no_dates)
    return target.getvalue()
