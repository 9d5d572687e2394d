"""`tumble apply`: measured data in, the same data with the specific force behind it out."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any, BinaryIO

from tumble.cli import options
from tumble.errors import EXIT_PASS, BadInput, UsageError, file_name, quoted
from tumble.messages import tell, warn
from tumble.units import SI, force_unit

if TYPE_CHECKING:
    from tumble.documents.result import Temperature
    from tumble.files.calibrated import CsvData, Demand, Seen

_SOURCE = "source"  # as tumble import names it
_IN_MEMORY = 1 << 24  # bytes of output, before they go to a temporary file


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write measured data again with the acceleration in its last three columns, x, y, z: by K and U0 of"
        " a result, and by its further terms. Other columns are kept. Any layout that tumble import reads: text"
        " stays text, Parquet stays Parquet, other binary recordings become CSV."
    )
    parser.epilog = (
        "Several files are joined, or written into --out FOLDER one by one. Exit codes: 0 done, 2 bad input, 77"
        " a format cannot be read here, 130 interrupted."
    )
    parser.add_argument("result", metavar="RESULT.json", help="a result of tumble solve")
    parser.add_argument("data", metavar="DATA", nargs="+", help="files with columns ux,uy,uz, in the result's unit")
    parser.add_argument("--out", metavar="FILE", help="a file, or an existing folder; default: standard output")
    parser.add_argument(
        "--unit",
        type=force_unit,
        choices=("g", SI),
        default="g",
        help="of the acceleration; m/s2 needs gravity_m_s2 in the result's environment; default: g",
    )
    parser.add_argument(
        "--uncertainty",
        action="store_true",
        help="standard uncertainties of x, y, z and of their norm, by those of the coefficients, as columns u_x, u_y,"
        " u_z, u_norm before x",
    )
    layout = options.add_layout(parser, "data", has_unit=False)
    layout.add_argument("--rows", metavar="source=NAME", help="one of several sources in a binary recording")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Calibrate and write. Returns the exit code; raises TumbleError."""
    from tumble.api.result import demand_of, load
    from tumble.api.thermal import is_thermal, load_thermal
    from tumble.documents.result import Temperature
    from tumble.files.calibrated import OUTPUTS
    from tumble.files.disk import together
    from tumble.files.frames import PARQUET, suffix_of
    from tumble.files.run_layout import TEMPERATURE
    from tumble.solving.decision import complaints_of_result, phrase

    layout = replace(options.layout_options(arguments, (*OUTPUTS, TEMPERATURE), has_unit=False), wanted=OUTPUTS)
    targets = _targets(arguments)
    source = _parse_source(arguments.rows)
    kinds = {suffix_of(file) in PARQUET for file in arguments.data}
    if arguments.out is not None and not os.path.isdir(arguments.out):
        options.require_ending(arguments.out, "--out", *(PARQUET if kinds == {True} else (".csv", ".tsv")))
    if is_thermal(arguments.result):
        warm = load_thermal(arguments.result)
        demand = warm.demand(layout, arguments.unit, arguments.uncertainty)
        known_c: Temperature | None = Temperature(*warm.range_c, "run_file")
        complaints, assumes = warm.complaints, warm.checked.assumes
    else:
        result = load(arguments.result)
        complaints, assumes = complaints_of_result(result.checked), result.checked.assumes
        force = result.force(arguments.unit, arguments.uncertainty)
        told = "unit" not in result.assumes
        demand = demand_of(force, result.unit, arguments.uncertainty, layout, told, arguments.unit)
        known_c = result.checked.temperature
    if True in kinds and len(set(targets)) < len(targets):
        what = "CSV and Parquet" if len(kinds) > 1 else "Parquet files"
        raise UsageError(f"{what} cannot be joined: --out FOLDER keeps them apart")
    if True in kinds and arguments.out is None:
        raise UsageError("Parquet goes to a file: --out FILE")
    if arguments.out is None:
        import shutil
        import tempfile

        with tempfile.SpooledTemporaryFile(_IN_MEMORY) as spooled:  # no half of it on stdout where a row is bad
            _calibrate(arguments.data, spooled, demand, known_c, source)  # type: ignore[arg-type] # a BinaryIO in all but name
            spooled.seek(0)
            shutil.copyfileobj(spooled, sys.stdout.buffer)
            sys.stdout.buffer.flush()
    with together() as them:
        for target in dict.fromkeys(filter(None, targets)):
            with them.written(target) as out:
                own = [file for file, its in zip(arguments.data, targets) if its == target]
                _calibrate(own, out, demand, known_c, source)
    warn(complaints, arguments.result)
    if assumes:
        tell(f"tumble: notice: {file_name(arguments.result)}: {phrase(assumes).removeprefix(', ')}")
    return EXIT_PASS


def _targets(arguments: argparse.Namespace) -> list[str]:
    """Where each file of data goes: "" for standard output. Raises UsageError."""
    from tumble.files.disk import refuse_overwriting

    out, data = arguments.out, arguments.data
    into_folder = out is not None and os.path.isdir(out)
    targets = [os.path.join(out, _name_within(file)) if into_folder else out or "" for file in data]
    if into_folder and len(set(targets)) < len(targets):
        raise UsageError(f"--out: two files of data have the same name, and would be one in {quoted(out)}")
    for target in set(targets):
        refuse_overwriting(target, arguments.result, *data)
    return targets


def _name_within(file: str) -> str:
    """Of the calibrated data, in a folder: that of the file; of a binary recording with the ending of CSV."""
    from tumble.files.containers import kind_in
    from tumble.files.frames import PARQUET, suffix_of

    name = os.path.basename(os.path.normpath(file))
    return name if suffix_of(file) in PARQUET or kind_in(file) is None else f"{os.path.splitext(name)[0]}.csv"


def _parse_source(text: str | None) -> str | None:
    """Read `source=NAME`."""
    if text is None:
        return None
    column, _, name = text.partition("=")
    if column.strip() != _SOURCE or not name.strip():
        raise UsageError(f"--rows: {quoted(text)} is not {_SOURCE}=NAME")
    return name.strip()


def _data_of(file: str, demand: Demand, source: str | None) -> CsvData:
    """CSV, or the table of a binary recording as such. Raises BadInput, UsageError."""
    import io

    from tumble.files import containers
    from tumble.files.calibrated import CsvData
    from tumble.files.disk import bounded, opened

    kind = containers.kind_in(file)
    if kind is None:
        if source is not None:
            raise UsageError(f"--rows {_SOURCE}={source}: {file_name(file)} is text, which has one source")
        return CsvData(opened(file), file, demand)
    options = replace(demand.layout, delimiter=",", decimal=".")
    try:
        table = containers.chosen(containers.read(file, kind), kind, source, options, file)
    except BadInput as refusal:
        refusal.assumed = ()  # which is said of imports
        raise
    with bounded(file):
        return CsvData(io.BytesIO(table.text), file, replace(demand, layout=options))


def _calibrate(
    files: list[str], out: BinaryIO, demand: Demand, known_c: Temperature | None, source: str | None
) -> None:
    """All files into one output: the header of the first, the rows of all. `known_c`: temperature of the result."""
    from tumble.files.calibrated import calibrate_parquet
    from tumble.files.frames import PARQUET, suffix_of

    first: Any = None
    last = b"\n"
    for file in files:
        if suffix_of(file) in PARQUET:
            seen = calibrate_parquet(file, out, demand)
            _tell_of_names(seen.renamed, file)
            _tell_of_doubts(seen, known_c, demand, file)
            continue
        with contextlib.closing(_data_of(file, demand, source)) as data:
            if first is None:
                _tell_of_names(data.seen.renamed, file)
                if data.seen.notes:
                    tell(f"tumble: notice: {file_name(file)}: {'; '.join(data.seen.notes)}")
                out.write(data.header)
            else:
                data.require_header_of(first)
            first = first or data
            out.write(b"" if last == b"\n" else b"\n")  # a comment may end a file without one
            for piece in data.rows():
                out.write(piece)
                last = piece[-1:] or last
            _tell_of_doubts(data.seen, known_c, demand, file)


def _tell_of_doubts(seen: Seen, known_c: Temperature | None, demand: Demand, file: str) -> None:
    """Raises BadInput where nearly no rest comes out as one of 1 g."""
    from tumble.api.result import warnings_of

    if (refusal := seen.refusal(demand)) is not None:
        raise BadInput(refusal, file)
    if not seen.unit_told:
        taken = f"{demand.unit}, as in the result{'' if demand.unit_told else ', whose run names none either'}"
        tell(f"tumble: notice: {file_name(file)}: no unit in its header (as ux [V]): outputs taken for {taken}")
    warn(warnings_of(seen, known_c, demand), file)


def _tell_of_names(renamed: dict[str, str], file: str) -> None:
    if renamed:
        listed = ", ".join(f"{name} is {other}" for name, other in renamed.items())
        tell(f"tumble: notice: {file_name(file)}: columns of its own renamed: {listed}")
