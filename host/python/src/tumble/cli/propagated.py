"""What a person is told of what follows from the coefficients: intrinsic parameters, and |a| at its worst."""

from __future__ import annotations

from tumble.solving.solution import Solution
from tumble.units import per_g


def remarks(solution: Solution) -> list[str]:
    """Lines of at most 80 columns; none without a declared stand."""
    found, u, norm = solution.found.intrinsic, solution.u_intrinsic, solution.u_norm
    if u is None or norm is None:
        return []
    rows = [("", f"row of K, {per_g(solution.run.unit)}", "bias over it, g", "angle of two rows, rad")]
    for i, (axis, pair) in enumerate(zip("xyz", ("xy", "xz", "yz"))):
        scale = f"{axis} {found.scale[i]:.6g} +- {u.scale[i]:.1e}"
        bias = f"{found.bias[i]:+.3e} +- {u.bias[i]:.1e}"
        rows.append(("" if i else "Intrinsic:", scale, bias, f"{pair} {found.angles[i]:.6f} +- {u.angles[i]:.1e}"))
    lines = [f"{name:11} {scale:20}  {bias:21}  {angle}".rstrip() for name, scale, bias, angle in rows]
    x, y, z = norm.attitude
    return [*lines, f"Worst u(|a|): {norm.worst * 1e6:.3g} ug, at the attitude ({x:+.2f}, {y:+.2f}, {z:+.2f})"]
