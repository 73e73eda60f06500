"""A configuration in its run directory: where its artifacts are, and what each of them depends on."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from robotid.artifacts.provenance import digest
from robotid.artifacts.store import ArtifactHeader
from robotid.config.load import Loaded
from robotid.errors import InputError
from robotid.pipeline.stage import Product, Stage


@dataclass(frozen=True, slots=True)
class Run:
    """A configuration and its run directory."""

    loaded: Loaded
    out: Path
    _digests: dict[Path, str] = field(default_factory=dict)

    def file(self, product: Product) -> Path:
        """Where a stage's artifact, or the report, is."""
        return self.out / product.output

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

    def inputs(self, stage: Stage, headers: Mapping[str, ArtifactHeader]) -> dict[str, str]:
        """Digests of all that a stage reads, by stage or file. headers : of the stages before it.

        Raises InputError where a measured file cannot be read.
        """
        found = {name: headers[name].digest for name in stage.inputs}
        if stage.reads_files:
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
