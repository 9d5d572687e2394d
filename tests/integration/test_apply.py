"""`tumble apply` and `Result.apply`: outputs in, acceleration out, held against exact arithmetic and brute force."""

import json
import re
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import NO_GRAVITY
from hypothesis import given, settings, strategies as st

import tumble
from tumble.api.result import Result
from tumble.cli.main import main
from tumble.files import calibrated
from tumble.model.coefficients import norm_uncertainty

pytestmark = pytest.mark.python

SCALE = 2.0
AXES = "xyz"


@pytest.fixture(scope="module")
def paper():
    return tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml")


@pytest.fixture(scope="module")
def extended():
    """With K2 and K3 that can be felt."""
    found = tumble.solve(
        EXAMPLES / "paper_stand.csv",
        stand=EXAMPLES / "paper_stand.toml",
        estimator="least_squares",
        model="k2,k3,drift",
    )
    document = found.document
    document["extended"]["k2_per_g"] = [4e-3, -3e-3, 2e-3]
    document["extended"]["k3_per_g2"] = [-1e-3, 2e-3, 1.5e-3]
    return Result(json.dumps(document))


@pytest.fixture
def saved(paper, tmp_path):
    paper.save(tmp_path / "result.json")
    return tmp_path / "result.json"


def with_coefficients(result, k, u0, **more):
    document = {**result.document, "K": np.asarray(k).tolist(), "U0": np.asarray(u0).tolist(), **more}
    return Result(json.dumps(document))


def solved_exactly(k, left):
    """Cramer's rule in fractions."""

    def determinant(m):
        return sum(m[0][i] * (m[1][(i + 1) % 3] * m[2][(i + 2) % 3] - m[1][(i + 2) % 3] * m[2][(i + 1) % 3])
                   for i in range(3))  # fmt: skip

    whole = determinant(k)
    return [determinant([[left[i] if j == column else k[i][j] for j in range(3)] for i in range(3)]) / whole
            for column in range(3)]  # fmt: skip


def exact_force(k, u0, outputs):
    exact = [[Fraction(one) for one in row] for row in np.asarray(k).tolist()]
    left = [Fraction(one) - Fraction(bias) for one, bias in zip(outputs, np.asarray(u0).tolist())]
    return solved_exactly(exact, left)


small = st.floats(-0.1, 0.1)
number = st.floats(-20.0, 20.0)


@given(st.lists(small, min_size=9, max_size=9), st.lists(number, min_size=3, max_size=3), st.lists(number, min_size=3,
       max_size=3), st.sampled_from([-SCALE, SCALE, 1e-4, 3e5]))  # fmt: skip
@settings(max_examples=60)
def test_the_force_is_the_exact_one(paper, off, u0, outputs, scale):
    k = scale * (np.eye(3) + np.reshape(off, (3, 3)))
    found = with_coefficients(paper, k, u0).apply(outputs)
    exact = exact_force(k, u0, outputs)
    size = max(map(abs, [*outputs, *u0])) / abs(scale)
    for one, expected in zip(found.tolist(), exact):
        assert abs(Fraction(one) - expected) <= Fraction(1, 10**14) * Fraction(max(size, 1e-300))


def outputs_exactly(result, force):
    """Of the model, with K2 and K3, in fractions, rounded once."""
    k, u0, more = result.document["K"], result.document["U0"], result.document["extended"]
    a = [Fraction(one) for one in force]
    found = []
    for i in range(3):
        beyond = Fraction(more["k2_per_g"][i]) * a[i] ** 2 + Fraction(more["k3_per_g2"][i]) * a[i] ** 3
        linear = sum(Fraction(one) * part for one, part in zip(k[i], a))
        found.append(float(Fraction(u0[i]) + linear + Fraction(k[i][i]) * beyond))
    return found


@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3))
@settings(max_examples=60)
def test_k2_and_k3_are_taken_out(extended, force):
    assert extended.apply(outputs_exactly(extended, force)) == pytest.approx(force, rel=0, abs=5e-15 * 3)


def test_k2_and_k3_in_si(extended):
    document = {**extended.document, "environment": {"gravity_m_s2": 9.80665}}
    found = Result(json.dumps(document)).apply(outputs_exactly(extended, [0.5, -1.5, 2.0]), unit="m/s2")
    assert found == pytest.approx(np.array([0.5, -1.5, 2.0]) * 9.80665, rel=1e-14)


def test_outputs_that_no_force_gives_are_refused(extended, tmp_path, refused):
    """K2 of -0.2/g and nothing else: U has its maximum at 2.5 g."""
    document = extended.document
    document["extended"] |= {"k2_per_g": [-0.2] * 3, "k3_per_g2": [0.0] * 3}
    document |= {"K": np.eye(3).tolist(), "U0": [0.0] * 3}
    result = Result(json.dumps(document))
    assert result.apply([0.8, 0.0, 0.0])[0] == pytest.approx(1.0, abs=1e-12)
    assert result.apply([1.2, 0.0, 0.0])[0] == pytest.approx(2.0, abs=1e-12)
    with pytest.raises(
        tumble.BadInput, match=r"^data: row 2: K2 or K3 is so large that the outputs do not tell the acc"
    ):
        result.apply([[0.0, 0.0, 0.0], [1.3, 0.0, 0.0]])
    result.save(tmp_path / "r.json")
    (tmp_path / "data.csv").write_text("# a comment\nux,uy,uz\n0,0,0\n\n1.3,0,0\n")
    said = "data.csv: row 5: K2 or K3 is so large that the outputs do not tell the acceleration\n"
    before = (tmp_path / "data.csv").read_bytes()
    done = refused_last_line(tmp_path, "apply", tmp_path / "r.json", tmp_path / "data.csv")
    assert done.endswith(said) and (tmp_path / "data.csv").read_bytes() == before


def refused_last_line(folder, *arguments):
    """The last of several lines on stderr; exit 2, nothing on stdout, no file left behind."""
    import contextlib
    import io

    before = sorted(folder.rglob("*"))
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([*map(str, arguments)])
    assert (code, out.getvalue()) == (2, "") and sorted(folder.rglob("*")) == before
    return err.getvalue()


def by_brute_force(result, outputs, covariance, build, values):
    """Standard uncertainties of x, y, z and of the length: every coefficient moved both ways."""
    columns = []
    for i, value in enumerate(values):
        step = 1e-5 * max(abs(value), 1e-3)
        up, down = (build(np.where(np.arange(len(values)) == i, values + sign * step, values)) for sign in (1, -1))
        columns.append((up(outputs) - down(outputs)) / (2 * step))
    by_coefficient = np.array(columns).T
    force = build(values)(outputs)
    rows = np.vstack([by_coefficient, (force / np.linalg.norm(force)) @ by_coefficient])
    return np.sqrt(np.diag(rows @ covariance @ rows.T))


@pytest.mark.parametrize("force", [[0.0, 0.0, 1.0], [0.6, -0.48, 0.64], [3.0, 2.0, -5.0]])
def test_uncertainties_are_those_of_moved_coefficients(paper, force):
    def build(values):
        return with_coefficients(paper, values[:9].reshape(3, 3), values[9:]).apply

    outputs = paper.U0 + paper.K @ np.array(force)
    values = np.concatenate([paper.K.ravel(), paper.U0])
    found = paper.apply(outputs, uncertainty=True)
    assert found[:3] == pytest.approx(force, abs=1e-14) and found.shape == (7,)
    assert found[3:] == pytest.approx(by_brute_force(paper, outputs, paper.covariance, build, values), rel=1e-6)
    if np.isclose(np.linalg.norm(force), 1.0):
        assert found[6] == pytest.approx(norm_uncertainty(paper.K, paper.covariance, np.array(force)), rel=1e-12)


def test_uncertainties_of_further_terms(extended):
    more, force = extended.document["extended"], [0.9, -1.2, 0.7]

    def build(values):
        changed = {**more, "k2_per_g": values[12:15].tolist(), "k3_per_g2": values[15:18].tolist()}
        return with_coefficients(extended, values[:9].reshape(3, 3), values[9:12], extended=changed).apply

    outputs = np.array(outputs_exactly(extended, force))
    values = np.concatenate([extended.K.ravel(), extended.U0, more["k2_per_g"], more["k3_per_g2"]])
    covariance = np.array(more["covariance"])[:18, :18]
    found = extended.apply(outputs, uncertainty=True)
    assert found[3:] == pytest.approx(by_brute_force(extended, outputs, covariance, build, values), rel=1e-6)


def test_uncertainties_in_si_have_that_of_gravity(paper):
    gravity, u_gravity = 9.81, 3e-4
    environment = {"gravity_m_s2": gravity, "u_gravity_m_s2": u_gravity}
    local = with_coefficients(paper, paper.K, paper.U0, environment=environment)
    outputs = paper.U0 + paper.K @ np.array([0.6, 0.0, 0.8])
    in_g, found = paper.apply(outputs, uncertainty=True), local.apply(outputs, unit="m/s2", uncertainty=True)
    assert found[:3] == pytest.approx(in_g[:3] * gravity, rel=1e-14)
    size = np.append(np.abs(in_g[:3]), 1.0)
    assert found[3:] == pytest.approx(np.hypot(in_g[3:] * gravity, size * u_gravity), rel=1e-9)


def test_what_is_not_known_is_refused(paper):
    alone = with_coefficients(paper, paper.K, paper.U0, u_K=None, u_U0=None, covariance=None)
    known = with_coefficients(paper, paper.K, paper.U0, environment={"gravity_m_s2": 9.8})
    for result, options, said in (
        (alone, {"uncertainty": True}, "result: no uncertainties: no stand was declared"),
        (paper, {"unit": "m/s2"}, f"result: {NO_GRAVITY}"),
        (
            known,
            {"unit": "m/s2", "uncertainty": True},
            "result: no uncertainties: its environment has no u_gravity_m_s2",
        ),
        (paper, {"unit": "ft/s2"}, "unit: 'ft/s2' is not one of g, m/s2"),
    ):
        with pytest.raises(ValueError, match="^" + re.escape(said)) as caught:
            result.apply([0, 0, 1], **options)
        assert str(caught.value) == said


def test_shapes_and_missing_values(paper):
    outputs = np.random.default_rng(1).normal(size=(2, 5, 3))
    found = paper.apply(outputs)
    assert found.shape == (2, 5, 3) and found[1, 4] == pytest.approx(paper.apply(outputs[1, 4]), abs=1e-15)
    assert paper.apply(outputs, uncertainty=True).shape == (2, 5, 7)
    assert paper.apply(np.zeros((0, 3))).shape == (0, 3) and paper.apply(np.zeros((0, 3)), uncertainty=True).size == 0
    with_gap = paper.apply([[0, 0, 2.0], [np.nan, 0, 2.0]], uncertainty=True)
    assert np.isfinite(with_gap[0]).all() and np.isnan(with_gap[1]).all()
    at_rest = paper.apply(paper.U0, uncertainty=True)
    assert at_rest[:6] == pytest.approx([0, 0, 0, *at_rest[3:6]]) and np.isfinite(at_rest[3:6]).all()
    for shape in ((), (4,), (3, 2)):
        with pytest.raises(tumble.UsageError, match="holds no outputs: its last axis must be of 3 channels"):
            paper.apply(np.zeros(shape))


def test_gaps_beside_k2(extended):
    found = extended.apply([[np.nan, 0, 0], outputs_exactly(extended, [0.1, 0.2, 0.3])])
    assert np.isnan(found[0]).all() and found[1] == pytest.approx([0.1, 0.2, 0.3], abs=1e-14)


# Files.


def applied(capsysbinary, *arguments, code=0):
    assert main(["apply", *map(str, arguments)]) == code
    return capsysbinary.readouterr()


def expected_lines(result, text, delimiter=",", comma=False):
    """Each row with nine decimals of the exact force, by fractions."""
    lines = []
    for line in text:
        fields = [one.replace(",", ".") if comma else one for one in line.split(delimiter)]
        exact = exact_force(result.K, result.U0, [float(one) for one in fields[-3:]])
        numbers = [str(Decimal(round(one * 10**9)).scaleb(-9).quantize(Decimal("1e-9"))) for one in exact]
        numbers = [one.replace(".", ",") if comma else one for one in numbers]
        lines.append(delimiter.join([line, *numbers]))
    return lines


def test_csv_with_nine_decimals(paper, saved, tmp_path, capsysbinary):
    rows = ["0,text,0.1,0.2,1.9", "1,more text,-1.25,0.5,1e-3", "2,,0.013,-0.008,0.021"]
    (tmp_path / "data.csv").write_text("\n".join(["time,note,ux,uy,uz", *rows]) + "\n")
    done = applied(capsysbinary, saved, tmp_path / "data.csv")
    lines = done.out.decode().splitlines()
    assert lines == ["time,note,ux,uy,uz,x,y,z", *expected_lines(paper, rows)]
    _, assuming = done.err.decode().splitlines()  # the first: of the unit (test_apply_warns)
    assert assuming.startswith(f"tumble: notice: {saved}: assuming a square seat, volts and one temperature")


def test_semicolons_decimal_commas_and_windows_ends(paper, saved, tmp_path, capsysbinary):
    rows = ["7;0,1;0,2;1,9", "8;-1,25;0,5;0,001"]
    data = "\r\n".join(["\ufeffn;ux;uy;uz", *rows]) + "\r\n"
    (tmp_path / "data.csv").write_bytes(data.encode())
    found = applied(capsysbinary, saved, tmp_path / "data.csv").out.decode()
    expected = ["\ufeffn;ux;uy;uz;x;y;z", *expected_lines(paper, rows, ";", comma=True)]
    assert found == "\r\n".join(expected) + "\r\n"


def test_comments_blanks_quotes_and_foreign_bytes_stay(paper, saved, tmp_path, capsysbinary):
    lines = [b"# a log", b"", b'"a ""b""",ux,uy,uz', b'"1,5",0,0,2', b"# \xb0C", b"\xb5,0,0,2", b"  ", b"z,0,0,2"]
    (tmp_path / "data.csv").write_bytes(b"\n".join(lines))  # and no end of the last line
    found = applied(capsysbinary, saved, tmp_path / "data.csv").out
    xyz = ",".join(expected_lines(paper, ["0,0,2"])[0].split(",")[3:]).encode()
    expected = [*lines[:2], lines[2] + b",x,y,z", lines[3] + b"," + xyz, lines[4], lines[5] + b"," + xyz]
    assert found == b"\n".join([*expected, lines[6], lines[7] + b"," + xyz]) + b"\n"


def test_a_decimal_comma_that_separates_too(saved, tmp_path, capsysbinary):
    (tmp_path / "data.csv").write_text('ux,uy,uz\n"0,1","0,2","1,9"\n')
    line = applied(capsysbinary, saved, tmp_path / "data.csv", "--decimal", ",").out.decode().splitlines()[1]
    assert line.startswith('"0,1","0,2","1,9","0,') and line.count('"') == 12


@pytest.mark.parametrize("piece", [7, 64, 1000])
@pytest.mark.parametrize("comment", ["", "# makes it slow\n"])
def test_pieces_give_the_same_file(piece, comment, paper, saved, tmp_path, capsysbinary, monkeypatch):
    """Fast or line by line, in one piece or in many."""
    outputs = np.random.default_rng(5).normal(size=(97, 3))
    text = (
        "t,ux,uy,uz\n" + comment + "".join(f"{i},{u[0]!r},{u[1]!r},{u[2]!r}\n" for i, u in enumerate(outputs.tolist()))
    )
    (tmp_path / "data.csv").write_text(text + "\n")
    whole = applied(capsysbinary, saved, tmp_path / "data.csv", "--uncertainty").out
    rows = [line.split(b",") for line in whole.splitlines()[1:] if line and not line.startswith(b"#")]
    expected = paper.apply(outputs, uncertainty=True)
    found = np.array(rows, dtype=float)
    assert found[:, -3:] == pytest.approx(expected[:, :3], abs=5.1e-10)
    assert found[:, -7:-3] == pytest.approx(expected[:, 3:], abs=5.1e-10)
    assert whole.splitlines()[0] == b"t,ux,uy,uz,u_x,u_y,u_z,u_norm,x,y,z"
    monkeypatch.setattr(calibrated, "_PIECE", max(piece, len("t,ux,uy,uz\n")))
    assert applied(capsysbinary, saved, tmp_path / "data.csv", "--uncertainty").out == whole
    (tmp_path / "data.csv").write_text(text + "1,2,3\n")
    said = refused_last_line(tmp_path, "apply", saved, tmp_path / "data.csv", "--out", tmp_path / "out.csv")
    row = text.count("\n") + 1
    assert said.endswith(f"data.csv: row {row}: 3 fields, but the header has 4\n")


def test_units_are_converted_or_refused(paper, saved, tmp_path, capsysbinary):
    (tmp_path / "data.csv").write_text("ux [mV],uy [mV],uz [mV]\n100,200,1900\n")
    line = applied(capsysbinary, saved, tmp_path / "data.csv").out.decode().splitlines()[1]
    assert [float(one) for one in line.split(",")[3:]] == pytest.approx(paper.apply([0.1, 0.2, 1.9]), abs=5.1e-10)
    assert paper.apply([100, 200, 1900], outputs_unit="mV") == pytest.approx(paper.apply([0.1, 0.2, 1.9]))
    (tmp_path / "data.csv").write_text("ux [LSB],uy [LSB],uz [LSB]\n100,200,1900\n")
    said = refused_last_line(tmp_path, "apply", saved, tmp_path / "data.csv")
    assert said.endswith("data.csv: outputs in LSB, but the result is for V\n")


def test_columns_by_name_and_columns_called_x(paper, saved, tmp_path, capsysbinary):
    """Data that is itself called x, y, z keeps its values under other names."""
    (tmp_path / "data.csv").write_text("x,y,z,raw_x\n0.1,0.2,1.9,7\n")
    done = applied(capsysbinary, saved, tmp_path / "data.csv")
    header, line = done.out.decode().splitlines()
    assert header == "raw_raw_x,raw_y,raw_z,raw_x,x,y,z" and line.startswith("0.1,0.2,1.9,7,")
    assert "columns of its own renamed: x is raw_raw_x, y is raw_y, z is raw_z\n" in done.err.decode()
    (tmp_path / "data.csv").write_text("a,b,c\n0.1,0.2,1.9\n")
    done = applied(capsysbinary, saved, tmp_path / "data.csv", "--columns", "uz=c,ux=a,uy=b")
    assert done.out.decode().splitlines()[1].split(",")[3:] == line.split(",")[4:]
    table = paper.apply({"x": [0.1], "y": [0.2], "z": [1.9]})
    assert list(table) == ["raw_x", "raw_y", "raw_z", "x", "y", "z"]
    for words, said in (
        (["--columns", "mounting=a"], "NAME one of ux, uy, uz, temperature, once each"),
        ([], "no columns ux, uy and uz"),
    ):
        assert said in refused_last_line(tmp_path, "apply", saved, tmp_path / "data.csv", *words)


def test_files_are_joined_or_kept_apart(paper, saved, tmp_path, capsysbinary):
    for name, value in (("one", 0.1), ("two", 0.2)):
        (tmp_path / f"{name}.csv").write_text(f"ux,uy,uz\n{value},0,0\n")
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    applied(capsysbinary, saved, one, two, "--out", tmp_path / "both.csv")
    joined = (tmp_path / "both.csv").read_text().splitlines()
    assert joined == ["ux,uy,uz,x,y,z", *expected_lines(paper, ["0.1,0,0", "0.2,0,0"])]
    (tmp_path / "out").mkdir()
    assert applied(capsysbinary, saved, one, two, "--out", tmp_path / "out").out == b""
    assert (tmp_path / "out/two.csv").read_text().splitlines() == [joined[0], joined[2]]
    two.write_text("a,ux,uy,uz\n1,0.2,0,0\n")
    said = refused_last_line(tmp_path, "apply", saved, one, two, "--out", tmp_path / "new.csv")
    assert said.endswith(f"two.csv: has other columns than {one}: --out FOLDER keeps them apart\n")


def test_what_cannot_be_done_leaves_all_as_it_was(saved, tmp_path):
    data, out = tmp_path / "data.csv", tmp_path / "out.csv"
    data.write_text("ux,uy,uz\n1,2,3\n1,two,3\n")
    out.write_text("precious")
    for words, said in (
        ([data, "--out", out], "data.csv: row 3, column uy: 'two' is not a number\n"),
        ([data], "data.csv: row 3, column uy: 'two' is not a number\n"),
        ([data, "--out", data], "is an input of this command\n"),
        ([data, "--out", saved], "is an input of this command\n"),
        ([tmp_path / "none.csv"], "none.csv: no such file or folder\n"),
        ([data, "--unit", "m/s2"], f"{NO_GRAVITY}\n"),
        ([tmp_path / "a.parquet"], "Parquet goes to a file: --out FILE\n"),
        (
            [tmp_path / "a.parquet", data, "--out", tmp_path / "b"],
            "CSV and Parquet cannot be joined: --out FOLDER keeps",
        ),
        ([data, data, "--out", tmp_path], "two files of data have the same name, and would be one in "),
    ):
        assert said in refused_last_line(tmp_path, "apply", saved, *words)
    assert out.read_text() == "precious"
    for text, said in (("ux,uy,uz\n", "row 1: no samples after the header"), ("", "row 1: the file is empty")):
        data.write_text(text)
        assert refused_last_line(tmp_path, "apply", saved, data).endswith(f"data.csv: {said}\n")


def test_a_process_of_its_own_writes_to_a_pipe(tumble, saved, tmp_path):
    (tmp_path / "data.csv").write_text("ux,uy,uz\n" + "0.1,0.2,1.9\n" * 3)
    done = tumble("apply", saved, tmp_path / "data.csv")
    assert done.returncode == 0 and done.stdout.count("\n") == 4


def test_a_comment_without_an_end_takes_no_row_of_the_next_file(paper, saved, tmp_path, capsysbinary):
    (tmp_path / "a.csv").write_text("ux,uy,uz\n0.1,0.2,1.9\n# end")
    (tmp_path / "b.csv").write_text("ux,uy,uz\n0.1,0.2,1.8\n")
    lines = applied(capsysbinary, saved, tmp_path / "a.csv", tmp_path / "b.csv").out.decode().splitlines()
    expected = expected_lines(paper, ["0.1,0.2,1.9", "0.1,0.2,1.8"])
    assert lines == ["ux,uy,uz,x,y,z", expected[0], "# end", expected[1]]
