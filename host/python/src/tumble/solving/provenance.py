"""When, by what and from what a result was made."""

from __future__ import annotations

import os
import re
from datetime import datetime, timezone

from tumble.errors import UsageError, quoted

_LATEST = 253402300799  # the last second of the year 9999


def created(clock: bool = True) -> str | None:
    """Now, UTC, in the form of ISO 8601, or the second that SOURCE_DATE_EPOCH names where it is set. Without `clock`,
    as for a run in virtual time, which has no date, None unless it is set.

    Raises UsageError for a SOURCE_DATE_EPOCH that is no whole number of seconds.
    """
    told = os.environ.get("SOURCE_DATE_EPOCH")
    if told is not None:
        if not re.fullmatch(r"[0-9]{1,12}", told, re.ASCII) or int(told) > _LATEST:
            raise UsageError(f"SOURCE_DATE_EPOCH: {quoted(told)} is not a whole number of seconds since 1970")
        return _written(datetime.fromtimestamp(int(told), timezone.utc))
    return _written(datetime.now(timezone.utc)) if clock else None


def _written(moment: datetime) -> str:
    return f"{moment:%Y-%m-%dT%H:%M:%SZ}"
