"""What a stage is, and what it reads: the run of a configuration in its directory."""

from __future__ import annotations

import importlib
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robotid.artifacts.provenance import digest
from robotid.artifacts.store import Label
from robotid.config.load import Loaded
from robotid.errors import InputError


@dataclass(frozen=True, slots=True)
class Stage:
    """One row of the table of stages.

    inputs : stages whose content the function takes, after the configuration; sections : of the configuration that it
    reads; function, content : where it and the class of its content are, imported when needed; files : it takes the
    tables of the measured files too; logs : it takes a `progress.Log`; beside : a text file that goes with the
    artifact, and the function that makes it of the configuration, the content and the folder.
    """

    name: str
    output: str
    function: str
    content: str
    inputs: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    files: bool = False
    logs: bool = False
    beside: tuple[str, str] | None = None

    @property
    def kind(self) -> str:
        """Name of the class of the content, known without importing it."""
        return self.content.partition(":")[2]

    def type(self) -> type[Any]:
        """Class of the content."""
        kind: type[Any] = find(self.content)
        return kind

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Content made of the configuration and the inputs' contents. Raises what the stage raises."""
        return find(self.function)(*arguments, **options)


@dataclass(frozen=True, slots=True)
class Run:
    """A configuration and its run directory."""

    loaded: Loaded
    out: Path
    _digests: dict[Path, str] = field(default_factory=dict)

    def file(self, stage: Stage) -> Path:
        """Where a stage's artifact is."""
        return self.out / stage.output

    def command(self, stage: str) -> str:
        """What a person types to run a stage again."""
        elsewhere = [] if self.out == Path("runs") / self.loaded.path.stem else ["--out", str(self.out)]
        return shlex.join(["robotid", stage, str(self.loaded.path), *elsewhere, *self._overrides()])

    def public_command(self, stage: str) -> str:
        """The same without folders, whose names may be a person's."""
        return shlex.join(["robotid", stage, self.loaded.path.name, *self._overrides()])

    def _overrides(self) -> list[str]:
        return [word for override in self.loaded.overrides for word in ("--set", override)]

    def sections(self, stage: Stage) -> dict[str, str]:
        """The configuration that a stage depends on, as canonical text."""
        return {name: self.loaded.section_text(name) for name in stage.sections}

    def measured(self) -> dict[str, Path]:
        """Measured files by record name."""
        return {r.name: self.loaded.directory / r.file for r in self.loaded.config.records if r.file is not None}

    def inputs(self, stage: Stage, labels: Mapping[str, Label]) -> dict[str, str]:
        """Digests of all that a stage reads, by stage or file. labels : of the stages before it.

        Raises InputError where a measured file cannot be read.
        """
        found = {name: labels[name].digest for name in stage.inputs}
        if stage.files:
            written = {r.name: f"file {r.file}" for r in self.loaded.config.records}
            found |= {written[record]: self._digest(path) for record, path in self.measured().items()}
        return found

    def _digest(self, path: Path) -> str:
        """Digest of a measured file, worked out once a run."""
        if path not in self._digests:
            try:
                self._digests[path] = digest(path.read_bytes())
            except OSError as error:
                what = f"cannot be read: {error.strerror}"
                raise InputError(what, where=str(path), hint="check `file` of the record") from error
        return self._digests[path]


def find(path: str) -> Any:
    """What "package.module:name" names."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
