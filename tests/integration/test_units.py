"""The unit of a run's outputs, and what the stand's noise in volts means to it; what is written to nowhere."""

import json
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble as package

pytestmark = pytest.mark.python

STAND = EXAMPLES / "paper_stand.toml"
RUN = (EXAMPLES / "paper_stand.csv").read_text().splitlines()


def rewritten(path, header, factor):
    rows = [line.split(",") for line in RUN[1:]]
    lines = [",".join([*row[:2], *(repr(float(u) * factor) for u in row[2:])]) for row in rows]
    path.write_text("\n".join([f"mounting,position,{header}", *lines]) + "\n")
    return path


def solved(tumble, run, *options):
    done = tumble("solve", run, "--json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(("unit", "factor"), [("mV", 1e3), ("uV", 1e6), ("µV", 1e6), ("kV", 1e-3)])
def test_uncertainties_follow_the_unit(unit, factor, tumble, tmp_path):
    header = f"ux [{unit}],uy [{unit}],uz [{unit}]"
    scaled = solved(tumble, rewritten(tmp_path / "run.csv", header, factor), "--stand", STAND)
    volts = solved(tumble, EXAMPLES / "paper_stand.csv", "--stand", STAND)
    for name in ("u_U0", "U0"):
        assert [value / factor for value in scaled[name]] == pytest.approx(volts[name], rel=1e-9)
    for row, expected in zip(scaled["u_K"], volts["u_K"]):
        assert [value / factor for value in row] == pytest.approx(expected, rel=1e-9)
    for name in ("noise_v", "u_noise_v", "u_alpha1_rad"):
        assert scaled["stand_seen"][name] == pytest.approx(volts["stand_seen"][name], rel=1e-9), name


def test_another_unit_takes_the_place_of_the_volt(tumble, tmp_path):
    run = rewritten(tmp_path / "run.csv", "ux [m/s^2],uy [m/s^2],uz [m/s^2]", 1.0)
    other, volts = (solved(tumble, file, "--stand", STAND) for file in (run, EXAMPLES / "paper_stand.csv"))
    its_own = ("unit", "units", "run_file", "run_sha256", "created", "assumes", "assumed_for", "warnings")
    assert {**other, **{name: volts[name] for name in its_own}} == volts and volts["unit"] == "V"
    without_block = tmp_path / "without_block.toml"
    without_block.write_text(STAND.read_text().partition("[block]")[0])
    done = tumble("solve", run, "--stand", without_block, "--details")
    assert "m/s^2, declared 3.00e-04\n" in done.stdout
    warning = "outputs in m/s^2: noise_v of the stand file, 0.0003, is in m/s^2 too"
    odd = "tumble: warning: 1 g gives 2.002 m/s^2: outputs look to be in another unit (--unit)\n"
    assert done.stderr == f"{odd}tumble: warning: {warning}\n"
    assert tumble("solve", run).stderr == odd


def test_a_declared_block_confirms_the_unit_of_its_file(tumble, tmp_path):
    """K is the declared one, so noise_v, from the same file, is in the unit of the outputs: nothing to be warned of."""
    run = rewritten(tmp_path / "run.csv", "ux [m/s^2],uy [m/s^2],uz [m/s^2]", 1.0)
    assert tumble("solve", run, "--stand", STAND).stderr == ""
    tenfold = rewritten(tmp_path / "tenfold.csv", "ux [m/s^2],uy [m/s^2],uz [m/s^2]", 10.0)
    assert "noise_v of the stand file, 0.0003, is in m/s^2 too" in tumble("solve", tenfold, "--stand", STAND).stderr


@pytest.mark.parametrize("header", ["ux [V],uy [mV],uz [V]", "ux,uy,uz [mV]"])
def test_different_units_are_refused(header, refused, tumble, tmp_path):
    run = rewritten(tmp_path / "run.csv", header, 1.0)
    assert "run.csv: row 1: outputs in different units: " in refused("solve", run)
    assert solved(tumble, run, "--unit", "V")["unit"] == "V"


def test_an_export_does_not_replace_its_result(tumble, refused, tmp_path):
    result = tmp_path / "r.json"
    assert tumble("solve", EXAMPLES / "paper_stand.csv", "--out", result).returncode == 0
    before = result.read_bytes()
    assert "is an input of this command" in refused("export", result, "--format", "csv", "--out", result)
    assert result.read_bytes() == before


def test_an_output_keeps_its_permissions(tumble, tmp_path):
    result = tmp_path / "r.json"
    result.write_text("old")
    result.chmod(0o600)
    assert tumble("solve", EXAMPLES / "paper_stand.csv", "--out", result).returncode == 0
    assert result.stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize("sink", ["/dev/full", "closed", "read only"])
def test_the_exit_code_stands_when_nobody_can_read_the_message(sink):
    def lose_stderr():
        os.close(2)
        if sink == "read only":
            os.dup2(os.open(os.devnull, os.O_RDONLY), 2)

    command = [sys.executable, "-m", "tumble", "solve", "nosuch.csv"]
    if sink == "/dev/full":
        with open(sink, "w") as full:
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=full)
    else:
        done = subprocess.run(command, stdout=subprocess.PIPE, preexec_fn=lose_stderr)
    assert (done.returncode, done.stdout) == (2, b"")


def test_check_positions_are_reported_apart(tumble):
    arguments = ["--schedule", EXAMPLES / "with_checks.toml"]
    text = tumble("solve", EXAMPLES / "with_checks.csv", *arguments).stdout
    largest = solved(tumble, EXAMPLES / "with_checks.csv", *arguments)["verification"]
    fitted, checked = largest["max_abs_delta_g_fit_g"], largest["max_abs_delta_g_check_g"]
    assert f"fitted {fitted:.2g} g, check positions {checked:.2g} g (8 of 8)" in text
    text = tumble("solve", EXAMPLES / "paper_stand.csv", *arguments).stdout
    assert "check positions unknown (0 of 8)" in text


def test_a_run_without_a_unit_is_warned_of(tumble):
    """Neither the header nor the user names one: the result says that it assumes volts, and passes."""
    run = EXAMPLES / "paper_stand.csv"
    done = tumble("solve", run, "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["assumes"] == ["seat", "unit", "temperature"]
    assert json.loads(done.stdout)["assumed_for"]["unit"] == []
    said = "the run file names no unit: outputs taken for volts (--unit V, or ux [V] in its header)"
    assert done.stderr == f"tumble: warning: {said}\n"
    shown = tumble("solve", run).stdout
    assert "All values assume volts: the run file names no unit (--unit)" in shown.splitlines()
    verdict = " ".join(shown.partition("\n\n")[0].split())
    assert verdict.startswith(
        "PASS at the 18 measured positions only, assuming a square seat, volts and one temperature: "
    )
    assert verdict.endswith(" 0.0003 g")  # the limit is the last to go
    told = tumble("solve", run, "--unit", "V", "--json")
    assert told.stderr == "" and json.loads(told.stdout)["assumes"] == ["seat", "temperature"]


@pytest.mark.parametrize("spelling", ["m/s2", "m/s²", "m/s**2", "m/s^2"])
def test_metres_per_second_squared_in_all_spellings(spelling, tumble, tmp_path):
    """Of the outputs, by option and in the header, and of what apply and export write."""
    run = rewritten(tmp_path / "run.csv", f"ux [{spelling}],uy [{spelling}],uz [{spelling}]", 1.0)
    assert solved(tumble, run)["unit"] == "m/s^2"
    assert solved(tumble, EXAMPLES / "paper_stand.csv", "--unit", spelling)["unit"] == "m/s^2"
    stand, result = tmp_path / "local.toml", tmp_path / "result.json"
    stand.write_text(STAND.read_text() + "\n[environment]\ngravity_m_s2 = 9.8\n")
    assert tumble("solve", run, "--stand", stand, "--out", result).returncode == 0
    said = [tumble("apply", result, run, "--unit", unit).stdout for unit in (spelling, "g")]
    forces = [[float(text) for text in table.splitlines()[1].split(",")[-3:]] for table in said]
    assert forces[0] == pytest.approx([9.8 * force for force in forces[1]], abs=1e-7)
    assert tumble("export", result, "--format", "csv", "--unit", spelling).returncode == 0


CONTRADICTIONS = [("m/s^2", "V"), ("V", "mV"), ("g", "m/s^2"), ("mV", "g"), ("mg", "ug")]


@pytest.mark.parametrize(("header", "told"), CONTRADICTIONS)
def test_a_known_unit_that_contradicts_the_header_is_refused(header, told, refused, tmp_path):
    run = rewritten(tmp_path / "run.csv", f"ux [{header}],uy [{header}],uz [{header}]", 1.0)
    said = refused("solve", run, "--unit", told)
    advice = "no number is converted: leave --unit out, or correct the names"
    assert f"row 1: outputs are named in {header}, but --unit says {told}; {advice}\n" in said
    assert f"named in {header}, but --unit says {told}; " in refused("import", run, "--unit", told)
    rows = np.loadtxt(run, delimiter=",", skiprows=1)
    table = dict(zip(("mounting", "position", *(f"u{axis} [{header}]" for axis in "xyz")), rows.T))
    with pytest.raises(package.BadInput, match="but unit= says"):
        package.read(table, unit=told)


ALIKE = [("µV", "uV"), ("m/s2", "m/s^2"), ("counts", "V"), ("V", "LSB"), ("V", "V")]


@pytest.mark.parametrize(("header", "told"), ALIKE)
def test_what_does_not_contradict_the_header_is_taken(header, told, tumble, tmp_path):
    run = rewritten(tmp_path / "run.csv", f"ux [{header}],uy [{header}],uz [{header}]", 1.0)
    assert solved(tumble, run, "--unit", told)["unit"] == told


def test_a_row_of_units_that_contradicts_is_refused(refused, tmp_path):
    lines = ["mounting,position,ux,uy,uz", "-,-,m/s^2,m/s^2,m/s^2", *RUN[1:]]
    run = tmp_path / "units.csv"
    run.write_text("\n".join(lines) + "\n")
    assert "row 2: outputs are named in m/s^2, but --unit says V; " in refused("import", run, "--unit", "V")


def scaled_stand(path, scale):
    """The paper's stand, made for a block whose outputs at 1 g are so many of whatever they are in."""
    path.write_text(STAND.read_text().replace("scale_v_per_g = 2.0", f"scale_v_per_g = {scale!r}"))
    return path


LOOKS = [(9.79, "m/s^2: --unit m/s^2"), (1.003, "--unit g or V"), (998.0, "mg or mV")]


@pytest.mark.parametrize(("scale", "looks"), LOOKS)
def test_a_declared_scale_does_not_make_volts_of_what_nobody_names(scale, looks, tumble, tmp_path):
    """The stand file was made for such a block: it confirms the number, not the unit."""
    run = rewritten(tmp_path / "run.csv", "ux,uy,uz", scale / 2.0)
    stand = scaled_stand(tmp_path / "stand.toml", scale)
    said = tumble("solve", run, "--stand", stand).stderr
    assert re.search(rf"1 g gives [0-9.]+, and nobody names its unit: it looks like .*{re.escape(looks)}", said)
    assert "nobody names" not in tumble("solve", run, "--stand", stand, "--unit", "V").stderr
    assert "nobody names" not in tumble("solve", EXAMPLES / "paper_stand.csv", "--stand", STAND).stderr


@pytest.mark.parametrize(("told", "scale", "truly"), [
    ("g", 9.81, "m/s^2"), ("m/s^2", 1.0, "g"), ("g", 1e3, "mg"),
    ("g", 12.0, "m/s^2"), ("m/s^2", 0.8, "g"), ("mg", 1.3, "g"),  # as sensors are off
])  # fmt: skip
def test_a_unit_of_acceleration_that_the_numbers_contradict(told, scale, truly, tumble, tmp_path):
    run = rewritten(tmp_path / "run.csv", "ux,uy,uz", scale / 2.0)
    assert f"{told}: outputs look to be in {truly} (--unit {truly})\n" in tumble("solve", run, "--unit", told).stderr
    assert "look to be" not in tumble("solve", run, "--unit", truly).stderr
    assert "look to be" not in tumble("solve", run, "--unit", "V").stderr
