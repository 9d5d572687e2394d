"""Logs of a CAN bus: the log of a run of the bench becomes its run file again, in every format; others are refused."""

import csv
import os
import re

import numpy as np
import pytest
from conftest import EXAMPLES

can = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("cantools", reason="cantools is not installed")

from can_logs import DBC, V_PER_COUNT, bench, rewritten  # noqa: E402, F401

import tumble as api  # noqa: E402
from tumble.errors import BadInput, UsageError  # noqa: E402
from tumble.files import can_log  # noqa: E402
from tumble.files.run_layout import LayoutOptions  # noqa: E402
from tumble.importing import can_bus  # noqa: E402
from tumble.importing.can_bus import Bus  # noqa: E402

pytestmark = [pytest.mark.python, pytest.mark.toolchain]

KINDS = {".log": "candump", ".asc": "ASC", ".blf": "BLF", ".trc": "TRC", ".csv": "python-can CSV", ".mf4": "MF4"}


def rows_of(file):
    """Of a run file: [(place, outputs, temperature)], and its header."""
    with open(file) as stream:
        lines = [row for row in csv.reader(stream) if not row[0].startswith("#")]
    at = lines[0].index("temperature")
    return lines[0], [((int(r[0]), int(r[1])), tuple(map(float, r[2:5])), float(r[at])) for r in lines[1:]]


def by_place(rows):
    found = {}
    for place, outputs, _ in rows:
        found.setdefault(place, []).append(outputs)
    return {place: np.array(outputs) for place, outputs in found.items()}


# The bench's own log, the way back.


@pytest.mark.parametrize("suffix", KINDS)
def test_the_log_of_a_run_becomes_its_run_file(suffix, bench, tumble, tmp_path):
    if suffix == ".mf4":
        pytest.importorskip("asammdf", reason="asammdf is not installed")
    log = bench.log if suffix == ".log" else rewritten(bench.log, tmp_path / f"bus{suffix}")
    done = tumble("import", log, "--stand", bench.stand, "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "")
    assert max(map(len, done.stdout.partition("\nNext:\n")[0].splitlines())) <= 80
    said = " ".join(done.stdout.split())
    frames = sum(1 for _ in can.CanutilsLogReader(str(bench.log)))
    assert f"- CAN log ({KINDS[suffix]}): {frames} frames" in said
    assert "left out" not in said.replace("left out: at no position", "") and "missing" not in said
    header, rows = rows_of(tmp_path / "run.csv")
    assert header == ["mounting", "position", "ux [V]", "uy [V]", "uz [V]", "time_s", "rest", "temperature"]
    _, expected = rows_of(bench.run)
    require_nearly_the_same(rows, expected)


@pytest.mark.parametrize("suffix", [".log", ".blf"])
def test_it_is_read_in_python_as_it_is_imported(suffix, bench, tumble, tmp_path):
    log = bench.log if suffix == ".log" else rewritten(bench.log, tmp_path / f"bus{suffix}")
    assert tumble("import", log, "--stand", bench.stand, "--out", tmp_path / "run.csv").returncode == 0
    imported, found = api.read(tmp_path / "run.csv"), api.read(log, v_per_count=V_PER_COUNT)
    assert (found.outputs == imported.outputs).all() and found.unit == "V" and len(found) > 100
    assert (found.mounting == imported.mounting).all() and (found.position == imported.position).all()
    assert any(note.startswith(f"CAN log ({KINDS[suffix]}): ") for note in found.notes) and imported.notes == ()
    assert (api.solve(found).K == api.solve(imported).K).all()
    with pytest.raises(UsageError, match=r"^dbc is for a log of a CAN bus$"):
        api.read(tmp_path / "run.csv", dbc=DBC)
    with pytest.raises(UsageError, match=r"^v_per_count: 0 is no number of volts above 0$"):
        api.read(log, v_per_count=0)
    with pytest.raises(BadInput):
        api.read(log, v_per_count=V_PER_COUNT, schedule=str(tmp_path / "none.toml"))


def require_nearly_the_same(rows, expected):
    """Of every position most samples that the bench has averaged, bit for bit and in their order, and beside them
    others of the same rest: means differ by chance."""
    found, wanted = by_place(rows), by_place(expected)
    assert list(found) == list(wanted)
    for place, outputs in wanted.items():
        have = set(map(tuple, outputs.tolist()))
        common = [tuple(row) for row in found[place].tolist() if tuple(row) in have]
        assert len(common) > 0.6 * len(outputs), place
        order = [tuple(row) for row in outputs.tolist()]
        begin = order.index(common[0])
        assert order[begin : begin + len(common)] == common, place
        sigma = outputs.std(axis=0, ddof=1)
        assert (np.abs(found[place].mean(axis=0) - outputs.mean(axis=0)) < 5 * sigma / np.sqrt(len(common))).all()
    assert {temperature for _, _, temperature in rows} == {temperature for _, _, temperature in expected} == {25.0}


def test_every_format_gives_the_same_rows(bench, tmp_path):
    def read(file):
        data = file.read_bytes()
        return can_bus.read(data, str(file), can_log.kind_of(data), LayoutOptions(), Bus())

    expected = read(bench.log)
    for suffix in (".asc", ".blf", ".trc", ".csv"):
        found = read(rewritten(bench.log, tmp_path / f"bus{suffix}"))
        assert np.array_equal(found.outputs, expected.outputs) and found.unit == "counts"
        times = found.seconds - found.seconds[0] - (expected.seconds - expected.seconds[0])
        assert np.abs(times).max() < 2e-5, suffix


def screen(log, form):
    """A candump -L log as candump shows it with -ta, -tz, -td or -tA, an error frame among its lines."""
    lines, before, start = [], None, None
    for line in log.read_text().splitlines():
        time, channel, frame = line.split()[:3]
        second, (identifier, data) = float(time[1:-1]), frame.split("#")
        start = second if start is None else start
        shown = second - {"a": 0.0, "z": start, "d": second if before is None else before, "A": 0.0}[form]
        date = str(np.datetime64(round(second * 1e6), "us")).replace("T", " ")
        stamp = date if form == "A" else f"{shown:010.6f}"
        octets = " ".join(data[place : place + 2] for place in range(0, len(data), 2))
        lines.append(f" ({stamp})  {channel}  {identifier}   [{len(data) // 2}]  {octets}")
        before = second
    stamp, _, _ = lines[6].partition(")")
    if form != "d":  # it would be one more step
        lines.insert(7, f"{stamp})  can0  20000080   [8]  00 00 00 00 00 00 00 00   ERRORFRAME")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("form", ["a", "z", "d", "A"])
def test_what_candump_shows_on_a_screen_is_read(form, bench):
    expected = can_bus.read(bench.log.read_bytes(), "log", "candump", LayoutOptions(), Bus())
    data = screen(bench.log, form).encode()
    assert can_log.kind_of(data) == "candump's screen"
    found = can_bus.read(data, "screen", can_log.kind_of(data), LayoutOptions(), Bus())
    assert np.array_equal(found.outputs, expected.outputs)
    times = found.seconds - found.seconds[0] - (expected.seconds - expected.seconds[0])
    assert np.abs(times).max() < 2e-3  # where each is rounded, they add up


def test_a_screen_without_times_is_refused(refused, tmp_path):
    (tmp_path / "screen.txt").write_text("  can0  683   [8]  00 00 00 00 00 00 00 00\n")
    said = refused("import", tmp_path / "screen.txt")
    assert said.endswith("candump's screen without times: log it with candump -L\n")


def test_without_a_converter_the_outputs_are_counts(bench, tumble, tmp_path):
    done = tumble("import", bench.log, "--out", tmp_path / "run.csv")
    assert done.returncode == 0
    advice = "in counts: set converter_bits and range_v in [block] of the stand file"
    assert advice in " ".join(done.stdout.split())
    header, rows = rows_of(tmp_path / "run.csv")
    assert header[2:5] == ["ux [counts]", "uy [counts]", "uz [counts]"]
    require_nearly_the_same(
        [(place, tuple(V_PER_COUNT * u for u in outputs), degrees) for place, outputs, degrees in rows],
        rows_of(bench.run)[1],
    )


def test_what_is_imported_can_be_solved(bench, tumble, tmp_path):
    done = tumble("import", bench.log, "--stand", bench.stand, "--out", tmp_path / "run.csv")
    assert done.returncode == 0
    import tumble as package

    own, again = (package.solve(str(file), stand=str(bench.stand)) for file in (bench.run, tmp_path / "run.csv"))
    assert again.unit == "V" and again.passed and own.passed
    assert (np.abs(own.K - again.K) < own.u_K).all() and (np.abs(own.U0 - again.U0) < own.u_U0).all()


def test_what_was_assumed_is_with_the_error(bench):
    with pytest.raises(BadInput, match=r"all 18 would be found in .* \(tumble import --columns ux=<that") as refusal:
        api.read(bench.log, columns={"ux": "y", "uy": "x", "uz": "z"})
    time, _, schedule, labels, rests, *_ = refusal.value.assumed
    assert time == "time of the log, 100 Hz" and labels == "no labels of positions"
    assert schedule == "schedule paper, the default (schedule=)"
    assert rests.endswith("(tumble import --still, --drift)")


def test_what_was_found_is_told_in_words_of_scripts(bench):
    notes = api.read(bench.log).notes
    assert "schedule: not given, assumed to be paper (schedule=)" in notes
    assert any("(tumble import --signs, or scale_v_per_g of a stand file)" in note for note in notes)
    with pytest.raises(BadInput, match=r"could be .*: tumble import --leave-out \d+ continues without it"):
        api.read(bench.log, schedule="three_mountings")


def test_axes_can_be_exchanged_and_a_recipe_remembers(bench, tumble, tmp_path):
    columns = ("--columns", "ux=y,uy=x,uz=z", "--signs=+++", "--stand", bench.stand)
    data = bench.log.read_bytes()
    plain = can_bus.read(data, "log", "candump", LayoutOptions(), Bus())
    turned = can_bus.read(data, "log", "candump", LayoutOptions(columns={"ux": "y", "uy": "x", "uz": "z"}), Bus())
    assert np.array_equal(turned.outputs, plain.outputs[:, [1, 0, 2]])
    refused = tumble("import", bench.log, *columns)
    assert refused.returncode == 2 and "channels y and x exchanged" in refused.stderr
    recipe = ("--recipe", tmp_path / "bench.toml")
    first = tumble(
        "import",
        bench.log,
        "--stand",
        bench.stand,
        "--can-channel",
        "can0",
        "--can-id",
        "0x683",
        *recipe,
        "--out",
        tmp_path / "first.csv",
    )
    again = tumble("import", bench.log, *recipe, "--out", tmp_path / "again.csv")
    assert first.returncode == again.returncode == 0, again.stderr
    assert (tmp_path / "first.csv").read_bytes() == (tmp_path / "again.csv").read_bytes()
    written = (tmp_path / "bench.toml").read_text()
    assert f'[can]\nidentifier = 1667\nchannel = "can0"\nv_per_count = {V_PER_COUNT!r}\n' in written


@pytest.mark.parametrize("suffix", [".blf", ".trc", ".csv", ".asc"])
def test_a_log_that_is_cut_is_read_so_far_or_refused(suffix, bench, tmp_path):
    data = rewritten(bench.log, tmp_path / f"bus{suffix}").read_bytes()
    whole = len(can_bus.read(data, "bus", KINDS[suffix], LayoutOptions(), Bus()).outputs)
    for length in (len(data) // 2, len(data) // 2 + 1, len(data) // 2 + 2, len(data) // 2 + 17):
        try:
            found = can_bus.read(data[:length], "bus", KINDS[suffix], LayoutOptions(), Bus())
        except BadInput as error:
            assert re.match(r"bus: (row \d+: )?(cannot be read as a CAN log|no samples of the block)", str(error))
        else:
            assert suffix == ".blf" or 0.4 * whole < len(found.outputs) < 0.6 * whole


def test_times_that_count_from_the_line_before_are_refused(bench, refused, tmp_path):
    text = rewritten(bench.log, tmp_path / "bus.asc").read_text()
    (tmp_path / "bus.asc").write_text(text.replace("timestamps absolute", "timestamps relative", 1))
    assert refused("import", tmp_path / "bus.asc").endswith(
        "bus.asc: its times count from the line before; log it with absolute timestamps\n"
    )


# Where no CAN log can be taken.


def test_solve_and_others_say_what_to_do(bench, refused, tmp_path):
    said = (
        f"{bench.log}: is a CAN log (candump), which has no positions: "
        f"tumble import {bench.log} --out RUN.csv finds them by the rests"
    )
    assert refused("solve", bench.log) == f"tumble: {said}\n"
    assert refused("fixture", "check", "--stand", bench.stand, bench.log) == f"tumble: {said}\n"
    with pytest.raises(BadInput) as caught:
        api.solve(bench.log)
    assert str(caught.value) == said
    blf = rewritten(bench.log, tmp_path / "bus.blf")
    assert "is a CAN log (BLF), which has no positions" in refused("solve", blf)


def test_options_of_can_logs_are_for_can_logs(refused):
    for options in (("--dbc", DBC), ("--can-id", "0x683"), ("--can-channel", "can0")):
        assert refused("import", EXAMPLES / "hand_held_session.csv", *options) == (
            f"tumble: {options[0]} applies to CAN logs, and none is given\n"
        )


@pytest.mark.parametrize("package", ["can", "cantools", "asammdf"])
def test_without_the_packages_a_line_says_what_to_install(package, bench, tumble, tmp_path):
    (tmp_path / f"{package}.py").write_text("raise ImportError('none')\n")
    log = bench.log
    if package == "asammdf":
        log = tmp_path / "bus.mf4"
        log.write_bytes(b"MDF     4.10    " + bytes(100))
    path = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("import", log, PYTHONPATH=path)
    assert (done.returncode, done.stdout) == (77, "")
    name = {"can": "python-can"}.get(package, package)
    kind = " in MF4" if package == "asammdf" else ""
    brought = "asammdf" if kind else "python-can cantools"
    assert done.stderr == f"tumble: {log}: a CAN log{kind} needs {name}: .venv/bin/pip install {brought}\n"


def test_an_old_python_can_is_told(tmp_path, tumble):
    (tmp_path / "can.py").write_text("__version__ = '4.0'\n")
    (tmp_path / "bus.trc").write_text(";$FILEVERSION=2.1\n")
    path = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("import", tmp_path / "bus.trc", PYTHONPATH=path)
    remedy = ".venv/bin/pip install python-can cantools"
    said = f"tumble: {tmp_path}/bus.trc: a CAN log in TRC needs a newer python-can: {remedy}\n"
    assert (done.returncode, done.stdout, done.stderr) == (77, "", said)


def test_what_a_can_log_is_shows_in_its_beginning():
    for text, kind in (
        (b"(0000000000.000112) can0 701#00\n", "candump"),
        (b"\n (1.5) vcan0 12345678#0011 R\n", "candump"),
        (b"date Sun Nov 22 08:00:00.000 am 2026\r\nbase hex  timestamps absolute\r\n", "ASC"),
        (b"// made by\ndate x\nbase dec timestamps absolute\n", "ASC"),
        (b"LOGG\x90\0\0\0", "BLF"),
        (b";$FILEVERSION=2.1\r\n", "TRC"),
        (b";" + b"#" * 74 + b"\n", "TRC"),
        (b"MDF     4.10    ", "MF4"),
        (b"\xef\xbb\xbftimestamp,arbitration_id,extended,remote,error,dlc,data\r\n", "python-can CSV"),
        (b"mounting,position,ux,uy,uz\n", None),
        (b"# comment\n", None),
        (b"", None),
        (b"(1) 2 3\n", None),
        (b"%RAWIMUSA,2209,491612.254;2209,", None),
        (b"timestamp,ax,ay,az\n", None),
    ):
        assert can_log.kind_of(text) == kind, text
