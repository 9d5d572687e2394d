"""`tumble compare`: what it warns of, what it refuses, what scripts call, and its picture."""

import dataclasses
import json
import re
import shlex
import sys

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from calibrations import U, result
from conftest import EXAMPLES, ROOT
from documents import valid
from test_readme import shows

import tumble as package
from tumble import model
from tumble.cli.main import main
from tumble.errors import BadInput, UsageError
from tumble.files.stand_file import read_stand

pytestmark = [pytest.mark.python, pytest.mark.toolchain]
U0 = np.array([0.01, -0.02, 0.03])
JOINT = np.diag(U**2)
STAND = EXAMPLES / "paper_stand.toml"


@pytest.fixture
def files(tmp_path):
    """Write a.json and b.json, of one calibration but for these keys; returns their names."""

    def write(a=None, b=None):
        for name, more in (("a", a or {}), ("b", b or {})):
            (tmp_path / f"{name}.json").write_text(json.dumps({**result(NOMINAL_K, U0, JOINT), **more}))
        return "a.json", "b.json"

    return write


WARNINGS = {
    "serial differs, 'B-17' and 'B-18': not one block?": ({"serial": "B-17"}, {"serial": "B-18"}),
    "item.block_serial differs, 'x' and 'y': not one block?": (
        {"item": {"block_serial": "x", "operator": "A"}},
        {"item": {"block_serial": "y", "operator": "B"}},
    ),
    "A at 20 to 21 deg C, B at 23.5 deg C: temperature alone changes a block": (
        {"temperature": {"min_c": 20.0, "max_c": 21.0, "source": "run_file"}},
        {"temperature": {"min_c": 23.5, "max_c": 23.5, "source": "environment"}},
    ),
    "both are of one run: its noise is in both, but is counted as independent": (
        {"run_sha256": "0" * 64},
        {"run_sha256": "0" * 64},
    ),
}


def test_what_contradicts_itself_is_refused_in_python_too():
    result = package.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml")
    with pytest.raises(UsageError, match=r"^schedule: serves to tell what the stand brings"):
        package.compare(result, result, schedule="nosuch.toml")
    with pytest.raises(UsageError, match=r"^two_stands: nothing is shared then"):
        package.compare(result, result, stand=EXAMPLES / "paper_stand.toml", two_stands=True)
    with pytest.raises(UsageError, match=r"^confidence: 'x' is not a number"):
        package.compare(result, result, confidence="x")


@pytest.mark.parametrize("said", WARNINGS)
def test_it_warns_and_says_so_in_the_document(said, files, tumble, tmp_path):
    done = tumble("compare", *files(*WARNINGS[said]), "--json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, f"tumble: warning: {said}\n")
    assert valid(done.stdout, "comparison")["warnings"] == [said]


FAILED = {"verification": {"pass": False, "max_abs_delta_g_g": 1e-3, "limit_g": 3e-4}, "pass": False}
SCALED = {"K": (NOMINAL_K * (1 + 2e-4 * np.eye(3)[1])[:, None]).tolist()}
TURNED = {"K": (NOMINAL_K @ np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])).tolist()}
BY_NUMBERS = {
    "unchanged": ({}, "no change of the block or of its seat is detectable."),
    "seat": (TURNED, "the block is as it was, but sits turned by "),
    "block": (SCALED, "the block has changed: scale y +200 +- 14 ppm."),
}


@pytest.mark.parametrize("apparent", BY_NUMBERS)
def test_of_a_result_that_failed_nothing_firm_is_said(apparent, files, tumble, tmp_path):
    moved, said = BY_NUMBERS[apparent]
    done = tumble("compare", *files({}, {**moved, **FAILED}), cwd=tmp_path)
    check = "tumble: warning: b.json: the gravity check FAILED: largest error 0.001 g, limit 0.0003 g\n"
    assert (done.returncode, done.stderr) == (1, check)
    first = done.stdout.split("\n\n")[0].replace("\n", " ")
    assert first.startswith(
        f"CANNOT TELL: b.json FAILED its check: nothing firm can be said. By the numbers alone, {said}"
    )
    assert "\nB: b.json, FAILED, refined\n" in done.stdout and max(map(len, done.stdout.splitlines())) <= 80
    found = package.compare(tmp_path / "a.json", tmp_path / "b.json")
    told = valid(found.to_json(), "comparison")
    assert (found.verdict, found.block_changed, found.changed, told["explained_by"]) == ("cannot tell", None, (), None)
    assert (told["apparent"], told["a"]["pass"], told["b"]["pass"]) == (apparent, True, False)
    assert not any(row["changed"] for row in told["parameters"]) and told["tests"] is not None
    assert found.sentence.startswith(f"CANNOT TELL: {tmp_path}/b.json FAILED its check:")


def test_a_run_that_does_not_fit_its_stand_has_failed_too(files):
    same = json.dumps(result(NOMINAL_K, U0, JOINT))
    fit = {"chi2": 99.0, "dof": 42, "p": 1e-6, "fits": False, "confidence": 0.999, "explanations": []}
    misfit = package.Result(json.dumps({**json.loads(same), "pass": False, "fit": fit}))
    assert package.compare(misfit, package.Result(same)).sentence.startswith("CANNOT TELL: A FAILED its check:")
    assert package.compare(misfit, misfit).sentence.startswith("CANNOT TELL: A and B FAILED their checks:")
    unsure = package.Result(json.dumps(result(NOMINAL_K, U0)))
    found = package.compare(misfit, unsure)
    said = "CANNOT TELL: B has no uncertainties: solve its run again with stand=."
    assert found.sentence.startswith(said) and found.sentence.endswith(" And A FAILED its check.")
    assert found.document["apparent"] is None


def test_a_result_that_is_not_shown_is_compared_and_told(files, tumble, tmp_path):
    rule = {"coverage_factor": 3.0, "u_norm_worst_g": 1.5e-4, "limit_g": 3e-4, "scope": "everywhere"}
    not_shown = {"pass": False, "pass_reason": "uncertainty", "decision": rule}
    done = tumble("compare", *files({}, not_shown), cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.startswith("UNCHANGED: ")
    assert "\nB: b.json, NOT SHOWN, refined\n" in done.stdout and "\nA: a.json, refined\n" in done.stdout
    told = valid(tumble("compare", "a.json", "b.json", "--json", cwd=tmp_path).stdout, "comparison")
    assert (told["a"]["pass"], told["a"]["pass_reason"]) == (True, None)
    assert (told["b"]["pass"], told["b"]["pass_reason"]) == (False, "uncertainty")
    done = tumble("compare", *files(not_shown, FAILED), cwd=tmp_path)
    assert done.returncode == 1 and done.stdout.startswith("CANNOT TELL: b.json FAILED its check:")
    assert "\nA: a.json, NOT SHOWN, refined\n" in done.stdout and "\nB: b.json, FAILED, refined\n" in done.stdout


def test_each_is_told_in_words_of_its_own(files, tumble, tmp_path):
    """Options on the command line, arguments in Python; in the document those of the command line."""
    names = files({}, {"warnings": ["the block is not linear: solve it with --model k2,drift"]})
    done = tumble("compare", *names, cwd=tmp_path)
    assert done.stderr == "tumble: warning: b.json: the block is not linear: solve it with --model k2,drift\n"
    assert "u is too large then (--stand FILE)." in done.stdout.replace("\n  ", " ")
    found = package.compare(*(package.load(tmp_path / name) for name in names))
    assert found.warnings == ('B: the block is not linear: solve it with model="k2,drift"',)
    assert found.notes[0].endswith("u is too large then (stand=).") and "--" not in found.text
    assert "(stand=)" in found.text.replace("\n  ", " ")
    assert found.document["warnings"] == ["B: the block is not linear: solve it with --model k2,drift"]
    assert main(["compare", *(str(tmp_path / name) for name in names), "--json"]) == 0
    with pytest.raises(BadInput, match=r"paper_stand\.toml: is a stand file \(stand=\), not a schedule file$"):
        package.compare(*(tmp_path / name for name in names), stand=STAND, schedule=STAND)
    refusal = tumble("compare", *names, "--stand", STAND, "--schedule", STAND, cwd=tmp_path).stderr
    assert refusal == f"tumble: {STAND}: is a stand file (--stand), not a schedule file\n"


OLD, NEW = "2025-03-01", "2026-05-01"
EXCHANGED = "exchanged? A is to be the earlier one"


@pytest.mark.parametrize("table", ["item", "environment"])
def test_runs_in_the_wrong_order_are_warned_of(table, files, tumble, tmp_path):
    """By the days of the runs, whenever they were solved."""
    old, new = ({table: {"Run date": day}, "created": "2026-06-01T00:00:00Z"} for day in (OLD, NEW))
    done = tumble("compare", *files(new, old), cwd=tmp_path)
    assert done.stderr == f"tumble: warning: A was measured on {NEW}, B before, on {OLD}: {EXCHANGED}\n"
    later = {**old, "created": "2026-07-01T00:00:00Z"}
    done = tumble("compare", *files(later, new), cwd=tmp_path)
    assert done.stderr == "" and "exchanged?" not in done.stdout and "dated" not in done.stdout


def test_results_in_the_wrong_order_or_without_a_date_are_told(files, tumble, tmp_path):
    """When they were solved says less: a run may be solved anew."""
    old, new = ({"created": f"{day}T12:00:00Z"} for day in (OLD, NEW))
    done = tumble("compare", *files(new, old), cwd=tmp_path)
    said = f"A was solved after B, on {NEW} and {OLD}: {EXCHANGED}"
    assert done.stderr == "" and f"- {said}" in " ".join(done.stdout.split())
    assert "solved after" not in tumble("compare", *files(old, new), cwd=tmp_path).stdout
    undated = "Not both results are dated: that A is the earlier one is taken on trust."
    for pair in ((old, {"created": None}), ({"created": None}, new), ({"created": None}, {"created": None})):
        assert undated in " ".join(tumble("compare", *files(*pair), cwd=tmp_path).stdout.split())


SILENT = [
    ({"serial": "B-17"}, {"serial": None}),
    ({"item": {"serial": "x", "date": "1"}}, {"item": {"serial": "x", "date": "2"}}),
    ({"temperature": {"min_c": 20.0, "max_c": 21.0}}, {"temperature": {"min_c": 22.0, "max_c": 23.0}}),
]


@pytest.mark.parametrize("pair", SILENT)
def test_it_does_not_warn_of_what_may_well_be(pair, files, tumble, tmp_path):
    done = tumble("compare", *files(*pair), "--json", cwd=tmp_path)
    assert (done.returncode, done.stderr, valid(done.stdout, "comparison")["warnings"]) == (0, "", [])


def extended(k2, terms=("k2",)):
    """As a result of --model k2 or k2,drift has it."""
    count = 3 * len(terms)
    joint = np.zeros((12 + count, 12 + count))
    joint[:12, :12], joint[12:, 12:] = JOINT, 1e-10 * np.eye(count)
    empty = dict.fromkeys(f"{u}{key}" for u in ("", "u_") for key in ("k2_per_g", "k3_per_g2", "drift_v"))
    found = {**empty, "terms": list(terms), "k2_per_g": k2, "u_k2_per_g": [1e-5] * 3, "covariance": joint.tolist()}
    return {"extended": {**found, **({"drift_v": [1.0] * 3, "u_drift_v": [1e-5] * 3} if "drift" in terms else {})}}


def test_k2_of_both_is_compared_and_a_drift_is_not(files, tumble, tmp_path):
    pair = extended([1e-4, 0.0, 0.0]), extended([2e-4, 0.0, 0.0], ("k2", "drift"))
    done = tumble("compare", *files(*pair), "--json", cwd=tmp_path)
    found = valid(done.stdout, "comparison")
    assert (done.returncode, done.stderr, found["verdict"], found["changed"]) == (1, "", "block", ["K2_x"])
    row = found["parameters"][9]
    assert (row["name"], row["unit"], len(found["parameters"])) == ("K2_x", "ug/g^2", 12)
    assert (row["difference"], row["u"]) == pytest.approx((100.0, np.sqrt(2) * 10.0), rel=1e-9)
    assert found["tests"]["block"]["dof"] == 12
    assert "A drift is the run's and not the block's: it is not compared." in found["notes"]


def test_k2_of_one_alone_is_told(files, tumble, tmp_path):
    done = tumble("compare", *files({}, extended([1e-4] * 3)), "--json", cwd=tmp_path)
    assert done.stderr == (
        "tumble: warning: k2 is in the model of B alone: the others mean something else with it\n"
    )
    assert (done.returncode, len(valid(done.stdout, "comparison")["parameters"])) == (0, 9)


REFUSED = {
    "b.json: outputs in mV, those of a.json in V: not compared": ({"unit": "mV"}, ()),
    "b.json: K is singular: it tells no acceleration": ({"K": [[1.0, 0.0, 0.0]] * 3}, ()),
    "b.json: not a result of schema tumble.result/1: schema is 'tumble.plan/1'": ({"schema": "tumble.plan/1"}, ()),
    "b.json: not a result of schema tumble.result/1: no stand.limits": ({"stand": {"name": "s"}}, ()),
    "b.json: not a result of schema tumble.result/1: schedule.mounting is '[]'": (
        {"schedule": {"name": None, "mounting": [], "position": [{"mounting": 1}]}},
        ("--stand", str(STAND)),
    ),
    "b.json: its covariance is none: of some mixture of the coefficients it is negative": (
        {"covariance": (JOINT - 0.5 * np.outer(U, U)).tolist()},
        (),
    ),
    "--confidence: '1' is not a number from 0.5 to 0.999999": ({}, ("--confidence", "1")),
    "--schedule serves to tell what the stand brings to a result: it needs --stand FILE": ({}, ("--schedule", "paper")),
    "--two-stands: nothing is shared then, which --stand and --levelled speak of": (
        {},
        ("--two-stands", "--levelled", "once"),
    ),
    "--plot: 'x.txt' does not end in .png, .svg or .pdf": ({}, ("--plot", "x.txt")),
    "--plot: 'b.json' is an input of this command": ({}, ("--plot", "b.json")),
    "none.toml: no such file or folder": ({}, ("--stand", "none.toml")),
}


@pytest.mark.parametrize("said", REFUSED)
def test_it_refuses(said, files, refused, tmp_path):
    more, options = REFUSED[said]
    first = {"stand": {**declared(read_stand(str(STAND)).stand)}} if "stand" in more else {}
    assert refused("compare", *files(first, more), *options, cwd=tmp_path) == f"tumble: {said}\n"


def declared(stand):
    """The stand as results repeat it."""
    labels = {"name": stand.name, "limits": stand.limits, "remount": stand.remounting, "samples": stand.samples}
    angles = ("axis_tilt", "level", "remount", "angle", "seat", "platform", "encoder")
    volts = {"noise_v": stand.noise, "drift_v": stand.drift}
    return {**labels, **{f"{angle}_rad": getattr(stand, angle) for angle in angles}, **volts}


def schedule_document(schedule):
    """The schedule likewise."""
    mountings = [
        {"number": one.number, "matrix": [list(row) for row in one.matrix], "axis_tilt_deg": one.tilt_deg}
        for one in schedule.mountings
    ]
    positions = [
        {"mounting": one.mounting, "position": one.number, "angle_deg": one.angle_deg, "use": one.use}
        for one in schedule.positions
    ]
    return {"name": None, "mounting": mountings, "position": positions}


@pytest.fixture
def told(tmp_path):
    """Two solved results that tell their stand and schedule: a.json, b.json."""
    schedule = model.built_in("paper")
    for name, seed in (("a", 1), ("b", 2)):
        noise = 3e-4 / 50**0.5 * np.random.default_rng(seed).standard_normal((18, 3))
        run = write_run(tmp_path / f"{name}.csv", schedule, model.Geometry(schedule).outputs(NOMINAL_K, U0) + noise)
        document = package.solve(run, stand=STAND).document
        document |= {"stand": declared(read_stand(str(STAND)).stand), "schedule": schedule_document(schedule)}
        (tmp_path / f"{name}.json").write_text(json.dumps(document))
    return tmp_path / "a.json", tmp_path / "b.json"


def test_the_stand_that_both_declare_is_taken(told):
    name, by_file = read_stand(str(STAND)).stand.name, package.compare(*told, stand=STAND, levelled="once")
    found = package.compare(*told, levelled="once")
    assert found.document["shared"] == {"stand": name, "levelled": "once", "sources": ["alpha1", "alpha2"]}
    u, same = ([row["u"] for row in one.document["coefficients"]] for one in (found, by_file))
    assert u == pytest.approx(same, rel=1e-12)
    apart = package.compare(*told, two_stands=True).document
    assert apart["shared"] == {"stand": None, "levelled": None, "sources": None}
    assert apart["coefficients"][10]["u"] > 1.3 * u[10]
    because = "No stand error is common to both runs, because the stand was levelled again."
    assert package.compare(*told).document["notes"][0] == because


PAPER = read_stand(str(STAND)).stand
ERRORS = {f.name: getattr(PAPER, f.name) for f in dataclasses.fields(PAPER) if f.type in ("float", "PerChannel")}
ONE = {
    "more samples in a mean": {"samples": 200},
    "another block's noise": {"noise": 2e-4},
    "a drift": {"drift": 1e-5},
    "a better clamp": {"remount": 2e-4, "seat": 1e-5},
    "a yaw that all mountings share": {"remounting": "common"},
    "three standard deviations": {"limits": "sigma3", **{name: 3.0 * size for name, size in ERRORS.items()}},
}
TWO = {
    "another name": {"name": "the stand upstairs"},
    "no name": {"name": ""},
    "another axis": {"axis_tilt": 3e-5},
    "another level": {"level": 3e-5},
    "a table that is set otherwise": {"angle": 3e-5},
    "a platform": {"platform": 1e-5},
    "an encoder": {"encoder": 1e-5},
    "the same numbers, meant otherwise": {"limits": "sigma3"},
}


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """A run of means, solved with the paper's stand but for these fields."""
    schedule = model.built_in("paper")
    outputs = model.Geometry(schedule).outputs(NOMINAL_K, U0)
    run = write_run(tmp_path_factory.mktemp("means") / "means.csv", schedule, outputs)
    return lambda **fields: package.solve(run, stand=dataclasses.replace(PAPER, **fields))


@pytest.mark.parametrize("otherwise", ONE)
def test_what_is_the_runs_own_makes_no_second_stand(otherwise, solved):
    found = package.compare(solved(), solved(**ONE[otherwise]), levelled="once").document
    assert found["shared"] == {"stand": PAPER.name, "levelled": "once", "sources": ["alpha1", "alpha2"]}
    by_file = package.compare(solved(), solved(**ONE[otherwise]), stand=STAND, levelled="once").document
    assert by_file["shared"]["sources"] == ["alpha1", "alpha2"]
    u = np.array([[row["u"] for row in one["coefficients"]] for one in (found, by_file)])
    assert u[0] == pytest.approx(u[1], rel=1e-9)


def test_a_stand_that_is_written_otherwise_gives_the_same_uncertainties(solved):
    same, written = (
        package.compare(solved(), solved(**fields), levelled="once").document["coefficients"]
        for fields in ({}, ONE["three standard deviations"])
    )
    assert [row["u"] for row in written] == pytest.approx([row["u"] for row in same], rel=1e-9)


@pytest.mark.parametrize("otherwise", TWO)
def test_two_stands_that_are_declared_otherwise_are_two(otherwise, solved):
    found = package.compare(solved(), solved(**TWO[otherwise]), levelled="once").document
    assert found["shared"] == {"stand": None, "levelled": None, "sources": None}


def test_scripts_get_what_the_command_prints(told, capsys):
    first = package.load(told[0])
    found = package.compare(first, str(told[1]))
    assert (found.verdict, found.block_changed, found.changed, found.warnings) == ("unchanged", False, (), ())
    assert repr(found) == f"<tumble.Comparison {told[1]} with A: unchanged>"
    assert main(["compare", *map(str, told), "--json"]) == 0
    assert capsys.readouterr().out.replace(f'"file": "{told[0]}"', '"file": "A"') == found.to_json()
    assert json.loads(found.to_json()) == found.document
    assert main(["compare", *map(str, told)]) == 0
    printed = capsys.readouterr().out
    assert printed.split("\n\n")[2:] == found.text.split("\n\n")[2:] and printed.split("\n")[0] == found.sentence
    assert package.compare(first, package.Result(json.dumps(result(NOMINAL_K, U0)))).block_changed is None


@pytest.mark.parametrize(
    ("arguments", "kind", "said"),
    [
        ({"levelled": "twice"}, UsageError, "levelled: 'twice' is not one of once, anew"),
        ({"confidence": 0.2}, UsageError, "confidence: '0.2' is not a number from 0.5 to 0.999999"),
        ({"stand": 3}, UsageError, "stand: a int is neither the path of a stand file nor a tumble.Stand"),
        ({"stand": "none.toml"}, BadInput, "none.toml: no such file or folder"),
        ({"b": 3}, UsageError, "B: a int is neither a tumble.Result nor the path of one"),
    ],
)
def test_scripts_are_told_what_is_wrong(arguments, kind, said):
    same = package.Result(json.dumps(result(NOMINAL_K, U0, JOINT)))
    with pytest.raises(kind) as error:
        package.compare(same, **{"b": same, **arguments})
    assert str(error.value) == said


@pytest.mark.parametrize("kind", ["svg", "png", "pdf"])
def test_the_picture_is_drawn(kind, files, tumble, tmp_path):
    pytest.importorskip("matplotlib")
    done = tumble("compare", *files({}, {"U0": [0.02, -0.02, 0.03]}), "--plot", f"p.{kind}", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    start = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}[kind]
    assert (tmp_path / f"p.{kind}").read_bytes().startswith(start)


def test_without_matplotlib_a_picture_is_skipped(files, tumble, monkeypatch, capsys, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["compare", *files(), "--plot", "p.svg"]) == 77
    said = f"tumble: --plot needs matplotlib: {ROOT}/tools/setup plot\n"  # from another folder
    assert capsys.readouterr() == ("", said) and not (tmp_path / "p.svg").exists()


def test_its_help_fits_eighty_columns(tumble):
    done = tumble("compare", "--help", COLUMNS="80")
    assert done.returncode == 0 and max(map(len, done.stdout.splitlines())) <= 80


@pytest.mark.slow
def test_the_page_shows_what_is_printed(tumble, tmp_path):
    page = (ROOT / "docs/files.md").read_text(encoding="utf-8").partition("\n## Compare two calibrations\n")[2]
    commands, shown = re.search(r"```console\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL).groups()
    (tmp_path / "examples").symlink_to(EXAMPLES)
    done = [tumble(*shlex.split(line)[2:], cwd=tmp_path) for line in commands.splitlines()]
    assert [one.returncode for one in done] == [0, 0, 0]
    assert shows(shown, done[-1].stdout)
