"""What results say of their block and their day, by keys or by labels that people wrote."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime, timezone
from typing import Any

from tumble.documents.result import Result
from tumble.errors import quoted

_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_ISO = "%Y-%m-%dT%H:%M:%SZ"
_REASONS_OF_NUMBERS = {"gravity", "fit"}  # why a result's numbers are not to be believed
Labels = Mapping[str, Any]


def label(labels: Labels, *names: str) -> str | None:
    """The first of these names that is there, however it is spelled."""
    plain = {re.sub(r"\W+", "_", key.strip().lower()): str(text) for key, text in labels.items()}
    return next((plain[name] for name in names if plain.get(name)), None)


def serial_of(serial: str | None, item: Labels | None) -> str | None:
    """Of a block: that of [block], else by a label of the item."""
    return serial or label(item or {}, "serial", "serial_number")


def is_believed(told: Result) -> bool:
    """Did its run pass the gravity check, and does it fit its stand?"""
    return not _REASONS_OF_NUMBERS & set((told.pass_reason or "").split(" and ")) and told.verification.passed


def seconds_of_day(date: str) -> int:
    """In seconds since 1970 UTC. Raises ValueError for what is no date such as 2026-07-31."""
    if not _DATE.fullmatch(date):
        raise ValueError
    return int(datetime.fromisoformat(date).replace(tzinfo=timezone.utc).timestamp())


def iso(seconds: float) -> str:
    """As documents have a time."""
    return datetime.fromtimestamp(seconds, timezone.utc).isoformat(timespec="seconds").replace("+00:00", "Z")


def measured_s(item: Labels | None, environment: Labels | None, created: str | None) -> int | None:
    """When a run was measured, in seconds since 1970 UTC: by a label `date` of the item or of the environment, else
    when it was solved; None where nobody says. Raises ValueError for a date that is none, which it names."""
    for key, labels in (("item", item or {}), ("environment", environment or {})):
        day = label(labels, "date", "run_date")
        if day is not None and _DATE.fullmatch(day):
            try:
                return seconds_of_day(day)
            except ValueError:
                raise ValueError(f"date of {key}: {quoted(day)} is not a date such as 2026-07-31") from None
    if created is None:
        return None
    return int(datetime.strptime(created, _ISO).replace(tzinfo=timezone.utc).timestamp())
