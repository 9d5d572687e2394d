"""Many runs at once, and the same as a step of a pipeline of scikit-learn."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from tumble.api.recording import recording_of
from tumble.api.result import Result
from tumble.api.solving import solve
from tumble.errors import UsageError, needing
from tumble.estimators import COEFFICIENTS
from tumble.files import frames


def solve_many(runs: Mapping[Any, Any] | Iterable[Any], **given: Any) -> Any:
    """Solve several runs to one DataFrame of pandas: a row for each.

    Parameters
    ----------
    runs : mapping or iterable
        What `solve` takes, by name, or one after the other; then a file has its path for a name, others their number
        from 0.
    given : any, optional
        Arguments of `solve` by name, for all of them.

    Returns
    -------
    pandas.DataFrame
        Columns: `passed`, `estimator`, `unit`, the twelve coefficients, and behind `u_` their standard uncertainties
        (NaN where they are not known), `u_norm_worst_g`.

    Raises
    ------
    NotInstalled
        Without pandas; and what `solve` raises.

    Examples
    --------
    >>> import tumble
    >>> table = tumble.solve_many(["examples/paper_stand.csv"], stand="examples/paper_stand.toml")
    >>> table.loc["examples/paper_stand.csv", "K_zz"].round(3), bool(table.passed.all())
    (np.float64(2.004), True)
    """
    with needing("a table of results", "pandas", extra="pandas"):
        import pandas
    named = runs.items() if isinstance(runs, Mapping) else ((_name(run, i), run) for i, run in enumerate(runs))
    rows = {name: _row(solve(run, **given)) for name, run in named}
    return pandas.DataFrame.from_dict(rows, orient="index")


def _name(run: Any, number: int) -> Any:
    return os.fspath(run) if isinstance(run, (str, os.PathLike)) else number


def _row(result: Result) -> dict[str, Any]:
    worst = result.checked.u_norm_g
    uncertainties = {f"u_{name}": result[f"u_{name}"] for name in COEFFICIENTS}
    return {
        "passed": result.passed,
        "estimator": result.estimator,
        "unit": result.unit,
        **{name: result[name] for name in COEFFICIENTS},
        **uncertainties,
        "u_norm_worst_g": np.nan if worst is None else worst.worst_g,
    }


class Calibrator:
    """A calibration as scikit-learn has its steps: `fit` solves a run, `transform` turns outputs into acceleration.

    Parameters
    ----------
    given : any, optional
        Arguments of `solve` by name.

    Attributes
    ----------
    result_ : Result
        After `fit`.

    Examples
    --------
    >>> import tumble
    >>> calibrator = tumble.Calibrator(stand="examples/paper_stand.toml").fit("examples/paper_stand.csv")
    >>> calibrator.transform([[0.0, 0.0, 2.0]]).shape
    (1, 3)
    """

    def __init__(self, **given: Any):
        self._given = given

    def fit(self, run: Any, y: Any = None) -> Calibrator:
        """Solve a run, what `solve` takes. `y` is not looked at."""
        self.result_ = solve(run, **self._given)
        return self

    def transform(self, data: Any) -> Any:
        """What `Result.apply` makes of outputs. Raises UsageError before `fit`."""
        if not hasattr(self, "result_"):
            raise UsageError("Calibrator: transform comes after fit")
        return self.result_.apply(data)

    def fit_transform(self, run: Any, y: Any = None) -> Any:
        """Both, of a run: a table comes back with x, y, z, an array (rows, 5), and a file, as an array (rows, 3)."""
        self.fit(run)
        return self.transform(run if frames.is_table(run) else recording_of(run).outputs)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """What it was given."""
        return dict(self._given)

    def set_params(self, **given: Any) -> Calibrator:
        """Give it something else."""
        self._given.update(given)
        return self

    def get_feature_names_out(self, names: Any = None) -> Any:
        """Of what `transform` gives of an array."""
        return np.array(["x", "y", "z"], dtype=object)

    def __repr__(self) -> str:
        told = ", ".join(f"{name}={value!r}" for name, value in self._given.items())
        return f"tumble.Calibrator({told})"
