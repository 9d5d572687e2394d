"""Exported coefficients: read back from C and from CSV, they are those of the result, bit for bit."""

import copy
import csv
import io
import json
import os
import shutil
import subprocess

import pytest
from conftest import EXAMPLES
from documents import paper_stand

pytestmark = pytest.mark.python

ORIGIN = ("serial", "run_file", "item", "environment", "fit", "stand_doubts")
NAMES = [f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"]

PROGRAM = """\
#include "coefficients.h"
#include <stdio.h>
static const tumble_exported_t coefficients = TUMBLE_COEFFICIENTS_INITIALIZER;
int main(void)
{
    for (int i = 0; i < 9; i++) printf("%.17g\\n", coefficients.k[i / 3][i % 3]);
    for (int i = 0; i < 3; i++) printf("%.17g\\n", coefficients.u0[i]);
#if TUMBLE_UNCERTAINTY_KNOWN
    const double u[] = {UNCERTAINTIES};
    for (int i = 0; i < 12; i++) printf("%.17g\\n", u[i]);
#endif
    printf("%d\\n", TUMBLE_GRAVITY_CHECK_PASSED);
    return 0;
}
""".replace("UNCERTAINTIES", ", ".join(f"TUMBLE_U_{name.upper()}" for name in NAMES))


def flat(k, u0):
    return [value for row in k for value in row] + u0


@pytest.fixture(scope="module")
def results():
    """Results of examples that were solved already, by the words of the command."""
    return {}


@pytest.fixture
def solved(results, tumble, tmp_path):
    """Solve an example; returns the result's file and document."""

    def run(*arguments):
        file = tmp_path / "result.json"
        if arguments not in results:
            tumble("solve", *arguments, "--out", file, cwd=EXAMPLES)
            results[arguments] = file.read_bytes()
        file.write_bytes(results[arguments])
        return file, json.loads(file.read_text())

    return run


def compiled(tmp_path, header):
    """Numbers that a C program prints which knows nothing but the header."""
    (tmp_path / "coefficients.h").write_text(header)
    (tmp_path / "main.c").write_text(PROGRAM)
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    flags = ["-std=c11", "-trigraphs", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True, env=environment)
    subprocess.run(["cc", *flags, "-fsyntax-only", "coefficients.h"], cwd=tmp_path, check=True, env=environment)
    printed = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout
    return [float(line) for line in printed.splitlines()]


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("stand", [[], ["--stand", "paper_stand.toml"]])
@pytest.mark.parametrize(("limit", "passed"), [("3e-4", 1), ("1e-6", 0)])
def test_c_header_round_trip(stand, limit, passed, solved, tumble, tmp_path):
    file, result = solved("paper_stand.csv", "--limit", limit, *stand)
    header = tumble("export", file, "--format", "c").stdout
    uncertainties = flat(result["u_K"], result["u_U0"]) if stand else []
    assert compiled(tmp_path, header) == flat(result["K"], result["U0"]) + uncertainties + [passed]
    numbers = [line for line in header.splitlines() if line.startswith("#define TUMBLE_") and "(" in line]
    assert len(numbers) == (24 if stand else 12)
    assert all("/* V/g" in line or "/* V" in line for line in numbers)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_header_says_where_it_comes_from(solved, tumble, tmp_path):
    """Serial, run file, labels and environment; nothing in them ends the comment."""
    label = '[item]\nnote = "*/ int x; /* ??/ \\\\ \\n \u00b5"\n[environment]\ntemperature_c = 21.5\n'
    stand = paper_stand(tmp_path, label, block='serial = "SN 7"\n')
    file, result = solved("paper_stand.csv", "--stand", stand)
    assert (result["serial"], result["run_file"]) == ("SN 7", "paper_stand.csv")
    done = tumble("export", file, "--format", "c", "--labels")
    assert done.stderr == "" and '#define TUMBLE_OUTPUT_UNIT "V"' in done.stdout
    for line in (" * Block: SN 7", " * Run file: paper_stand.csv", " * environment.temperature_c: 21.5"):
        assert line in done.stdout.splitlines()
    assert len(compiled(tmp_path, done.stdout)) == 25


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize("end", ["??/", "???/", "?" * 8 + "/", "\\\\", "*??/", "/*"])
def test_what_a_label_ends_with_leaves_its_line_alone(end, solved, tumble, tmp_path):
    """A trigraph at the end of a line would join it with the next one, which a compiler says even of a comment."""
    stand = paper_stand(tmp_path, f'[item]\nnote = "ends in {end}"\n')
    file, _ = solved("paper_stand.csv", "--stand", stand)
    header = tumble("export", file, "--format", "c", "--labels").stdout
    [line] = [line for line in header.splitlines() if "item.note: ends in " in line]
    assert len(compiled(tmp_path, header)) == 25
    assert "??" not in line


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_warnings_of_a_result_leave_the_comment_alone(solved, tumble, tmp_path):
    file, result = solved("paper_stand.csv")
    file.write_text(json.dumps({**result, "warnings": ["*/ int x;\nint y; /* ??/"]}))
    header = tumble("export", file, "--format", "c").stdout
    assert " * WARNING: * / int x;\\nint y; / * ? ?/\n" in header
    assert len(compiled(tmp_path, header)) == 13


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_compiler_finds_a_trigraph(solved, tumble, tmp_path):
    """The canary of the test above."""
    file, _ = solved("paper_stand.csv")
    header = tumble("export", file, "--format", "c", "--labels").stdout
    header = header.replace(" * Run file: paper_stand.csv", " * Run file: ??/")
    with pytest.raises(subprocess.CalledProcessError):
        compiled(tmp_path, header)


@pytest.mark.parametrize("form", ["c", "csv", "matlab", "ros", "imucal"])
def test_nothing_of_the_customer_leaves_unasked(form, solved, tumble, tmp_path):
    """Neither name nor number of a certificate, nor serials, nor what the run file is called; numbers of the conditions
    and the hash of the run do."""
    secrets = ("ACME", "C-2026-17", "SN 7", "N. N.", "paper_stand")
    label = '[item]\ncustomer = "ACME"\ncertificate = "C-2026-17"\n[environment]\noperator = "N. N."\n'
    stand = paper_stand(tmp_path, f"{label}gravity_m_s2 = 9.81\nu_gravity_m_s2 = 1e-5\n", block='serial = "SN 7"\n')
    file, result = solved("paper_stand.csv", "--stand", stand)
    text = tumble("export", file, "--format", form).stdout
    assert [one for one in secrets if one in text] == []
    if form != "csv":
        assert result["run_sha256"] in text and "environment.gravity_m_s2: 9.81" in text
        asked = tumble("export", file, "--format", form, "--labels").stdout
        assert [one for one in secrets if one not in asked] == []


def test_a_result_to_beware_of_is_exported_with_a_warning(solved, tumble):
    """On stderr and in the header; the exit code is that of an export that was done."""
    for options, warning, count in (
        (("paper_stand.csv", "--limit", "1e-6"), "the gravity check FAILED: largest error 6.6e-05 g, limit 1e-06 g", 1),
        (("lab_stand.csv", "--stand", "paper_stand.toml"), "the run does not fit the stand file: ", 2),
    ):
        file, _ = solved(*options)
        done = tumble("export", file, "--format", "c")
        assert done.returncode == 0 and f"result.json: {warning}" in done.stderr and done.stderr.count("\n") == count
        assert f" * WARNING: {warning}" in done.stdout
        assert warning in tumble("export", file, "--format", "csv").stderr


def test_an_older_result_without_its_origin_is_exported_all_the_same(solved, tumble):
    file, result = solved("paper_stand.csv")
    file.write_text(json.dumps({key: value for key, value in result.items() if key not in ORIGIN}))
    done = tumble("export", file, "--format", "c")
    assert (done.returncode, done.stderr) == (0, "") and "Run file" not in done.stdout


@pytest.mark.parametrize("stand", [[], ["--stand", "paper_stand.toml"]])
def test_csv_round_trip(stand, solved, tumble):
    file, result = solved("paper_stand.csv", *stand)
    rows = list(csv.DictReader(io.StringIO(tumble("export", file, "--format", "csv").stdout)))
    assert [row["coefficient"] for row in rows] == NAMES
    assert [float(row["value"]) for row in rows] == flat(result["K"], result["U0"])
    assert [row["unit"] for row in rows] == ["V/g"] * 9 + ["V"] * 3
    if stand:
        assert [float(row["standard_uncertainty"]) for row in rows] == flat(result["u_K"], result["u_U0"])
    else:
        assert {row["standard_uncertainty"] for row in rows} == {""}
    assert [row["uncertainty_unit"] for row in rows] == [row["unit"] for row in rows]


def test_whole_numbers_stay_doubles(solved, tumble, tmp_path):
    file, result = solved("paper_stand.csv", "--unit", "V")
    result["K"], result["U0"] = [[2, 0, 0], [0, -2, 0], [0, 0, 1e300 / 1e200]], [0, 1, -0.0]
    file.write_text(json.dumps(result))
    header = tumble("export", file, "--format", "c").stdout
    assert "#define TUMBLE_K_XX (2.0) /* V/g, assuming one temperature */" in header
    assert compiled(tmp_path, header)[:12] == flat(result["K"], result["U0"])


def test_out_writes_what_is_printed(solved, tumble, tmp_path):
    file, _ = solved("paper_stand.csv")
    printed = tumble("export", file, "--format", "c").stdout
    done = tumble("export", file, "--format", "c", "--out", tmp_path / "coefficients.h")
    assert (done.returncode, done.stdout) == (0, "")
    assert (tmp_path / "coefficients.h").read_text() == printed


def changed(result, path, value):
    """A result with one value replaced, or removed if `value` is ...."""
    result = copy.deepcopy(result)
    *way, last = path
    table = result
    for key in way:
        table = table[key]
    if value is ...:
        del table[last]
    else:
        table[last] = value
    return json.dumps(result)


BAD_VALUES = {
    "other schema": (["schema"], "tumble.plan/1"),
    "no K": (["K"], ...),
    "K of two rows": (["K"], [[1, 2, 3], [4, 5, 6]]),
    "K of text": (["K", 1, 1], "2.0"),
    "K with null": (["K", 1, 1], None),
    "K true": (["K", 1, 1], True),
    "K beyond a double": (["K", 1, 1], 10**400),
    "no U0": (["U0"], ...),
    "U0 a number": (["U0"], 1.0),
    "u_K missing": (["u_K"], ...),
    "u_K alone known": (["u_U0"], None),
    "u_K negative": (["u_K", 0, 0], -1e-5),
    "no unit": (["unit"], ...),
    "unit that ends the comment": (["unit"], "V */ #error"),
    "estimator that ends the comment": (["estimator"], "refined */"),
    "no verification": (["verification"], ...),
    "verdict of text": (["verification", "pass"], "yes"),
    "no limit": (["verification", "limit_g"], None),
    "unknown reason": (["pass_reason"], "wind"),
    "reason twice": (["pass_reason"], "fit and fit"),
    "reason without a word": (["pass_reason"], ""),
    "unknown remedy": (["would_show"], [{"change": "wind", "to": "optimal", "reach_g": 1e-4}]),
    "remedy of half a sample": (["would_show"], [{"change": "samples", "to": 0.5, "reach_g": 1e-4}]),
    "remedy to nothing": (["would_show"], [{"change": "stand", "reach_g": 1e-4}]),
}


@pytest.mark.parametrize("format", ["c", "csv"])
@pytest.mark.parametrize("case", BAD_VALUES)
def test_malformed_results(case, format, solved, refused, tmp_path):
    file, result = solved("paper_stand.csv", "--stand", "paper_stand.toml")
    file.write_text(changed(result, *BAD_VALUES[case]))
    line = refused("export", file, "--format", format, "--out", tmp_path / "exported")
    assert "result.json: " in line


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "row 1, column 1: not valid JSON"),
        (b"{", "row 1, column 2: not valid JSON"),
        (b'{"schema":\n nope}', "row 2, column 2: not valid JSON"),
        (b"[1, 2]", "an object is expected"),
        (b'{"K": NaN}', "not valid JSON: 'NaN is not a number'"),
        (b'{"K": 1e999}', "no schema"),
        (b"\xff\xfe\x00", "not valid JSON"),
        (b"[" * 100_000, "not valid JSON"),
    ],
)
def test_files_that_are_no_result(content, message, refused, tmp_path):
    file = tmp_path / "result.json"
    file.write_bytes(content)
    assert message in refused("export", file, "--format", "c")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["result.json"], "required: --format"),
        (["result.json", "--format", "xml"], "invalid choice: 'xml'"),
        (["none.json", "--format", "c"], "none.json: no such file or folder"),
        ([".", "--format", "c"], "a folder, not a file"),
    ],
)
def test_bad_command_lines(arguments, message, refused, tmp_path):
    assert message in refused("export", *arguments, cwd=tmp_path)
