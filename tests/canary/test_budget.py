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

REJECTED_OF_NAVCOMP = {
    "code": r"cortex-m4 navcomp: code \d+ B exceeds its limit of \d+ B",
    "static_ram": r"cortex-m4 navcomp: static_ram \d+ B exceeds its limit of 4096 B",
    "deep": r"cortex-m4 navcomp: stack \d+ B exceeds its limit of 1024 B",
    "recursion": r"cortex-m4 navcomp: recursion: canary_(even|odd) -> canary_(odd|even) -> canary_(even|odd)",
    "indirect": r"cortex-m4 navcomp: indirect call in canary_call",
    "dynamic": r"cortex-m4 navcomp: stack of unknown size in canary_dynamic",
    "heap": r"cortex-m4 navcomp: heap\.c\.obj needs malloc",
    "unlisted": r"cortex-m4 navcomp: \S+calls\.csv: canary_unlisted has its address taken and is nobody's target",
}


@pytest.mark.parametrize("defect", REJECTED)
def test_build_rejects(cortex_m4, defect):
    result = cortex_m4(f"budget_canary_{defect}")
    assert result.returncode != 0
    assert re.search("^budget: " + REJECTED[defect], result.stdout, re.MULTILINE), result.stdout


@pytest.mark.parametrize("defect", REJECTED_OF_NAVCOMP)
def test_build_rejects_in_navcomp(cortex_m4, defect):
    result = cortex_m4(f"budget_canary_navcomp_{defect}")
    assert result.returncode != 0
    assert re.search("^budget: " + REJECTED_OF_NAVCOMP[defect], result.stdout, re.MULTILINE), result.stdout


def test_build_accepts_navcomp_with_harmless_code(cortex_m4):
    result = cortex_m4("budget_canary_navcomp_clean")
    assert result.returncode == 0, result.stdout


# Edits of the committed list of indirect calls, and what must be said of the list then.
SPOILT_LISTS = {
    "a call without an entry": ("tumble_link_send,board\n", "", "indirect call in tumble_link_send"),
    "an entry without its call": ("tumble_link_send,board\n", "tumble_link_send,board\ncanary_clean,board\n",
                                  "canary_clean calls nothing through a pointer"),
    "a target left out": ("tell_heartbeat,tumble_navcomp_node_events+8/20\n", "tell_heartbeat,board\n",
                          "heartbeat has its address taken and is nobody's target"),
    "a target that is none": ("tumble_navcomp_init,board\n", "tumble_navcomp_init,tumble_pdo_step\n",
                              "tumble_pdo_step is a target, and nobody holds its address"),
    "no such function": ("tumble_link_send,board\n", "tumble_link_send,canary\n", "the image has no function canary"),
    "no such table": ("estimators+0/4", "canaries+0/4", "the image has 0 tables canaries"),
    "no such column": ("estimators+0/4", "estimators+0/8", "estimators of 12 B has no column 0 of rows of 8 B"),
}


@pytest.mark.parametrize("spoilt", SPOILT_LISTS)
def test_a_list_of_calls_that_disagrees_with_the_image_is_rejected(cortex_m4, tmp_path, spoilt):
    assert cortex_m4("budget_canary_navcomp_clean").returncode == 0
    old, new, message = SPOILT_LISTS[spoilt]
    listed = (ROOT / "firmware/calls.csv").read_text()
    assert listed.count(old) == 1
    (tmp_path / "calls.csv").write_text(listed.replace(old, new))
    built = ROOT / "build/cortex-m4/tests/canary/budget"
    image = built / "footprint_canary_navcomp_clean"
    result = run("tools/budget", "--limits", "boards/budget.csv", "--target", "cortex-m4", "--part", "navcomp",
                 "--image", image, "--map", f"{image}.map", "--calls", tmp_path / "calls.csv",
                 "--linked", f"{image}.ltrans0.ltrans.o", f"@{built / 'canary_navcomp_clean.objects'}")
    assert result.returncode == 1, result.stdout
    assert message in result.stdout


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
