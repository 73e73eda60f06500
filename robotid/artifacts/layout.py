"""The layout of a content: which fields of which types its class declares, as one digest."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, get_args, get_origin, get_type_hints

from robotid.artifacts.provenance import digest


def layout_digest(cls: type[Any]) -> str:
    """SHA-256 of the fields of a dataclass and of all dataclasses in it, by name and type.

    An artifact of another layout cannot be read; comparing digests shows that without reading its content. All arrays
    count as one type, because how their type is written depends on the version of NumPy.
    """
    return digest(repr(_described(cls, ())).encode())


def _described(hint: Any, above: tuple[Any, ...]) -> Any:
    """A type as nested tuples of names. above : the dataclasses that it stands in, for those that hold themselves."""
    if isinstance(hint, type) and is_dataclass(hint):
        if hint in above:
            return hint.__name__
        hints = get_type_hints(hint)
        inner = ((field.name, _described(hints[field.name], (*above, hint))) for field in fields(hint))
        return (hint.__name__, *inner)
    if "ndarray" in repr(hint).lower():
        return "array"
    if isinstance(hint, type) and issubclass(hint, Enum):
        return (hint.__name__, *(member.value for member in hint))
    origin = get_origin(hint)
    if origin is None:
        return getattr(hint, "__name__", repr(hint))
    return (getattr(origin, "__name__", repr(origin)), *(_described(inner, above) for inner in get_args(hint)))
