"""Run files in blocks: wherever they are cut, in memory or not, whatever they come through, the rows are the same."""

import bz2
import gzip
import hashlib
import io
import itertools
import json
import math
import sys
import tracemalloc
from fractions import Fraction

import numpy as np
import pytest
from conftest import EXAMPLES
from hypothesis import given, settings, strategies as st
from test_bad_runs import BAD_TEXTS
from test_run_files import LAYOUTS, PAPER, nearly_plain_files, table

from tumble.cli.main import main
from tumble.core import CoreSchedule
from tumble.errors import BadInput, NotInstalled
from tumble.files import run_layout
from tumble.files.disk import Incoming
from tumble.files.rows import PositionIndex
from tumble.files.run_file import Rows, RowStore, RunReader, facts_of, read_measured, read_run
from tumble.files.run_layout import LayoutOptions
from tumble.files.run_rows import check_rows

pytestmark = pytest.mark.python
RUN = EXAMPLES / "paper_stand.csv"


def taken(blocks, options=None):
    """All that a reader finds in blocks of a file, or its complaint."""
    try:
        reader = RunReader(blocks, PositionIndex(PAPER), options or LayoutOptions(), "f")
        index, values = (np.concatenate(parts).tolist() for parts in zip(*reader))
        return index, values, reader.parser.blanks, reader.parser.comments, reader.temperature, reader.layout
    except BadInput as error:
        return str(error)


def cut(data, size):
    return [data[begin : begin + size] for begin in range(0, len(data), size)]


@pytest.fixture
def short_head(monkeypatch):
    """The layout is found in few bytes, so that blocks of small files are more than their beginning."""
    monkeypatch.setattr(run_layout, "_HEAD_BYTES", 70)


STREAMS = ("plain", "no last line end", "CRLF", "CR", "quoted decimal commas", "extra text, quoted", "comments")


@pytest.mark.parametrize("case", STREAMS)
def test_blocks_of_every_size(case, short_head):
    text, options = LAYOUTS[case]
    data = text.encode()[:330].rpartition(b"\r" if case == "CR" else b"\n")[0]
    whole = taken([data], options)
    assert len(whole[0]) > 4
    for size in range(1, len(data) + 1):
        assert taken(cut(data, size), options) == whole, size


@pytest.mark.parametrize("case", BAD_TEXTS)
def test_complaints_are_the_same_in_blocks(case, short_head):
    data = BAD_TEXTS[case][0]
    data = data.encode() if isinstance(data, str) else data
    whole = taken([data])
    for size in (1, 2, 3, 7, 64, 71, max(1, len(data) - 1)):
        assert taken(cut(data, size)) == whole, size


def test_a_bad_row_at_the_edge_of_a_block(short_head):
    """Cut everywhere in and around it; what is before it has been given out by then."""
    rows = table().splitlines(keepends=True)
    rows[12] = "2,3,0.1,x,0.3\n"
    data, begin = "".join(rows).encode(), len("".join(rows[:12]))
    for place in range(begin - 2, begin + len(rows[12]) + 2):
        assert taken([data[:place], data[place:]]) == "f: row 13, column uy: 'x' is not a number"


def test_a_zero_byte_comes_before_other_complaints(short_head):
    data = table().replace("1,5,", "1,x,").encode() + b"1,1,\0\n"
    for size in (20, 100, len(data)):
        assert taken(cut(data, size)) == "f: row 20: not a text file"


@settings(max_examples=40)
@given(nearly_plain_files(), st.lists(st.integers(0, 300), max_size=6), st.integers(40, 90))
def test_where_a_file_is_cut_changes_nothing(data, places, head):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run_layout, "_HEAD_BYTES", head)
        edges = [0, *sorted(min(place, len(data)) for place in places), len(data)]
        assert taken([data[a:b] for a, b in itertools.pairwise(edges)]) == taken([data])


# Numbers.


@st.composite
def decimals(draw):
    """Numbers as people and programs write them, near and beyond what C takes."""
    digits = draw(st.text("0123456789", min_size=1, max_size=draw(st.sampled_from([3, 8, 17, 19, 22]))))
    place = draw(st.integers(0, len(digits)))
    text = digits[:place] + draw(st.sampled_from([".", "."] + [""] * (place == len(digits)))) + digits[place:]
    exponent = draw(st.sampled_from(["", "", "e0", "E+3", "e-05", "e-19", "e22", "e-30", "e60"]))
    return draw(st.sampled_from(["", "-", "+"])) + text + exponent


@settings(max_examples=40)
@given(st.lists(decimals(), min_size=3, max_size=60))
def test_numbers_are_those_of_python(texts):
    rows = [texts[at : at + 3] for at in range(0, len(texts) - 2, 3)]
    data = "mounting,position,ux,uy,uz\n" + "".join(f"1,1,{','.join(row)}\n" for row in rows)
    _, values, *_ = taken([data.encode()])
    assert [[number.hex() for number in row[:3]] for row in values] == [[float(t).hex() for t in row] for row in rows]


def test_ties_are_rounded_to_even():
    """Numbers half-way between two doubles, and the next ones with 19 digits."""
    texts = []
    for odd in range(1, 200, 2):
        half = Fraction(2**53 + odd, 2**16) / 2**4  # 20 binary places: half-way, and no more than 20 decimal ones
        exact = f"{half.numerator * 10**8 // half.denominator}"
        beside = f"{exact[:-1]}{(int(exact[-1]) + 1) % 10}"
        texts += [*(f"{one[:-8]}.{one[-8:]}" for one in (exact, beside)), "9007199254740993"]
    data = "mounting,position,ux,uy,uz\n" + "".join(
        f"1,1,{','.join(texts[at : at + 3])}\n" for at in range(0, len(texts), 3)
    )
    found = [number for row in taken([data.encode()])[1] for number in row[:3]]
    assert found == list(map(float, texts))


@given(st.lists(st.integers(-5, 5), min_size=1, max_size=80), st.sampled_from([0.5, 1e-3]))
def test_facts_of_a_position(numbers, step):
    """Against numpy and brute force."""
    values = np.array(numbers) * step
    facts = facts_of(np.stack([values, -values, values**2, np.arange(len(values)) + 7], axis=1))
    off = np.abs(values - np.median(values))
    runs = [(begin, end) for begin in range(len(values)) for end in range(begin + 1, len(values) + 1)]
    longest = max((end - begin, -begin) for begin, end in runs if len(set(values[begin:end])) == 1)
    one = facts.channels[0]
    assert one.median == np.median(values) and one.farthest == off.max()
    assert one.run == (-longest[1], longest[0] - longest[1])
    assert one.ends == (values.min(), values.max())
    assert one.at_ends == tuple(int((values == end).sum()) for end in one.ends)
    assert one.off.tolist() == np.sort(off)[1:].tolist() and one.changes.tolist() == np.abs(np.diff(values)).tolist()
    steps = np.diff(np.unique(values))
    assert one.resolution == (steps.min() if len(steps) else math.inf)
    if len(values) > 1:
        usual = np.quantile(off, 0.6827, method="lower") * math.sqrt(len(values) / (len(values) - 1))
        assert one.usual == usual
    assert facts.lines == (7, 6 + len(values))


@pytest.mark.parametrize("rows", [*range(2, 20), 63, 64, 65, 5000])
def test_scatter_and_squares_are_those_of_numpy_to_the_bit(rows):
    values = np.random.default_rng(rows).normal(2.0, 1e-3, (rows, 4))
    facts, sums, length = facts_of(values), values[:, :3] - values[0, :3], 1
    assert facts.scatter.tolist() == np.ascontiguousarray(values[:, :3]).std(axis=0, ddof=1).tolist()
    for squares in facts.squares:
        first, second = sums[: len(sums) // 2 * 2 : 2], sums[1::2]
        assert squares.tolist() == (((first - second) ** 2).sum(axis=0) / (2 * length)).tolist()
        sums, length = first + second, 2 * length
    assert len(sums) == 1


# Rows in memory and in a file.


def told_by(store):
    rows = [[part.tolist() for part in store.rows(position)] for position in range(len(store.samples))]
    squares = [one.squares.tolist() for one in store.facts]
    return rows, squares, store.samples.tolist(), store.step.tolist()


@settings(max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 3), st.floats(-9, 9)), min_size=1, max_size=60), st.data())
def test_how_rows_are_added_and_held_changes_nothing(rows, data):
    index = np.array([position for position, _ in rows])
    values = np.array([[u, 2 * u, -u, line] for line, (_, u) in enumerate(rows)])
    whole = RowStore(4, "f")
    whole.add(index, values)
    store = RowStore(4, "f", in_memory=data.draw(st.integers(0, 70)))
    edges = [0, *sorted(data.draw(st.lists(st.integers(0, len(rows)), max_size=5))), len(rows)]
    for begin, end in itertools.pairwise(edges):
        store.add(index[begin:end], values[begin:end])
    assert told_by(store) == told_by(whole)


def test_of_many_rows_the_same_are_looked_at_for_the_step():
    values = np.random.default_rng(3).normal(size=(130_001, 4))
    whole, parts = RowStore(1, "f"), RowStore(1, "f", in_memory=50_000)
    whole.add(np.zeros(len(values), dtype=int), values)
    for part in np.array_split(values, 23):
        parts.add(np.zeros(len(part), dtype=int), part)
    steps = [np.diff(np.unique(channel)).min() for channel in values[::4, :3].T]
    assert parts.step.tolist() == whole.step.tolist() == steps


def test_no_room_for_the_rows(monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", str(tmp_path / "none"))
    store = RowStore(1, "run.csv", in_memory=1)
    with pytest.raises(BadInput, match=r"^run.csv: its rows have no room in .*none \(TMPDIR\): no such file"):
        store.add(np.zeros(2, dtype=int), np.zeros((2, 4)))


def test_memory_does_not_grow_with_the_file(monkeypatch, tmp_path):
    """Rows of all positions by turns. A tenth of what is added would be too much."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    block = "".join(f"{p.mounting},{p.number},0.1234567,{n}.5,-0.25\n" for n in range(200) for p in PAPER.positions)

    def peak(blocks):
        tracemalloc.start()
        head = b"mounting,position,ux,uy,uz\n"
        store = RowStore(18, "f", in_memory=1 << 14)
        for part in RunReader([head, *[block.encode()] * blocks], PositionIndex(PAPER), LayoutOptions(), "f"):
            store.add(*part)
        assert store.samples.tolist() == [200 * blocks] * 18
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    few, many = peak(20), peak(60)
    added = 40 * len(block)
    assert many < few + added / 10 and few < 6e6, (few, many)


def test_a_schedule_with_closures_is_read_once(tmp_path):
    """Without rows that close a mounting the positions are those of the plain schedule."""
    diagonal = CoreSchedule.built_in("diagonal")
    lines = [f"{p.mounting},{p.number},{i},{i}.5,-{i}\n" for i, p in enumerate(diagonal.data.positions)]
    file = tmp_path / "run.csv"
    file.write_text("mounting,position,ux,uy,uz\n" + "".join(lines))
    run, schedule = read_measured(str(file), diagonal)
    assert schedule is diagonal
    assert run.means[:, 1].tolist() == [i + 0.5 for i in range(len(lines))]


# Rows that are odd, where there are so many that not all distances are kept.


def test_an_absurd_row_among_very_many(monkeypatch):
    monkeypatch.setattr("tumble.files.run_file._FEW_ROWS", 1 << 8)
    rng = np.random.default_rng(31)
    outputs = np.repeat([p.number * 0.2 for p in PAPER.positions], 3000)[:, None] + 3e-4 * rng.normal(size=(54_000, 3))
    store, clean = RowStore(18, "f", in_memory=10_000), RowStore(18, "f")
    index = np.repeat(np.arange(18), 3000)
    clean.add(index, np.column_stack((outputs, np.arange(54_000) + 2)))
    outputs[31_000, 1] = 9.0
    store.add(index, np.column_stack((outputs, np.arange(54_000) + 2)))

    def judged(rows):
        return check_rows(Rows(rows, "V", True, {}).run(), PAPER, None, "f")

    assert judged(clean) == ()
    with pytest.raises(
        BadInput, match=r"^f: row 31002, column uy: 9 V is far off: the others of 2\.2 lie about 0\.(4|3)"
    ):
        judged(store)


# Where a run comes from.


def sha256(data):
    return hashlib.sha256(data).hexdigest()


def same_run(found, run):
    return found.means.tolist() == run.means.tolist() and found.blocks.squares.tolist() == run.blocks.squares.tolist()


def test_compressed_files(tmp_path):
    """Told by their beginning; the hash is that of the file, not of what is in it."""
    data, plain = RUN.read_bytes(), read_run(str(RUN), PAPER)
    packed = gzip.compress(data[:5000]) + gzip.compress(data[5000:])
    for name in ("run.csv.gz", "run.csv"):
        (tmp_path / name).write_bytes(packed)
        run = read_run(str(tmp_path / name), PAPER)
        assert same_run(run, plain) and run.sha256 == sha256(packed)
    assert plain.sha256 == sha256(data)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda packed: packed[:-20], "its compressed data end too early"),
        (lambda packed: packed[:2], "its compressed data end too early"),
        (lambda packed: packed[:-6] + bytes(6), "cannot be read: 'CRC check failed"),
        (lambda packed: packed[:40] + b"\xff" * 9 + packed[49:], "its compressed data are damaged: "),
    ],
)
def test_damaged_compressed_files(change, said, refused, tmp_path):
    file = tmp_path / "run.csv.gz"
    file.write_bytes(change(gzip.compress(RUN.read_bytes(), mtime=0)))
    assert f"tumble: {file}: {said}" in refused("solve", file)


def test_what_is_packed_otherwise_is_no_text(refused, tmp_path):
    file = tmp_path / "run.csv.bz2"
    file.write_bytes(bz2.compress(RUN.read_bytes()))
    assert "not a text file" in refused("solve", file)


def test_zstd(tmp_path):
    zstd = pytest.importorskip("compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd")
    file = tmp_path / "run.csv.zst"
    file.write_bytes(zstd.compress(RUN.read_bytes()))
    assert same_run(read_run(str(file), PAPER), read_run(str(RUN), PAPER))
    file.write_bytes(file.read_bytes()[:-20])
    with pytest.raises(BadInput, match="its compressed data end too early"):
        read_run(str(file), PAPER)


def test_zstd_that_is_not_installed(monkeypatch, tmp_path):
    for module in ("compression", "compression.zstd", "backports", "backports.zstd"):
        monkeypatch.setitem(sys.modules, module, None)
    file = tmp_path / "run.csv.zst"
    file.write_bytes(b"\x28\xb5\x2f\xfd" + bytes(9))
    said = r"run.csv.zst: zstd needs backports.zstd: \.venv/bin/pip install backports.zstd$"
    with pytest.raises(NotInstalled, match=said) as no:
        list(Incoming(str(file)))
    assert no.value.exit_code == 77


class Trickle(io.RawIOBase):
    """A pipe that gives seven bytes at a time."""

    def __init__(self, data):
        self._data = io.BytesIO(data)

    def readinto(self, buffer):
        return self._data.readinto(memoryview(buffer)[:7])


@pytest.mark.parametrize("packed", [False, True])
def test_standard_input(packed, monkeypatch, capsys):
    data = gzip.compress(RUN.read_bytes()) if packed else RUN.read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(Trickle(data)))
    assert main(["solve", "-", "--json", "--unit", "V"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert main(["solve", str(RUN), "--json", "--unit", "V"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert found.pop("run_file") is None and found.pop("run_sha256") == sha256(data)
    del told["run_file"], told["run_sha256"], found["created"], told["created"]
    assert found == told


def test_a_bad_row_of_standard_input(monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(RUN.read_bytes() + b"1,1,x,0,0\n")))
    assert main(["solve", "-"]) == 2
    assert capsys.readouterr() == ("", "tumble: standard input: row 902, column ux: 'x' is not a number\n")
