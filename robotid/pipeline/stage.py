"""What a row of the table of stages states. Imports of a row are texts, "package.module:name", resolved when needed."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Literal


@dataclass(frozen=True, slots=True)
class Companion:
    """A text file that goes with an artifact. function : makes the text of the loaded configuration, the content (of
    several axes by axis) and the run directory."""

    output: str
    function: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Product:
    """What a command of the pipeline makes, and how people see it.

    name : of the command; summary : its help, one sentence; heading : over its tables on the page of a report; output :
    file in the run directory; tables : module with `tables(content)`, `document(content)` and, where there is something
    to state, `sentence(content)`, the last line of the command, and `brief(content)`, for the end of a whole run.
    """

    name: str
    summary: str
    heading: str
    output: str
    tables: str

    def view(self) -> ModuleType:
        """The module of tables."""
        return importlib.import_module(self.tables)


@dataclass(frozen=True, slots=True, kw_only=True)
class Stage(Product):
    """A product that is an artifact, made by a pure function of the configuration and of earlier artifacts.

    function, content : the function and the class of what it returns; shared : the class of what it computes once for
    all axes of a robot, an instance of which it takes as `shared`, empty where there is nothing such; inputs : stages
    whose content the function takes, after the configuration; for_virtual : those of them that only a record that
    excites needs, None where there is none; sections : of the configuration that it reads; reads_files : it takes the
    tables of the measured files too; logs : it takes a `progress.Log`. finding : field of `report.findings.Findings`
    for the content.
    export : function of `pipeline.exports` that offers the content to other programs, empty where there is none.
    after_run : whether a whole run prints the content: never, always, or as the latest of those marked so.
    """

    function: str
    content: str
    finding: str
    shared: str = ""
    inputs: tuple[str, ...] = ()
    for_virtual: tuple[str, ...] = ()
    sections: tuple[str, ...] = ()
    reads_files: bool = False
    logs: bool = False
    export: str = ""
    after_run: Literal["never", "latest", "always"] = "never"
    companion: Companion | None = None

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


def find(path: str) -> Any:
    """What "package.module:name" names."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
