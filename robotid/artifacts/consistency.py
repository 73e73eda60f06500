"""Whether the parts of a content belong together, by what its classes declare of their fields.

A field's metadata "shape" names the lengths of its array or tuple, such as ("p", "p"); of a mapping, those of each of
its values. A name means one length within a dataclass and in all that it holds; one that ends in "[]" means one length
for each key of a mapping. "lengths" of a mapping of dataclasses gives such names to what is called otherwise in these.
A field with "may_be_empty" may hold an array without elements instead. A word with "among" is a key of that field;
"keys" of a mapping of dataclasses names their field that repeats the key. What else must agree, a class states in
`contradictions()`.

No number is infinite unless its field is "unbounded", and none is so large that its square is no number any more.
Numbers with "finite" are numbers, and at least one unless the field may be empty; those with "positive" are above zero,
too. "least" and "largest" bound them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import Field, fields, is_dataclass
from typing import Any

import numpy as np

LARGEST, SMALLEST = 1e100, 1e-100
"""In SI units, far beyond what anything measures: squares and reciprocals of what is between are numbers still."""

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
        for field in fields(content):
            value, given = getattr(content, field.name), field.metadata.get("lengths")
            if given and isinstance(value, Mapping):
                others = {name: length for name, length in lengths.items() if name not in given}
                for key, part in value.items():
                    own = {name: _of_key(outer, key) for name, outer in given.items()}
                    yield from mismatches(part, others | {n: lengths[o] for n, o in own.items() if o in lengths})
            else:
                yield from mismatches(value, lengths)
        yield from getattr(content, "contradictions", tuple)()
    elif isinstance(content, (Mapping, tuple)):
        for part in content.values() if isinstance(content, Mapping) else content:
            yield from mismatches(part, lengths)


def _of_numbers(content: Any, field: Field[Any]) -> Iterator[str]:
    place = f"{type(content).__name__}.{field.name}"
    for numbers in _numbers(getattr(content, field.name)):
        wrong = _wrong(numbers, field.metadata)
        if wrong:
            yield f"{place} is {wrong}"


def _numbers(value: Any) -> Iterator[np.ndarray[Any, Any]]:
    """The numbers of a field, arrays of any shape; of a mapping those of each value."""
    if isinstance(value, Mapping):
        for part in value.values():
            yield from _numbers(part)
    elif isinstance(value, (np.ndarray, int, float, complex)) or (
        isinstance(value, tuple) and all(isinstance(part, (int, float, complex)) for part in value)
    ):
        yield np.asarray(value)


def _wrong(numbers: np.ndarray[Any, Any], metadata: Mapping[str, Any]) -> str:
    """What numbers are and must not be, empty where there is nothing of that."""
    positive, unbounded = metadata.get("positive", False), metadata.get("unbounded", False)
    finite = positive or metadata.get("finite", False)
    if not numbers.size:
        return "empty" if finite and not metadata.get("may_be_empty") else ""
    if (finite and np.isnan(numbers).any()) or (not unbounded and np.isinf(numbers).any()):
        return "not finite"
    size = np.abs(numbers[np.isfinite(numbers)])
    largest = metadata.get("largest", np.inf if unbounded else LARGEST)
    if (size > largest).any():
        return f"beyond {largest:g}"
    if positive and not (numbers > SMALLEST).all():
        return "not positive"
    least = metadata.get("least")
    return f"below {least:g}" if least is not None and (numbers < least).any() else ""


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
