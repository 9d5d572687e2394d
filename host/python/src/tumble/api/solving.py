"""From a recording to a solution: the one way, of `tumble.solve` and of the command line."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from tumble.api.arguments import as_list, as_number, is_one_of, told_in_python
from tumble.api.complaints import complaints
from tumble.api.recording import Recording, recording_of
from tumble.api.result import Result
from tumble.defaults import (
    DEFAULT_CONFIDENCE,
    DEFAULT_COVERAGE_FACTOR,
    DEFAULT_ESTIMATOR,
    DEFAULT_LIMIT_G,
    DEFAULT_SCHEDULE,
    NEEDS_STAND,
)
from tumble.documents.base import to_json
from tumble.documents.result import Result as ResultDocument
from tumble.errors import UsageError, quoted
from tumble.estimators import ESTIMATORS, OPTIMAL
from tumble.files import run_rows
from tumble.files.schedule_file import schedule_of
from tumble.files.stand_file import StandFile, stand_file_of
from tumble.schedule import Schedule
from tumble.solving import plausibility
from tumble.solving.plausibility import contradicted, in_environment
from tumble.solving.result import created, document_of
from tumble.solving.solution import Solution, solve as solve_run
from tumble.stand import Stand
from tumble.terms import Terms, parse


@dataclass(frozen=True)
class Solved:
    """A `solution`, what its stand file declares (None: there is none), what is `odd` about its rows and its K, and
    when it was `created`; `run_file`: the name of what was solved, None where that was no file."""

    solution: Solution
    stand_file: StandFile | None
    odd: tuple[str, ...]
    created: str | None
    run_file: str | None

    def complaints(self, solution: Solution | None = None) -> list[str]:
        """Why it may not be what it claims; `solution`: if more has been found since."""
        confirmed = plausibility.confirms_unit(self.solution, self.stand_file)
        return complaints(solution or self.solution, self.odd, confirmed)

    def document(self, solution: Solution | None = None) -> ResultDocument:
        """As it is written, schema tumble.result/1; `solution` as of `complaints`."""
        file, told_of = self.stand_file, self.complaints(solution)
        told = (None, None, None) if file is None else (file.item, file.environment, file.serial)
        return document_of(solution or self.solution, *told, self.run_file, self.created, told_of)


def solved(
    recording: Recording,
    *,
    stand: Any = None,
    schedule: Any = None,
    estimator: str = DEFAULT_ESTIMATOR,
    limit_g: float | None = None,
    confidence: float = DEFAULT_CONFIDENCE,
    terms: Terms = (),
) -> Solved:
    """Solve a recording; arguments as of `solve`. Raises TumbleError."""
    if not is_one_of(estimator, ESTIMATORS):
        raise UsageError(f"estimator: {quoted(estimator)} is not one of {', '.join(ESTIMATORS)}")
    if estimator == OPTIMAL and stand is None:
        raise UsageError(NEEDS_STAND)
    now = created()
    stand_file = None if stand is None else stand_file_of(stand)
    declared_g = None if stand_file is None else stand_file.delta_g_limit_g
    told_g = declared_g if limit_g is None else limit_g
    run, planned = recording.averaged_on(schedule_of(DEFAULT_SCHEDULE if schedule is None else schedule, estimator))
    odd_rows = run_rows.check_rows(run, planned.data, stand_file, recording.name)
    environment = None if stand_file is None else stand_file.environment
    contradiction = contradicted(run, environment)
    solution = solve_run(
        in_environment(run, environment),
        planned,
        estimator,
        DEFAULT_LIMIT_G if told_g is None else told_g,
        None if stand_file is None else stand_file.stand,
        recording.name,
        0.0 if stand_file is None else stand_file.step_v,
        confidence=confidence,
        terms=terms,
        coverage_factor=DEFAULT_COVERAGE_FACTOR if stand_file is None else stand_file.decided_by,
    )
    solution = plausibility.with_order_flag(solution, stand_file)
    odd = (*odd_rows, *plausibility.check_k(solution, stand_file, recording.name))
    odd += () if contradiction is None else (contradiction,)
    return Solved(solution, stand_file, odd, now, os.path.basename(recording.name) if recording.is_file else None)


def solve(
    run: Any,
    *,
    stand: Stand | StandFile | str | os.PathLike[str] | None = None,
    schedule: Schedule | str | os.PathLike[str] | None = None,
    estimator: str = DEFAULT_ESTIMATOR,
    limit_g: float | None = None,
    confidence: float = DEFAULT_CONFIDENCE,
    model: str | Iterable[str] = (),
) -> Result:
    """Solve a run: the twelve coefficients of U = U0 + K a, with their uncertainties and a verdict.

    The firmware's own code computes, an independent numpy computation confirms; docs/method.md has the formulas:
    estimators (3) and (7), the gravity check (8).

    `run`: what `read` gives, or what it takes. `stand`: what is declared of the stand, a path (TOML) or an object; it
    gives the uncertainties. `schedule`: the name of a built-in one ("paper", the default, "three_mountings",
    "diagonal", "six_faces"), a path (TOML) or an object. `estimator`: "averaged", "refined", "least_squares" or
    "optimal", which needs a stand. `limit_g`: of the gravity check, g; default: the stand file's, else 3e-4.
    `confidence`: at which the run must fit its stand, 0.5 to 0.999999. `model`: further terms, "k2", "k3", "drift", of
    least_squares and optimal.

    A run that fails its limits is a result too: see its `passed`. Raises BadInput for a run, stand or schedule that
    cannot be used, UsageError for what contradicts itself (both are ValueErrors), Disagreement where numpy does not
    confirm the core, and what `read` raises.

    >>> import tumble
    >>> result = tumble.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml")
    >>> result.passed, result.K.shape, result.u_U0.shape
    (True, (3, 3), (3,))
    >>> round(float(result.K[2, 2]), 3)
    2.004
    """
    if limit_g is not None and not 0.0 < as_number(limit_g) <= 1.0:
        raise UsageError(f"limit_g: {quoted(limit_g)} is not a number of g above 0, at most 1")
    if not 0.5 <= as_number(confidence) <= 0.999999:
        raise UsageError(f"confidence: {quoted(confidence)} is not a number from 0.5 to 0.999999")
    with told_in_python():
        found = solved(
            recording_of(run),
            stand=stand,
            schedule=schedule,
            estimator=estimator,
            limit_g=limit_g,
            confidence=confidence,
            terms=parse(as_list(model), estimator),
        )
        return Result(to_json(found.document()), tuple(found.complaints()))
