"""What a person is told of what follows from the coefficients: intrinsic parameters, and |a| at its worst."""

from __future__ import annotations

import textwrap

from tumble.estimators import COEFFICIENTS
from tumble.solving.monte_carlo import NORMAL_COVERAGE, MonteCarlo, Verdict
from tumble.solving.solution import Solution


def remarks(solution: Solution) -> list[str]:
    """Lines of at most 80 columns; none without a declared stand."""
    found, u, norm = solution.found.intrinsic, solution.u_intrinsic, solution.u_norm
    if u is None or norm is None:
        return []
    rows = [("Intrinsic: row of K", "bias over it, g", "angle of two rows, rad")]
    for i, (axis, pair) in enumerate(zip("xyz", ("xy", "xz", "yz"))):
        scale = f"{axis} {found.scale[i]:#.6g} +- {u.scale[i]:.1e}"
        bias = f"{found.bias[i]:+.3e} +- {u.bias[i]:.1e}"
        rows.append((scale, bias, f"{pair} {found.angles[i]:.6f} +- {u.angles[i]:.1e}"))
    lines = [f"{scale:24}  {bias:21}  {angle}".rstrip() for scale, bias, angle in rows]
    x, y, z = norm.attitude
    lines.append(f"Worst u(|a|): {norm.worst * 1e6:.3g} ug, at the attitude ({x:+.2f}, {y:+.2f}, {z:+.2f})")
    return lines + ([] if solution.monte_carlo is None else _simulated(solution.monte_carlo))


def _simulated(found: MonteCarlo) -> list[str]:
    """A table of what simulated runs make of the uncertainties, and what that comes to."""
    lines = ["", f"Monte Carlo, {found.runs} runs, seed {found.seed}; in units of the stated u:"]
    lines.append(f"{'':6} {'mean error':>10}  {'u':>6}  {'95 % interval':>16}  linear: -1.960 to +1.960")
    for i, (name, verdict) in enumerate(zip(COEFFICIENTS, found.verdicts)):
        shift, spread, ends = _over_u(found, i)
        lines.append(f"{name:6} {shift:>10}  {spread:>6}  {ends:>16}  {verdict.value}")
    return lines + textwrap.wrap(complaint(found) or "It agrees with the linear uncertainties.", 80)


def _over_u(found: MonteCarlo, i: int) -> tuple[str, str, str]:
    """Mean error, standard deviation and interval of one coefficient; of a stand without errors there is no unit."""
    u = (found.linear_high[i] - found.linear_low[i]) / (2.0 * NORMAL_COVERAGE)
    middle = (found.linear_high[i] + found.linear_low[i]) / 2.0
    if u == 0.0:
        return "-", "-", "-"
    ends = f"{(found.low[i] - middle) / u:+.3f} to {(found.high[i] - middle) / u:+.3f}"
    return f"{found.shift[i] / u:+.3f}", f"{found.u[i] / u:.3f}", ends


def complaint(found: MonteCarlo) -> str | None:
    """Where simulated runs do not confirm the uncertainties, or leave it open; None where they do."""
    differs, open_ones = found.where(Verdict.DIFFERS), found.where(Verdict.CANNOT_TELL)
    if differs:
        return f"Monte Carlo differs from the uncertainties of {', '.join(differs)}"
    return f"too few runs of Monte Carlo to tell of {', '.join(open_ones)}" if open_ones else None
