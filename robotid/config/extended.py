"""The configuration of an extended model: the one it came from, with more effects."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from robotid.config.load import Loaded, resolved
from robotid.config.records import RecordSettings
from robotid.config.robot import Effects, ParameterSettings
from robotid.extension.results import Extension
from robotid.model.structure import Structure, belongs, changed


def extended_configuration(loaded: Loaded, extension: Extension, folder: Path) -> str:
    """The text of extended.yaml, to be kept in a folder."""
    added = [p for p in extension.fit.parameters if any(belongs(p.name, effect) for effect in extension.added)]
    return extended_text(loaded, extension.fit.structure, {p.name: p.value for p in added}, folder)


def extended_text(loaded: Loaded, structure: Structure, guesses: Mapping[str, float], folder: Path) -> str:
    """A complete configuration for another structure, as YAML to be kept in a folder.

    guesses : starts of parameters, by dotted name. The virtual robot, if there is one, stays what it is; measured
    files are named relative to the folder.
    """
    config = loaded.config
    known = dict(config.robot.parameters)
    for name, guess in guesses.items():
        known[name] = known.get(name, ParameterSettings()).model_copy(update={"guess": guess})
    robot = config.robot.model_copy(
        update={"model": effects_of(structure), "changes": changes_of(structure), "parameters": known}
    )
    return resolved(config.model_copy(update={"robot": robot, "records": _moved(loaded, folder)}))


def effects_of(structure: Structure) -> Effects:
    """Effects by port and channels by signal, as the robot section lists them."""
    found: dict[str, tuple[str, ...]] = {}
    for effect in (*structure.terms, *structure.channels):
        place, _, name = effect.partition(".")
        found[place] = (*found.get(place, ()), name)
    return found


def changes_of(structure: Structure) -> dict[str, tuple[str, ...]]:
    """Parameters that differ, by record."""
    found: dict[str, tuple[str, ...]] = {}
    for record, parameter in map(changed, structure.changes):
        found[record] = (*found.get(record, ()), parameter)
    return found


def _moved(loaded: Loaded, folder: Path) -> tuple[RecordSettings, ...]:
    """The records with their files as seen from a folder."""
    return tuple(
        record
        if record.file is None
        else record.model_copy(update={"file": _relative(record.files, loaded.directory, folder)})
        for record in loaded.config.records
    )


def _relative(files: Sequence[str], here: Path, folder: Path) -> str | tuple[str, ...]:
    """Files relative to another folder."""
    moved = tuple(os.path.relpath(here / file, folder) for file in files)
    return moved[0] if len(moved) == 1 else moved
