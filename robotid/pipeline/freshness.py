"""Which artifacts are fresh: made by this version from the same configuration and the same input content.

Times of files do not matter: a copied run directory is as fresh as it was, and so is a file that was only touched.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from robotid import __version__
from robotid.artifacts.store import ArtifactHeader, read_headers
from robotid.errors import InputError
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.stage import Stage

NOT_MADE = "not made yet"


class State(StrEnum):
    """What an artifact is worth."""

    FRESH = "fresh"
    STALE = "stale"
    ABSENT = "absent"


@dataclass(frozen=True, slots=True)
class StageStatus:
    """State of one stage's artifact, and why it is not fresh. axis : of a robot of several, whose states differ."""

    stage: str
    file: Path
    state: State
    why: str = ""
    header: ArtifactHeader | None = None
    axis: str = ""


Before = Mapping[str, Mapping[str, StageStatus]]
"""States of the stages that a stage reads, by axis and stage."""


def judge(run: Runs, stage: Stage, before: Before) -> dict[str, StageStatus]:
    """State of one stage's artifact for each axis; a damaged one is stale."""
    file = run.file(stage)
    if not file.exists():
        return {axis: StageStatus(stage.name, file, State.ABSENT, NOT_MADE, axis=axis) for axis in run.axes}
    try:
        headers = read_headers(file)
    except InputError as error:
        return {axis: StageStatus(stage.name, file, State.STALE, error.what, axis=axis) for axis in run.axes}
    if run.several == ("" in headers):
        what = "made for a single joint" if run.several else f"made for several axes: {', '.join(headers)}"
        return {axis: StageStatus(stage.name, file, State.STALE, what, axis=axis) for axis in run.axes}
    return {axis: _judged(joint, stage, headers.get(axis), before[axis]) for axis, joint in run.axes.items()}


def _judged(run: Run, stage: Stage, header: ArtifactHeader | None, before: Mapping[str, StageStatus]) -> StageStatus:
    file, axis = run.file(stage), run.loaded.axis
    if header is None:
        return StageStatus(stage.name, file, State.ABSENT, NOT_MADE, axis=axis)
    why = _why_stale(run, stage, header, before)
    return StageStatus(stage.name, file, State.STALE if why else State.FRESH, why, header, axis)


def _why_stale(run: Run, stage: Stage, header: ArtifactHeader, before: Mapping[str, StageStatus]) -> str:
    made = header.provenance
    if made.stage != stage.name or header.kind != stage.kind:
        return f"it holds what {made.stage} makes"
    if made.version != __version__:
        return f"made by version {made.version}"
    if made.interrupted:
        return "its run was interrupted"
    if stage.companion is not None and not (run.out / stage.companion.output).exists():
        return f"{stage.companion.output} is missing"
    changed = _differing(made.sections, run.sections(stage))
    if changed:
        return f"configuration changed: {', '.join(changed)}"
    return _why_inputs_differ(run, stage, header, before)


def _why_inputs_differ(run: Run, stage: Stage, header: ArtifactHeader, before: Mapping[str, StageStatus]) -> str:
    for name in run.needs(stage):
        if before[name].state is not State.FRESH:
            return f"{before[name].file.name} is {before[name].state}"
    headers = {name: found for name in run.needs(stage) if (found := before[name].header) is not None}
    try:
        now = run.inputs(stage, headers)
    except InputError as error:
        return f"{error.where} {error.what}"
    changed = _differing(header.provenance.inputs, now)
    return f"{', '.join(before[n].file.name if n in before else n for n in changed)} changed" if changed else ""


def _differing(then: Mapping[str, str], now: Mapping[str, str]) -> list[str]:
    """Names whose text is not what it was, in the order of now."""
    return [name for name in {**now, **then} if then.get(name) != now.get(name)]
