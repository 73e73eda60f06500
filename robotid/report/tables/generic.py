"""Any content as a table: what `show` prints of an artifact that has no view of its own."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any

from robotid.numerals import number
from robotid.report.tables.table import Json, Table

if TYPE_CHECKING:
    import numpy as np


def tables(content: Any) -> tuple[Table, ...]:
    """One table: a row a field, nested names dotted, arrays by shape and range."""
    return (Table("Content", ("field", "value", "unit"), tuple(_rows(content, ""))),)


def document(content: Any) -> Json:
    """Fields by name, arrays in full."""
    if is_dataclass(content):
        return {f.name: document(getattr(content, f.name)) for f in fields(content)}
    if isinstance(content, dict):
        return {str(key): document(value) for key, value in content.items()}
    if isinstance(content, tuple | list):
        return [document(value) for value in content]
    if isinstance(content, Enum):
        return str(content.value)
    plain: Json = content.tolist() if hasattr(content, "tolist") else content
    return plain


def _rows(content: Any, prefix: str, unit: str = "") -> list[tuple[str, ...]]:
    if is_dataclass(content):
        parts = [(f.name, getattr(content, f.name), str(f.metadata.get("unit", ""))) for f in fields(content)]
    elif isinstance(content, dict):
        parts = [(str(key), value, unit) for key, value in content.items()]
    elif isinstance(content, tuple) and any(is_dataclass(item) for item in content):
        parts = [(str(getattr(item, "name", i)), item, unit) for i, item in enumerate(content)]
    else:
        return [(prefix, _cell(content), unit)]
    return [row for key, value, unit in parts for row in _rows(value, f"{prefix}.{key}" if prefix else key, unit)]


def _cell(value: Any) -> str:
    if hasattr(value, "shape"):
        return _array(value)
    if isinstance(value, float):
        return number(value, 6)
    if isinstance(value, tuple | list):
        return ", ".join(map(_cell, value)) or "-"
    return "-" if value is None else str(value)


def _array(array: np.ndarray[Any, Any]) -> str:
    shape = " x ".join(map(str, array.shape)) or "1"
    if array.size == 0 or array.dtype.kind not in "fiu":
        return f"{shape} values"
    return f"{shape} values from {number(float(array.min()))} to {number(float(array.max()))}"
