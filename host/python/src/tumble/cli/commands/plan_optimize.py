"""`tumble plan optimize`: the gain table that is best for a stand, for people, programs and the firmware.

A table bears the serial of the block that it was made for, a gain record a CRC of it. That is for people: nothing
checks it, as the firmware does not know which block is mounted.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tumble.cli.commands.plan_options import add_case_options, add_subject, read_case, write_json
from tumble.cli.options import Subparsers, refuse_model
from tumble.errors import EXIT_PASS, UsageError, quoted
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.schedule import file_of

if TYPE_CHECKING:
    from tumble.arrays import Floats
    from tumble.documents.plan import Optimize
    from tumble.planning.optimize import Optimized


def add_to(subparsers: Subparsers) -> None:
    """Describe the subject to argparse."""
    parser = add_subject(
        subparsers,
        "optimize",
        run,
        help="the weights that are best for a stand: a gain table for `optimal`",
        description="The gain table of the optimal estimator for a stand, and how much better it is than refined.",
    )
    add_case_options(parser, choose_estimator=False, extendable=False)
    parser.set_defaults(estimator=OPTIMAL)
    refuse_model(
        parser,
        "the firmware's gains are for twelve coefficients; further terms are for other plans",
    )
    parser.add_argument(
        "--result",
        metavar="RESULT.json",
        help="linearise at the K of this result, the block's last known; default: its nominal K",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        help="also write the table: .json, .h (a C header) or .bin (a gain record for non-volatile memory)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Optimize and print. Returns the exit code; raises TumbleError."""
    kind = _kind(arguments.out)

    from tumble.files.disk import refuse_overwriting, write_bytes
    from tumble.planning import optimize

    refuse_overwriting(arguments.out, arguments.stand, file_of(arguments.schedule), arguments.result)
    case = read_case(arguments)
    k = None if arguments.result is None else _last_known_k(arguments.result)
    found = optimize.optimize(case, k, _serial(arguments.stand))
    document = optimize.document(found)
    if kind is not None:
        write_bytes(arguments.out, _content(kind, found, document))
    if arguments.json:
        write_json(document)
    else:
        _show(found)
    return EXIT_PASS


def _show(found: Optimized) -> None:
    import numpy as np

    from tumble.planning import tables
    from tumble.planning.promise import sentence
    from tumble.stand import per_channel

    out, record = tables.console(), found.record
    other = "least_squares" if found.u_refined is None else "refined"
    u_other = found.u_least_squares if found.u_refined is None else found.u_refined
    noise = ", ".join(f"{sigma:.2g}" for sigma in np.atleast_1d(per_channel(record.sigma_mean / record.weights)))
    angles = ", ".join(f"{sigma:.3g}" for sigma in record.sigma)
    out.print(tables.heading(f"Optimal weights: {record.fit_positions} fit positions in {record.mountings} mountings"))
    out.print(f"Standard deviations: alpha1 to alpha4 {angles} rad, a mean's noise {noise} V")
    rows = [
        (name, "V/g" if name.startswith("K") else "V", f"{u:.3e}", f"{old:.3e}", f"{old / u:.2f}", f"{efficiency:.4f}")
        for name, u, old, efficiency in zip(COEFFICIENTS, found.u, u_other, found.efficiency)
    ]
    headings = ("", "unit", "u, optimal", f"u, {other}", "gain", "efficiency")
    out.print(tables.table(headings, rows, left=(0, 1)))
    if (note := found.case.rounding_sentence) is not None:
        out.print(note)
    out.print(sentence(found.promise))
    if found.table.floored:
        out.print("Beware: the stand declares no noise; weights for 1e-9 g of it mean little.", style="yellow")
    for complaint in found.second_order.complaints:
        out.print(f"Beware: {complaint}", style="yellow")


def _kind(out: str | None) -> str | None:
    if out is None:
        return None
    kind = next((kind for kind in (".json", ".h", ".bin") if out.endswith(kind)), None)
    if kind is None:
        raise UsageError(f"--out: {quoted(out)} ends in none of .json, .h, .bin")
    return kind


def _content(kind: str, found: Optimized, document: Optimize) -> bytes:
    from tumble.documents.base import to_json
    from tumble.solving import optimal_run

    if kind == ".bin":
        return optimal_run.to_bytes(found.record)
    text = to_json(document) if kind == ".json" else optimal_run.to_c_header(found.record, found.case.stand.name)
    return text.encode("utf-8")


def _last_known_k(file: str) -> Floats:
    """K (3, 3) in V/g of a result file."""
    import numpy as np

    from tumble.errors import BadInput
    from tumble.files.documents import read_coefficients
    from tumble.units import noise_unit, volts_per

    result = read_coefficients(file)
    if noise_unit(result["unit"]) != "V":
        raise BadInput(f"K is in {quoted(result['unit'])} per g; a gain table needs volts", file)
    return np.array(result["K"], dtype=float) * volts_per(result["unit"])


def _serial(stand: str | None) -> str | None:
    """The block's serial that a stand file states: the record is then for this block only."""
    if stand is None:
        return None
    from tumble.files.stand_file import read_stand

    block = read_stand(stand).block
    assert block is not None  # read_case has asked for it
    serial: str | None = block["serial"]
    return serial
