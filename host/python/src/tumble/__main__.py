"""`python -m tumble`: the command line."""

import signal
import sys

# Until the command itself can clean up, an interrupt simply ends the process: there is nothing to clean up yet.
_HANDLER = signal.signal(signal.SIGINT, signal.SIG_DFL)

from tumble.cli import main  # noqa: E402

sys.exit(main(interrupt=_HANDLER))
