"""A layout knows the fields and types of a class and of all classes in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, make_dataclass
from enum import StrEnum
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from robotid.artifacts.layout import layout_digest


class End(StrEnum):
    """How something ended."""

    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True)
class Inner:
    value: float


@dataclass(frozen=True)
class Tree:
    branches: tuple[Tree, ...]


PLAIN: list[tuple[str, Any]] = [
    ("x", NDArray[np.float64]),
    ("inner", dict[str, Inner]),
    ("end", End),
    ("n", int | None),
]


def made(*fields: tuple[str, Any]) -> str:
    return layout_digest(make_dataclass("Content", fields))


def test_the_same_fields_have_the_same_layout() -> None:
    assert made(*PLAIN) == made(*PLAIN)


def renamed_member() -> type[StrEnum]:
    return StrEnum("End", {"DONE": "done", "BROKEN": "broken"})


@pytest.mark.parametrize(
    "change",
    [
        lambda fields: fields[:-1],
        lambda fields: [*fields, ("more", str)],
        lambda fields: [("y", fields[0][1]), *fields[1:]],
        lambda fields: [*fields[:1], ("inner", dict[str, make_dataclass("Inner", [("other", float)])]), *fields[2:]],
        lambda fields: [*fields[:1], ("inner", tuple[Inner, ...]), *fields[2:]],
        lambda fields: [*fields[:2], ("end", renamed_member()), *fields[3:]],
        lambda fields: [*fields[:2], ("end", Literal["done", "failed"]), *fields[3:]],
        lambda fields: [*fields[:3], ("n", int)],
    ],
    ids=["fewer", "more", "renamed", "inner field", "container", "member", "literal", "optional"],
)
def test_any_other_field_or_type_is_another_layout(change: Callable[[list[Any]], list[Any]]) -> None:
    assert made(*change(PLAIN)) != made(*PLAIN)


def test_literals_count() -> None:
    assert made(("kind", Literal["a", "b"])) != made(("kind", Literal["a", "c"]))


def test_a_class_may_hold_itself() -> None:
    assert layout_digest(Tree) == layout_digest(Tree)
