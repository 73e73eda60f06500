"""The Python interface for the manual: the public names of the package with their signatures and docstrings."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

import robotid
from robotid.diagnosis.results import Event, Misfit
from robotid.estimate.result import Estimate
from robotid.extension.results import Score
from robotid.interface.files import RunContents, Setup
from robotid.interface.improvement import DiagnosedFit, ExtendedFit
from robotid.interface.monitoring import WatchedFit
from support.manual.markdown import table

RETURNED = (DiagnosedFit, ExtendedFit, WatchedFit, RunContents, Setup, Estimate, Score, Misfit, Event)
"""What functions return or results hold, and nobody makes by hand."""
WIDTH = 100  # characters of a signature on one line
VERSION = "The version of the installed package, a text."


class _Plain:
    """An annotation that is shown without quotation marks."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def interface() -> str:
    """A table of all names, and a section for each: the public ones in the order of `robotid.__all__`, then the types
    of what is returned."""
    things = [(name, getattr(robotid, name)) for name in robotid.__all__]
    things += [(thing.__name__, thing) for thing in RETURNED]
    rows = [(f"[{name}](#{name.lower()})", _first_sentence(thing)) for name, thing in things if name != "__version__"]
    sections = (_section(name, thing) for name, thing in things)
    return "\n\n".join([table(("name", "what it is"), rows), *sections])


def _first_sentence(thing: Any) -> str:
    return " ".join(_text(thing).split()).partition(". ")[0].rstrip(".")


def _section(name: str, thing: Any) -> str:
    if name == "__version__":
        return f"### {name}\n\n{VERSION}"
    if inspect.isclass(thing) and issubclass(thing, BaseModel):
        return f"### {name}\n\n{_text(thing)}\n\nIts sections are those of [Configuration](configuration.md)."
    return "\n\n".join([f"### {name}", _block(name, thing), *(_members(name, thing) if inspect.isclass(thing) else ())])


def _block(name: str, thing: Any) -> str:
    return f"```text\n{_signature(name, thing)}\n\n{_text(thing)}\n```"


def _text(thing: Any) -> str:
    return (inspect.getdoc(thing) or "").strip()


def _members(name: str, cls: type) -> Iterator[str]:
    """Properties in a list, then the methods."""
    own = {key: value for key, value in vars(cls).items() if not key.startswith("_")}
    properties = [(key, value) for key, value in own.items() if isinstance(value, property)]
    if properties:
        yield "\n".join(f"- `{name}.{key}`: {' '.join(_text(value).split())}" for key, value in properties)
    for key, value in own.items():
        found = value.__func__ if isinstance(value, classmethod | staticmethod) else value
        if inspect.isfunction(found):
            yield f"#### {name}.{key}"
            yield _block(f"{name}.{key}", found)


def _signature(name: str, thing: Any) -> str:
    try:
        found = inspect.signature(thing)
    except (TypeError, ValueError):
        return f"{name}(...)"
    parts: list[str] = []
    free = False  # whether what follows is by keyword alone
    for parameter in found.parameters.values():
        free = free or parameter.kind is parameter.VAR_POSITIONAL
        if parameter.kind is parameter.KEYWORD_ONLY and not free:
            parts.append("*")
            free = True
        parts.append(str(parameter.replace(annotation=_plain(parameter.annotation))))
    given = found.return_annotation
    result = "" if given in (found.empty, "None", None) else f" -> {_plain(given)!r}"
    line = f"{name}({', '.join(parts)}){result}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"{name}(", *(f"    {part}," for part in parts), f"){result}"])


def _plain(annotation: Any) -> Any:
    return _Plain(annotation) if isinstance(annotation, str) else annotation
