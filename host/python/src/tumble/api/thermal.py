"""A calibration over temperature: runs at several temperatures in, K(T) and U0(T) with uncertainties out."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET

from tumble import defaults
from tumble._version import __version__
from tumble.api.arguments import layout_options, require_flag, told_in_python
from tumble.api.recording import Recording, recording_of
from tumble.api.result import Figures, warnings_of
from tumble.api.solving import Solved, solved
from tumble.arrays import Floats
from tumble.documents import result as doc, thermal as document
from tumble.documents.base import to_json
from tumble.documents.thermal import Thermal
from tumble.errors import BadInput, UsageError, quoted
from tumble.files import frames
from tumble.files.calibrated import OUTPUTS, Demand, Seen, with_calibrated
from tumble.files.disk import RESULT_FILE, path_of, read_bytes, write_bytes, write_text
from tumble.files.rows import HIGHEST_C, LOWEST_C, NUMBERS
from tumble.files.run_layout import LayoutOptions
from tumble.model import reliability
from tumble.model.thermal import Polynomials, ThermalFit
from tumble.solving.coefficients import gravity_of
from tumble.solving.plausibility import outside
from tumble.solving.result import created, declared_stand, set_angles_part, unseen
from tumble.solving.thermal import BOLTING_KEPT, DEGREES, STAND_KEPT, Measured, ThermalSolution, solve_together
from tumble.stand import by_channel
from tumble.units import SI, force_unit, volts_per

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def solve_thermal(
    runs: Iterable[Any],
    *,
    temperature: str = "linear",
    stand: Any = None,
    schedule: Any = None,
    estimator: str | None = None,
    limit_g: float | None = None,
    confidence: float = defaults.DEFAULT_CONFIDENCE,
    at: Sequence[float] | None = None,
    bolted_once: bool = False,
    unit: str | None = None,
    columns: dict[str, str] | None = None,
) -> ThermalResult:
    """Calibrate a block over temperature, from runs at several temperatures.

    Parameters
    ----------
    runs : iterable
        What `solve` takes, each with a column temperature, deg C, or with its place in `at`.
    temperature : str, optional
        Degree of the polynomials, "linear" or "quadratic".
    stand, schedule, estimator, limit_g, confidence : optional
        As of `solve`, for every run.
    at : sequence of float, optional
        Temperatures of the runs, deg C.
    bolted_once : bool, optional
        The block stays bolted and the stand level through all runs: seat, yaw and level are the same in them. Errors of
        the axis, the platform and the encoder always are.
    unit, columns : optional
        As of `solve`.

    Returns
    -------
    ThermalResult

    Raises
    ------
    BadInput, UsageError, Disagreement
        As `solve`; also for temperatures that do not determine the polynomials.
    """
    with told_in_python():
        layout = layout_options(columns, unit)
        recordings = [recording_of(one, layout) for one in runs]
        given = {"stand": stand, "schedule": schedule, "estimator": estimator, "limit_g": limit_g}
        single, found = solved_together(recordings, temperature, at, bolted_once, confidence, **given)
        return ThermalResult(document_of(single, found))


def solved_together(
    recordings: Sequence[Recording],
    degree: str,
    temperatures_c: Sequence[float] | None,
    bolted_once: bool,
    confidence: float,
    **given: Any,
) -> tuple[list[Solved], ThermalSolution]:
    """Every run alone, and all together; `given`: as `solved` has it. Raises TumbleError."""
    if degree not in DEGREES:
        raise UsageError(f"--temperature: {quoted(degree)} is not one of {', '.join(DEGREES)}")
    if temperatures_c is not None and len(temperatures_c) != len(recordings):
        raise UsageError(f"--at: {len(temperatures_c)} temperatures for {len(recordings)} runs")
    hashes = [one.sha256 for one in recordings if one.sha256 is not None]
    if not recordings or len(set(hashes)) < len(hashes):
        raise UsageError("--temperature: runs of several temperatures, and none of them twice")
    single, measured = [], []
    for number, recording in enumerate(recordings):
        one = solved(recording, confidence=confidence, **given)
        single.append(one)
        if one.solution.found.estimator == "norm":
            raise UsageError("--temperature: with estimator norm every run has a frame of its own; give a schedule")
        told = None if temperatures_c is None else temperatures_c[number]
        measured.append(Measured(recording.name, one.solution, _temperatures_c(recording, one, told)))
    _require_one_stand(recordings, single)
    kept = (*STAND_KEPT, *(BOLTING_KEPT if bolted_once else ()))
    return single, solve_together(measured, DEGREES[degree], kept, confidence)


def _require_one_stand(recordings: Sequence[Recording], single: Sequence[Solved]) -> None:
    """Raise BadInput where a table of set angles corrects some of the runs alone."""
    plain = [recording.name for recording, one in zip(recordings, single) if one.solution.set_angles is None]
    if plain and len(plain) < len(single):
        why = "cannot be corrected by the table of set angles, as other runs are: leave out this run, or the table"
        raise BadInput(why, plain[0])


def _temperatures_c(recording: Recording, one: Solved, told_c: float | None) -> Floats:
    """The mean temperature of each position measured. Raises BadInput."""
    run, positions = one.solution.run, one.solution.schedule.positions
    measured = [positions[index] for index in np.flatnonzero(run.measured)]
    if told_c is not None:
        if not LOWEST_C <= told_c <= HIGHEST_C:
            raise UsageError(f"--at: {told_c:g} is no temperature from {LOWEST_C:g} to {HIGHEST_C:g} deg C")
        return np.full(len(measured), float(told_c))
    felt = recording.temperatures_c
    if felt is None:
        raise BadInput("has no temperature: import it with a column temperature, or give --at", recording.name)
    place, known = recording.mounting * NUMBERS + recording.position, ~np.isnan(felt)
    means = []
    for position in measured:
        rows = known & (place == position.mounting * NUMBERS + position.number)
        if not rows.any():
            raise BadInput(f"no row of position {position.label} tells its temperature", recording.name)
        means.append(float(felt[rows].mean()))
    return np.array(means)


def document_of(single: Sequence[Solved], found: ThermalSolution) -> Thermal:
    """As it is written."""
    first, decision, thermal = single[0], found.decision, found.fit
    count, u = len(thermal.polynomials.k), np.sqrt(np.diag(thermal.covariance)).reshape(-1, 12)
    file, unit = first.stand_file, first.solution.run.unit
    stand = first.solution.stand
    step_v = by_channel(first.solution.step) * volts_per(unit)
    return Thermal(
        created=created(),
        tumble=__version__,
        serial=None if file is None else file.serial,
        unit=unit,
        degree=count - 1,
        reference_c=thermal.polynomials.reference_c,
        range_c=found.range_c,
        K=tuple(thermal.polynomials.k),
        U0=tuple(thermal.polynomials.u0),
        u_K=tuple(u[:, :9].reshape(-1, 3, 3)) if found.has_stand else None,
        u_U0=tuple(u[:, 9:]) if found.has_stand else None,
        covariance=thermal.covariance if found.has_stand else None,
        at=tuple(_at(found, one) for one in (found.range_c[0], thermal.polynomials.reference_c, found.range_c[1])),
        u_norm_g=tuple(
            document.AtTemperature(temperature_c=at, worst_g=one.worst_g, attitude=one.attitude)
            for at, one in found.u_norms
        ),
        fit=document.ThermalFit(
            thermal.chi_squared, thermal.freedom, thermal.p, found.confidence, thermal.p >= 1.0 - found.confidence
        )
        if found.has_stand
        else None,
        reliability=None if found.reliability is None else unseen(found.reliability),
        reliability_norm_g=None if found.reliability is None else reliability.largest(found.reliability),
        max_abs_delta_g_g=max(float(np.abs(one).max()) for one in found.delta_g),
        at_one_temperature_g=found.at_one_temperature_g,
        passed=decision.passed,
        pass_reason=" and ".join(decision.failures) or None,
        decision=doc.Decision(decision.coverage_factor, decision.u_norm_g, decision.limit_g, decision.scope),
        assumes=decision.assumes,
        warnings=tuple(f"{one.name}: {told}" for one, its in zip(found.runs, single) for told in its.complaints),
        kept=found.kept,
        stand=None if stand is None else declared_stand(stand, step_v),
        set_angles=UNSET if first.solution.set_angles is None else set_angles_part(first.solution.set_angles),
        runs=tuple(
            _of_run(name, one, its, delta_g)
            for name, one, its, delta_g in zip(_told_apart(found.runs), found.runs, single, found.delta_g)
        ),
        item=None if file is None else file.item,
        environment=None if file is None else file.environment,
    )


def _at(found: ThermalSolution, temperature_c: float) -> document.CoefficientsAt:
    k, u0 = found.fit.polynomials.at(temperature_c)
    u = np.sqrt(np.diag(found.fit.covariance_at(temperature_c))) if found.has_stand else None
    return document.CoefficientsAt(
        temperature_c=temperature_c,
        K=k,
        U0=u0,
        u_K=None if u is None else u[:9].reshape(3, 3),
        u_U0=None if u is None else u[9:],
    )


def _told_apart(runs: Sequence[Measured]) -> list[str]:
    """Names of their files; with those of their folders where else two would be one."""
    paths = [os.path.split(one.name) for one in runs]
    names = [name for _, name in paths]
    if len(set(names)) == len(names):
        return names
    return [f"{os.path.basename(folder)}/{name}" if folder else name for folder, name in paths]


def _of_run(name: str, one: Measured, its: Solved, delta_g: Floats) -> document.RunAtTemperature:
    alone = its.document
    return document.RunAtTemperature(
        file=name,
        sha256=alone.run_sha256,
        range_c=(float(one.temperature_c.min()), float(one.temperature_c.max())),
        mean_c=float(one.temperature_c.mean()),
        schedule=None if alone.schedule is None else alone.schedule.name,
        estimator=alone.estimator,
        positions=len(delta_g),
        passed=alone.passed,
        pass_reason=alone.pass_reason,
        K=alone.K,
        U0=alone.U0,
        u_K=alone.u_K,
        u_U0=alone.u_U0,
        max_abs_delta_g_g=float(np.abs(delta_g).max()),
    )


class ThermalResult:
    """A calibration over temperature. Made by `solve_thermal` or `load_thermal`; immutable."""

    def __init__(self, told: Thermal, name: str = "the result"):
        """`name`: what errors call it."""
        self._told = told
        self._name = name
        self._polynomials = Polynomials(told.reference_c, np.array(told.K), np.array(told.U0))

    @property
    def checked(self) -> Thermal:
        """All of it, with names."""
        return self._told

    @property
    def passed(self) -> bool:
        """The decision, over the whole range."""
        return self._told.passed

    @property
    def unit(self) -> str:
        """Of the outputs."""
        return self._told.unit

    @property
    def range_c(self) -> tuple[float, float]:
        """Of the runs, deg C."""
        return self._told.range_c

    def at(self, temperature_c: float | Floats) -> tuple[Floats, Floats]:
        """K (..., 3, 3), outputs' unit per g, and U0 (..., 3) at temperatures (...), deg C; with a UserWarning where
        these are outside the range of the runs by more than 1 deg C, so that the polynomials are extrapolated."""
        self._warn_outside(temperature_c)
        return self._polynomials.at(temperature_c)

    def uncertainty_at(self, temperature_c: float) -> tuple[Floats, Floats]:
        """Standard uncertainties of K (3, 3) and U0 (3,) at a temperature, deg C; warns as `at` does. Beyond the range
        they hold if the block goes on as the polynomials do, which no run has shown. Raises BadInput without a
        stand."""
        self._warn_outside(temperature_c)
        u = np.sqrt(np.diag(self._fit.covariance_at(temperature_c)))
        return u[:9].reshape(3, 3), u[9:]

    def covariance_at(self, temperature_c: float) -> Floats:
        """Of K row by row and U0 at a temperature, deg C: (12, 12); as `uncertainty_at`."""
        self._warn_outside(temperature_c)
        return self._fit.covariance_at(temperature_c)

    @property
    def _fit(self) -> ThermalFit:
        """Raises BadInput."""
        if self._told.covariance is None:
            raise BadInput("no uncertainties: no stand was declared", self._name)
        return ThermalFit(self._polynomials, self._told.covariance, 0.0, 0)

    def _warn_outside(self, temperature_c: float | Floats) -> None:
        if outside(doc.Temperature(*self.range_c, "run_file"), temperature_c) is not None:
            low, high = self.range_c
            warnings.warn(f"extrapolated: the runs were at {low:.3g} to {high:.3g} deg C", stacklevel=3)

    @property
    def complaints(self) -> list[str]:
        """Warnings to show before it is used."""
        own = [] if self.passed else [f"it did not pass: {self._told.pass_reason}"]
        return [*own, *self._told.warnings]

    def apply(
        self,
        data: Any,
        temperature_c: Any = None,
        *,
        unit: str = "g",
        uncertainty: bool = False,
        columns: Any = None,
    ) -> Any:
        """Calibrate outputs: a = K(T)^-1 (U - U0(T)).

        `data`: an array (..., 3) of outputs in the result's unit, with `temperature_c` (...) or one for all, deg C,
        gives an array of the same shape; a table with columns ux, uy, uz and temperature, as `Result.apply` takes it,
        gives the same kind with x, y, z behind. `unit`: "g" or "m/s2". `uncertainty`: also standard uncertainties, at
        the temperature of each sample, as `Result.apply` has them: an array is then (..., 7). Raises UsageError,
        BadInput.
        """
        require_flag(uncertainty, "uncertainty")
        with told_in_python():
            demand = self.demand(layout_options(columns, None, wanted=OUTPUTS), unit, uncertainty)
            if frames.is_table(data):
                seen = Seen()
                found = with_calibrated(data, frames.library_of(data) or "table", demand, seen)
                known = doc.Temperature(*self.range_c, "run_file")
                for odd in warnings_of(seen, known, demand):
                    warnings.warn(odd, stacklevel=2)
                return found
            values = np.asarray(data, dtype=float)
            if temperature_c is None or values.shape[-1:] != (3,):
                raise UsageError("apply: outputs (..., 3) and their temperatures, or a table with a column temperature")
            try:
                felt = np.broadcast_to(np.asarray(temperature_c, dtype=float), values.shape[:-1])
            except ValueError:
                raise UsageError("apply: as many temperatures as outputs, or one for all") from None
            known = doc.Temperature(*self.range_c, "run_file")
            if (warning := outside(known, felt)) is not None:
                warnings.warn(warning, stacklevel=2)
            force: Floats = demand.values(values.reshape(-1, 3), 1.0, felt.ravel())
            count = force.shape[1] - 3  # of uncertainties, which stand before x, y, z in a table
            return np.roll(force, 3, axis=1).reshape(*values.shape[:-1], 3 + count)

    def demand(self, layout: LayoutOptions, unit: str, uncertainty: bool = False) -> Demand:
        """What is to be done with data. Raises UsageError, BadInput."""
        (gravity, u_gravity), of_force = gravity_of(self._told.environment), str(force_unit(unit))
        if of_force not in ("g", SI):
            raise UsageError(f"unit: {quoted(unit)} is neither g nor m/s2")
        if of_force == SI and gravity is None:
            raise BadInput("its environment has no gravity_m_s2, which m/s2 needs", self._name)
        if uncertainty and of_force == SI and u_gravity is None:
            raise BadInput("no uncertainties: its environment has no u_gravity_m_s2", self._name)
        fit = self._fit if uncertainty else ThermalFit(self._polynomials, np.zeros((0, 0)), 0.0, 0)
        per_g, u_per_g = (gravity or 1.0, u_gravity or 0.0) if of_force == SI else (1.0, 0.0)

        def warm(outputs: Floats, felt_c: Floats) -> Floats:
            force = fit.of(outputs, felt_c)
            if not uncertainty:
                return per_g * force
            by_gravity = u_per_g * np.column_stack([force, np.linalg.norm(force, axis=1)])
            u = np.hypot(per_g * fit.uncertainty(force, felt_c), by_gravity)
            return np.concatenate([u, per_g * force], axis=1)

        told = "unit" not in self._told.assumes
        return Demand(lambda outputs: outputs, self.unit, uncertainty, layout, told, per_g, warm)

    def plot(self, file: str | os.PathLike[str] | None = None, kind: str | None = None) -> dict[str, Figure]:
        """Pictures by name: figures of matplotlib, as wide as a page of A4.

        "coefficients": each over temperature, with its uncertainty and the runs alone; "residuals": the runs alone less
        the polynomials; "uncertainty": of the length of a calibrated acceleration at the worst attitude, over
        temperature (with a stand).

        Parameters
        ----------
        file : path, optional
            Write it, .png, .svg or .pdf by its name; without `kind` the coefficients. A kind in place of the file is
            that kind, unwritten.
        kind : str, optional
            This picture alone.

        Raises
        ------
        UsageError, BadInput
        NotInstalled
            Without matplotlib.
        """
        from tumble import pictures

        if kind is None and isinstance(file, str) and file in pictures.thermal.CAPTIONS:
            file, kind = None, str(file)
        with told_in_python():
            path = None if file is None else path_of(file)
            if path is not None:
                pictures.require_format(path, "file")
                kind = "coefficients" if kind is None else kind
            drawn = Figures(pictures.thermal.figures(self._told, kind))
            if path is not None and kind is not None:
                write_bytes(path, pictures.written(drawn[kind], path))
        return drawn

    def report(
        self,
        file: str | os.PathLike[str],
        *,
        template: str | os.PathLike[str] | None = None,
        logo: str | os.PathLike[str] | None = None,
        number: str | None = None,
        issued: str | None = None,
    ) -> None:
        """Write a calibration report, HTML or PDF as the file's name ends; arguments and errors as of
        `Result.report`."""
        from tumble.report.make import kind_of

        with told_in_python():
            name = path_of(file)
            files = {
                key: None if one is None else path_of(one) for key, one in (("template", template), ("logo", logo))
            }
            write_bytes(name, self.reported(kind_of(name, "file"), issued=issued, number=number, **files))

    def reported(self, kind: str, *, issued: str | None = None, **given: str | None) -> bytes:
        """What `report` writes; `kind`: "html" or "pdf"; `given`: template, logo, number."""
        from tumble.report.make import made_over_temperature
        from tumble.report.pages import require_date

        day, text = require_date((created() or "")[:10] if issued is None else issued), self.to_json()
        more: dict[str, Any] = {**given, "issued": day, "attached": text}
        return made_over_temperature(json.loads(text), self._name, kind, **more)

    def to_json(self) -> str:
        """As `save` writes it, schema tumble.thermal/1."""
        return to_json(self._told)

    def save(self, file: str | os.PathLike[str]) -> None:
        """To a file. Raises BadInput where it cannot be written."""
        write_text(os.fspath(file), self.to_json())

    def __repr__(self) -> str:
        low, high = self.range_c
        verdict = "passed" if self.passed else "not passed"
        return f"<tumble.ThermalResult, degree {self._told.degree}, {low:g} to {high:g} deg C: {verdict}>"


def is_thermal(file: str) -> bool:
    """Whether a file is of schema tumble.thermal/1. Raises BadInput where it cannot be read."""
    with suppress(ValueError, RecursionError):
        told = json.loads(read_bytes(file, RESULT_FILE))
        return isinstance(told, dict) and told.get("schema") == document.THERMAL
    return False


def load_thermal(file: str | os.PathLike[str]) -> ThermalResult:
    """Read a calibration over temperature.

    Parameters
    ----------
    file : path
        What `ThermalResult.save` or `tumble solve --temperature --out` wrote.

    Returns
    -------
    ThermalResult

    Raises
    ------
    BadInput
        For a file that cannot be used.
    """
    name = os.fspath(file)
    return ThermalResult(document.parse_thermal(read_bytes(name, RESULT_FILE), name), name)
