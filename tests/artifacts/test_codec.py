"""Any frozen dataclass survives the way to HDF5 and back, and what could not is refused when it is written."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, make_dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, TypeVar

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from support.alike import alike
from typing_extensions import TypeAliasType

from robotid.artifacts.codec import CodecError, read, write
from robotid.model.array import Array, Mask
from robotid.model.units import sliding


class Colour(StrEnum):
    RED = "a warm one"
    BLUE = "a cold one"


@dataclass(frozen=True, slots=True)
class Point:
    x: float = field(metadata={"unit": "rad"})
    label: str = ""


@dataclass(frozen=True, slots=True)
class Line:
    ends: tuple[Point, Point]


@dataclass(frozen=True, slots=True)
class Drawing:
    shapes: tuple[Point | Line, ...] = ()
    title: Point | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    torque: Array = field(metadata={"unit": "Nm"})
    inertia: float = field(metadata={"unit": "kg m2"})
    missing: float | None = field(metadata={"unit": "rad/s"})
    limits: tuple[float, float] = field(metadata={"unit": "rad"})
    by_record: dict[str, float] = field(metadata={"unit": "%"})
    value: float = field(metadata={"unit_in": "unit"})
    unit: str
    values: Array = field(metadata={"unit_in": "units"})
    units: tuple[str, ...]
    count: int


MEASURED = Measured(np.arange(3.0), 1.0, None, (0.0, 1.0), {"set1": 1.0}, 2.0, "Nm/rad", np.ones(2), ("Nm", "kg m2"), 3)


@pytest.fixture
def group() -> Iterator[h5py.Group]:
    with memory() as file:
        yield file.create_group("content")


def memory() -> h5py.File:
    return h5py.File("memory", "w", driver="core", backing_store=False)


def there_and_back(content: Any) -> Any:
    with memory() as file:
        write(file.create_group("content"), content)
        return read(file["content"], type(content))


WORDS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=5)
SIGNALS = arrays(np.float64, array_shapes(min_dims=0, max_dims=3, max_side=4), elements=st.floats())
POINTS = st.builds(Point, st.floats(), WORDS)
LEAVES: list[tuple[Any, st.SearchStrategy[Any]]] = [
    (float, st.floats()),
    (int, st.integers(-(2**63), 2**63 - 1)),
    (bool, st.booleans()),
    (complex, st.complex_numbers()),
    (str, WORDS),
    (Colour, st.sampled_from(Colour)),
    (Literal["speed", "position"], st.sampled_from(["speed", "position"])),
    (Array, SIGNALS),
    (Mask, arrays(np.bool_, 3)),
    (Point, POINTS),
    (Point | Line, POINTS | st.builds(Line, st.tuples(POINTS, POINTS))),
]


S = TypeVar("S", bound=np.generic)
V = TypeVar("V")
W = TypeVar("W")
# `type` statements, as Python 3.12 has them and as NumPy 2.5 declares NDArray.
Signal = TypeAliasType("Signal", np.ndarray[tuple[Any, ...], np.dtype[S]], type_params=(S,))
Speed = TypeAliasType("Speed", Signal[np.float64])
Mode = TypeAliasType("Mode", Literal["speed", "position"])
Ratio = TypeAliasType("Ratio", float)
Perhaps = TypeAliasType("Perhaps", V | None, type_params=(V,))
Swapped = TypeAliasType("Swapped", tuple[W, V], type_params=(V, W))
Same = TypeAliasType("Same", V, type_params=(V,))
Figure = TypeAliasType("Figure", Point | Line)

ALIASES: list[tuple[Any, Any]] = [
    (Signal[np.float64], np.arange(3.0)),
    (Signal[np.float64] | None, None),
    (Signal[np.float64] | None, np.arange(3.0)),
    (tuple[Signal[np.float64], ...], (np.zeros(2), np.ones(3))),
    (dict[str, Signal[np.bool_]], {"a": np.array([True, False])}),
    (Speed, np.arange(3.0)),
    (Speed | None, np.arange(3.0)),
    (Mode, "speed"),
    (Ratio, 0.5),
    (tuple[Ratio, ...], (0.5, 1.5)),
    (Perhaps[float], None),
    (Perhaps[Speed], np.arange(3.0)),
    (Perhaps[Figure], Line((Point(0.0), Point(1.0)))),
    (Swapped[int, str], ("a", 1)),
    (Same[Ratio], 0.5),
    (Figure | None, Point(1.0)),
]


def grown(kind: tuple[Any, st.SearchStrategy[Any]]) -> st.SearchStrategy[tuple[Any, st.SearchStrategy[Any]]]:
    hint, values = kind
    return st.sampled_from(
        [
            (hint | None, st.none() | values),
            (tuple[hint, ...], st.lists(values, max_size=3).map(tuple)),
            (tuple[hint, int], st.tuples(values, st.integers(0, 9))),
            (dict[str, hint], st.dictionaries(st.text(max_size=4), values, max_size=3)),
        ]
    )


KINDS = st.recursive(st.sampled_from(LEAVES), lambda kinds: kinds.flatmap(grown), max_leaves=3)


@st.composite
def contents(draw: st.DrawFn) -> Any:
    """An instance of a class that nobody has seen before."""
    kinds = draw(st.lists(KINDS, min_size=1, max_size=4))
    cls = make_dataclass("Content", [(f"field{i}", hint) for i, (hint, _) in enumerate(kinds)], frozen=True, slots=True)
    return cls(*(draw(values) for _, values in kinds))


@given(contents())
def test_there_and_back(content: Any) -> None:
    assert alike(there_and_back(content), content)


@pytest.mark.parametrize(("hint", "value"), ALIASES, ids=lambda case: str(case).replace("\n", " "))
def test_an_alias_stands_for_what_it_names(hint: Any, value: Any) -> None:
    content = make_dataclass("Content", [("field", hint)], frozen=True)(value)
    assert alike(there_and_back(content), content)


@pytest.mark.parametrize("key", ["", ".", "..", "a/b", "gear.spring.k1", "%", "%2F", "50 %", "naïve", "/", "a\0b"])
def test_any_word_is_a_key(key: str) -> None:
    Keyed = make_dataclass("Keyed", [("by", dict[str, int])], frozen=True)
    assert there_and_back(Keyed({"z": 1, key: 2, "a": 3})).by == {"z": 1, key: 2, "a": 3}


def test_keys_keep_their_order_and_can_be_read_by_people(group: h5py.Group) -> None:
    Keyed = make_dataclass("Keyed", [("by", dict[str, int])], frozen=True)
    write(group, Keyed({"gear.spring.k1": 1, "arm.inertia.J": 2}))
    assert list(group["by"]) == ["gear.spring.k1", "arm.inertia.J"]


def test_a_union_of_classes_is_told_by_name() -> None:
    drawing = Drawing((Point(1.0), Line((Point(2.0), Point(3.0)))), Point(4.0, "here"))
    assert there_and_back(drawing) == drawing


def test_numpy_numbers_become_pythons() -> None:
    Numbers = make_dataclass("Numbers", [("a", float), ("b", int), ("c", bool), ("d", tuple[float, ...])], frozen=True)
    back = there_and_back(Numbers(np.float64(1.5), np.int64(2), np.bool_(True), (np.float64(1.0), 2)))
    assert [type(value) for value in (back.a, back.b, back.c, *back.d)] == [float, int, bool, float, float]


def units(group: h5py.Group) -> dict[str, Any]:
    """Unit of every dataset that holds no words."""
    found: dict[str, Any] = {}

    def look(name: str, node: h5py.Group | h5py.Dataset) -> None:
        if isinstance(node, h5py.Dataset) and not h5py.check_string_dtype(node.dtype):
            unit = node.attrs["unit"]
            found[name] = unit if isinstance(unit, str) else list(unit)

    group.visititems(look)
    return found


def test_every_number_has_its_unit(group: h5py.Group) -> None:
    write(group, MEASURED)
    assert units(group) == {
        "torque": "Nm",
        "inertia": "kg m2",
        "missing": "rad/s",
        "limits": "rad",
        "by_record/set1": "%",
        "value": "Nm/rad",
        "values": ["Nm", "kg m2"],
        "count": "",
    }


def test_a_sliding_axis_has_other_units(group: h5py.Group) -> None:
    write(group, MEASURED, sliding)
    found = units(group)
    assert [found[name] for name in ("torque", "inertia", "missing", "limits")] == ["N", "kg", "m/s", "m"]
    assert found["value"] == "Nm/rad", "what the content says itself is right already"


def test_long_signals_are_packed_and_short_ones_are_not(group: h5py.Group) -> None:
    Signals = make_dataclass("Signals", [("long", Array), ("short", Array)], frozen=True)
    write(group, Signals(np.zeros(10_000), np.zeros(10)))
    assert group["long"].compression == "gzip"
    assert group["long"].id.get_storage_size() < 1000
    assert group["short"].compression is None


@pytest.mark.parametrize(
    ("hint", "value"),
    [
        (float, "1"),
        (float, None),
        (int, 1.5),
        (bool, 1),
        (str, 1),
        (Array, [1.0]),
        (Signal[np.float64], [1.0]),
        (Swapped[int, str], (1, "a")),
        (Mode, 1),
        (tuple[float, ...], [1.0]),
        (tuple[int, ...], (1, 2.5)),
        (dict[str, int], {"a": "b"}),
        (Point, Line((Point(0.0), Point(0.0)))),
        (int | str, 1),
        (object, 1),
    ],
)
def test_what_could_not_be_read_back_is_not_written(hint: Any, value: Any, group: h5py.Group) -> None:
    Content = make_dataclass("Content", [("field", hint)], frozen=True)
    with pytest.raises(CodecError, match="does not allow"):
        write(group, Content(value))


@pytest.mark.parametrize(
    ("written", "hint"),
    [
        ((float, 1.0), str),
        ((str, "a"), float),
        ((str, "sped"), Literal["speed", "position"]),
        ((Array, np.zeros(2)), float),
        ((Signal[np.float64], np.zeros(2)), Ratio),
        ((Ratio, 1.0), Mode),
        ((Array, np.zeros(2)), tuple[Array, Array]),
        ((float | None, None), float),
        ((Point, Point(0.0)), float),
        ((dict[str, int], {"a": 1}), int),
        ((tuple[str, ...], ("a",)), tuple[float, ...]),
    ],
)
def test_another_type_is_not_read(written: tuple[Any, Any], hint: Any, group: h5py.Group) -> None:
    write(group, make_dataclass("Content", [("field", written[0])], frozen=True)(written[1]))
    with pytest.raises(CodecError):
        read(group, make_dataclass("Content", [("field", hint)], frozen=True))


def test_a_field_that_is_not_there(group: h5py.Group) -> None:
    with pytest.raises(CodecError, match="/content has no x"):
        read(group, Point)


def test_a_name_that_is_no_text_is_written_out(tmp_path: Path) -> None:
    """Bytes of a file name that are not UTF-8 reach an artifact by its configuration's name."""
    with h5py.File(tmp_path / "a.h5", "w") as file:
        write(file, Point(1.0, "c\udcff.yaml"))
    with h5py.File(tmp_path / "a.h5") as file:
        assert read(file, Point) == Point(1.0, "c\\udcff.yaml")
