"""User-mode Linux: a kernel with CAN as an ordinary process, for machines whose own kernel has none.

It starts in a few seconds, with this machine's files as its own (read only) and an interface vcan0. What it runs is a
shell script; the folder of the run is the one place where it may write, and is at the same path inside and outside.
Programs are to be built outside: system calls and page faults are slow in there.

A command of the user's in there (`run_command`) finds this machine's files, read only but for the directory it is
called in, the checkout, and a TMPDIR of its own that is gone afterwards. On a terminal it has that terminal, and is a
shell if it is not said what it is; otherwise its input is empty, and its output goes where ours goes.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from tumble.errors import BenchFault, Skipped, UsageError
from tumble.world.programs import built, last_words

INTERFACE = "vcan0"
PACKAGES = "user-mode-linux kmod iproute2"

_KERNEL = "linux.uml"
_SHIM = "tumble_uml.so"
_MODULES = ("net/can/can", "net/can/can-raw", "net/can/can-bcm", "drivers/net/can/dev/can-dev", "drivers/net/can/vcan")
_MODULE_FOLDERS = "/usr/lib/uml/modules"
_PATH = "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"
_TICK_S = 0.05
_BOOT_S = 60.0  # until it must have begun
_SILENCE_S = 60.0  # between two signs of life
_NO_BUS = "no bus"

_INIT = """#!/bin/sh
PATH={path}; export PATH
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t tmpfs tmpfs /run
mount -t hostfs -o {folder} hostfs {folder}
cd {folder}
(while :; do # a sign of life, and the end of all when nobody outside has watched for 20 s
    echo beat >alive
    read -r now <watched
    [ "$now" != "$before" ] && idle=0 || idle=$((${{idle:-0}} + 1))
    before=$now
    [ $idle -lt 40 ] || echo o >/proc/sysrq-trigger
    sleep 0.5
done) &
ip link set up lo
modules={modules}/$(uname -r)/kernel
code="{no_bus}"
(for module in {names}; do insmod $modules/$module.ko || exit; done &&
    ip link add dev {interface} type vcan && ip link set up {interface}) && {{ sh job.sh; code=$?; }}
echo $code >code.part && mv code.part code
echo o >/proc/sysrq-trigger
sleep 10
"""


def missing() -> str | None:
    """What keeps user-mode Linux from running here, for one line to the user; None: nothing."""
    if sys.platform != "linux":
        return "it runs on Linux alone"
    search = f"{os.environ.get('PATH', '')}:{_PATH}"
    programs = (_KERNEL, "insmod", "ip")
    lacking = [name for name in programs if shutil.which(name, path=search) is None]
    if not lacking and not any(Path(_MODULE_FOLDERS).glob(f"*/kernel/{_MODULES[-1]}.ko")):
        lacking = [f"its module {_MODULES[-1]}.ko"]
    return f"no {', '.join(lacking)}: install {PACKAGES}" if lacking else None


def require_there(remark: str = "") -> None:
    """Raise Skipped, with one line about what to install, where it cannot run; the remark before it."""
    if (lacking := missing()) is not None:
        raise Skipped(f"{remark}user-mode Linux is not there: {lacking}")


def run(
    job: str,
    folder: Path,
    *,
    on_tick: Callable[[], None] = lambda: None,
    memory_mb: int = 128,
    timeout_s: float = float("inf"),
    terminals: Sequence[tuple[int | None, int]] = (),
) -> int:
    """Run the shell script `job` in there. Returns its exit code.

    `folder`: the run's own (its working folder, writable); files appear outside when they are closed inside. `on_tick`
    is called all the while. `terminals`: descriptors, input or None and output, of what is tty1, tty2 and so on in
    there (character devices 4:1, 4:2); bytes go through them at once. Raises Skipped where it is not installed,
    BenchFault where it does not start, falls silent or takes longer than `timeout_s`; whatever on_tick raises, and an
    interrupt, ends it at once.
    """
    require_there()
    _write_scripts(job, folder)
    with open(folder / "console.log", "wb") as console:
        process = subprocess.Popen(
            [*_command(folder, memory_mb), *_lines(terminals)],
            stdin=subprocess.DEVNULL,
            stdout=console,
            stderr=subprocess.STDOUT,
            env=_environment(folder, memory_mb),
            start_new_session=True,
            pass_fds={one for pair in terminals for one in pair if one is not None},
        )
    try:
        with _watching(folder):
            _watch(process, folder, on_tick, timeout_s)
    finally:
        _end(process)
    return _exit_code(folder)


def stop(folder: Path) -> None:
    """Tell the job, which has to look for it, by the file `stop`."""
    (folder / "stop").touch()


def work_folder() -> tempfile.TemporaryDirectory[str]:
    """A folder to run in: its path can stand in the command line of a kernel."""
    parent = tempfile.gettempdir()
    plain = re.fullmatch(r"[\w./-]+", parent, re.ASCII)
    return tempfile.TemporaryDirectory(prefix="tumble-", dir=parent if plain else "/tmp", ignore_cleanup_errors=True)


def _write_scripts(job: str, folder: Path) -> None:
    init = _INIT.format(
        path=_PATH,
        folder=folder,
        modules=_MODULE_FOLDERS,
        names=" ".join(_MODULES),
        interface=INTERFACE,
        no_bus=_NO_BUS,
    )
    (folder / "job.sh").write_text(job)
    (folder / "watched").write_text("0\n")
    (folder / "init.sh").write_text(init)
    (folder / "init.sh").chmod(0o755)


def _command(folder: Path, memory_mb: int) -> list[str]:
    kernel = shutil.which(_KERNEL, path=f"{os.environ.get('PATH', '')}:{_PATH}")
    assert kernel is not None  # require_there has looked
    return [
        kernel,
        f"mem={memory_mb}M",
        "root=/dev/root",
        "rootfstype=hostfs",
        "rootflags=/",
        "ro",
        f"init={folder}/init.sh",
        f"uml_dir={folder}/",
        "con=null",
        "con0=fd:0,fd:1",
        "quiet",
    ]


def _lines(terminals: Sequence[tuple[int | None, int]]) -> list[str]:
    return [
        f"con{number}={'null' if given is None else f'fd:{given}'},fd:{taken}"
        for number, (given, taken) in enumerate(terminals, 1)
    ]


def _environment(folder: Path, memory_mb: int) -> dict[str, str]:
    """Its memory is a file: in shared memory where there is room for it."""
    memory = Path("/dev/shm")
    roomy = os.access(memory, os.W_OK) and shutil.disk_usage(memory).free > 2 * memory_mb * 2**20
    environment = {**os.environ, "TMPDIR": str(memory if roomy else folder)}
    shim = built(f"host/uml/{_SHIM}")
    if shim.exists():
        environment["LD_PRELOAD"] = str(shim)
    return environment


@contextmanager
def _watching(folder: Path) -> Iterator[None]:
    """Tell what is inside that somebody outside is there, also while a person thinks about an answer."""
    done = threading.Event()

    def tell() -> None:
        seconds = 0
        while not done.wait(1.0):
            seconds += 1
            (folder / "watched").write_text(f"{seconds}\n")

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _watch(process: subprocess.Popen[bytes], folder: Path, on_tick: Callable[[], None], timeout_s: float) -> None:
    """Until it has ended."""
    began = time.monotonic()
    while process.poll() is None:
        on_tick()
        _require_life(folder, began)
        if time.monotonic() - began > timeout_s:
            raise BenchFault(f"user-mode Linux: no end after {timeout_s:.0f} s")
        time.sleep(_TICK_S)
    on_tick()


def _require_life(folder: Path, began: float) -> None:
    alive = folder / "alive"
    if alive.exists():
        if time.time() - alive.stat().st_mtime > _SILENCE_S:
            raise BenchFault(f"user-mode Linux has been silent for {_SILENCE_S:.0f} s: {_last_words(folder)}")
    elif time.monotonic() - began > _BOOT_S:
        raise BenchFault(f"user-mode Linux does not start: {_last_words(folder)}")


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.poll() is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _exit_code(folder: Path) -> int:
    path = folder / "code"
    if not path.exists():
        raise BenchFault(f"user-mode Linux ended without a word about the run: {_last_words(folder)}")
    code = path.read_text().strip()
    if code == _NO_BUS:
        raise BenchFault(f"user-mode Linux has no interface {INTERFACE}: {_last_words(folder)}")
    return int(code)


def _last_words(folder: Path) -> str:
    return last_words((folder / "console.log").read_text(errors="replace"))


# A command of the user's in there.

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


def run_command(command: list[str]) -> int:
    """Run it; none: a shell, which needs a terminal. Returns its exit code, as a shell would say it. Raises Skipped,
    UsageError, BenchFault."""
    require_there()
    interactive = all(os.isatty(number) for number in range(3))
    if not command and not interactive:
        raise UsageError("uml: a shell needs a terminal; otherwise say which COMMAND")
    command_line = shlex.join(command or [os.environ.get("SHELL", "/bin/sh")])
    with work_folder() as name:
        if interactive:
            return _on_terminal(command_line, Path(name))
        return _piped(command_line, Path(name))


def _on_terminal(command_line: str, folder: Path) -> int:
    with _own_terminal() as (descriptor, size):
        mode = f"sane rows {size.lines} cols {size.columns}"
        job = _job(_TERMINAL.format(shlex.quote(f"exec {command_line}")), folder, 1, mode)
        return run(job, folder, memory_mb=_MEMORY_MB, terminals=[(descriptor, descriptor)])


def _piped(command_line: str, folder: Path) -> int:
    job = _job(_PIPES.format(command_line), folder, 2, "-opost")
    sys.stdout.flush()
    with ExitStack() as stack:
        out, errors = (stack.enter_context(_Relay(to)) for to in (1, 2))
        ends = [(None, out.end), (None, errors.end)]
        return run(job, folder, on_tick=out.require_reader, memory_mb=_MEMORY_MB, terminals=ends)


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
