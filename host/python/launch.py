"""`tumble` from a checkout: like `python -m tumble`, but the working directory is not searched for modules."""

import signal

# tools/tumble starts Python with Ctrl-C held back: one that came meanwhile ends the process here, without a word.
if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})

import runpy  # noqa: E402

runpy.run_module("tumble", run_name="__main__", alter_sys=True)
