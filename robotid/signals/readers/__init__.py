"""Readers of measured files, one format a file. A module here names its suffixes in SUFFIXES and reads by `read`."""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path
from types import ModuleType

from robotid.errors import InputError
from robotid.signals.readers.table import Table

__all__ = ["Table", "formats", "read"]


def formats() -> dict[str, ModuleType]:
    """Suffix to the module that reads it."""
    modules = (importlib.import_module(f"{__name__}.{m.name}") for m in pkgutil.iter_modules(__path__))
    return {suffix: module for module in modules for suffix in getattr(module, "SUFFIXES", ())}


def read(path: Path) -> Table:
    """All numeric columns of a file. Raises InputError where it is missing, of unknown format or damaged."""
    if path.is_dir():
        raise InputError("this is a folder", where=str(path), hint="of a ROS 2 bag, name the .mcap or .db3 file in it")
    if not path.is_file():
        raise InputError(
            "there is no such file", where=str(path), hint="a record's file is relative to the configuration"
        )
    known = formats()
    if path.suffix.lower() not in known:
        hint = f"known are {', '.join(sorted(known))}"
        raise InputError(f'no reader for the format "{path.suffix}"', where=str(path), hint=hint)
    table: Table = known[path.suffix.lower()].read(path)
    return table
