"""What can be set on a node, as a mapping by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from tumble.client.errors import DEVICE_STATE, OUT_OF_RANGE, Refused
from tumble.client.link import Link, number, require_number
from tumble.client.tables import SETTINGS
from tumble.errors import UsageError, quoted

SAVE, LOAD = 0x65766173, 0x64616F6C  # "save", "load"
_HINT = "; no run may be on, and the service level must be open: unlock() opens it"
_SHOWN_BY = {"Host: Calendar": "Keeper: Calendar", "Host: Inhibit": "Keeper: Inhibit left"}  # where they are read


class Settings(Mapping[str, float | None]):
    """Names and units are those of docs/client.md; None where the node has no such setting, or does not know it now.

    Writing raises Refused: a value out of its limits, a state that does not allow it, a service level that is closed.
    An unknown name is a KeyError in reading, as of any mapping, and a UsageError in writing.
    """

    def __init__(self, link: Link):
        self._link = link

    def __getitem__(self, name: str) -> float | None:
        if name not in SETTINGS:
            raise KeyError(name)
        value = self._link.read(_SHOWN_BY.get(name, name))
        return None if value is None else number(value)

    def __setitem__(self, name: str, value: float) -> None:
        if name not in SETTINGS:
            raise UsageError(f"there is no setting {quoted(name)}; see docs/client.md")
        require_number(f"writing {name}", value)
        whole = SETTINGS[name][1] not in ("f32", "f64")
        if whole and not float(value).is_integer():
            raise Refused(f"writing {name}", OUT_OF_RANGE, "; it is a whole number")
        try:
            self._link.write(name, int(value) if whole else value)
        except Refused as refusal:
            if refusal.code == DEVICE_STATE and SETTINGS[name][2]:
                raise Refused(f"writing {name}", refusal.code, _HINT) from None
            raise

    def __iter__(self) -> Iterator[str]:
        return iter(SETTINGS)

    def __len__(self) -> int:
        return len(SETTINGS)

    @staticmethod
    def unit(name: str) -> str:
        """Of a setting; "": it has none. Raises KeyError."""
        return SETTINGS[name][0]

    @staticmethod
    def needs_unlock(name: str) -> bool:
        """Whether it can be written at service level only. Raises KeyError."""
        return SETTINGS[name][2]

    def save(self) -> None:
        """Keep what was written beyond the next power-on (1010h). Needs `unlock()`. Raises Refused."""
        self._link.write("Store parameters: Save all parameters", SAVE)

    def restore(self) -> None:
        """Forget what was saved (1011h): the board's own are back after the next power-on. Needs `unlock()`. Raises
        Refused."""
        self._link.write("Restore default parameters: Restore all default parameters", LOAD)
