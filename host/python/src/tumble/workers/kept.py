"""What is done of a campaign, kept as Parquet: a row for each piece, its name and what it left.

The file says whose it is: a fingerprint of all that the results depend on, beside words for people. It is written as a
whole or not at all, every few seconds, and at the end.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from typing import Any

import numpy as np

from tumble._version import __version__
from tumble.errors import BadInput, NotInstalled, quoted
from tumble.files.disk import bounded, refuse_link, written

Result = dict[str, Any]  # arrays (Floats, Integers) of one dimension, or text: fit for a row of Parquet

FORMAT = "tumble-done/1"  # of a table of Parquet, so no JSON schema stands for it
_NAME, _ABOUT = "piece", b"tumble"
_PAUSE_S, _SHARE = 5.0, 0.05  # between two writings at least; and no more of the time than this is spent on them


class Kept:
    """In a file, which need not be there yet. `depends`: on what the results do, by name."""

    def __init__(self, file: str, depends: dict[str, Any]):
        """Raises BadInput where the file is another campaign's, or none, or cannot be there; NotInstalled."""
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise NotInstalled("--resume", "pyarrow", extra="parquet") from None
        text = json.dumps({**depends, "tumble": __version__}, default=_as_text, sort_keys=True)
        self._about = {
            "schema": FORMAT,
            "campaign": str(depends["campaign"]),
            "fingerprint": hashlib.sha256(text.encode()).hexdigest(),
        }
        self._file = file
        refuse_link(file)
        if not os.access(os.path.dirname(os.path.realpath(file)), os.W_OK):  # told now, not after the first hours
            raise BadInput("cannot be written: its folder is not there, or nobody may write to it", file)
        self._done = self._read() if os.path.exists(file) else {}
        self._is_new = not self._done
        self._wait_until = time.monotonic() + _PAUSE_S

    def get(self, name: str) -> Result | None:
        """What a piece has left, None if it is not done."""
        return self._done.get(name)

    def add(self, name: str, result: Result) -> None:
        """A piece is done."""
        self._done[name] = result
        self._is_new = True
        if time.monotonic() >= self._wait_until:
            self.write()

    def write(self) -> None:
        """All that is done so far."""
        if not (self._is_new and self._done):
            return
        from pyarrow import Table, parquet

        started = time.monotonic()
        columns = {_NAME: list(self._done)}
        columns |= {name: [one[name] for one in self._done.values()] for name in next(iter(self._done.values()))}
        table = Table.from_pydict(columns).replace_schema_metadata({_ABOUT: json.dumps(self._about)})
        with written(self._file) as stream:
            parquet.write_table(table, stream, compression="zstd")
        self._is_new = False
        ended = time.monotonic()
        self._wait_until = ended + max(_PAUSE_S, (ended - started) / _SHARE)

    def _read(self) -> dict[str, Result]:
        from pyarrow import ArrowException, parquet

        try:
            with bounded(self._file):
                table = parquet.read_table(self._file)
            about = json.loads((table.schema.metadata or {}).get(_ABOUT, b"{}"))
        except (ArrowException, OSError, ValueError) as error:
            raise BadInput(f"not a Parquet file that can be read: {quoted(error)}", self._file) from None
        if about.get("schema") != FORMAT:
            raise BadInput(f"not a file of --resume (schema {FORMAT})", self._file)
        if about.get("campaign") != self._about["campaign"]:
            raise BadInput(f"what is done of another campaign: {quoted(about.get('campaign'))}", self._file)
        if about.get("fingerprint") != self._about["fingerprint"]:
            raise BadInput("what is done of a campaign with other inputs, options or version of tumble", self._file)
        rows = {name: table[name].to_pylist() for name in table.column_names}
        names = rows.pop(_NAME)
        return {
            piece: {name: _value(column[row], table.schema.field(name).type) for name, column in rows.items()}
            for row, piece in enumerate(names)
        }


def _as_text(value: Any) -> Any:
    """Of what JSON does not know; an array by its numbers, all of them."""
    return value.tolist() if isinstance(value, np.ndarray) else repr(value)


def _value(found: Any, kind: Any) -> Any:
    if isinstance(found, str):
        return found
    return np.array(found, dtype=float if "double" in str(kind) else int)
