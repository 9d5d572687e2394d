"""Processes that have the command line loaded when they begin: forks of one that loads it once.

Each is a process of its own, as `python -m tumble` is, with its own output, exit code, working directory and signals.
What it saves is the loading, which takes longer than most commands. Not for a test of how Python itself starts.
"""

import multiprocessing
import os
import pkgutil
import subprocess
import sys
import tempfile

import tumble

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(
    [module.name for module in pkgutil.walk_packages(tumble.__path__, "tumble.") if module.name != "tumble.__main__"]
)


def run(arguments, cwd, timeout):
    """`tumble ...`, as subprocess.run does it, with text. Raises subprocess.TimeoutExpired."""
    import hang_guards  # a plugin, which pytest loads after this module

    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        streams = [multiprocessing.reduction.DupFd(stream.fileno()) for stream in (out, err)]
        child = _context.Process(target=_command, args=(arguments, cwd, dict(os.environ), streams))
        child.start()
        child.join(hang_guards.longer(timeout))
        if child.exitcode is None:
            child.kill()
            child.join()
            raise subprocess.TimeoutExpired(["tumble", *arguments], timeout)
        return subprocess.CompletedProcess(["tumble", *arguments], child.exitcode, _text(out), _text(err))


def _command(arguments, cwd, environment, streams):
    """The command, where a new process would be."""
    for number, stream in enumerate([os.open(os.devnull, os.O_RDONLY), *(stream.detach() for stream in streams)]):
        os.dup2(stream, number)
    sys.stdin, sys.stdout, sys.stderr = os.fdopen(0), os.fdopen(1, "w"), os.fdopen(2, "w")
    os.environ.clear()
    os.environ.update(environment)
    if cwd is not None:
        os.chdir(cwd)
    sys.argv = ["tumble", *arguments]
    from tumble.__main__ import run as command

    sys.exit(command())


def _text(stream):
    stream.seek(0)
    return stream.read()
