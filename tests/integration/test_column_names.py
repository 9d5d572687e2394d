"""Which column is which: an exact name wins over one that means the same."""

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble
from tumble.cli.main import main
from tumble.files.run_layout import find_column, unit_in
from tumble.units import spelled

pytestmark = pytest.mark.python


@pytest.fixture(scope="module")
def paper():
    return tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml")


@pytest.mark.parametrize("further", [(), ("--uncertainty",)])
def test_apply_reads_its_own_output_again(paper, tmp_path, further):
    """u_x, an uncertainty, was taken for ux."""
    (tmp_path / "data.csv").write_text("ux,uy,uz\n0.1,0.2,1.9\n")
    paper.save(tmp_path / "result.json")
    once, again = tmp_path / "once.csv", tmp_path / "again.csv"
    given = ["apply", str(tmp_path / "result.json")]
    assert main([*given, str(tmp_path / "data.csv"), "--uncertainty", "--out", str(once)]) == 0
    assert main([*given, str(once), *further, "--out", str(again)]) == 0
    (_, first), (head, second) = ([line.split(",") for line in one.read_text().splitlines()] for one in (once, again))
    assert head[:3] == ["ux", "uy", "uz"] and head[-3:] == ["x", "y", "z"]
    assert second[-3:] == first[-3:]
    table = paper.apply(paper.apply({"ux": [0.1], "uy": [0.2], "uz": [1.9]}, uncertainty=True))
    assert table["x"].tolist() == table["raw_x"].tolist() and list(table)[3] == "u_x"


@pytest.mark.parametrize(("names", "place"), [
    (["u_x", "ux"], 1), (["U_x", "Ux"], 1), (["ux [V]", "u_x"], 0), (["u-x", "UX"], 1), (["u_x", "y"], 0),
])  # fmt: skip
def test_an_exact_name_wins(names, place):
    assert find_column("ux", names, {}) == place


@pytest.mark.parametrize(("unit", "spellings"), [
    ("m/s^2", "m/s2 m/s² m/s**2 m/s/s m/(s^2) m/(s2) m*s^-2 m·s⁻² ms^-2 mps2 m/sec^2 M/S^2 meters/s^2"),
    ("mm/s^2", "mm/s² mm/(s^2)"), ("g", "G gee g_n g0"), ("mg", "mG milli-g"), ("µg", "μg uG"), ("V", "v VDC Volts"),
    ("mV", "mv mVDC millivolt"), ("µV", "μV"), ("counts", "count Counts"),
])  # fmt: skip
def test_a_unit_is_one_in_any_spelling(unit, spellings):
    assert {one: spelled(one) for one in spellings.split()} == dict.fromkeys(spellings.split(), unit)
    assert unit_in(f"ax [{spellings.split()[0]}]") == ("ax", unit)
    assert unit_in("ax_mg") == ("ax", "mg") and unit_in("u_x") == ("u_x", "")


def test_a_column_is_named_with_or_without_its_unit():
    assert find_column("ux", ["Kanal 1 [V]", "Kanal 2 [V]"], {"ux": "Kanal 2"}) == 1
    assert find_column("ux", ["accel_y_mg", "accel_x_mg"], {}) == 1
    assert find_column("time", ["time", "ux"], {"time": ""}) is None


def test_two_exact_names_are_refused():
    with pytest.raises(ValueError, match=r"columns 'ux' and 'ux \[V\]' could both be ux"):
        find_column("ux", ["ux", "ux [V]", "u_x"], {})


@pytest.mark.parametrize("suffix", ["npz", "mat", "NPZ"])
def test_files_of_arrays_with_one_row(paper, suffix, refused, tmp_path):
    """They were called "not a text file"."""
    file = tmp_path / f"run.{suffix}"
    np.savez(open(file, "wb"), ux=[0.1], uy=[0.2], uz=[1.9])  # noqa: SIM115
    paper.save(tmp_path / "result.json")
    for command in (("apply", tmp_path / "result.json"), ("import",)):
        assert refused(*command, file) == f"tumble: {file}: NPZ without three columns of numbers, of one length\n"


def test_a_recording_is_sent_to_import(refused):
    said = refused("solve", EXAMPLES / "hand_held_session.csv")
    assert said.endswith("=NAME,position=NAME, or add it; tumble import makes a run file of a logger's recording\n")
