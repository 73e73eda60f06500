"""The command example: a configuration that is shipped with the package, and its data, as files of one's own."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from robotid.cli.console import print_json, print_message, print_tables
from robotid.config.suggest import suggest
from robotid.errors import ConfigError, InputError
from robotid.report.tables.table import Table

PACKAGE = Path(__file__).resolve().parents[1]
SHIPPED = PACKAGE / "examples"
"""Where the wheel puts configs/ and data/; a checkout has them beside the package."""
NAMES = ("demo", "hidden", "motor", "smoke", "paper", "puzzle", "two_axes")
FILE = re.compile(r"(?<=file: )\.\./(data/[\w.-]+)")
"""A data file as the configurations name it, relative to their own folder."""


@dataclass(frozen=True)
class Example:
    """A shipped configuration. path : of the YAML file; its data files are named relative to it."""

    path: Path

    @property
    def name(self) -> str:
        """The name that the command line takes."""
        return self.path.stem

    @cached_property
    def text(self) -> str:
        """The configuration as it is shipped. Raises InputError where the installation lacks it."""
        if not self.path.is_file():
            raise InputError("the installation lacks this file", where=str(self.path), hint="install robotid again")
        return self.path.read_text(encoding="utf-8")

    @property
    def summary(self) -> str:
        """The first sentence of the comment that opens the configuration."""
        lines = [line.removeprefix("#").strip() for line in self.text.split("\nrobot:")[0].splitlines()]
        return re.split(r"(?<=[^.]\.)\s", " ".join(lines))[0]

    def files(self) -> Mapping[str, bytes]:
        """Contents by path inside the folder that is written: NAME.yaml, and data/ beside it. Raises InputError."""
        found = {f"{self.name}.yaml": FILE.sub(r"\1", self.text).encode()}
        for relative in dict.fromkeys(FILE.findall(self.text)):
            source = self.path.parents[1] / relative
            if not source.is_file():
                raise InputError("the installation lacks this file", where=str(source), hint="install robotid again")
            found[relative] = source.read_bytes()
        return found


def examples() -> Sequence[Example]:
    """All shipped examples, the one to begin with first."""
    root = SHIPPED if SHIPPED.is_dir() else PACKAGE.parent
    return tuple(Example(root / "configs" / f"{name}.yaml") for name in NAMES)


def list_examples(*, as_json: bool = False) -> None:
    """Print every example in a line."""
    if as_json:
        print_json({one.name: {"summary": one.summary, "files": sorted(one.files())} for one in examples()})
        return
    rows = tuple((one.name, ", ".join(sorted(one.files())), one.summary) for one in examples())
    print_tables([Table("Examples", ("name", "files", "what it is"), rows, "`robotid example NAME` writes one")])


def write_example(name: str, folder: Path | None) -> None:
    """Write an example into a new folder, by default ./NAME: all of its files or none.

    Raises ConfigError where there is no such example or the folder exists, InputError where it cannot be written.
    """
    known = {one.name: one for one in examples()}
    if name not in known:
        hint = suggest(name, known, many=0) or f"there are {', '.join(known)}"
        raise ConfigError(f'there is no example "{name}"', where="example", hint=hint)
    target = Path(name) if folder is None else folder
    if target.exists() or target.is_symlink():
        raise ConfigError(
            "this folder or file exists", where=str(target), hint=f"name a new folder: `robotid example {name} FOLDER`"
        )
    files = known[name].files()
    try:
        _write_folder(target, files)
    except OSError as error:
        why, hint = f"it cannot be written ({error.strerror or error})", "check its folder and the space left"
        raise InputError(why, where=str(target), hint=hint) from error
    for path in files:
        print(target / path)
    print_message(f"next: robotid run {target / name}.yaml")


def _write_folder(target: Path, files: Mapping[str, bytes]) -> None:
    """Write files into a temporary folder beside the target, then rename it."""
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
    try:
        for path, content in files.items():
            (draft / path).parent.mkdir(exist_ok=True)
            (draft / path).write_bytes(content)
        umask = os.umask(0)
        os.umask(umask)
        draft.chmod(0o777 & ~umask)
        draft.rename(target)
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise
