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


def _content(path: Path) -> bytes:
    """All bytes of a file; of a folder, names and digests of the files in it."""
    if not path.is_dir():
        return path.read_bytes()
    files = sorted(file for file in path.iterdir() if file.is_file())
    return "\n".join(f"{file.name} {digest(file.read_bytes())}" for file in files).encode()
