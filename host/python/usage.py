"""What a checkout answers before it is set up: --help, --version, usage errors. With any Python from 3.10 on, and no
package but its own. Exit 0: it parses, so that it is worth a set-up; 2 usage error; 10 answered; 20 this Python is too
old."""

import signal
import sys

# tools/usage starts Python with Ctrl-C held back: it ends it without a word.
signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

if sys.version_info < (3, 10):  # noqa: UP036 # it runs on whatever Python there is
    sys.exit(20)

from tumble.cli.main import parse  # noqa: E402

sys.exit(parse(sys.argv[1:]))
