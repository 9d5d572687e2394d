"""Files of tables other than CSV: Parquet, NumPy's NPZ and MATLAB's MAT, as tables that `frames` knows.

The libraries are loaded when such a file is read. Raises BadInput; NotInstalled where a library is not there.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from tumble.errors import BadInput, NotInstalled, file_name, quoted
from tumble.files.disk import reason
from tumble.files.memory import bounded

PARQUET = (".parquet", ".pq")
_NPZ, _MAT = ".npz", ".mat"
SUFFIXES = (*PARQUET, _NPZ, _MAT)


def suffix_of(file: str | os.PathLike[str]) -> str:
    """Of a file's name, in small letters."""
    return os.path.splitext(os.fspath(file))[1].lower()


def read_table_file(file: str) -> Any:
    """The table in a file with one of SUFFIXES."""
    suffix = suffix_of(file)
    reader = _read_npz if suffix == _NPZ else _read_mat if suffix == _MAT else _read_parquet
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
    with open(file, "rb"):
        pass  # the system's own complaint, whatever the library's is
    try:
        from pyarrow import parquet
    except ImportError:
        pass
    else:
        return parquet.read_table(file)
    try:
        import polars
    except ImportError:
        raise NotInstalled(f"{file_name(file)}: Parquet", "pyarrow", "polars", extra="parquet") from None
    return polars.read_parquet(file)


def _read_npz(file: str) -> dict[str, Any]:
    import zipfile

    if not zipfile.is_zipfile(file):
        with open(file, "rb"):
            raise BadInput("not an NPZ file", file)
    with np.load(file, allow_pickle=False) as arrays:
        return {name: np.ravel(arrays[name]) for name in arrays.files}


def _read_mat(file: str) -> dict[str, Any]:
    try:
        from scipy.io import loadmat
    except ImportError:
        raise NotInstalled(f"{file_name(file)}: MAT", "scipy", extra="mat") from None
    with open(file, "rb"):
        pass
    try:
        found = loadmat(file)
    except NotImplementedError:
        raise BadInput("MATLAB 7.3, which is HDF5: save it with -v7", file) from None
    return {name: np.ravel(values) for name, values in found.items() if not name.startswith("__")}
