"""What tests that compile C of their own need of the firmware, for a compiler that is called in the root of the repo."""

from pathlib import Path

INCLUDES = ["-Ifirmware", "-Ifirmware/include"]
_ROOT = Path(__file__).resolve().parents[2]


def firmware_sources():
    """All rooms."""
    return sorted(path.relative_to(_ROOT).as_posix() for path in (_ROOT / "firmware").rglob("*.c"))
