"""tumble-bench from a profile (cmake/profile.cmake): other machine code, the same bytes."""

import json
import re
import shutil
import subprocess

import pytest
from conftest import ROOT

from tumble.bench import program

COMPILER = shutil.which("gcc") or ""
pytestmark = [
    pytest.mark.slow,
    pytest.mark.toolchain,
    pytest.mark.skipif(not COMPILER or not shutil.which("ninja"), reason="not installed: gcc or ninja"),
]
SEEDS = (1, 77, 5000, 2**63)
TAKES_TIME = re.compile(r'"(wall_s|cpu_s|ms_per_life)":[0-9.e-]+')


def run(*command):
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=500)
    assert done.returncode in (0, 1), done.stdout + done.stderr  # 1: a run failed its gravity check
    return done.stdout


@pytest.fixture(scope="module")
def profiled(tmp_path_factory):
    """The program, built twice in one folder as the presets do."""
    folder = tmp_path_factory.mktemp("profiled")
    options = ["-G", "Ninja", "-S", ROOT, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_C_COMPILER={COMPILER}"]
    for profile, target in (("generate", "profile"), ("use", "tumble-bench")):
        run("cmake", *options, f"-DTUMBLE_PROFILE={profile}")
        run("cmake", "--build", folder, "--target", target)
    return folder / "host/bench/tumble-bench"


def test_it_was_counted(profiled):
    counted = {path.name for path in profiled.parent.rglob("*.gcda")}
    assert {"campaign.c.gcda", "averaging_sample.c.gcda", "sensor.c.gcda"} <= counted


@pytest.mark.parametrize("seed", SEEDS)
def test_runs_are_the_same_bytes(profiled, seed):
    options = ["--runs", 10, "--means", "--seed", seed]
    assert run(profiled, *options) == run(program.find(), *options)
    assert run(profiled, "--seed", seed) == run(program.find(), "--seed", seed)


def test_hostile_lives_are_the_same_but_for_the_time_they_take(profiled):
    options = ["--campaign", 3, "--seed", 9]
    found, expected = (TAKES_TIME.sub("", run(one, *options)) for one in (profiled, program.find()))
    assert found == expected


def test_presets_share_the_folder():
    presets = json.loads((ROOT / "CMakePresets.json").read_text())["configurePresets"]
    by_name = {preset["name"]: preset for preset in presets}
    assert by_name["profiled"]["inherits"] == "profile" and "binaryDir" not in by_name["profiled"]
