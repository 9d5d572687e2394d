"""`python -m tumble`, and the program `tumble`: the command line."""

import os
import sys

from tumble import interruption

# Before anything else is loaded, which takes its time.
interruption.end_at_once()

# Our matrices are too small for OpenBLAS's threads, which wait for work in a loop: `plan validate` took half as much
# again of the processor. And no last bit depends on how many processors there are.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

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
