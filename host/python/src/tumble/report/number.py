"""The number of a report, which stands on every page: given, or made from what the result says."""

from __future__ import annotations

import hashlib
import json
import re
from datetime import date
from typing import Any

from tumble.errors import UsageError, quoted

LONGEST = 64
_DIGITS = 12  # hexadecimal: of ten thousand reports of a day, two have one number with a chance of 2e-7
_UNDATED = "undated"
_DATE = re.compile(r"\d{4}-\d\d-\d\d", re.ASCII)


def number_of(document: dict[str, Any]) -> str:
    """Such as T-20261123-9f3a1c77b2d4: the date of the result, the beginning of the SHA-256 of its content, whatever
    blanks its file has. The same result has the same number, and practically no other has it."""
    content = json.dumps(document, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    created = document.get("created")
    date = created[:10].replace("-", "") if isinstance(created, str) else _UNDATED
    return f"T-{date}-{hashlib.sha256(content.encode('ascii')).hexdigest()[:_DIGITS]}"


def require_date(text: object) -> str:
    """A date of issue of the user's own, as ISO 8601 writes it. Raises UsageError."""
    try:
        return date.fromisoformat(str(text) if _DATE.fullmatch(str(text)) else "").isoformat()
    except ValueError:
        said = quoted(text) if isinstance(text, str) else f"a {type(text).__name__}"
        raise UsageError(f"--issued: {said} is not a date such as 2026-11-28") from None


def require_number(text: object) -> str:
    """A number of the user's own. Raises UsageError."""
    if not isinstance(text, str) or not 1 <= len(text.strip()) <= LONGEST or not text.isprintable():
        said = quoted(text) if isinstance(text, str) else f"a {type(text).__name__}"
        raise UsageError(f"--number: {said} is not a text of 1 to {LONGEST} characters on one line")
    return text.strip()
