"""Tables with named columns: DataFrames of pandas and polars, tables of pyarrow, datasets of xarray, structured arrays,
and mappings from names to columns; and files of them: Parquet, NumPy's NPZ and MATLAB's MAT. A library is loaded when
such a file is read; who hands in a frame has loaded its own.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.errors import BadInput, NotInstalled, file_name, needing, quoted
from tumble.files.disk import bounded, opened, reason

PANDAS, POLARS, ARROW, XARRAY = "pandas", "polars", "pyarrow", "xarray"


def library_of(data: object) -> str | None:
    """The library whose DataFrame, Table or Dataset this is; None for anything else."""
    known = {(PANDAS, "DataFrame"), (POLARS, "DataFrame"), (ARROW, "Table"), (XARRAY, "Dataset")}
    for base in type(data).__mro__:
        library, kind = base.__module__.partition(".")[0], base.__name__
        if (library, kind) in known:
            return library
    return None


def is_table(data: object) -> bool:
    """Has it named columns?"""
    structured = isinstance(data, np.ndarray) and data.dtype.names is not None
    return library_of(data) is not None or isinstance(data, Mapping) or structured


def names_of(table: Any) -> list[str]:
    """Of its columns."""
    library = library_of(table)
    if library == ARROW:
        return list(map(str, table.column_names))
    if library is None and not isinstance(table, Mapping):
        return list(table.dtype.names)
    return list(map(str, table.columns if library in (PANDAS, POLARS) else table.keys()))


def real(column: Any) -> Floats:
    """As floats. Raises ValueError, TypeError."""
    if np.iscomplexobj(column):
        raise ValueError("complex")
    try:
        return np.asarray(column, dtype=float)
    except OverflowError as error:  # an integer of hundreds of digits
        raise ValueError(str(error)) from None


def column_of(table: Any, place: int, name: str) -> Floats:
    """Column number `place` as floats (rows,), NaN for what is missing. Raises BadInput, the table being `name`."""
    library, label = library_of(table), names_of(table)[place]
    try:
        if library == PANDAS:
            values = table.iloc[:, place].to_numpy(dtype=float, na_value=np.nan)
        elif library == POLARS:
            values = table.to_series(place).cast(float).to_numpy()
        elif library == ARROW:
            values = table.column(place).cast("double").to_numpy()
        elif isinstance(table, Mapping):
            values = real(list(table.values())[place])
        else:
            values = real(table[label])
    except (ValueError, TypeError) as error:
        raise BadInput(f"not numbers: {quoted(error)}", name, column=label) from None
    except Exception as error:  # of polars and pyarrow, which have classes of their own for it
        if library not in (POLARS, ARROW):
            raise
        raise BadInput(f"not numbers: {quoted(error)}", name, column=label) from None
    values = np.array(values, dtype=float)
    if values.ndim != 1:
        raise BadInput(f"has {values.ndim} dimensions, a column has one", name, column=label)
    return values


def stacked(table: Any, places: tuple[int, ...], labels: tuple[str, ...], name: str) -> Floats:
    """Columns number `places`, which errors call by `labels`, as (rows, columns). Raises BadInput as `column_of`."""
    values = [column_of(table, place, name) for place in places]
    if len({len(column) for column in values}) != 1:
        sizes = ", ".join(f"{label} {len(column)}" for label, column in zip(labels, values))
        raise BadInput(f"columns of different lengths: {sizes}", name)
    return np.stack(values, axis=1)


def with_columns(table: Any, renamed: dict[str, str], new: dict[str, Floats]) -> Any:
    """A table of the same kind: columns `renamed`, the `new` ones behind all. The index of pandas is kept."""
    library = library_of(table)
    if library == PANDAS:
        return table.rename(columns=renamed).assign(**new)
    if library == POLARS:
        from polars import Series

        return table.rename(renamed).with_columns([Series(name, values) for name, values in new.items()])
    if library == ARROW:
        table = table.rename_columns([renamed.get(name, name) for name in names_of(table)])
        for name, values in new.items():
            table = table.append_column(name, [values])
        return table
    if library == XARRAY:
        along = next(one.dims for one in table.values() if one.ndim == 1)
        return table.rename(renamed).assign({name: (along, values) for name, values in new.items()})
    columns = {renamed.get(name, name): table[name] for name in names_of(table)}
    return {**columns, **new}


PARQUET = (".parquet", ".pq")
NPZ, MAT = ".npz", ".mat"
SUFFIXES = (*PARQUET, NPZ, MAT)


def suffix_of(file: str | os.PathLike[str]) -> str:
    """Of a file's name, in small letters."""
    return os.path.splitext(os.fspath(file))[1].lower()


def read_table_file(file: str, suffix: str = "") -> Any:
    """The table in a file with one of SUFFIXES, or in one that is as those of this `suffix` are."""
    suffix = suffix or suffix_of(file)
    reader = _read_npz if suffix == NPZ else _read_mat if suffix == MAT else _read_parquet
    try:
        with bounded(file):
            return reader(file)
    except (BadInput, NotInstalled):
        raise
    except OSError as error:
        raise BadInput(reason(error) if error.errno else f"cannot be read: {quoted(error)}", file) from None
    except Exception as error:  # each library has classes of its own for what is no file of its kind
        raise BadInput(f"not a {suffix[1:]} file that can be read: {quoted(error)}", file) from None


def _read_parquet(file: str) -> Any:
    opened(file).close()  # the system's own complaint, whatever the library's is
    try:
        from pyarrow import parquet
    except ImportError:
        return load_polars(file).read_parquet(file)
    return parquet.read_table(file)


def load_polars(file: str) -> Any:
    """Where there is no pyarrow. Raises NotInstalled."""
    with needing(f"{file_name(file)}: Parquet", "pyarrow", "polars", extra="parquet"):
        import polars
    return polars


def _read_npz(file: str) -> dict[str, Any]:
    import zipfile

    if not zipfile.is_zipfile(file):
        with open(file, "rb"):
            raise BadInput("not an NPZ file", file)
    with np.load(file, allow_pickle=False) as arrays:
        return {name: _column(arrays[name]) for name in arrays.files}


def _read_mat(file: str) -> dict[str, Any]:
    with needing(f"{file_name(file)}: MAT", "scipy", extra="mat"):
        from scipy.io import loadmat
    opened(file).close()
    try:
        found = loadmat(file)
    except NotImplementedError:
        raise BadInput("MATLAB 7.3, which is HDF5: save it with -v7", file) from None
    return {name: _column(values) for name, values in found.items() if not name.startswith("__")}


def _column(values: Any) -> Any:
    """Of one row or column that column, of others the array as it is."""
    return values.ravel() if values.size == max(values.shape, default=1) else values
