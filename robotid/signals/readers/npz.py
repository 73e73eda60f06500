"""NumPy archives of plain arrays."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.signals.readers.table import Table

SUFFIXES = (".npz",)
DAMAGED = (OSError, ValueError, EOFError, TypeError, KeyError, SyntaxError, NotImplementedError, RuntimeError)


def read(path: Path) -> Table:
    """Every numeric array of one or two dimensions. Pickled objects are refused."""
    try:
        with zipfile.ZipFile(path), np.load(path, allow_pickle=False) as archive:
            arrays = {name: np.squeeze(archive[name]) for name in archive.files}
    except (*DAMAGED, zipfile.BadZipFile, zlib.error) as error:
        what = "this is not a readable NumPy archive: foreign, damaged, or with pickled objects"
        raise InputError(what, where=str(path), hint="save plain arrays with numpy.savez") from error
    kept = {n: a for n, a in arrays.items() if a.dtype.kind in "fiub" and a.ndim in (1, 2) and a.size > 1}
    return Table(str(path), {name: a.astype(np.float64) for name, a in kept.items()})
