"""A command of the user's inside user-mode Linux, with vcan0, where the kernel of this machine has no CAN.

It finds this machine's files, read only but for the directory it is called in, the checkout, and a TMPDIR of its own
that is gone afterwards. On a terminal it has that terminal, and is a shell if it is not said what it is; otherwise its
input is empty, and its output goes where ours goes.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tumble.errors import UsageError
from tumble.world import uml

_MEMORY_MB = 768
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)
_NOT_HANDED_ON = {"LD_PRELOAD", "PWD", "OLDPWD", "SHLVL", "_"}

_JOB = """
echo uml >/proc/sys/kernel/hostname
for number in {numbers}; do
    mknod /run/tty$number c 4 $number
    stty -F /run/tty$number {mode}
done
{mounts}
mkdir /run/tmp
{exports}
export TMPDIR=/run/tmp PATH="$PATH:/usr/local/sbin:/usr/sbin:/sbin"
cd -P -- {here} || exit
{command}
"""
_TERMINAL = "setsid -c -w sh -c {} </run/tty1 >/run/tty1 2>&1"
_PIPES = """mkfifo /run/out /run/errors # a program shall not take ours for a terminal
(trap '' TERM; exec cat </run/out >/run/tty1) & out=$!
(trap '' TERM; exec cat </run/errors >/run/tty2) & errors=$!
{} </dev/null >/run/out 2>/run/errors
code=$?
kill -s TERM -- -1 # what it has left
(sleep 5; kill -s KILL -- -1) &
wait $out $errors
exit $code"""


def run(command: list[str]) -> int:
    """Run it; none: a shell, which needs a terminal. Returns its exit code, as a shell would say it. Raises Skipped,
    UsageError, BenchFault."""
    uml.require_there()
    interactive = all(os.isatty(number) for number in range(3))
    if not command and not interactive:
        raise UsageError("uml: a shell needs a terminal; otherwise say which COMMAND")
    words = shlex.join(command or [os.environ.get("SHELL", "/bin/sh")])
    with uml.work_folder() as name:
        if interactive:
            return _on_terminal(words, Path(name))
        return _piped(words, Path(name))


def _on_terminal(words: str, folder: Path) -> int:
    with _own_terminal() as (descriptor, size):
        mode = f"sane rows {size.lines} cols {size.columns}"
        job = _job(_TERMINAL.format(shlex.quote(f"exec {words}")), folder, 1, mode)
        return uml.run(job, folder, memory_mb=_MEMORY_MB, terminals=[(descriptor, descriptor)])


def _piped(words: str, folder: Path) -> int:
    job = _job(_PIPES.format(words), folder, 2, "-opost")
    sys.stdout.flush()
    with ExitStack() as stack:
        out, errors = (stack.enter_context(_Relay(to)) for to in (1, 2))
        ends = [(None, out.end), (None, errors.end)]
        return uml.run(job, folder, on_tick=out.require_reader, memory_mb=_MEMORY_MB, terminals=ends)


def _job(command: str, folder: Path, terminals: int, mode: str) -> str:
    exports = [f"export {name}={shlex.quote(value)}" for name, value in os.environ.items() if _is_handed_on(name)]
    return _JOB.format(
        numbers=" ".join(str(number) for number in range(1, terminals + 1)),
        mode=mode,
        mounts="\n".join(_mount(path, folder / f"writable{number}") for number, path in enumerate(_writable())),
        exports="\n".join(exports),
        here=shlex.quote(os.getcwd()),
        command=command,
    )


def _is_handed_on(name: str) -> bool:
    return _NAME.fullmatch(name) is not None and name not in _NOT_HANDED_ON


def _writable() -> list[Path]:
    """The directory we are called in, and the checkout that we are of, if of one; the outer first."""
    checkouts = [folder for folder in Path(__file__).resolve().parents[5:6] if (folder / "tools/tumble").exists()]
    found = {Path.cwd().resolve(), *checkouts}
    return sorted(found - {Path("/")}, key=lambda path: len(path.parts))


def _mount(path: Path, link: Path) -> str:
    """Through a link, as the options of a mount cannot hold every path."""
    link.symlink_to(path)
    return f"mount -t hostfs -o {link} hostfs {shlex.quote(str(path))}"


@contextmanager
def _own_terminal() -> Iterator[tuple[int, os.terminal_size]]:
    """Our terminal, opened anew, as user-mode Linux changes what it is given; afterwards it is as before."""
    import termios  # which Windows has not, where the command line is loaded, too

    before = termios.tcgetattr(0)
    descriptor = os.open(os.ttyname(0), os.O_RDWR | os.O_NOCTTY)
    try:
        yield descriptor, os.get_terminal_size(0)
    finally:
        os.close(descriptor)
        termios.tcsetattr(0, termios.TCSADRAIN, before)


class _Relay:
    """A pipe whose bytes go to one of our outputs, as they come."""

    def __init__(self, output: int):
        self._output = output
        self._fault: OSError | None = None

    def __enter__(self) -> _Relay:
        self._source, self.end = os.pipe()
        self._thread = threading.Thread(target=self._hand_on, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self.end)
        self._thread.join()
        os.close(self._source)

    def require_reader(self) -> None:
        """Raise what writing raised: BrokenPipeError where nobody reads any more."""
        if self._fault is not None:
            raise self._fault

    def _hand_on(self) -> None:
        while data := os.read(self._source, 65536):
            while data and self._fault is None:
                try:
                    data = data[os.write(self._output, data) :]
                except OSError as fault:
                    self._fault = fault
