"""The temperatures at which a run was measured: its coefficients hold there, and are a guess elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tumble.files.rows import OF_ENVIRONMENT, Temperatures
from tumble.files.run_file import Run

TOLERANCE_C = 1.0  # what thermometers and the inside of a block differ by
FAR_C = 10.0  # blocks change by some 1e-4 a kelvin: this is 1e-3, and no warming-up of a block in its room


def in_environment(run: Run, environment: Mapping[str, Any] | None) -> Run:
    """The run with the temperature that the stand file's [environment] tells, where its own file tells none."""
    told = (environment or {}).get("temperature_c")
    if run.temperature is not None or told is None:
        return run
    return replace(run, temperature=Temperatures(float(told), float(told), OF_ENVIRONMENT))


def spanned(run: Run) -> str | None:
    """A warning that the run has no one temperature; None where it has."""
    found = run.temperature
    if found is None or found.high_c - found.low_c <= FAR_C:
        return None
    return f"the run was measured at {found.text}: its coefficients are those of no one temperature"


def contradicted(run: Run, environment: Mapping[str, Any] | None) -> str | None:
    """A warning that the file of a run and the stand file's [environment] do not tell of the same day."""
    found, told = run.temperature, (environment or {}).get("temperature_c")
    if found is None or told is None or found.low_c - FAR_C <= told <= found.high_c + FAR_C:
        return None
    return f"the run says {found.text}, temperature_c of the stand file {told:.3g}: that of the run counts"


def document(run: Run) -> dict[str, Any] | None:
    """As it stands in a result; None: unknown."""
    found = run.temperature
    return None if found is None else {"min_c": found.low_c, "max_c": found.high_c, "source": found.source}


def outside(known: Mapping[str, Any] | None, temperatures_c: ArrayLike) -> str | None:
    """A warning that coefficients are applied where they were not measured; None where all is well.

    `known`: `temperature` of the result, None where it does not tell one: then nobody can warn. `temperatures_c` (any
    shape), degrees Celsius, of the data that the coefficients are applied to; NaN where they are not known. Within
    TOLERANCE_C of the run they are as good as within it.
    """
    at = np.asarray(temperatures_c, dtype=float).ravel()
    at = at[~np.isnan(at)]
    if known is None or at.size == 0:
        return None
    low, high = float(known["min_c"]), float(known["max_c"])
    if low - TOLERANCE_C <= at.min() and at.max() <= high + TOLERANCE_C:
        return None
    used, run = Temperatures(at.min(), at.max(), ""), Temperatures(low, high, "")
    return f"applied at {used.text}, calibrated at {run.text}"
