"""What people type without the manual: each snippet as they would, and it works."""

import doctest
import json
import re
import sys

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

import tumble
from tumble.model import built_in

pytestmark = pytest.mark.python

RUN, STAND = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"
KEYS = {"axis_tilt_rad": 2e-5, "level_rad": 2e-5, "remount_rad": 4e-4, "angle_rad": 4e-5, "noise_v": 3e-4,
        "samples": 50, "limits": "sigma1"}  # fmt: skip


def test_the_snippets_of_the_page(tmp_path, monkeypatch):
    """docs/client.md, each as it stands."""
    for package in ("pandas", "xarray", "matplotlib"):
        pytest.importorskip(package)
    (tmp_path / "examples").symlink_to(EXAMPLES)
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/client.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```pycon\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    snippets = doctest.DocTestParser().get_doctest("\n".join(blocks), {}, "snippets", "docs/client.md", 0)
    failed, attempted = doctest.DocTestRunner().run(snippets)
    assert failed == 0 and attempted > 30


@pytest.fixture(scope="module")
def cal():
    return tumble.solve(RUN, stand=STAND)


@pytest.fixture(scope="module")
def df():
    pandas = pytest.importorskip("pandas")
    read = tumble.read(RUN)
    rows = np.column_stack([read.mounting, read.position, read.outputs])
    return pandas.DataFrame(rows, columns=["mounting", "position", "ux", "uy", "uz"])


def test_a_frame_with_its_unit(df):
    assert tumble.solve(df, unit="V").K.tolist() == tumble.solve(RUN).K.tolist()
    assert tumble.solve(df, unit="V").unit == "V" and "unit" not in tumble.solve(df, unit="V").assumes


def test_a_frame_with_its_columns(df):
    other = df.rename(columns={"ux": "AccX"})
    assert tumble.solve(other, unit="V", columns={"ux": "AccX"})["K_xx"] == tumble.solve(df, unit="V")["K_xx"]


def test_a_recording_has_been_read(df):
    with pytest.raises(tumble.UsageError, match=r"give them to tumble\.read"):
        tumble.solve(tumble.read(df), unit="V")


def test_one_coefficient(cal):
    assert cal["K_xy"] == cal.K[0, 1] and cal["U0_z"] == cal.U0[2]


def test_one_uncertainty(cal):
    assert cal["u_K_zz"] == cal.u_K[2, 2] and np.isnan(tumble.solve(RUN)["u_U0_x"])


@pytest.mark.parametrize("name", ["K_xw", "k_xx", 0, "u_u_K_xx"])
def test_no_coefficient(cal, name):
    with pytest.raises(KeyError, match="is none of K_xx"):
        cal[name]


def test_a_table_of_coefficients(cal):
    pytest.importorskip("pandas")
    table = cal.to_frame()
    assert list(table.index)[:2] == ["K_xx", "K_xy"] and list(table.columns) == ["value", "u", "unit", "assumes"]
    assert table.loc["K_yz", "value"] == cal["K_yz"] and table.loc["U0_x", "unit"] == "V"
    assert "seat" in table.loc["K_yz", "assumes"].split() and "seat" not in table.loc["K_xx", "assumes"].split()


def test_a_summary(cal):
    lines = cal.summary().splitlines()
    assert lines[0].startswith("PASS, assuming") and lines[2].split()[0] == "K_xx"
    assert lines[7].split()[0] == "K_yz*" and lines[2].endswith("V/g")


def test_a_notebook_shows_marks(cal):
    assert "<td>K_yz*</td>" in cal._repr_html_() and "<td>K_xx</td>" in cal._repr_html_()


def test_load_what_was_saved(cal, tmp_path):
    cal.save(str(tmp_path / "result.json"))
    kinds = (str(tmp_path / "result.json"), tmp_path / "result.json", cal.document, json.loads(cal.to_json()))
    assert all(tumble.load(one).K.tolist() == cal.K.tolist() for one in kinds)
    with pytest.raises(tumble.BadInput):
        tumble.load({"schema": "of another"})


def test_a_stand_by_its_keys(cal):
    stand = tumble.Stand(**KEYS)
    assert stand == tumble.Stand(2e-5, 2e-5, 4e-4, 4e-5, 3e-4, 50, "sigma1")
    assert tumble.solve(RUN, stand=stand).u_K.tolist() == cal.u_K.tolist()


def test_a_stand_given_twice():
    with pytest.raises(TypeError, match="is given twice"):
        tumble.Stand(**KEYS, angle=1e-4)


def test_a_stand_as_a_dict(cal):
    assert tumble.solve(RUN, stand=KEYS).u_K.tolist() == cal.u_K.tolist()
    whole = tumble.solve(RUN, stand={"stand": KEYS, "accept": {"delta_g_limit_g": 1e-5}})
    assert whole.document["decision"]["limit_g"] == 1e-5


@pytest.mark.parametrize(("stand", "said"), [
    ({**KEYS, "axis_tilt": 1}, "unknown key"), ({"axis_tilt_rad": 1e-4}, "level_rad"),
    ({**KEYS, "noise_v": "loud"}, "noise_v"), ({}, "axis_tilt_rad"), ({"stand": 3}, "stand"),
])  # fmt: skip
def test_a_dict_that_is_no_stand(stand, said):
    with pytest.raises(tumble.BadInput, match=said):
        tumble.solve(RUN, stand=stand)


def test_schedules_by_attribute():
    assert tumble.schedules.diagonal == built_in("diagonal") and "hand_laid" in dir(tumble.schedules)
    run, stand = EXAMPLES / "diagonal_stand.csv", EXAMPLES / "diagonal_stand.toml"
    by_object = tumble.solve(run, stand=stand, schedule=tumble.schedules.diagonal)
    assert by_object["K_xx"] == tumble.solve(run, stand=stand, schedule="diagonal")["K_xx"]
    with pytest.raises(AttributeError, match="no built-in schedule 'diagnal'"):
        _ = tumble.schedules.diagnal


def test_many_runs_to_one_table(cal, df):
    table = tumble.solve_many({"file": RUN, "frame": df}, stand=STAND, unit=None)
    assert list(table.index) == ["file", "frame"] and table.loc["frame", "K_xx"] == cal["K_xx"]
    assert list(tumble.solve_many([RUN], stand=STAND).index) == [str(RUN)]
    assert table.passed.all() and (table["u_K_yz"] > 0).all() and table.u_norm_worst_g.notna().all()
    assert tumble.solve_many([df, df]).u_K_xx.isna().all()


def test_a_plot_is_a_picture_in_a_notebook(cal):
    pytest.importorskip("matplotlib")
    shown = cal.plot(kind="attitude")
    assert list(shown) == ["attitude"]
    assert shown._repr_html_().startswith('<img alt="attitude" src="data:image/png;base64,')


def test_export(cal, request, tmp_path):
    program = request.getfixturevalue("tumble")  # the command line
    cal.save(tmp_path / "result.json")
    text = cal.export("c", tmp_path / "coefficients.h")
    assert (tmp_path / "coefficients.h").read_text() == text
    assert program("export", "result.json", "--format", "c", cwd=tmp_path).stdout == text
    assert cal.export("csv").startswith("coefficient,value,unit")
    assert "fixed" in cal.export("c", number="fixed", step=1e-6)


@pytest.mark.parametrize(("given", "said"), [
    ({"format": "fortran"}, "format: 'fortran' is not one of c, csv"), ({"format": "c", "number": "half"}, "number: "),
    ({"format": "csv", "number": "float"}, "number: "), ({"format": "c", "step": 1.0}, "step: "),
    ({"format": "c", "number": "fixed"}, "step: "), ({"format": "c", "unit": "ft/s2"}, "unit: "),
])  # fmt: skip
def test_no_such_export(cal, given, said):
    with pytest.raises(tumble.UsageError, match=said):
        cal.export(**given)


def test_an_export_that_cannot_be(cal):
    with pytest.raises(tumble.BadInput, match="gravity_m_s2"):
        cal.export("ros")


def test_a_step_of_a_pipeline(cal, df):
    step = tumble.Calibrator(stand=STAND)
    with pytest.raises(tumble.UsageError, match="transform comes after fit"):
        step.transform([[0.0, 0.0, 2.0]])
    assert step.fit(df) is step and step.result_["K_xx"] == cal["K_xx"]
    assert step.transform(cal.U0 + cal.K @ [0.0, 0.6, 0.8]) == pytest.approx([0.0, 0.6, 0.8])
    assert list(step.fit_transform(df).columns[-3:]) == ["x", "y", "z"]
    assert step.fit_transform(RUN).shape == (len(df), 3)
    assert step.get_params() == {"stand": STAND} and step.set_params(limit_g=1e-3).get_params()["limit_g"] == 1e-3
    assert repr(tumble.Calibrator(unit="V")) == "tumble.Calibrator(unit='V')"


class Variable:
    """As much of a DataArray as is asked for."""

    dims, ndim = ("time",), 1

    def __init__(self, values):
        self.values = values

    def __array__(self, dtype=None, copy=None):
        return np.asarray(self.values, dtype=dtype)


def test_a_dataset_comes_back_as_one(cal):
    """Its class by its name, for xarray is not among the packages of tests."""
    told = {}

    class Dataset(dict):
        def rename(self, names):
            told["renamed"] = names
            return self

        def assign(self, new):
            return Dataset(**self, **new)

    Dataset.__module__ = "xarray.core.dataset"
    given = Dataset({f"u{axis}": Variable([0.1, 0.2 + i, 2.0]) for i, axis in enumerate("xyz")})
    found = cal.apply(given, outputs_unit="V")
    assert type(found) is Dataset and list(found)[-3:] == ["x", "y", "z"] and told == {"renamed": {}}
    along, x = found["x"]
    wanted = cal.apply(np.column_stack([one.values for one in given.values()]), outputs_unit="V")
    assert along == ("time",) and x.tolist() == wanted[:, 0].tolist()


def test_datasets_of_xarray(cal):
    xarray = pytest.importorskip("xarray")
    told = cal.to_xarray()
    assert float(told.K.sel(channel="ux", axis="y")) == cal["K_xy"] and told.u_U0.attrs["units"] == "V"
    assert told.attrs["verdict"].startswith("PASS")
    given = xarray.Dataset({f"u{axis}": ("t", [0.1, 2.0]) for axis in "xyz"}, {"t": [3, 4]})
    found = cal.apply(given, outputs_unit="V")
    assert isinstance(found, xarray.Dataset) and found.x.dims == ("t",) and found.t.values.tolist() == [3, 4]


def test_a_library_that_is_missing_is_named(cal, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(tumble.NotInstalled, match="a dataset of coefficients needs xarray"):
        cal.to_xarray()


def test_the_names_of_the_twelve_and_the_verdict(cal):
    assert {name: cal[name] for name in cal} == dict(zip(cal, [*cal.K.ravel(), *cal.U0])) and len(list(cal)) == 12
    assert "K_xx" in cal and "K_xw" not in cal
    assert cal.verdict == "PASS" and cal.document["pass"]


def test_a_kind_of_picture_in_place_of_a_file(cal, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    assert list(cal.plot("attitude")) == ["attitude"] and not list(tmp_path.iterdir())
    with pytest.raises(tumble.UsageError, match=r"file: 'altitude' does not end in \.png, \.svg or \.pdf"):
        cal.plot("altitude")
