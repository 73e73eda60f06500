"""The Python interface for the manual: the public names of the package with their signatures and docstrings."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

import robotid


def interface() -> str:
    """A section for every public name, in the order of `robotid.__all__`."""
    return "\n\n".join(_section(name, getattr(robotid, name)) for name in getattr(robotid, "__all__", ()))


def _section(name: str, thing: Any) -> str:
    return "\n\n".join([f"### {name}", *_parts(name, thing)])


def _parts(name: str, thing: Any) -> Iterator[str]:
    if isinstance(thing, str):
        yield "The version of the installed package." if name == "__version__" else f"`{thing!r}`"
        return
    if callable(thing):
        yield f"```\n{_signature(name, thing)}\n```"
    text = inspect.getdoc(thing)
    if text:
        yield f"```text\n{text}\n```"
    if inspect.isclass(thing):
        for member, value in vars(thing).items():
            if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                yield from _member(f"{name}.{member}", value)


def _member(name: str, value: Any) -> Iterator[str]:
    text = inspect.getdoc(value) or ""
    head = f"`{_signature(name, value)}`" if inspect.isfunction(value) else f"`{name}`"
    yield f"- {head}: {' '.join(text.split())}" if text else f"- {head}"


def _signature(name: str, thing: Any) -> str:
    try:
        return f"{name}{inspect.signature(thing)}"
    except (TypeError, ValueError):
        return f"{name}(...)"
