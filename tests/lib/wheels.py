"""The package as it is handed on: built, and installed in an environment of its own."""

import os
import subprocess
import sys
import venv


def build(kind, source, folder):
    """The package of this kind that the backend makes of a project, and its file."""
    environment = {key: value for key, value in os.environ.items() if key not in ("LD_PRELOAD", "PYTHONPATH")}
    program = f"import scikit_build_core.build as b; b.build_{kind}({str(folder)!r})"
    done = subprocess.run([sys.executable, "-c", program], cwd=source, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and "WARNING" not in done.stdout, done.stdout + done.stderr
    return next(folder.glob("*.tar.gz" if kind == "sdist" else "*.whl"))


def installed_in(folder, *what):
    """Run a command of an environment that has these and what they require alone, away from the checkout and from any
    compiler."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "TUMBLE", "LD_"))}
    environment["PATH"] = str(folder)  # where no program is

    def run(name, *arguments):
        command = [folder / "venv/bin" / name, *arguments]
        return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=600)

    venv.create(folder / "venv", with_pip=True)
    done = run("python", "-m", "pip", "install", "--no-input", "--disable-pip-version-check", *what)
    assert done.returncode == 0, done.stderr
    return run
