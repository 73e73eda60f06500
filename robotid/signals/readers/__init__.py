"""Readers of measured files, one format a file. A module here names its suffixes in SUFFIXES and reads by `read`."""

from __future__ import annotations

import importlib
import pkgutil
import re
from pathlib import Path
from types import ModuleType

from robotid.errors import InputError
from robotid.signals.readers.table import Table

BAGS = (".db3", ".mcap")
COMPRESSED = re.compile(rb"compression_mode:\s*['\"]?(?!none\b)\w", re.IGNORECASE)

__all__ = ["Table", "formats", "read"]


def formats() -> dict[str, ModuleType]:
    """Suffix to the module that reads it."""
    modules = (importlib.import_module(f"{__name__}.{m.name}") for m in pkgutil.iter_modules(__path__))
    return {suffix: module for module in modules for suffix in getattr(module, "SUFFIXES", ())}


def read(path: Path) -> Table:
    """All numeric columns of a file, or of the folder of a ROS 2 bag.

    Raises InputError where it is missing, of unknown format or damaged.
    """
    if path.is_dir():
        return _bag(path)
    if not path.is_file():
        raise InputError(
            "there is no such file", where=str(path), hint="a record's file is relative to the configuration"
        )
    if path.suffix == ".zstd" and path.with_suffix("").suffix in BAGS:
        raise InputError("this is a compressed file of a ROS 2 bag", where=str(path), hint="name its folder")
    known = formats()
    if path.suffix.lower() not in known:
        hint = f"export it as CSV, or name a file of {', '.join(sorted(known))}"
        raise InputError(f'no reader for the format "{path.suffix}"', where=str(path), hint=hint)
    table: Table = known[path.suffix.lower()].read(path)
    return table


def _bag(folder: Path) -> Table:
    """The ROS 2 bag of a folder: of its one file, or of all files that it was split into.

    How messages or files are compressed, only the folder says: then, as of several files, rosbags reads it.
    """
    files = sorted(file for file in folder.iterdir() if {*file.suffixes} & {*BAGS})
    metadata = folder / "metadata.yaml"
    if not metadata.is_file() or not files:
        hint = "name a file, or the folder of a ROS 2 bag, with metadata.yaml and a .db3 or .mcap file"
        raise InputError("this is a folder, and no ROS 2 bag", where=str(folder), hint=hint)
    if len(files) == 1 and not COMPRESSED.search(metadata.read_bytes()):
        return read(files[0])
    table: Table = formats()[".db3"].read(folder)
    return table
