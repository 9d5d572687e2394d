"""A result as a row of the history: numbers that neither the seat of the block nor the unit of its outputs changes.

K is split into a triangle and a turn, K = L Q. L, which is lower triangular, has the lengths of K's rows and the angles
between them, that is the block; Q is how it sat on its stand, kept as the vector of that turn. A block that sits turned
by a small phi has Q (I + [phi]x), and L as before.
"""

from __future__ import annotations

import hashlib
import json
import math
import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import UnsetType

from tumble.arrays import Floats
from tumble.documents.labels import is_believed, label, measured_s, seconds_of_day, serial_of
from tumble.documents.result import Result, parse_result
from tumble.errors import BadInput, UsageError, quoted
from tumble.model.coefficients import by_intrinsic, intrinsic
from tumble.store.codec import HAS_TEMPERATURE, HAS_UNCERTAINTY, HistoryEntry
from tumble.store.image import Image
from tumble.units import volts_per

PARAMETERS = (
    *(f"scale_{axis}" for axis in "xyz"),
    *(f"angle_{pair}" for pair in ("xy", "xz", "yz")),
    *(f"bias_{axis}" for axis in "xyz"),
    *(f"seat_{axis}" for axis in "xyz"),
)
OF_BLOCK = 9  # of these; the last three are of its seat
_TRIANGLE = np.tril_indices(OF_BLOCK)
ON_BOARD = "on board"  # in place of the estimator of a set that a computer made
_ROLLED_BACK, _DECAYED = 4, 6  # origins of an entry: a copy of an older set, an event
_OTHER_BLOCK_BEFORE = 0x8000  # a flag of an entry: those before are of another block
Row = dict[str, Any]


def row_of(data: bytes, file: str, serial: str | None = None, kind: str | None = None, date: str | None = None) -> Row:
    """A calibration by its JSON. `serial`, `kind` (the type of the block), `date` (YYYY-MM-DD): in place of what it
    says. Raises BadInput, UsageError."""
    told = parse_result(data, file)
    item = told.item or {}
    if not isinstance(told.prior, UnsetType) and told.prior.used:
        raise BadInput("rests on an earlier calibration, which would count twice: solve it without --prior", file)
    serial = serial or serial_of(told.serial, item)
    if serial is None:
        raise BadInput("names no block: write serial under [block] of the stand file, or give --serial NAME", file)
    covariance = _covariance(told)
    row: Row = {
        "sha256": hashlib.sha256(data).hexdigest(),
        "run_sha256": told.run_sha256,
        "serial": serial,
        "type": kind or label(item, "type", "model") or "",
        "stand": None if told.stand is None else told.stand.name,
        "created_s": seconds_of(date, "--date") if date else _created(told, file),
        "schedule": None if told.schedule is None else told.schedule.name,
        "estimator": told.estimator,
        "passed": told.passed,
        "believed": is_believed(told),
        "limit_g": told.verification.limit_g,
        "temperature_c": None if told.temperature is None else (told.temperature.min_c + told.temperature.max_c) / 2.0,
        "gravity_m_s2": (told.environment or {}).get("gravity_m_s2"),
        "u_norm_g": None if told.u_norm_g is None else told.u_norm_g.worst_g,
        "tumble": told.tumble,
    }
    try:
        row |= numbers_of(told.K * volts_per(told.unit), told.U0 * volts_per(told.unit), covariance)
    except (np.linalg.LinAlgError, ZeroDivisionError):
        raise BadInput("K cannot be inverted: no calibration", file) from None
    return row | {"document": zlib.compress(data, 1)}


def rows_of_image(image: Image, file: str, serial: str | None = None, kind: str | None = None) -> list[Row]:
    """The sets that became active, by the history in a memory of a navigation computer, of the block that it has now.
    Left out are those that a rollback gave up, copies that it restored, and those without a date. Raises BadInput."""
    serial = serial or (None if image.active is None else image.active.serial)
    if serial is None:
        raise BadInput("names no block: it has no active set: give --serial NAME", file)
    return rows_of_sets(image.history, file, serial, kind)


def rows_of_sets(history: Sequence[HistoryEntry], file: str, serial: str, kind: str | None = None) -> list[Row]:
    """The same of the entries of a history, newest first, as firmware/navcomp/keeper_values.c has it for its trend."""
    rows, given_up = [], 0
    for entry in history:
        if entry.origin == _DECAYED:
            continue
        was_given_up, is_copy = given_up > 0, entry.origin == _ROLLED_BACK
        given_up += is_copy - was_given_up
        if was_given_up or is_copy:
            continue
        if entry.date_utc_s is not None:
            rows.append(_row_of_entry(entry, serial, kind))
        if entry.flags & _OTHER_BLOCK_BEFORE:
            break
    if not rows:
        raise BadInput("no set with a date in the history of this memory", file)
    return rows


def _row_of_entry(entry: HistoryEntry, serial: str, kind: str | None) -> Row:
    """Nothing tells its stand, its schedule and what its coefficients have in common, which are taken as independent;
    numbers have 24 bits."""
    values, u = np.array(entry.values), np.array(entry.u)
    known = bool(entry.flags & HAS_UNCERTAINTY)
    name = json.dumps([serial, entry.sequence, entry.date_utc_s, entry.values])
    return {
        "sha256": hashlib.sha256(name.encode()).hexdigest(),
        "serial": serial,
        "type": kind or "",
        "created_s": entry.date_utc_s,
        "estimator": ON_BOARD,
        "passed": True,
        "believed": True,
        "temperature_c": entry.temperature_c if entry.flags & HAS_TEMPERATURE else None,
        **numbers_of(values[:9].reshape(3, 3), values[9:], np.diag(u**2) if known else None),
    }


def numbers_of(k: Floats, u0: Floats, covariance: Floats | None) -> Row:
    """Parameters, their standard uncertainties and covariance, of K (3, 3), U0 (3,) and the covariance (12, 12) of
    both."""
    if not np.abs(np.linalg.det(k)) > 0.0:
        raise np.linalg.LinAlgError
    scale, angles, bias = intrinsic(k, u0)
    lower, turn = _turn(k)
    values = [*scale, *angles, *bias, *_seat(turn)]
    row: Row = dict(zip(PARAMETERS, map(float, values)))
    names = [f"u_{name}" for name in PARAMETERS]
    if covariance is None:
        return row | dict.fromkeys(names) | {"covariance": None}
    by_block = by_intrinsic(k, u0)
    by_block[:3] /= scale[:, None]  # relative, as trends and |a| have it
    gradients = np.concatenate([by_block, _by_seat(lower, turn, 1.0 if np.linalg.det(k) > 0.0 else -1.0)])
    joint = gradients @ covariance @ gradients.T
    row |= dict(zip(names, np.sqrt(np.maximum(np.diag(joint), 0.0)).tolist()))
    return row | {"covariance": packed(joint[:OF_BLOCK, :OF_BLOCK])}


def packed(covariance: Floats) -> bytes:
    """The lower triangle of a covariance (..., 9, 9) of the block's parameters, scales relative, as float64."""
    return np.ascontiguousarray(covariance[..., _TRIANGLE[0], _TRIANGLE[1]], dtype="<f8").tobytes()


def unpacked(texts: list[bytes]) -> Floats:
    """Covariances (n, 9, 9)."""
    lower = np.frombuffer(b"".join(texts), dtype="<f8").reshape(len(texts), -1)
    found = np.zeros((len(texts), OF_BLOCK, OF_BLOCK))
    found[:, _TRIANGLE[0], _TRIANGLE[1]] = lower
    found[:, _TRIANGLE[1], _TRIANGLE[0]] = lower
    return found


def seconds_of(date: str, option: str) -> int:
    """Of a day, in seconds since 1970 UTC. Raises UsageError."""
    try:
        return seconds_of_day(date)
    except ValueError:
        raise UsageError(f"{option}: {quoted(date)} is not a date such as 2026-07-31") from None


def _created(told: Result, file: str) -> int:
    """When it was measured: by a label `date` of the item or of the environment, else when it was solved."""
    try:
        found = measured_s(told.item, told.environment, told.created)
    except ValueError as error:
        raise BadInput(str(error), file) from None
    if found is None:
        raise BadInput("has no date (key created): give --date YYYY-MM-DD", file)
    return found


def _covariance(told: Result) -> Floats | None:
    """Of K row by row and U0, in V; without covariance that of independent coefficients."""
    if told.u_K is None or told.u_U0 is None:
        return None
    volts = volts_per(told.unit)
    if told.covariance is not None:
        return told.covariance * volts**2
    found: Floats = np.diag(np.concatenate([told.u_K.ravel(), told.u_U0]) * volts) ** 2
    return found


def _turn(k: Floats) -> tuple[Floats, Floats]:
    """L and the turn Q, whose determinant is 1, so that K is L Q or, of left-handed channels (det K < 0), -L Q."""
    q, triangle = np.linalg.qr(k.T)
    signs = np.sign(np.diag(triangle))
    lower, turn = (triangle.T * signs), (q * signs).T
    return lower, turn * np.sign(np.linalg.det(turn))


def _seat(turn: Floats) -> Floats:
    """The vector of the turn Q, rad: along its axis, as long as its angle."""
    values, vectors = np.linalg.eig(turn)
    axis = np.real(vectors[:, np.argmin(np.abs(values - 1.0))])
    cross = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = math.atan2(float(cross @ axis), float(np.trace(turn)) - 1.0)
    found: Floats = axis * angle
    return found


def _by_seat(lower: Floats, turn: Floats, sign: float) -> Floats:
    """Derivatives (3, 12) of a small turn of the seat, about the block's axes, by the coefficients: what of
    L^-1 dK Q^T lies above the diagonal can be no part of L. `sign`: of det K."""
    by_k = sign * np.einsum("ri,cj->rcij", np.linalg.inv(lower), turn)  # L^-1 dK Q^T by K_ij
    above = np.stack([-by_k[1, 2], by_k[0, 2], -by_k[0, 1]]).reshape(3, 9)
    found = np.zeros((3, 12))
    found[:, :9] = turn.T @ above
    return found
