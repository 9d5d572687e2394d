"""A result repeats what it rests on: the declared stand and the schedule, with the keys and numbers of their files."""

import dataclasses
import json

import calibrations
import numpy as np
import pytest
from conftest import EXAMPLES
from documents import document_of, paper_stand, valid

import tumble
from tumble.core import built_in
from tumble.errors import BadInput
from tumble.files.schedule_file import read_schedule
from tumble.schedule import BUILT_IN
from tumble.solving.expected import expected
from tumble.solving.result import schedule_of, schedule_part, stand_of, step_of
from tumble.stand import SOURCES, Stand

pytestmark = pytest.mark.python


def test_every_number_of_a_stand_is_repeated():
    """One that Stand has and a result forgets would be an error that nobody reads of."""
    others = {"name", "limits", "remounting", "samples", "rounding"}  # rounding: a plan's, made of the converter's step
    declared = {source.attribute for source in SOURCES.values()}
    assert declared | others == {field.name for field in dataclasses.fields(Stand)}


@pytest.mark.parametrize("limits", ["sigma1", "sigma3", "uniform"])
def test_a_stand_is_repeated_as_its_file_has_it(limits, tmp_path):
    added = "seat_rad = 1e-5\nplatform_rad = 2e-5\nencoder_rad = 3e-5\nremount = \"common\""
    file = paper_stand(tmp_path, limits=f'"{limits}"\n{added}')
    told = tumble.solve(EXAMPLES / "paper_stand.csv", stand=file).document["stand"]
    assert told == {**declared_keys(file), "drift_v": 0.0, "step_v": None}


def declared_keys(file):
    """Of [stand], by a parser of this test's own: lines KEY = VALUE, whose values are JSON but for comments."""
    body = file.read_text().split("[stand]")[1].split("[")[0]
    lines = [line.split("#")[0].split("=") for line in body.splitlines() if "=" in line.split("#")[0]]
    return {key.strip(): json.loads(value) for key, value in lines}


def test_the_step_of_the_converter_is_repeated(tmp_path):
    file = paper_stand(tmp_path, block="converter_bits = 16\nrange_v = 10.0\n")
    result = tumble.solve(EXAMPLES / "paper_stand.csv", stand=file)
    assert result.document["stand"]["step_v"] == 10.0 / 2**15
    declared = tumble.read_stand(file)
    assert (stand_of(result.checked, "r"), step_of(result.checked)) == (declared.stand, declared.step_v)


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_drift_that_is_solved_for_is_repeated_as_well(estimator, tmp_path):
    """The solve has it as an unknown; a comparison still knows the stand of both, and each budget is of its model."""
    file = paper_stand(tmp_path, limits='"sigma1"\ndrift_v = 2e-3')
    told = [tumble.solve(EXAMPLES / "paper_stand.csv", stand=file, estimator=estimator, model=terms)
            for terms in ((), "drift")]
    assert [one.document["stand"]["drift_v"] for one in told] == [2e-3, 2e-3]
    assert told[0].document["stand"] == told[1].document["stand"]
    assert tumble.compare(*told, levelled="once").document["shared"]["sources"] == ["alpha1", "alpha2"]
    budgets = [expected(one.checked, built_in("paper"), stand_of(one.checked, "r"), 0.0) for one in told]
    assert ["drift" in budget.coefficients for budget in budgets] == [True, False]


@pytest.mark.parametrize("name", ["paper", "diagonal"])
def test_stand_and_schedule_are_read_back(name):
    file = "diagonal_stand" if name == "diagonal" else "paper_stand"
    result = tumble.solve(EXAMPLES / f"{file}.csv", stand=EXAMPLES / f"{file}.toml", schedule=name)
    assert schedule_of(result.checked, "r").data == built_in(name)
    assert stand_of(result.checked, "r") == tumble.read_stand(EXAMPLES / f"{file}.toml").stand
    bare = tumble.Result(json.dumps(calibrations.result(np.eye(3), np.zeros(3)))).checked
    assert (stand_of(bare, "r"), schedule_of(bare, "r"), step_of(bare)) == (None, None, 0.0)


@pytest.mark.parametrize(("key", "changed"), [
    ("stand", {"level_rad": -1.0}), ("stand", {"limits": "sigma2"}), ("stand", {"samples": 0}),
    ("stand", {"noise_v": "much"}), ("stand", {"limits": None}), ("schedule", {"position": [{"mounting": 1}]}),
    ("schedule", {"mounting": []}), ("schedule", {"name": 7}),
])
def test_what_no_solve_writes_is_refused(key, changed):
    document = tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml").document
    document[key] |= changed
    wrong = rf"(no )?{key}\.{next(iter(changed))}"
    with pytest.raises(BadInput, match=rf"^r: not a result of schema tumble\.result/1: {wrong}"):
        tumble.Result(json.dumps(document), name="r")


PLACE = {"mounting": 1, "position": 1, "angle_deg": 0, "use": "fit"}


@pytest.mark.parametrize(("key", "changed"), [("stand", {"level_rad": 1e10}), ("schedule", {"position": [PLACE] * 2})])
def test_what_no_solve_could_do_with_is_refused(key, changed):
    document = tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml").document
    document[key] |= changed
    with pytest.raises(BadInput, match=f"^r: its {key} is not as tumble solve writes it$"):
        {"stand": stand_of, "schedule": schedule_of}[key](tumble.Result(json.dumps(document)).checked, "r")


def test_without_a_stand_there_is_none():
    assert tumble.solve(EXAMPLES / "paper_stand.csv").document["stand"] is None


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_built_in_schedule_has_its_name(name):
    assert schedule_part(built_in(name)).name == name


def test_a_schedule_of_one_s_own_is_repeated_whole(tumble, tmp_path):
    """And what is written is a schedule file's tables: read again, it is the same schedule."""
    arguments = ["with_checks.csv", "--unit", "V", "--schedule", "with_checks.toml", "--estimator", "least_squares"]
    told = document_of(tumble("solve", *arguments, "--json", cwd=EXAMPLES))["schedule"]
    assert told["name"] is None and {one["use"] for one in told["position"]} == {"fit", "check"}
    lines = []
    for table in ("mounting", "position"):
        for row in told[table]:
            lines += [f"[[{table}]]", *(f"{key} = {json.dumps(value)}" for key, value in row.items())]
    again = tmp_path / "again.toml"
    again.write_text("\n".join(lines) + "\n")
    assert read_schedule(str(again)).data == read_schedule(str(EXAMPLES / "with_checks.toml")).data


def test_a_bench_run_repeats_both(tumble, tmp_path):
    stand = EXAMPLES / "diagonal_stand.toml"
    done = tumble("bench", "--stand", stand, "--schedule", "diagonal", "--out", tmp_path / "run", "--json")
    result = valid(done.stdout)
    assert result["schedule"]["name"] == "diagonal"
    assert result["stand"]["name"] == declared_keys(stand)["name"]
