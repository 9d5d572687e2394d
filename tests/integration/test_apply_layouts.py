"""Every layout of a recording, read by `tumble import` and by `tumble apply`: both take the same numbers from it."""

import io
import json

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble
from tumble.api.result import Result
from tumble.cli.main import main
from tumble.files.run_layout import LayoutOptions
from tumble.importing.recording import Timing, read

pytestmark = pytest.mark.python

RNG = np.random.default_rng(8)
OUTPUTS = np.round(RNG.normal(size=(40, 3)), 6)
TIME = np.arange(40) / 50
K, U0 = np.array([[1.1, 0.02, -0.01], [0.03, 0.9, 0.01], [0.0, -0.02, 1.05]]), np.array([0.1, -0.2, 0.05])
FORCE = (OUTPUTS - U0) @ np.linalg.inv(K).T  # g, of outputs in V


def rows(sign=",", decimal="."):
    lines = (sign.join(f"{one:.6f}".replace(".", decimal) for one in (time, *u)) for time, u in zip(TIME, OUTPUTS))
    return "".join(f"{line}\n" for line in lines)


TEXTS = {  # text, options of both
    "plain": ("time,ux,uy,uz\n" + rows(), ()),
    "units in brackets": ("time [s],Ax [V],Ay [V],Az [V]\n" + rows(), ()),
    "units behind names": ("time_s,Ax_V,Ay_V,Az_V\n" + rows(), ()),
    "a header in a comment": ("# a log\n#time,x,y,z\n" + rows(), ()),
    "a header in a comment, blanks": ("# time, x, y, z\n" + rows(), ()),
    "no header": (rows(), ()),
    "no header below comments": ("# a log\n# of today\n" + rows(), ()),
    "no header, columns by number": (rows(), ("--columns", "ux=2,uy=3,uz=4")),
    "rows above the header": ("Logger 7; serial 12\nstarted 2026-05-01\n\ntime,Ax,Ay,Az\n" + rows(), ()),
    "a row of units": ("time,Ax,Ay,Az\ns,V,V,V\n" + rows(), ()),
    "TOA5": ('"TOA5","CR1000"\n"TIME","Ax","Ay","Az"\n"s","V","V","V"\n"","Smp","Smp","Smp"\n' + rows(), ()),
    "semicolons and decimal commas": ("time;Ax;Ay;Az\n" + rows(";", ","), ()),
    "semicolons, no header": (rows(";", ","), ()),
    "tabs": ("time\tAx\tAy\tAz\n" + rows("\t"), ()),
    "blanks": ("time   Ax  Ay Az\n" + rows("   "), ("--delimiter", "space")),
    "another delimiter": ("time|Ax|Ay|Az\n" + rows("|"), ("--delimiter", "|")),
    "names of the user's": ("t,a,b,c\n" + rows(), ("--columns", "ux=a,uy=b,uz=c")),
    "quoted names": ('"a ""b""","ux","uy","uz"\n' + rows(), ()),
}


def told(options):
    """The LayoutOptions of `options`."""
    said = dict(zip(options[::2], options[1::2]))
    columns = dict(part.split("=") for part in said.get("--columns", "").split(",") if part)
    return LayoutOptions(columns, {"space": " "}.get(said.get("--delimiter"), said.get("--delimiter")))


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    found = tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml")
    Result(json.dumps({**found.document, "K": K.tolist(), "U0": U0.tolist()})).save(
        file := tmp_path_factory.mktemp("result") / "result.json"
    )
    return file


def applied(capsysbinary, *arguments, code=0):
    assert main(["apply", *map(str, arguments)]) == code
    said = capsysbinary.readouterr()
    return said.out.decode(), said.err.decode()


def appended(text):
    """The last three columns of each row of numbers."""
    found = []
    for line in text.splitlines():
        sign = next((one for one in ";\t|" if one in line), "," if "," in line else " ")
        fields = line.split(sign)
        try:
            found.append([float(one.replace(",", ".")) for one in fields][-3:])
        except ValueError:
            continue  # a header, or a comment
    return np.array(found)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize(("text", "options"), TEXTS.values(), ids=TEXTS)
def test_import_and_apply_take_the_same_outputs(text, options, end, encoding, saved, tmp_path, capsysbinary):
    file = tmp_path / "data.csv"
    file.write_bytes(text.replace("\n", end).encode(encoding))
    assert read(str(file), told(options), Timing()).outputs.tolist() == OUTPUTS.tolist()
    out, _ = applied(capsysbinary, saved, file, *options)
    assert appended(out) == pytest.approx(FORCE, abs=6e-10)
    own = text.splitlines()
    assert len(out.splitlines()) == len(own) and out.count(end) == len(own)
    if "space" not in options:
        assert all(new.startswith(old) for new, old in zip(out.splitlines()[-40:], own[-40:]))


@pytest.mark.parametrize(
    ("kind", "header"),
    [
        ("a header in a comment", "#time,raw_x,raw_y,raw_z,x,y,z"),
        ("a header in a comment, blanks", "# time,raw_x,raw_y,raw_z,x,y,z"),
        ("rows above the header", "time,Ax,Ay,Az,x,y,z"),
        ("a row of units", "time,Ax,Ay,Az,x,y,z\ns,V,V,V,g,g,g"),
        ("TOA5", '"TIME","Ax","Ay","Az",x,y,z\n"s","V","V","V",g,g,g\n"","Smp","Smp","Smp",,,'),
        ("quoted names", '"a ""b""","ux","uy","uz",x,y,z'),
    ],
)
def test_new_columns_have_their_names_and_units(kind, header, saved, tmp_path, capsysbinary):
    (tmp_path / "data.csv").write_text(TEXTS[kind][0])
    out, _ = applied(capsysbinary, saved, tmp_path / "data.csv")
    above = TEXTS[kind][0].splitlines()[: -len(OUTPUTS)][: -header.count("\n") - 1]
    assert out.splitlines()[: -len(OUTPUTS)] == [*above, *header.splitlines()]


def test_a_unit_below_the_names_counts(saved, tmp_path, capsysbinary):
    """It was refused as a row of no numbers."""
    (tmp_path / "data.csv").write_text("time,Ax,Ay,Az\ns,mV,mV,mV\n0,100,200,1900\n")
    out, err = applied(capsysbinary, saved, tmp_path / "data.csv")
    assert appended(out)[0] == pytest.approx(np.linalg.solve(K, [0.1 - 0.1, 0.2 + 0.2, 1.9 - 0.05]), abs=6e-10)
    assert "data.csv: row 2 is read as units: mV\n" in err and "no unit" not in err


def test_columns_without_names_are_told(saved, tmp_path, capsysbinary):
    (tmp_path / "data.csv").write_text(rows())
    _, err = applied(capsysbinary, saved, tmp_path / "data.csv")
    assert "data.csv: header: none, columns are numbered from 1: ux=2,uy=3,uz=4 (--columns)\n" in err


def test_files_without_a_header_are_joined(saved, tmp_path, capsysbinary):
    for name in "ab":
        (tmp_path / f"{name}.csv").write_text(rows())
    out, _ = applied(capsysbinary, saved, tmp_path / "a.csv", tmp_path / "b.csv")
    assert appended(out) == pytest.approx(np.tile(FORCE, (2, 1)), abs=6e-10)


# Binary recordings.


def npz(file, **columns):
    with open(file, "wb") as stream:
        np.savez(stream, **columns)


def hdf5(file, groups):
    h5py = pytest.importorskip("h5py", reason="h5py is not installed")
    with h5py.File(file, "w") as written:
        for group, outputs in groups.items():
            written[f"{group}/time"], written[f"{group}/accel"] = TIME, outputs
            written[f"{group}/accel"].attrs["units"] = "V"


def test_arrays_become_csv(saved, tmp_path, capsysbinary):
    npz(tmp_path / "data.npz", time=TIME, ux=OUTPUTS[:, 0], uy=OUTPUTS[:, 1], uz=OUTPUTS[:, 2])
    assert read(str(tmp_path / "data.npz"), LayoutOptions(), Timing()).outputs.tolist() == OUTPUTS.tolist()
    out, _ = applied(capsysbinary, saved, tmp_path / "data.npz")
    assert out.splitlines()[0] == "time,ux,uy,uz,x,y,z" and appended(out) == pytest.approx(FORCE, abs=6e-10)
    found = np.loadtxt(io.StringIO(out), delimiter=",", skiprows=1)
    assert found[:, :4].tolist() == np.column_stack((TIME, OUTPUTS)).tolist()
    (tmp_path / "out").mkdir()
    applied(capsysbinary, saved, tmp_path / "data.npz", "--out", tmp_path / "out")
    assert (tmp_path / "out/data.csv").read_text() == out


def test_a_source_of_several(saved, tmp_path, capsysbinary):
    hdf5(tmp_path / "data.h5", {"one": OUTPUTS, "two": OUTPUTS[::-1]})
    _, err = applied(capsysbinary, saved, tmp_path / "data.h5", code=2)
    assert err == (f"tumble: {tmp_path}/data.h5: 2 sources have outputs, '/one, /two': --rows source=NAME takes one\n")
    for source, force in (("/one", FORCE), ("/two", FORCE[::-1])):
        out, _ = applied(capsysbinary, saved, tmp_path / "data.h5", "--rows", f"source={source}")
        assert out.startswith("accel_x [V],accel_y [V],accel_z [V],time,x,y,z\n")
        assert appended(out) == pytest.approx(force, abs=6e-10)


@pytest.mark.parametrize(
    ("rows_of", "said"),
    [
        ("1/2", "--rows: '1/2' is not source=NAME"),
        ("source=", "--rows: 'source=' is not source=NAME"),
        ("source=a", "--rows source=a: {} is text, which has one source"),
    ],
)
def test_other_choices_of_rows_are_refused(rows_of, said, saved, tmp_path, capsysbinary):
    (tmp_path / "data.csv").write_text(TEXTS["plain"][0])
    out, err = applied(capsysbinary, saved, tmp_path / "data.csv", "--rows", rows_of, code=2)
    assert (out, err) == ("", f"tumble: {said.format(tmp_path / 'data.csv')}\n")
