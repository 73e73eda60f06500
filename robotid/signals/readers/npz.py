"""NumPy archives of plain arrays."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from robotid.errors import InputError
from robotid.signals.readers.table import Table, numeric, table

SUFFIXES = (".npz",)
DAMAGED = (OSError, ValueError, EOFError, TypeError, KeyError, SyntaxError, NotImplementedError, RuntimeError)


def read(path: Path) -> Table:
    """Every numeric array of one or two dimensions, fields by dotted name. Nothing is unpickled."""
    try:
        if not zipfile.is_zipfile(path):
            raise ValueError("not a zip archive")
        with np.load(path, allow_pickle=False) as archive:
            columns = dict(column for name in archive.files for column in numeric(name, archive[name]))
    except (*DAMAGED, zipfile.BadZipFile, zlib.error) as error:
        what = "this is not a readable NumPy archive: foreign, damaged, or with pickled objects"
        raise InputError(what, where=str(path), hint="save plain arrays with numpy.savez") from error
    return table(str(path), columns)
