"""Results of each axis of a robot as tables and JSON: what the module of a stage's tables offers for one content, here
for contents by axis. A single joint is the one axis without a name, and is shown as such."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import ModuleType
from typing import Any, TypeVar

from robotid.report.tables.sliding import in_units_of_axis, in_words_of_axis
from robotid.report.tables.table import Json, Table

T = TypeVar("T", bound=Json)


def tables(
    view: ModuleType, contents: Mapping[str, Any], linear: Mapping[str, bool], *, brief: bool = False
) -> Iterator[Table]:
    """The tables of every axis, its name before their titles, and what several have in common once. linear : the axes
    that slide. brief : what the end of a whole run shows."""
    make = getattr(view, "brief" if brief else "tables", view.tables)
    for axis, content in contents.items():
        for table in of_axis(view, content) if len(contents) > 1 and make is view.tables else make(content):
            shown = in_units_of_axis(table, linear=linear[axis])
            yield replace(shown, title=titled(axis, shown.title))
    if len(contents) > 1:
        yield from of_robot(view, next(iter(contents.values())))


def of_axis(view: ModuleType, content: Any) -> tuple[Table, ...]:
    """The tables of a stage that are of one axis alone."""
    return tuple(getattr(view, "of_axis", view.tables)(content))


def of_robot(view: ModuleType, content: Any) -> tuple[Table, ...]:
    """The tables of a stage that are the same of all axes, of the content of any of them."""
    return tuple(view.of_robot(content)) if hasattr(view, "of_robot") else ()


def titled(axis: str, title: str) -> str:
    """A title with the name of the axis, if it has one, before it."""
    return ": ".join(word for word in (axis, title) if word)


def document(documents: Mapping[str, T]) -> T | dict[str, Mapping[str, T]]:
    """One JSON document of those of all axes."""
    return documents.get("", {"axes": documents})


def sentences(view: ModuleType, contents: Mapping[str, Any], linear: Mapping[str, bool]) -> Iterator[str]:
    """What came of it in a sentence an axis, where the stage has any. linear : the axes that slide."""
    if hasattr(view, "sentence"):
        found = {axis: view.sentence(content) for axis, content in contents.items()}
        for axis, sentence in found.items():
            if sentence:
                yield titled(axis, in_words_of_axis(sentence, linear=linear[axis]))
