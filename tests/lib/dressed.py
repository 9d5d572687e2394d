"""Recordings as files of loggers that have their own ways: another header, another clock, rows out of order, rows in
which nothing was measured, counts without a sign. Nothing here is taken from tumble.importing."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Dressed:
    """`data`: of the file; `row_of_line`: of each line, from 1, the row of the recording, -1 where it is none; `scale`,
    `offset`: by what the outputs were multiplied, without what was taken off before."""

    data: bytes
    row_of_line: np.ndarray
    scale: float = 1.0
    offset: np.ndarray | float = 0.0


def dressed(recorded, kind, rng):
    """A file of this kind, one of KINDS."""
    return KINDS[kind](recorded, rng)


def _file(lines, header, rows=None, encoding="utf-8", end="\n", **more):
    """Lines of rows in this order (as they stand: all), below the lines of a header."""
    rows = np.arange(len(lines)) if rows is None else np.asarray(rows)
    data = (end.join([*header, *lines]) + end).encode(encoding)
    return Dressed(data, np.concatenate([np.full(1 + len(header), -1), rows]), **more)


def _numbers(outputs, digits=7):
    places = max(0, int(digits - np.floor(np.log10(np.abs(outputs).max()))))
    return [",".join(f"{value:.{places}f}" for value in row) for row in outputs.tolist()]


def _timed(recorded, time, form="{:.6f}", outputs=None):
    own = _numbers(recorded.outputs if outputs is None else outputs)
    return [f"{form.format(second)},{row}" for second, row in zip(time.tolist(), own)]


def plain(recorded, _):
    return _file(_timed(recorded, recorded.time_s), ["time,Ax,Ay,Az"])


def commented(recorded, _):
    return _file(_timed(recorded, recorded.time_s), ["# a logger", "#time [s],accel_x,accel_y,accel_z"])


def headless(recorded, _):
    return _file(_timed(recorded, recorded.time_s), [])


def clock_in(size, form, name):
    """A clock that counts by so many seconds, and is called so."""
    return lambda recorded, _: _file(
        _timed(recorded, (recorded.time_s - recorded.time_s[0]) / size, form), [f"{name},Ax,Ay,Az"]
    )


def epoch_ns(recorded, _):
    time = 1_700_000_000_000_000_000 + np.round((recorded.time_s - recorded.time_s[0]) * 1e9).astype(np.int64)
    return _file(_timed(recorded, time, "{:d}"), ["timestamp,Ax,Ay,Az"])


def dates(recorded, _):
    passed = 1e6 * (recorded.time_s - recorded.time_s[0])
    stamps = np.datetime64("2026-11-12T23:59:30") + passed.astype("timedelta64[us]")
    own = _numbers(recorded.outputs)
    told = [f"{text[8:10]}/{text[5:7]}/{text[:4]} {text[11:]}" for text in map(str, stamps)]
    return _file([f"{one},{row}" for one, row in zip(told, own)], ["Date,Ax,Ay,Az"])


def swapped(recorded, rng):
    order = np.arange(len(recorded.time_s))
    for place in np.flatnonzero(rng.random(len(order) // 2) < 0.1) * 2:
        order[place : place + 2] = order[place : place + 2][::-1]
    rows = _timed(recorded, recorded.time_s)
    return _file([rows[row] for row in order], ["time,Ax,Ay,Az"], order)


def newest_first(recorded, _):
    order = np.arange(len(recorded.time_s))[::-1]
    rows = _timed(recorded, recorded.time_s)
    return _file([rows[row] for row in order], ["time,Ax,Ay,Az"], order)


def bursts(recorded, _):
    """Sixteen rows at a time, at the time when they were fetched."""
    each = float(np.median(np.diff(recorded.time_s)))
    time = recorded.time_s - recorded.time_s[0]
    fetched = np.floor(time / (16 * each)) * 16 * each + 1e-3 * each * (np.arange(len(time)) % 16)
    return _file(_timed(recorded, np.maximum.accumulate(fetched)), ["time,Ax,Ay,Az"])


def zeros_at_the_ends(recorded, rng):
    each = float(np.median(np.diff(recorded.time_s)))
    before, after = rng.integers(50, 600, 2).tolist()
    first, last = recorded.time_s[[0, -1]]
    ends = first - each * np.arange(before, 0, -1), last + each * np.arange(1, after + 1)
    time = np.concatenate([ends[0], recorded.time_s, ends[1]])
    own = ["0,0,0"] * before + _numbers(recorded.outputs) + ["0,0,0"] * after
    rows = np.concatenate([np.full(before, -1), np.arange(len(recorded.outputs)), np.full(after, -1)])
    return _file([f"{second:.6f},{row}" for second, row in zip(time.tolist(), own)], ["time,Ax,Ay,Az"], rows)


def stuck(recorded, rng):
    """The last value is held for a while, elsewhere than at rest."""
    held, rows = recorded.outputs.copy(), np.arange(len(recorded.outputs))
    moving = np.flatnonzero(recorded.truth < 0)
    begin = int(rng.choice(moving[moving < len(held) - 200]))
    length = int(rng.integers(40, 150))
    held[begin : begin + length], rows[begin + 1 : begin + length] = held[begin], -1
    return _file(_timed(recorded, recorded.time_s, outputs=held), ["time,Ax,Ay,Az"], rows)


def with_column(name, of_row):
    """Another column, behind the clock."""

    def made(recorded, rng):
        rows = _timed(recorded, recorded.time_s)
        lines = [row.replace(",", f",{of_row(recorded, place, rng)},", 1) for place, row in enumerate(rows)]
        return _file(lines, [f"time,{name},Ax,Ay,Az"])

    return made


def encoder(recorded, place, rng):
    return f"{10.0 * recorded.truth[place] + rng.normal(0.0, 0.01):.4f}"


def thermometer(recorded, _):
    own = _numbers(recorded.outputs)
    rise = np.round(np.linspace(20.0, 20.8, len(own)), 1)
    return _file([f"{row},{degrees}" for row, degrees in zip(own, rise.tolist())], ["x,y,z,T"])


def unsigned(recorded, _):
    """Counts of 16 bits, where 1 g is 4096 or so."""
    largest = np.abs(recorded.outputs - recorded.u0).max()
    counts = np.round((recorded.outputs - recorded.u0) * 30000.0 / largest).astype(int) % 65536
    each = np.round(1e3 * (recorded.time_s - recorded.time_s[0])).astype(int)
    lines = [f"{ms},{x},{y},{z}" for ms, (x, y, z) in zip(each.tolist(), counts.tolist())]
    return _file(lines, ["time_ms,x,y,z"], scale=30000.0 / largest, offset=recorded.u0)


def toa5(recorded, _):
    header = ['"TOA5","station"', '"TS","Ax","Ay","Az"', '"s","m/(s^2)","m/(s^2)","m/(s^2)"', '"","Smp","Smp","Smp"']
    return _file(_timed(recorded, recorded.time_s), header)


def utf_16(recorded, _):
    return _file(_timed(recorded, recorded.time_s), ["time,Ax,Ay,Az"], encoding="utf-16")


def carriage_returns(recorded, _):
    rows = np.arange(len(recorded.outputs))
    made = _file(_timed(recorded, recorded.time_s), ["time,Ax,Ay,Az"], end="\r\r\n")
    made.row_of_line = np.concatenate([[-1, -1, -1], np.repeat(rows, 2)])
    return made


KINDS = {
    "plain": plain, "header in a comment": commented, "no header": headless,
    "clock in ms": clock_in(1e-3, "{:.3f}", "time"), "clock in us": clock_in(1e-6, "{:.0f}", "TimeUS"),
    "clock in min": clock_in(60.0, "{:.8f}", "time"), "clock in days": clock_in(86400.0, "{:.11f}", "Time"),
    "clock in s, named ms": clock_in(1.0, "{:.6f}", "time (ms)"),
    "clock in s, named us": clock_in(1.0, "{:.6f}", "time_us"),
    "epoch in ns": epoch_ns, "dates": dates, "rows exchanged": swapped, "newest first": newest_first, "bursts": bursts,
    "zeros at the ends": zeros_at_the_ends, "stuck for a while": stuck,
    "counter of 8 bits": with_column("counter", lambda _, place, __: place % 256),
    "angle of an encoder": with_column("angle", encoder), "T is a temperature": thermometer,
    "counts without their sign": unsigned, "TOA5": toa5, "UTF-16": utf_16, "CR CR LF": carriage_returns,
}  # fmt: skip
