"""Files as loggers write them: each is imported, or refused with advice that works when it is followed."""

import csv
import io

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import cause_and_remedy
from recordings import Habits, recording

from tumble.files.run_layout import LayoutOptions
from tumble.importing.recording import Timing, crc32, read
from tumble.model import Geometry, built_in

pytestmark = pytest.mark.python

SCHEDULE = built_in("paper")
U0 = np.array([0.1, 0.2, 0.3])
QUIET = Habits(rate_hz=50.0, rest_s=(2.0, 3.0), noise_g=1e-4, angle=1e-5, seat=1e-5, bench=0.0, pause=0.0, gap=0.0)
MEANS = Geometry(SCHEDULE).outputs(NOMINAL_K, U0)


@pytest.fixture(scope="module")
def logged():
    """A recording of all 18 positions in order."""
    return recording(SCHEDULE, list(range(18)), NOMINAL_K, U0, QUIET, np.random.default_rng(11))


@pytest.fixture
def imported(tumble, tmp_path):
    """Import files, of these texts or bytes, with options; what was said, and the means of the run by position."""

    def run(*contents, options=(), name="log"):
        files = []
        for number, content in enumerate(contents):
            files.append(tmp_path / f"{name}{number}.csv")
            files[-1].write_bytes(content if isinstance(content, bytes) else content.encode())
        done = tumble("import", *files, *options, "--out", tmp_path / "run.csv")
        if done.returncode:
            line = cause_and_remedy(done.stderr)[0]
            assert (done.returncode, done.stdout) == (2, ""), done.stderr
            return line, {}
        assert done.stderr == "" and max(map(len, done.stdout.partition("\nNext:\n")[0].splitlines())) <= 80
        return " ".join(done.stdout.split()), means_of((tmp_path / "run.csv").read_text())

    return run


def means_of(text):
    """Of a run file: outputs by (mounting, position)."""
    rows = {}
    for row in csv.reader(io.StringIO("".join(line for line in text.splitlines(True)[2:]))):
        rows.setdefault((int(row[0]), int(row[1])), []).append([float(value) for value in row[2:5]])
    return {place: np.mean(samples, axis=0) for place, samples in rows.items()}


def is_right(means, scale=1.0):
    """All 18 positions, each with its outputs."""
    places = [(place.mounting, place.number) for place in SCHEDULE.positions]
    return list(means) == places and all(
        np.abs(means[place] / scale - expected).max() < 2e-3 for place, expected in zip(places, MEANS)
    )


def samples(place, count=6):
    """Outputs at a position, with a little noise that is always the same."""
    rng = np.random.default_rng(place)
    return MEANS[place] + 1e-4 * rng.normal(size=(count, 3))


def labelled(label, header="{labels},Ux,Uy,Uz", places=range(18), number="{:.6f}".format):
    """A file with a few rows a position; `label`: their label, by the index of the position."""
    names, told = zip(*label(places[0]).items()), [label(place) for place in places]
    rows = [
        ",".join([*map(str, one.values()), *map(number, values)])
        for place, one in zip(places, told)
        for values in samples(place).tolist()
    ]
    return "\n".join([header.format(labels=",".join(next(iter(names)))), *rows]) + "\n"


# What finding loggers' files led to.


def test_rows_above_the_header_and_a_row_of_units_below(imported, logged):
    preamble = "Logger 7; serial 12\nstarted 2026-05-01 10:00\n\nrange;+-5 V\n"
    text = preamble + logged.csv("time,Ax,Ay,Az").replace("\n", "\ns,mV,mV,mV\n", 1)
    said, means = imported(text)
    assert is_right(means)
    assert "header: row 5; the rows above it are not read" in said and "row 6 is read as units: mV" in said


def test_running_numbers_without_mountings(imported):
    said, means = imported(labelled(lambda place: {"Pos": place + 1}))
    assert is_right(means) and "from the labels of the rows, confirmed by gravity" in said


def test_an_angle_instead_of_a_position(imported):
    said, means = imported(
        labelled(lambda p: {"Mount": SCHEDULE.positions[p].mounting, "Angle": SCHEDULE.positions[p].angle_deg + 0.5})
    )
    assert is_right(means), said


def test_an_angle_that_begins_anew_with_every_mounting(imported):
    said, means = imported(labelled(lambda p: {"Angle": SCHEDULE.positions[p].angle_deg}))
    assert is_right(means) and "part1=1,part2=2" in said


def test_an_angle_that_the_schedule_lacks(imported):
    text = labelled(lambda p: {"Angle": SCHEDULE.positions[p].angle_deg + (22.5 if p == 3 else 0)})
    said, _ = imported(text)
    assert "the schedule has no angle '157.5' in mounting 1; another one? (--schedule)" in said


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_one_file_a_mounting(imported, order):
    halves = [labelled(lambda p: {"Pos": p % 9 + 1}, places=range(9 * half, 9 * half + 9)) for half in order]
    said, means = imported(*halves)
    assert f"file1={order[0] + 1},file2={order[1] + 1}" in said
    assert sorted(means) == [(place.mounting, place.number) for place in SCHEDULE.positions]
    assert np.abs(means[1, 2] - MEANS[1]).max() < 2e-3


def test_one_file_alone_names_what_lacks(imported):
    half = labelled(lambda p: {"Pos": p % 9 + 1}, places=range(9))
    said, _ = imported(half)
    assert "give the recordings of all mountings together" in said
    _, means = imported(half, labelled(lambda p: {"Pos": p % 9 + 1}, places=range(9, 18)))
    assert is_right(means)


@pytest.mark.parametrize("names", [("A", "B"), ("I", "II"), ("flat", "upright")])
def test_mountings_with_names(imported, names):
    label = lambda p: {"mounting": names[p // 9], "position": p % 9 + 1}  # noqa: E731
    said, means = imported(labelled(label))
    assert is_right(means) and f"{names[0]}=1,{names[1]}=2" in said
    said, means = imported(labelled(label), options=("--mountings", f"{names[0]}=2,{names[1]}=1"))
    assert means == {} and "mountings or positions exchanged" in said


@pytest.mark.parametrize(("mountings", "said"), [
    ("C=1", "--mountings: 'C' is not a mounting here; the rows have 'A', 'B'"),
    ("A=1,B=2,a=1", "--mountings: 'a' is not a mounting here; the rows have 'A', 'B'"),
    ("A=3", "--mountings: the schedule has no mounting 3; it has 1, 2"),
])  # fmt: skip
def test_mountings_that_are_not_there(imported, logged, mountings, said):
    """Of rows that name their positions, and of a recording with a column of mountings beside it."""
    text = labelled(lambda p: {"mounting": "AB"[p // 9], "position": p % 9 + 1})
    assert imported(text, options=("--mountings", mountings))[0].endswith(f"log0.csv: {said}\n")
    assert imported(with_mountings(logged), options=("--mountings", mountings))[0].endswith(f"log0.csv: {said}\n")


def with_mountings(logged):
    """A continuous recording whose rows name their mounting, A or B."""
    middle = int(np.flatnonzero(logged.truth == 9)[0]) - 60
    head, *rows = logged.csv().splitlines()
    named = [f"{'A' if place < middle else 'B'},{row}" for place, row in enumerate(rows)]
    return "\n".join([f"mounting,{head}", *named]) + "\n"


def test_the_mountings_that_are_said_are_those_of_a_continuous_recording(imported, logged):
    said, means = imported(with_mountings(logged), options=("--mountings", "A=1,B=2"))
    assert is_right(means), said
    said, _ = imported(with_mountings(logged), options=("--mountings", "A=2"))
    assert said.endswith(" is in mounting 1, but --mountings says 'A' is 2\n")
    said, _ = imported(logged.csv(), options=("--mountings", "A=1"))
    assert said.endswith("log0.csv: --mountings: 'A' is not a mounting here: the rows name none\n")


FACES = {"+x": (1, 0, 0), "-x": (-1, 0, 0), "y up": (0, 1, 0), "Y_DOWN": (0, -1, 0), "z+": (0, 0, 1), "z-": (0, 0, -1)}


@pytest.mark.parametrize("column", ["face", "mounting", "orientation"])
def test_faces_with_names(imported, column):
    """Of the axis that points up; without a clock, and fewer rows than a rest has."""
    rng = np.random.default_rng(3)
    rows = [
        f"{name},{','.join(f'{value:.5f}' for value in NOMINAL_K @ up + U0 + 1e-4 * rng.normal(size=3))}"
        for name, up in FACES.items()
        for _ in range(30)
    ]
    text = "\n".join([f"{column},Ax,Ay,Az", *rows]) + "\n"
    said, means = imported(text, options=("--schedule", "six_faces"))
    assert len(means) == 6 and "from the labels of the rows, confirmed by gravity" in said
    said, _ = imported(text, options=())
    assert "labelled by the axis that points up, like the faces of hand_laid: --schedule hand_laid" in said


def test_labels_that_gravity_denies(imported):
    exchanged = {3: 5, 5: 3}
    said, _ = imported(labelled(lambda p: {"Pos": exchanged.get(p, p) + 1}))
    assert "is labelled 1." in said and "correct its label, or delete its rows" in said


# Columns that are named like labels and say the same in every row.


@pytest.mark.parametrize(("name", "value"), [
    ("position", "0"), ("position", ""), ("Pos", "n/a"), ("angle", "45"), ("index", "1"), ("mounting", "1"),
])  # fmt: skip
def test_a_column_that_says_the_same_in_every_row(imported, logged, name, value):
    """It made the recording unreadable."""
    head, *rows = logged.csv().splitlines()
    said, means = imported("\n".join([f"{name},{head}", *(f"{value},{row}" for row in rows)]) + "\n")
    label = {"Pos": "position", "index": "number"}.get(name, name)
    assert is_right(means), said
    assert f"- {label}: '{value}' is the same in every row, so it cannot identify positions: not read" in said


@pytest.mark.parametrize("number", [lambda place: place + 1, lambda place: place % 9 + 1])
def test_one_mounting_for_all_positions(imported, number):
    said, means = imported(labelled(lambda place: {"mounting": 1, "position": number(place)}))
    assert is_right(means) and "- mounting: '1' is the same in every row" in said


def test_positions_that_are_the_same_in_every_row_of_their_own_file(imported):
    files = [labelled(lambda p: {"mounting": p // 9 + 1, "position": p % 9 + 1}, places=[p]) for p in range(18)]
    assert is_right(imported(*files)[1])


# Which rests to take, of rows with labels.


def seen_twice(shift=0.01, longer=3):
    """All positions by running number, then 4 again: longer, and a little off; a file, and the means of both visits."""
    mixed = np.vstack([np.random.default_rng(n).permutation(samples(3)) for n in range(longer)])  # copies are refused
    again = mixed + np.array([shift, 0.0, -shift])
    rows = "".join(f"4,{x:.6f},{y:.6f},{z:.6f}\n" for x, y, z in again.tolist())
    return labelled(lambda place: {"Pos": place + 1}) + rows, samples(3).mean(axis=0), again.mean(axis=0)


@pytest.mark.parametrize(("options", "second"), [
    (("--repeats", "first"), 0.0), (("--repeats", "last"), 1.0), (("--repeats", "longest"), 1.0),
    (("--leave-out", "19"), 0.0), (("--leave-out", "4"), 1.0), ((), 0.75),
])  # fmt: skip
def test_which_of_two_visits_is_taken(imported, options, second):
    text, first, again = seen_twice()
    said, means = imported(text, options=options)
    assert means[1, 4] == pytest.approx((1 - second) * first + second * again, abs=1e-6), said
    assert ("all their rests are used; --repeats first|last|longest selects one" in said) == (not options)
    assert ("left out: repeated" in said) == ("--repeats" in options)
    assert ("left out by --leave-out" in said) == ("--leave-out" in options)


def test_a_label_that_gravity_denies_is_taken_or_left_out_as_told(imported):
    text = labelled(lambda place: {"Pos": place + 1 if place != 3 else 6})
    said, means = imported(text)
    assert means == {} and "rest 4 is labelled 1.6, but gravity is" in said
    assert "--leave-out 4 leaves it out, --take 4 uses it" in said
    said, means = imported(text, options=("--leave-out", "4"))
    assert len(means) == 17 and "no rows at 1.4" in said and means[1, 6] == pytest.approx(MEANS[5], abs=1e-3)
    said, means = imported(text, options=("--take", "4", "--tolerance", "20"))
    assert means[1, 6] == pytest.approx((MEANS[5] + MEANS[3]) / 2, abs=1e-3), said


@pytest.mark.parametrize("option", ["--leave-out", "--take"])
def test_a_rest_that_the_labels_do_not_name(imported, option):
    said, _ = imported(labelled(lambda place: {"Pos": place + 1}), options=(option, "19"))
    assert said == "tumble: --leave-out, --take: no rest 19, there are 18\n"


def test_nothing_is_left(imported):
    everything = ",".join(str(number) for number in range(1, 19))
    said, _ = imported(labelled(lambda place: {"Pos": place + 1}), options=("--leave-out", everything))
    assert said.endswith("log0.csv: --leave-out leaves no rest\n")


# The same for continuous recordings.


def test_one_recording_a_mounting(imported, logged):
    middle = int(np.flatnonzero(logged.truth == 9)[0]) - 60
    head, *rows = logged.csv().splitlines()
    parts = ["\n".join([head, *part]) + "\n" for part in (rows[:middle], rows[middle:])]
    said, means = imported(*parts)
    assert is_right(means), said


def test_a_receivers_raw_log_with_a_torn_line(imported, logged):
    counts = np.round(1e5 * logged.outputs).astype(int)
    lines = [raw_line(second, x, y, z) for second, (x, y, z) in zip((logged.time_s + 4e5).tolist(), counts.tolist())]
    lines[500] = lines[500][:40] + lines[501]
    lines[700] = lines[700].replace(";", ";9", 1)
    said, means = imported("GPS1,OK\r\n" + "\r\n".join(lines) + "\r\n")
    assert is_right(means, scale=1e5), said
    assert "left out: 2 messages that are damaged, 1 lines of something else" in said


def raw_line(second, x, y, z):
    body = f"RAWIMUSXA,2209,{second:.3f};04,41,2209,{second:.6f},ea59fe00,{z},{-y},{x},1,-2,3"
    return f"%{body}*{crc32(body.encode()):08x}"


PUBLISHED = (  # lines of receivers, as their maker's manual and public test data have them, with their check sums
    b"%RAWIMUSXA,1692,484620.664;00,11,1692,484620.664389000,00801503,43110635,-817242,-202184,-215194,-41188,-9895*a5db8c7b",
    b"%RAWIMUSA,2209,491612.254;2209,491612.253588,ea5afe00,329303960,-2512321,4410363,309705,607017,-1009773*1fb76c28",
    b"#RAWIMUXA,USB1,0,64.5,FINESTEERING,2209,491740.110,02000020,0dc5,16809;04,41,2209,491740.109817,ea57fe00,"
    b"329394068,-2396829,4481425,321199,257329,-936077*cf9c035d",
    b"#RAWIMUA,COM3,0,72.0,FINESTEERING,2038,117867.800,1a008000,fa9a,14968;2038,117867.792005000,f7f7fe00,-325882330,"
    b"-39071383,104462335,-240437176,7815616,-7423919*a02e612f",
)


@pytest.mark.parametrize("line", PUBLISHED)
def test_published_lines_are_read(line, tmp_path):
    (tmp_path / "log").write_bytes(line + b"\r\n")
    log = read(str(tmp_path / "log"), LayoutOptions(), Timing(rate_hz=100.0))
    z, minus_y, x = (int(field) for field in line.split(b";")[1].split(b"*")[0].split(b",")[-6:-3])
    assert log.outputs.tolist() == [[x, -minus_y, z]] and len(log.notes) == 1
    assert not any(note.startswith("left out") for note in log.notes)


def test_latin_1_decimal_commas_time_of_day_and_a_delimiter_at_the_end(imported, logged):
    lines = ["Messger\xe4t;7", "Uhrzeit;Kanal 1 [m\xb2];Kanal 2;Kanal 3"]
    for t, outputs in zip(logged.time_s.tolist(), logged.outputs.tolist()):
        second = t + 86390.0  # midnight comes
        clock = f"{int(second // 3600) % 24:02}:{int(second // 60) % 60:02}:{second % 60:06.3f}"
        lines.append(";".join([clock, *(f"{value:.6f}" for value in outputs), ""]).replace(".", ","))
    text = "\n".join(lines) + "\n"
    said, _ = imported(text.encode("latin-1"))
    assert "name what is missing with --columns ux=NAME,uy=NAME,uz=NAME" in said
    columns = "ux=Kanal 1 [m\xb2],uy=Kanal 2,uz=Kanal 3,time=Uhrzeit"
    said, means = imported(text.encode("latin-1"), options=("--columns", columns, "--unit", "V"))
    assert is_right(means), said
    assert "decimal mark: the comma" in said and "clock: set back 1 times, each step back counts as a gap" in said


def test_lost_samples_and_a_footer(imported, logged):
    head, *rows = logged.csv("t_ms,Ax,Ay,Az").splitlines()
    rows = [f"{1e3 * float(row.split(',')[0]):.3f},{row.split(',', 1)[1]}" for row in rows]
    for place in range(40, len(rows), 97):
        rows[place] = rows[place].rsplit(",", 1)[0] + (",NaN" if place % 2 else ",")
    text = "\n".join([head, *rows])
    said, _ = imported(text + "\nEnd of log\n")
    assert "1 fields, but the header has 4; delete the row, or begin it with #" in said
    said, means = imported(text + "\n# End of log\n")
    assert is_right(means) and "rows without a number in an output are left out" in said
    said, _ = imported(text.replace(".", ","))  # to delete the row would help nobody
    assert "8 fields, but the header has 4; if some of its commas are decimal marks, write" in said
    assert "delete" not in said


def test_blanks_between_columns_and_no_clock(imported, logged):
    rows = [f"  {x:12.6f}   {y:12.6f} {z:12.6f}" for x, y, z in logged.outputs.tolist()]
    text = "\n".join(["  Ax   Ay Az", *rows]) + "\n"
    said, _ = imported(text)
    assert "say what separates the columns with --delimiter" in said
    said, means = imported(text, options=("--delimiter", "space"))
    assert is_right(means) and "clock: none, so lengths are counted in samples" in said
    said, means = imported(text, options=("--delimiter", "space", "--rate", "50"))
    assert is_right(means) and "--window 0.4 s" in said


def test_a_counter_is_no_clock_and_a_clock_without_a_unit_is_told(imported, logged):
    rows = logged.csv().splitlines()[1:]
    numbered = [f"{number},{20 * number},{row.split(',', 1)[1]}" for number, row in enumerate(rows)]
    said, means = imported("\n".join(["n_samples,time,Ax,Ay,Az", *numbered]) + "\n")
    assert is_right(means), said
    told = " ".join(said.split())
    assert "column 'n_samples' counts samples: not read" in told
    assert "'time' names no unit, its steps of 20 are read as ms (--time-unit)" in told


def test_a_clock_that_stands_still(imported, logged):
    head, *rows = logged.csv().splitlines()
    text = "\n".join([head, *("7," + row.split(",", 1)[1] for row in rows)]) + "\n"
    said, _ = imported(text)
    assert "column 'time' does not increase: --rate HZ reads the recording without it" in said
    assert is_right(imported(text, options=("--rate", "50"))[1])


@pytest.mark.parametrize("value", ["1e308", "-1e308", "1e200", "1.1e100", "1e400"])
@pytest.mark.parametrize("column", ["time", "Ax", "Az"])
def test_numbers_beyond_any_output_are_refused(imported, logged, column, value):
    """They made numpy warn, on stderr, of overflows."""
    head, *rows = logged.csv().splitlines()
    place, fields = head.split(",").index(column), rows[700].split(",")
    fields[place] = value
    said, _ = imported("\n".join([head, *rows[:700], ",".join(fields), *rows[701:]]) + "\n")
    name = {"time": "time", "Ax": "ux", "Az": "uz"}[column]
    shown = repr(float(value)) if column == "time" else repr(value)
    assert said.endswith(f"log0.csv: row 702, column {name}: {shown} is out of range\n")


def test_numbers_just_within_are_read_without_a_warning(imported, logged):
    head, *rows = logged.csv().splitlines()
    for value in ("1e100", "-1e100"):
        fields = [*rows[700].split(",")[:3], value]
        said, _ = imported("\n".join([head, *rows[:700], ",".join(fields), *rows[701:]]) + "\n")
        assert "do not show" in said or "channels" in said or "import of" in said


@pytest.mark.parametrize(("option", "value"), [("--window", "20.5"), ("--window", "0.4"), ("--min-rest", "1.5")])
def test_seconds_without_a_clock(imported, logged, option, value):
    """They were passed over in silence."""
    head, *rows = logged.csv().splitlines()
    text = "\n".join(row.split(",", 1)[1] for row in (head, *rows)) + "\n"
    said, _ = imported(text, options=(option, value))
    advice = "without a clock it counts samples, a whole number; --rate HZ gives seconds"
    assert said == f"tumble: {option} {value}: {advice}\n"
    assert advice not in imported(text, options=(option, value, "--rate", "50"))[0]
    assert is_right(imported(text, options=(option, "24"))[1])


def test_no_such_time(imported, logged):
    text = logged.csv().replace("\n", "\nnoon,1,2,3\n", 1)
    said, _ = imported(text)
    assert "row 2, column time: 'noon' is not a time" in said and "--rate HZ reads" in said
    assert is_right(imported(text.replace("noon,1,2,3", "# noon"))[1])


def test_a_stand_file_is_no_recording(imported):
    assert "is TOML" in imported("[stand]\nname = 'x'\n")[0]


def test_other_schedules_are_advised(imported, logged):
    diagonal = built_in("diagonal")
    made = recording(diagonal, list(range(12)), NOMINAL_K, U0, QUIET, np.random.default_rng(5))
    said, _ = imported(made.csv())
    assert "no schedule is given" in said and "--schedule diagonal" in said
    said, means = imported(made.csv(), options=("--schedule", "diagonal"))
    assert list(means) == [(place.mounting, place.number) for place in diagonal.positions]
