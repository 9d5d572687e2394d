"""The tests' own limits against hanging (tests/lib/hang_guards.py)."""

import subprocess
import sys
import time

import hang_guards
import pytest


def test_a_short_limit_is_kept_and_a_long_one_is_for_a_machine_at_rest():
    assert [hang_guards.longer(limit_s) for limit_s in (None, 0.1, 14.9, 15, 60)] == [None, 0.1, 14.9, 150, 600]


@pytest.mark.parametrize("wait", ["wait", "communicate"])
def test_what_hangs_is_found(wait, monkeypatch):
    monkeypatch.setattr(hang_guards, "GUARD_S", 0.05)
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    began = time.monotonic()
    with pytest.raises(subprocess.TimeoutExpired):
        getattr(process, wait)(timeout=0.1)
    assert time.monotonic() - began > 0.9
    process.kill()
    process.wait()
