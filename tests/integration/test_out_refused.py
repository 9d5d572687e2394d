"""What `--out` refuses, as docs/files.md lists it: exit 2, one line, nothing written, what was there untouched."""

import shutil

import pytest
from conftest import EXAMPLES, ROOT

from tumble.report.coefficients import FORMATS

pytestmark = pytest.mark.python
FILES = (ROOT / "docs/files.md").read_text(encoding="utf-8")
PAGE = FILES.partition("## What `--out` refuses")[2].partition("\n## ")[0]
ROWS = {  # arguments of the command, name of the output, what the line says
    "solve a table": (("solve", "run.csv"), "result.csv", "does not end in .json"),
    "solve, capitals": (("solve", "run.csv"), "RESULT.TOML", "does not end in .json"),
    "solve, its input": (("solve", "run.csv"), "run.csv", "is an input of this command"),
    "solve, its input by a link": (("solve", "run.csv"), "link", "is an input of this command"),
    "solve, a link": (("solve", "run.csv"), "link.json", "link.json: cannot be written: a symbolic link to"),
    "solve, a link to nothing": (("solve", "run.csv"), "nowhere.json", "cannot be written: a symbolic link to"),
    "export, a link": (("export", "result.json", "--format", "csv"), "link.csv", "a symbolic link to"),
    "apply, a link": (("apply", "result.json", "other/run.csv"), "link.csv", "cannot be written: a symbolic link to"),
    "draw, a link": (("draw", "stand"), "link.svg", "cannot be written: a symbolic link to"),
    "schedule, a link": (("plan", "schedule"), "link.toml", "cannot be written: a symbolic link to"),
    "solve, its stand": (("solve", "run.csv", "--stand", "stand.toml"), "stand.toml", "is an input of this command"),
    "solve, a folder": (("solve", "run.csv"), "folder", "cannot be written: a folder, not a file"),
    "solve, no such folder": (("solve", "run.csv"), "none/result.json", "cannot be written: no such file or folder"),
    "export as a table": (("export", "result.json", "--format", "c"), "k.csv", "does not end in .h or .c"),
    "export as ROS": (("export", "result.json", "--format", "ros"), "k.json", "does not end in .yaml or .yml"),
    "export, its input": (("export", "result.json", "--format", "c"), "result.json", "is an input of this command"),
    "export, capitals": (("export", "result.json", "--format", "C"), "k.h", "invalid choice: 'C'"),
    "draw": (("draw", "stand"), "stand.png", "does not end in .svg"),
    "apply": (("apply", "result.json", "run.csv"), "data.json", "does not end in .csv or .tsv"),
    "apply, its data": (("apply", "result.json", "run.csv"), "run.csv", "is an input of this command"),
    "apply, one name twice": (("apply", "result.json", "run.csv", "other/run.csv"), "folder", "have the same name"),
    "optimize": (("plan", "optimize"), "gains.csv", "ends in none of .json, .h, .bin"),
    "optimize, capitals": (("plan", "optimize"), "gains.JSON", "ends in none of .json, .h, .bin"),
    "schedule": (("plan", "schedule"), "s.json", "does not end in .toml"),
    "bench, a folder": (("bench",), "full", "is there already and is not an empty folder"),
    "bench, a file": (("bench",), "run.csv", "is there already and is not a folder"),
    "bench, no such folder": (("bench",), "none/run", "the folder cannot be made: make the folder none first"),
    "bench, a run goes on": (("bench",), "busy", "of a run that goes on or was killed"),
}  # fmt: skip


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    import tumble

    path = tmp_path_factory.mktemp("result") / "result.json"
    tumble.solve(str(EXAMPLES / "paper_stand.csv"), stand=str(EXAMPLES / "paper_stand.toml")).save(path)
    return path


@pytest.mark.parametrize("row", ROWS)
def test_it_is_refused(row, result, refused, tmp_path):
    for source, name in ((EXAMPLES / "paper_stand.csv", "run.csv"), (EXAMPLES / "paper_stand.toml", "stand.toml"),
                         (result, "result.json")):
        shutil.copy(source, tmp_path / name)
    for folder in ("folder", "full", "other", "none-of-it", ".busy.part"):
        (tmp_path / folder).mkdir()
    (tmp_path / "full/kept").write_text("kept")
    shutil.copy(tmp_path / "run.csv", tmp_path / "other/run.csv")
    (tmp_path / "link").symlink_to("run.csv")
    for suffix in ("json", "csv", "svg", "toml"):
        (tmp_path / f"link.{suffix}").symlink_to("kept.txt")
    (tmp_path / "kept.txt").write_text("kept")
    (tmp_path / "nowhere.json").symlink_to("nothing.json")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    arguments, out, said = ROWS[row]
    line = refused(*arguments, "--out", out, cwd=tmp_path)
    assert said in line, line
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_links_of_the_system_are_written_to(tumble, tmp_path):
    """And a link to a folder of the path is followed."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("folder")
    assert tumble("draw", "stand", "--out", "/dev/null").returncode == 0
    assert tumble("draw", "stand", "--out", tmp_path / "link/stand.svg").returncode == 0
    assert [path.name for path in (tmp_path / "folder").iterdir()] == ["stand.svg"]


def test_the_page_has_what_the_lines_say():
    for said in ("is an input of this command", "a symbolic link to",
                 "cannot be written: a folder, not a file", "does not end in .json",
                 "ends in none of", "is there already and is not an empty folder", "and is not a folder",
                 "of a run that goes on or was killed", "have the same name", "the folder cannot be made:"):
        assert said in PAGE, said
    for name, form in FORMATS.items():
        assert f"`{name}` {', '.join(form.endings)}" in PAGE, name
