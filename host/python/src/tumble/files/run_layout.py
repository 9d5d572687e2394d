"""How a run file is laid out: header, delimiter, decimal mark, which column is which, and the unit of the outputs.

What the user says wins; the rest is read off the header line and the first rows.
"""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

from tumble.errors import BadInput, listed, quoted
from tumble.files.disk import JSON, TOML
from tumble.units import UNIT, are_at_odds, is_known, spelled

COLUMNS = ("mounting", "position", "ux", "uy", "uz")
TEMPERATURE = "temperature"  # a column that need not be there
DEFAULT_UNIT = "V"
DECIMALS = (".", ",")
UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # how its files begin
_UTF_8 = b"\xef\xbb\xbf"
_LINE_END = re.compile(rb"\r\n?|\n")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)

_HEAD_BYTES = 1 << 16
_ROWS_TO_LOOK_AT = 200
_LONGEST_HEADER = 400
_MOST_UNITS = 3  # rows of units and the like, below a header
NO_VALUE = {"", "nan", "-", "null", "none", "n/a"}  # what loggers write instead of one, in small letters, without sign
_BRACKETED = re.compile(r"[\[(]((?:[^\[\]()]|\([^\[\]()]*\))*)[\])]\s*$")  # m/(s^2) has its own
_TOML = re.compile(r"\s*(\[\[?[\w.]+\]\]?\s*(#.*)?$|[\w.]+\s*=)")
_TIME_UNITS = ("", "s", "sec", "ms", "msec", "us", "usec", "ns", "nsec", "min", "h", "d")
_CLOSEST = {"time": {f"time{unit}" for unit in _TIME_UNITS}}  # before others: a bench run has a timestamp as well
_ALIASES = {
    "mounting": {"mounting", "mount", "mountingno", "mountingnumber", "setup"},
    "position": {"position", "pos", "positionno", "positionnumber", "testposition"},
    "angle": {"angle", "angledeg", "tableangle", "tableangledeg", "phi", "phideg"},
    "number": {"number", "no", "nr", "n", "point", "step", "index", "sample", "samples", "nsamples", "sampleno"}
    | {"counter", "count", "row", "seq"},
    "time": {
        stem + unit
        for stem in ("time", "t", "timestamp", "ts", "elapsed", "elapsedtime", "clock", "datetime", "gpstime", "uptime")
        for unit in _TIME_UNITS
    },
    **{f"u{axis}": {f"{stem}{axis}" for stem in ("u", "out", "output", "acc", "accel", "a", "")} for axis in "xyz"},
    TEMPERATURE: {"temperature", "temp", "temperaturec", "tempc"},
}


_LAST = {  # where there is none of these
    "time": {"millis", "micros", "ms", "us", "ns", "sec", "seconds", "date", "uhrzeit", "zeit"},
    "mounting": {"face", "side", "orientation", "pose"},
}


@dataclass(frozen=True)
class LayoutOptions:
    """What the user says about a run file; whatever is empty or None is detected.

    `columns`: names of columns in the file, by name in COLUMNS or TEMPERATURE. `delimiter`: one character. `decimal`:
    "." or ",". `unit`: of the outputs. `wanted`: which of COLUMNS must be there, the outputs last. `has_preamble`:
    other rows may stand above the header.
    """

    columns: dict[str, str] = field(default_factory=dict)
    delimiter: str | None = None
    decimal: str | None = None
    unit: str | None = None
    wanted: tuple[str, ...] = COLUMNS
    has_preamble: bool = False


NO_LAYOUT_OPTIONS = LayoutOptions()


@dataclass(frozen=True)
class Column:
    """A column that need not be there: its `index`, its `name` in the file, `unit` in brackets there, empty if none;
    `told` by the user, not found."""

    index: int
    name: str
    unit: str
    told: bool


@dataclass(frozen=True)
class Layout:
    """A run file's layout. `header_row` counts lines from 1; `indices` are those of the wanted COLUMNS among `width`
    columns; the `unit` of the outputs is `unit_told`, or assumed. `temperature`: the column of that name, if there is
    one; `doubt`: why it is not known which one that is; `names`: of all columns."""

    header_row: int
    comments: int
    blanks: int
    delimiter: str
    decimal: str
    indices: tuple[int, ...]
    width: int
    unit: str
    unit_told: bool
    temperature: Column | None = None
    doubt: str | None = None
    names: tuple[str, ...] = ()


def is_delimiter(sign: object) -> bool:
    """Can this separate columns?"""
    return isinstance(sign, str) and len(sign) == 1 and sign not in '"#\r\n\0.+-' and not sign.isalnum()


def decoded(data: bytes) -> str:
    """Text of a file: UTF-8 with or without a mark, or else one byte a character (only names can differ then)."""
    return as_text(data.removeprefix(_UTF_8))


def as_text(data: bytes) -> str:
    """Of a part of a file that is not its beginning."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def body_of(data: bytes, lines: int) -> bytes:
    """What follows so many lines."""
    if lines == 0:
        return data.removeprefix(_UTF_8)
    ends = [match.end() for match in itertools.islice(_LINE_END.finditer(data), lines)]
    return data[ends[-1] :] if len(ends) == lines else b""


def split(line: str, delimiter: str) -> list[str]:
    """The fields of one line, quotes removed, blanks around them too. Raises csv.Error for a quote left open."""
    return [name.strip() for name in next(csv.reader((line,), delimiter=delimiter, strict=True), [])]


def require_text(data: bytes, file: str) -> None:
    """Raise BadInput for what is no text, or empty."""
    if data.startswith(UTF_16):
        raise BadInput("UTF-16 text; save it as UTF-8", file, 1)
    zero = data.find(b"\0")
    if zero >= 0:
        raise BadInput("not a text file", file, data.count(b"\n", 0, zero) + 1)
    if not data.strip():
        raise BadInput("the file is empty", file, 1)


def detect(data: bytes, options: LayoutOptions, file: str) -> Layout:
    """Find out how a run file is laid out. Raises BadInput."""
    found = detect_in_head(data, options, file) or _detect(data, options, file)
    if found is None:
        raise BadInput("no header line", file, len(lines_of(data)))
    return found


def is_long_enough(start: bytes | bytearray) -> bool:
    """Does `detect_in_head` find in this beginning of a file whatever it finds in all of it?"""
    return len(start) > _HEAD_BYTES and not start.endswith(b"\r") and not start.isspace()


def detect_in_head(data: bytes, options: LayoutOptions, file: str) -> Layout | None:
    """As `detect`, by the beginning alone; None if there is no header line in it."""
    head = data[:_HEAD_BYTES]
    if len(data) > len(head):
        head = head[: max(head.rfind(b"\n"), head.rfind(b"\r")) + 1]
    return _detect(head, options, file)


def lines_of(data: bytes) -> list[str]:
    """Of a file, without their ends."""
    return decoded(data).replace("\r\n", "\n").replace("\r", "\n").split("\n")


def _detect(head: bytes, options: LayoutOptions, file: str) -> Layout | None:
    """None if there is no header line in it."""
    lines = lines_of(head)
    blanks = comments = 0
    for row, line in enumerate(lines, start=1):
        if not line.strip():
            blanks += 1
        elif line.startswith("#"):
            comments += 1
        elif options.has_preamble and (bare := _without_header(row, lines, options)) is not None:
            return _from_header(*bare, (comments, blanks), options, file)
        else:
            return _from_header(row, line, lines[row:], (comments, blanks), options, file)
    return None


_OF_ROW = re.compile(r"[\d\s.,:/TZe+-]*\d[\d\s.,:/TZe+-]*|nan|", re.IGNORECASE)  # a number, a date, or nothing


def _without_header(row: int, lines: list[str], options: LayoutOptions) -> tuple[int, str, list[str]] | None:
    """Row, line and what follows of the header of a recording whose first line that is no comment, in this `row`, has
    numbers: the last comment above with as many fields, else one that is made up; None: its line is a header."""
    for sign in [options.delimiter] if options.delimiter else [",", ";", "\t"]:
        fields = [field.strip() for field in lines[row - 1].split(sign)]
        numbers = sum(map(is_number, fields))
        if numbers < len(options.wanted) or not all(map(_OF_ROW.fullmatch, fields)):
            continue
        for above in range(row - 1, 0, -1):
            names = lines[above - 1].lstrip("# ").split(sign)
            if lines[above - 1].startswith("#") and len(names) == len(fields):
                return above, sign.join(names), lines[row - 1 :]
        return row - 1, sign.join(_made_up(fields, lines[row - 1 :], sign, options)), lines[row - 1 :]
    return None


def _made_up(first: list[str], following: list[str], sign: str, options: LayoutOptions) -> list[str]:
    """Names of columns that have none: their numbers, from 1; where the user names no output by these, a column that
    counts by one is n, another that counts the time, and the next three are the outputs."""
    names = [str(number) for number in range(1, len(first) + 1)]
    if set(options.wanted) & set(options.columns):
        return names
    rows = [line.split(sign) for line in following[:_ROWS_TO_LOOK_AT] if line.strip() and not line.startswith("#")]
    columns = list(zip(*(row for row in rows if len(row) == len(first))))
    left = [*options.wanted[-3:], *names]
    roles = {"n", "time"} if len(first) > len(options.wanted) else set()
    for place, texts in enumerate(columns):
        values = [float(text.replace(",", ".")) if is_number(text.strip()) else None for text in texts]
        steps = [b - a for a, b in itertools.pairwise(values) if a is not None and b is not None]
        counts = bool(steps) and min(steps) >= 0.0 < max(steps)
        role = "n" if counts and set(steps) == {1.0} else "time"
        if (counts or not steps) and role in roles:
            names[place] = role
            roles.remove(role)
        elif left[0] in options.wanted:
            names[place] = left.pop(0)
    return names


def _from_header(
    row: int, line: str, following: list[str], skipped: tuple[int, int], options: LayoutOptions, file: str
) -> Layout:
    if any(not (sign.isprintable() or sign == "\t") for sign in line):
        raise BadInput("not a text file", file, row)
    candidates = [options.delimiter] if options.delimiter else [",", ";", "\t"]
    attempts = []
    for delimiter in candidates:
        try:
            names = split(line, delimiter)
            indices = find_all(names, options)
        except (csv.Error, ValueError) as error:
            attempts.append((line.count(delimiter), str(error)))
            continue
        decimal = options.decimal or _detect_decimal(following, delimiter, indices)
        unit = unit_of(options, [names[index] for index in indices[-3:]], file, row)
        told = unit or DEFAULT_UNIT, unit is not None
        felt = temperature_column(names, options.columns)
        return Layout(row, *skipped, delimiter, decimal, indices, len(names), *told, *felt, tuple(names))
    fields = re.split(r"[,;\t]", line)
    if all(NUMBER.fullmatch(name.strip()) for name in fields):
        raise BadInput(f"no header line; the first line must name the columns {','.join(options.wanted)}", file, row)
    below = _rows_above_header([line, *following], candidates, options)
    if _TOML.match(line) and not (below and options.has_preamble):
        raise BadInput(f"is {TOML}, and no run file", file, row)
    if line.lstrip().startswith("{"):
        raise BadInput(f"is {JSON}, and no run file", file, row)
    if below:
        if options.has_preamble:
            return _from_header(row + below, following[below - 1], following[below:], skipped, options, file)
        advice = "delete the rows above it, or begin each of them with #"
        raise BadInput(f"is no header; row {row + below} looks like it: {advice}", file, row)
    raise BadInput(max(attempts)[1], file, row)


def _rows_above_header(lines: list[str], delimiters: list[str], options: LayoutOptions) -> int:
    """How many rows of something else, as loggers write them, are above what must be the header; 0: none, or nothing
    looks like one."""
    filled = [(row, line) for row, line in enumerate(lines) if line.strip()][:_ROWS_TO_LOOK_AT]
    for is_header in (_has_columns, _is_above_numbers):
        for place, (row, line) in enumerate(filled):
            following = [below for _, below in filled[place + 1 : place + 3]]  # units may stand between
            if any(is_header(line, following, delimiter, options) for delimiter in delimiters):
                return row
    return 0


def _has_columns(line: str, _following: list[str], delimiter: str, options: LayoutOptions) -> bool:
    try:
        find_all(split(line, delimiter), options)
    except (csv.Error, ValueError):
        return False
    return True


def _is_above_numbers(line: str, following: list[str], delimiter: str, options: LayoutOptions) -> bool:
    """As many different names as there are fields in a row of numbers below?"""
    try:
        names, rows = split(line, delimiter), [split(below, delimiter) for below in following]
    except csv.Error:
        return False
    alike = [sum(map(is_number, row)) for row in rows if len(row) == len(names) == len(set(names))]
    return not any(map(is_number, names)) and max(alike, default=0) >= len(options.wanted)


def is_number(text: str) -> bool:
    """With either decimal mark."""
    return NUMBER.fullmatch(text.replace(",", ".")) is not None


def temperature_column(names: list[str], renamed: dict[str, str]) -> tuple[Column | None, str | None]:
    """The column of the temperature, and why it is not known; that a told one is there, is known."""
    try:
        index = find_column(TEMPERATURE, names, renamed)
    except ValueError as several:
        return None, str(several)
    if index is None:
        return None, None
    unit = _BRACKETED.search(names[index])
    return Column(index, names[index], "" if unit is None else unit.group(1).strip(), TEMPERATURE in renamed), None


def find_all(names: list[str], options: LayoutOptions, is_text: bool = True) -> tuple[int, ...]:
    """Indices of the wanted COLUMNS. `is_text`: the names were one line, which a delimiter separates. Raises
    ValueError, naming all that are not there, and what is."""
    renamed = options.columns
    told_beside = [TEMPERATURE] if renamed.get(TEMPERATURE) else []
    found = {wanted: find_column(wanted, names, renamed) for wanted in (*options.wanted, *told_beside)}
    missing = [wanted for wanted, index in found.items() if index is None]
    if not missing:
        for index in found.values():
            alike = [wanted for wanted, its in found.items() if its == index]
            if len(alike) > 1:
                name = quoted(names[index or 0])
                raise ValueError(f"column {name} is named for {listed(alike)}; each has one of its own")
        return tuple(index for wanted, index in found.items() if index is not None and wanted != TEMPERATURE)
    told = [wanted for wanted in missing if wanted in renamed]
    plain = [wanted for wanted in missing if wanted not in renamed]
    asked = [f"{_columns([quoted(renamed[wanted]) for wanted in told])} (for {listed(told)})"] if told else []
    header = quoted(",".join(names), _LONGEST_HEADER)
    said = f"{' and '.join([*asked, *([_columns(plain)] if plain else [])])} among {header}"
    if len(names) == 1 and is_text:
        raise ValueError(f"{said}; say what separates the columns with --delimiter")
    if plain:
        said += f"; name what is missing with --columns {','.join(f'{wanted}=NAME' for wanted in plain)}, or add it"
    if "position" in plain and any(name.strip().lower().startswith("angle") for name in names):
        said += "; a position is counted from 1 in its mounting, its angle is the schedule's"
    if missing == list(COLUMNS[:2]):
        said += "; tumble import makes a run file of a logger's recording"
    raise ValueError(said)


def _columns(names: list[str]) -> str:
    return f"no column{'s' if len(names) > 1 else ''} {listed(names)}"


def find_column(wanted: str, names: list[str], renamed: dict[str, str]) -> int | None:
    """Index of a column: by the user's name for it, else by its own, else by one that means the same; None: it is not
    there. Raises ValueError where there are several."""
    asked = renamed.get(wanted)
    if asked == "":
        return None  # it is not to be read
    plain = [_BRACKETED.sub("", name).strip() for name in names]  # u_x may be the uncertainty of x, beside ux
    bare = list(map(_bare, plain))
    tests: list[Callable[[int], bool]] = (
        [
            lambda i: names[i] == asked,
            lambda i: names[i].lower() == asked.lower(),
            lambda i: plain[i].lower() == asked.lower(),  # without its unit
        ]
        if asked
        else [
            lambda i: plain[i] == wanted,
            lambda i: plain[i].lower() == wanted,
            lambda i: bare[i] == wanted,
            lambda i: bare[i] in _CLOSEST.get(wanted, ()),
            lambda i: bare[i] in _ALIASES[wanted],
            lambda i: _bare(unit_in(names[i])[0]) in _ALIASES[wanted],  # accel_x_mg
            lambda i: bare[i] in _LAST.get(wanted, ()),
        ]
    )
    for test in tests:
        found = [index for index in range(len(names)) if test(index)]
        if len(found) == 1:
            return found[0]
        if found:
            if len({names[index] for index in found}) == 1:
                raise ValueError(f"{len(found)} columns are named {quoted(names[found[0]])}")
            several = " and ".join(quoted(names[index]) for index in found)
            raise ValueError(f"columns {several} could both be {wanted}; say which with --columns {wanted}=NAME")
    return None


def _bare(name: str) -> str:
    """`U_x` is `ux`."""
    return re.sub(r"[\s_.-]", "", name).lower()


def unit_in(name: str) -> tuple[str, str]:
    """A column's name and its unit, empty if it has none: in brackets, or a known one behind a sign, as `ax_mg`."""
    if (found := _BRACKETED.search(name)) is not None:
        return name[: found.start()].strip(), spelled(found[1].strip())
    stem, sign, unit = max((name.rpartition(sign) for sign in "_/,"), key=lambda parts: len(parts[0]))
    return (stem.strip(), spelled(unit.strip())) if sign and stem and is_known(unit.strip()) else (name, "")


def unit_of(options: LayoutOptions, names: list[str], file: str, row: int | None, option: str = "--unit") -> str | None:
    """The unit of the outputs: the one that the user says by this `option`, else the one behind their names (unit_in);
    None where neither is there. Raises BadInput for a known unit in brackets that is not the user's, and where the
    three differ and the user says nothing."""
    units = {unit_in(name)[1] for name in names}
    if options.unit is None and len(units) > 1:
        raise BadInput(f"outputs in different units: {', '.join(map(quoted, names))}; {option} says which", file, row)
    told = units.pop()
    if options.unit is None:
        return told if UNIT.fullmatch(told) else None
    if not units and are_at_odds(told, options.unit):
        advice = f"no number is converted: leave {option} out, or correct the names"
        raise BadInput(f"outputs are named in {told}, but {option} says {options.unit}; {advice}", file, row)
    return options.unit


def _detect_decimal(lines: list[str], delimiter: str, indices: tuple[int, ...]) -> str:
    """A comma if the first output with a mark has one that is no point."""
    for line in lines[:_ROWS_TO_LOOK_AT]:
        try:
            fields = [] if line.startswith("#") else split(line, delimiter)
        except csv.Error:
            continue
        for index in indices[-3:]:
            mark = set(fields[index] if index < len(fields) else "") & {".", ","}
            if mark:
                return mark.pop() if len(mark) == 1 else "."
    return "."


# What a recording may have, beside a run file.


def has_header(data: bytes, layout: Layout) -> bool:
    """Do the names of its columns stand there, or are they made up?"""
    if layout.header_row == 0:
        return False
    try:
        names = split(lines_of(data)[layout.header_row - 1].lstrip("# "), layout.delimiter)
    except csv.Error:
        return False
    return tuple(names) == layout.names


def about_header(data: bytes, layout: Layout, options: LayoutOptions) -> list[str]:
    """Where it is, or that there is none."""
    row = layout.header_row
    if not has_header(data, layout):
        taken = ",".join(f"{name}={place + 1}" for name, place in zip(options.wanted[-3:], layout.indices[-3:]))
        return [f"header: none, columns are numbered from 1: {taken} (--columns)"]
    if lines_of(data)[row - 1].startswith("#"):
        return [f"header: the comment in row {row}"]
    return [f"header: row {row}; the rows above it are not read"] if row - layout.comments - layout.blanks > 1 else []


def below_units(data: bytes, layout: Layout, options: LayoutOptions, file: str) -> tuple[Layout, list[str], list[str]]:
    """The layout with a row of units taken for a part of the header, if there is one, and what stands below it in
    words, as in TOA5; the units of all columns; sentences."""
    units, notes = [""] * layout.width, list[str]()
    for row, line in itertools.islice(rows_of(data, layout), _MOST_UNITS):
        try:
            fields = split(line, layout.delimiter)
        except csv.Error:
            break
        words = {field.lower() for field in fields}
        if any(map(is_number, fields)) or len(fields) < layout.width or words <= NO_VALUE:
            break
        layout = replace(layout, header_row=row)
        if notes:
            notes.append(f"row {row} is not read")
            continue
        units = [field.strip("[]") if "(" in field[1:] else field.strip("[]()") for field in fields]
        unit = unit_of(options, [f"[{units[index]}]" for index in layout.indices], file, row)
        felt = layout.temperature
        if felt is not None and not felt.unit and units[felt.index].lower() not in NO_VALUE:
            felt = replace(felt, unit=units[felt.index])
        told = layout.unit_told or unit is not None
        layout = replace(layout, unit=unit or layout.unit, unit_told=told, temperature=felt)
        notes.append(f"row {row} is read as units" + (f": {unit}" if unit else ""))
    return layout, units, notes


def rows_of(data: bytes, layout: Layout) -> Iterator[tuple[int, str]]:
    """What follows the header, without comments and blank lines: numbers of lines and their text."""
    body = as_text(body_of(data, layout.header_row))
    for row, line in enumerate(io.StringIO(body, newline=None), start=layout.header_row + 1):
        if line.strip() and not line.startswith("#"):
            yield row, line
