"""What a report is made of: the artifacts of a run that are fresh. The page itself is no artifact but a view of them,
so it may be made after any stage and shows whatever there is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robotid import __version__
from robotid.artifacts.provenance import digest as sha256
from robotid.artifacts.store import ArtifactHeader, load
from robotid.errors import InputError
from robotid.pipeline.execute import status
from robotid.pipeline.freshness import StageStatus, State
from robotid.pipeline.run import Run
from robotid.pipeline.table import REPORT, STAGES
from robotid.report.stamp import Stamp, stamp_of

if TYPE_CHECKING:
    from robotid.report.findings import Findings

HEAD = 16_384  # characters of a page within which its stamp stands


@dataclass(frozen=True)
class Material:
    """What there is to report of. fresh : headers by stage; left_out : artifacts that are stale, and why."""

    run: Run
    fresh: Mapping[str, ArtifactHeader]
    left_out: Mapping[str, str]

    @property
    def digest(self) -> str:
        """Digest of all that a page of it shows."""
        made = [f"{stage} {header.digest} {header.provenance.created}" for stage, header in self.fresh.items()]
        missing = [f"{file} {why}" for file, why in self.left_out.items()]
        return sha256("\n".join([__version__, self.run.loaded.resolved_text(), *made, *missing]).encode())

    @cached_property
    def contents(self) -> Mapping[str, Any]:
        """Contents by stage, read from their files at the first use."""
        return {name: load(self.run.file(STAGES[name]), STAGES[name].type()).content for name in self.fresh}

    @cached_property
    def findings(self) -> Findings:
        """The contents as a report takes them."""
        from robotid.report.findings import Findings

        config = self.run.loaded.config
        found = {STAGES[name].finding: content for name, content in self.contents.items()}
        return Findings(config.robot.name, config.robot.linear, config.fit.fixed_horizon, **found)


def gather(run: Run) -> Material:
    """The artifacts of a run that are fresh. Raises InputError where there is none."""
    found = status(run)
    material = _fresh_of(run, found)
    if not material.fresh:
        hint = f"run `{run.command('run')}` first"
        raise InputError(f"nothing to report: {_why_nothing(found)}", where=str(run.out), hint=hint)
    return material


def _fresh_of(run: Run, found: Sequence[StageStatus]) -> Material:
    fresh = {s.stage: s.header for s in found if s.state is State.FRESH and s.header is not None}
    return Material(run, fresh, {s.file.name: s.why for s in found if s.state is State.STALE})


def _why_nothing(found: tuple[StageStatus, ...]) -> str:
    stale = [s for s in found if s.state is State.STALE]
    return f"{stale[0].file.name} is stale ({stale[0].why})" if stale else "no stage has run"


def page_file(run: Run) -> Path:
    """Where the page is."""
    return run.file(REPORT)


def why_made(material: Material) -> str:
    """Why a page has to be made, empty where the one there shows just this."""
    if not page_file(material.run).is_file():
        return "not made yet"
    stamp = page_stamp(material.run)
    if stamp is None:
        return "it is not a report of this program"
    return "" if stamp.digest == material.digest else "what it shows has changed"


def page_stamp(run: Run) -> Stamp | None:
    """The stamp of the page there, None where that is another file."""
    with page_file(run).open(encoding="utf-8", errors="replace") as page:
        return stamp_of(page.read(HEAD))


def is_current(run: Run, found: Sequence[StageStatus]) -> bool:
    """Whether the page there shows what there is."""
    return not why_made(_fresh_of(run, found))
