"""States and reasons of the firmware in words: what goes on, what is wrong, what to do."""

from __future__ import annotations

from tumble.client import names
from tumble.client.tables import REASONS, STATES

STANDS = ("OFFLINE", "READY", "HOMING", "MOVING", "IN_POSITION", "STOPPED", "FAULT")  # tumble_stand_state_t
ANGLE_KNOWN = ("MOVING", "IN_POSITION", "STOPPED")
_MEANINGS = dict(STATES)
_REASONS = {name: (meaning, remedy) for name, meaning, remedy in REASONS}


def state(number: int) -> str:
    """Of 2000h."""
    return names.state(number)


def reason(number: int) -> str | None:
    """Of 2001h; None where nothing is wrong."""
    return names.reason(number).name if number else None


def stand(number: int) -> str:
    """Of 2003h:12."""
    return STANDS[number] if number < len(STANDS) else f"STAND_{number}"


def meaning(state: str | None) -> str | None:
    """What is done in a state; None where that is not known."""
    return _MEANINGS.get(state or "")


def sentence(reason: str | None) -> str | None:
    """What is wrong."""
    return _REASONS.get(reason or "", (None, None))[0]


def remedy(reason: str | None) -> str | None:
    """What to do about it."""
    return _REASONS.get(reason or "", (None, None))[1]
