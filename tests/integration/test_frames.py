"""DataFrames of pandas and polars, tables of pyarrow, Parquet and MAT files: the same bits as CSV, the index kept."""

import sys

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble
from tumble.cli.main import main

pd = pytest.importorskip("pandas")
pl = pytest.importorskip("polars")
pa = pytest.importorskip("pyarrow")
scipy_io = pytest.importorskip("scipy.io")
parquet = pytest.importorskip("pyarrow.parquet")

pytestmark = [pytest.mark.python, pytest.mark.toolchain]

CSV, STAND = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"


@pytest.fixture(scope="module")
def result():
    return tumble.solve(CSV, stand=STAND)


@pytest.fixture(scope="module")
def frame():
    return pd.read_csv(CSV, float_precision="round_trip")


def bits(result):
    return result.K.tobytes() + result.U0.tobytes() + result.covariance.tobytes()


def test_every_frame_and_file_gives_the_same_bits(result, frame, tmp_path):
    frame.to_parquet(tmp_path / "pandas.parquet")
    pl.from_pandas(frame).write_parquet(tmp_path / "polars.pq")
    columns = {name: frame[name].to_numpy(dtype=float) for name in frame}
    scipy_io.savemat(tmp_path / "run.mat", columns)
    sources = [frame, frame.set_index(np.arange(len(frame)) * 7), pl.from_pandas(frame), pa.Table.from_pandas(frame)]
    sources += [tmp_path / "pandas.parquet", tmp_path / "polars.pq", tmp_path / "run.mat"]
    for source in sources:
        assert bits(tumble.solve(source, stand=STAND)) == bits(result)
    assert bits(tumble.solve(frame.astype({"mounting": "Int64", "ux": "Float64"}), stand=STAND)) == bits(result)


def test_the_command_takes_parquet_too(result, frame, tmp_path, capsys):
    frame.to_parquet(tmp_path / "run.parquet")
    assert main(["solve", str(tmp_path / "run.parquet"), "--stand", str(STAND), "--out", str(tmp_path / "r.json")]) == 0
    assert bits(tumble.load(tmp_path / "r.json")) == bits(result)
    assert "run.parquet: 900 samples" in capsys.readouterr().out


def test_a_missing_column_of_a_frame_is_named(frame):
    for source, name in (
        (frame, "pandas"),
        (pl.from_pandas(frame), "polars"),
        (pa.Table.from_pandas(frame), "pyarrow"),
    ):
        less = source.drop(columns="uy") if name == "pandas" else source.drop(["uy"])
        with pytest.raises(ValueError, match=f"^{name}: no column uy among 'mounting,position,ux,uz"):
            tumble.solve(less)


def test_what_is_no_number_in_a_frame(frame):
    for convert, name in ((lambda x: x, "pandas"), (pl.from_pandas, "polars"), (pa.Table.from_pandas, "pyarrow")):
        with pytest.raises(tumble.BadInput, match=f"^{name}: column uy: not numbers: "):
            tumble.solve(convert(frame.assign(uy="one")))
        gap = frame.astype({"uz": "Float64"})
        gap.loc[4, "uz"] = pd.NA
        with pytest.raises(tumble.BadInput, match=f"^{name}: row 5, column uz: nan is not a finite number in range"):
            tumble.solve(convert(gap))
    with pytest.raises(tumble.UsageError, match=r"a LazyFrame has no rows yet: collect\(\) it"):
        tumble.solve(pl.from_pandas(frame).lazy())


def test_apply_keeps_index_columns_and_kind(result, frame):
    expected = result.apply(frame[["ux", "uy", "uz"]].to_numpy(), uncertainty=True)
    dated = frame.assign(note="text").set_index(pd.date_range("2024-01-01", periods=len(frame), freq="s"))
    found = result.apply(dated)
    assert type(found) is pd.DataFrame and found.index.equals(dated.index) and found[dated.columns].equals(dated)
    assert list(found.columns[-3:]) == ["x", "y", "z"] and np.array_equal(found[["x", "y", "z"]], expected[:, :3])
    assert list(dated.columns[-3:]) != ["x", "y", "z"]  # what was handed in stays as it was
    for convert in (pl.from_pandas, pa.Table.from_pandas):
        table = convert(frame)
        found = result.apply(table, uncertainty=True)
        assert type(found) is type(table) and found.shape == (len(frame), table.shape[1] + 7)
        names = list(found.columns if convert is pl.from_pandas else found.column_names)
        assert names[-7:] == ["u_x", "u_y", "u_z", "u_norm", "x", "y", "z"]
        numbers = np.array([found[name].to_numpy() for name in ("x", "y", "z", "u_x", "u_y", "u_z", "u_norm")]).T
        assert np.array_equal(numbers, expected)


def test_apply_leaves_gaps_and_raw_names(result):
    for table in (pd.DataFrame({"x": [0.1, None], "y": [0.2, 0.2], "z": [1.9, 1.9]}),
                  pl.DataFrame({"x": [0.1, None], "y": [0.2, 0.2], "z": [1.9, 1.9]})):  # fmt: skip
        found = result.apply(table)
        assert list(found.columns) == ["raw_x", "raw_y", "raw_z", "x", "y", "z"]
        assert found["x"][0] == result.apply([0.1, 0.2, 1.9])[0] and np.isnan(found["x"].to_numpy()[1])


@pytest.mark.parametrize("by", ["pyarrow", "polars"])
def test_apply_to_parquet(by, result, frame, tmp_path, monkeypatch):
    """In pieces by pyarrow, as a whole by polars where only that is there; types of other columns are kept."""
    many = pd.concat([frame.assign(label="a", n=np.arange(len(frame), dtype=np.int16))] * 80, ignore_index=True)
    many.to_parquet(tmp_path / "data.parquet", index=False)
    result.save(tmp_path / "r.json")
    if by == "polars":
        monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
        monkeypatch.setitem(sys.modules, "pyarrow", None)
    files = [str(tmp_path / name) for name in ("r.json", "data.parquet", "out.parquet")]
    assert main(["apply", *files[:2], "--out", files[2]]) == 0
    monkeypatch.undo()
    found, source = pd.read_parquet(files[2]), pd.read_parquet(files[1])
    assert found.drop(columns=["x", "y", "z"]).equals(source) and list(found.columns[-3:]) == ["x", "y", "z"]
    assert np.array_equal(found[["x", "y", "z"]], result.apply(many[["ux", "uy", "uz"]].to_numpy()))
    if by == "pyarrow":
        assert parquet.ParquetFile(files[2]).num_row_groups > 1


def test_parquet_that_is_none(result, tmp_path, capsys):
    result.save(tmp_path / "r.json")
    (tmp_path / "data.parquet").write_text("ux,uy,uz\n")
    code = main(["apply", str(tmp_path / "r.json"), str(tmp_path / "data.parquet"), "--out", str(tmp_path / "out.pq")])
    assert code == 2 and "data.parquet: not a Parquet file that can be read: " in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["data.parquet", "r.json"]
    for name, said in (("data.parquet", "not a parquet file that can be read"), ("run.mat", "not a mat file")):
        (tmp_path / name).write_text("ux,uy,uz\n")
        with pytest.raises(tumble.BadInput, match=said):
            tumble.read(tmp_path / name)
