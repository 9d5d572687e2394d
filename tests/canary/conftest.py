"""Canaries: every gate of tools/test must reject a planted defect, and accept the same thing without it."""
import contextlib
import functools
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "tests/lib")]

import stages  # noqa: E402

pytest_plugins = ["hang_guards"]


def run(*command, **environment):
    """A finished process with `returncode` and, in `stdout`, all that it printed."""
    return subprocess.run([str(part) for part in command], cwd=ROOT, env={**os.environ, **environment}, text=True,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=600)


@functools.cache
def configured(preset, *options):
    """The build directory of a preset, configured."""
    result = run("cmake", "--preset", preset, *options)
    assert result.returncode == 0, result.stdout
    return ROOT / "build" / preset


@pytest.fixture(scope="session")
def sanitizers():
    if "Unity" in stages.read_missing():
        pytest.skip("Unity is not installed, and the preset builds its tests with it")
    return functools.partial(build, configured("sanitizers", "-DTUMBLE_TESTS=ON"))


@pytest.fixture
def cortex_m4():
    if shutil.which("arm-none-eabi-gcc") is None:
        pytest.skip("arm-none-eabi-gcc is not installed")
    return functools.partial(build, configured("cortex-m4"))


def build(directory, target):
    """Try to build one target; the finished process."""
    return run("cmake", "--build", directory, "--target", target)


@contextlib.contextmanager
def planted(tree, defects):
    """For as long as it lasts, files of a copy hold defects: (file, text, what stands there instead). Each text must be
    there exactly once. Gives the files."""
    sound = {}
    try:
        for path, text, instead in defects:
            source = tree / path
            now = source.read_text()
            assert now.count(text) == 1, f"{path}: {text}"
            sound.setdefault(source, now)
            source.write_text(now.replace(text, instead))
        yield list(sound)
    finally:
        for source, text in sound.items():
            source.write_text(text)
