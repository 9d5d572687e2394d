"""From a recording to a solution, and why it may not be what it claims, in sentences: the one way, of `tumble.solve`
and of the command line, which prints them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from tumble import defaults
from tumble.api.arguments import as_list, as_number, is_one_of, layout_options, told_in_python
from tumble.api.recording import Recording, recording_of
from tumble.api.result import Result
from tumble.arrays import Floats
from tumble.core import MAX_POSITIONS, CoreRefusal, CoreSchedule
from tumble.documents.base import to_json
from tumble.documents.labels import measured_s, serial_of
from tumble.documents.result import Explanation, Result as ResultDocument, read_result
from tumble.errors import BadInput, UsageError, quoted
from tumble.estimators import ESTIMATORS, NORM, OPTIMAL
from tumble.files import run_rows
from tumble.files.run_file import Run
from tumble.files.schedule_file import planned_with
from tumble.files.stand_file import TWO_SERIALS, StandFile, stand_file_of
from tumble.fixture.judge import Limits
from tumble.model.fit import NOISE_V
from tumble.model.inclined import EQUAL
from tumble.model.norm import of_poses
from tumble.model.prior import Growth, LastCalibration, Run as RunFacts
from tumble.model.stand_seen import NAMES
from tumble.schedule import ANY_POSE, Schedule
from tumble.solving import hands, noise, plausibility
from tumble.solving.decision import NO_UNIT
from tumble.solving.many_runs import MonteCarlo, Verdict
from tumble.solving.noise import CORRELATED
from tumble.solving.plausibility import contradicted, in_environment
from tumble.solving.prior import temperature_notice
from tumble.solving.prior_run import Rule, solve_with_prior
from tumble.solving.result import created, document_of, today
from tumble.solving.set_angles import corrected, unusable
from tumble.solving.solution import Solution, solve as solve_run
from tumble.stand import SetAngles, Stand, by_channel
from tumble.terms import Terms, parse
from tumble.units import ANOTHER_UNIT, contradicts, looks_like, noise_unit


@dataclass(frozen=True)
class Solved:
    """A `solution`, what its stand file declares (None: there is none), what is `odd` about its rows and its K, and
    when it was `created`; `run_file`: the name of what was solved, None where that was no file."""

    solution: Solution
    stand_file: StandFile | None
    odd: tuple[str, ...]
    created: str | None
    run_file: str | None

    @cached_property
    def complaints(self) -> list[str]:
        """Why it may not be what it claims."""
        file = self.stand_file
        is_declared = file is not None and file.block is not None  # then K is the declared one where nothing is odd
        confirmed = is_declared and plausibility.examine(self.solution, file) == plausibility.Plausibility()
        return complaints(self.solution, self.odd, confirmed)

    @property
    def document(self) -> ResultDocument:
        """As it is written, schema tumble.result/1."""
        file = self.stand_file
        told = (None, None, None) if file is None else (file.item, file.environment, file.serial)
        return document_of(self.solution, *told, self.run_file, self.created, self.complaints)


def solved(
    recording: Recording,
    *,
    stand: Any = None,
    schedule: Any = None,
    estimator: str | None = None,
    limit_g: float | None = None,
    confidence: float = defaults.DEFAULT_CONFIDENCE,
    model: Any = (),
    prior: LastCalibration | None = None,
) -> Solved:
    """Solve a recording; arguments as of `solve`. Raises TumbleError."""
    if estimator is not None and not is_one_of(estimator, (*ESTIMATORS, NORM)):
        raise UsageError(f"estimator: {quoted(estimator)} is not one of {', '.join((*ESTIMATORS, NORM))}")
    if estimator == OPTIMAL and stand is None and not hands.brings_stand(schedule):
        raise UsageError(defaults.NEEDS_STAND)
    now = created()
    stand_file = None if stand is None else stand_file_of(stand)
    if prior is not None and estimator is None and stand is not None:
        estimator = OPTIMAL  # the one whose least squares a prior enters
    run, planned, estimator, terms, stand_file = _planned(recording, stand_file, schedule, estimator, as_list(model))
    declared_g = None if stand_file is None else stand_file.delta_g_limit_g
    told_g = declared_g if limit_g is None else limit_g
    odd_rows = run_rows.check_rows(run, planned.data, stand_file, recording.name)
    environment = None if stand_file is None else stand_file.environment
    contradiction = contradicted(run, environment)
    rule = Rule(
        defaults.DEFAULT_LIMIT_G if told_g is None else told_g,
        confidence,
        defaults.DEFAULT_COVERAGE_FACTOR if stand_file is None else stand_file.decided_by,
    )
    step_v = 0.0 if stand_file is None else stand_file.step_v
    known = None
    if prior is not None:
        require_prior(estimator, terms, planned.data)
        known = prior.at(facts_of(stand_file, run.sha256, run.unit, now))

    def solve_it(run: Run, stand: Stand | None) -> Solution:
        if known is not None:
            assert stand is not None  # optimal has one
            return solve_with_prior(known, run, planned, rule, stand, recording.name, step_v)
        return solve_run(
            run,
            planned,
            estimator,
            rule.limit_g,
            stand,
            recording.name,
            step_v,
            confidence=confidence,
            terms=terms,
            coverage_factor=rule.coverage_factor,
            signs=_signs(stand_file),
        )

    run, about_angles = in_environment(run, environment), None
    if stand_file is None or stand_file.set_angles is None:
        solution = solve_it(run, None if stand_file is None else stand_file.stand)
    else:
        table = stand_file.set_angles
        k = None if known is None else known.k
        solution, about_angles = _with_set_angles(solve_it, estimator, run, planned.data, stand_file, table, k)
    solution = replace(plausibility.with_order_flag(solution, stand_file), brought_stand=stand is None)
    odd = (*odd_rows, *plausibility.check_k(solution, stand_file, recording.name))
    odd += tuple(filter(None, (contradiction, about_angles)))
    odd += (TWO_SERIALS,) if stand_file is not None and stand_file.has_two_serials else ()
    return Solved(solution, stand_file, odd, now, os.path.basename(recording.name) if recording.is_file else None)


def _planned(
    recording: Recording, stand_file: StandFile | None, schedule: Any, estimator: str | None, further: str | None
) -> tuple[Run, CoreSchedule, str, Terms, StandFile | None]:
    """The run on its schedule, the estimator and the `further` terms to find, and the stand, which some schedules
    bring. Raises BadInput, UsageError."""
    of_poses_alone = isinstance(schedule, str) and schedule == ANY_POSE
    if of_poses_alone or estimator == NORM:
        if not of_poses_alone and schedule is not None:
            raise UsageError(f"--estimator {NORM} knows no directions: it takes --schedule {ANY_POSE} alone")
        if estimator not in (None, NORM):
            raise UsageError(f"--schedule {ANY_POSE} tells no directions, which {estimator} needs; {NORM} does not")
        run, planned = _any_poses(recording)
        return run, planned, NORM, parse(further, NORM), hands.poses(run) if stand_file is None else stand_file
    if estimator is None and stand_file is None and not further and hands.brings_stand(schedule):
        estimator = OPTIMAL  # the tilts of faces that were laid by hand spoil U0 of plain least squares
    planned, estimator = planned_with(defaults.DEFAULT_SCHEDULE if schedule is None else schedule, estimator)
    terms = parse(further, estimator)
    if planned.data.is_laid_by_hand:
        planned = hands.as_measured(planned, recording.mounting, recording.position)
    run, planned = recording.averaged_on(planned)
    if stand_file is None and hands.brings_stand(schedule):
        stand_file = hands.faces(run, planned.data, recording.name)
    return run, planned, estimator, terms, stand_file


_Solve: TypeAlias = "Callable[[Run, Stand | None], Solution]"


def _with_set_angles(
    solve_it: _Solve,
    estimator: str,
    run: Run,
    schedule: Schedule,
    stand_file: StandFile,
    table: SetAngles,
    known: Floats | None,
) -> tuple[Solution, str | None]:
    """A run on a stand with a table of set angles, by it if it can be used; and what a person is told of it. `known`: K
    (3, 3) of the prior, if there is one."""
    declared = stand_file.stand
    why_not = unusable(table, schedule, run, estimator, today())
    if why_not is not None:
        return solve_it(run, declared), why_not
    left = table.left_on(declared, len(schedule.fitted_mountings))
    solution = replace(solve_it(corrected(run, schedule, table, known), left), set_angles=table)
    if solution.fit is None or solution.fit.fits:
        return solution, None
    plain = solve_it(run, declared)
    if plain.fit is None or not plain.fit.fits:
        return solution, None
    return solution, (
        f"the run fits the stand, but not with its table of set angles: they have changed since {table.learned};"
        " learn it anew"
    )


def require_prior(estimator: str, terms: Terms, schedule: Schedule) -> None:
    """Raise UsageError where a solve has no prior."""
    if estimator != OPTIMAL:
        raise UsageError(f"--prior enters the least squares of --estimator optimal; {estimator} has none")
    if terms:
        raise UsageError(f"--prior is of the twelve coefficients alone: leave out --model {','.join(terms)}")
    if schedule.is_inclined:
        raise UsageError("--prior takes no block that is inclined with its stand: its run determines all by itself")


def facts_of(stand: Any, sha256: str | None, unit: str = "V", now: str | None = None) -> RunFacts:
    """What of a run decides whether a prior is for it. `stand`: as of `solve`. Raises TumbleError."""
    stand_file = None if stand is None else stand_file_of(stand)
    item, environment = (None, None) if stand_file is None else (stand_file.item, stand_file.environment)
    try:
        measured = measured_s(item, environment, now or created())
    except ValueError as error:
        raise BadInput(str(error), stand if isinstance(stand, str) else "stand") from None
    assert measured is not None  # a solve looks at the clock
    return RunFacts(
        serial_of(None if stand_file is None else stand_file.serial, item),
        unit,
        measured,
        sha256 or None,
        None if stand_file is None else stand_file.stand,
        (environment or {}).get("gravity_m_s2"),
    )


def last_calibration(prior: Any, growth: Any) -> LastCalibration | None:
    """What callers give as a prior, and how its block has changed since. Raises TumbleError."""
    if prior is None:
        if growth is not None:
            raise UsageError("--growth: without --prior there is nothing that grows")
        return None
    declared = None if growth is None else growth_of(growth)
    if isinstance(prior, LastCalibration):
        return prior if declared is None else replace(prior, growth=declared)
    if declared is None:
        raise UsageError(
            "--prior: nobody says how much such a block changes: give --growth SCALE,ANGLE,BIAS, in ppm, urad and ug"
            " a year"
        )
    if isinstance(prior, Result):
        return LastCalibration.of(prior.checked, "prior", declared)
    if isinstance(prior, (str, os.PathLike)):
        file = os.fspath(prior)
        return LastCalibration.of(read_result(file), file, declared)
    raise UsageError(f"prior: a {type(prior).__name__} is neither a result nor the path of one")


def growth_of(growth: Any) -> Growth:
    """Of three numbers, ppm, urad and ug a year, or a text of these. Raises UsageError."""
    try:
        sizes = [*map(float, growth.split(","))] if isinstance(growth, str) else [*map(as_number, growth)]
    except (TypeError, ValueError):
        sizes = []
    if len(sizes) != 3 or not all(0.0 <= one <= _MOST_GROWTH for one in sizes):
        raise UsageError(
            f"--growth: {quoted(growth)} is not three numbers from 0 to {_MOST_GROWTH:g}, ppm, urad and ug a year"
        )
    return Growth.declared(*(one * 1e-6 for one in sizes))


_MOST_GROWTH = 1e5  # a tenth: no block that is worth a prior


def _any_poses(recording: Recording) -> tuple[Run, CoreSchedule]:
    """A run of poses of any numbers. Where a mounting has several, they are numbered anew, in the order of the run."""
    numbers = list(dict.fromkeys(zip(recording.mounting.tolist(), recording.position.tolist())))
    if len(numbers) > MAX_POSITIONS:
        raise BadInput(f"{len(numbers)} poses, at most {MAX_POSITIONS} are solved", recording.name)
    try:
        own = CoreSchedule(of_poses(numbers))
    except CoreRefusal as refusal:
        raise BadInput(str(refusal), recording.name) from None
    anew = (
        own
        if len(own.data.mountings) == len(numbers)
        else CoreSchedule(of_poses([(i + 1, 1) for i in range(len(numbers))]))
    )
    return recording.averaged_on(own)[0], anew


def _signs(stand_file: StandFile | None) -> Floats:
    """Of the scales of a declared block (3,); + where none is."""
    if stand_file is None or stand_file.block is None:
        return EQUAL
    return np.sign(by_channel(stand_file.block["scale_v_per_g"]))


def solve(
    run: Any,
    *,
    stand: Stand | StandFile | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    schedule: Schedule | str | os.PathLike[str] | None = None,
    estimator: str | None = None,
    limit_g: float | None = None,
    confidence: float = defaults.DEFAULT_CONFIDENCE,
    model: str | Iterable[str] = (),
    prior: LastCalibration | Result | str | os.PathLike[str] | None = None,
    growth: Sequence[float] | None = None,
    unit: str | None = None,
    columns: dict[str, str] | None = None,
) -> Result:
    """Solve a run: the twelve coefficients of U = U0 + K a, with their uncertainties and a verdict.

    The firmware's own code computes, an independent numpy computation confirms; docs/method.md has the formulas:
    estimators (3) and (7), the gravity check (8).

    Parameters
    ----------
    run : Recording, path, table or array
        What `read` gives, or what it takes.
    stand : path, mapping, Stand or StandFile, optional
        What is declared of the stand: a path (TOML), an object, or a mapping of the keys of a stand file. It gives the
        uncertainties.
    schedule : str, path or Schedule, optional
        The name of a built-in one ("paper", the default, "three_mountings", "diagonal", "hand_laid", "six_faces",
        "inclined", or "any_pose"), one of `tumble.schedules`, a path (TOML) or an object.
    estimator : str, optional
        "averaged", "refined", "least_squares", "inclined", "norm", or "optimal", which needs a stand; default: what the
        schedule has.
    limit_g : float, optional
        Of the gravity check, g, above 0, at most 1; default: the stand file's, else 3e-4.
    confidence : float, optional
        At which the run must fit its stand, 0.5 to 0.999999.
    model : str or list of str, optional
        Further terms, "k2", "k3", "asymmetry", "cross", "drift", of least_squares and optimal.
    prior, growth : any, optional
        The last calibration of this block, a Result, a path or what `History.prior` returns; and standard deviations of
        what changes in a year: scales in ppm, angles between axes in urad, biases in ug. Not used if they disagree.
    unit, columns : any, optional
        Of what is read here, as `read` has them.

    Returns
    -------
    Result
        Of a run that fails its limits, too: see its `passed`.

    Raises
    ------
    BadInput
        For a run, stand or schedule that cannot be used, a ValueError; and what `read` raises.
    UsageError
        For what contradicts itself, a ValueError.
    Disagreement
        Where numpy does not confirm the core.

    Examples
    --------
    >>> import tumble
    >>> result = tumble.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml")
    >>> result.passed, result.K.shape, result.u_U0.shape
    (True, (3, 3), (3,))
    """
    _require_rule(limit_g, confidence)
    with told_in_python():
        if isinstance(run, Recording) and (unit is not None or columns is not None):
            raise UsageError("unit and columns are of what is read here: give them to tumble.read")
        found = solved(
            recording_of(run, layout_options(columns, unit)),
            stand=stand,
            schedule=schedule,
            estimator=estimator,
            limit_g=limit_g,
            confidence=confidence,
            model=model,
            prior=last_calibration(prior, growth),
        )
        return Result(to_json(found.document), tuple(found.complaints))


def _require_rule(limit_g: float | None, confidence: float) -> None:
    if limit_g is not None and not 0.0 < as_number(limit_g) <= 1.0:
        raise UsageError(f"limit_g: {quoted(limit_g)} is not a number of g above 0, at most 1")
    if not 0.5 <= as_number(confidence) <= 0.999999:
        raise UsageError(f"confidence: {quoted(confidence)} is not a number from 0.5 to 0.999999")


def complaints(solution: Solution, odd: Sequence[str] = (), confirmed_unit: bool = False) -> list[str]:
    """All of them. `odd`: what is odd about its rows and its K; `confirmed_unit`: the declared block shows that
    outputs are in the unit that its stand file is in, which is the volt where nobody names one."""
    told: list[str] = []
    one_g, unit = plausibility.size_of(solution.found.k), solution.run.unit
    # That 1 g comes out as if in another unit: than the one of acceleration that is told, or than the volt that nobody
    # tells. A declared block does not count where that unit is known: it may have been declared in it.
    if not solution.run.unit_told:
        told += [] if confirmed_unit else [NO_UNIT]
        if (seen := looks_like(one_g)) is not None:
            told.append(f"1 g gives {one_g:.4g}, and nobody names its unit: it looks like {seen}")
    elif (other := contradicts(one_g, unit)) is not None and (other != ANOTHER_UNIT or not confirmed_unit):
        told.append(f"1 g gives {one_g:.4g} {unit}: outputs look to be in {other}")
    told += odd
    if (span := plausibility.spanned(solution.run)) is not None:
        told.append(span)
    stand = None if solution.brought_stand else solution.stand
    if stand is not None and noise_unit(unit) != "V" and not confirmed_unit:
        declared = ", ".join(f"{one:g}" for one in np.atleast_1d(stand.noise).tolist())
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
    if solution.prior is not None:
        told += filter(None, [temperature_notice(solution.prior.prior, solution.run.temperature)])
        told += [] if (changed := solution.prior.finding) is None else [f"{changed}; the prior is not used"]
    return told


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
        sigma = {**limits.sigma, "inclination_rad": solution.stand.sigma("inclination")}[name]
        said = f"{named(explanation)}{seen} (declared {sigma:.1e})"
    else:
        said = _placed(name, explanation.column)
        said += "" if size is None else f" {size:.4g} +- {explanation.u_size:.2g} {unit}"
    return " or ".join([said, *(NAMES.get(other, other) for other in others)])


def named(explanation: Explanation) -> str:
    """Its likeliest pattern without sizes, such as "position 2.5 (x)" or "axis tilt"."""
    name = explanation.patterns[0]
    return _placed(NAMES.get(name, name), explanation.column)


def _placed(name: str, column: str | None) -> str:
    """With what shows it. One bad mean is that of a channel at a position, of which the channel may not be known."""
    if name == "position" and column:
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
