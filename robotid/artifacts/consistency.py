"""Whether the parts of a content belong together, by what its classes declare of their fields.

A field's metadata "shape" names the lengths of its array or tuple, such as ("p", "p"); of a mapping, those of each of
its values. A name means one length within a dataclass and in all that it holds; one that ends in "[]" means one length
for each key of a mapping. "lengths" of a mapping of dataclasses gives such names to what is called otherwise in these.
A field with "may_be_empty" may hold an array without elements instead. A word with "among" is a key of that field;
"keys" of a mapping of dataclasses names their field that repeats the key. Numbers with "finite" are finite, and not
none at all; those with "positive" are above zero, too. What else must agree, a class states in `contradictions()`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import Field, fields, is_dataclass
from typing import Any

import numpy as np

Lengths = Mapping[str, tuple[int, str]]
"""What each name means so far, and the field that says so."""


def mismatches(content: Any, known: Lengths | None = None) -> Iterator[str]:
    """What does not belong together in a content, as sentences. known : lengths of what it is part of."""
    lengths = dict(known or {})
    if is_dataclass(content):
        for field in fields(content):
            if "shape" in field.metadata:
                yield from _of_field(content, field, lengths)
            yield from _of_numbers(content, field)
            if (among := field.metadata.get("among")) and getattr(content, field.name) not in getattr(content, among):
                yield f"{type(content).__name__}.{field.name} is none of its {among}"
            keys, value = field.metadata.get("keys"), getattr(content, field.name)
            if keys and any(getattr(part, keys) != key for key, part in value.items()):
                yield f"{type(content).__name__}.{field.name} holds something of another name"
        yield from getattr(content, "contradictions", tuple)()
        for field in fields(content):
            value, given = getattr(content, field.name), field.metadata.get("lengths")
            if given and isinstance(value, Mapping):
                others = {name: length for name, length in lengths.items() if name not in given}
                for key, part in value.items():
                    own = {name: _of_key(outer, key) for name, outer in given.items()}
                    yield from mismatches(part, others | {n: lengths[o] for n, o in own.items() if o in lengths})
            else:
                yield from mismatches(value, lengths)
    elif isinstance(content, (Mapping, tuple)):
        for part in content.values() if isinstance(content, Mapping) else content:
            yield from mismatches(part, lengths)


def _of_numbers(content: Any, field: Field[Any]) -> Iterator[str]:
    value, positive = getattr(content, field.name), field.metadata.get("positive", False)
    if value is None or not (positive or field.metadata.get("finite")):
        return
    place, numbers = f"{type(content).__name__}.{field.name}", np.asarray(value)
    if not numbers.size:
        yield f"{place} is empty"
    elif not np.isfinite(numbers).all():
        yield f"{place} is not finite"
    elif positive and not (numbers > 0).all():
        yield f"{place} is not positive"


def _of_key(name: str, key: str) -> str:
    return f"{name.removesuffix('[]')}[{key}]" if name.endswith("[]") else name


def _of_field(content: Any, field: Field[Any], lengths: dict[str, tuple[int, str]]) -> Iterator[str]:
    value, place = getattr(content, field.name), f"{type(content).__name__}.{field.name}"
    for key, array in value.items() if isinstance(value, Mapping) else (("", value),):
        if array is None:
            continue
        shape = (len(array),) if isinstance(array, tuple) else array.shape
        names = [_of_key(name, key) for name in field.metadata["shape"]]
        if len(shape) != len(names):
            yield f"{place} has {len(shape)} dimensions, not {len(names)}"
        elif not (field.metadata.get("may_be_empty") and 0 in shape):
            for name, length in zip(names, shape, strict=True):
                expected, source = lengths.setdefault(name, (length, place))
                if length != expected:
                    yield f"{place} has length {length}, {source} {expected}"
