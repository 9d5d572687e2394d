"""`tumble plan optimize`: the gain table as JSON, as a C header and as a gain record, all the same numbers."""

import json
import shutil
import struct
import subprocess
import zlib
from dataclasses import replace

import gain_record
import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES, ROOT
from core_functions import gains_of, stand_gains_of
from documents import document_of, paper_stand

from tumble import core, model
from tumble.files.schedule_file import to_toml
from tumble.model.optimal import optimal_table
from tumble.schedule import Position, Schedule
from tumble.solving import optimal_run
from tumble.stand import PAPER_STAND

STANDS = ("paper", "angle", "lab")
NAMES = [f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"]


def optimize(tumble, *arguments, cwd=EXAMPLES):
    return document_of(tumble("plan", "optimize", *arguments, "--json", cwd=cwd), "plan")


@pytest.mark.parametrize("name", STANDS)
def test_the_document_says_what_the_gains_are_worth(name, tumble):
    plan = optimize(tumble, "--stand", f"{name}_stand.toml")
    assert (plan["schema"], plan["plan"], plan["names"]) == ("tumble.plan/1", "optimize", NAMES)
    assert np.shape(plan["gains"]) == (12, 54) and np.shape(plan["stand_gains"]) == (4, 54)
    assert np.shape(plan["u_K"]) == (3, 3) and np.shape(plan["u_U0"]) == (3,)
    assert plan["efficiency"] == pytest.approx([1.0] * 12, abs=1e-9)
    assert min(plan["gain_over_refined"]) > 1.0 and min(plan["gain_over_least_squares"]) > 1.0
    assert not plan["noise_floored"] and not plan["second_order"]["matters"]
    assert plan["K"] == pytest.approx(NOMINAL_K)


def test_the_default_is_the_papers_stand(tumble):
    assert optimize(tumble)["gains"] == optimize(tumble, "--stand", "paper_stand.toml")["gains"]


def test_a_schedule_without_refined_has_no_gain_over_it(tumble):
    plan = optimize(tumble, "--schedule", "six_faces.toml")
    assert plan["gain_over_refined"] is None and min(plan["gain_over_least_squares"]) >= 1.0 - 1e-9
    assert np.shape(plan["gains"]) == (12, 18)


def test_check_positions_have_no_columns(tumble):
    assert np.shape(optimize(tumble, "--schedule", "with_checks.toml")["gains"]) == (12, 54)


@pytest.mark.parametrize("arguments", [[], ["--schedule", "six_faces.toml"], ["--stand", "angle_stand.toml"]])
def test_people_get_a_table_of_80_columns(arguments, tumble):
    done = tumble("plan", "optimize", *arguments, cwd=EXAMPLES)
    assert (done.returncode, done.stderr) == (0, "")
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert all(name in done.stdout for name in NAMES)


def test_it_says_where_the_stand_is_too_good_or_too_bad(tumble, tmp_path):
    angles = dict.fromkeys(("axis_tilt_rad", "level_rad", "remount_rad", "angle_rad"), "10e-3")
    stand = paper_stand(tmp_path, noise_v=0.0, **angles)
    plan = optimize(tumble, "--stand", stand)
    assert plan["noise_floored"] and plan["second_order"]["matters"]
    shown = tumble("plan", "optimize", "--stand", stand).stdout
    assert "declares no noise" in shown and "large yaw" in shown


def test_the_three_files_hold_the_same_numbers(tumble, tmp_path):
    for kind in ("json", "h", "bin"):
        optimize(tumble, "--stand", EXAMPLES / "lab_stand.toml", "--out", f"table.{kind}", cwd=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["table.bin", "table.h", "table.json"]
    plan, data = json.loads((tmp_path / "table.json").read_text()), (tmp_path / "table.bin").read_bytes()
    opened = core.GainRecord(core.CoreSchedule(core.paper_schedule()), data)
    assert gains_of(opened).tolist() == plan["gains"] and stand_gains_of(opened).tolist() == plan["stand_gains"]
    read = gain_record.from_bytes(data)
    assert read.gains.tolist() == plan["gains"] and read.k.tolist() == plan["K"]
    assert read.u == pytest.approx(np.concatenate([np.ravel(plan["u_K"]), plan["u_U0"]]), rel=1e-9)
    assert read.sigma.tolist() == [2e-4, 5e-4, 2e-3, 2e-4] and read.sigma_mean == plan["sigma_mean_v"]


PROGRAM = """\
#include "table.h"

#include <stdio.h>

int main(void)
{
    return fwrite(&tumble_optimal_gains, sizeof tumble_optimal_gains, 1, stdout) == 1 ? 0 : 1;
}
"""


@pytest.mark.parametrize("arguments", [[], ["--schedule", str(EXAMPLES / "six_faces.toml")]])
def test_the_header_compiles_to_the_record(arguments, tumble, tmp_path):
    for kind in ("h", "bin"):
        optimize(tumble, *arguments, "--out", f"table.{kind}", cwd=tmp_path)
    (tmp_path / "main.c").write_text(PROGRAM)
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror"]
    compiler = shutil.which("gcc") or "cc"
    command = [compiler, *flags, f"-I{ROOT / 'firmware/include'}", "main.c", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "main"], capture_output=True, check=True).stdout
    assert printed == (tmp_path / "table.bin").read_bytes()


def test_a_name_with_anything_in_it_stays_within_its_comment(tumble, tmp_path):
    paper_stand(tmp_path, name='"*/ int evil; /* \u00e9"')
    optimize(tumble, "--stand", "stand.toml", "--out", "table.h", cwd=tmp_path)
    head = (tmp_path / "table.h").read_text().split("#ifndef")[0]
    assert head.count("*/") == 1 and "evil" in head and head.isascii()


def test_a_serial_binds_the_record_to_its_block(tumble, tmp_path):
    paper_stand(tmp_path, block='serial = "B-17 \\u00e9"\n')
    optimize(tumble, "--stand", "stand.toml", "--out", "table.bin", cwd=tmp_path)
    assert gain_record.from_bytes((tmp_path / "table.bin").read_bytes()).block_crc == zlib.crc32("B-17 é".encode())


def test_weights_for_the_last_known_k(tumble, tmp_path):
    run = ["solve", EXAMPLES / "paper_stand.csv", "--out", "result.json"]
    assert tumble(*run, cwd=tmp_path).returncode == 0
    known = json.loads((tmp_path / "result.json").read_text())["K"]
    assert optimize(tumble, "--result", "result.json", cwd=tmp_path)["K"] == known
    header, *rows = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    (tmp_path / "run.csv").write_text("\n".join([header, *rows]))
    assert tumble("solve", "run.csv", "--unit", "mV", "--out", "mv.json", cwd=tmp_path).returncode == 0
    in_millivolts = optimize(tumble, "--result", "mv.json", cwd=tmp_path)["K"]
    assert np.array(in_millivolts) == pytest.approx(1e-3 * np.array(known))


BAD = {
    "suffix": (["--out", "table.txt"], "--out: 'table.txt' ends in none of .json, .h, .bin"),
    "no folder": (["--out", "nowhere/table.h"], "nowhere/table.h: cannot be written: no such file or folder"),
    "its own input": (["--result", "result.json", "--out", "result.json"], "--out: 'result.json' is an input"),
    "no stand": (["--stand", "nothing.toml"], "nothing.toml: no such file"),
    "no block": (["--stand", "bare.toml"], "bare.toml: no table [block]"),
    "no result": (["--result", "bare.toml"], "bare.toml: is TOML, such as a stand or a schedule file; a result of"),
    "other unit": (["--result", "counts.json"], "counts.json: K is in 'counts' per g; a gain table needs volts"),
    "rank": (["--schedule", "flat.toml"], "flat.toml: these positions cannot identify K_xy, K_yy, K_zy"),
    "noise": (["--stand", "stand.toml"], "noise_v must be 0 to 1e+09"),
    "estimator": (["--estimator", "refined"], "unrecognized arguments: --estimator refined"),
}


@pytest.mark.python
def test_optimal_weights_are_for_as_many_mountings_as_the_core_takes(tumble, refused, tmp_path):
    """Six; other estimators take more, and of all of them a plan leaves out this one."""
    three = core.built_in("diagonal")
    for count in (6, 7):
        more = [replace(three.mountings[n % 3], number=n + 1) for n in range(count)]
        positions = [Position(one.number, n + 1, 45.0 + 90.0 * n) for one in more for n in range(4)]
        (tmp_path / f"{count}.toml").write_text(to_toml(Schedule(tuple(more), tuple(positions))))
    for out in ([], ["--out", "table.bin"], ["--out", "table.h"], ["--out", "table.json"]):
        assert tumble("plan", "optimize", "--schedule", "6.toml", *out, cwd=tmp_path).returncode == 0
        (tmp_path / out[1]).unlink() if out else None
        line = refused("plan", "optimize", "--schedule", "7.toml", *out, cwd=tmp_path)
        assert line == "tumble: 7.toml: has 7 mountings, optimal takes 6; least_squares solves any schedule\n"
        assert not list(tmp_path.glob("table.*"))
    done = tumble("plan", "validate", "--runs", "200", "--schedule", "7.toml", "--json", cwd=tmp_path)
    assert sorted(json.loads(done.stdout)["estimators"]) == ["averaged", "least_squares", "refined"]


@pytest.mark.python
@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_leaves_nothing(case, tumble, refused, tmp_path):
    text = (EXAMPLES / "paper_stand.toml").read_text()
    (tmp_path / "bare.toml").write_text(text.split("[block]")[0])
    paper_stand(tmp_path, noise_v="1e300")
    one = "[[mounting]]\nnumber = 1\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
    turns = (f"[[position]]\nmounting = 1\nposition = {i + 1}\nangle_deg = {45 * i}\n" for i in range(8))
    (tmp_path / "flat.toml").write_text(one + "".join(turns))
    for unit, name in (("V", "result.json"), ("counts", "counts.json")):
        assert tumble("solve", EXAMPLES / "paper_stand.csv", "--unit", unit, "--out", tmp_path / name).returncode == 0
    arguments, message = BAD[case]
    assert message in refused("plan", "optimize", *arguments, cwd=tmp_path)


# Of a record for one mounting, and channels that are alike.
ALIKE = {"mountings": 1, "yaws": 1, "seats": 0, "waves": 0, "drifts": 0, "inclinations": 0}
ALIKE |= {"sigma_inclination": 0.0, "weights": np.ones(3), "floored": False}


def golden():
    """A record written out by hand, of two positions, one mounting, one yaw, and numbers that no estimator made."""
    numbers = [float(n) / 8 for n in range(1, 27 + 6 * 15)]
    head = b"TGR1" + struct.pack("<I", 24 + 8 * len(numbers) + 8) + bytes([1, 0, 2, 1, 1, 0, 0, 0])
    body = head + struct.pack("<II", 0x01234567, 0x89ABCDEF) + struct.pack(f"<{len(numbers)}d", *numbers) + bytes(4)
    return numbers, body + struct.pack("<I", zlib.crc32(body))


def test_the_record_is_laid_out_as_documented():
    numbers, _ = golden()
    tables = np.array(numbers[26:]).reshape(-1, 6)
    made = optimal_run.Record(
        **ALIKE,
        schedule_crc=0x01234567,
        block_crc=0x89ABCDEF,
        k=np.reshape(numbers[:9], (3, 3)),
        sigma=np.array(numbers[9:13]),
        sigma_mean=numbers[13],
        u=np.array(numbers[14:26]),
        gains=tables[:12],
        nuisance_gains=tables[12:],
    )
    assert len(tables) == 15
    assert optimal_run.to_bytes(made) == golden()[1]
    assert optimal_run.to_bytes(gain_record.from_bytes(golden()[1])) == golden()[1]


def test_a_spoilt_record_is_no_record():
    table = optimal_table(model.built_in("paper"), NOMINAL_K, PAPER_STAND)
    data = optimal_run.to_bytes(optimal_run.record_of(table, model.built_in("paper")))
    assert len(data) == gain_record.size_of(18, 2) == 7152
    for index in (0, 4, 8, 10, 11, 12, 13, 14, 15, 20, 30, 500, 5000, len(data) - 8, len(data) - 1):
        spoilt = bytearray(data)
        spoilt[index] ^= 1
        with pytest.raises(gain_record.BadRecord):
            gain_record.from_bytes(bytes(spoilt))
    for short in (b"", data[:20], data[:-1]):
        with pytest.raises(gain_record.BadRecord):
            gain_record.from_bytes(short)


def test_a_record_of_no_position_is_no_record():
    parts = {"k": np.eye(3), "sigma": np.ones(4), "sigma_mean": 1.0, "u": np.ones(12), "gains": np.empty((12, 0))}
    crcs = {"schedule_crc": 0, "block_crc": 0}
    empty = optimal_run.Record(**ALIKE, **crcs, **parts, nuisance_gains=np.empty((3, 0)))
    with pytest.raises(gain_record.BadRecord):
        gain_record.from_bytes(optimal_run.to_bytes(empty))
