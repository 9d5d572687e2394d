"""What the firmware found on the bench, confirmed: from its document and run.csv to a solution with truth."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
from msgspec import UNSET, structs

from tumble.api.solving import complaints
from tumble.arrays import Floats
from tumble.documents import bench
from tumble.documents.base import to_json
from tumble.documents.bench import Bench, Node, NodeWithStand, RunWithTruth, Stand
from tumble.documents.result import Table, Truth
from tumble.errors import BadInput, BenchFault, Disagreement
from tumble.estimators import OPTIMAL
from tumble.files.run_file import Run, read_run
from tumble.files.run_layout import LayoutOptions
from tumble.files.stand_file import StandFile
from tumble.model.estimators import unknowns
from tumble.model.optimal import optimal_covariance, optimal_estimate
from tumble.model.propagation import Propagation
from tumble.solving import result
from tumble.solving.computation import OPTIMAL_LIMIT_U, RELATIVE_LIMIT, compare_uncertainties
from tumble.solving.noise import estimate_noise, of_means
from tumble.solving.solution import Solution, solve
from tumble.world.progress import state_text
from tumble.world.setup import Setup, step_v, weights_made_for

DOCUMENT = "bench.json"
INPROCESS = "inprocess"
_NOISE_LIMIT = 1e-9


def require_done(document: RunWithTruth) -> None:
    """Raise BenchFault, one line that says what went wrong and where, unless the firmware has finished."""
    if document.end == "done" and document.K is not None:
        return
    if document.end == "running":
        raise BenchFault("the run has not come to its end: no result yet")
    if document.end == "too long":
        raise BenchFault(f"no end after {document.virtual_s:.0f} s of virtual time, in {state_text(document.state)}")
    where = f"in state {state_text(document.failed_in)}, positions finished: {len(document.means)}"
    code = f", drive error 0x{document.drive_code:04X}" if document.drive_code else ""
    code += f", {document.drive_refusal.sentence}" if document.drive_refusal else ""
    rest = "" if document.table.at_rest else "; THE TABLE IS NOT AT REST"
    name = document.reason.removeprefix("TUMBLE_REASON_")
    raise BenchFault(f"the run failed: {document.reason_sentence} ({name}, {where}{code}){rest}")


def with_stand(document: Bench | Node, stand: Stand, **others: dict[str, int]) -> RunWithTruth:
    """A run's document with what tumble-stand knows of it, and the counters of both and of `others`."""
    counters = dict(document.counters)
    for who, told in {"stand": stand.counters, **others}.items():
        counters |= {f"{who}_{name}": value for name, value in told.items()}
    known = {name: getattr(stand, name) for name in ("seed", "truth", "faults", "table")} | {"counters": counters}
    if isinstance(document, Bench):
        return structs.replace(document, **known)
    return NodeWithStand(**{**structs.asdict(document), **known})


def confirm(document: RunWithTruth, stage: Path, setup: Setup) -> Solution:
    """The firmware's result as a solution, if three computations agree; else raises Disagreement.

    The core behind the binding, given the firmware's means, must give the firmware's bits. The numpy witness must
    confirm it within 1e-12 of max|K| (the optimal estimator: 1e-6 of u), once from these means and once from the
    samples in run.csv, averaged anew. And it must confirm the standard uncertainties that the firmware states.

    Further terms of the model, which the firmware does not know, are found from the same means then. Raises BadInput
    where they are not to be had.
    """
    recorded = read_run(str(stage / "run.csv"), setup.schedule.data, LayoutOptions(unit="V"))
    run = _as_averaged(recorded, document)
    given = run, setup.schedule, setup.estimator, setup.limit_g, setup.stand, "run.csv"
    try:
        solution = solve(
            *given, step_v=step_v(setup), known=weights_made_for(setup), coverage_factor=setup.coverage_factor
        )
    except BadInput as error:
        raise Disagreement(f"the firmware has a result, but: {error}; no result is given") from None
    _require_same_bits(solution, document)
    _require_same_estimate(solution, recorded, setup)
    _require_same_uncertainties(solution, document, setup)
    if setup.terms:
        solution = solve(*given, step_v=step_v(setup), terms=setup.terms, coverage_factor=setup.coverage_factor)
    return dataclasses.replace(solution, truth=_truth(document.truth), knows_signs=True)  # of the nominal scale


def result_text(
    solution: Solution,
    setup: Setup,
    stand_file: StandFile | None,
    document: RunWithTruth,
    bus: str = INPROCESS,
    firmware: str = "host",
) -> str:
    """result.json of a run that `confirm` has confirmed."""
    item, environment = (None, None) if stand_file is None else (stand_file.item, stand_file.environment)
    serial = None if setup.block is None else setup.block.get("serial")
    created = result.created(clock=bus != INPROCESS)
    found = result.document_of(solution, item, environment, serial, "run.csv", created, complaints(solution))
    assert solution.truth is not None  # it has been simulated
    found.seed, found.bus, found.firmware = setup.seed, bus, firmware
    found.table, found.truth = Table(**bench.written(document.table)), solution.truth
    return to_json(found)


def _as_averaged(recorded: Run, document: RunWithTruth) -> Run:
    """The run with the firmware's means: those of the recorded samples but for rounding. All positions have one."""
    means = np.array([mean.u_v for mean in document.means])
    samples = [mean.samples for mean in document.means]
    if means.shape != recorded.means.shape or recorded.samples.tolist() != samples:
        raise Disagreement("the firmware averaged other samples than were recorded; no result is given")
    _require_close("a mean", means, recorded.means, RELATIVE_LIMIT * np.abs(recorded.means).max())
    return dataclasses.replace(recorded, means=means, counters={**recorded.counters, **document.counters})


def _require_same_bits(solution: Solution, document: RunWithTruth) -> None:
    found, check = solution.found, document.verification
    assert check is not None  # of a run that is done
    pairs = {
        "K": (found.k, document.K),
        "U0": (found.u0, document.U0),
        "delta_g": (found.gravity.delta_g, [row.delta_g_g for row in check.delta_g_g]),
        "pass": (found.gravity.passed, check.passed),
    }
    for name, (core, firmware) in pairs.items():
        if not np.array_equal(np.asarray(core), np.asarray(firmware)):
            raise Disagreement(f"the firmware's {name} is not what the core makes of its means; no result is given")


def _require_same_estimate(solution: Solution, recorded: Run, setup: Setup) -> None:
    schedule, found = setup.schedule.data, solution.found
    if setup.estimator == OPTIMAL:
        known, step = weights_made_for(setup), step_v(setup)
        one = optimal_estimate(schedule, recorded.means, setup.stand, recorded.samples, step, known.k, known.samples)
        _require_close("K", found.k, one.k, OPTIMAL_LIMIT_U * one.u_k)
        _require_close("U0", found.u0, one.u0, OPTIMAL_LIMIT_U * one.u_u0)
        return
    weights = setup.stand.with_step(step_v(setup)).weights
    twelve = unknowns(schedule, recorded.means, setup.estimator, weights=weights)
    _require_close("K", found.k.ravel(), twelve[:9], RELATIVE_LIMIT * np.abs(twelve[:9]).max())
    _require_close("U0", found.u0, twelve[9:], RELATIVE_LIMIT * np.abs(twelve[:9]).max())


def _require_same_uncertainties(solution: Solution, document: RunWithTruth, setup: Setup) -> None:
    """Those of the optimal estimator are for the gains on board, at the K that they were made for."""
    if document.u_K is None or document.u_U0 is None:
        raise Disagreement("the firmware states no uncertainties; no result is given")
    schedule, samples = setup.schedule.data, solution.run.samples
    variance = _noise_on_board(solution, document, setup)
    if setup.estimator == OPTIMAL:
        known, step = weights_made_for(setup), step_v(setup)
        given = schedule, known.k, setup.stand, samples, step, variance
        by_numpy = optimal_covariance(*given, known_samples=known.samples)
    else:
        # Rounding counts in the weights of the channels, and not as noise where none is declared.
        weighed = setup.stand.with_step(step_v(setup))
        noise = np.square(setup.stand.mean_sigma(samples)) if variance is None else variance
        seen = solution.measured_schedule
        by_numpy = Propagation(seen, solution.found.k, weighed, samples, setup.estimator).covariance(noise)
    stated = np.concatenate([np.ravel(document.u_K), document.u_U0])
    compare_uncertainties(stated, np.sqrt(np.diag(by_numpy)), setup.estimator == OPTIMAL)


def _noise_on_board(solution: Solution, document: RunWithTruth, setup: Setup) -> Floats | None:
    """What the noise of a mean counts at least, (positions, 3), from the recorded samples by the rule on board, which
    looks at two lengths of blocks; None where nobody looks. A position that was measured again counts twice there, and
    only its last samples are recorded: then as the firmware tells it."""
    told, samples, step = document.noise, solution.run.samples, step_v(setup)
    if told is None:
        return None
    declared = setup.stand.with_step(step) if setup.estimator == OPTIMAL else setup.stand
    scatter = (solution.run.scatter / step).astype(np.float32).astype(float) * step  # as it is kept there
    noise = estimate_noise(dataclasses.replace(solution.run, scatter=scatter), declared, step, told.block_samples)
    if document.counters["positions_kept"] > len(samples):
        above = np.array([name in told.above_declared for name in "xyz"])
        as_told: Floats = np.maximum(noise.mean_variance, above * np.square(told.noise_v) / samples[:, None])
        return as_told
    assert noise.measured is not None  # the firmware saw two samples of a position
    seen = of_means(noise.measured, samples)
    _require_close("the noise", told.noise_v, seen, _NOISE_LIMIT * seen)
    return noise.mean_variance


def _require_close(name: str, firmware: Floats, witness: Floats, allowed: Floats | float) -> None:
    difference = np.abs(firmware - witness)
    if not (difference <= allowed).all():
        with np.errstate(divide="ignore"):
            times = np.nanmax(difference / allowed)
        raise Disagreement(
            f"the firmware and numpy disagree: {name} differs by {times:.2g} times what is allowed; no result is given"
        )


def _truth(simulated: bench.Truth) -> Truth:
    """As results have it: in numbers as they are written, without what is not declared."""
    told: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in bench.written(simulated).items()
    }
    declared = {name: told[name] if any(told[name]) else UNSET for name in ("encoder_rad", "drift_v")}
    declared["over_temperature"] = simulated.over_temperature
    return Truth(**{**told, **declared, "K": np.array(told["K"]), "U0": np.array(told["U0"])})
