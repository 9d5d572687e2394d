"""The core's chi-squared of all residuals, beside numpy's. Arrays as in tumble.core."""

import numpy as np
from _tumble_core import ffi, lib

from tumble.core import record_of, require_ok
from tumble.model.estimators import columns_at
from tumble.model.geometry import ideal_force
from tumble.solving.computation import LARGEST_MISFIT, _require

FIT_LIMIT = 1e-6
_FLOOR = 1e-7  # of the outputs
_DESCENTS = 3


def chi_squared(schedule, means, measured, variance, stand):
    """The sum of squares, and its degrees of freedom. `variance` (positions, 3), or (positions,) for channels
    that are alike, of each mean by its noise; `stand` and `variance` in the unit of the means. Raises CoreRefusal."""
    declared = record_of(stand)
    of_each = np.broadcast_to(variance.reshape(len(means), -1), means.shape)
    noise = np.ascontiguousarray(np.where(measured[:, None], of_each, 0.0), dtype=float)
    given, work = schedule.means(means, measured), ffi.new("tumble_whole_work_t *")
    by_channel = ffi.cast("double (*)[3]", ffi.from_buffer(noise))
    run = ffi.new("tumble_whole_run_t *", [schedule.struct, given, declared, ffi.NULL, by_channel])
    square, freedom = ffi.new("double *"), ffi.new("uint8_t *")
    require_ok(lib.tumble_whole_chi_squared(run, work, square, freedom))
    return square[0], freedom[0]


def compare_fit(found, model):
    """Of a WholeModel. Raises Disagreement.

    They may differ by 1e-6, relative and absolute. Beyond a misfit of 100 both must find one: there the problem is not
    nearly linear any more, and nobody needs the figure.
    """
    square, freedom = found
    _require("degrees of freedom of the fit", float(freedom), float(model.freedom), 0.0)
    if not min(square, model.chi_squared) > LARGEST_MISFIT**2 * max(1, freedom):
        _require("chi-squared of the fit", square, model.chi_squared, FIT_LIMIT * max(1.0, model.chi_squared))


def least_chi_squared(schedule, means, measured, variance, stand, terms, sizes):
    """With further terms in the model. The core's chi-squared of the outputs without the terms is nearly a quadratic
    function of their sizes: its minimum is found from its values, first of all around the estimated `sizes`."""
    further = np.zeros((3 * len(terms), *means.shape))
    further[:, measured] = columns_at(ideal_force(schedule.part(measured).data), terms)
    noise = np.maximum(variance[measured], (_FLOOR * np.abs(means[measured]).max()) ** 2)
    steps = np.diag(1.0 / np.sqrt((further[:, measured] ** 2 / noise).sum(axis=(1, 2))))

    def square(at):
        return chi_squared(schedule, means - np.tensordot(at, further, axes=1), measured, variance, stand)

    lowest = _lowest(lambda at: square(at)[0], sizes.ravel(), steps)
    found, freedom = square(lowest)
    return found, freedom - len(lowest)


def _lowest(square, start, steps):
    """Where a nearly quadratic function is least, by Newton's way with the curvature at the start; `steps` (n, n): how
    far to look, along each axis."""

    def around(at):
        return np.array([[square(at + sign * step) for step in steps] for sign in (1.0, -1.0)])

    here, (up, down) = square(start), around(start)
    curvature = np.diag(up + down - 2.0 * here)
    for i, j in zip(*np.triu_indices(len(steps), 1)):
        both = square(start + steps[i] + steps[j])
        curvature[i, j] = curvature[j, i] = both - up[i] - up[j] + here
    for _ in range(_DESCENTS):
        start = start - np.linalg.solve(curvature, (up - down) / 2.0) @ steps
        up, down = around(start)
    return start
