"""Run folders: run.csv, bus.log, result.json and inputs/, all of them or none.

A run that ends in a fault leaves run.csv (the positions that were finished), bus.log, inputs/ and fault.json: what the
bench says of it.
"""

from __future__ import annotations

import contextlib
import datetime
import os
import shutil
from pathlib import Path

from tumble import interruption
from tumble.errors import BadInput, file_name
from tumble.files.disk import reason

DEFAULT_PARENT = "runs"
SCENARIO = "scenario.txt"
GAINS = "gains.bin"


def default_path(seed: int) -> str:
    """A new folder's path: runs/<UTC time>-<seed>."""
    now = datetime.datetime.now(datetime.timezone.utc).strftime("%Y%m%dT%H%M%SZ")
    path = os.path.join(DEFAULT_PARENT, f"{now}-{seed}")
    number = 2
    while os.path.lexists(path):
        path = os.path.join(DEFAULT_PARENT, f"{now}-{seed}-{number}")
        number += 1
    return path


def is_in_default_parent(path: str) -> bool:
    """Does it lie in runs/, which is made where it is not there?"""
    return os.path.dirname(path) == DEFAULT_PARENT


class RunFolder:
    """A folder in the making: everything goes into `stage`, a hidden folder in or beside it, until `keep`.

    Used with `with`: what was not kept is removed. Raises BadInput where the folder cannot be made or is not empty.
    """

    def __init__(self, path: str, *, may_make_parent: bool = False):
        self.path = path
        self._may_make_parent = may_make_parent
        self._made_parent = False
        self._made = False  # the stage is ours: what lies there otherwise is another run's
        _check(path)
        try:
            self._target = Path(os.path.realpath(path))
            self._existed = self._target.is_dir()
            if self._existed and any(self._target.iterdir()):
                raise BadInput("is there already and is not an empty folder; remove it or choose another --out", path)
            if not self._existed and os.path.lexists(self._target):
                raise BadInput("is there already and is not a folder", path)
            self.stage = (self._target if self._existed else self._target.parent) / f".{self._target.name}.part"
        except OSError as error:
            raise self._cannot_be_made(error) from None

    def _cannot_be_made(self, error: OSError) -> BadInput:
        parent = os.path.dirname(os.path.normpath(self.path))
        is_missing = isinstance(error, FileNotFoundError) and bool(parent) and not os.path.lexists(parent)
        why = f"make the folder {file_name(parent)} first" if is_missing else reason(error)
        return BadInput(f"the folder cannot be made: {why}", self.path)

    def _cannot_be_written(self, error: OSError) -> BadInput:
        return BadInput(f"cannot be written: {reason(error)}", self.path)

    def __enter__(self) -> RunFolder:
        try:
            with interruption.postponed():
                self._make()
            return self
        except FileExistsError:
            message = f"{file_name(self.stage)} is there, of a run that goes on or was killed"
            raise BadInput(message, self.path) from None
        except OSError as error:
            self._remove_made_parent()
            raise self._cannot_be_made(error) from None
        except KeyboardInterrupt:
            self.__exit__()
            raise

    def _make(self) -> None:
        if self._may_make_parent and not self._target.parent.exists():
            self._target.parent.mkdir()
            self._made_parent = True
        self.stage.mkdir()
        self._made = True

    def __exit__(self, *_: object) -> None:
        with interruption.postponed():
            if self._made:
                shutil.rmtree(self.stage, ignore_errors=True)
            self._remove_made_parent()

    def _remove_made_parent(self) -> None:
        if self._made_parent:
            _remove_if_empty(self._target.parent)

    def add_inputs(self, files: dict[str, bytes], scenario: str, gains: bytes | None = None) -> Path:
        """Copies of the given files (name and contents), the scenario and the gain record if there is one, in inputs/.
        Returns the scenario's path."""
        inputs = self.stage / "inputs"
        try:
            inputs.mkdir()
            for number, (file, data) in enumerate(files.items(), start=1):
                name = os.path.basename(file)
                free = not (inputs / name).exists() and name not in (SCENARIO, GAINS)
                (inputs / (name if free else f"{number}-{name}")).write_bytes(data)
            (inputs / SCENARIO).write_text(scenario, encoding="ascii")
            if gains is not None:
                (inputs / GAINS).write_bytes(gains)
        except OSError as error:
            raise self._cannot_be_written(error) from None
        return inputs / SCENARIO

    def add(self, name: str, data: bytes) -> None:
        """A file beside run.csv. Raises BadInput."""
        try:
            (self.stage / name).write_bytes(data)
        except OSError as error:
            raise self._cannot_be_written(error) from None

    def keep(self, unwanted: str, *, renamed: str | None = None, **texts: str) -> None:
        """Give the folder its name. The file `unwanted` goes, or is `renamed`; `texts` become files NAME.json."""
        try:
            for name, text in texts.items():
                (self.stage / f"{name}.json").write_text(text, encoding="utf-8")
            if renamed is None:
                (self.stage / unwanted).unlink()
            else:
                (self.stage / unwanted).rename(self.stage / renamed)
            interruption.ignore()
            self._publish()
            self._made = False
        except OSError as error:
            raise self._cannot_be_written(error) from None

    def _publish(self) -> None:
        if not self._existed:
            self.stage.rename(self._target)
            return
        for entry in sorted(self.stage.iterdir()):
            entry.rename(self._target / entry.name)
        self.stage.rmdir()


def _check(path: str) -> None:
    if not path or "\0" in path:
        raise BadInput("not a folder name", path)


def _remove_if_empty(folder: Path) -> None:
    with contextlib.suppress(OSError):
        folder.rmdir()
