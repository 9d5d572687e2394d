"""States and reasons of the firmware in words: what goes on, what is wrong, what to do."""

from __future__ import annotations

from tumble.client.tables import REASONS, STATES

_MEANINGS = dict(STATES)
_REASONS = {name: (meaning, remedy) for name, meaning, remedy in REASONS}


def meaning(state: str | None) -> str | None:
    """What is done in a state; None where that is not known."""
    return _MEANINGS.get(state or "")


def sentence(reason: str | None) -> str | None:
    """What is wrong."""
    return _REASONS.get(reason or "", (None, None))[0]


def remedy(reason: str | None) -> str | None:
    """What to do about it."""
    return _REASONS.get(reason or "", (None, None))[1]
