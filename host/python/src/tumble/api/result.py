"""A result: coefficients with uncertainties and a verdict, from `tumble.solve` or from a file that a solve wrote; for
notebooks as a small table of HTML."""

from __future__ import annotations

import base64
import html
import json
import math
import os
import warnings
from collections.abc import Iterator, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from tumble.api.arguments import (
    as_number,
    in_python,
    is_one_of,
    layout_options,
    require_flag,
    require_unit,
    told_in_python,
)
from tumble.api.recording import recording_of
from tumble.arrays import Floats
from tumble.defaults import DEFAULT_CONFIDENCE
from tumble.documents.base import described
from tumble.documents.result import Result as ResultDocument, Temperature, parse_result
from tumble.errors import BadInput, TumbleError, UsageError, needing, quoted
from tumble.estimators import COEFFICIENTS
from tumble.files import frames
from tumble.files.calibrated import OUTPUTS, Demand, Seen, factor_of, with_calibrated
from tumble.files.disk import RESULT_FILE, path_of, read_bytes, write_bytes, write_text
from tumble.files.run_layout import LayoutOptions
from tumble.files.stand_file import StandFile
from tumble.model.coefficients import Force, NoForce
from tumble.report.coefficients import DOUBLE, FIXED, FORMATS, NUMBERS, exported
from tumble.schedule import Schedule
from tumble.solving.coefficients import Coefficients
from tumble.solving.decision import Decision, complaints_of_result, marks
from tumble.solving.plausibility import outside
from tumble.stand import Stand
from tumble.units import force_unit, per_g, per_g_of, spelled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tumble.history import History

_UNKNOWN = "unknown"
_DIGITS = 6  # of a value whose uncertainty is not known
_MOST_DECIMALS = 12


def html_table(result: ResultDocument) -> str:
    """The verdict, then a row for each of the twelve coefficients: its
    value to the second digit of its standard uncertainty, that, and the unit of both."""
    values, unit = [*result.K.ravel().tolist(), *result.U0.tolist()], result.unit
    uncertainties: list[float | None] = [None] * len(values)
    if result.u_K is not None and result.u_U0 is not None:
        uncertainties = [*result.u_K.ravel().tolist(), *result.u_U0.tolist()]
    marked = marks(result.assumed_for)
    rows = "".join(
        _row("td", name + marked.get(name, ""), *_rounded(value, u), unit if name.startswith("U0") else per_g(unit))
        for name, value, u in zip(COEFFICIENTS, values, uncertainties)
    )
    decision = Decision.of(result)
    verdict = f"<b>{decision.word}</b>{html.escape(decision.reason)}"
    return f"<p>{verdict}</p><table>{_row('th', '', 'value', 'std uncertainty', 'unit')}{rows}</table>"


def _row(tag: str, *cells: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{html.escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _rounded(value: float, u: float | None) -> tuple[str, str]:
    if u is None or u == 0.0:
        return f"{value:.{_DIGITS}g}", _UNKNOWN if u is None else "0"
    decimals = min(_MOST_DECIMALS, max(0, 1 - math.floor(math.log10(u))))
    return f"{value:.{decimals}f}", f"{u:.1e}"


class Figures(dict[str, "Figure"]):
    """Pictures by name; a notebook shows them."""

    def _repr_html_(self) -> str:
        from tumble.pictures import written

        coded = (base64.b64encode(written(figure, "picture.png")).decode() for figure in self.values())
        shown = zip(self, coded)
        return "".join(f'<img alt="{html.escape(name)}" src="data:image/png;base64,{one}">' for name, one in shown)


class HasColumns(Protocol):
    """A DataFrame of pandas or polars, or a table of pyarrow."""

    @property
    def columns(self) -> Any:
        """Of whatever kind: each library has its own."""


FrameT = TypeVar("FrameT", bound=HasColumns)
UNITS = ("g", "m/s2")


class Result:
    """What a solve found: U = U0 + K a, U the outputs in `unit`, a the specific force in g. Immutable.

    K_ij is the response of channel i to acceleration along axis j. Uncertainties are standard uncertainties (one
    sigma), in the unit of what they are of, by propagation of the declared stand's errors; None where no stand was
    declared. Arrays are float64 and cannot be written to.
    """

    def __init__(self, text: str, warnings: tuple[str, ...] | None = None, name: str = "result"):
        """`text`: JSON of schema tumble.result/1; `warnings`: None for those that it shows; `name`: what errors call
        it. Raises BadInput, UsageError."""
        if not isinstance(text, str):
            raise UsageError(f"text: a {type(text).__name__} is no text of a result; tumble.load reads a file")
        self._text = text
        self._name = name
        self._told = parse_result(text.encode("utf-8", "surrogatepass"), name)
        told = complaints_of_result(self._told) if warnings is None else warnings
        self.warnings = tuple(map(in_python, told))
        """Why the result may not be what it claims: the sentences that the command line prints, with arguments in place
        of options."""

    @property
    def checked(self) -> ResultDocument:
        """The same by its types, tumble.documents.result."""
        return self._told

    @property
    def document(self) -> dict[str, Any]:
        """All that is known, as it is written: docs/files.md explains every key. A copy, which may be changed."""
        found: dict[str, Any] = json.loads(self._text)
        return found

    @property
    def keys(self) -> dict[str, str]:
        """The keys of `document` and what they mean.

        >>> import tumble
        >>> tumble.solve("examples/paper_stand.csv").keys["U0"]
        'Outputs at zero acceleration.'
        """
        return described(ResultDocument)[1]

    @property
    def estimator(self) -> str:
        """By which the coefficients were found."""
        return str(self._told.estimator)

    @property
    def unit(self) -> str:
        """Of the outputs, such as "V"."""
        return str(self._told.unit)

    @cached_property
    def K(self) -> Floats:  # noqa: N802 # as the formulas have it
        """(3, 3), in the unit of the outputs per g."""
        return _fixed(self._told.K)

    @cached_property
    def U0(self) -> Floats:  # noqa: N802
        """(3,), in the unit of the outputs."""
        return _fixed(self._told.U0)

    @cached_property
    def u_K(self) -> Floats | None:  # noqa: N802
        """(3, 3): standard uncertainties of K; None without a stand."""
        return None if self._told.u_K is None else _fixed(self._told.u_K)

    @cached_property
    def u_U0(self) -> Floats | None:  # noqa: N802
        """(3,): standard uncertainties of U0; None without a stand."""
        return None if self._told.u_U0 is None else _fixed(self._told.u_U0)

    @cached_property
    def covariance(self) -> Floats | None:
        """(12, 12), of K row by row, then U0; None without a stand."""
        return None if self._told.covariance is None else _fixed(self._told.covariance)

    @property
    def passed(self) -> bool:
        """The gravity check (8) passed, and if a stand is declared, the run fits it and the uncertainty is within the
        limit at every attitude."""
        return bool(self._told.passed)

    @property
    def verdict(self) -> str:
        """PASS, FAIL, or NOT SHOWN where only the uncertainty stands in the way of a PASS."""
        return Decision.of(self._told).word

    @property
    def assumes(self) -> tuple[str, ...]:
        """Names of what the result rests on that nobody tested, such as "seat"."""
        return tuple(self._told.assumes)

    def __repr__(self) -> str:
        return f"<tumble.Result {self._name}: {self.estimator}, {Decision.of(self._told).word}, unit {self.unit}>"

    def __getitem__(self, name: str) -> float:
        """One of the twelve by its name, such as "K_xx" or "U0_z"; behind u_ its standard uncertainty, NaN where that
        is not known. Raises KeyError.

        >>> import tumble
        >>> round(tumble.solve("examples/paper_stand.csv")["K_zz"], 3)
        2.004
        """
        if name in COEFFICIENTS:
            return float([*self.K.ravel(), *self.U0][COEFFICIENTS.index(name)])
        if isinstance(name, str) and name.removeprefix("u_") in COEFFICIENTS:
            if self.u_K is None or self.u_U0 is None:
                return math.nan
            return float([*self.u_K.ravel(), *self.u_U0][COEFFICIENTS.index(name.removeprefix("u_"))])
        raise KeyError(f"{name!r} is none of {', '.join(COEFFICIENTS)}, nor u_ and one of them")

    def __iter__(self) -> Iterator[str]:
        """The names of the twelve."""
        return iter(COEFFICIENTS)

    def to_frame(self) -> Any:
        """The twelve as a DataFrame of pandas, by name: `value`, `u` (NaN where it is not known) and `unit` of both,
        and names of what each `assumes`."""
        with needing("a table of coefficients", "pandas", extra="pandas"):
            import pandas
        assumed_for = self._told.assumed_for.items()
        rows = [
            (
                self[name],
                self[f"u_{name}"],
                self.unit if name.startswith("U0") else per_g(self.unit),
                " ".join(one for one, where in assumed_for if not where or name in where),
            )
            for name in COEFFICIENTS
        ]
        index = pandas.Index(COEFFICIENTS, name="coefficient")
        return pandas.DataFrame(rows, index=index, columns=["value", "u", "unit", "assumes"])

    def to_xarray(self) -> Any:
        """K (channel, axis) and U0 (channel) as a Dataset of xarray, with u_K and u_U0 where they are known; units and
        verdict are attributes."""
        with needing("a dataset of coefficients", "xarray", extra="xarray"):
            import xarray
        found = {"K": (("channel", "axis"), self.K), "U0": (("channel",), self.U0)}
        if self.u_K is not None and self.u_U0 is not None:
            found |= {"u_K": (("channel", "axis"), self.u_K), "u_U0": (("channel",), self.u_U0)}
        units = {"K": per_g(self.unit), "U0": self.unit}
        variables = {name: (*one, {"units": units[name.removeprefix("u_")]}) for name, one in found.items()}
        verdict = {"estimator": self.estimator, "verdict": Decision.of(self._told).sentence}
        return xarray.Dataset(variables, {"channel": ["ux", "uy", "uz"], "axis": list("xyz")}, verdict)

    def summary(self) -> str:
        """The verdict, and a line for each of the twelve, as text."""
        marked, lines = marks(self._told.assumed_for), [Decision.of(self._told).sentence, ""]
        for name in COEFFICIENTS:
            u = self[f"u_{name}"]
            value, told = _rounded(self[name], None if math.isnan(u) else u)
            unit = self.unit if name.startswith("U0") else per_g(self.unit)
            lines.append(f"{name + marked.get(name, ''):6} {value:>14} +- {told:<8} {unit}")
        return "\n".join([*lines, *(f"Beware: {one}" for one in self.warnings)])

    def _repr_html_(self) -> str:
        """What a notebook shows: the verdict, and the coefficients with their uncertainties."""
        return html_table(self._told)

    @overload
    def apply(
        self,
        data: FrameT,
        *,
        unit: str = "g",
        uncertainty: bool = False,
        columns: dict[str, str] | None = None,
        outputs_unit: str | None = None,
    ) -> FrameT: ...
    @overload
    def apply(
        self,
        data: Mapping[str, Any],
        *,
        unit: str = "g",
        uncertainty: bool = False,
        columns: dict[str, str] | None = None,
        outputs_unit: str | None = None,
    ) -> dict[str, Any]: ...
    @overload
    def apply(
        self,
        data: ArrayLike,
        *,
        unit: str = "g",
        uncertainty: bool = False,
        columns: dict[str, str] | None = None,
        outputs_unit: str | None = None,
    ) -> Floats: ...
    def apply(
        self,
        data: Any,
        *,
        unit: str = "g",
        uncertainty: bool = False,
        columns: dict[str, str] | None = None,
        outputs_unit: str | None = None,
    ) -> Any:
        """Calibrate outputs: a = K^-1 (U - U0); with further terms in the result, the root of their equation.

        A column temperature, deg C, of a table is held against that of the run: a UserWarning where a row is more than
        1 deg C outside. Where nobody tells the unit of the data or of the run, another such warning comes if the
        acceleration at rest is not near 1 g. Missing values (NaN, null) stay missing.

        Parameters
        ----------
        data : array (..., 3) or table
            Outputs; a table has columns ux, uy, uz: a DataFrame of pandas or polars, a table of pyarrow, a Dataset of
            xarray or a mapping.
        unit : str, optional
            Of the acceleration: "g" or "m/s2", which needs gravity_m_s2 in the result's environment.
        uncertainty : bool, optional
            Also standard uncertainties of x, y, z and of the length, by the covariance of the coefficients (and of the
            gravity, for m/s2). The noise of the data itself is not in them.
        columns : dict of str to str, optional
            The columns that are named otherwise, as in `{"ux": "AccX"}`.
        outputs_unit : str, optional
            Of the data; default: the one in brackets in the columns' names, else the result's.

        Returns
        -------
        array or table
            Of an array (..., 3) the same shape; with uncertainty (..., 7) of x, y, z, u_x, u_y, u_z, u_norm. Of a table
            the same kind with x, y, z behind all its columns, its index kept; with uncertainty u_x, u_y, u_z, u_norm
            before them. What had those names before is called raw_x, raw_y, raw_z.

        Raises
        ------
        UsageError, BadInput

        Examples
        --------
        >>> import tumble
        >>> result = tumble.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml")
        >>> result.apply(result.U0 + result.K @ [0.36, 0.48, 0.8]).round(9).tolist()
        [0.36, 0.48, 0.8]
        >>> table = result.apply({"time": [0.0], "ux": [0.01], "uy": [0.02], "uz": [2.0]})
        >>> list(table)
        ['time', 'ux', 'uy', 'uz', 'x', 'y', 'z']
        """
        require_flag(uncertainty, "uncertainty")
        with told_in_python():
            force, of_force = self.force(unit, uncertainty), str(force_unit(unit))
            outputs_unit = spelled(outputs_unit) if isinstance(outputs_unit, str) else outputs_unit
            require_unit(outputs_unit, "outputs_unit")
            layout = layout_options(columns, outputs_unit, wanted=OUTPUTS)
            demand = demand_of(force, self.unit, uncertainty, layout, "unit" not in self.assumes, of_force)
            if frames.is_table(data):
                name, seen = frames.library_of(data) or "table", Seen()
                found = with_calibrated(data, name, demand, seen)
            else:
                name, seen = "data", Seen(unit_told=outputs_unit is not None)
                found = _of_array(force, data, self.unit, uncertainty, outputs_unit)
                seen.weigh(found.reshape(-1, found.shape[-1])[:, :3] / demand.one_g)
            for odd in warnings_of(seen, self._told.temperature, demand):
                warnings.warn(f"{name}: {odd}", stacklevel=2)
        return found

    def force(self, unit: str = "g", uncertainty: bool = False) -> Force:
        """What turns outputs in the result's unit into specific force in `unit`. `uncertainty`: it must be known."""
        unit = str(force_unit(unit))
        if unit not in UNITS:
            raise UsageError(f"unit: {quoted(unit)} is not one of {', '.join(UNITS)}")
        try:
            force = Coefficients.of(self._told, unit).force
        except ValueError as error:
            raise BadInput(str(error), self._name) from None
        if uncertainty and not force.is_certain:
            why = "no stand was declared" if self.covariance is None else "its environment has no u_gravity_m_s2"
            raise BadInput(f"no uncertainties: {why}", self._name)
        return force

    def plot(
        self,
        file: str | os.PathLike[str] | None = None,
        kind: str | None = None,
        run: Any = None,
        *,
        stand: Stand | StandFile | str | os.PathLike[str] | None = None,
        schedule: Schedule | str | os.PathLike[str] | None = None,
    ) -> dict[str, Figure]:
        """Pictures of the result, by name: figures of matplotlib, as wide as a page of A4.

        "gravity_check", "residuals" (with the schedule), "samples" (with the run), "budget" (with the stand),
        "stand_seen", "correlation" and "attitude" (of a result that was solved with a stand); tumble.pictures.CAPTIONS
        says what they show.

        Parameters
        ----------
        file : path, optional
            Write it, .png, .svg or .pdf by its name; without `kind` the gravity check. A kind in place of the file is
            that kind, unwritten.
        kind : str, optional
            This picture alone.
        run : Recording, path, table or array, optional
            What was solved, as `read` gives or takes it.
        stand, schedule : any, optional
            As `solve` takes them, for a result of an earlier version, which does not repeat them.

        Returns
        -------
        dict of str to matplotlib.figure.Figure

        Raises
        ------
        UsageError
            For a picture that lacks something, or for a run, stand or schedule that is not that of this result.
        BadInput
            For files that cannot be read or written.
        NotInstalled
            Without matplotlib.

        Examples
        --------
        >>> import tumble
        >>> result = tumble.solve("examples/paper_stand.csv", stand="examples/paper_stand.toml")
        >>> list(result.plot("attitude"))
        ['attitude']
        """
        from tumble import pictures

        if kind is None and isinstance(file, str) and file in pictures.CAPTIONS:
            file, kind = None, str(file)
        with told_in_python():
            path = None if file is None else path_of(file)
            if path is not None:
                pictures.require_format(path, "file")
                kind = "gravity_check" if kind is None else kind
            recorded = None if run is None else recording_of(run)
            drawn = Figures(pictures.figures(self._told, recorded, schedule, stand=stand, kind=kind))
            if path is not None and kind is not None:
                write_bytes(path, pictures.written(drawn[kind], path))
        return drawn

    def to_json(self) -> str:
        """The result as `tumble solve --json` prints it: schema tumble.result/1."""
        return self._text

    def save(self, file: str | os.PathLike[str]) -> None:
        """Write `to_json()` to a file, as a whole or not at all.

        Parameters
        ----------
        file : path

        Raises
        ------
        BadInput
        """
        write_text(path_of(file), self._text)

    def export(
        self,
        format: str,
        file: str | os.PathLike[str] | None = None,
        *,
        unit: str | None = None,
        number: str = DOUBLE,
        step: float | None = None,
        labels: bool = False,
        certificate_number: str | None = None,
        issued: str | None = None,
    ) -> str:
        """The coefficients for other programs, as `tumble export` writes them; also to a `file`.

        Parameters
        ----------
        format : str
            "c", "csv", "matlab", "ros", "imucal", "px4", "ardupilot" or "dcc".
        file : path, optional
            Written as a whole or not at all.
        unit : str, optional
            Of accelerations: "g" or "m/s2", default: the format's.
        number : str, optional
            What a C header computes with: "double", "float" or "fixed".
        step : float, optional
            Of "fixed": the size of a count of the outputs, above 0.
        labels : bool, optional
            Also the block's serial number and other labels.
        certificate_number : str, optional
            Of "dcc"; default: the label of that name, else the number of the result's report.
        issued : str, optional
            Of "dcc": the date of issue, as "2026-11-28"; default: that of the result.

        Returns
        -------
        str

        Raises
        ------
        UsageError, BadInput

        Examples
        --------
        >>> import tumble
        >>> print(tumble.solve("examples/paper_stand.csv").export("c").splitlines()[0])
        /* Coefficients of a three-axis block of accelerometers: U = U0 + K a
        """
        if not is_one_of(format, FORMATS):
            raise UsageError(f"format: {quoted(format)} is not one of {', '.join(FORMATS)}")
        if not is_one_of(number, NUMBERS) or (number != DOUBLE and format != "c"):
            raise UsageError(
                f"number: {quoted(number)} is not one of {', '.join(NUMBERS)}, of which c alone has a choice"
            )
        if (number == FIXED) != (step is not None) or not (step is None or 0.0 < as_number(step) < 1e9):
            raise UsageError('step: belongs to number="fixed", and is the size of a count of the outputs, above 0')
        if unit is not None and not is_one_of(unit := str(force_unit(unit)), UNITS):
            raise UsageError(f"unit: {quoted(unit)} is not one of {', '.join(UNITS)}")
        for name, given in (("certificate_number", certificate_number), ("issued", issued)):
            if given is not None and format != "dcc":
                raise UsageError(f"{name}: is for dcc alone")
        with told_in_python():
            try:
                told = complaints_of_result(self._told)
                text = exported(self._told, format, unit, number, step, labels, told, 1, certificate_number, issued)
            except TumbleError:
                raise
            except ValueError as error:
                raise BadInput(str(error), self._name) from None
            if file is not None:
                write_text(path_of(file), text)
        return text

    def report(
        self,
        file: str | os.PathLike[str],
        *,
        run: Any = None,
        template: str | os.PathLike[str] | None = None,
        logo: str | os.PathLike[str] | None = None,
        number: str | None = None,
        since: Result | str | os.PathLike[str] | None = None,
        history: History | str | os.PathLike[str] | None = None,
        issued: str | None = None,
    ) -> None:
        """Write a calibration report, HTML or PDF as the file's name ends; docs/files.md tells what is in it.

        Parameters
        ----------
        file : path
            .html or .pdf by its name.
        run : Recording, path, table or array, optional
            What was solved, as `read` gives or takes it: then its samples are drawn too.
        template : path, optional
            A file of Jinja2 in place of the built-in one, or extending it.
        logo : path, optional
            A picture in PNG, JPEG or SVG.
        number : str, optional
            Of the report; default: the label certificate_number, else one by date and content, the same for the same
            result.
        since : Result or path, optional
            An earlier result of the same block: then the report says whether the block has changed, as `compare` does.
        history : tumble.history.History, path or URL, optional
            A history that has calibrations of the block: then the report shows them, and when the next one is due.
        issued : str, optional
            The date of issue, as "2026-11-28"; default: today's (UTC), or that of SOURCE_DATE_EPOCH.

        Raises
        ------
        BadInput, UsageError
        NotInstalled
            Where jinja2, matplotlib or (for PDF) WeasyPrint is missing.
        """
        from tumble.report.make import kind_of

        with told_in_python():
            name = path_of(file)
            given = {"template": template, "logo": logo}
            files = {key: None if one is None else path_of(one) for key, one in given.items()}
            kind = kind_of(name, "file")
            text = self.reported(kind, run, since=since, history=history, issued=issued, number=number, **files)
            write_bytes(name, text)

    def reported(
        self,
        kind: str,
        run: Any = None,
        *,
        since: Result | str | os.PathLike[str] | None = None,
        history: History | str | os.PathLike[str] | None = None,
        issued: str | None = None,
        **given: str | None,
    ) -> bytes:
        """What `report` writes; `kind`: "html" or "pdf"; `given`: template, logo, number."""
        from tumble.comparison import pair, report as comparison
        from tumble.report.make import made
        from tumble.report.pages import require_date
        from tumble.solving.result import created

        recording = None if run is None else recording_of(run, LayoutOptions(unit=self.unit))
        hashes = {self._told.run_sha256, None if recording is None else recording.sha256} - {None}
        if recording is not None and len(hashes) > 1:  # what has no hash is told by its means, when it is drawn
            raise BadInput(f"is not the run of {self._name}: its SHA-256 is another", recording.name)
        earlier = None
        if since is not None:
            before = since if isinstance(since, Result) else load(since)
            first = pair.ComparedResult.of("the earlier result", before._told, complaints_of_result(before._told))
            second = pair.ComparedResult.of("this result", self._told, complaints_of_result(self._told))
            earlier = before.document, comparison.document(pair.compare(first, second, None, DEFAULT_CONFIDENCE))
        day = require_date((created() or "")[:10] if issued is None else issued)
        more: dict[str, Any] = {**given, "earlier": earlier, "known": self._known(history), "issued": day}
        return made(self.document, self._name, kind, run=recording, attached=self._text, **more)

    def _known(self, history: History | str | os.PathLike[str] | None) -> Any:
        if history is None or not isinstance(history, (str, os.PathLike)):
            return None if history is None else history.trend_and_due(self._told, self._name)
        from tumble.history import History

        with History(history) as opened:
            return opened.trend_and_due(self._told, self._name)


def load(file: str | os.PathLike[str] | Mapping[str, Any]) -> Result:
    """Read a result.

    Parameters
    ----------
    file : path or mapping
        What `Result.save`, `tumble solve --out` or `tumble bench` wrote, or as `Result.document` has it.

    Returns
    -------
    Result

    Raises
    ------
    BadInput
    """
    if isinstance(file, Mapping):
        return Result(json.dumps(file))
    name = path_of(file)
    data = read_bytes(name, RESULT_FILE)
    parse_result(data, name)  # also that it is text
    return Result(data.decode("utf-8-sig"), name=name)


def _fixed(values: Any) -> Floats:
    found = np.array(values, dtype=float)
    found.flags.writeable = False
    return found


def values_of(force: Force, outputs: Floats, with_uncertainty: bool, name: str = "data") -> Floats:
    """x, y, z, then with uncertainty u_x, u_y, u_z, u_norm, of outputs (samples, 3) in the unit of the result."""
    try:
        found = force.of(outputs)
    except NoForce as error:
        raise BadInput(str(error), name, int(error.rows[0]) + 1) from None
    return np.concatenate([found, force.uncertainty(found)], axis=1) if with_uncertainty else found


def warnings_of(seen: Seen, known_c: Temperature | None, demand: Demand) -> tuple[str, ...]:
    """What to warn of after data were calibrated. `known_c`: temperature of the result, None where it is not known."""
    told = outside(known_c, seen.temperatures_c), seen.doubt(demand)
    return (*seen.passed_over, *(one for one in told if one is not None))


def demand_of(
    force: Force, unit: str, with_uncertainty: bool, options: LayoutOptions, unit_told: bool, of_force: str
) -> Demand:
    """What is to be done with a table, or with a file, of outputs; `unit`: of the result's, `unit_told` or assumed;
    `of_force`: the unit of the acceleration."""
    calibrate = partial(values_of, force, with_uncertainty=with_uncertainty)
    return Demand(calibrate, unit, with_uncertainty, options, unit_told, per_g_of(of_force))


def _of_array(force: Force, data: Any, unit: str, with_uncertainty: bool, outputs_unit: str | None) -> Floats:
    try:
        outputs = frames.real(data)
    except (TypeError, ValueError):
        kind = f"{type(data).__module__}.{type(data).__name__}"
        raise UsageError(f"{kind} is neither an array of numbers nor a table with columns") from None
    if outputs.ndim < 1 or outputs.shape[-1] != 3:
        raise UsageError(f"an array of shape {outputs.shape} holds no outputs: its last axis must be of 3 channels")
    flat = outputs.reshape(-1, 3) * factor_of(outputs_unit, unit, "data")
    values = values_of(force, flat, with_uncertainty)
    return values.reshape(*outputs.shape[:-1], values.shape[1])
