"""The command export: a fitted model, signals or frequency responses in the files of other programs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from robotid.cli.console import print_message
from robotid.errors import ConfigError, InputError
from robotid.export.handover.target import Target, described
from robotid.export.targets import TARGETS
from robotid.export.write import check_format, write_columns, write_tree
from robotid.files import atomic_write
from robotid.model.units import typeset
from robotid.pipeline.exports import Export, Wanted, export_of


@dataclass(frozen=True, slots=True)
class Request:
    """What is wanted of an artifact. model, record : one of several; speed [rad/s] : about which a model is linearised;
    joint : its name in the other program; into : a file that is to have it; axis : of a robot of several."""

    model: str | None = None
    record: str | None = None
    speed: float = 0.0
    joint: str = ""
    into: Path | None = None
    axis: str | None = None


def export_artifact(file: Path, to: Path, request: Request) -> None:
    """Write what an artifact holds: all in one file, but as CSV a file each, where there are several: TO_RECORD.csv.

    Raises ConfigError for an artifact, a format or a name that cannot be exported, InputError where a file cannot be
    read or written.
    """
    check_format(to, TARGETS)
    target = TARGETS.get(to.suffix.lower())
    wanted = Wanted(
        request.model,
        request.record,
        request.speed,
        print_message,
        to,
        request.joint,
        _patched(request.into, target),
        request.axis or "",
    )
    found = export_of(file, wanted)
    if target is not None:
        _hand_over(found, target, file, to)
        return
    if to.suffix.lower() != ".csv":
        write_tree(to, found.tree())
        print_message(f"{to} written: {found.summary}")
        return
    for name, columns in found.columns.items():
        one = to if len(found.columns) == 1 else to.with_name(f"{to.stem}_{name}{to.suffix}")
        write_columns(one, columns)
        print_message(f"{one} written: {found.summary}" if len(found.columns) == 1 else f"{one} written")


def _hand_over(found: Export, target: Target, file: Path, to: Path) -> None:
    """Write a model for another program, and state what that file lacks."""
    if found.handed is None:
        raise ConfigError(
            f"{to.suffix} is written of a model only", where=str(file), hint="give model.h5 or extension.h5"
        )
    handed = target.hand_over(found.handed())
    atomic_write(to, handed.text)
    print_message(f"{to} written: {found.summary}, {target.summary}")
    for line in (*handed.remarks, *described(handed.omitted, handed.costs)):
        print_message(typeset(line))


def _patched(into: Path | None, target: Target | None) -> str:
    """Text of the file that is to have the joint, empty where there is none."""
    if into is None:
        return ""
    if target is None or not target.patches:
        endings = ", ".join(suffix for suffix, one in TARGETS.items() if one.patches)
        raise ConfigError(f"no {into.suffix} file is changed this way", where="--into", hint=f"TO ends in {endings}")
    try:
        return into.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise InputError("it is not text in UTF-8", where=str(into), hint="give a robot description") from error
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", where=str(into), hint="check --into") from error
