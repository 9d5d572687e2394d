"""Which position of the schedule a row belongs to, by the numbers of its mounting and position.

The rows of a run file as numbers, block by block: plain lines by C, all others carefully, one by one.

C (binding/rows.c) takes lines of whose numbers it is certain, and stops at any other. That one is read here, which is
the one way that complains: so what C takes does not matter to what is accepted, and every complaint knows its line.
"""

from __future__ import annotations

import io
import itertools
import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput
from tumble.files import can_log
from tumble.files.disk import LONGEST_LINE, MIB, in_words
from tumble.files.incoming import NotANumber, Refused, row_of_numbers
from tumble.files.run_layout import (
    COLUMNS,
    NUMBER,
    Layout,
    Wishes,
    as_text,
    detect,
    detect_in_head,
    is_blank,
    is_comment,
    is_long_enough,
    is_number,
    require_text,
    split,
)
from tumble.files.run_temperature import HIGHEST_C, LOWEST_C, Temperatures, Thermometer
from tumble.schedule import Schedule

NUMBERS = 256  # of mountings and of positions: 0 to 255


class PositionIndex:
    """From mounting and position numbers to the index of a position in the schedule; `table` (256, 256), -1: none."""

    def __init__(self, schedule: Schedule):
        self.mountings = {mounting.number for mounting in schedule.mountings}
        self.table = np.full((NUMBERS, NUMBERS), -1, dtype=np.int32)
        for index, position in enumerate(schedule.positions):
            self.table[position.mounting, position.number] = index

    def of_arrays(self, mountings: Floats, positions: Floats) -> Integers:
        """Indices of many rows; -1 where a number is not whole or the schedule does not have it."""
        known = (mountings >= 0) & (mountings < NUMBERS) & (positions >= 0) & (positions < NUMBERS)
        known &= (mountings == np.floor(mountings)) & (positions == np.floor(positions))
        rows = np.where(known, mountings, 0).astype(np.intp)
        return np.where(known, self.table[rows, np.where(known, positions, 0).astype(np.intp)], -1)

    def of_row(self, mounting: float, position: float) -> int:
        """Index of one row. Raises Refused, saying what the schedule does not have."""
        for column, number in (("mounting", mounting), ("position", position)):
            if number != math.floor(number):
                raise Refused(f"{number!r} is not a whole number", column)
        if mounting not in self.mountings:
            hint = self._are_exchanged(mounting, position) or f"mountings are {listed(self.mountings)}"
            raise Refused(f"the schedule has no mounting {mounting:.15g}; {hint}", "mounting")
        index = int(self.table[int(mounting), int(position)]) if 0 <= position < NUMBERS else -1
        if index < 0:
            missing = f"the schedule has no position {position:.15g} in mounting {mounting:.15g}"
            known = np.flatnonzero(self.table[int(mounting)] >= 0).tolist()
            raise Refused(f"{missing}; positions are {listed(known)}", "position")
        return index

    def _are_exchanged(self, mounting: float, position: float) -> str | None:
        """A question, where the row would be good the other way round."""
        known = position in self.mountings and 0 <= mounting < NUMBERS
        is_good = known and self.table[int(position), int(mounting)] >= 0
        asked = "are mounting and position exchanged? Or is it a run of another schedule (--schedule)?"
        return asked if is_good else None


class Anywhere(PositionIndex):
    """For rows whose schedule is not known yet: every number is good; the index is 256 mounting + position."""

    def __init__(self) -> None:
        self.mountings = set(range(NUMBERS))
        self.table = np.arange(NUMBERS**2, dtype=np.int32).reshape(NUMBERS, NUMBERS)


def listed(numbers: Iterable[int]) -> str:
    """As "1 to 9", or all of them where some between are missing."""
    known = sorted(numbers)
    if known and len(known) > 2 and known[-1] - known[0] == len(known) - 1:
        return f"{known[0]} to {known[-1]}"
    return ", ".join(map(str, known)) or "none"


LONGEST_HEAD = 16 * MIB  # of comments and blank lines above the header
_SHORTEST_ROW = 10  # bytes: five fields of a digit each, and what ends them
_LINE_END = re.compile(rb"\r\n?|\n")

Part = tuple[Integers, Floats]  # of rows: index of the position (rows,); ux, uy, uz and number of the line (rows, 4)


class RunReader:
    """Goes through a run file once, given its bytes in blocks of any size; yields parts of rows. `layout` is known from
    the beginning; `blanks` and `comments` (lines) and `temperature` when all is read. `fast`: by C where that can be.

    Raises BadInput with row and column; a zero byte anywhere comes before other complaints.
    """

    def __init__(self, blocks: Iterable[bytes], positions: PositionIndex, wishes: Wishes, file: str, fast: bool = True):
        self._positions, self._file = positions, file
        self._blocks = iter(blocks)
        start = self._beginning()
        self._blocks = self._without_zeros(self._blocks, start.count(b"\n"))
        with _to_its_end(self._blocks):
            layout = detect_in_head(start, wishes, file)
            if layout is None:
                start = self._head(start)
                layout = detect(start, wishes, file)
        self.layout = layout
        self.blanks, self.comments = layout.blanks, layout.comments
        self._line, self._rows, self._marked = layout.header_row + 1, 0, False
        self._pieces = pieces(itertools.chain((_after_lines(start, layout.header_row),), self._blocks), file)
        self._thermometer = Thermometer(layout)
        self._plain = _Plain(layout, positions, self._thermometer) if fast and _can_be_plain(layout) else None

    def __iter__(self) -> Iterator[Part]:
        with _to_its_end(self._blocks):
            for piece in self._pieces:
                parts = list(self._parts(piece))
                if parts:
                    yield parts[0] if len(parts) == 1 else _joined(parts)
            if not self._rows:
                raise BadInput("no samples after the header", self._file, self.layout.header_row)

    @property
    def temperature(self) -> tuple[Temperatures | None, tuple[str, ...]]:
        """Of the rows, and sentences about a column that is passed over. Raises BadInput."""
        return self._thermometer.told(self._file)

    def _beginning(self) -> bytes:
        """Enough of it to find the layout in. Raises BadInput for what is no text."""
        start, blank = bytearray(), True
        for block in self._blocks:
            start += block
            blank = blank and block.isspace()
            if is_long_enough(start) and not start.endswith(b"\r") and not blank:
                break
            self._require_head(start)
        found = bytes(start)
        can_log.refuse(found, self._file)
        require_text(found, self._file)
        return found

    def _head(self, start: bytes) -> bytes:
        """What is left of a file without a header line in its beginning. Raises BadInput where that is much."""
        whole = bytearray(start)
        for block in self._blocks:
            whole += block
            self._require_head(whole)
        return bytes(whole)

    def _require_head(self, start: bytes | bytearray) -> None:
        if len(start) > LONGEST_HEAD:
            raise BadInput(f"no header line within {in_words(LONGEST_HEAD)}", self._file)

    def _without_zeros(self, blocks: Iterator[bytes], ends: int) -> Iterator[bytes]:
        """Raises BadInput for a zero byte; `ends`: of lines, before these blocks."""
        for block in blocks:
            zero = block.find(b"\0")
            if zero >= 0:
                raise BadInput("not a text file", self._file, ends + block.count(b"\n", 0, zero) + 1)
            ends += int(
                np.count_nonzero(np.frombuffer(block, dtype=np.uint8) == ord("\n"))
            )  # ten times as fast as count
            yield block

    def _parts(self, piece: bytes) -> Iterator[Part]:
        at = 0
        while at < len(piece):
            if self._plain is not None:
                taken, part, blanks = self._plain.take(piece, at, self._line)
                self.blanks += blanks
                self._rows += len(part[0])
                self._line += blanks + len(part[0])
                at += taken
                yield part
                if at == len(piece):
                    break
            end = piece.find(b"\n", at) + 1 or len(piece)
            yield from self._carefully(piece[at:end], piece[end:])
            at = end

    def _carefully(self, some: bytes, following: bytes) -> Iterator[Part]:
        """Some lines; `following`: what else is there of the piece."""
        lines = _lines(some)
        for line in lines:
            row = self._line
            self._line += 1
            if is_blank(line) or is_comment(line):
                self.blanks, self.comments = self.blanks + is_blank(line), self.comments + is_comment(line)
                continue
            try:
                index, outputs = self._read_row(line, row)
            except NotANumber as refused:
                after = map(_lines, itertools.chain((following,), self._pieces))
                rest = itertools.chain((line,), lines, itertools.chain.from_iterable(after))
                raise BadInput(f"{refused}{self._hint(refused, line, rest)}", self._file, row, refused.column) from None
            except Refused as refused:
                raise BadInput(str(refused), self._file, row, refused.column) from None
            self._rows += 1
            yield np.array([index], dtype=np.uint16), np.array([[*outputs, row]])

    def _read_row(self, line: str, row: int) -> tuple[int, list[float]]:
        layout = self.layout
        values = row_of_numbers(line, layout, COLUMNS)
        found = self._positions.of_row(*values[:2]), values[2:]
        fields = split(line, layout.delimiter)
        if self._thermometer.index is not None:
            self._thermometer.take(fields[self._thermometer.index], row)
        self._marked |= any(layout.decimal in fields[index] for index in layout.indices)
        return found

    def _hint(self, refused: NotANumber, line: str, rest: Iterable[str]) -> str:
        """What to do about it. Another option is advised only where all rows can be read with it: else one piece of
        advice would lead to the next. `rest`: the line and all after it."""
        if not self._rows and not any(map(is_number, split(line, self.layout.delimiter))):
            return " (a row of units? Delete it, or begin it with #; --unit says the unit)"
        if refused.column == "mounting":
            return f"; mountings are {listed(self._positions.mountings)}"
        if not NUMBER.fullmatch(re.sub(r"[.,\s']", "", refused.text)):
            return ""
        other = replace(self.layout, decimal="." if self.layout.decimal == "," else ",")
        if other.decimal in refused.text and not self._has_marks and _have_numbers_alone(rest, other):
            return f" (its decimal mark? see --decimal {other.decimal})"
        return " (write all numbers with the same decimal mark, and without thousands separators)"

    @property
    def _has_marks(self) -> bool:
        """Has a number of the rows so far a decimal mark? With another mark it would be none."""
        return self._marked or (self._plain is not None and self._plain.marked)


class _Plain:
    """What C needs to take lines of a layout, and has found so far."""

    def __init__(self, layout: Layout, positions: PositionIndex, thermometer: Thermometer):
        self._roles = np.full(layout.width, -1, dtype=np.int8)
        self._roles[list(layout.indices)] = np.arange(len(COLUMNS))
        self._thermometer, self._felt = thermometer, thermometer.index
        if self._felt is not None:
            self._roles[self._felt] = len(COLUMNS)
        self._layout = ffi.new(
            "rows_layout_t *",
            {
                "delimiter": layout.delimiter.encode(),
                "decimal": layout.decimal.encode(),
                "columns": layout.width,
                "role": ffi.from_buffer("int8_t[]", self._roles),
                "position": ffi.from_buffer("int32_t[]", positions.table),
                "coldest": LOWEST_C,
                "hottest": HIGHEST_C,
            },
        )
        self._kept = positions  # whose table C looks at
        self._found = ffi.new("rows_found_t *", {"low_c": math.inf, "high_c": -math.inf})
        self._index, self._values = np.empty(0, dtype=np.uint16), np.empty((0, len(COLUMNS) - 1))

    @property
    def marked(self) -> bool:
        """Had a number a decimal mark?"""
        return bool(self._found.marked)

    def take(self, piece: bytes, at: int, line: int) -> tuple[int, Part, int]:
        """The lines from `at`, where number `line` begins, up to the first that is not plain: bytes, rows, blank
        lines."""
        if self._felt is not None and self._thermometer.index is None:
            self._roles[self._felt], self._felt = -1, None
        size, found = len(piece) - at, self._found
        if len(self._index) < (room := size // _SHORTEST_ROW + 1):
            self._index, self._values = np.empty(room, dtype=np.uint16), np.empty((room, len(COLUMNS) - 1))
        index, values = ffi.from_buffer("uint16_t[]", self._index), ffi.from_buffer("double[][4]", self._values)
        lib.rows_parse(self._layout, ffi.from_buffer("char[]", piece) + at, size, line, index, values, found)
        self._thermometer.take_range(found.low_c, found.high_c)
        return found.bytes, (self._index[: found.rows].copy(), self._values[: found.rows].copy()), found.blanks


def _can_be_plain(layout: Layout) -> bool:
    return layout.decimal != layout.delimiter and layout.delimiter.isascii()


@contextmanager
def _to_its_end(blocks: Iterator[bytes]) -> Iterator[None]:
    """After a complaint the rest is looked at too, for what comes before all other complaints."""
    try:
        yield
    except BadInput:
        for _ in blocks:
            pass
        raise


def _after_lines(data: bytes, lines: int) -> bytes:
    """What follows so many lines."""
    ends = [match.end() for match in itertools.islice(_LINE_END.finditer(data), lines)]
    return data[ends[-1] :] if len(ends) == lines else b""


def pieces(blocks: Iterable[bytes], file: str) -> Iterator[bytes]:
    """The same bytes, cut where lines end. Raises BadInput for a line that does not end."""
    parts: list[bytes] = []
    held = 0
    for block in blocks:
        cut = block.rfind(b"\n") + 1 or block.rfind(b"\r", 0, len(block) - 1) + 1  # a last \r may be half an end
        if cut:
            yield b"".join((*parts, block[:cut]))
            parts, held = [], 0
        parts.append(block[cut:])
        held += len(block) - cut
        if held > LONGEST_LINE:
            raise BadInput(f"a line of more than {in_words(LONGEST_LINE)}", file)
    if last := b"".join(parts):
        yield last if last.endswith(b"\n") else last + b"\n"


def _joined(parts: list[Part]) -> Part:
    indices, values = zip(*parts)
    return np.concatenate(indices), np.concatenate(values)


def _lines(data: bytes) -> io.StringIO:
    return io.StringIO(as_text(data), newline=None)


def _have_numbers_alone(lines: Iterable[str], layout: Layout) -> bool:
    """Can all rows be read, as far as numbers go?"""
    for line in lines:
        try:
            if not is_blank(line) and not is_comment(line):
                row_of_numbers(line, layout, COLUMNS)
        except NotANumber:
            return False
        except Refused:
            continue
    return True
