"""Every bad stand or schedule file: exit 2, stdout empty, one line that names file and row, nothing left behind."""

import pytest
from conftest import EXAMPLES

pytestmark = pytest.mark.python

STAND = (EXAMPLES / "paper_stand.toml").read_text()
SCHEDULE = (EXAMPLES / "six_faces.toml").read_text()
DEEP = "x = " + "[" * 5000


def row_of(text, part):
    """The row (from 1) where a part of a text stands."""
    return text[: text.index(part)].count("\n") + 1


def changed(text, old, new, row=None):
    """A text with one part replaced, and the row that the complaint must name."""
    assert text.count(old) >= 1
    return text.replace(old, new, 1), row or f"row {row_of(text, old)}"


K_ROW = f"row {row_of(STAND, 'K = [')}"
LAST_ROW = f"row {STAND.count(chr(10)) + 2}"
THIRD_POSITION = f"row {row_of(SCHEDULE, '[[position]]                 # x up')}"

BAD_STANDS = {
    "empty": ("", "", "no table [stand]"),
    "binary": (b"[stand]\n\xff\xfe", "row 2", "not UTF-8"),
    "not TOML": (*changed(STAND, "level_rad = 2e-5", "level_rad 2e-5"), "not valid TOML"),
    "decimal comma": (*changed(STAND, "level_rad = 2e-5", "level_rad = 0,00002"), "a decimal point and no unit"),
    "unit": (*changed(STAND, "level_rad = 2e-5", "level_rad = 2e-5 rad"), "a decimal point and no unit"),
    "cut off": (STAND[: STAND.index("4e-4")], "row 7", "not valid TOML"),
    "cut off within an array": (f"{STAND}\nmore = [1, 2\n", f"row {STAND.count(chr(10)) + 3}", "unclosed array"),
    "key twice": (*changed(STAND, "noise_v =", "axis_tilt_rad ="), "not valid TOML"),
    "too deep": (DEEP, "row 1", "not valid TOML"),
    "unknown table": (*changed(STAND, "[accept]", "[limits]"), "unknown key 'limits'"),
    "unknown key": (
        *changed(STAND, "samples = 50", "sample = 50"),
        "unknown key 'sample' in [stand]; is samples meant?",
    ),
    "degrees": (
        *changed(STAND, "axis_tilt_rad", "axis_tilt_deg"),
        "unknown key 'axis_tilt_deg' in [stand]; is axis_tilt_rad meant? (a name states its unit)",
    ),
    "millivolts": (*changed(STAND, "noise_v", "noise_mv"), "unknown key 'noise_mv' in [stand]; is noise_v meant?"),
    "key in the wrong table": (*changed(STAND, "[accept]", "accept = 1"), "unknown key 'accept' in [block.true]"),
    "no key": (*changed(STAND, "remount_rad = 4e-4", "", "row 3"), "[stand] has no remount_rad"),
    "no limits kind": (*changed(STAND, 'limits = "sigma1"', "", "row 3"), "[stand] has no limits"),
    "unknown limits kind": (*changed(STAND, '"sigma1"', '"sigma2"'), '[stand] limits must be "sigma1" or "sigma3"'),
    "unknown remount": (*changed(STAND, "samples = 50", 'remount = "twice"\nsamples = 50'), "[stand] remount must be"),
    "text for a number": (*changed(STAND, "2e-5 ", '"2e-5" '), "[stand] axis_tilt_rad must be a number"),
    "true for a number": (*changed(STAND, "2e-5 ", "true "), "[stand] axis_tilt_rad must be a number, not 'True'"),
    "number for a text": (
        *changed(STAND, '"single-axis rotary stand of the paper"', "5"),
        "[stand] name must be a text",
    ),
    "name of two lines": (*changed(STAND, "single-axis rotary", r"a\nb"), "[stand] name must be a text of one line"),
    "negative": (
        *changed(STAND, "angle_rad = 4e-5", "angle_rad = -4e-5"),
        "[stand] angle_rad must be 0 to 0.5, not '-4e-05'",
    ),
    "nan": (*changed(STAND, "noise_v = 3e-4", "noise_v = nan"), "[stand] noise_v must be 0 to 1e+09, not 'nan'"),
    "infinite": (*changed(STAND, "noise_v = 3e-4", "noise_v = inf"), "[stand] noise_v must be 0 to 1e+09, not 'inf'"),
    "arc minutes as radians": (
        *changed(STAND, "level_rad = 2e-5", "level_rad = 20"),
        "[stand] level_rad must be 0 to 0.5",
    ),
    "no samples": (*changed(STAND, "samples = 50", "samples = 0"), "[stand] samples must be 1 to"),
    "half a sample": (*changed(STAND, "samples = 50", "samples = 2.5"), "[stand] samples must be a whole number"),
    "samples beyond int64": (*changed(STAND, "samples = 50", "samples = " + "9" * 30), "[stand] samples must be 1 to"),
    "noise beyond a double": (
        *changed(STAND, "noise_v = 3e-4", "noise_v = " + "9" * 400),
        "[stand] noise_v must be a number",
    ),
    "array for a table": (*changed(STAND, "[accept]", "[[accept]]"), "accept must be a table"),
    "scale of zero": (
        *changed(STAND, "scale_v_per_g = 2.0", "scale_v_per_g = 0"),
        "[block] scale_v_per_g must not be 0",
    ),
    "tiny scale": (
        *changed(STAND, "scale_v_per_g = 2.0", "scale_v_per_g = 1e-300"),
        "[block] scale_v_per_g must be of a size from 1e-09 to 1e+09",
    ),
    "huge range": (
        *changed(STAND, "misal", "range_v = 1e300\nmisal"),
        "[block] range_v must be of a size from 1e-09 to 1e+09",
    ),
    "bits": (*changed(STAND, "misal", "converter_bits = 64\nmisal"), "[block] converter_bits must be 8 to 32"),
    "K of two rows": (*changed(STAND, "  [-0.01874, 1.99762, 0.03318],\n", "", K_ROW), "[block.true] K must be 3 rows"),
    "K with a hole": (*changed(STAND, "[0.02561, -0.03706,", '[0.02561, "",', K_ROW), "[block.true] K must be 3 rows"),
    "U0 of two": (*changed(STAND, "0.01326, ", ""), "[block.true] U0 must be 3 numbers"),
    "motion": (STAND + "[motion]\nspeed = 3\n", LAST_ROW, "unknown key 'speed' in [motion]"),
    "negative motion": (STAND + "[motion]\nsettling_s = -1\n", LAST_ROW, "[motion] settling_s must be at least 0"),
    "environment": (STAND + "[environment]\ntemperature_k = 3\n", LAST_ROW, "is temperature_c meant?"),
    "temperature of text": (
        STAND + '[environment]\ntemperature_c = "20"\n',
        LAST_ROW,
        "temperature_c must be a number",
    ),
    "gravity in g": (STAND + "[environment]\ngravity_m_s2 = 1\n", LAST_ROW, "gravity_m_s2 must be 9.7 to 9.9"),
    "item of a list": (STAND + "[item]\nserial = [1]\n", LAST_ROW, "[item] serial must be a text, a number or a date"),
    "limit of zero": (*changed(STAND, "_g = 3e-4", "_g = 0"), "[accept] delta_g_limit_g must not be 0"),
    "limit of a mile": (*changed(STAND, "_g = 3e-4", "_g = 1609"), "[accept] delta_g_limit_g must be 0 to 1"),
    "limit in m/s^2": (*changed(STAND, "delta_g_limit_g", "delta_g_limit_m_s2"), "is delta_g_limit_g meant?"),
}

NINE_MORE = "".join(f"[[position]]\nmounting=1\nposition={p}\nangle_deg=0\n" for p in range(50, 90))
MANY = "".join(f"[[mounting]]\nnumber={n}\nmatrix=[[1,0,0],[0,1,0],[0,0,1]]\n" for n in range(3, 39))
ONE_MOUNTING = SCHEDULE[: SCHEDULE.index("[[position]]                 # y up")]

BAD_SCHEDULES = {
    "empty": ("", "", "no mounting"),
    "no positions": (SCHEDULE[: SCHEDULE.index("[[position]]")], "", "no position"),
    "positions are no array": (*changed(SCHEDULE, "[[position]]", "[position]", "row 17"), "not valid TOML"),
    "unknown key": (
        *changed(SCHEDULE, "angle_deg", "angle_rad"),
        "unknown key 'angle_rad' in [[position]]; is angle_deg meant?",
    ),
    "unknown use": (
        *changed(SCHEDULE, "angle_deg = 0", 'angle_deg = 0\nuse = "maybe"', "row 16"),
        '[[position]] use must be "fit" or "check"',
    ),
    "no angle": (*changed(SCHEDULE, "angle_deg = 90\n", "", THIRD_POSITION), "[[position]] has no angle_deg"),
    "text for an angle": (
        *changed(SCHEDULE, "angle_deg = 90", 'angle_deg = "90"'),
        "[[position]] angle_deg must be a number",
    ),
    "ten turns too far": (*changed(SCHEDULE, "angle_deg = 90", "angle_deg = 3601"), "angle_deg must be -3600 to 3600"),
    "nan": (*changed(SCHEDULE, "angle_deg = 90", "angle_deg = nan"), "angle_deg must be -3600 to 3600"),
    "number 0": (*changed(SCHEDULE, "position = 3", "position = 0"), "[[position]] position must be 1 to 255"),
    "number 256": (*changed(SCHEDULE, "position = 3", "position = 256"), "[[position]] position must be 1 to 255"),
    "position twice": (
        *changed(SCHEDULE, "position = 3", "position = 1", THIRD_POSITION),
        "[[position]] is refused: two mountings or two positions have the same number",
    ),
    "mounting twice": (
        *changed(SCHEDULE, "number = 2", "number = 1", "row 8"),
        "[[mounting]] is refused: two mountings",
    ),
    "mounting that is not there": (
        *changed(
            SCHEDULE, "mounting = 2", "mounting = 3", f"row {row_of(SCHEDULE, '[[position]]                 # y up')}"
        ),
        "[[position]] is refused: a position refers to a mounting",
    ),
    "mirror image": (
        *changed(SCHEDULE, "[0, 0, 1]]", "[0, 0, -1]]", "row 4"),
        "[[mounting]] is refused: a mounting matrix is not a proper rotation",
    ),
    "stretched": (
        *changed(SCHEDULE, "[0, 0, 1], [0, 1, 0]]", "[0, 0, 1.001], [0, 1, 0]]", "row 8"),
        "not a proper rotation",
    ),
    "skewed": (*changed(SCHEDULE, "[[1, 0, 0]", "[[1, 0, 1e-4]", "row 4"), "not a proper rotation"),
    "zero matrix": (
        *changed(SCHEDULE, "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "[[0,0,0],[0,0,0],[0,0,0]]", "row 4"),
        "proper rotation",
    ),
    "matrix of two rows": (*changed(SCHEDULE, "[[1, 0, 0], ", "["), "[[mounting]] matrix must be 3 rows of 3 numbers"),
    "matrix with infinity": (
        *changed(SCHEDULE, "[[1, 0", "[[inf, 0"),
        "[[mounting]] matrix must be 3 rows of 3 numbers",
    ),
    "tilt of 90": (
        *changed(SCHEDULE, "number = 1", "number = 1\naxis_tilt_deg = 90", "row 6"),
        "axis_tilt_deg must be -89 to 89",
    ),
    "too many positions": (
        SCHEDULE + NINE_MORE,
        f"row {SCHEDULE.count(chr(10)) + 30 * 4 + 1}",
        "[[position]] is refused: the schedule has no positions, or more",
    ),
    "too many mountings": (
        SCHEDULE + MANY,
        f"row {SCHEDULE.count(chr(10)) + 34 * 3 + 1}",
        "[[mounting]] is refused: the schedule has no positions, or more",
    ),
    "deficient rank": (ONE_MOUNTING, "", "these positions cannot identify K_xy, K_yy, K_zy"),
}


@pytest.mark.parametrize("case", BAD_STANDS)
def test_bad_stand_files(case, refused, tmp_path):
    check(refused, tmp_path, "--stand", BAD_STANDS[case])


@pytest.mark.parametrize("case", BAD_SCHEDULES)
def test_bad_schedule_files(case, refused, tmp_path):
    check(refused, tmp_path, "--schedule", BAD_SCHEDULES[case])


def check(refused, tmp_path, option, case):
    content, row, message = case
    file = tmp_path / "file.toml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    run = EXAMPLES / "paper_stand.csv"
    line = refused("solve", run, option, file, "--json", "--out", tmp_path / "result.json")
    assert f"file.toml: {row}" in line and message in line


def test_a_harmonic_estimator_on_six_faces(refused):
    run, schedule = EXAMPLES / "six_faces.csv", EXAMPLES / "six_faces.toml"
    line = refused("solve", run, "--schedule", schedule, "--estimator", "refined")
    assert line == f"tumble: {schedule}: lacks positions that refined needs; least_squares solves any schedule\n"


@pytest.mark.parametrize(
    ("option", "file", "message"),
    [
        ("--stand", "six_faces.toml", "is a schedule file (--schedule), not a stand file"),
        ("--schedule", "paper_stand.toml", "is a stand file (--stand), not a schedule file"),
    ],
)
def test_files_that_are_mixed_up(refused, option, file, message):
    line = refused("solve", EXAMPLES / "paper_stand.csv", option, EXAMPLES / file)
    assert line == f"tumble: {EXAMPLES / file}: {message}\n"


@pytest.mark.parametrize(("file", "row"), [("six_faces.toml", 4), ("paper_stand.toml", 3)])
def test_a_toml_file_is_no_run(refused, file, row):
    line = refused("solve", EXAMPLES / file)
    assert (
        line == f"tumble: {EXAMPLES / file}: row {row}: is TOML, such as a stand or a schedule file, and no run file\n"
    )


BROKEN = {
    "an array without =": 'matrix [[0, 0, 1], [1, 0, 0], [0, 1, 0]]\n[[mounting]]\nnumber = 1\n',
    "a list for a table": "stand, block, accept\n[stand]\nsamples = 50\n",
    "a quoted key": "1, 2, 3\n\"noise_v\" = 3e-4\n",
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_toml_is_not_called_csv(name, refused, tmp_path):
    """Its row is told instead."""
    (tmp_path / "stand.toml").write_text(BROKEN[name])
    said = refused("solve", EXAMPLES / "paper_stand.csv", "--stand", tmp_path / "stand.toml")
    assert "stand.toml: row 1" in said and "not valid TOML" in said and "CSV" not in said
