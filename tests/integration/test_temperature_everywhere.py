"""The column temperature is known wherever a run or data come from: tables, NPZ, Parquet, recordings; and its range is
one, with warnings where a run has no one temperature."""

import json
import warnings

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES
from documents import paper_stand
from recordings import Habits, recording

import tumble
from tumble.cli.main import main
from tumble.model import built_in

pytestmark = pytest.mark.python

CSV = EXAMPLES / "paper_stand.csv"
STAND = EXAMPLES / "paper_stand.toml"
NAMES = ("mounting", "position", "ux", "uy", "uz")
ROWS = np.loadtxt(CSV, delimiter=",", skiprows=1)
HABITS = Habits(rate_hz=50.0, rest_s=(2.0, 3.0), noise_g=1e-4, angle=1e-5, seat=1e-5, bench=0.0, pause=0.0, gap=0.0)


def columns(temperatures, name="temperature"):
    """The paper's run with a column of temperatures, over and over."""
    return {**dict(zip(NAMES, ROWS.T)), name: np.resize(np.array(temperatures), len(ROWS))}


def run_file(folder, temperatures, name="temperature"):
    head, *rows = CSV.read_text().splitlines()
    texts = [f"{row},{temperatures[place % len(temperatures)]}" for place, row in enumerate(rows)]
    (folder / "run.csv").write_text("\n".join([f"{head},{name}", *texts]) + "\n")
    return folder / "run.csv"


# Runs.


@pytest.mark.parametrize("kind", ["mapping", "structured", "npz", "csv"])
@pytest.mark.parametrize(("name", "told"), [
    ("temperature", None), ("Temp [°C]", None), ("oven", {"temperature": "oven"}),
])  # fmt: skip
def test_a_run_tells_its_temperature(kind, name, told, tmp_path):
    table = columns([20.5, np.nan, 22.25], name)
    if kind == "structured":
        table = np.rec.fromarrays(list(table.values()), dtype=[(one, float) for one in table])
    elif kind == "npz":
        np.savez(tmp_path / "run.npz", **table)
        table = tmp_path / "run.npz"
    elif kind == "csv":
        table = run_file(tmp_path, ["20.5", "", "22.25"], name)
    run = tumble.read(table, columns=told, unit="V")
    assert run.temperature_c == (20.5, 22.25)
    found = tumble.solve(run, stand=STAND).document
    assert found["temperature"] == {"min_c": 20.5, "max_c": 22.25, "source": "run_file"}
    assert found["counters"]["columns_ignored"] == 0 and "temperature" not in found["assumes"]


@pytest.mark.parametrize(("temperatures", "why"), [
    ([293.15], "row 1: 293.15 is no temperature from -100 to 230 deg C"),
    ([20.0, -np.inf], "row 2: -inf is no temperature from -100 to 230 deg C"),
    (["warm"], "not numbers: \"could not convert string to float: 'w...'\""),
])  # fmt: skip
def test_what_is_no_temperature_in_a_table(temperatures, why):
    """Passed over with a warning where it was found, refused where it was named, already by `read`."""
    found = tumble.solve(columns(temperatures))
    if "not numbers" in why:
        assert any(one.startswith("column 'temperature' passed over: not numbers: ") for one in found.warnings)
    else:
        assert f"column 'temperature' passed over: {why}" in found.warnings
    assert found.document["temperature"] is None and found.document["counters"]["columns_ignored"] == 1
    with pytest.raises(tumble.BadInput, match="column temp") as caught:
        tumble.read(columns(temperatures, "temp"), columns={"temperature": "temp"})
    assert "not numbers" in why or str(caught.value) == f"table: {why.replace(':', ', column temp:', 1)}"


def test_a_column_of_another_length_is_no_temperature():
    table = {**columns([20.0]), "temperature": [20.0, 21.0]}
    said = f"column 'temperature' passed over: its length is 2, that of the outputs {len(ROWS)}"
    assert said in tumble.solve(table).warnings


def test_a_run_file_that_is_named_wrongly_is_refused_by_read(tmp_path):
    with pytest.raises(tumble.BadInput, match=r"row 2, column T: 'hot' is no temperature from -100 to 230 deg C$"):
        tumble.read(run_file(tmp_path, ["hot"], "T"), columns={"temperature": "T"})


# Data.


@pytest.fixture
def at_20(tmp_path):
    result = tumble.solve(columns([20.0]), stand=STAND)
    result.save(tmp_path / "result.json")
    return result


def test_a_named_column_of_data_is_held_against_the_run(at_20, tmp_path, capsys):
    (tmp_path / "data.csv").write_text("ux,uy,uz,oven\n0.1,0.2,1.9,20.5\n0.1,0.2,1.9,31\n")
    given = ["apply", str(tmp_path / "result.json"), str(tmp_path / "data.csv")]
    assert main(given) == 0 and "applied at" not in capsys.readouterr().err
    assert main([*given, "--columns", "temperature=oven"]) == 0
    assert "data.csv: applied at 20.5 to 31 deg C, calibrated at 20 deg C\n" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["temperature", "oven"])
def test_a_table_of_data_is_held_against_the_run(at_20, name):
    told = {"temperature": name} if name == "oven" else None
    data = {"ux": [0.1, 0.1], "uy": [0.2, 0.2], "uz": [1.9, 1.9], name: [20.5, 31.0]}
    with pytest.warns(UserWarning, match=r"^table: applied at 20.5 to 31 deg C, calibrated at 20 deg C$") as caught:
        found = at_20.apply(data, columns=told)
    assert caught[0].filename == __file__ and list(found) == ["ux", "uy", "uz", name, "x", "y", "z"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        at_20.apply({**data, name: [20.5, 21.0]}, columns=told)


def test_parquet_is_held_against_the_run(at_20, tmp_path, capsys):
    pyarrow = pytest.importorskip("pyarrow", reason="pyarrow is not installed")
    from pyarrow import parquet

    data = {"ux": [0.1, 0.1], "uy": [0.2, 0.2], "uz": [1.9, 1.9], "temperature": [20.5, 31.0]}
    parquet.write_table(pyarrow.table(data), tmp_path / "data.parquet")
    given = [str(tmp_path / name) for name in ("result.json", "data.parquet")]
    assert main(["apply", *given, "--out", str(tmp_path / "calibrated.parquet")]) == 0
    assert "data.parquet: applied at 20.5 to 31 deg C, calibrated at 20 deg C\n" in capsys.readouterr().err


# Recordings.


def recorded(folder, texts, header="time,Ax,Ay,Az,temperature", units=None):
    """A recording with these texts in its last column, each for a third of it."""
    made = recording(
        built_in("paper"), list(range(18)), NOMINAL_K, np.array([0.1, 0.2, 0.3]), HABITS, np.random.default_rng(11)
    )
    _, *rows = made.csv().splitlines()
    lines = [f"{row},{texts[place * len(texts) // len(rows)]}" for place, row in enumerate(rows)]
    (folder / "log.csv").write_text("\n".join([header, *([] if units is None else [units]), *lines]) + "\n")
    return folder / "log.csv"


def imported(folder, file, capsys, *options, code=0):
    """What was said; the run file is run.csv."""
    assert main(["import", str(file), "--out", str(folder / "run.csv"), *options]) == code
    return " ".join("".join(capsys.readouterr()).split())


def test_a_recording_hands_its_temperature_on(tmp_path, capsys):
    said = imported(tmp_path, recorded(tmp_path, ["20.5", "", "22.0"]), capsys)
    assert "- temperature: of column 'temperature', 20.5 to 22 deg C" in said
    run = tumble.read(tmp_path / "run.csv")
    assert run.temperature_c == (20.5, 22.0)
    head, *rows = (tmp_path / "run.csv").read_text().splitlines()[1:]
    assert head == "mounting,position,ux,uy,uz,time_s,rest,temperature"
    texts = [row.split(",")[7] for row in rows]
    assert [text for place, text in enumerate(texts) if place == 0 or text != texts[place - 1]] == ["20.5", "", "22.0"]


def test_a_named_column_of_a_recording_and_its_recipe(tmp_path, capsys):
    file = recorded(tmp_path, ["20.5"], header="time,Ax,Ay,Az,oven")
    recipe = ("--recipe", str(tmp_path / "recipe.toml"))
    said = imported(tmp_path, file, capsys, "--columns", "temperature=oven", "--schedule", "paper", *recipe)
    assert "of column 'oven', 20.5 deg C" in said
    assert imported(tmp_path, file, capsys, *recipe).replace("- recipe recipe.toml followed ", "") == said
    assert tumble.read(tmp_path / "run.csv").temperature_c == (20.5, 20.5)


def test_a_recording_whose_column_is_no_temperature(tmp_path, capsys):
    file = recorded(tmp_path, ["293.5"])
    why = "'293.5' is no temperature from -100 to 230 deg C"
    assert f"- column 'temperature' passed over: row 2: {why}" in imported(tmp_path, file, capsys)
    assert tumble.read(tmp_path / "run.csv").temperature_c is None
    said = imported(tmp_path, file, capsys, "--columns", "temperature=temperature", code=2)
    assert said.endswith(f"log.csv: row 2, column temperature: {why}")


@pytest.mark.parametrize(("unit", "known"), [("°C", (20.0, 20.0)), ("F", None), ("-", (20.0, 20.0))])
def test_a_row_of_units_tells_that_of_the_temperature(unit, known, tmp_path, capsys):
    imported(tmp_path, recorded(tmp_path, ["20"], units=f"s,V,V,V,{unit}"), capsys)
    assert tumble.read(tmp_path / "run.csv").temperature_c == known


# One range; one warning for a span, one for a contradiction.


@pytest.mark.parametrize(("temperature", "good"), [(-100.0, True), (230.0, True), (-100.5, False), (230.5, False)])
def test_stand_file_and_run_file_take_the_same_range(temperature, good, tmp_path):
    assert (tumble.solve(columns([temperature])).document["temperature"] is not None) == good
    stand = paper_stand(tmp_path, f"[environment]\ntemperature_c = {temperature}\n")
    if good:
        assert tumble.solve(CSV, stand=stand).document["temperature"]["min_c"] == temperature
    else:
        with pytest.raises(tumble.BadInput, match="temperature_c"):
            tumble.solve(CSV, stand=stand)


@pytest.mark.parametrize(("highest", "warned"), [(45.0, True), (10.5, True), (10.0, False)])
def test_a_run_of_many_temperatures_is_warned_of(highest, warned, tmp_path, capsys):
    said = f"the run was measured at 0 to {highest:.3g} deg C: its coefficients are those of no one temperature"
    assert (said in tumble.solve(columns([0.0, highest])).warnings) == warned
    run = run_file(tmp_path, ["0", str(highest)])
    assert main(["solve", str(run), "--json"]) == 0
    printed = capsys.readouterr()
    assert (f"tumble: warning: {said}\n" in printed.err) == (said in json.loads(printed.out)["warnings"]) == warned
    main(["fixture", "check", "--stand", str(STAND), str(run)])
    assert (f"run.csv: {said}\n" in capsys.readouterr().err) == warned


@pytest.mark.parametrize(("told", "warned"), [(60.0, True), (31.0, False), (10.0, False), (9.0, True)])
def test_a_stand_file_that_contradicts_the_run_is_warned_of(told, warned, tmp_path, capsys):
    stand = paper_stand(tmp_path, f"[environment]\ntemperature_c = {told}\n")
    said = f"the run says 20 to 21 deg C, temperature_c of the stand file {told:g}: that of the run counts"
    found = tumble.solve(columns([20.0, 21.0]), stand=stand)
    assert (said in found.warnings) == warned
    assert found.document["temperature"] == {"min_c": 20.0, "max_c": 21.0, "source": "run_file"}
    main(["fixture", "check", "--stand", str(stand), str(run_file(tmp_path, ["20", "21"]))])
    assert (f"run.csv: {said}\n" in capsys.readouterr().err) == warned
