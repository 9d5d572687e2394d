"""The build for the target fails beyond a limit of boards/budget.csv, and on code whose stack nobody can bound."""
import re

import pytest
from conftest import ROOT, run

REJECTED = {
    "code": r"cortex-m4 core: code \d+ B exceeds its limit of 12288 B",
    "library": r"cortex-m4 core: library \d+ B exceeds its limit of 4608 B",
    "static_ram": r"cortex-m4 core: static_ram \d+ B exceeds its limit of 1536 B",
    "stack": r"cortex-m4 core: stack \d+ B exceeds its limit of 512 B",
    "recursion": r"cortex-m4 core: recursion: canary_(even|odd) -> canary_(odd|even) -> canary_(even|odd)",
    "indirect": r"cortex-m4 core: indirect call in canary_call",
    "dynamic": r"cortex-m4 core: stack of unknown size in canary_dynamic",
    "heap": r"cortex-m4 core: heap\.c\.obj needs malloc",
}


@pytest.mark.parametrize("defect", REJECTED)
def test_build_rejects(cortex_m4, defect):
    result = cortex_m4(f"budget_canary_{defect}")
    assert result.returncode != 0
    assert re.search("^budget: " + REJECTED[defect], result.stdout, re.MULTILINE), result.stdout


def test_only_the_planted_limit_is_exceeded(cortex_m4):
    result = cortex_m4("budget_canary_stack")
    assert result.stdout.count("exceeds its limit") == 1, result.stdout


def test_build_accepts_the_core_with_harmless_code(cortex_m4):
    result = cortex_m4("budget_canary_clean")
    assert result.returncode == 0, result.stdout


def test_a_part_without_limits_is_an_error(cortex_m4, tmp_path):
    limits = tmp_path / "budget.csv"
    limits.write_text("target,part,code_limit_bytes\ncortex-m4,other,1\n")
    result = run("tools/budget", "--limits", limits, "--target", "cortex-m4", "--part", "core",
                 "--image", "x", "--map", "x", "x.o")
    assert result.returncode == 2
    assert "0 rows for target cortex-m4, part core; exactly one is needed" in result.stdout


def test_a_map_of_another_image_is_an_error(cortex_m4, tmp_path):
    assert cortex_m4("budget_canary_clean").returncode == 0
    built = ROOT / "build/cortex-m4/tests/canary/budget"
    (tmp_path / "empty.map").write_text("Linker script and memory map\n")
    result = run("tools/budget", "--limits", "boards/budget.csv", "--target", "cortex-m4", "--part", "core",
                 "--image", built / "footprint_canary_clean", "--map", tmp_path / "empty.map",
                 f"@{built / 'canary_clean.objects'}")
    assert result.returncode == 2
    assert "does not account for" in result.stdout
