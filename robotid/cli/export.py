"""The command export: a fitted model, signals or frequency responses in the files of other programs."""

from __future__ import annotations

from pathlib import Path

from robotid.cli.console import print_message
from robotid.export.write import check_format, write_columns, write_tree
from robotid.pipeline.exports import Wanted, export_of


def export_artifact(file: Path, to: Path, *, model: str | None, record: str | None, speed: float) -> None:
    """Write what an artifact holds: all in one file, but as CSV a file each, where there are several: TO_RECORD.csv.

    Raises ConfigError for an artifact, a format or a name that cannot be exported, InputError where a file cannot be
    read or written.
    """
    check_format(to)
    found = export_of(file, Wanted(model, record, speed, print_message))
    if to.suffix.lower() != ".csv":
        write_tree(to, found.tree())
        print_message(f"{to} written: {found.summary}")
        return
    for name, columns in found.columns.items():
        one = to if len(found.columns) == 1 else to.with_name(f"{to.stem}_{name}{to.suffix}")
        write_columns(one, columns)
        print_message(f"{one} written: {found.summary}" if len(found.columns) == 1 else f"{one} written")
