"""The temperature of a run: read from its file or the stand file, carried into results and exports, warned of."""

import json
import math
import re
import struct

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import document_of, paper_stand, valid
from hypothesis import given, strategies as st
from simulated_bench import bench

from tumble.cli import output
from tumble.cli.main import main
from tumble.documents.result import Temperature, read_result
from tumble.errors import BadInput
from tumble.files import run_rows
from tumble.files.rows import OF_ENVIRONMENT, OF_RUN_FILE, Temperatures
from tumble.files.run_file import read_run
from tumble.files.run_layout import LayoutOptions
from tumble.model import Geometry, built_in
from tumble.solving import plausibility
from tumble.solving.decision import assumed
from tumble.solving.solution import solve

pytestmark = pytest.mark.python

PAPER = built_in("paper")
K = np.array([[2.0, 0.04, 0.04], [0.04, 2.0, 0.04], [0.04, 0.04, 2.0]])
MEANS = Geometry(PAPER).outputs(K, np.zeros(3))


def run_file(folder, temperatures, header="temperature", delimiter=",", decimal="."):
    """One row for each position of the paper's schedule, with these texts in a further column, over and over."""
    rows = [delimiter.join(["mounting", "position", "ux", "uy", "uz", header])]
    for index, (position, mean) in enumerate(zip(PAPER.positions, MEANS.tolist())):
        numbers = [repr(value).replace(".", decimal) for value in mean]
        fields = [str(position.mounting), str(position.number), *numbers, temperatures[index % len(temperatures)]]
        rows.append(delimiter.join(fields))
    path = folder / "run.csv"
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return str(path)


def told(folder, temperatures, options=None, **layout):
    """The range that is read, and what is passed over."""
    run = read_run(run_file(folder, temperatures, **layout), PAPER, options or LayoutOptions())
    found = run.temperature
    assert found is None or found.source == OF_RUN_FILE
    assert run.counters["columns_ignored"] == (found is None)
    assert run_rows.check_rows(run, PAPER, None, "run.csv") == run.passed_over
    return None if found is None else (found.low_c, found.high_c), run.passed_over


FOUND = ((-3.0, 21.0), ())
NO_NUMBER = ("column 'temperature' passed over: row 2: '20,5' is no temperature from -100 to 230 deg C",)


@pytest.mark.parametrize(
    ("layout", "texts", "found"),
    [({"header": one}, ["20.5", "21", " 19.25 ", "-3e0"], FOUND)
     for one in ("temperature", "Temp", "TEMPERATURE [°C]", "temp (deg C)", "temp_C", "temperature [C]")]
    + [
        ({"delimiter": ";", "decimal": ","}, ["20,5", '"21,25"'], ((20.5, 21.25), ())),
        ({"delimiter": ";"}, ["20,5"], (None, NO_NUMBER)),
        ({}, ["", "20", ""], ((20.0, 20.0), ())),
        ({}, [""], (None, ())),
    ],
)  # fmt: skip
def test_a_column_of_temperatures_is_found(layout, texts, found, tmp_path):
    """Empty fields tell nothing."""
    assert told(tmp_path, texts, **layout) == found


def test_a_column_of_another_name_is_read_where_the_user_says_so(tmp_path):
    assert told(tmp_path, ["20", "22"], header="sensor 3") == (None, ())
    options = LayoutOptions(columns={"temperature": "Sensor 3"})
    assert told(tmp_path, ["20", "22"], options, header="sensor 3") == ((20.0, 22.0), ())


@pytest.mark.parametrize(
    ("header", "texts", "why"),
    [
        ("temperature", ["20", "n/a"], "row 3: 'n/a' is no temperature from -100 to 230 deg C"),
        ("temp", ["20", "20", "293.15"], "row 4: '293.15' is no temperature from -100 to 230 deg C"),
        ("temp", ["nan"], "row 2: 'nan' is no temperature from -100 to 230 deg C"),
        ("temp", ["1_0"], "row 2: '1_0' is no temperature from -100 to 230 deg C"),
        ("temperature [K]", ["200"], "its unit is not deg C"),
        ("temperature (F)", ["68"], "its unit is not deg C"),
    ],
)
def test_what_is_no_temperature(header, texts, why, tmp_path):
    """A column that was found is passed over, and a warning says so; one that was named is refused."""
    assert told(tmp_path, texts, header=header) == (None, (f"column '{header}' passed over: {why}",))
    file = run_file(tmp_path, texts, header)
    with pytest.raises(BadInput) as refused:
        read_run(file, PAPER, LayoutOptions(columns={"temperature": header}))
    row, _, message = why.rpartition(": ")
    assert refused.value.fault == message and refused.value.row == (int(row.split()[1]) if row else None)


def test_two_columns_that_could_be_it(tmp_path):
    file = run_file(tmp_path, ["20,30"], header="temp,Temp (C)")
    run = read_run(file, PAPER)
    several = "columns 'temp' and 'Temp (C)' could both be temperature; say which with --columns temperature=NAME"
    assert run.temperature is None and run.passed_over == (several,)
    chosen = read_run(file, PAPER, LayoutOptions(columns={"temperature": "Temp (C)"}))
    assert (chosen.temperature.low_c, chosen.passed_over) == (30.0, ())


def test_a_column_that_is_named_must_be_there(tmp_path):
    with pytest.raises(BadInput, match=r"no column 'oven' \(for temperature\) among 'mounting,position,ux,uy,uz,t'"):
        read_run(run_file(tmp_path, ["20"], header="t"), PAPER, LayoutOptions(columns={"temperature": "oven"}))


def test_the_run_file_comes_before_the_stand_file(tmp_path):
    of_file = read_run(run_file(tmp_path, ["20", "21"]), PAPER)
    of_none = read_run(run_file(tmp_path, ["20"], header="x"), PAPER)
    environment = {"temperature_c": 30, "place": "cellar"}
    assert plausibility.in_environment(of_file, environment).temperature == Temperatures(20.0, 21.0, OF_RUN_FILE)
    assert plausibility.in_environment(of_none, environment).temperature == Temperatures(30.0, 30.0, OF_ENVIRONMENT)
    for nothing in (None, {}, {"place": "cellar"}):
        assert plausibility.in_environment(of_none, nothing).temperature is None


def test_a_solution_assumes_it_where_it_is_not_told(tmp_path):
    for texts, rests_on, lines in (
        (["20.5", "21"], set(), ["Temperature of the run: 20.5 to 21 deg C (run file)"]),
        (["", ""], {"temperature"}, []),
    ):
        run = read_run(run_file(tmp_path, texts), PAPER, LayoutOptions(unit="V"))
        solution = solve(run, None, "refined", 1.0, None, "run.csv")
        assert assumed(solution).keys() - {"seat", "white_noise"} == rests_on
        said = [line for line in output.remarks(solution) if "emperature" in line]
        assert said == lines
        assert any("assume one temperature" in line for line in output.notes(solution)) == bool(rests_on)


def test_results_and_exports_carry_it(tumble, tmp_path):
    """From the environment of the stand file, which the verdict then does not rest on."""
    stand = paper_stand(tmp_path, "[environment]\ntemperature_c = 21.5\n")
    result = tmp_path / "result.json"
    run = ("solve", EXAMPLES / "paper_stand.csv", "--unit", "V", "--stand")
    found = document_of(tumble(*run, stand, "--json", "--out", result))
    assert found["temperature"] == {"min_c": 21.5, "max_c": 21.5, "source": "environment"}
    assert found["assumes"] == ["seat"]
    header = tumble("export", result, "--format", "c").stdout
    for line in ("KNOWN 1", "MIN_C (21.5) /* deg C, of the run */", "MAX_C (21.5) /* deg C, of the run */"):
        assert f"#define TUMBLE_TEMPERATURE_{line}\n" in header
    for row in tumble("export", result, "--format", "csv").stdout.splitlines()[1:]:
        assert row.endswith(",21.5,21.5")
    text = json.loads(result.read_text())
    odd_ones = {
        "temperature is ": "warm",
        "no temperature.max_c": {"min_c": 20},
        "temperature.max_c is ": {"min_c": 20, "max_c": "hot"},
    }
    for said, odd in odd_ones.items():
        result.write_text(json.dumps({**text, "temperature": odd}))
        with pytest.raises(BadInput, match=rf"not a result of schema tumble\.result/1: {said}"):
            read_result(str(result))
    del text["temperature"]  # of an earlier version
    result.write_text(json.dumps(text))
    header = tumble("export", result, "--format", "c").stdout
    assert "#define TUMBLE_TEMPERATURE_KNOWN 0\n" in header and "TUMBLE_TEMPERATURE_MIN_C" not in header


def test_a_bench_run_has_the_block_s_own(tumble, tmp_path):
    result = valid(tumble("bench", "--seed", 3, "--samples", 5, "--out", tmp_path / "run", "--json").stdout)
    assert result["temperature"] == {"min_c": 25.0, "max_c": 25.0, "source": "run_file"}
    assert "temperature" not in result["assumes"]


def test_the_run_file_has_the_temperatures_of_the_frames(tmp_path):
    """Of a block that warms up: by counts of z and timestamp every row is found on the recorded bus."""
    warming = {"block.start_c": 10, "block.end_c": 31, "block.warm_s": 30, "procedure.gravity_limit_g": 1}
    assert bench(warming, out=tmp_path / "run")["exit"] in (0, 1)
    frames = set()
    for data in re.findall(r" 693#([0-9A-F]{16})$", (tmp_path / "run/bus.log").read_text(), re.MULTILINE):
        z, timestamp, warmth, _ = struct.unpack("<3sxHbB", bytes.fromhex(data))
        frames.add((int.from_bytes(z, "little", signed=True), timestamp & 0xFFF, warmth / 2))
    lines = (tmp_path / "run/run.csv").read_text().splitlines()
    rows = [dict(zip(lines[0].split(","), line.split(","))) for line in lines[1:]]
    seen = {(int(row["cz"]), int(row["timestamp"]), float(row["temperature"])) for row in rows}
    assert len(rows) == 900 and seen <= frames
    found = read_run(str(tmp_path / "run/run.csv"), PAPER).temperature
    values = [warmth for _, _, warmth in seen]
    assert (found.low_c, found.high_c) == (min(values), max(values)) and found.high_c - found.low_c > 10


@pytest.mark.parametrize(
    ("known", "used", "warning"),
    [
        ((20.0, 22.0), [20.0, 21.0, 22.0], None),
        ((20.0, 22.0), [19.0, 23.0], None),
        ((20.0, 22.0), [math.nan], None),
        ((20.0, 22.0), [], None),
        (None, [500.0], None),
        ((20.0, 22.0), 25.5, "applied at 25.5 deg C, calibrated at 20 to 22 deg C"),
        (
            (20.0, 20.0),
            [[18.5, 20.0], [math.nan, 21.5]],
            "applied at 18.5 to 21.5 deg C, calibrated at 20 deg C",
        ),
    ],
)
def test_who_applies_coefficients_elsewhere_is_warned(known, used, warning):
    document = None if known is None else Temperature(known[0], known[1], "run_file")
    assert plausibility.outside(document, used) == warning


@given(st.floats(-60, 60), st.floats(0, 20), st.lists(st.floats(-90, 90), max_size=8))
def test_the_warning_is_there_where_one_is_outside(low, span, used):
    """Against every temperature by itself."""
    low_c, high_c = low - plausibility.TOLERANCE_C, low + span + plausibility.TOLERANCE_C
    beyond = [one for one in used if one < low_c or one > high_c]
    said = plausibility.outside(Temperature(low, low + span), used)
    assert (said is None) == (not beyond)


def test_apply_warns_where_the_data_were_hotter_than_the_run(tmp_path, capsys):
    saved, data = tmp_path / "result.json", tmp_path / "data.csv"
    run = tmp_path / "run.csv"
    text = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    run.write_text("\n".join([f"{text[0]},temperature", *(f"{line},20.5" for line in text[1:])]) + "\n")
    assert main(["solve", str(run), "--unit", "V", "--out", str(saved)]) == 0
    for hottest, warned in (("20.9", ""), ("36.5", "applied at 20.5 to 36.5 deg C, calibrated at 20.5 deg C")):
        data.write_text(f"ux,uy,uz,temp\n0.1,0.2,1.9,20.5\n0.1,0.2,1.9,{hottest}\n0.1,0.2,1.9,\n")
        capsys.readouterr()
        assert main(["apply", str(saved), str(data)]) == 0
        said = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
        assert said == ([f"tumble: warning: {data}: {warned}"] if warned else [])
