"""What commands say of a wrong word or a wrong file: which formats, names and files there are."""

import json
import os
import pty
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

from tumble.schedule import BUILT_IN

pytestmark = pytest.mark.python

NAMES = f"nor a built-in schedule: these are {', '.join(BUILT_IN)}"
TOML, JSON = "TOML, such as a stand or a schedule file", "a result of tumble solve (JSON) is expected"
WANTED = "TOML is expected, such as a stand or a schedule file"

RUN, STAND = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"
HAND_HELD = EXAMPLES / "hand_held_session.csv"
FACES = ("--schedule", EXAMPLES / "hand_laid_faces.toml", "--repeats", "first", "--rate", "102.4")


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    from tumble.cli.main import main

    file = tmp_path_factory.mktemp("words") / "result.json"
    assert main(["solve", str(RUN), "--unit", "V", "--out", str(file)]) == 0
    return file


@pytest.mark.parametrize(
    ("command", "out", "endings"),
    [
        (("solve", RUN), "x.csv", ".json"),
        (("draw", "stand"), "x.png", ".svg"),
        (("draw", "states"), "x.PDF", ".svg"),
        (("import", HAND_HELD), "x.json", ".csv"),
        (("apply", "RESULT", RUN), "x.pdf", ".csv or .tsv"),
        (("export", "RESULT", "--format", "c"), "x.csv", ".h or .c"),
        (("export", "RESULT", "--format", "ros"), "x.json", ".yaml or .yml"),
        (("report", "RESULT"), "x.json", ".html or .pdf"),
        (("plan", "schedule"), "x.json", ".toml"),
    ],
)
def test_an_output_is_not_called_what_it_is_not(command, out, endings, refused, result, tmp_path):
    words = [result if word == "RESULT" else word for word in command]
    line = refused(*words, "--out", out, cwd=tmp_path)
    assert line.endswith(f"--out: '{out}' does not end in {endings}\n") and not os.listdir(tmp_path)


def test_a_name_that_promises_no_format_is_taken(tumble, tmp_path):
    assert tumble("draw", "states", "--out", "picture", cwd=tmp_path).returncode == 0
    assert (tmp_path / "picture").read_text().startswith("<svg")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("report", RUN), f"is CSV, such as a run file; {JSON}"),
        (("apply", STAND, RUN), f"is {TOML}; {JSON}"),
        (("compare", RUN, RUN), f"is CSV, such as a run file; {JSON}"),
        (("solve", "RESULT"), "row 1: is JSON, such as a result, and no run file"),
        (("solve", STAND), f"row 3: is {TOML}, and no run file"),
        (("solve", RUN, "--stand", RUN), f"is CSV, such as a run file; {WANTED}"),
        (("solve", RUN, "--schedule", "RESULT"), f"is JSON, such as a result; {WANTED}"),
        (("solve", RUN, "--schedule", "sixfaces"), f"sixfaces: no such file or folder, {NAMES}; is six_faces meant?"),
        (("draw", "stand", "--schedule", "my.toml"), f"my.toml: no such file or folder, {NAMES}"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_called_what_it_looks_like(words, said, refused, result):
    assert refused(*(result if word == "RESULT" else word for word in words)).endswith(f"{said}\n")


@pytest.mark.parametrize(
    ("factor", "unit"),
    [(1.0, "m/s^2: --unit m/s^2"), (1 / 9.81, "g, or volts of a sensor of 1 V/g: --unit g or V"),
     (1000 / 9.81, "mg, or mV of a sensor of 1 V/g: --unit mg or mV"), (0.3, None)],
)  # fmt: skip
def test_import_says_what_outputs_without_a_unit_look_like(factor, unit, tumble, tmp_path):
    table = np.loadtxt(HAND_HELD, delimiter=",", skiprows=1)[:, 1:] * factor
    np.savetxt(tmp_path / "log.csv", table, "%.7g", delimiter=",", header="ux,uy,uz", comments="")
    done = tumble("import", tmp_path / "log.csv", *FACES, "--signs", "+++", "--json")
    (note,) = [one for one in json.loads(done.stdout)["assumed"] if one.startswith("unit: ")]
    expected = f"which looks like {unit})" if unit else "names none either (--unit)"
    assert note.endswith(expected)


@pytest.mark.parametrize("signs", ["-++", "+--", "---", "--+"])
def test_signs_may_begin_with_a_minus(signs, tumble, tmp_path):
    table = np.loadtxt(HAND_HELD, delimiter=",", skiprows=1)[:, 1:] * [1.0 if sign == "+" else -1.0 for sign in signs]
    np.savetxt(tmp_path / "log.csv", table, "%.7g", delimiter=",", header="ux,uy,uz", comments="")
    done = tumble("import", tmp_path / "log.csv", *FACES, "--signs", signs, "--unit", "m/s^2", "--json")
    assert done.returncode == 0, done.stderr
    assert np.sign(np.diag(json.loads(done.stdout)["K"])).tolist() == [1.0 if sign == "+" else -1.0 for sign in signs]


@pytest.mark.parametrize("arguments, said", [
    (("draw", "states"), "a picture is no text for a terminal: --out FILE.svg"),
    (("report", "result.json"), "a page is no text for a terminal: --out FILE.html or --out FILE.pdf"),
])
def test_what_is_no_text_does_not_flood_a_terminal(arguments, said):
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "tumble", *arguments]
    done = subprocess.run(command, stdout=theirs, stderr=subprocess.PIPE, text=True, cwd=ROOT)
    os.close(theirs)
    os.close(ours)
    assert (done.returncode, done.stderr) == (2, f"tumble: {said}\n")


def test_many_named_mountings_are_refused_at_once():
    from tumble.importing import labels
    from tumble.importing.match import Doubtful
    from tumble.schedule import Mounting, Schedule

    schedule = Schedule(tuple(Mounting(number, ()) for number in range(1, 11)), ())
    names = [f"name {letter}" for letter in "abcdefghij"]
    with pytest.raises(
        Doubtful, match=r"10 mountings have names, too many to try .* --mountings name a=N,name b=N,... and leave"
    ):
        next(labels._ways(names, schedule, {}))
    told = {name: number for number, name in enumerate(names[:4], 1)}
    assert len(list(labels._ways(names, schedule, told))) == 720


@pytest.mark.parametrize(
    ("label", "value"),
    [
        ("POS-3", 3),
        ("Pos 3", 3),
        ("-45°", -45),
        ("at -45", -45),
        ("P_7", 7),
        ("1-2", 1),
        ("-22,5 deg", -22.5),
        ("x", None),
    ],
)
def test_numbers_of_labels(label, value):
    from tumble.importing import labels

    assert labels._value(label) == value
