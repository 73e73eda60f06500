"""What a report is made of: the artifacts of a run that are fresh. The page itself is no artifact but a view of them,
so it may be made after any stage and shows whatever there is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from robotid import __version__
from robotid.artifacts.provenance import digest
from robotid.artifacts.store import Label, load
from robotid.errors import InputError
from robotid.pipeline.execute import status
from robotid.pipeline.freshness import StageStatus, State
from robotid.pipeline.stage import Run
from robotid.pipeline.table import STAGES
from robotid.report.findings import Findings
from robotid.report.stamp import stamp_of

PAGE = "report.html"
FIELDS = {
    "excite": "excitation",
    "collect": "recordings",
    "init-rigid": "rigid",
    "init-flex": "flex",
    "fit": "fits",
    "validate": "validation",
    "diagnose": "diagnosis",
    "extend": "extension",
}
"""What the content of each stage is called among the findings."""


@dataclass(frozen=True, slots=True)
class Material:
    """What there is to report of. fresh, contents : labels and contents by stage; left_out : artifacts that are stale,
    and why."""

    run: Run
    fresh: Mapping[str, Label]
    contents: Mapping[str, Any]
    left_out: Mapping[str, str]

    @property
    def stamp(self) -> str:
        """Digest of all that a page of it shows."""
        made = [f"{stage} {label.digest} {label.provenance.created}" for stage, label in self.fresh.items()]
        missing = [f"{file} {why}" for file, why in self.left_out.items()]
        return digest("\n".join([__version__, self.run.loaded.resolved_text(), *made, *missing]).encode())

    def findings(self) -> Findings:
        """The contents as a report takes them."""
        config = self.run.loaded.config
        found = {FIELDS[name]: content for name, content in self.contents.items()}
        return Findings(config.robot.name, config.robot.linear, config.fit.horizon, **found)


def gather(run: Run) -> Material:
    """The artifacts of a run that are fresh. Raises InputError where there is none, or one is damaged."""
    found = status(run)
    material = _labels(run, found)
    if not material.fresh:
        hint = f"run `{run.command('run')}` first"
        raise InputError(f"nothing to report: {_nothing(found)}", where=str(run.out), hint=hint)
    contents = {name: load(run.file(STAGES[name]), STAGES[name].type()).content for name in material.fresh}
    return replace(material, contents=contents)


def _labels(run: Run, found: Sequence[StageStatus]) -> Material:
    """What a page would be made of, without the contents."""
    fresh = {s.stage: s.label for s in found if s.state is State.FRESH and s.label is not None}
    return Material(run, fresh, {}, {s.file.name: s.why for s in found if s.state is State.STALE})


def _nothing(found: tuple[StageStatus, ...]) -> str:
    stale = [s for s in found if s.state is State.STALE]
    return f"{stale[0].file.name} is stale ({stale[0].why})" if stale else "no stage has run"


def page_file(run: Run) -> Path:
    """Where the page is."""
    return run.out / PAGE


def why_made(material: Material) -> str:
    """Why a page has to be made, empty where the one there is shows just this."""
    file = page_file(material.run)
    if not file.is_file():
        return "not made yet"
    stamp = stamp_of(file.read_text(encoding="utf-8", errors="replace"))
    if stamp is None:
        return "it is no report of ours"
    return "" if stamp == material.stamp else "what it shows has changed"


def is_current(run: Run, found: Sequence[StageStatus]) -> bool:
    """Whether the page there is shows what there is."""
    return not why_made(_labels(run, found))
