"""What a file looks like that is not what was expected: for messages alone, nothing is read by it."""

from __future__ import annotations

import re

_HEAD_BYTES = 1 << 12
_MAGIC = {b"PK\x03\x04": "a ZIP or NPZ file", b"\x89PNG": "a PNG picture", b"%PDF": "a PDF file", b"PAR1": "Parquet"}
_TOML = re.compile(r"\[\[?\s*[\w.\"'-]+\s*\]\]?\s*(#.*)?$|[\w.\"'-]+\s*=\s*\S")
CSV, JSON, TOML = "CSV, such as a run file", "JSON, such as a result", "TOML, such as a stand or a schedule file"


def kind_of(data: bytes) -> str | None:
    """What the beginning of a file looks like, as a message calls it; None: nothing that is known."""
    found = next((kind for magic, kind in _MAGIC.items() if data.startswith(magic)), None)
    lines = data[:_HEAD_BYTES].decode("utf-8-sig", errors="replace").splitlines()
    filled = [line.strip() for line in lines if line.strip() and not line.startswith("#")]
    first = filled[0] if filled else ""
    if found is not None or not first:
        return found
    if first[0] == "{" or first == "[":
        return JSON
    if first[0] == "<":
        return "HTML or XML"
    if any(map(_TOML.match, filled)):  # the first line may be what is wrong with it
        return TOML
    return CSV if any(first.count(sign) >= 2 for sign in ",;\t") else None
