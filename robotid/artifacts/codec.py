"""Any frozen dataclass to an HDF5 group and back, driven by its type hints. Nothing is ever pickled.

Dataclasses, mappings and mixed tuples are groups; numbers, words, arrays and tuples of one kind of them are datasets;
None is a dataset without extent. Every dataset but words has an attribute `unit`, from its field's metadata: "unit"
names it ("SI" where numbers of several units share a field), "unit_in" names the field of the same dataclass that holds
it. Words that hold a NUL cannot be kept. A hint may be an alias of any kind (`Array = ...`, `type Array = ...`, generic
or not, as NumPy's own NDArray is one or the other): it stands for what it names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import Field, fields, is_dataclass
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints
from urllib.parse import quote, unquote

import h5py
import numpy as np

from robotid.signals.readers.hdf5 import require_own_values

T = TypeVar("T")
Units = Callable[[str], str]

NUMBERS: dict[type, tuple[type, ...]] = {
    bool: (bool, np.bool_),
    int: (int, np.integer),
    float: (float, int, np.floating, np.integer),
    complex: (complex, float, int, np.number),
}  # what a number may be given as
WORDS = h5py.string_dtype()
LARGE = 4096  # bytes from which an array is worth compressing


class CodecError(Exception):
    """A group does not hold what its type says, or a type is none that can be kept."""


def write(group: h5py.Group, content: Any, units: Units = str) -> None:
    """Write a dataclass into an empty group. units : what a declared unit is called here (of a sliding axis, say).

    Raises CodecError for a value that its type hint does not allow.
    """
    hints = _hints(type(content))  # type: ignore[arg-type]
    for field in fields(content):
        _write(group, field.name, getattr(content, field.name), hints[field.name], _unit(field, content, units), units)


def read(group: h5py.Group, cls: type[T]) -> T:
    """The dataclass that a group holds. Raises CodecError where the group does not fit the class."""
    hints = _hints(cls)  # type: ignore[arg-type]
    names = [field.name for field in fields(cls)]  # type: ignore[arg-type]
    missing = [name for name in names if name not in group]
    if missing:
        raise CodecError(f"{group.name} has no {missing[0]}")
    return cls(**{name: _read(_member(group, name), hints[name]) for name in names})


@cache
def _hints(cls: type[Any]) -> Mapping[str, Any]:
    """The types of a dataclass's fields, which are written as texts and evaluated once."""
    return get_type_hints(cls)


def _member(group: h5py.Group, name: str) -> h5py.Group | h5py.Dataset:
    """What a group itself holds: no link leads to another place or file."""
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise CodecError(f"{group.name}/{name} is a link")
    return group[name]


def _unit(field: Field[Any], content: Any, units: Units) -> str | tuple[str, ...]:
    if "unit_in" in field.metadata:
        unit: str | tuple[str, ...] = getattr(content, field.metadata["unit_in"])
        return unit
    return units(field.metadata.get("unit", ""))


def _write(parent: h5py.Group, name: str, value: Any, hint: Any, unit: str | tuple[str, ...], units: Units) -> None:
    kind = _alternative(hint, type(value).__name__)
    origin = get_origin(kind) or kind
    if value is None and NoneType in _options(hint):
        parent.create_dataset(name, data=h5py.Empty("f8")).attrs["unit"] = unit
    elif is_dataclass(kind) and isinstance(value, kind):  # type: ignore[arg-type]
        inner = parent.create_group(name)
        inner.attrs["class"] = type(value).__name__
        write(inner, value, units)
    elif origin in (dict, Mapping) and isinstance(value, Mapping):
        inner = parent.create_group(name, track_order=True)
        for key, item in value.items():
            _write(inner, _to_name(key), item, get_args(kind)[1], unit, units)
    elif origin is tuple and isinstance(value, tuple):
        _write_tuple(parent, name, value, kind, unit, units)
    elif origin is np.ndarray and isinstance(value, np.ndarray):
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if value.nbytes > LARGE else {}
        parent.create_dataset(name, data=value, **packed).attrs["unit"] = unit
    elif _is_word(kind) and isinstance(value, str):
        parent.create_dataset(name, data=_encodable(value), dtype=WORDS)
    elif kind in NUMBERS and isinstance(value, NUMBERS[kind]):
        parent.create_dataset(name, data=kind(value)).attrs["unit"] = unit
    else:
        raise CodecError(f"{parent.name}/{name} is a {type(value).__name__}, which {hint} does not allow")


def _encodable(text: str) -> str:
    """A text with what UTF-8 cannot write, such as a byte of a file name that is no text, written out as \\udcff."""
    return text.encode("utf-8", "backslashreplace").decode("utf-8")


def _write_tuple(
    parent: h5py.Group, name: str, value: tuple[Any, ...], kind: Any, unit: str | tuple[str, ...], units: Units
) -> None:
    one = _one_kind(kind)
    if one is not None and not all(isinstance(item, NUMBERS.get(one, str)) for item in value):
        raise CodecError(f"{parent.name}/{name} has an element that {kind} does not allow")
    if one is str:
        parent.create_dataset(name, data=np.array([_encodable(item) for item in value], dtype=object), dtype=WORDS)
    elif one is not None:
        parent.create_dataset(name, data=np.array(value, dtype=one)).attrs["unit"] = unit
    else:
        inner = parent.create_group(name)
        inner.attrs["length"] = len(value)
        for i, (item, hint) in enumerate(zip(value, _elements(kind, len(value)), strict=True)):
            _write(inner, str(i), item, hint, unit, units)


def _read(node: h5py.Group | h5py.Dataset, hint: Any) -> Any:
    if isinstance(node, h5py.Dataset) and node.shape is None and NoneType in _options(hint):
        return None
    kind = _alternative(hint, node.attrs.get("class", ""))
    origin = get_origin(kind) or kind
    if isinstance(node, h5py.Group):
        return _read_group(node, kind, origin)
    if node.shape is not None:
        words = h5py.check_string_dtype(node.dtype) is not None
        require_own_values(node)
        value = node.asstr()[()] if words else node[()]
        if node.shape == () and (_is_word(kind) if words else kind in NUMBERS and _holds(kind, node)):
            return _plain(value, kind)
        one = _one_kind(kind) if origin is tuple else None
        if (
            one is not None
            and node.shape == (len(_elements(kind, node.size)),)
            and (words if one is str else _holds(one, node))
        ):
            return tuple(one(item) for item in value)
        if origin is np.ndarray and not words and _holds(_number(kind), node):
            return np.asarray(value, dtype=_number(kind))
    raise CodecError(f"{node.name} is no {hint}")


def _holds(kind: Any, node: h5py.Dataset) -> bool:
    """Whether the numbers of a dataset are of a kind: a real one is complex, a complex one not real, a truth none."""
    truths = node.dtype.kind == "b", np.dtype(kind).kind == "b"
    return np.can_cast(node.dtype, kind, "safe") and truths[0] == truths[1]


def _number(array: Any) -> np.dtype[Any]:
    """Of what an array consists, by its type hint."""
    inner = get_args(_resolve(get_args(array)[-1]))
    found: np.dtype[Any] = np.dtype(_resolve(inner[0]))
    return found


def _plain(value: Any, kind: Any) -> Any:
    """A number or word as Python has it."""
    if get_origin(kind) is not Literal:
        return kind(value)
    if value not in get_args(kind):
        raise CodecError(f"{value!r} is none of {', '.join(map(repr, get_args(kind)))}")
    return value


def _read_group(group: h5py.Group, kind: Any, origin: Any) -> Any:
    if is_dataclass(kind):
        return read(group, kind)  # type: ignore[arg-type]
    if origin in (dict, Mapping):
        return {_to_key(name): _read(_member(group, name), get_args(kind)[1]) for name in group}
    if origin is tuple:
        count = length(group)
        if count != len(group):
            raise CodecError(f"{group.name} has {len(group)} entries, not {count}")
        return tuple(_read(_member(group, str(i)), hint) for i, hint in enumerate(_elements(kind, count)))
    raise CodecError(f"{group.name} is no {kind}")


def length(group: h5py.Group) -> int:
    """How many entries a group that is a tuple states. Raises CodecError where that is no whole number."""
    stated = group.attrs.get("length")
    if not isinstance(stated, np.integer):
        raise CodecError(f"{group.name} states no length")
    return int(stated)


def _to_name(key: str) -> str:
    """A key as HDF5 can name it: "/" parts names, "." alone is the group itself, and no name is empty."""
    return quote(key, safe=" ") if key.strip(".") else key.replace(".", "%2E") or "%"


def _to_key(name: str) -> str:
    return "" if name == "%" else unquote(name)


def _resolve(hint: Any) -> Any:
    """What a hint stands for: an alias that a `type` statement made (PEP 695) is replaced by its value."""
    alias = get_origin(hint) or hint
    if not hasattr(alias, "__type_params__") or not hasattr(alias, "__value__"):
        return hint
    value = alias.__value__
    arguments = dict(zip(alias.__type_params__, get_args(hint), strict=False))
    if isinstance(value, TypeVar) and value in arguments:
        return _resolve(arguments[value])
    parameters = getattr(value, "__parameters__", ())
    if arguments and parameters:
        value = value[tuple(arguments.get(parameter, parameter) for parameter in parameters)]
    return _resolve(value)


def _options(hint: Any) -> tuple[Any, ...]:
    """The types that a hint allows: the members of a union, or the one type that it is."""
    kind = _resolve(hint)
    if get_origin(kind) not in (Union, UnionType):
        return (kind,)
    return tuple(option for member in get_args(kind) for option in _options(member))


def _alternative(hint: Any, name: str) -> Any:
    """What a value is to be: of a union of dataclasses the one of this name."""
    options = [option for option in _options(hint) if option is not NoneType]
    if len(options) == 1:
        return options[0]
    return next(
        (option for option in options if is_dataclass(option) and getattr(option, "__name__", "") == name), hint
    )


def _is_word(kind: Any) -> bool:
    if get_origin(kind) is Literal:
        return all(isinstance(word, str) for word in get_args(kind))
    return isinstance(kind, type) and (kind is str or issubclass(kind, StrEnum))


def _elements(kind: Any, count: int) -> tuple[Any, ...]:
    """The type of each element of a tuple."""
    arguments = get_args(kind)
    return arguments[:1] * count if arguments[-1:] == (Ellipsis,) else arguments


def _one_kind(kind: Any) -> type | None:
    """The one plain type of all elements of a tuple, if it is so."""
    found = {_resolve(argument) for argument in get_args(kind) if argument is not Ellipsis}
    return found.pop() if len(found) == 1 and found <= {*NUMBERS, str} else None
