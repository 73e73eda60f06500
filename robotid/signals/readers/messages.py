"""Messages by topic as columns: what ROS 2 bags and MCAP files have in common.

A field is called /topic.field, one of a nested message /topic.field.inner, an entry of an array /topic.field[0]. Where
a message names its entries, as JointState does, they go by these names: /joint_states.elbow.position.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robotid.errors import InputError
from robotid.signals.readers.table import Table, floats

NAMES = ("name", "names", "joint_names")  # fields that name the entries of the arrays beside them
MOST_ENTRIES = 64  # of an array; a longer one is an image or a cloud of points


@dataclass(frozen=True, slots=True)
class Message:
    """time : when it was logged, in ns; content : a dict or an object with fields."""

    topic: str
    time: int
    content: Any


@dataclass(slots=True)
class _Topic:
    """Time stamps of the messages in ns, as logged and as their headers say, and values and message numbers by name."""

    logged: list[int] = field(default_factory=list)
    stamped: list[int] = field(default_factory=list)
    values: dict[str, list[float]] = field(default_factory=dict)
    at: dict[str, list[int]] = field(default_factory=dict)


def from_messages(path: str, messages: Iterable[Message]) -> Table:
    """Columns of all topics; /topic.t are time stamps [s] from the first message of the file.

    They are those of the headers where all messages of a topic bear one, else when it was logged. A field that only
    some messages hold has time stamps of its own. Raises InputError where no message holds a number.
    """
    topics: dict[str, _Topic] = {}
    for message in messages:
        _add(topics.setdefault(message.topic, _Topic()), message)
    columns: dict[str, Any] = {}
    clocks: dict[str, str] = {}
    zero = min((topic.logged[0] for topic in topics.values()), default=0)
    for name, topic in topics.items():
        stamps = np.array(topic.stamped if all(topic.stamped) else topic.logged, dtype=np.int64)
        for part, at in topic.at.items():
            full = f"{name}.{part}"
            clocks[full] = f"{name}.t" if len(at) == len(stamps) else f"{full}.t"
            columns.setdefault(clocks[full], (stamps[at] - zero) * 1e-9)
            columns[full] = floats(np.array(topic.values[part]))
    if not columns:
        raise InputError("its messages hold no numbers", where=path, hint="record topics with torque and angle")
    times = set(clocks.values())
    return Table(path, columns, dict.fromkeys(times, "s"), clocks=clocks | {time: time for time in times})


def _add(topic: _Topic, message: Message) -> None:
    topic.logged.append(message.time)
    content = _fields(message.content)
    topic.stamped.append(_stamp(content))
    for name, value in _numbers("", {key: item for key, item in content.items() if key != "header"}):
        topic.values.setdefault(name, []).append(value)
        topic.at.setdefault(name, []).append(len(topic.logged) - 1)


def _fields(content: Any) -> Mapping[str, Any]:
    """Fields of a message by name: of a dict, or of an object with slots or without."""
    if isinstance(content, Mapping):
        return content
    names = getattr(content, "__slots__", None) or vars(content)
    return {name: getattr(content, name) for name in names if not name.startswith("__")}


def _stamp(content: Mapping[str, Any]) -> int:
    """What its header says in ns, 0 where it has none."""
    try:
        stamp = _fields(_fields(content["header"])["stamp"])
        return int(stamp["sec"]) * 1_000_000_000 + int(stamp["nanosec" if "nanosec" in stamp else "nsec"])
    except (KeyError, TypeError, ValueError):
        return 0


def _numbers(prefix: str, value: Any) -> Iterator[tuple[str, float]]:
    """Names and values of all numbers inside a value."""
    if isinstance(value, bool | int | float | np.number):
        yield prefix, value  # type: ignore[misc]  # integers stay integers: nanoseconds are exact
    elif isinstance(value, Mapping) or hasattr(value, "__dict__"):
        yield from _of_fields(f"{prefix}." if prefix else "", _fields(value))
    elif _is_array(value) and len(value) <= MOST_ENTRIES:
        for i, item in enumerate(value):
            yield from _numbers(f"{prefix}[{i}]", item)


def _of_fields(prefix: str, fields: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    entries = next((list(fields[key]) for key in NAMES if key in fields and _is_names(fields[key])), [])
    for key, value in fields.items():
        if entries and _is_array(value) and len(value) == len(entries):
            for entry, item in zip(entries, value, strict=True):
                yield from _numbers(f"{prefix}{entry}.{key}", item)
        else:
            yield from _numbers(prefix + key, value)


def _is_array(value: Any) -> bool:
    return isinstance(value, Sequence | np.ndarray) and not isinstance(value, str | bytes | bytearray | memoryview)


def _is_names(value: Any) -> bool:
    return _is_array(value) and len(value) > 0 and all(isinstance(item, str) for item in value)
