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
from robotid.artifacts.store import ArtifactHeader
from robotid.config.load import as_yaml
from robotid.errors import InputError
from robotid.pipeline.execute import reader, status
from robotid.pipeline.freshness import StageStatus, State
from robotid.pipeline.run import Run, Runs
from robotid.pipeline.table import REPORT, STAGES
from robotid.report.origin import Source
from robotid.report.stamp import Stamp, stamp_of

if TYPE_CHECKING:
    from robotid.report.findings import Findings

HEAD = 16_384  # characters of a page within which its stamp stands


@dataclass(frozen=True)
class Material:
    """What there is to report of. fresh : headers by axis and stage, the axis "" for a single joint; left_out :
    artifacts that are stale, and why."""

    run: Runs
    fresh: Mapping[str, Mapping[str, ArtifactHeader]]
    left_out: Mapping[str, str]

    @property
    def stages(self) -> tuple[str, ...]:
        """The stages that there is anything of, in order."""
        return tuple(name for name in STAGES if any(name in headers for headers in self.fresh.values()))

    @property
    def configuration(self) -> str:
        """The whole configuration: of a single joint with its defaults, of several axes as it is written."""
        loaded = self.run.loaded
        return as_yaml(loaded.robot) if self.run.several else loaded.resolved_text()

    @property
    def digest(self) -> str:
        """Digest of all that a page of it shows."""
        made = [
            f"{axis} {stage} {header.digest} {header.provenance.created}".lstrip()
            for axis, headers in self.fresh.items()
            for stage, header in headers.items()
        ]
        missing = [f"{file} {why}" for file, why in self.left_out.items()]
        return sha256("\n".join([__version__, self.configuration, *made, *missing]).encode())

    @cached_property
    def contents(self) -> Mapping[str, Mapping[str, Any]]:
        """Contents by axis and stage, read from their files at the first use."""
        found: dict[str, dict[str, Any]] = {axis: {} for axis in self.fresh}
        for name in self.stages:
            stage, axes = STAGES[name], [axis for axis, headers in self.fresh.items() if name in headers]
            content = reader(self.run, stage, axes)()
            for axis in axes:
                found[axis][name] = content[axis] if self.run.several else content
        return found

    @cached_property
    def findings(self) -> Mapping[str, Findings]:
        """The contents by axis as a report takes them."""
        return {axis: findings_of(self.run.axes[axis], found) for axis, found in self.contents.items()}


def findings_of(run: Run, contents: Mapping[str, Any]) -> Findings:
    """What the stages have found of one joint as a report takes it. contents : by stage."""
    from robotid.report.evidence.gather import with_evidence
    from robotid.report.findings import Findings

    config = run.loaded.config
    found = {STAGES[name].finding: content for name, content in contents.items()}
    free = config.fit.initial_states == "free"
    horizon = config.fit.fixed_horizon
    return with_evidence(Findings(config.robot.name, config.robot.linear, horizon, estimate_states=free, **found))


def gather(run: Runs) -> Material:
    """The artifacts of a run that are fresh. Raises InputError where there is none."""
    found = status(run)
    material = _fresh_of(run, found)
    if not material.fresh:
        hint = f"run `{run.command('run')}` first"
        raise InputError(f"nothing to report: {_why_nothing(found)}", where=str(run.out), hint=hint)
    return material


def _fresh_of(run: Runs, found: Sequence[StageStatus]) -> Material:
    fresh: dict[str, dict[str, ArtifactHeader]] = {axis: {} for axis in run.axes}
    for s in found:
        if s.state is State.FRESH and s.header is not None:
            fresh[s.axis][s.stage] = s.header
    stale = {f"{s.file.name}{s.axis and f' of {s.axis}'}": s.why for s in found if s.state is State.STALE}
    return Material(run, {axis: headers for axis, headers in fresh.items() if headers}, stale)


def _why_nothing(found: tuple[StageStatus, ...]) -> str:
    stale = [s for s in found if s.state is State.STALE]
    return f"{stale[0].file.name} is stale ({stale[0].why})" if stale else "no stage has run"


def page_file(run: Runs) -> Path:
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


def page_stamp(run: Runs) -> Stamp | None:
    """The stamp of the page there, None where that is another file."""
    with page_file(run).open(encoding="utf-8", errors="replace") as page:
        return stamp_of(page.read(HEAD))


def is_current(run: Runs, found: Sequence[StageStatus]) -> bool:
    """Whether the page there shows what there is."""
    return not why_made(_fresh_of(run, found))


def source_of(name: str, file: str, header: ArtifactHeader) -> Source:
    """Where an artifact comes from, as a page states it. name : of what the artifact is there."""
    made = header.provenance
    return Source(
        stage=name,
        file=file,
        command=made.command,
        version=made.version,
        created=made.created,
        digest=header.digest,
        inputs=made.inputs,
        seed=made.seed,
        environment=made.environment,
    )
