"""Run files of every accepted layout, and the two ways of reading them, which must be one."""

import math
from fractions import Fraction

import numpy as np
import pytest
from blocks import NOMINAL_K
from hypothesis import given, strategies as st

from tumble.errors import BadInput
from tumble.files.rows import PositionIndex, RowParser
from tumble.files.run_file import RowStore, RunReader, read_run
from tumble.files.run_layout import LayoutOptions
from tumble.model import Geometry, built_in

PAPER = built_in("paper")
MEANS = np.round(Geometry(PAPER).outputs(NOMINAL_K, [0.1, 0.2, 0.3]), 7)
ROWS = [(p.mounting, p.number, *mean) for p, mean in zip(PAPER.positions, MEANS.tolist())]


def table(header="mounting,position,ux,uy,uz", delimiter=",", decimal=".", extra=(), newline="\n"):
    """The rows as text in some layout; `extra` fields end every row."""
    lines = [header]
    for mounting, position, *outputs in ROWS:
        fields = [str(mounting), str(position), *(f"{u:.7f}".replace(".", decimal) for u in outputs), *extra]
        lines.append(delimiter.join(fields))
    return newline.join(lines) + newline


def quoted_decimals():
    """Decimal commas among commas, as spreadsheets write them."""
    lines = ["mounting,position,ux,uy,uz"]
    for mounting, position, *outputs in ROWS:
        lines.append(f"{mounting},{position}," + ",".join(f'"{u:.7f}"'.replace(".", ",") for u in outputs))
    return "\n".join(lines) + "\n"


LAYOUTS = {
    "plain": (table(), LayoutOptions()),
    "no last line end": (table().rstrip("\n"), LayoutOptions()),
    "CRLF": (table(newline="\r\n"), LayoutOptions()),
    "CR": (table(newline="\r"), LayoutOptions()),
    "UTF-8 mark": ("\ufeff" + table(), LayoutOptions()),
    "semicolons": (table("mounting;position;ux;uy;uz", ";"), LayoutOptions()),
    "tabs": (table("mounting\tposition\tux\tuy\tuz", "\t"), LayoutOptions()),
    "semicolons and decimal commas": (table("mounting;position;ux;uy;uz", ";", ","), LayoutOptions()),
    "tabs and decimal commas, said so": (table("mounting\tposition\tux\tuy\tuz", "\t", ","),
        LayoutOptions(decimal=",")),
    "bars, said so": (table("mounting|position|ux|uy|uz", "|"), LayoutOptions(delimiter="|")),
    "quoted decimal commas": (quoted_decimals(), LayoutOptions()),
    "quoted header": (table('"mounting","position","ux","uy","uz"'), LayoutOptions()),
    "capitals": (table("Mounting,POSITION,Ux,UY,uZ"), LayoutOptions()),
    "blanks": (table("mounting , position, ux , uy, uz").replace(",", " , "), LayoutOptions()),
    "units in brackets": (table("Mounting,Position,U_x [V],U_y [V],U_z [V]"), LayoutOptions()),
    "other names": (table("mount,pos,AccX,AccY,AccZ"), LayoutOptions()),
    "bare axes": (table("Mounting,Position,X,Y,Z"), LayoutOptions()),
    "told names": (table("m,p,a,b,c"),
        LayoutOptions({"mounting": "m", "position": "p", "ux": "a", "uy": "b", "uz": "c"})),
    "told names, case apart": (
        table("m,p,A,B,C"),
        LayoutOptions({"mounting": "M", "position": "P", "ux": "a", "uy": "b", "uz": "c"}),
    ),
    "own name wins": (table("mounting,position,ux,uy,uz,ax", extra=["junk"]), LayoutOptions()),
    "extra text": (table("mounting,position,ux,uy,uz,note", extra=["at 20 degrees"]), LayoutOptions()),
    "extra text, quoted": (table("mounting,position,ux,uy,uz,note", extra=['"a, b"']), LayoutOptions()),
    "extra text, not UTF-8": (table("mounting,position,ux,uy,uz,note", extra=["20 \xb0C"]).encode("latin-1"),
        LayoutOptions()),
    "extra text with # and a point": (table("mounting;position;ux;uy;uz;note", ";", ",", ["no. 5 #2"]),
        LayoutOptions()),
    "extra empty column": (table("mounting,position,ux,uy,uz,", extra=[""]), LayoutOptions()),
    "blank lines": (table().replace("\n", "\n\n"), LayoutOptions()),
    "blank lines of CRLF": (table().replace("\n", "\r\n\r\n"), LayoutOptions()),
    "blank lines of spaces": (table().replace("\n", "\n  \n"), LayoutOptions()),
    "comments": ("# operator: N. N.\n" + table().replace("\n1,5", '\n# "half way\n1,5'), LayoutOptions()),
    "plus signs and exponents": (table().replace(",0.", ",+0.").replace("0000\n", "0000E0\n"), LayoutOptions()),
    "whole numbers as floats": (table().replace("\n1,", "\n1.0,").replace("\n2,", "\n2e0,"), LayoutOptions()),
}


@pytest.mark.parametrize("case", LAYOUTS)
def test_layouts(case, tmp_path):
    text, options = LAYOUTS[case]
    file = tmp_path / "run.csv"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    run = read_run(str(file), PAPER, options)
    assert run.means.tolist() == MEANS.tolist()
    assert run.samples.tolist() == [1] * 18
    assert np.isnan(run.scatter).all()
    assert (run.counters["rows"], run.counters["positions"], run.unit) == (18, 18, "V")


@pytest.mark.parametrize(
    ("header", "options", "unit"),
    [
        ("mounting,position,ux [mV],uy [mV],uz [mV]", LayoutOptions(), "mV"),
        ("mounting,position,ux (m/s^2),uy (m/s^2),uz (m/s^2)", LayoutOptions(), "m/s^2"),
        ("mounting,position,ux [mV],uy [mV],uz [mV]", LayoutOptions(unit="LSB"), "LSB"),
        ("mounting,position,ux [*/],uy [*/],uz [*/]", LayoutOptions(), "V"),
    ],
)
def test_units(header, options, unit, tmp_path):
    file = tmp_path / "run.csv"
    file.write_text(table(header))
    assert read_run(str(file), PAPER, options).unit == unit


def test_what_was_passed_over_is_counted(tmp_path):
    file = tmp_path / "run.csv"
    rows = table("mounting,position,ux,uy,uz,t,note", extra=["20", "x"]).splitlines()
    file.write_text("\n".join(["# one", "", *rows[:10], "", "# two", "", *rows[10:-2]]) + "\n")
    counters = read_run(str(file), PAPER).counters
    assert counters == {
        "rows": 16,
        "positions": 16,
        "positions_missing": 2,
        "blank_lines": 3,
        "comment_lines": 2,
        "columns_ignored": 2,
    }


finite = st.floats(-1e12, 1e12, allow_nan=False).map(lambda value: value if abs(value) > 1e-100 else 0.0)
samples = st.lists(st.tuples(st.integers(0, 17), finite, finite, finite), min_size=1, max_size=60)


def written(rows):
    """Rows of (index of a position, three outputs) as a run file."""
    lines = ["mounting,position,ux,uy,uz"]
    lines += [f"{PAPER.positions[i].mounting},{PAPER.positions[i].number},{x!r},{y!r},{z!r}" for i, x, y, z in rows]
    return ("\n".join(lines) + "\n").encode()


def reader_of(data, options=None, fast=True):
    """Of a file in one block; carefully, if not `fast`."""
    return RunReader([data], PositionIndex(PAPER), options or LayoutOptions(), "f", fast)


def rows_of(reader):
    """All its rows: index of the position; outputs and line."""
    index, values = zip(*reader)
    return np.concatenate(index).tolist(), np.concatenate(values).tolist()


@given(samples)
def test_means_are_quotients_of_exact_sums(rows):
    """Against fractions: the sum is rounded once, the quotient once more."""
    data = written(rows)
    store = RowStore(18, "f")
    for part in reader_of(data):
        store.add(*part)
    counts, means, scatter = zip(*((one.samples, one.means, one.scatter) for one in store.facts))
    for index in range(18):
        own = [row[1:] for row in rows if row[0] == index]
        assert counts[index] == len(own)
        for channel in range(3 if own else 0):
            exact = sum(map(Fraction, (row[channel] for row in own)))
            assert means[index][channel] == float(exact) / len(own)
            assert abs(means[index][channel] - exact / len(own)) <= math.ulp(means[index][channel])
            if len(own) > 1:
                variance = sum((Fraction(row[channel]) - exact / len(own)) ** 2 for row in own) / (len(own) - 1)
                largest = max(abs(row[channel]) for row in own)
                assert scatter[index][channel] == pytest.approx(math.sqrt(variance), rel=1e-12, abs=1e-14 * largest)


text_fields = st.text(st.sampled_from('0123456789.,;+-eE \t"#xn\r'), max_size=6)
plain_fields = st.one_of(
    finite.map(repr),
    st.integers(-3, 12).map(str),
    st.sampled_from(["nan", "inf", "", " 1 ", "0,5", "1e400", ".5", "5."]),
)


@st.composite
def nearly_plain_files(draw):
    """Files of which about half are in order, the others wrong in one place or many."""
    delimiter = draw(st.sampled_from([",", ";", "\t"]))
    in_order = finite.map(repr)
    outputs = draw(st.sampled_from([in_order] * 4 + [plain_fields, st.one_of(plain_fields, text_fields)]))
    notes = draw(st.sampled_from([st.just("ok")] * 3 + [text_fields]))
    lines = [delimiter.join(["mounting", "position", "ux", "uy", "uz", "note"])]
    for row in range(draw(st.integers(1, 6))):
        fields = [str(1 + row % 2), str(1 + row % 9), *(draw(outputs) for _ in range(3)), draw(notes)]
        lines.append(delimiter.join(fields[: draw(st.sampled_from([6] * 30 + [5, 0]))]))
    return draw(st.sampled_from(["\n", "\r\n"])).join(lines).encode()


ACCEPTED = {True: 0, False: 0}


def taken(data, fast):
    """The rows and counts of a file, or the complaint."""
    try:
        reader = reader_of(data, fast=fast)
        return rows_of(reader), reader.parser.blanks, reader.parser.comments, reader.temperature
    except BadInput as error:
        return str(error)


@given(nearly_plain_files())
def check_the_ways_agree(data):
    """What C takes first makes no difference: the same numbers, counts, complaints."""
    careful = taken(data, fast=False)
    ACCEPTED[not isinstance(careful, str)] += 1
    assert taken(data, fast=True) == careful


def test_the_fast_way_takes_nothing_that_the_careful_way_would_not():
    check_the_ways_agree()
    assert min(ACCEPTED.values()) > 0.1 * sum(ACCEPTED.values()), "the files test nothing"


@pytest.mark.parametrize("case", LAYOUTS)
def test_the_careful_way_reads_every_layout(case):
    text, options = LAYOUTS[case]
    data = text if isinstance(text, bytes) else text.encode()
    assert [row[:3] for row in rows_of(reader_of(data, options, fast=False))[1]] == MEANS.tolist()


@pytest.mark.parametrize(
    "case", ["plain", "CRLF", "semicolons and decimal commas", "extra text", "blank lines of CRLF", "blanks"]
)
def test_plain_layouts_go_the_fast_way(case, monkeypatch):
    monkeypatch.setattr(RowParser, "_read_row", None)
    assert [row[:3] for row in rows_of(reader_of(LAYOUTS[case][0].encode()))[1]] == MEANS.tolist()


@given(st.binary(max_size=400))
def test_no_bytes_are_anything_but_a_run_or_a_refusal(data):
    """Any bytes, with or without a good header before them."""
    for content in (data, b"mounting,position,ux,uy,uz\n" + data):
        try:
            rows_of(reader_of(content))
        except BadInput as error:
            assert str(error).startswith("f: ") and "\n" not in str(error)
