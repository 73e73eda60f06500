"""Any frozen dataclass to an HDF5 group and back, driven by its type hints. Nothing is ever pickled.

Numbers and arrays become datasets with an attribute `unit`, from the field's metadata; dataclasses, tuples and mappings
become groups. None becomes an empty group marked as such.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import h5py
import numpy as np

T = TypeVar("T")
Units = Callable[[str], str]

LARGE = 4096  # bytes from which an array is worth compressing


class CodecError(Exception):
    """A group does not hold what its type says."""


def write(group: h5py.Group, content: Any, units: Units = str) -> None:
    """Write a dataclass into an empty group. units : what a declared unit is called here (of a sliding axis, say)."""
    hints = get_type_hints(type(content))
    for field in fields(content):
        unit = units(field.metadata.get("unit", ""))
        _write(group, field.name, getattr(content, field.name), hints[field.name], unit, units)


def read(group: h5py.Group, cls: type[T]) -> T:
    """The dataclass that a group holds. Raises CodecError where the group does not fit the class."""
    hints = get_type_hints(cls)
    values = {}
    for field in fields(cls):  # type: ignore[arg-type]
        if field.name not in group:
            raise CodecError(f"{group.name} has no {field.name}")
        values[field.name] = _read(group[field.name], hints[field.name])
    return cls(**values)


def _write(group: h5py.Group, name: str, value: Any, hint: Any, unit: str, units: Units) -> None:
    if value is None:
        group.create_group(name).attrs["none"] = True
    elif is_dataclass(value):
        inner = group.create_group(name)
        inner.attrs["class"] = type(value).__name__
        write(inner, value, units)
    elif isinstance(value, Mapping):
        inner = group.create_group(name)
        kind = _arguments(hint)[1]
        inner.attrs["keys"] = np.array([str(k) for k in value], dtype=h5py.string_dtype())
        for i, item in enumerate(value.values()):
            _write(inner, str(i), item, kind, unit, units)
    elif isinstance(value, tuple):
        inner = group.create_group(name)
        inner.attrs["length"] = len(value)
        for i, item in enumerate(value):
            _write(inner, str(i), item, _element(hint, i), unit, units)
    elif isinstance(value, (str, Enum)):
        group.create_dataset(name, data=str(value.value if isinstance(value, Enum) else value), dtype=h5py.string_dtype())
    elif isinstance(value, np.ndarray):
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if value.nbytes > LARGE else {}
        group.create_dataset(name, data=value, **packed).attrs["unit"] = unit
    else:
        group.create_dataset(name, data=value).attrs["unit"] = unit


def _read(node: h5py.Group | h5py.Dataset, hint: Any) -> Any:
    if isinstance(node, h5py.Group) and node.attrs.get("none", False):
        return None
    hint = _resolve(node, hint)
    origin = get_origin(hint) or hint
    if is_dataclass(origin):
        return read(node, origin)  # type: ignore[type-var]
    if origin in (dict, Mapping):
        keys = [k if isinstance(k, str) else k.decode() for k in node.attrs["keys"]]
        return {key: _read(node[str(i)], _arguments(hint)[1]) for i, key in enumerate(keys)}
    if origin is tuple:
        return tuple(_read(node[str(i)], _element(hint, i)) for i in range(int(node.attrs["length"])))
    if origin is np.ndarray:
        return node[()]
    if origin is Literal:
        return _literal(node[()], get_args(hint))
    value = node[()]
    return origin(value.decode() if isinstance(value, bytes) else value)


def _literal(value: Any, allowed: tuple[Any, ...]) -> Any:
    text = value.decode() if isinstance(value, bytes) else value
    for one in allowed:
        if one == text:
            return one
    raise CodecError(f"{text!r} is none of {', '.join(map(repr, allowed))}")


def _resolve(node: h5py.Group | h5py.Dataset, hint: Any) -> Any:
    """One alternative of a union: of several dataclasses the one whose name was written."""
    if get_origin(hint) not in (Union, types.UnionType):
        return hint
    options = [o for o in get_args(hint) if o is not type(None)]
    name = node.attrs.get("class", "")
    return next((o for o in options if getattr(o, "__name__", "") == name), options[0])


def _arguments(hint: Any) -> tuple[Any, ...]:
    if get_origin(hint) in (Union, types.UnionType):
        hint = next(o for o in get_args(hint) if o is not type(None))
    return get_args(hint)


def _element(hint: Any, i: int) -> Any:
    arguments = _arguments(hint)
    return arguments[0] if len(arguments) == 2 and arguments[1] is Ellipsis else arguments[i]
