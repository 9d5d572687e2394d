"""Python as it is on Windows or macOS, as far as that shows from within: a program for tests.

    other_system.py win32|darwin STATEMENTS      runs the statements there; if run_all is among them, after it ran here
    other_system.py linux STATEMENTS             runs them, and nothing is taken away

Taken away is what the other system has not: modules, functions, signals and kinds of sockets. What stands for itself is
made to behave as there: no folder can be opened as a file, no file that is open can be replaced, removed or renamed,
no program of ours can be started, and who opens a text file without saying its encoding is at fault (there it is not
UTF-8). Libraries are loaded before, as they are: the package alone is loaded anew.
"""

import builtins
import os
import pkgutil
import shutil
import signal
import socket
import subprocess
import sys
import time
import warnings

MODULES = {  # that only POSIX has; of each system those that it lacks
    "win32": {"fcntl", "termios", "resource", "pwd", "grp", "pty", "tty", "syslog", "crypt", "readline", "curses"},
    "darwin": {"spwd", "ossaudiodev"},
}
NAMES = {
    "win32": {
        signal: "SIGHUP SIGQUIT SIGTRAP SIGBUS SIGKILL SIGUSR1 SIGUSR2 SIGPIPE SIGALRM SIGCHLD SIGCONT SIGSTOP SIGTSTP "
        "SIGTTIN SIGTTOU SIGWINCH SIGIO SIGPOLL SIGPWR alarm pause setitimer getitimer pthread_kill pthread_sigmask "
        "sigpending sigwait sigwaitinfo sigtimedwait siginterrupt",
        os: "fork forkpty setsid setpgid getpgid getpgrp setpgrp getuid geteuid getgid getegid setuid setgid getresuid "
        "killpg wait wait3 wait4 waitid WNOHANG nice openpty ttyname ctermid mkfifo mknod chown fchown lchown fchmod "
        "chroot sync fdatasync pread pwrite preadv pwritev sendfile statvfs fstatvfs sched_getaffinity "
        "sched_setaffinity sched_yield uname getloadavg sysconf confstr pathconf fpathconf posix_spawn posix_spawnp "
        "register_at_fork O_DIRECTORY O_NOFOLLOW O_CLOEXEC O_NONBLOCK O_NDELAY O_SYNC O_DSYNC O_NOCTTY O_TMPFILE "
        "getxattr setxattr memfd_create eventfd pidfd_open splice copy_file_range",
        socket: "AF_UNIX AF_CAN AF_PACKET AF_NETLINK CAN_RAW SO_REUSEPORT SCM_RIGHTS",
        time: "tzset clock_gettime clock_gettime_ns CLOCK_MONOTONIC CLOCK_REALTIME pthread_getcpuclockid",
    },
    "darwin": {
        os: "sched_getaffinity sched_setaffinity O_TMPFILE getxattr setxattr memfd_create eventfd pidfd_open splice "
        "copy_file_range getresuid posix_fadvise posix_fallocate",
        socket: "AF_CAN AF_PACKET AF_NETLINK CAN_RAW",
        signal: "SIGPWR SIGPOLL SIGSTKFLT sigwaitinfo sigtimedwait",
    },
}
LINUX_ALONE = ("/proc", "/sys", "/dev/shm")


def package_modules():
    """Of the package, all that the command line and a script load."""
    import tumble

    names = [module.name for module in pkgutil.walk_packages(tumble.__path__, "tumble.")]
    return [name for name in names if name != "tumble.__main__"]


def load_package():
    """All of it."""
    for name in package_modules():
        __import__(name)


def forget_package():
    """So that it is loaded anew."""
    for name in [name for name in sys.modules if name == "tumble" or name.startswith("tumble.")]:
        del sys.modules[name]


class NotThere:
    """Finds no module of these names."""

    def __init__(self, names):
        self.names = names

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def become(system):
    """From here on this is the other system."""
    if system == "linux":
        return
    own = set(package_modules())
    forget_package()
    for name in MODULES[system]:
        sys.modules.pop(name, None)
    sys.meta_path.insert(0, NotThere(MODULES[system]))
    for module, names in NAMES[system].items():
        for name in names.split():
            if hasattr(module, name):
                delattr(module, name)
    sys.platform = system
    builtins.open = _opener(builtins.open, system)
    subprocess.Popen = _nothing_starts
    if system == "win32":
        _hold_open_files()
    for name in own:
        warnings.filterwarnings("error", category=EncodingWarning, module=name.replace(".", r"\."))


def _opener(plain, system):
    """A folder is no file, Linux's own folders are not there, and text without an encoding is warned of as Python
    does it (-X warn_default_encoding), for the module that calls."""

    def opened(file, *arguments, **options):
        mode = arguments[0] if arguments else options.get("mode", "r")
        if "b" not in mode and "encoding" not in options and len(arguments) < 3:
            warnings.warn("'encoding' argument not specified", EncodingWarning, stacklevel=2)
            options["encoding"] = "locale"
        path = os.fspath(file) if isinstance(file, (str, os.PathLike)) else ""
        if isinstance(path, str) and path.startswith(LINUX_ALONE):
            raise FileNotFoundError(2, "No such file or directory", path)
        if system == "win32" and path and os.path.isdir(path):
            raise PermissionError(13, "Permission denied", path)
        return plain(file, *arguments, **options)

    return opened


def _nothing_starts(command, *_, **__):
    raise FileNotFoundError(2, "The system cannot find the file specified", command[0])


def _hold_open_files():
    """What this process has open cannot be replaced, renamed or removed; a folder cannot be opened."""
    paths, read, own = "/proc/self/fd", os.readlink, os.listdir

    def is_open(path):
        real = os.path.realpath(path)
        return any(_link(read, f"{paths}/{number}") == real for number in own(paths))

    def guarded(plain, count, must_be_new=False):
        def call(*arguments, **options):
            for path in arguments[:count]:
                if is_open(path):
                    raise PermissionError(13, "used by another process", path)
            if must_be_new and os.path.lexists(arguments[1]):
                raise FileExistsError(17, "Cannot create a file that is there", arguments[1])
            return plain(*arguments, **options)

        return call

    os.replace, os.rename = guarded(os.replace, 2), guarded(os.rename, 2, must_be_new=True)
    os.unlink = os.remove = guarded(os.unlink, 1)
    plain_open = os.open

    def opened(path, *arguments, **options):
        if os.path.isdir(path):
            raise PermissionError(13, "Permission denied", path)
        return plain_open(path, *arguments, **options)

    os.open = opened
    shutil._use_fd_functions = False  # of rmtree, which opens folders where it can


def _link(read, path):
    try:
        return read(path)
    except OSError:
        return None


if __name__ == "__main__":
    from examples_in_process import run_all

    load_package()
    if sys.argv[1] != "linux" and "run_all" in sys.argv[2]:
        run_all("folder-here")
    become(sys.argv[1])
    exec(sys.argv[2], {"load_package": load_package, "run_all": run_all})
