"""What a person is told of what follows from the coefficients: intrinsic parameters, and |a| at its worst."""

from __future__ import annotations

import textwrap

import numpy as np

from tumble.api.complaints import simulation_complaint
from tumble.estimators import COEFFICIENTS
from tumble.model import reliability
from tumble.solving.further import Further
from tumble.solving.many_runs import NORMAL_COVERAGE, MonteCarlo
from tumble.solving.solution import Solution

_LOSS = 1.05  # of an uncertainty, before it is spoken of


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
    lines += [] if solution.further is None else _loss(solution, solution.further)
    lines += [] if solution.reliability is None else reliability.lines(solution.reliability, solution.limit_g)
    return lines + ([] if solution.monte_carlo is None else _simulated(solution.monte_carlo))


def _loss(solution: Solution, further: Further) -> list[str]:
    """What further terms of the model cost the twelve: of each kind of coefficient the one that loses most."""
    without, now = further.without, further.worst_norm
    assert without is not None and now is not None  # of a declared stand they are known
    before = np.concatenate([without.u_k.ravel(), without.u_u0])
    assert further.covariance is not None
    after = np.sqrt(np.diag(further.covariance)[:12])
    scale = np.abs(np.concatenate([np.repeat(np.diag(further.k), 3), np.diag(further.k)])) * 1e-6
    parts = []
    for kind, unit in ((range(0, 9, 4), "ppm"), ((1, 2, 3, 5, 6, 7), "urad"), (range(9, 12), "ug")):
        with np.errstate(divide="ignore", invalid="ignore"):
            worst = max(kind, key=lambda i: float(np.nan_to_num(after[i] / before[i])))
        if after[worst] > _LOSS * before[worst]:
            parts.append(
                f"u({COEFFICIENTS[worst]}) {_change(before[worst] / scale[worst], after[worst] / scale[worst])} {unit}"
            )
    parts.append(f"worst u(|a|) {_change(without.worst.worst * 1e6, now.worst * 1e6)} ug")
    listed = " and ".join([*filter(None, [", ".join(further.terms[:-1])]), further.terms[-1]])
    return textwrap.wrap(f"Because of {listed}: {', '.join(parts)}", 80, break_on_hyphens=False)


def _change(before: float, after: float) -> str:
    return f"{before:.3g} -> {after:.3g}"


def _simulated(found: MonteCarlo) -> list[str]:
    """A table of what simulated runs make of the uncertainties, and what that comes to."""
    lines = ["", f"Monte Carlo, {found.runs} runs, seed {found.seed}; in units of the stated u:"]
    lines.append(f"{'':6} {'mean error':>10}  {'u':>6}  {'95 % interval':>16}  linear: -1.960 to +1.960")
    for i, (name, verdict) in enumerate(zip(COEFFICIENTS, found.verdicts)):
        shift, spread, ends = _over_u(found, i)
        lines.append(f"{name:6} {shift:>10}  {spread:>6}  {ends:>16}  {verdict.value}")
    return lines + textwrap.wrap(simulation_complaint(found) or "It agrees with the linear uncertainties.", 80)


def _over_u(found: MonteCarlo, i: int) -> tuple[str, str, str]:
    """Mean error, standard deviation and interval of one coefficient; of a stand without errors there is no unit."""
    u = (found.linear_high[i] - found.linear_low[i]) / (2.0 * NORMAL_COVERAGE)
    middle = (found.linear_high[i] + found.linear_low[i]) / 2.0
    if u == 0.0:
        return "-", "-", "-"
    ends = f"{(found.low[i] - middle) / u:+.3f} to {(found.high[i] - middle) / u:+.3f}"
    return f"{found.shift[i] / u:+.3f}", f"{found.u[i] / u:.3f}", ends
