"""`tumble history`: results in a database, and what is refused."""

import json
import os
import shutil
import sqlite3
import struct
import zlib

import numpy as np
import pytest
from blocks import NOMINAL_K
from calibrations import result
from conftest import EXAMPLES
from documents import document_of, valid
from fleets import fleet, rows_of
from test_store_golden import a_set

import tumble as package
from tumble.documents.base import written
from tumble.documents.labels import iso
from tumble.errors import BadInput, UsageError
from tumble.history import History, database
from tumble.history.calibrations import PARAMETERS, row_of, unpacked
from tumble.store import codec

pytestmark = pytest.mark.python
TIME = "2026-03-01T12:00:00Z"
U0, JOINT = np.array([0.01, -0.02, 0.03]), np.eye(12) * 1e-10


def rotation(vector):
    """By Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def put(folder, name="r.json", covariance=JOINT, k=NOMINAL_K, **more):
    path = folder / name
    path.write_text(json.dumps(result(k, U0, covariance, **{"created": TIME, "serial": "A-1", **more})))
    return path


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """A result of the command line's own."""
    path = tmp_path_factory.mktemp("solved") / "result.json"
    package.solve(EXAMPLES / "lab_stand.csv", stand=EXAMPLES / "lab_stand.toml").save(path)
    return path


def test_a_row_has_the_intrinsic_parameters_of_its_result(solved):
    row, told = row_of(solved.read_bytes(), "r", serial="A-1"), json.loads(solved.read_text())
    for place, axis in enumerate("xyz"):
        assert row[f"scale_{axis}"] == pytest.approx(told["intrinsic"]["scale"][place], rel=1e-14)
        assert row[f"bias_{axis}"] == pytest.approx(told["intrinsic"]["bias_g"][place], rel=1e-12)
        relative = told["u_intrinsic"]["scale"][place] / told["intrinsic"]["scale"][place]
        assert row[f"u_scale_{axis}"] == pytest.approx(relative, rel=1e-9)
        assert row[f"u_bias_{axis}"] == pytest.approx(told["u_intrinsic"]["bias_g"][place], rel=1e-9)
    for pair in ("xy", "xz", "yz"):
        assert row[f"angle_{pair}"] == pytest.approx(told["intrinsic"]["angle_rad"][pair], rel=1e-14)
        assert row[f"u_angle_{pair}"] == pytest.approx(told["u_intrinsic"]["angle_rad"][pair], rel=1e-9)
    joint = unpacked([row["covariance"]])[0]
    assert np.sqrt(np.diag(joint)) == pytest.approx([row[f"u_{name}"] for name in PARAMETERS[:9]], rel=1e-12)
    assert iso(row["created_s"]) == told["created"] and row["u_norm_g"] == told["u_norm_g"]["worst_g"]


@pytest.mark.parametrize("angle", [1e-5, 0.3, 3.0])
@pytest.mark.parametrize("hand", [1.0, -1.0])
def test_a_turned_seat_changes_the_seat_alone(tmp_path, angle, hand):
    """K (I + [phi]x) has the triangle of K; the derivatives say so by differences."""
    turn = np.array([0.6, -0.64, 0.48]) * angle
    lower = np.linalg.cholesky(NOMINAL_K @ NOMINAL_K.T) * hand
    first, then = (
        row_of(put(tmp_path, k=k).read_bytes(), "r") for k in (lower, lower @ rotation(turn))
    )
    for name in PARAMETERS[:9]:
        assert then[name] == pytest.approx(first[name], rel=1e-12)
    assert [then[f"seat_{axis}"] for axis in "xyz"] == pytest.approx(turn, rel=1e-9)
    assert [first[f"seat_{axis}"] for axis in "xyz"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-15)


def test_the_uncertainty_of_the_seat_is_that_of_draws(tmp_path):
    rng = np.random.default_rng(5)
    spread = rng.normal(size=(12, 12)) * 1e-6
    joint, k = spread.T @ spread, NOMINAL_K @ rotation([0.1, 0.2, -0.3])
    row = row_of(put(tmp_path, covariance=joint, k=k).read_bytes(), "r")
    draws = rng.normal(size=(400, 12)) @ spread
    seats = []
    for draw in draws:
        one = row_of(put(tmp_path, covariance=joint, k=k + draw[:9].reshape(3, 3)).read_bytes(), "r")
        turned = rotation([row[f"seat_{a}"] for a in "xyz"]).T @ rotation([one[f"seat_{a}"] for a in "xyz"])
        seats.append([turned[2, 1], turned[0, 2], turned[1, 0]])
    assert np.std(seats, axis=0) == pytest.approx([row[f"u_seat_{a}"] for a in "xyz"], rel=0.12)


def test_adding_again_adds_nothing(tumble, tmp_path):
    put(tmp_path, "a.json")
    (tmp_path / "runs/one").mkdir(parents=True)
    put(tmp_path / "runs/one", "result.json", created="2026-04-01T00:00:00Z")
    said = [tumble("history", "add", "a.json", "runs", cwd=tmp_path) for _ in range(2)]
    assert [(one.returncode, one.stdout, one.stderr) for one in said] == [(0, "2 added\n", ""), (0, "0 added\n", "")]
    told = document_of(tumble("history", "show", "--json", cwd=tmp_path), "history")
    assert [(one["serial"], one["measured"]) for one in told["calibrations"]] == [
        ("A-1", TIME), ("A-1", "2026-04-01T00:00:00Z"),
    ]  # fmt: skip
    with History(tmp_path / "history.db") as history:
        assert history.document(told["calibrations"][0]["sha256"]) == (tmp_path / "a.json").read_bytes()


def test_a_result_may_be_as_long_as_a_memory(tumble, tmp_path):
    """Of whole sectors, and with a byte order mark before it."""
    text = b"\xef\xbb\xbf" + put(tmp_path).read_bytes()
    (tmp_path / "r.json").write_bytes(text + b" " * (-len(text) % 4096))
    assert tumble("history", "add", "r.json", cwd=tmp_path).stdout == "1 added\n"


def test_labels_name_block_type_and_day(tumble, tmp_path):
    item = {"Serial number": "S 7", "Model": "QA-1", "date": "2025-02-03"}
    put(tmp_path, serial=None, item=item)
    put(tmp_path, "b.json", serial=None, item=item, K=(NOMINAL_K * 1.1).tolist())
    assert tumble("history", "add", "r.json", cwd=tmp_path).returncode == 0
    options = "--serial", "S-8", "--type", "QA-2", "--date", "2025-06-30"
    assert tumble("history", "add", "b.json", *options, cwd=tmp_path).returncode == 0
    told = document_of(tumble("history", "show", "--json", cwd=tmp_path), "history")["calibrations"]
    assert [(one["serial"], one["type"], one["measured"]) for one in told] == [
        ("S 7", "QA-1", "2025-02-03T00:00:00Z"), ("S-8", "QA-2", "2025-06-30T00:00:00Z"),
    ]  # fmt: skip
    assert tumble("history", "show", "--serial", "S-8", cwd=tmp_path).stdout.splitlines()[1:] == [
        "2025-06-30 00:00  S-8              QA-2         -                pass               -", "1 calibration",
    ]  # fmt: skip


def test_volts_and_millivolts_are_one_block(tmp_path):
    volts, milli = (row_of(put(tmp_path, K=(NOMINAL_K * f).tolist(), U0=(U0 * f).tolist(), unit=unit,
                               covariance=np.eye(12) * 1e-10 * f**2).read_bytes(), "r")
                    for f, unit in ((1.0, "V"), (1000.0, "mV")))  # fmt: skip
    for name in PARAMETERS:
        assert milli[name] == pytest.approx(volts[name], rel=1e-12, abs=1e-15)
        assert milli[f"u_{name}"] == pytest.approx(volts[f"u_{name}"], rel=1e-9)


@pytest.mark.parametrize("more, line", [
    ({"serial": None}, "r.json: names no block: write serial under [block] of the stand file, or give --serial NAME"),
    ({"created": None}, "r.json: has no date (key created): give --date YYYY-MM-DD"),
    ({"K": np.zeros((3, 3)).tolist()}, "r.json: K cannot be inverted: no calibration"),
    ({"item": {"date": "2026-02-30"}}, "r.json: date of item: '2026-02-30' is not a date such as 2026-07-31"),
    ({"environment": {"date": "2026-13-01"}},
     "r.json: date of environment: '2026-13-01' is not a date such as 2026-07-31"),
])  # fmt: skip
def test_a_result_without_block_day_or_numbers_is_refused(refused, tmp_path, more, line):
    put(tmp_path, **more)
    assert refused("history", "add", "r.json", cwd=tmp_path) == f"tumble: {line}\n"


@pytest.mark.parametrize("arguments, line", [
    (("show",), "history.db: no such history; tumble history add makes it"),
    (("show", "--db", "r.json"), "r.json: the database refuses: 'file is not a database'"),
    (("show", "--db", "other.db"), "other.db: holds no history; tumble history add makes one"),
    (("show", "--db", "newer.db"), "newer.db: a history of version 2; this tumble reads 1: use a newer one"),
    (("show", "--db", "one.db", "--serial", "no"), "one.db: no calibration of block 'no'"),
    (("add", "empty", "--db", "one.db"), "empty: no result.json in it, nor in a folder below"),
    (("add", "r.json", "--date", "1.2.2026", "--db", "one.db"),
     "--date: '1.2.2026' is not a date such as 2026-07-31"),
    (("add", "r.json", "--db", ""), "--db: is empty: give the name of a file, such as history.db, or a URL"),
    (("show", "--db", "sqlite+pysqlite:///nothing.db"), "nothing.db: no such history; tumble history add makes it"),
    (("show", "--db", "nonsense://:x:y"), "--db: not the URL of a database, such as postgresql://USER@HOST/NAME"),
    (("due", "--limit", "0", "--db", "one.db"), "--limit: '0' is not an acceleration in g"),
    (("export", "--out", "a.csv", "--db", "one.db"), "--out: the file of an export ends in .parquet"),
])  # fmt: skip
def test_what_cannot_be_is_refused(refused, tumble, tmp_path, arguments, line):
    put(tmp_path)
    (tmp_path / "empty").mkdir()
    assert tumble("history", "add", "r.json", "--db", "one.db", cwd=tmp_path).returncode == 0
    shutil.copy(tmp_path / "one.db", tmp_path / "newer.db")
    with sqlite3.connect(tmp_path / "newer.db") as newer:
        newer.execute("UPDATE history SET version = 2")
    newer.close()
    with sqlite3.connect(tmp_path / "other.db") as other:
        other.execute("CREATE TABLE own (number INTEGER)")
    other.close()
    assert refused("history", *arguments, cwd=tmp_path) == f"tumble: {line}\n"
    assert not (tmp_path / "nothing.db").exists()


def test_a_history_without_a_name_is_refused():
    with pytest.raises(UsageError, match="--db: is empty"):
        History("")


def test_a_history_in_memory_is_read_while_it_is_open():
    with History(":memory:") as history:
        assert history.add_rows(rows_of(fleet(1, 2, 1).series)) == 2
        assert len(history.show().calibrations) == 2
    with History(":memory:") as history, pytest.raises(BadInput, match="holds no history"):
        history.show()


def test_a_label_that_is_no_day_is_a_fault_of_the_file(tmp_path):
    with History(tmp_path / "h.db") as history, pytest.raises(BadInput, match="date of item: '2026-02-30' is not"):
        history.add(put(tmp_path, item={"date": "2026-02-30"}))
    with History(tmp_path / "h.db") as history, pytest.raises(UsageError, match="--date: '2026-02-30' is not"):
        history.add(put(tmp_path), date="2026-02-30")


def test_a_day_of_long_ago_has_four_digits_of_a_year(tmp_path):
    with History(tmp_path / "h.db") as history:
        history.add(put(tmp_path), date="0999-01-05")
        told = valid(json.dumps(written(history.show())), "history")
    assert told["calibrations"][0]["measured"] == "0999-01-05T00:00:00Z"


@pytest.mark.parametrize("ask, line", [
    (lambda one: one.trend(confidence=1.0), "confidence: '1.0' is not a number from 0.5 to 0.999999"),
    (lambda one: one.trend(confidence=99.73), "confidence: '99.73' is not a number from 0.5 to 0.999999"),
    (lambda one: one.due(1e-4, confidence="0.9"), "confidence: '0.9' is not a number from 0.5 to 0.999999"),
    (lambda one: one.due(-1), "limit_g: '-1' is not a number of g above 0, at most 1"),
    (lambda one: one.due(float("nan")), "limit_g: 'nan' is not a number of g above 0, at most 1"),
    (lambda one: one.due(1e-4, coverage_factor=0.5), "coverage_factor: '0.5' is not a number from 1 to 10"),
    (lambda one: one.due(1e-4, method="guess"), "method: 'guess' is not one of control-chart, staircase"),
])  # fmt: skip
def test_arguments_out_of_range_are_refused(tmp_path, ask, line):
    with History(tmp_path / "h.db") as history:
        history.add_rows(rows_of(fleet(2, 2, 1).series))
        with pytest.raises(UsageError) as refused:
            ask(history)
    assert str(refused.value) == line


def test_all_results_are_added_or_none(refused, tumble, tmp_path):
    put(tmp_path, "a.json")
    put(tmp_path, "b.json", created="2026-05-01T00:00:00Z")
    put(tmp_path, "c.json", serial=None)
    tumble("history", "add", "a.json", cwd=tmp_path)
    refused("history", "add", "b.json", "c.json", cwd=tmp_path)
    assert len(document_of(tumble("history", "show", "--json", cwd=tmp_path), "history")["calibrations"]) == 1


def test_what_fails_half_way_leaves_nothing(tmp_path, monkeypatch):
    """The last portion of rows does not fit the table: those before it are not there either."""
    monkeypatch.setattr(database, "_AT_ONCE", 10)
    rows = rows_of(fleet(5, 5, 1).series)
    with History(tmp_path / "h.db") as history:
        history.add_rows(rows[:1])
        with pytest.raises(BadInput, match="nothing was added"):
            history.add_rows([*rows, {**rows[0], "sha256": "another", "created_s": None}])
        assert len(history.columns()["id"]) == 1
        assert history.add_rows(rows) == 24


def test_a_password_is_not_shown(tumble, tmp_path):
    put(tmp_path)
    done = tumble("history", "add", "r.json", "--db", "postgresql://me:secret@127.0.0.1:1/x", cwd=tmp_path)
    assert done.returncode in (2, 77) and "secret" not in done.stderr and done.stdout == ""


def test_without_sqlalchemy_the_extra_is_named(tumble, tmp_path):
    put(tmp_path)
    (tmp_path / "none").mkdir()
    (tmp_path / "none/sqlalchemy.py").write_text("raise ImportError('none')\n")
    path = f"{tmp_path / 'none'}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("history", "add", "r.json", cwd=tmp_path, PYTHONPATH=path)
    assert (done.returncode, done.stdout) == (77, "")
    assert done.stderr.startswith("tumble: the history of blocks needs sqlalchemy: ")


def test_an_export_is_read_by_others(tumble, tmp_path):
    """Which give back what was added: by pyarrow and by DuckDB, where they are there."""
    pytest.importorskip("pyarrow")
    put(tmp_path)
    put(tmp_path, "b.json", covariance=None, created="2026-04-01T00:00:00Z")
    tumble("history", "add", "r.json", "b.json", cwd=tmp_path)
    done = tumble("history", "export", "--out", "h.parquet", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "2 written\n")
    duckdb = pytest.importorskip("duckdb")
    found = duckdb.sql(
        f"SELECT serial, epoch(measured), scale_x, u_scale_x FROM '{tmp_path / 'h.parquet'}' ORDER BY measured"
    ).fetchall()
    row = row_of((tmp_path / "r.json").read_bytes(), "r")
    assert found[0] == ("A-1", row["created_s"], row["scale_x"], row["u_scale_x"])
    assert found[1][3] is None


def test_the_door_for_scripts(solved, tmp_path):
    with History(tmp_path / "h.db") as history:
        assert history.add(package.load(solved), serial="A-1") == history.add(solved, serial="A-2") + 1
        frame = pytest.importorskip("pandas") and history.to_frame()
        assert list(frame["serial"]) == ["A-1"]
        assert valid(json.dumps(written(history.show("A-1"))), "history")["calibrations"][0]["pass"] is False


def entry(number, day, origin=2, flags=codec.HAS_UNCERTAINTY, bias=0.01):
    """128 bytes of a history, as docs/embedding.md has them."""
    k = np.float32([2.0, 0.01, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0, bias, 0.0, 0.0])
    date = int(np.datetime64(day, "s").astype(int)) if day else 0
    head = struct.pack("<4sIIBBHQf", b"THS1", number, number, origin, 2, flags, date, 21.5)
    body = head + k.astype("<f4").tobytes() + np.full(12, 2e-5, "<f4").tobytes()
    return body + struct.pack("<I", zlib.crc32(body))


def memory(*entries):
    image = bytearray(b"\xff" * 8 * 4096)
    active = codec.encode_set(a_set(sequence=9, origin=2, serial="TB-0007"))
    image[4096 : 4096 + len(active) + len(codec.mark_of(active))] = active + codec.mark_of(active)
    image[4 * 4096 : 4 * 4096 + 128 * len(entries)] = b"".join(entries)
    return bytes(image)


def test_the_history_of_a_computer_is_read(tumble, tmp_path):
    """Its sets with a date, of the block that it has now; without what a rollback gave up, and its copy."""
    other, mine = codec.HAS_UNCERTAINTY, codec.HAS_UNCERTAINTY | 0x8000
    image = memory(
        entry(1, "2025-01-01", flags=other), entry(2, "2025-02-01", flags=mine), entry(3, None),
        entry(4, "2025-04-01"), entry(5, "2025-05-01", origin=3, bias=0.5), entry(6, "2025-06-01", origin=4),
        entry(7, "2025-07-01", origin=6), entry(8, "2025-08-01", flags=0),
    )  # fmt: skip
    (tmp_path / "nv.bin").write_bytes(image)
    assert [tumble("history", "add", "nv.bin", cwd=tmp_path).stdout for _ in range(2)] == ["3 added\n", "0 added\n"]
    with History(tmp_path / "history.db") as history:
        columns = history.columns("TB-0007")
    assert [iso(one)[:10] for one in columns["created_s"]] == ["2025-02-01", "2025-04-01", "2025-08-01"]
    assert columns["bias_x"] == pytest.approx([0.005] * 3, rel=1e-4) and set(columns["estimator"]) == {"on board"}
    assert columns["u_bias_x"][:2] == pytest.approx([1e-5] * 2, rel=0.01) and np.isnan(columns["u_bias_x"][2])


@pytest.mark.parametrize("image, line", [
    (b"\xff" * 8 * 4096, "names no block: it has no active set: give --serial NAME"),
    (memory(entry(1, None)), "no set with a date in the history of this memory"),
    (b"\xff" * 4096, "4096 bytes are not whole sectors of 4096 bytes, 8 at least"),
])  # fmt: skip
def test_a_memory_without_sets_is_refused(refused, tmp_path, image, line):
    (tmp_path / "nv.bin").write_bytes(image)
    assert refused("history", "add", "nv.bin", cwd=tmp_path) == f"tumble: nv.bin: {line}\n"


def test_a_memory_has_dates_of_its_own(refused, tmp_path):
    (tmp_path / "nv.bin").write_bytes(memory(entry(1, "2025-01-01")))
    line = "tumble: --date: the sets in a memory have dates of their own: leave it out for nv.bin\n"
    assert refused("history", "add", "nv.bin", "--date", "2026-01-01", cwd=tmp_path) == line
    assert not (tmp_path / "history.db").exists()
