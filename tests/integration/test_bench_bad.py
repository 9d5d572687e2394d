"""What `tumble bench` must refuse: exit 2, one line, nothing left behind. And what it must not believe: exit 3."""

import os

import pytest
from conftest import EXAMPLES

from tumble import errors

PAPER = (EXAMPLES / "paper_stand.toml").read_text()

OPTIONS = {
    "seed below 0": (["--seed=-1"], "--seed: '-1' is not a whole number from 0 to 18446744073709551615"),
    "seed too large": (["--seed", "18446744073709551616"], "--seed: '18446744073709551616' is not"),
    "seed as a fraction": (["--seed", "1.5"], "--seed: '1.5' is not a whole number"),
    "seed in words": (["--seed", "seven"], "--seed: 'seven' is not a whole number"),
    "seed in hexadecimal": (["--seed", "0x10"], "--seed: '0x10' is not"),
    "seed with a blank": (["--seed", " 1"], "--seed: ' 1' is not"),
    "seed in other digits": (["--seed", "\u0663"], "--seed: "),
    "empty seed": (["--seed", ""], "--seed: '' is not"),
    "endless seed": (["--seed", "9" * 5000], "--seed: '99"),
    "no samples": (["--samples", "0"], "--samples: '0' is not a whole number from 1 to 1048576"),
    "samples below 0": (["--samples=-5"], "--samples: '-5' is not"),
    "too many samples": (["--samples", "1048577"], "--samples: '1048577' is not"),
    "samples as a fraction": (["--samples", "10.0"], "--samples: '10.0' is not"),
    "limit 0": (["--limit", "0"], "--limit: '0' is not a number of g"),
    "limit not a number": (["--limit", "nan"], "--limit: 'nan' is not a number of g"),
    "estimator unknown": (["--estimator", "best"], "invalid choice: 'best'"),
    "bus unknown": (["--bus", "token ring"], "'token ring' is not inprocess, uml, or socketcan:"),
    "firmware unknown": (["--firmware", "toaster"], "invalid choice: 'toaster'"),
    "stand not there": (["--stand", "nowhere.toml"], "nowhere.toml: no such file or folder"),
    "stand is a folder": (["--stand", "."], "a folder, not a file"),
    "block not there": (["--block", "nowhere.toml"], "nowhere.toml: no such file or folder"),
    "schedule not there": (["--schedule", "nowhere.toml"], "nowhere.toml: no such file or folder"),
    "schedule the estimator cannot use": (
        ["--schedule", str(EXAMPLES / "six_faces.toml"), "--estimator", "refined"],
        "lacks positions that refined needs; least_squares solves any schedule",
    ),
    "something more": (["run.csv"], "unrecognized arguments: run.csv (see tumble bench --help)"),
    "out in no folder": (
        ["--out", "nowhere/run"],
        "nowhere/run: the folder cannot be made: make the folder nowhere first",
    ),
    "out empty": (["--out", ""], "not a folder name"),
    "out is a full folder": (["--out", str(EXAMPLES)], "is not an empty folder; remove it or choose another --out"),
    "out is a file": (["--out", str(EXAMPLES / "paper_stand.toml")], "is there already and is not a folder"),
}


@pytest.mark.python
@pytest.mark.parametrize("name", OPTIONS)
def test_options(name, refused, tmp_path):
    options, words = OPTIONS[name]
    assert words in refused("bench", *options, cwd=tmp_path)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--set", "fault"], "--set: 'fault' is not KEY=VALUE"),
        (["--set", "procedure.samples=5"], "--set: procedure.samples is given by --samples"),
        (["--set", "motion.settling_s=-1"], "this cannot be simulated: --set: motion.settling_s must be"),
        (["--set", "no.such=1"], "this cannot be simulated: --set: no such key: no.such"),
        (["--set", "motion.settling_s=1", "--set", "motion.settling_s=2"], "motion.settling_s is given twice"),
        (["--runs", "0"], "--runs: '0' is not a whole number from 1"),
        (["--runs", "2", "--out", "run"], "--runs: takes no --out, --interactive, --report or --model"),
        (["--runs", "2", "--bus", "socketcan:vcan0"], "--runs: runs inprocess alone"),
        (["--jobs", "2"], "--jobs: needs --runs"),
    ],
)
def test_keys_and_runs(options, words, refused, tmp_path):
    assert words in refused("bench", *options, cwd=tmp_path)


STANDS = {
    "no stand": ("[block]\nscale_v_per_g = 2\nmisalignment_rad = 0\n", "no table [stand]"),
    "unknown key": (PAPER.replace("level_rad", "level_deg"), "unknown key 'level_deg' in [stand]"),
    "unknown table": (PAPER + "\n[moton]\n", "unknown key 'moton'"),
    "angle negative": (PAPER.replace("level_rad = 2e-5", "level_rad = -2e-5"), "level_rad must be 0 to 0.5"),
    "samples 0": (PAPER.replace("samples = 50", "samples = 0"), "samples must be 1 to 1.04858e+06"),
    "too many bits": (PAPER.replace("[block]", "[block]\nconverter_bits = 32"), "converter_bits must be 8 to 24 on"),
    "too fast": (PAPER.replace("[block]", "[block]\nsample_rate_hz = 2000"), "sample_rate_hz must be 1 to 1000 on the"),
    "scale 0": (PAPER.replace("scale_v_per_g = 2.0", "scale_v_per_g = 0"), "scale_v_per_g must not be 0"),
    "scale beyond all blocks": (PAPER.replace("scale_v_per_g = 2.0", "scale_v_per_g = 1e300"), "from 1e-09 to 1e+09"),
    "scale of nothing": (PAPER.replace("scale_v_per_g = 2.0", "scale_v_per_g = -1e-300"), "from 1e-09 to 1e+09"),
    "noise beyond all blocks": (PAPER.replace("noise_v = 3e-4", "noise_v = 1e300"), "noise_v must be 0 to 1e+09"),
    "table at rest": (PAPER + "\n[motion]\nvelocity_deg_per_s = 0\n", "velocity_deg_per_s must be 0.1 to 10000"),
    "endless swing": (PAPER + "\n[motion]\nsettling_s = 1e6\n", "settling_s must be 0 to 4.095 on the bench"),
    "swing as long as a turn of the timestamp": (
        PAPER + "\n[motion]\nsettling_s = 4.096\n",
        "settling_s must be 0 to 4.095 on the bench, not 4.096",
    ),
    "range of nothing": (PAPER.replace("[block]", "[block]\nrange_v = 1e-12"), "range_v must be of a size from 1e-09"),
    "not TOML": ("[stand", "not valid TOML"),
}


@pytest.mark.python
@pytest.mark.parametrize("name", STANDS)
def test_stand_files(name, refused, tmp_path):
    text, words = STANDS[name]
    path = tmp_path / "stand.toml"
    path.write_text(text)
    line = refused("bench", "--stand", path, cwd=tmp_path)
    assert words in line


def test_the_longest_settling_there_may_be(tumble, tmp_path):
    path = tmp_path / "stand.toml"
    path.write_text(PAPER + "\n[motion]\nsettling_s = 4.095\n")
    done = tumble("bench", "--stand", path, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr


BLOCKS = {
    "a whole stand file": (PAPER, "unknown key 'stand': a block file holds [block] and [block.true] alone"),
    "nothing": ("", "no table [block]: a block file holds [block] and [block.true] alone"),
    "no scale": ("[block]\nmisalignment_rad = 0.1\n", "[block] has no scale_v_per_g"),
    "truth in part": (
        "[block]\nscale_v_per_g = 2\nmisalignment_rad = 0\n[block.true]\nU0 = [0, 0, 0]\n",
        "[block.true] has no K",
    ),
}


@pytest.mark.python
@pytest.mark.parametrize("name", BLOCKS)
def test_block_files(name, refused, tmp_path):
    text, words = BLOCKS[name]
    path = tmp_path / "block.toml"
    path.write_text(text)
    assert words in refused("bench", "--block", path, cwd=tmp_path)


def test_a_folder_that_is_not_empty_stays_as_it_is(refused, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run/note.txt").write_text("mine")
    assert "is not an empty folder" in refused("bench", "--out", tmp_path / "run")
    assert (tmp_path / "run/note.txt").read_text() == "mine"


def test_an_empty_folder_is_taken(tumble, tmp_path):
    (tmp_path / "run").mkdir()
    assert tumble("bench", "--out", ".", cwd=tmp_path / "run").returncode == 0
    assert sorted(os.listdir(tmp_path / "run")) == ["bus.log", "inputs", "result.json", "run.csv"]


def test_a_world_that_is_not_built(tumble, tmp_path):
    """As a checkout whose set-up stopped before it."""
    without = tmp_path / "without/_tumble_world.py"
    without.parent.mkdir()
    without.write_text("raise ImportError\n")
    path = os.pathsep.join([str(without.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = tumble("bench", "--out", tmp_path / "run", PYTHONPATH=path)
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == f"tumble: the simulated world is not built: {errors.set_up('world')} builds it\n"
    assert not (tmp_path / "run").exists()


SCENARIOS = {
    "no such key": ("# of mine\nno.such_key = 1\n", "faults.txt:2: no such key: no.such_key"),
    "out of range": ("motion.settling_s = -1\n", "faults.txt:1: motion.settling_s must be"),
    "no such fault": ("fault = earthquake at=1.1\n", "faults.txt:1: no such fault"),
    "of no single line": ("block.k = 1 0 0 0 1 0 0 0 1\n", "faults.txt: block.k and block.u0 go together"),
    "a place that the schedule lacks": ("fault = stall at=3.1\n", "faults.txt: a fault names a position that"),
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_scenarios(name, refused, tmp_path):
    text, words = SCENARIOS[name]
    (tmp_path / "faults.txt").write_text(text)
    line = refused("bench", "--scenario", "faults.txt", cwd=tmp_path)
    assert line.startswith("tumble: this cannot be simulated: ") and words in line


FORGERIES = {  # what is changed in bench.json after the run, and what must be noticed
    "K": (lambda d: d["K"][1].__setitem__(1, d["K"][1][1] * (1 + 1e-15)), "the firmware's K is not what the core"),
    "U0": (lambda d: d["U0"].__setitem__(0, d["U0"][0] + 1e-9), "the firmware's U0 is not what the core makes"),
    "a mean": (lambda d: d["means"][3]["u_v"].__setitem__(2, 0.123), "the firmware and numpy disagree: a mean differs"),
    "samples": (lambda d: d["means"][3].__setitem__("samples", 49), "averaged other samples than were recorded"),
    "verdict": (lambda d: d["verification"].__setitem__("pass", False), "the firmware's pass is not what the core"),
    "u_K": (lambda d: d["u_K"][0].__setitem__(2, d["u_K"][0][2] * (1 + 2e-9)), "u_K differs"),
    "u_U0": (lambda d: d["u_U0"].__setitem__(1, d["u_U0"][1] * (1 - 2e-9)), "u_U0 differs"),
    "no u": (lambda d: d.__setitem__("u_K", None), "the firmware states no uncertainties"),
    "delta_g": (
        lambda d: d["verification"]["delta_g_g"][0].__setitem__("delta_g_g", 1e-5),
        "the firmware's delta_g is not what the core makes",
    ),
}


@pytest.mark.parametrize("name", FORGERIES)
def test_a_result_that_is_not_confirmed_is_not_given(name, forged, tmp_path):
    """A firmware that errs: the document is forged between the run and the comparison."""
    forge, words = FORGERIES[name]
    code, out, err = forged(forge, "--out", str(tmp_path / "run"))
    assert (code, out) == (3, "")
    assert words in err.splitlines()[-1] and "no result is given" in err
    assert sorted(os.listdir(tmp_path / "run")) == ["bus.log", "fault.json", "inputs", "run.csv"]
