"""Results as JSON documents of schema tumble.result/1, made by solve and bench. files.documents reads them back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from tumble._version import __version__
from tumble.core import Intrinsic
from tumble.files.documents import RESULT
from tumble.model import reliability, stand_seen
from tumble.model.norm import IntrinsicUncertainties, named
from tumble.solving import noise, si, temperature
from tumble.solving.assumptions import assumed
from tumble.solving.decision import decide
from tumble.solving.declared import schedule_document, stand_document
from tumble.solving.gravity_uncertainty import UNKNOWN, gravity_uncertainty
from tumble.solving.solution import Solution, Truth
from tumble.solving.would_show import would_show
from tumble.stand import by_channel, per_channel
from tumble.units import per_g, volts_per


def document(
    solution: Solution,
    item: dict[str, Any] | None,
    environment: dict[str, Any] | None,
    serial: str | None = None,
    run_file: str | None = None,
    created: str | None = None,
    warnings: Sequence[str] = (),
) -> dict[str, Any]:
    """The result of a solve, ready for JSON. `serial`: of the block; `run_file`: name of what was solved; `created`:
    when, None where no clock was looked at; `warnings`: sentences that a person is told beside it."""
    unit, rests_on, decision = solution.run.unit, assumed(solution), decide(solution)
    return {
        "schema": RESULT,
        "created": created,
        "tumble": __version__,
        "run_file": run_file,
        "run_sha256": solution.run.sha256 or None,
        "serial": serial,
        "stand": stand_document(solution.stand, per_channel(by_channel(solution.step) * volts_per(unit))),
        "schedule": schedule_document(solution.schedule),
        "estimator": solution.found.estimator,
        "unit": unit,
        "units": {"K": per_g(unit), "U0": unit, "u_K": per_g(unit), "u_U0": unit},
        "K": solution.found.k.tolist(),
        "U0": solution.found.u0.tolist(),
        "u_K": None if solution.u_k is None else solution.u_k.tolist(),
        "u_U0": None if solution.u_u0 is None else solution.u_u0.tolist(),
        "covariance": None if solution.covariance is None else solution.covariance.tolist(),
        "u_norm_g": _worst_norm(solution),
        "extended": None if solution.further is None else solution.further.document(volts_per(unit)),
        "second_order": None if solution.second_order is None else solution.second_order.document(),
        "monte_carlo": None if solution.monte_carlo is None else solution.monte_carlo.document(),
        "misfit": None if solution.fit is None else solution.fit.misfit,
        "fit": None if solution.fit is None else solution.fit.document(),
        "stand_doubts": None if solution.fit is None else list(solution.fit.doubts),
        **reliability.documents(solution.reliability),
        "pass": decision.passed,
        "pass_reason": " and ".join(decision.failures) or None,
        "decision": decision.document(),
        "would_show": None if not decision.is_not_shown else [one.document() for one in would_show(solution)],
        "assumes": list(rests_on),
        "assumed_for": {name: list(coefficients) for name, coefficients in rests_on.items()},
        "warnings": list(warnings),
        "noise": noise.document(solution.noise, solution.run.samples),
        "scatter_alone": _scatter_alone(solution),
        "coverage": None if solution.coverage is None else solution.coverage.document(),
        "verification": _verification(solution),
        "stand_seen": stand_seen.document(solution.stand_seen, volts_per(unit), solution.channel_noise),
        "intrinsic": _intrinsic(solution.found.intrinsic),
        "si": si.document(solution.found.k, solution.found.u0, solution.covariance, environment, unit),
        "u_intrinsic": None if solution.u_intrinsic is None else _intrinsic(solution.u_intrinsic),
        "reference": {
            "max_abs_difference_K": float(np.abs(solution.comparison.k).max()),
            "max_abs_difference_U0": float(np.abs(solution.comparison.u0).max()),
            "difference_K": solution.comparison.k.tolist(),
            "difference_U0": solution.comparison.u0.tolist(),
        },
        "means": _means(solution),
        "counters": solution.run.counters,
        "item": item,
        "environment": environment,
        "temperature": temperature.document(solution.run),
    }


def _scatter_alone(solution: Solution) -> dict[str, Any] | None:
    alone = solution.scatter_alone
    return None if alone is None else {"u_K": alone.u_k.tolist(), "u_U0": alone.u_u0.tolist()}


def _intrinsic(found: Intrinsic | IntrinsicUncertainties) -> dict[str, Any]:
    return named([*found.scale.tolist(), *found.angles.tolist(), *found.bias.tolist()])


def _worst_norm(solution: Solution) -> dict[str, Any] | None:
    u = solution.u_norm
    return None if u is None else {"worst_g": u.worst, "attitude": u.attitude.tolist()}


def _places(solution: Solution) -> list[tuple[int, dict[str, Any]]]:
    """Index and names of every measured position."""
    return [
        (index, {"mounting": position.mounting, "position": position.number, "use": position.use})
        for index, position in enumerate(solution.schedule.positions)
        if solution.run.samples[index] > 0
    ]


def _verification(solution: Solution) -> dict[str, Any]:
    gravity, rms = solution.found.gravity, solution.found.residual_rms
    judged = [largest for largest in (gravity.max_abs_fit, gravity.max_abs_check) if largest is not None]
    known = gravity_uncertainty(solution)
    return {
        "delta_g_g": [
            {
                **place,
                "delta_g_g": float(gravity.delta_g[index]),
                **(UNKNOWN if known is None else known.document(index)),
            }
            for index, place in _places(solution)
        ],
        "max_abs_delta_g_g": max(judged),
        "max_abs_delta_g_fit_g": gravity.max_abs_fit,
        "max_abs_delta_g_check_g": gravity.max_abs_check,
        "limit_g": solution.limit_g,
        "pass": gravity.passed,
        "closure": [
            {"mounting": mounting, "difference": difference.tolist()}
            for mounting, difference in solution.found.closure.items()
        ],
        "residual_rms": None if rms is None else rms.tolist(),
    }


def _means(solution: Solution) -> list[dict[str, Any]]:
    run = solution.run
    return [
        {
            **place,
            "samples": int(run.samples[index]),
            "mean": run.means[index].tolist(),
            "scatter": run.scatter[index].tolist() if run.samples[index] > 1 else None,
        }
        for index, place in _places(solution)
    ]


def truth(known: Truth) -> dict[str, Any]:
    """What a simulated run was made of."""
    return {
        "K": known.k.tolist(),
        "U0": known.u0.tolist(),
        "alpha1_rad": known.alpha1,
        "alpha2_rad": known.alpha2,
        "alpha3_rad": list(known.alpha3),
        "alpha4_rad": list(known.alpha4),
        "theta_h_rad": list(known.theta_h),
        "theta_n_rad": list(known.theta_n),
        **({"encoder_rad": list(known.encoder)} if any(known.encoder) else {}),
        **({"drift_v": list(known.drift)} if any(known.drift) else {}),
    }
