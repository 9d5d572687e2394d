"""Why a solution may not be what it claims, in sentences: for callers, and for the command line, which prints them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tumble.fixture.judge import Limits
from tumble.model.fit import NOISE_V, Explanation
from tumble.model.stand_seen import NAMES
from tumble.solving import noise, plausibility
from tumble.solving.decision import NO_UNIT
from tumble.solving.many_runs import MonteCarlo, Verdict
from tumble.solving.noise import CORRELATED
from tumble.solving.solution import Solution
from tumble.units import contradicts, looks_like, noise_unit


def complaints(solution: Solution, odd: Sequence[str] = (), confirmed_unit: bool = False) -> list[str]:
    """All of them. `odd`: what is odd about its rows and its K; `confirmed_unit`: the declared block shows that
    outputs are in the unit that its stand file is in, which is the volt where nobody names one."""
    told: list[str] = []
    if not solution.run.unit_told and not confirmed_unit:
        told.append(NO_UNIT)
    if (looks := unit_complaint(solution)) is not None:
        told.append(looks)
    told += odd
    if (span := plausibility.spanned(solution.run)) is not None:
        told.append(span)
    unit = solution.run.unit
    if solution.stand is not None and noise_unit(unit) != "V" and not confirmed_unit:
        declared = ", ".join(f"{one:g}" for one in np.atleast_1d(solution.stand.noise).tolist())
        told.append(f"outputs in {unit}: noise_v of the stand file, {declared}, is in {unit} too")
    told += [] if solution.second_order is None else solution.second_order.complaints
    if solution.lone:
        told.append(f"a single row, taken for one sample, at {', '.join(solution.lone)}")
    if (noisy := noise_notice(solution)) is not None:
        told.append(f"{noisy}; the uncertainties count it")
    if solution.monte_carlo is not None and (open_or_not := simulation_complaint(solution.monte_carlo)):
        told.append(open_or_not)
    told += plausibility.unchecked(solution)
    if (doubt := misfit_sentence(solution)) is not None:
        told.append(f"{doubt}; the uncertainties {misfit_consequence(solution)}")
    return told


def unit_complaint(solution: Solution) -> str | None:
    """That 1 g comes out as if in another unit: than the one of acceleration that is told, or than the volt that nobody
    tells. A declared block does not count here: it may have been declared in that other unit."""
    per_g, unit = plausibility.size_of(solution.found.k), solution.run.unit
    if not solution.run.unit_told:
        seen = looks_like(per_g)
        return None if seen is None else f"1 g gives {per_g:.4g}, and nobody names its unit: it looks like {seen}"
    other = contradicts(per_g, unit)
    return None if other is None else f"1 g gives {per_g:.4g} {unit}: outputs look to be in {other} (--unit {other})"


def noise_notice(solution: Solution) -> str | None:
    """That the samples are noisier than declared, and that the uncertainties count that; None if not."""
    if solution.stand is None:
        return None
    return noise.notice(solution.noise, solution.declared, solution.run.samples, solution.run.unit)


def misfit_sentence(solution: Solution) -> str | None:
    """That the run does not fit the declared stand, or shows what is not declared; None where it does neither."""
    if solution.fit is None:
        return None
    shown = "; ".join(_explained(solution, explanation) for explanation in solution.fit.explanations)
    if solution.fit.fits:
        return f"the run fits the stand file, but shows {shown}" if shown else None
    return f"the run does not fit the stand file: {shown or 'no known pattern explains it'}"


def _explained(solution: Solution, explanation: Explanation) -> str:
    """Such as "k2 of y 104 +- 12 ug/g^2 or asymmetry"; of a source, what is declared of it."""
    name, *others = explanation.patterns
    size, unit = explanation.size, explanation.unit
    if name in NAMES and solution.stand is not None:
        limits = Limits.declared(solution.stand, len(solution.measured_schedule.fitted_mountings))
        seen = "" if size is None else f" {abs(size):.1e} {unit}"
        said = f"{NAMES[name]}{seen} (declared {limits.sigma[name]:.1e})"
    else:
        said = _placed(name, explanation.column)
        said += "" if size is None else f" {size:.4g} +- {explanation.u_size:.2g} {unit}"
    return " or ".join([said, *(NAMES.get(other, other) for other in others)])


def named(explanation: Explanation) -> str:
    """Its likeliest pattern without sizes, such as "position 2.5 (x)" or "axis tilt"."""
    name = explanation.patterns[0]
    return _placed(NAMES.get(name, name), explanation.column)


def _placed(name: str, column: str) -> str:
    """With what shows it. One bad mean is that of a channel at a position, of which the channel may not be known."""
    if name == "position":
        place, _, channel = column.partition(" ")
        return f"position {place} ({channel})" if channel else f"position {place}"
    return f"{name} of {column}" if column else name


def misfit_consequence(solution: Solution) -> str:
    """What a run that does not fit means for its uncertainties: more noise, where samples show it, is in them."""
    causes = () if solution.fit is None else [one.patterns[0] for one in solution.fit.explanations]
    is_noise = bool(causes) and set(causes) <= {NOISE_V, CORRELATED}
    return "count it" if is_noise and solution.noise.exceeds.any() else "are too small"


def simulation_complaint(found: MonteCarlo) -> str | None:
    """Where simulated runs do not confirm the uncertainties, or leave it open; None where they do."""
    differs, open_ones = found.where(Verdict.DIFFERS), found.where(Verdict.CANNOT_TELL)
    if differs:
        return f"Monte Carlo differs from the uncertainties of {', '.join(differs)}"
    return f"too few runs of Monte Carlo to tell of {', '.join(open_ones)}" if open_ones else None
