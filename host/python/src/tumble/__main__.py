"""`python -m tumble`, and the program `tumble`: the command line."""

import sys

from tumble import interruption

# Before anything else is loaded, which takes its time.
interruption.end_at_once()

from tumble.cli.main import main  # noqa: E402


def run() -> int:
    """One command, as a process of its own. Returns its exit code."""
    try:
        return main(interruptible=True)
    except KeyboardInterrupt:  # while something else was being said
        return interruption.exit_code()
    finally:
        interruption.ignore()


if __name__ == "__main__":
    sys.exit(run())
