"""AddressSanitizer and UndefinedBehaviorSanitizer are really on in the preset, in programs and inside Python."""
import subprocess
import sys

import pytest
import stages
from conftest import ROOT, run

PROGRAMS = ROOT / "build/sanitizers/tests/canary/sanitizers"
CASES = {  # program: (harmful argument, what must be said, harmless argument)
    "heap_overflow": ("8", "AddressSanitizer: heap-buffer-overflow", "7"),
    "signed_overflow": ("1", "runtime error: signed integer overflow", "0"),
    "divide_by_zero": ("0", "runtime error: division by zero", "1"),
    "assertion": ("1.25", "1 Tests 1 Failures 0 Ignored", "1.5"),
}


@pytest.mark.parametrize("name", CASES)
def test_program_is_stopped(sanitizers, name):
    harmful, message, harmless = CASES[name]
    assert sanitizers(f"canary_{name}").returncode == 0
    stopped = run(PROGRAMS / f"canary_{name}", harmful)
    assert stopped.returncode != 0
    assert message in stopped.stdout
    accepted = run(PROGRAMS / f"canary_{name}", harmless)
    assert accepted.returncode == 0, accepted.stdout


def test_unity_compares_doubles(sanitizers):
    assert sanitizers("canary_assertion").returncode == 0
    assert "Expected 1.5 Was 1.25" in run(PROGRAMS / "canary_assertion", "1.25").stdout


def call_in_python(index):
    library = PROGRAMS / "libcanary_extension.so"
    call = f"import ctypes; ctypes.CDLL({str(library)!r}).canary_write({index}); print('lived')"
    return run(sys.executable, "-c", call, **stages.sanitizer_environment())


def test_python_is_stopped_when_an_extension_overflows(sanitizers):
    assert sanitizers("canary_extension").returncode == 0
    stopped = call_in_python(8)
    assert stopped.returncode != 0 and "lived" not in stopped.stdout
    assert "AddressSanitizer: heap-buffer-overflow" in stopped.stdout
    accepted = call_in_python(7)
    assert (accepted.returncode, accepted.stdout) == (0, "lived\n")


def test_the_extension_under_test_is_the_instrumented_one():
    question = "import _tumble_core; print(_tumble_core.__file__)"
    answer = run(sys.executable, "-c", question, **stages.sanitizer_environment()).stdout.strip()
    assert answer.startswith(str(ROOT / "build/sanitizers/python/"))
    symbols = subprocess.run(["nm", "-D", answer], check=True, capture_output=True, text=True).stdout
    assert "__asan_report_load8" in symbols and "__ubsan_handle_" in symbols
