"""Libraries that only some formats need: imported when such a file is read, and named where they are missing."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

from robotid.errors import InputError


def library(module: str, extra: str, path: Path) -> Any:
    """A module of an optional extra. path : the file that needs it. Raises InputError where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        what = f"to read {path.suffix} files, {module.partition('.')[0]} must be installed"
        raise InputError(what, where=str(path), hint=f"pip install 'robotid[{extra}]'") from error
