"""The build for a target fails beyond a limit of boards/budget.csv, and on code whose stack nobody can bound."""
import functools
import re
import shutil

import pytest
from conftest import ROOT, build, configured, run

COMPILERS = {"cortex-m4": "arm-none-eabi-gcc", "zcu102": "aarch64-linux-gnu-gcc"}  # by preset

RECURSION = r"recursion: canary_(even|odd) -> canary_(odd|even) -> canary_(even|odd)"
ANYWHERE = {
    "code": r"code \d+ B exceeds its limit of \d+ B",
    "recursion": RECURSION,
    "indirect": "indirect call in canary_call",
    "dynamic": "stack of unknown size in canary_dynamic",
}
NAVCOMP = ANYWHERE | {"unlisted": r"\S+calls\.csv: canary_unlisted has its address taken and is nobody's target"}
# By preset and what the build is to say first, the planted defects and what it is to say of them.
REJECTED = {
    ("cortex-m4", "budget: cortex-m4 core: "): ANYWHERE | {
        "library": r"library \d+ B exceeds its limit of 4608 B",
        "static_ram": r"static_ram \d+ B exceeds its limit of 1536 B",
        "stack": r"stack \d+ B exceeds its limit of 432 B",
        "heap": r"heap\.c\.obj needs malloc",
    },
    ("cortex-m4", "budget: cortex-m4 navcomp: "): NAVCOMP | {
        "static_ram": r"static_ram \d+ B exceeds its limit of 4080 B",
        "deep": r"stack \d+ B exceeds its limit of 864 B",
        "floating": r"canary_floating takes floating point: canary_floating > (canary_mean > )?__aeabi_\w+",
        "heap": r"heap\.c\.obj needs malloc",
    },
    ("zcu102", "budget: cortex-a53 navcomp: "): NAVCOMP | {
        "static_ram": r"static_ram \d+ B exceeds its limit of 7200 B",
        "deep": r"stack \d+ B exceeds its limit of 1680 B",
        "assembly": r"stack 8[23]\d\d B exceeds its limit of 1680 B",
        "moved": r"stack of unknown size in canary_moved \(\S+ mov sp, x0\)",
    },
    ("zcu102", r"\S+/heap\.c:\d+: "): {"heap": "undefined reference to `malloc'"},
}
DEFECTS = [(preset, f"{'' if 'core' in begin else 'navcomp_'}{defect}", begin + said)
           for (preset, begin), defects in REJECTED.items() for defect, said in defects.items()]


def builder(preset):
    """What tries to build a target of a preset."""
    if shutil.which(COMPILERS[preset]) is None:
        pytest.skip(f"{COMPILERS[preset]} is not installed")
    return functools.partial(build, configured(preset))


@pytest.mark.parametrize("preset, defect, said", DEFECTS, ids=[" ".join(row[:2]) for row in DEFECTS])
def test_build_rejects(preset, defect, said):
    result = builder(preset)(f"budget_canary_{defect}")
    assert result.returncode != 0
    assert re.search("^" + said, result.stdout, re.MULTILINE), result.stdout


@functools.cache
def harmless(preset):
    """The build of navcomp with harmless code, once."""
    return builder(preset)("budget_canary_navcomp_clean")


@pytest.mark.parametrize("preset", COMPILERS)
def test_build_accepts_navcomp_with_harmless_code(preset):
    result = harmless(preset)
    assert result.returncode == 0, result.stdout


# Edits of the committed lists of indirect calls, and what must be said of the list then.
SPOILT_LISTS = {
    "cortex-m4": {
        "a call without an entry": ("tumble_link_send,board\n", "", "indirect call in tumble_link_send"),
        "an entry without its call": ("tumble_link_send,board\n", "tumble_link_send,board\ncanary_clean,board\n",
                                      "canary_clean calls nothing through a pointer"),
        "a target left out": ("tell_heartbeat,tumble_navcomp_node_events+8/20\n", "tell_heartbeat,board\n",
                              "heartbeat has its address taken and is nobody's target"),
        "a target that is none": ("tumble_navcomp_init,board\n", "tumble_navcomp_init,tumble_pdo_step\n",
                                  "tumble_pdo_step is a target, and nobody holds its address"),
        "no such function": ("tumble_link_send,board\n", "tumble_link_send,canary\n",
                             "the image has no function canary"),
        "no such table": ("estimators+0/4", "canaries+0/4", "the image has 0 tables canaries"),
        "no such column": ("estimators+0/4", "estimators+0/12", "estimators of 20 B has no column 0 of rows of 12 B"),
    },
    "zcu102": {
        "a call without an entry": ("tumble_link_send,can_send\n", "", "indirect call in tumble_link_send"),
        "an entry without its call": ("tumble_link_send,can_send\n", "tumble_link_send,can_send\ncanary_clean,\n",
                                      "canary_clean calls nothing through a pointer"),
        "a target left out": ("tell_heartbeat,tumble_navcomp_node_events+16/40\n", "tell_heartbeat,\n",
                              "heartbeat has its address taken and is nobody's target"),
        "a target that only code holds": ("tumble_link_send,can_send\n", "tumble_link_send,\n",
                                          "can_send has its address taken and is nobody's target"),
        "a target that is none": ("tumble_navcomp_init,now_us\n", "tumble_navcomp_init,now_us zcu102_now_us\n",
                                  "zcu102_now_us is a target, and nobody holds its address"),
        "no such function": ("tumble_link_send,can_send\n", "tumble_link_send,canary\n",
                             "the image has no function canary"),
        "no such table": ("estimators+0/8", "canaries+0/8", "the image has 0 tables canaries"),
        "no such column": ("estimators+0/8", "estimators+0/24",
                           "estimators of 40 B has no column 0 of rows of 24 B"),
    },
}
LISTS = {"cortex-m4": "firmware/calls.csv", "zcu102": "boards/zcu102/calls.csv"}


def budget_of_navcomp(preset, calls, *more):
    """tools/budget on the image of the harmless canary, with another list of calls."""
    built = ROOT / f"build/{preset}/tests/canary/budget"
    if preset == "zcu102":
        image, whole = built / "canary_navcomp_clean.elf", ["--exceptions", "vectors", "--tools", "aarch64-linux-gnu-"]
    else:
        image = built / "footprint_canary_navcomp_clean"
        whole = ["--linked", f"{image}.ltrans0.ltrans.o"]
    target = "cortex-a53" if preset == "zcu102" else preset
    return run("tools/budget", "--limits", "boards/budget.csv", "--target", target, "--part", "navcomp",
               "--image", image, "--map", f"{image}.map", "--calls", calls, *whole, *more,
               f"@{built / 'canary_navcomp_clean.objects'}")


@pytest.mark.parametrize("preset, spoilt", [(preset, edit) for preset, edits in SPOILT_LISTS.items() for edit in edits])
def test_a_list_of_calls_that_disagrees_with_the_image_is_rejected(preset, spoilt, tmp_path):
    assert harmless(preset).returncode == 0
    old, new, message = SPOILT_LISTS[preset][spoilt]
    listed = (ROOT / LISTS[preset]).read_text()
    assert listed.count(old) == 1
    (tmp_path / "calls.csv").write_text(listed.replace(old, new))
    result = budget_of_navcomp(preset, tmp_path / "calls.csv")
    assert result.returncode == 1, result.stdout
    assert message in result.stdout


def test_a_function_of_the_sample_path_that_is_not_there_is_rejected():
    assert harmless("cortex-m4").returncode == 0
    result = budget_of_navcomp("cortex-m4", LISTS["cortex-m4"], "--integer", "canary_clean", "--integer", "canary_none")
    assert result.returncode == 1
    assert "no object has a function canary_none" in result.stdout
    assert "canary_clean" not in result.stdout


def test_a_whole_image_without_the_exceptions_named_is_rejected():
    assert harmless("zcu102").returncode == 0
    result = budget_of_navcomp("zcu102", LISTS["zcu102"], "--exceptions", "canary")
    assert result.returncode == 1
    assert "the image has no table of exceptions canary" in result.stdout


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
