"""A calibration applied to data in memory: arrays, and tables with named columns."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from tumble.api.arguments import require_unit, wishes_of
from tumble.arrays import Floats
from tumble.documents.result import Temperature
from tumble.errors import BadInput, UsageError
from tumble.files import frames
from tumble.files.calibrated import OUTPUTS, Demand, Seen, factor_of, with_calibrated
from tumble.files.run_layout import Wishes
from tumble.model.coefficients import Force, NoForce
from tumble.solving.plausibility import outside
from tumble.units import per_g_of, spelled


def values_of(force: Force, outputs: Floats, with_uncertainty: bool, name: str = "data") -> Floats:
    """x, y, z, then with uncertainty u_x, u_y, u_z, u_norm, of outputs (samples, 3) in the unit of the result."""
    try:
        found = force.of(outputs)
    except NoForce as error:
        raise BadInput(str(error), name, int(error.rows[0]) + 1) from None
    return np.concatenate([found, force.uncertainty(found)], axis=1) if with_uncertainty else found


def applied(
    force: Force,
    data: Any,
    unit: str,
    with_uncertainty: bool,
    columns: dict[str, str] | None,
    outputs_unit: str | None,
    known_c: Temperature | None,
    unit_told: bool,
    of_force: str,
) -> Any:
    """As Result.apply; `unit`: of the result's outputs, `unit_told` or assumed; `known_c`: its temperature; `of_force`:
    the unit of the acceleration."""
    outputs_unit = spelled(outputs_unit) if isinstance(outputs_unit, str) else outputs_unit
    require_unit(outputs_unit, "outputs_unit")
    wishes = wishes_of(columns, outputs_unit, wanted=OUTPUTS)
    demand = demand_of(force, unit, with_uncertainty, wishes, unit_told, of_force)
    if frames.is_table(data):
        name, seen = frames.library_of(data) or "table", Seen()
        found = with_calibrated(data, name, demand, seen)
    else:
        name, seen = "data", Seen(unit_told=outputs_unit is not None)
        found = _of_array(force, data, unit, with_uncertainty, outputs_unit)
        seen.weigh(found.reshape(-1, found.shape[-1])[:, :3] / demand.one_g)
    for odd in doubts(seen, known_c, demand):
        warnings.warn(f"{name}: {odd}", stacklevel=3)
    return found


def doubts(seen: Seen, known_c: Temperature | None, demand: Demand) -> tuple[str, ...]:
    """What to warn of after data were calibrated. `known_c`: temperature of the result, None where it is not known."""
    told = outside(known_c, seen.temperatures_c), seen.doubt(demand)
    return (*seen.passed_over, *(one for one in told if one is not None))


def demand_of(
    force: Force, unit: str, with_uncertainty: bool, wishes: Wishes, unit_told: bool, of_force: str
) -> Demand:
    """What is to be done with a table, or with a file, of outputs; `unit`: of the result's, `unit_told` or assumed;
    `of_force`: the unit of the acceleration."""
    return Demand(
        lambda outputs: values_of(force, outputs, with_uncertainty),
        unit,
        with_uncertainty,
        wishes,
        unit_told,
        per_g_of(of_force),
    )


def _of_array(force: Force, data: Any, unit: str, with_uncertainty: bool, outputs_unit: str | None) -> Floats:
    try:
        outputs = frames.real(data)
    except (TypeError, ValueError):
        kind = f"{type(data).__module__}.{type(data).__name__}"
        raise UsageError(f"{kind} is neither an array of numbers nor a table with columns") from None
    if outputs.ndim < 1 or outputs.shape[-1] != 3:
        raise UsageError(f"an array of shape {outputs.shape} holds no outputs: its last axis must be of 3 channels")
    flat = outputs.reshape(-1, 3) * factor_of(outputs_unit, unit, "data")
    values = values_of(force, flat, with_uncertainty)
    return values.reshape(*outputs.shape[:-1], values.shape[1])
