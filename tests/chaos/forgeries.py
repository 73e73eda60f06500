"""Artifacts with a value forged under a checksum that fits: refused in one line, or harmless to all that read them."""

from __future__ import annotations

import random
import shutil
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from support.forgery import WAYS, altered, altered_attribute, attributes, datasets, forge

from chaos.mutations import Subject, complaint
from robotid.artifacts.store import load
from robotid.errors import InputError
from robotid.pipeline.table import STAGES

EXPORTED = {
    "excitation.h5": (),
    "records.h5": ("csv",),
    "flex.h5": ("csv",),
    "model.h5": ("json", "m"),
    "extension.h5": ("json",),
}


@dataclass(frozen=True, slots=True)
class Forgery:
    """One dataset of an artifact, or one of its attributes, altered in one way."""

    artifact: str
    dataset: str
    way: str
    attribute: str = ""

    def apply(self, path: Path) -> None:
        change = (
            altered_attribute(self.dataset, self.attribute, self.way)
            if self.attribute
            else altered(self.dataset, self.way)
        )
        forge(path, change)

    def __str__(self) -> str:
        return f"{self.artifact}: {self.dataset}{'@' * bool(self.attribute)}{self.attribute}: {self.way}"


def forgeries(run: Path) -> Iterator[Forgery]:
    """All of a run directory's artifacts."""
    for stage in STAGES.values():
        path = run / stage.output
        if path.suffix == ".h5" and path.exists():
            yield from (Forgery(path.name, name, way) for name in datasets(path) for way in WAYS)
            yield from (Forgery(path.name, name, way, key) for name, key in attributes(path) for way in WAYS)


def stage_type(artifact: str) -> type:
    """What an artifact holds."""
    (found,) = (stage.type() for stage in STAGES.values() if stage.output == artifact)
    return found


def wrong_with(forgery: Forgery, config: Path, run: Path, folder: Path, commands: tuple[str, ...]) -> tuple[bool, str]:
    """Whether a forged artifact loads, and what is wrong with how commands take it, empty where nothing is. run : a
    finished run directory, which stays as it is; folder : for its forged copy; commands : of `COMMANDS`."""
    forged = folder / "forged"
    shutil.rmtree(forged, ignore_errors=True)
    shutil.copytree(run, forged)
    path = forged / forgery.artifact
    forgery.apply(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # which a command reports as a bug of its own
        try:
            load(path, stage_type(forgery.artifact))
        except InputError as error:
            return False, "" if str(error).isprintable() else f"its refusal is {str(error)!r}"
        except Exception as error:
            return False, f"loading raises {error!r}"
        for name in commands:
            for command in _commands(name, path, config, run):
                text = complaint(Subject(path, command, binary=True), path.read_bytes())
                if text:
                    return True, f"{' '.join(command[:1])} {command[-1] if name == 'export' else ''}: {text}"
    return True, ""


COMMANDS = ("show", "compare", "export", "report")


def _commands(name: str, path: Path, config: Path, run: Path) -> list[tuple[str, ...]]:
    if name == "show":
        return [("show", str(path)), ("show", str(path), "--json")]
    if name == "compare":
        return [("compare", str(run), str(path.parent), "--json"), ("compare", str(run), str(path.parent))]
    if name == "report":
        return [("report", str(config), "--out", str(path.parent), "--quiet", "--force")]
    return [("export", str(path), str(path.parent / f"to.{suffix}")) for suffix in EXPORTED.get(path.name, ())]


def drawn(run: Path, rng: random.Random) -> list[Forgery]:
    """All of them in an order drawn at random."""
    found = list(forgeries(run))
    rng.shuffle(found)
    return found
