"""Print every table of docs/performance.md, measured now.

    tools/benchmark [all] [--write]

The page names what prints each (costs_page.py). A benchmark that this machine cannot run is told on standard error,
and its table is left as the page has it. --write puts the tables into the page. Exit 1 when one failed, 77 when one
was left out.
"""

import argparse
import subprocess
import sys
from pathlib import Path

import costs_page as page

HERE = Path(__file__).resolve().parent
LEFT_OUT = 77


def main(arguments):
    """Measure, print, and write if asked to."""
    parser = argparse.ArgumentParser(description="Print every table of docs/performance.md, measured now.")
    parser.add_argument("--write", action="store_true", help="into the page, too")
    options = parser.parse_args(arguments)
    text, codes = page.PAGE.read_text(encoding="utf-8"), [0]
    for name in page.names(text):
        code, shown = measured(name)
        codes.append(code)
        if code == 0:
            print(f"<!-- tools/benchmark {name} --table -->\n{shown}\n{page.END}\n", flush=True)
            text = page.with_part(text, name, shown)
    if options.write:
        page.PAGE.write_text(text, encoding="utf-8")
    return 1 if set(codes) - {0, LEFT_OUT} else max(codes)


def measured(name):
    """(exit code, what it printed) of one benchmark; what it complains of goes to standard error."""
    command = [sys.executable, HERE / f"{name}.py", "--table"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        print(f"tools/benchmark {name}: LEFT OUT, exit {done.returncode}", file=sys.stderr)
    return done.returncode, done.stdout.rstrip("\n")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
