"""A configuration in its run directory: where its artifacts are, and what each of them depends on."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from robotid.artifacts.provenance import digest
from robotid.artifacts.store import ArtifactHeader
from robotid.config.axes import axes_of
from robotid.config.load import Loaded
from robotid.errors import InputError
from robotid.pipeline.stage import Product, Stage


@dataclass(frozen=True, slots=True)
class Run:
    """The configuration of one joint and its run directory, which it shares with the other axes of its robot."""

    loaded: Loaded
    out: Path
    _digests: dict[Path, str] = field(default_factory=dict)

    @property
    def axes(self) -> dict[str, Run]:
        """The run itself by the name of its axis, empty for a single joint."""
        return {self.loaded.axis: self}

    @property
    def several(self) -> bool:
        """Whether its artifacts hold several axes, be it one."""
        return bool(self.loaded.axis)

    @property
    def names(self) -> tuple[str, ...]:
        """All axes of the robot, none for a single joint."""
        return axes_of(self.loaded.robot) if self.several else ()

    def file(self, product: Product) -> Path:
        """Where a stage's artifact, or the report, is."""
        return self.out / product.output

    def command(self, stage: str) -> str:
        """What a person types to run a stage again."""
        return shlex.join([*_command(self.loaded, stage, self.out), *_axis(self.loaded), *_overrides(self.loaded)])

    def public_command(self, stage: str) -> str:
        """The same without folders, whose names may be a person's."""
        words = ["robotid", stage, self.loaded.path.name]
        return shlex.join([*words, *_axis(self.loaded), *_overrides(self.loaded)])

    def sections(self, stage: Stage) -> dict[str, str]:
        """The configuration that a stage depends on, as canonical text."""
        return {name: self.loaded.section_text(name) for name in stage.sections}

    def needs(self, stage: Stage) -> tuple[str, ...]:
        """The stages whose content a stage takes under this configuration."""
        virtual = any(r.excite is not None for r in self.loaded.config.records)
        return tuple(name for name in stage.inputs if virtual or name not in stage.for_virtual)

    def measured(self) -> dict[str, tuple[Path, ...]]:
        """Measured files by record name."""
        return {
            r.name: tuple(self.loaded.directory / f for f in r.files) for r in self.loaded.config.records if r.files
        }

    def inputs(self, stage: Stage, headers: Mapping[str, ArtifactHeader]) -> dict[str, str]:
        """Digests of all that a stage reads, by stage or file. headers : of the stages before it.

        Raises InputError where a measured file cannot be read.
        """
        found = {name: headers[name].digest for name in self.needs(stage)}
        if stage.reads_files:
            written = [(f, self.loaded.directory / f) for r in self.loaded.config.records for f in r.files]
            found |= {f"file {name}": self._digest(path) for name, path in written}
        return found

    def _digest(self, path: Path) -> str:
        """Digest of a measured file, worked out once a run."""
        if path not in self._digests:
            try:
                self._digests[path] = digest(_content(path))
            except OSError as error:
                what = f"cannot be read: {error.strerror}"
                raise InputError(what, where=str(path), hint="check `file` of the record") from error
        return self._digests[path]


@dataclass(frozen=True, slots=True)
class RobotRun:
    """The runs of all axes of a robot, by axis, in one directory."""

    axes: Mapping[str, Run]
    out: Path
    several: ClassVar[bool] = True

    @property
    def names(self) -> tuple[str, ...]:
        """All axes of the robot."""
        return tuple(self.axes)

    @property
    def loaded(self) -> Loaded:
        """The configuration of the first axis, whose file, overrides and whole text are those of all."""
        return next(iter(self.axes.values())).loaded

    def file(self, product: Product) -> Path:
        """Where a stage's artifact, or the report, is."""
        return self.out / product.output

    def command(self, stage: str) -> str:
        """What a person types to run a stage again for all axes."""
        return shlex.join([*_command(self.loaded, stage, self.out), *_overrides(self.loaded)])


Runs = Run | RobotRun
"""The run of one joint, or of all axes of a robot."""


def linear_axes(run: Runs) -> dict[str, bool]:
    """Whether each axis slides, by name; a content without an axis does not."""
    return {"": False} | {axis: joint.loaded.config.robot.linear for axis, joint in run.axes.items()}


def runs_of(axes: Mapping[str, Loaded], out: Path) -> Runs:
    """The run of a configuration. axes : of the robot by name, "" for a single joint."""
    if "" in axes:
        return Run(axes[""], out)
    digests: dict[Path, str] = {}
    return RobotRun({axis: Run(loaded, out, digests) for axis, loaded in axes.items()}, out)


def _command(loaded: Loaded, stage: str, out: Path) -> list[str]:
    elsewhere = [] if out == Path("runs") / loaded.path.stem else ["--out", str(out)]
    return ["robotid", stage, str(loaded.path), *elsewhere]


def _axis(loaded: Loaded) -> list[str]:
    return ["--axis", loaded.axis] if loaded.axis else []


def _overrides(loaded: Loaded) -> list[str]:
    return [word for override in loaded.overrides for word in ("--set", override)]


def _content(path: Path) -> bytes:
    """All bytes of a file; of a folder, names and digests of the files in it."""
    if not path.is_dir():
        return path.read_bytes()
    files = sorted(file for file in path.iterdir() if file.is_file())
    return "\n".join(f"{file.name} {digest(file.read_bytes())}" for file in files).encode()
