"""The fuzz stage: every target finds a planted defect in its time, and accepts the firmware; no skip is silent."""
import fuzz
import pytest
from conftest import ROOT, configured, run
from stages import PYTHON

SECONDS = fuzz.SECONDS * len(fuzz.TARGETS)  # what the stage takes
FOUND = {  # target: what must be said of its defect, which tests/canary/fuzz describes
    "block_frames": "violated: widened counter",
    "canopen": "ERROR: AddressSanitizer: global-buffer-overflow",
    "navcomp": "ERROR: AddressSanitizer: global-buffer-overflow",
}


@pytest.fixture(scope="module")
def built():
    if (lacking := fuzz.what_lacks()) is not None:
        pytest.skip(f"{lacking} is not installed")
    programs = [f"{kind}_{target}" for kind in ("fuzz", "canary_fuzz") for target in fuzz.TARGETS]
    result = run("cmake", "--build", configured("fuzz"), "--target", *programs)
    assert result.returncode == 0, result.stdout


@pytest.mark.parametrize("target", fuzz.TARGETS)
def test_finds_what_is_planted(built, tmp_path, target):
    """With a search that begins in the same way every time."""
    command = fuzz.command(target, f"canary_fuzz_{target}", SECONDS, tmp_path / "corpus")
    result = run(*command, "-seed=1", f"-artifact_prefix={tmp_path}/")
    assert result.returncode == fuzz.FOUND, result.stdout[-2000:]
    assert FOUND[target] in result.stdout


@pytest.mark.parametrize("target", fuzz.TARGETS)
def test_the_seeds_alone_do_not_find_it(built, tmp_path, target):
    """Or the canary would say nothing of the search; and the target itself has nothing against them."""
    for program in (f"canary_fuzz_{target}", f"fuzz_{target}"):
        command = fuzz.command(target, program, SECONDS, tmp_path / program)
        result = run(*command, "-runs=0", f"-artifact_prefix={tmp_path}/")
        assert result.returncode == 0, result.stdout[-2000:]


def test_what_was_found_fails_the_stage(built, monkeypatch):
    """libFuzzer's own status for it is the 77 that means a skip elsewhere."""
    monkeypatch.setattr(fuzz, "build", lambda *programs: True)
    monkeypatch.setattr(fuzz, "run", lambda *command: 77 if "block_frames" in str(command[0]) else 0)
    assert fuzz.main([]) == 1
    assert fuzz.main(["navcomp"]) == 0


def test_a_build_that_fails_fails_the_stage(built, monkeypatch):
    monkeypatch.setattr(fuzz, "run", lambda *command: 1)
    assert fuzz.main([]) == 1


def test_a_missing_compiler_is_a_skip_and_not_a_pass(tmp_path):
    result = run(PYTHON, "tools/fuzz.py", PATH=str(tmp_path))
    assert (result.returncode, result.stdout) == (77, "clang-19 is not installed\n")


def test_another_compiler_is_refused(tmp_path):
    result = run("cmake", "-S", ROOT, "-B", tmp_path, "-DTUMBLE_FUZZ=ON", "-DCMAKE_C_COMPILER=gcc")
    assert result.returncode != 0 and "TUMBLE_FUZZ needs clang" in result.stdout


def test_seeds_are_read_as_they_are_written(tmp_path):
    (tmp_path / "seeds.txt").write_text("# a note\n\n# one\n0102\n03 04  # so\n\n\n# two\nff\n0a 0b x3  # thrice\n00\n")
    assert fuzz.read_seeds(tmp_path / "seeds.txt") == [b"\x01\x02\x03\x04", b"\xff" + 3 * b"\x0a\x0b" + b"\0"]
