"""`tumble draw`: on standard output or into a file; and the pictures of the pages show what it draws."""

import re
import shlex
import shutil
import subprocess
import sys
from xml.etree import ElementTree

import pytest
from conftest import ROOT
from drawn_schedules import SCHEDULES, odd_schedule

from tumble import pictures
from tumble.cli.main import main
from tumble.files.schedule_file import to_toml

pytestmark = pytest.mark.python

LINES = re.findall(r"^\$ tools/tumble (draw .*)$", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.MULTILINE)
SUBJECTS = ("stand", "mountings", "inclinations", "angles", "states", "wiring")


@pytest.mark.parametrize("line", LINES)
def test_the_pictures_of_the_pages_show_what_the_code_draws(line, capsys):
    """The same words at the same places, and as many shapes; another matplotlib may write them otherwise."""
    *words, option, file = shlex.split(line)
    assert option == "--out" and main(words) == 0
    drawn, shown = shapes_of(capsys.readouterr().out), shapes_of((ROOT / file).read_text(encoding="utf-8"))
    assert drawn[:2] == shown[:2], f"tools/tumble {line}"
    assert drawn[2] == pytest.approx(shown[2], abs=1.0)


def shapes_of(text):
    """Size, words and how many paths; the places of the words, pt."""
    root = ElementTree.fromstring(text)
    tags = [one.tag.rpartition("}")[2] for one in root.iter()]
    texts = [one for one in root.iter() if one.tag.rpartition("}")[2] in ("title", "desc", "text")]
    places = [float(one.get(key)) for one in texts if one.get("x") for key in "xy"]
    return [one.text for one in texts], (tags.count("path"), tags.count("use")), places


def pages():
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")]


def test_every_picture_is_on_a_page_and_every_page_has_its_pictures():
    made = {(ROOT / shlex.split(line)[-1]).resolve() for line in LINES}
    shown = {(page.parent / target).resolve() for page in pages()
             for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", page.read_text(encoding="utf-8"))}  # fmt: skip
    assert len(made) == len(LINES) >= 5 and made <= shown
    assert not [file for file in shown if not file.is_file()]
    drawn = {file for file in shown if file.suffix == ".svg"}  # beside them pages show the screen
    others = {ROOT / "docs/sample-way.svg", ROOT / "docs/parabola.svg"}  # of a run: test_inclined.py draws it
    assert drawn <= made | others
    assert {shlex.split(line)[1] for line in LINES} == set(SUBJECTS)


@pytest.mark.skipif(shutil.which("git") is None, reason="git is not installed")
def test_pictures_that_pages_show_are_committed():
    listed = subprocess.run(["git", "ls-files", "docs"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode or not listed.stdout:
        pytest.skip("not a checkout")
    assert {shlex.split(line)[-1] for line in LINES} <= set(listed.stdout.splitlines())


@pytest.mark.parametrize("subject", SUBJECTS)
def test_standard_output_and_file_hold_the_same(subject, tumble, tmp_path):
    words = ("draw", subject, *(("--schedule", "inclined") if subject == "inclinations" else ()))
    printed, written = tumble(*words), tumble(*words, "--out", tmp_path / "picture.svg")
    assert (printed.returncode, printed.stderr) == (written.returncode, written.stderr) == (0, "")
    assert written.stdout == "" and (tmp_path / "picture.svg").read_text() == printed.stdout
    arguments = {"states": (), "wiring": (), "angles": (SCHEDULES["paper"], 1),
                 "inclinations": (SCHEDULES["inclined"],)}  # fmt: skip
    assert printed.stdout == pictures.svg(getattr(pictures, subject)(*arguments.get(subject, (SCHEDULES["paper"],))))


@pytest.mark.parametrize("name", ["three_mountings", "diagonal", "six_faces"])
def test_built_in_schedules_by_name(name, capsys):
    assert main(["draw", "mountings", "--schedule", name]) == 0
    assert capsys.readouterr().out == pictures.svg(pictures.mountings(SCHEDULES[name]))


def test_a_schedule_of_ones_own(tmp_path, capsys):
    (tmp_path / "own.toml").write_text(to_toml(odd_schedule()))
    for words in (["mountings"], ["angles", "--mounting", "200"], ["angles"]):
        assert main(["draw", *words, "--schedule", str(tmp_path / "own.toml")]) == 0
        figure = (pictures.mountings(odd_schedule()) if words == ["mountings"] else
                  pictures.angles(odd_schedule(), 200 if len(words) > 1 else 1))  # fmt: skip
        assert capsys.readouterr().out == pictures.svg(figure)


REFLECTED = "[[mounting]]\nnumber = 1\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\n[[position]]\nmounting = 1\n" \
            "position = 1\nangle_deg = 0\n"  # fmt: skip


@pytest.mark.parametrize(("text", "said"), [
    ("[[mounting]]\nnumber = 1\nmatrix = [1, 2\n", "bad.toml: row 4: not valid TOML: unclosed array"),
    (REFLECTED, "bad.toml: row 1: [[mounting]] is refused: a mounting matrix is not a proper rotation"),
    (REFLECTED.replace("-1]]", "1]]").replace("angle_deg = 0", "angle_deg = 1e9"),
     "bad.toml: row 7: [[position]] angle_deg must be -3600"),
    (REFLECTED.replace("-1]]", "1]]"), "bad.toml: these positions cannot identify K_xx"),
])  # fmt: skip
@pytest.mark.parametrize("subject", ["stand", "mountings", "angles"])
def test_a_bad_schedule_is_one_line_that_says_where(subject, text, said, tmp_path, refused):
    (tmp_path / "bad.toml").write_text(text)
    complaint = refused("draw", subject, "--schedule", "bad.toml", "--out", tmp_path / "out.svg", cwd=tmp_path)
    assert said in complaint


@pytest.mark.parametrize(("words", "said"), [
    (("angles", "--mounting", "3"), "no mounting 3 in this schedule, which has 1, 2"),
    (("angles", "--mounting", "x"), "--mounting: 'x' is not a whole number from 1 to 255"),
    (("states", "--schedule", "paper"), "unrecognized arguments: --schedule paper (see tumble draw states --help)"),
    (("stand", "--schedule", "no_such.toml"), "no_such.toml: no such file or folder"),
    (("stand", "--out", "no/such/folder.svg"), "no/such/folder.svg: cannot be written"),
    (("block",), "invalid choice: 'block'"),
    ((), "the following arguments are required: SUBJECT"),
])  # fmt: skip
def test_bad_words_are_refused(words, said, tmp_path, refused):
    assert said in refused("draw", *words, cwd=tmp_path)


def test_the_schedule_is_not_overwritten(tmp_path, refused):
    (tmp_path / "own.toml").write_text(to_toml(odd_schedule()))
    assert "is an input" in refused("draw", "stand", "--schedule", "own.toml", "--out", "own.toml", cwd=tmp_path)
    assert (tmp_path / "own.toml").read_text() == to_toml(odd_schedule())


def test_without_matplotlib_a_drawing_is_refused_in_a_line(tumble, without_matplotlib, tmp_path):
    done = tumble("draw", "stand", "--out", tmp_path / "x.svg", **without_matplotlib)
    assert (done.returncode, done.stdout) == (77, "") and not (tmp_path / "x.svg").exists()
    assert done.stderr == "tumble: draw needs matplotlib: tools/setup plot\n"


def test_words_of_poses_need_no_library_for_drawing():
    """They are asked for on a bench."""
    program = "import sys, tumble.poses, tumble.firmware_tables; print(*(one.split('.')[0] for one in sys.modules))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    heavy = {"matplotlib", "jinja2", "pandas", "rich", "PIL", "weasyprint", "_tumble_core"}
    assert not heavy & set(done.stdout.split()) and done.stderr == ""
