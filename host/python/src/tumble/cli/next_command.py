"""What an import says last: the command that solves the run file which it has written."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterable
from typing import TYPE_CHECKING

from tumble.defaults import DEFAULT_SCHEDULE

if TYPE_CHECKING:
    from tumble.importing.pipeline import Imported

_WIDTH = 80
_WITHOUT_RUN = "Next: the same with --out RUN.csv, which writes the run file for tumble solve."


def after_import(done: Imported, run: str | None, stand: str | None) -> str:
    """The lines that tell it. `run`: the run file, None where none was asked for; `stand`: the stand file, if any. The
    program is called as it was: tools/tumble of a checkout says how, by TUMBLE_PROGRAM."""
    if run is None:
        return f"\n{_WITHOUT_RUN}\n"
    words = [os.environ.get("TUMBLE_PROGRAM", "tumble"), "solve", run]
    if done.settings.schedule_name != DEFAULT_SCHEDULE:
        words += ["--schedule", done.settings.schedule_name]
    words += [] if stand is None else ["--stand", stand]
    words += [] if _has_closed_form(done) else ["--estimator", "least_squares"]
    words += ["--out", os.path.join(os.path.dirname(run), "result.json")]  # which apply and report take
    return "\n".join(["", "Next:", *_folded(words), ""])


def _has_closed_form(done: Imported) -> bool:
    """Can the usual estimator solve the positions that were found?"""
    from tumble.core import CoreRefusal, CoreSchedule

    present = set(done.matched.positions.tolist())
    try:
        CoreSchedule(done.schedule.part(index in present for index in range(len(done.schedule.positions)))).harmonic()
    except CoreRefusal:
        return False
    return True


def _folded(words: Iterable[str]) -> list[str]:
    """A command on lines that a shell joins: an option and its value stay together."""
    program, verb, run, *options = map(shlex.quote, words)
    lines = [f"  {program} {verb}"]
    for option in (run, *map(" ".join, zip(options[::2], options[1::2]))):
        if len(lines[-1]) + len(option) + len("  \\") > _WIDTH:
            lines[-1] += " \\"
            lines.append(f"    {option}")
        else:
            lines[-1] += f" {option}"
    return lines
