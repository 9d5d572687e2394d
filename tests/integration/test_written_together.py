"""Commands that write several files write all of them or none, and what was there before stays."""

import os

import pytest
from conftest import EXAMPLES

from tumble.cli.main import main
from tumble.errors import BadInput, TumbleError
from tumble.files import disk

pytestmark = pytest.mark.python

HAND_HELD = ("--schedule", "six_faces", "--order", "any", "--signs=+++", "--repeats", "first", "--rate", "102.4")


def contents(folder):
    """All files, hidden ones too, and what is in them."""
    return {path.name: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def files(folder):
    return {str(folder / "a"): b"new a", str(folder / "b"): b"new b", str(folder / "c"): b"new c"}


def test_all_are_written(tmp_path):
    (tmp_path / "b").write_bytes(b"old b")
    (tmp_path / "b").chmod(0o640)
    disk.write_all(files(tmp_path))
    assert contents(tmp_path) == {"a": b"new a", "b": b"new b", "c": b"new c"}
    assert (tmp_path / "b").stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize("failing", range(3))
@pytest.mark.parametrize("linked", [True, False])
@pytest.mark.parametrize("there", [(), ("a", "b", "c"), ("b",)])
def test_where_one_cannot_be_put_in_place_all_is_as_before(failing, linked, there, tmp_path, monkeypatch):
    """As in a folder of which files of others cannot be replaced."""
    for name in there:
        (tmp_path / name).write_bytes(b"old " + name.encode())
    before, replace, asked = contents(tmp_path), os.replace, []

    def replaced(source, target):
        asked.append(target)
        if len(asked) == failing + 1:
            raise PermissionError(1, "Operation not permitted")
        replace(source, target)

    def no_links(source, target):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "replace", replaced)
    if not linked:
        monkeypatch.setattr(os, "link", no_links)
    with pytest.raises(BadInput, match=f"^{tmp_path}/{'abc'[failing]}: cannot be written: operation not permitted$"):
        disk.write_all(files(tmp_path))
    assert contents(tmp_path) == before


@pytest.mark.parametrize(("last", "said"), [
    ("no/such", "cannot be written: no such file or folder"), ("", "cannot be written: a folder, not a file"),
    ("zero\0byte", "not a file name"),
])  # fmt: skip
def test_where_one_cannot_be_begun_none_is_there(last, said, tmp_path):
    with pytest.raises(BadInput) as caught:
        disk.write_all({**files(tmp_path), f"{tmp_path}/{last}": b"x"})
    assert caught.value.fault == said and contents(tmp_path) == {}


def test_what_goes_wrong_while_one_is_written_is_told_as_it_is(tmp_path):
    with pytest.raises(TumbleError, match=r"^odd$"), disk.together() as them:
        for name in ("a", "b"):
            with them.written(str(tmp_path / name)) as stream:
                stream.write(b"x")
                if name == "b":
                    raise TumbleError("odd")
    assert contents(tmp_path) == {}


@pytest.mark.parametrize("option", ["--recipe", "--out"])
def test_an_import_leaves_no_part_of_its_outputs(option, refused, tmp_path):
    outputs = {"--out": tmp_path / "run.csv", "--recipe": tmp_path / "recipe.toml", option: tmp_path / "no" / "such"}
    told = [text for pair in outputs.items() for text in pair]
    said = refused("import", EXAMPLES / "hand_held_session.csv", *HAND_HELD, *told)
    assert said == f"tumble: {outputs[option]}: cannot be written: no such file or folder\n"


def test_data_that_are_bad_leave_no_part_of_a_folder(tmp_path, capsys):
    assert main(["solve", str(EXAMPLES / "paper_stand.csv"), "--out", str(tmp_path / "result.json")]) == 0
    (tmp_path / "good.csv").write_text("ux,uy,uz\n0.1,0.2,1.9\n")
    (tmp_path / "bad.csv").write_text("ux,uy,uz\n0.1,0.2,x\n")
    (tmp_path / "calibrated").mkdir()
    data = [str(tmp_path / name) for name in ("good.csv", "bad.csv")]
    assert main(["apply", str(tmp_path / "result.json"), *data, "--out", str(tmp_path / "calibrated")]) == 2
    assert "bad.csv: row 2, column uz: 'x' is not a number" in capsys.readouterr().err
    assert contents(tmp_path / "calibrated") == {}
