"""The configuration of an extended model: the one it came from, with more effects."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

from robotid.config.axes import AXES, BODY
from robotid.config.load import Loaded, as_yaml, resolved
from robotid.config.records import RecordSettings
from robotid.config.robot import Effects, ParameterSettings
from robotid.extension.results import Extension
from robotid.model.structure import Structure, belongs, changed


def extended_configuration(loaded: Loaded, found: Extension | Mapping[str, Extension], folder: Path) -> str:
    """The text of extended.yaml, to be kept in a folder. found : the extension of a single joint, or of each axis of
    the robot by its name; an axis without one stays as it is, and so do clocks, which are one for all axes."""
    if isinstance(found, Extension):
        return extended_text(
            loaded, found.fit.structure, _guesses(found), folder, late=found.late, horizon=found.fit.horizon
        )
    return _robot_text(loaded, found, folder)


def _guesses(extension: Extension) -> dict[str, float]:
    """Fitted values of what the extension added."""
    added = (p for p in extension.fit.parameters if any(belongs(p.name, effect) for effect in extension.added))
    return {p.name: p.value for p in added}


def _robot_text(loaded: Loaded, extensions: Mapping[str, Extension], folder: Path) -> str:
    """The configuration of a robot of several axes as it is written, with the models of the extensions."""
    whole: dict[str, Any] = deepcopy(dict(loaded.robot))
    for axis, extension in extensions.items():
        joint, structure = whole["robot"][AXES][axis], extension.fit.structure
        known = dict(joint.get("parameters") or {})
        known |= {name: {**(known.get(name) or {}), "guess": guess} for name, guess in _guesses(extension).items()}
        plant, own = whole.get("plant") or {}, joint.get("plant") or {}
        if (plant or own) and "model" not in plant | own:  # the virtual robot stays what it is
            joint["plant"] = own | {"model": joint["model"]}
        joint |= {"model": _as_lists(effects_of(structure)), "changes": _as_lists(changes_of(structure))}
        joint |= {"parameters": known, "recorded_angle": structure.recorded_angle}
    body = whole["robot"].get(BODY) or {}
    if (urdf := body.get("urdf", "<")).lstrip()[:1] != "<":
        body["urdf"] = _relative((urdf,), loaded.directory, folder)
    for record in whole["records"]:
        if (file := record.get("file")) is not None:
            files = (file,) if isinstance(file, str) else tuple(file)
            record["file"] = _as_list(_relative(files, loaded.directory, folder))
    return as_yaml(whole)


def _as_lists(mapping: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    return {key: list(values) for key, values in mapping.items()}


def _as_list(files: str | tuple[str, ...]) -> str | list[str]:
    return files if isinstance(files, str) else list(files)


def extended_text(
    loaded: Loaded,
    structure: Structure,
    guesses: Mapping[str, float],
    folder: Path,
    *,
    late: float,
    horizon: float | None = None,
) -> str:
    """A complete configuration for another structure, as YAML to be kept in a folder.

    guesses : starts of parameters, by dotted name. late [s] : by how much the torque of measured files is recorded
    later than was known; horizon [s] : of the pieces that it was fitted in, which a later fit takes from the start. The
    virtual robot, if there is one, stays what it is; measured files are named relative to the folder.
    """
    config = loaded.config
    known = dict(config.robot.parameters)
    for name, guess in guesses.items():
        known[name] = known.get(name, ParameterSettings()).model_copy(update={"guess": guess})
    robot = config.robot.model_copy(
        update={
            "model": effects_of(structure),
            "changes": changes_of(structure),
            "parameters": known,
            "recorded_angle": structure.recorded_angle,
        }
    )
    fit = config.fit if config.fit.horizon is not None else config.fit.model_copy(update={"horizon": horizon})
    return resolved(config.model_copy(update={"robot": robot, "records": _moved(loaded, folder, late), "fit": fit}))


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


def _moved(loaded: Loaded, folder: Path, late: float) -> tuple[RecordSettings, ...]:
    """The records with their files as seen from a folder, and what delays their torque."""
    return tuple(
        record
        if record.file is None
        else record.model_copy(
            update={
                "file": _relative(record.files, loaded.directory, folder),
                "torque_delay": record.torque_delay + late,
            }
        )
        for record in loaded.config.records
    )


def _relative(files: Sequence[str], here: Path, folder: Path) -> str | tuple[str, ...]:
    """Files relative to another folder."""
    moved = tuple(os.path.relpath(here / file, folder) for file in files)
    return moved[0] if len(moved) == 1 else moved
