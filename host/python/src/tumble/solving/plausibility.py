"""Is K that of the declared block? Gravity looks the same in many wrong set-ups: exchanged channels or mountings, a
table that turned the other way, millivolts for volts all pass the gravity check.

A K that is not near a declared one is held against hypotheses. Each undoes one or several such mistakes; where K is
then near the declared one, that is what happened, and the fewest mistakes win. Without a declared block only the
structure of K can tell, and nothing is refused.

The temperatures at which a run was measured: its coefficients hold there, and are a guess elsewhere.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tumble.arrays import Flags, Floats
from tumble.core import AXES
from tumble.distributions import student_quantile
from tumble.documents.result import Temperature
from tumble.errors import BadInput, listed
from tumble.estimators import NORM
from tumble.files.rows import OF_ENVIRONMENT, Temperatures
from tumble.files.run_file import Run
from tumble.files.stand_file import StandFile
from tumble.model.geometry import Geometry
from tumble.model.norm import NINE
from tumble.schedule import FIT, Position, Schedule
from tumble.solving.solution import Solution
from tumble.stand import by_channel, over
from tumble.units import noise_unit, per_g, unit_of, volts_per

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


def outside(known: Temperature | None, temperatures_c: ArrayLike) -> str | None:
    """A warning that coefficients are applied where they were not measured; None where all is well.

    `known`: `temperature` of the result, None where it does not tell one: then nobody can warn. `temperatures_c` (any
    shape), degrees Celsius, of the data that the coefficients are applied to; NaN where they are not known. Within
    TOLERANCE_C of the run they are as good as within it.
    """
    at = np.asarray(temperatures_c, dtype=float).ravel()
    at = at[~np.isnan(at)]
    if known is None or at.size == 0:
        return None
    low, high = known.min_c, known.max_c
    if low - TOLERANCE_C <= at.min() and at.max() <= high + TOLERANCE_C:
        return None
    used, run = Temperatures(at.min(), at.max(), ""), Temperatures(low, high, "")
    return f"applied at {used.text}, calibrated at {run.text}"


_SIGMAS = 4.0  # of a declared misalignment: six of them exceed it in 4 runs of 10,000
_LEAST_RAD = 5e-3  # a misalignment declared to be smaller is not taken at its word
_LARGEST_RAD = 0.6  # beyond it another axis is as near
_SCALE = 1.25  # factor by which a scale may differ from the nominal one
_ROUGHLY_RAD, _ROUGHLY_SCALE = 0.5, 1.6  # of a K once its mistakes are undone: near enough to name them
_MOST_MOUNTINGS = 3  # whose every order is tried; of more, exchanges of two
_MOST_NAMED = 3
_CLEAR = 5.0  # uncertainties by which an element of K exceeds 0, before anything is said of its channel
_SURELY = 0.999  # the same by residuals, of which there may be few
UNCHECKED = "no more means than unknowns: nothing checks this run"
_OTHERWISE_G = 0.1  # between the forces of positions whose means cannot be the same
_STEPS = 3.0  # of a converter, at least
_FAR_DEG = 15.0  # of a found inclination from the one set: a frame or a wedge is nearer
_OFF_DEG = 3.0  # the same, where another one that was set is nearer
_MOSTLY = 0.7  # of an axis along another one
_AS_WELL = 1.5  # times the rms of the residuals: fits no worse


@dataclass(frozen=True)
class Plausibility:
    """What speaks against K: `refusal` says by which mistake it comes from the declared block, `warnings` what else is
    odd. Sentences for people."""

    refusal: str | None = None
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Mistake:
    """`descriptions` say what happened; `count` is how many single mistakes that takes."""

    count: int
    descriptions: tuple[str, ...] = ()

    def __add__(self, other: Mistake) -> Mistake:
        return Mistake(self.count + other.count, self.descriptions + other.descriptions)


def examine(solution: Solution, stand_file: StandFile | None) -> Plausibility:
    """Hold K against the block that the stand file declares, or against itself where none is."""
    noise = _of_noise(solution)
    if stand_file is None or stand_file.block is None:
        return Plausibility(warnings=noise or _structure(solution))
    unit = volts_per(solution.run.unit)
    nominal = np.diag(by_channel(over(stand_file.block["scale_v_per_g"], unit)))
    known = [] if stand_file.truth is None else [np.array(stand_file.truth["K"], dtype=float) / unit]
    spread = 0.0 if solution.u_k is None else float((solution.u_k / np.abs(np.diag(nominal))[:, None]).max())
    misalignment = max(stand_file.block["misalignment_rad"], _LEAST_RAD)
    allowed = min(_SIGMAS * math.hypot(misalignment, spread), _LARGEST_RAD)
    k = solution.found.k
    if any(not _far(k, declared, allowed, _SCALE).any() for declared in (nominal, *known)):
        return Plausibility()
    if noise:
        return Plausibility(warnings=noise)
    for declared in (nominal, *known):
        mistakes = _explain(solution, declared)
        if mistakes:
            said = " or ".join(" and ".join(mistake.descriptions) for mistake in mistakes[:_MOST_NAMED])
            remedy = _remedy(k, nominal, unit) if declared is nominal else ""
            if len(mistakes) > 1 and solution.inclinations is not None:
                said += ", which look alike to this run"
                remedy = remedy.replace("if the block is so", "if the stand was used as told and the block is so")
            # the element that is farthest from the declared one; of several, one that should be small
            is_large = np.abs(declared) > np.abs(declared).max() / 2
            worst = divmod(int((np.abs(k - declared) * np.where(is_large, 0.75, 1.0)).argmax()), 3)
            return Plausibility(refusal=f"{said}: {_element(solution, declared, misalignment, *worst)}{remedy}")
    far = np.argwhere(_far(k, nominal, allowed, _SCALE))[:_MOST_NAMED]
    odd = "; ".join(_element(solution, nominal, misalignment, *place) for place in far)
    return Plausibility(warnings=(f"K is not that of the declared block: {odd}",))


def check_k(solution: Solution, stand_file: StandFile | None, file: str) -> tuple[str, ...]:
    """The warnings about K. Raises BadInput for a K that a mistake has made of the declared one; `file`: the run's."""
    found = examine(solution, stand_file)
    refusal = _same_means(solution) or found.refusal
    if refusal is not None:
        raise BadInput(refusal, file)
    return (*found.warnings, *_inclined_otherwise(solution))


def _inclined_otherwise(solution: Solution) -> tuple[str, ...]:
    """That the run shows inclinations far from where they were set, or nearer to where another was: inclinations that
    were exchanged, or a schedule in radians. It is solved by those that it shows."""
    if solution.inclinations is None:
        return ()
    set_at = {one.number: one.tilt_deg for one in solution.schedule.fitted_mountings}
    far = []
    for number, deg in zip(solution.inclinations.numbers, np.rad2deg(solution.inclinations.beta).tolist()):
        off = abs(deg - set_at[number])
        if off > _FAR_DEG or (off > _OFF_DEG and any(abs(deg - other) < off for other in set_at.values())):
            far.append(f"{number} at {deg:+.1f} deg, set to {set_at[number]:g}")
    causes = "inclinations exchanged, not all inclined, or axis_tilt_deg in radians?"
    return (f"inclinations found far from where they were set: {'; '.join(far)}: {causes}",) if far else ()


def _same_means(solution: Solution) -> str | None:
    """What speaks against means that are the same in all digits, of as many rows, where the block lay otherwise."""
    run, schedule = solution.run, solution.measured_schedule
    samples, means = run.samples[run.measured], run.means[run.measured]
    if run.table is None:
        return None
    force, scale = Geometry(schedule).force(), float(np.ptp(means)) / 2
    for i, j in itertools.combinations(range(len(means)), 2):
        apart = float(np.linalg.norm(force[i] - force[j]))
        if apart > _OTHERWISE_G and apart * scale > _STEPS * run.table.step.max():
            if samples[i] == samples[j] and (means[i] == means[j]).all():
                one, other = schedule.positions[i].label, schedule.positions[j].label
                same = f"positions {one} and {other} have the same means, digit for digit"
                return f"{same}, where the block lies otherwise: a copy, or the table did not turn"
    return None


def with_order_flag(solution: Solution, stand_file: StandFile | None) -> Solution:
    """This solution, which tells whether its K is out of order for all that is declared of the block."""
    is_declared = stand_file is not None and stand_file.block is not None
    is_odd = not _of_noise(solution) and bool(_structure(solution))
    return replace(solution, is_out_of_order=not is_declared and is_odd, knows_signs=is_declared)


def size_of(k: Floats) -> float:
    """What 1 g gives in the channel that is neither the largest nor the smallest."""
    return float(np.median(np.linalg.norm(k, axis=1)))


def unchecked(solution: Solution) -> tuple[str, ...]:
    """That a run has no residual, nor a position that checks it."""
    positions = solution.measured_schedule.positions
    fitted = sum(position.use == FIT for position in positions)
    free = 3 * (fitted - 4 - len(solution.found.terms))
    if solution.found.estimator == NORM:
        free = fitted - len(NINE)
    return (UNCHECKED,) if free <= 0 and fitted == len(positions) else ()


def _far(k: Floats, declared: Floats, allowed: float, scale: float) -> Flags:
    """Which elements of K (3, 3) are not near the declared ones: large ones within a factor `scale`, and small ones
    within `allowed` of their row's length."""
    length = np.linalg.norm(declared, axis=1)[:, None]
    is_large = np.abs(declared) > length / 2
    ratio = np.where(is_large, k, 1.0) / np.where(is_large, declared, 1.0)
    return np.where(is_large, (ratio < 1 / scale) | (ratio > scale), np.abs(k - declared) > allowed * length)


# Does K say anything?


def _of_noise(solution: Solution) -> tuple[str, ...]:
    """That the outputs do not follow the positions: none of them, or none along one axis, or one channel. Then K is
    noise there, and names no mistake.

    An element means nothing by what is declared, else by the scatter of samples, and by the residuals, which tell too
    how well a face was laid down again. Beside a declared stand large residuals are no noise: mountings may be
    exchanged."""
    stated, rms = solution.stated or solution.scatter_alone, solution.found.residual_rms
    limit = np.zeros((3, 3)) if stated is None else _CLEAR * stated.u_k
    if rms is not None and solution.stated is None:
        measured = solution.measured_schedule
        fitted = [position.use == FIT for position in measured.positions]
        design = np.column_stack([Geometry(measured).force(), np.ones(len(fitted))])[fitted]
        by_axis = np.sqrt(np.diag(np.linalg.inv(design.T @ design))[:3])
        freedom = len(design) - 4 - len(solution.found.terms)
        limit = np.maximum(limit, student_quantile(_SURELY, freedom) * rms[:, None] * by_axis)
    k, everywhere = np.abs(solution.found.k), np.ones((3, 3), dtype=bool)
    alone = [("the outputs do not follow the positions", everywhere)]
    for axis, one in zip(AXES, np.eye(3, dtype=bool)):
        alone.append((f"the outputs do not change with gravity along {axis}", everywhere & one))
        alone.append((f"channel u{axis} does not follow the positions", everywhere & one[:, None]))
    for what, where in alone:
        if (k <= limit)[where].all():
            row, column = np.argwhere(where)[int(k[where].argmax())].tolist()
            size = f"K_{AXES[row]}{AXES[column]} = {solution.found.k[row, column]:.2g} {per_g(solution.run.unit)}"
            most = f"{limit[row, column]:.2g}"
            return (f"{what}: {size} where noise gives up to {most}; was the sensor not turned, or in another order?",)
    return ()


# What the declared block would have to suffer.


def _explain(solution: Solution, declared: Floats) -> list[Mistake]:
    """The mistakes that lead from the declared block to this K, the fewest; several where they look the same, none
    where K is roughly the declared one as it stands."""
    found: list[tuple[Mistake, float]] = []
    for of_stand, k, residual in _resolved(solution):
        of_unit, factor = _unit_mistake(solution.run.unit, k, declared)
        for of_channels, undo in _CHANNELS:
            if not _far(undo @ k / factor, declared, _ROUGHLY_RAD, _ROUGHLY_SCALE).any():
                found.append((of_unit + of_channels + of_stand, residual))
    fewest = min((mistake.count for mistake, _ in found), default=0)
    best = [(mistake, residual) for mistake, residual in found if mistake.count == fewest > 0]
    smallest = min((residual for _, residual in best), default=0.0)
    return [mistake for mistake, residual in best if residual <= _AS_WELL * smallest]


def _channel_mistakes() -> Iterator[tuple[Mistake, Floats]]:
    """All orders and signs of the channels, each with the matrix that undoes it."""
    names = [f"u{axis}" for axis in AXES]
    for order in itertools.permutations(range(3)):
        moved = [index for index in range(3) if order[index] != index]
        exchanged = Mistake(0)
        if moved:
            channels = " and ".join(names[index] for index in moved) if len(moved) == 2 else "ux, uy and uz"
            exchanged = Mistake(len(moved) - 1, (f"channels {channels} look exchanged (--columns)",))
        for signs in itertools.product((1.0, -1.0), repeat=3):
            odd = [names[index] for index in range(3) if signs[index] < 0]
            looks = "channel {} looks" if len(odd) == 1 else "channels {} look"
            reversed_ones = Mistake(len(odd), (f"{looks.format(' and '.join(odd))} reversed",) if odd else ())
            if len(odd) == 3:
                reversed_ones = Mistake(1, ("all channels look reversed (the sign of scale_v_per_g?)",))
            yield exchanged + reversed_ones, np.eye(3)[list(order)].T * np.array(signs)


_CHANNELS = tuple(_channel_mistakes())


def _remedy(k: Floats, nominal: Floats, volts: float) -> str:
    """How to declare a block of which some channels have the other sign, and nothing else is odd."""
    signs = np.where(np.diag(k) * np.diag(nominal) < 0.0, -1.0, 1.0)
    if abs(signs.sum()) == 3 or _far(signs[:, None] * k, nominal, _ROUGHLY_RAD, _ROUGHLY_SCALE).any():
        return ""
    scales = ", ".join(f"{scale:g}" for scale in (signs * np.diag(nominal) * volts).tolist())
    return f"; if the block is so, [block] says it per channel: scale_v_per_g = [{scales}]"


def _unit_mistake(unit: str, k: Floats, declared: Floats) -> tuple[Mistake, float]:
    """A power of 1000 between K and the declared one, as a unit; of no unit that is no multiple of the volt."""
    thousands = round(math.log(size_of(k) / size_of(declared), 1000.0)) if noise_unit(unit) == "V" else 0
    if thousands == 0:
        return Mistake(0), 1.0
    factor = 1000.0**thousands
    other = unit_of(volts_per(unit) / factor)
    if other is None:
        return Mistake(1, (f"outputs look {factor:g} times too large (--unit)",)), factor
    return Mistake(1, (f"outputs look to be in {other}, not in {unit} (--unit {other})",)), factor


def _resolved(solution: Solution) -> Iterator[tuple[Mistake, Floats, float]]:
    """K as it would be had the stand been used in another way, with the rms of the residuals; only where the run fits
    that no worse than its own schedule."""
    measured = solution.measured_schedule
    rows = [index for index, position in enumerate(measured.positions) if position.use == FIT]
    means = solution.run.means[solution.run.measured][rows]
    fitted = Schedule(measured.mountings, tuple(measured.positions[index] for index in rows))
    told = _least_squares(fitted, means)
    assert told is not None  # there is a solution
    rounding = 1e-9 * float(np.abs(means).max())
    if solution.inclinations is not None:  # it may mirror all along the axis, and nothing else tells: it comes first
        matrix = np.array(fitted.fitted_mountings[0].matrix)
        exchange = Mistake(1, (f"inclinations of opposite sign look exchanged ({_sloping(solution)})",))
        yield exchange, solution.found.k @ (matrix * [1.0, -1.0, 1.0]) @ matrix.T, told[1] + rounding
    yield Mistake(0), solution.found.k, told[1] + rounding
    for mistake, positions in _stand_mistakes(fitted):
        other = _least_squares(Schedule(fitted.mountings, positions), means)
        if other is not None and other[1] <= _AS_WELL * told[1] + rounding:
            yield mistake, other[0], other[1] + rounding


def _sloping(solution: Solution) -> str:
    """The numbers of the inclinations that are set to one side of the level or the other."""
    return listed([one.number for one in solution.schedule.fitted_mountings if one.tilt_deg])


def _least_squares(schedule: Schedule, means: Floats) -> tuple[Floats, float] | None:
    """K and the rms of the residuals; None where the positions do not determine it."""
    design = np.column_stack([Geometry(schedule).force(), np.ones(len(means))])
    found, _, rank, _ = np.linalg.lstsq(design, means, rcond=1e-6)
    if rank < 4:
        return None
    return np.array(found[:3].T, dtype=np.float64), float(np.sqrt(np.mean((means - design @ found) ** 2)))


def _stand_mistakes(schedule: Schedule) -> Iterator[tuple[Mistake, tuple[Position, ...]]]:
    """Mountings in another order, a table that turned the other way, or both; with what was measured in truth."""
    told = schedule.positions
    numbers = [mounting.number for mounting in schedule.fitted_mountings]
    orders: list[tuple[int, ...]] = list(itertools.permutations(numbers))
    if len(numbers) > _MOST_MOUNTINGS:
        exchanges = [{one: other, other: one} for one, other in itertools.combinations(numbers, 2)]
        orders = [tuple(numbers), *(tuple(pair.get(number, number) for number in numbers) for pair in exchanges)]
    for order in orders:
        truly = dict(zip(numbers, order))
        moved = [number for number in numbers if truly[number] != number]
        exchanged = Mistake(max(0, len(moved) - 1), (f"mountings {listed(moved)} look exchanged",) if moved else ())
        positions = tuple(replace(position, mounting=truly[position.mounting]) for position in told)
        if moved:
            yield exchanged, positions
        for turned in ([], *([number] for number in numbers)):
            where = f" in mounting {turned[0]}" if turned else ""
            mistake = Mistake(1, (f"the table looks to have turned the other way{where}",))
            backwards = turned or numbers
            yield (
                exchanged + mistake,
                tuple(
                    replace(position, angle_deg=-position.angle_deg) if one.mounting in backwards else position
                    for position, one in zip(positions, told)
                ),
            )


# What is said of it.


def _element(solution: Solution, declared: Floats, misalignment: float, row: int, column: int) -> str:
    unit, value = per_g(solution.run.unit), declared[row, column]
    length = float(np.linalg.norm(declared[row]))
    spread = "" if abs(value) > length / 2 else f" +- {misalignment * length:.2g}"
    name = f"K_{AXES[row]}{AXES[column]}"
    return f"{name} = {solution.found.k[row, column]:.4g} {unit} where {value:.4g}{spread} is declared"


def _structure(solution: Solution) -> tuple[str, ...]:
    """What is odd about a K of which nothing is declared but that channel x measures along x."""
    k, unit = solution.found.k, per_g(solution.run.unit)
    for row, column in enumerate(np.abs(k).argmax(axis=1).tolist()):
        if column != row:
            small, large = f"K_{AXES[row]}{AXES[row]}", f"K_{AXES[row]}{AXES[column]}"
            values = f"{large} = {k[row, column]:.4g} {unit}, {small} = {k[row, row]:.4g} {unit}"
            return (f"channel u{AXES[row]} measures along {AXES[column]}: {values}; channels or mountings exchanged?",)
    signs = np.sign(np.diag(k))
    if abs(signs.sum()) == 3:
        return ()
    odd = int(np.flatnonzero(signs == -np.sign(signs.sum()))[0])
    value = f"K_{AXES[odd]}{AXES[odd]} = {k[odd, odd]:.4g} {unit}"
    causes = "a channel reversed, or the table turned the other way?"
    if solution.inclinations is not None and abs(solution.schedule.fitted_mountings[0].matrix[odd][1]) > _MOSTLY:
        causes = f"inclinations of opposite sign exchanged ({_sloping(solution)}), {causes}"
    return (f"{value} has another sign than the other two: {causes}",)
