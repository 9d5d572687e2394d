"""How many functions and files of the package a command of `tumble` enters: what a reader follows from argv to table.

    entered.py [--list] WORDS...      such as: entered.py solve examples/paper_stand.csv

Counted are functions and methods with a name, each once, that run after the command has been parsed and its modules
are loaded: what runs at import is no part of the way, so the command runs twice. --list names them, by file.
"""

import collections
import contextlib
import io
import sys
from pathlib import Path

import tumble
from tumble.cli.main import main

PACKAGE = str(Path(tumble.__file__).parent)


def entered(words):
    """By file, the names in the order in which they are entered; and the number of calls."""
    found, calls = collections.defaultdict(dict), 0

    def count(frame, event, _argument):
        nonlocal calls
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(PACKAGE):
            calls += 1
            if not code.co_name.startswith("<"):
                found[code.co_filename[len(PACKAGE) + 1 :]][code.co_qualname] = None

    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        run(words)
        sys.setprofile(count)
        try:
            run(words)
        finally:
            sys.setprofile(None)
    return found, calls


def run(words):
    with contextlib.suppress(SystemExit):
        main(words)


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--list"]
    found, calls = entered(words)
    print(f"{sum(map(len, found.values()))} functions in {len(found)} files, {calls} calls: tumble {' '.join(words)}")
    for file, names in found.items() if "--list" in sys.argv else ():
        print(f"{file}: {', '.join(names)}")
