"""Every bad run file and option: exit 2, nothing on stdout, one line that names file and row, nothing left behind."""

import os
import signal
import subprocess
import sys

import pytest
from blocks import NOMINAL_K, write_run
from conftest import EXAMPLES

from tumble.model import Geometry, built_in

pytestmark = pytest.mark.python

HEADER = "mounting,position,ux,uy,uz\n"
ROWS = [
    f"{m},{p},{ux:.6f},{uy:.6f},{uz:.6f}\n"
    for (m, p), (ux, uy, uz) in zip(
        [(m, p) for m in (1, 2) for p in range(1, 10)],
        Geometry(built_in("paper")).outputs(NOMINAL_K, [0.1, 0.2, 0.3]),
    )
]
GOOD = HEADER + "".join(ROWS)


def with_row(number, row):
    """The good run with one line (from 1, the header) replaced."""
    lines = [HEADER, *ROWS]
    lines[number - 1] = row
    return "".join(lines)


BAD_TEXTS = {
    "empty": ("", "row 1", "empty"),
    "blank": ("\n \n\n", "row 1", "empty"),
    "header only": (HEADER, "row 1", "no samples"),
    "headless": ("".join(ROWS), "row 1", "no header line"),
    "binary": (b"\x7fELF\x02\x01\0\0" + bytes(range(256)), "row 1", "not a text file"),
    "binary without zeros": (bytes(range(128, 256)) * 9 + b"\x01\x02", "row 1", "not a text file"),
    "zero byte later": (GOOD.replace("1,4,", "1,\0,").encode(), "row 5", "not a text file"),
    "UTF-16": (GOOD.encode("utf-16"), "row 1", "UTF-16"),
    "column missing": (GOOD.replace("uz", "temperature"), "row 1", "no column uz"),
    "column twice": (GOOD.replace("uz", "uy"), "row 1", "2 columns are named 'uy'"),
    "two candidates": (GOOD.replace("mounting", "mount").replace("position", "setup"), "row 1", "both be mounting"),
    "NaN": (with_row(5, "1,4,nan,0,0\n"), "row 5, column ux", "not a finite number"),
    "infinity": (with_row(6, "1,5,0,-inf,0\n"), "row 6, column uy", "not a finite number"),
    "overflow": (with_row(6, "1,5,0,0,1e999\n"), "row 6, column uz", "out of range"),
    "too large": (with_row(6, "1,5,0,0,1e101\n"), "row 6, column uz", "out of range"),
    "text": (with_row(7, "1,6,0,volts,0\n"), "row 7, column uy", "'volts' is not a number"),
    "underscore": (with_row(7, "1,6,0,1_0,0\n"), "row 7, column uy", "'1_0' is not a number"),
    "hexadecimal": (with_row(7, "1,6,0,0x10,0\n"), "row 7, column uy", "'0x10' is not a number"),
    "digits of another script": (with_row(7, "1,6,0,\u0663,0\n"), "row 7, column uy", "is not a number"),
    "no value": (with_row(8, "1,7,0,,0\n"), "row 8, column uy", "no value"),
    "short row": (with_row(9, "1,8,0,0\n"), "row 9", "4 fields, but the header has 5"),
    "long row": (with_row(9, "1,8,0,0,0,0\n"), "row 9", "6 fields, but the header has 5"),
    "short and long rows": (
        with_row(9, "1,8,0,0\n").replace(ROWS[8], "1,9,0,0,0,0\n"),
        "row 9",
        "4 fields, but the header has 5",
    ),
    "decimal commas among commas": (with_row(9, "1,8,0,1,0,2,0,3\n"), "row 9",
        "8 fields, but the header has 5; if some of its commas are decimal marks, "),
    "last row cut off": (GOOD[:-12], "row 19", "fields"),
    "unknown mounting": (with_row(10, "3,9,0,0,0\n"), "row 10, column mounting", "no mounting 3; mountings are 1, 2"),
    "exchanged": (with_row(10, "3,2,0,0,0\n"), "row 10, column mounting", "are mounting and position exchanged?"),
    "unknown position": (
        with_row(10, "1,10,0,0,0\n"),
        "row 10, column position",
        "no position 10 in mounting 1; positions are 1 to 9",
    ),
    "negative position": (with_row(10, "1,-9,0,0,0\n"), "row 10, column position", "no position -9"),
    "huge position": (with_row(10, "1,1e30,0,0,0\n"), "row 10, column position", "no position 1e+30"),
    "half a position": (with_row(10, "1,1.5,0,0,0\n"), "row 10, column position", "not a whole number"),
    "position 256 more": (with_row(10, "1,265,0,0,0\n"), "row 10, column position", "no position 265"),
    "quote left open": (with_row(11, '2,1,"0,0,0\n'), "row 11", "cannot be split"),
    "row after blank lines": (with_row(5, "\n\n1,4,x,0,0\n"), "row 7, column ux", "'x' is not a number"),
    "decimal comma among points": (
        with_row(5, "1,4,X,0,0\n").replace(",", ";").replace("X", "0,5"),
        "row 5, column ux",
        "'0,5' is not a number (write all numbers with the same decimal mark, and without thousands separators)",
    ),
    "another column is named so": (GOOD.replace("mounting", "M").replace("ux", "AccX_raw"), "row 1",
        "no columns mounting and ux among 'M,position,AccX_raw,uy,uz'; name what is missing with "
        "--columns mounting=NAME,ux=NAME, or add it"),
    "one column": (GOOD.replace(",", "|"), "row 1", "say what separates the columns with --delimiter"),
    "a mounting by letter": (with_row(5, "A,4,0,0,0\n"), "row 5, column mounting",
        "'A' is not a number; mountings are 1, 2"),
    "units below the header": (with_row(1, HEADER + "-,-,V,V,V\n"), "row 2, column mounting",
        "'-' is not a number (a row of units? Delete it, or begin it with #; --unit says the unit)"),
    "missing positions": (HEADER + "".join(ROWS[:3] + ROWS[5:]), "", "missing 1.4, 1.5"),
    "one mounting": (HEADER + "".join(ROWS[:9]), "", "missing 2.1, 2.2"),
}


@pytest.mark.parametrize("case", BAD_TEXTS)
def test_bad_run_files(case, refused, tmp_path):
    content, row, message = BAD_TEXTS[case]
    run = tmp_path / "run.csv"
    run.write_bytes(content if isinstance(content, bytes) else content.encode())
    line = refused("solve", run, "--json", "--out", tmp_path / "result.json")
    assert f"run.csv: {row}" in line and message in line


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        ([0], "no response to gravity in channel ux: "),
        ([1], "no response to gravity in channel uy: "),
        ([0, 2], "no response to gravity in channel ux and uz: "),
        ([0, 1, 2], "no response to gravity in channel ux and uy and uz: "),
    ],
)
@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_dead_channels(channels, message, estimator, refused, tmp_path):
    means = Geometry(built_in("paper")).outputs(NOMINAL_K, [0.1, 0.2, 0.3])
    means[:, channels] = 0.125
    run = write_run(tmp_path / "run.csv", built_in("paper"), means)
    assert message in refused("solve", run, "--estimator", estimator, "--out", tmp_path / "result.json")


def test_parallel_channels(refused, tmp_path):
    means = Geometry(built_in("paper")).outputs(NOMINAL_K, [0.1, 0.2, 0.3])
    means[:, 2] = 2 * means[:, 1]
    run = write_run(tmp_path / "run.csv", built_in("paper"), means)
    assert "two channels are parallel" in refused("solve", run, "--estimator", "least_squares")


def test_a_table_that_turned_the_other_way_in_one_mounting(refused, tmp_path):
    """The responses to x cancel: the first column of K is 0."""
    means = Geometry(built_in("paper")).outputs(NOMINAL_K, [0.1, 0.2, 0.3])
    means[9:] = means[17:8:-1]
    run = write_run(tmp_path / "run.csv", built_in("paper"), means)
    assert "the table turned the other way in one mounting" in refused("solve", run, "--estimator", "averaged")


def test_least_squares_on_one_mounting_names_the_coefficients(refused, tmp_path):
    run = tmp_path / "run.csv"
    run.write_text(HEADER + "".join(ROWS[:9]))
    line = refused("solve", run, "--estimator", "least_squares")
    assert "cannot identify K_xy, K_yy, K_zy" in line


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["no such.csv"], "no such.csv: no such file or folder"),
        (["."], "a folder, not a file"),
        (["run.csv/"], "run.csv/: not a directory"),
        (["new\nline.csv"], r"'new\nline.csv': no such file or folder"),
        ([], "required: RUN.csv"),
        (["run.csv", "--estimator", "best"], "invalid choice: 'best'"),
        (["run.csv", "--estimator"], "expected one argument"),
        (["run.csv", "--verbose"], "unrecognized arguments: --verbose (see tumble solve --help)"),
        (["run.csv", "--est", "refined"], "unrecognized arguments: --est"),
        (["run.csv", "other.csv"], "2 runs: solve takes one, or several at their temperatures (--temperature)"),
        (["run.csv", "--limit", "tight"], "--limit: 'tight' is not"),
        (["run.csv", "--limit", "0"], "--limit: '0' is not"),
        (["run.csv", "--limit=-3e-4"], "--limit: '-3e-4' is not"),
        (["run.csv", "--limit", "nan"], "--limit: 'nan' is not"),
        (["run.csv", "--limit", "inf"], "--limit: 'inf' is not"),
        (["run.csv", "--limit", "1.1"], "--limit: '1.1' is not"),
        (["run.csv", "--stand", "none.toml"], "none.toml: no such file"),
        (["run.csv", "--schedule", "none.toml"], "none.toml: no such file"),
        (["run.csv", "--stand", "."], "a folder, not a file"),
        (["run.csv", "--unit", "V*/ int main"], "--unit: 'V*/ int main' is not a unit"),
        (["run.csv", "--unit", ""], "--unit: '' is not a unit"),
        (["run.csv", "--delimiter", "ab"], "--delimiter: 'ab' is not"),
        (["run.csv", "--delimiter", "5"], "--delimiter: '5' is not"),
        (["run.csv", "--decimal", ";"], "invalid choice: ';'"),
        (["run.csv", "--columns", "ux"], "--columns: 'ux' is not NAME=COLUMN"),
        (["run.csv", "--columns", "ux=a,ux=b"], "--columns: 'ux=b' is not NAME=COLUMN"),
        (["run.csv", "--columns", "volts=ux"], "--columns: 'volts=ux' is not NAME=COLUMN"),
        (
            ["run.csv", "--columns", "ux=AccX,uy=AccY"],
            "run.csv: row 1: no columns 'AccX' and 'AccY' (for ux and uy) among 'mounting,position,ux,uy,uz'\n",
        ),
        (["run.csv", "--delimiter", ";"], "run.csv: row 1: no columns mounting, position, ux, uy and uz among"),
        (["run.csv", "--out", "none/result.json"], "none/result.json: cannot be written: no such file or folder"),
        (["run.csv", "--out", "."], "cannot be written: a folder, not a file"),
        (["run.csv", "--out", "/dev/full"], "/dev/full: cannot be written: no space left on device"),
        (["run.csv", "--out", ""], "cannot be written"),
        (["run.csv", "--out", "run.csv"], "--out: 'run.csv' is an input"),
        (["run.csv", "--stand", "stand.toml", "--out", "./stand.toml"], "--out: './stand.toml' is an input"),
    ],
)
def test_bad_command_lines(arguments, message, refused, tmp_path):
    (tmp_path / "run.csv").write_text(GOOD)
    (tmp_path / "stand.toml").write_bytes((EXAMPLES / "paper_stand.toml").read_bytes())
    assert message in refused("solve", *arguments, cwd=tmp_path)
    assert (tmp_path / "run.csv").read_text() == GOOD


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(["resolve"], "invalid choice: 'resolve'"), (["--quiet"], "unrecognized arguments: --quiet")],
)
def test_bad_commands(arguments, message, refused):
    assert message in refused(*arguments)


def test_standard_output_that_is_full(tumble, tmp_path):
    (tmp_path / "run.csv").write_text(GOOD)
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "tumble", "solve", "run.csv", "--unit", "V"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
        )
    assert done.returncode == 2
    assert done.stderr == "tumble: standard output cannot be written: no space left on device\n"


def test_a_reader_that_goes_away_is_not_complained_of(tmp_path):
    (tmp_path / "run.csv").write_text(GOOD)
    read_end, write_end = os.pipe()
    os.close(read_end)
    done = subprocess.run(
        [sys.executable, "-m", "tumble", "solve", "run.csv", "--unit", "V"],
        stdout=write_end,
        stderr=subprocess.PIPE,
        cwd=tmp_path,
    )
    os.close(write_end)
    assert (done.returncode, done.stderr) == (2, b"")


def test_interruption(tmp_path):
    """Ctrl-C while the command waits for its input: exit 130, one line, nothing left behind."""
    pipe = tmp_path / "run.csv"
    os.mkfifo(pipe)
    child = subprocess.Popen(
        [sys.executable, "-m", "tumble", "solve", pipe, "--out", tmp_path / "result.json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with open(pipe, "w"):  # returns once the command has opened the other end
        child.send_signal(signal.SIGINT)
    stdout, stderr = child.communicate(timeout=60)  # a signal just before the read is seen when the read ends
    assert (child.returncode, stdout, stderr) == (130, "", "tumble: interrupted\n")
    assert list(tmp_path.iterdir()) == [pipe]
