"""Arrays of formulae: what numpy's functions make of them is formulae again."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from robotid.export.equations.node import Node, Untraceable, as_node, make

SAME = {"true_divide": "divide", "float_power": "power", "fabs": "absolute", "conjugate": "positive"}


class Traced(np.ndarray[Any, np.dtype[Any]]):
    """An array of objects that are formulae. Functions of numpy that are no operation on formulae raise Untraceable."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method != "__call__" or any(value is not None for value in options.values()):
            raise Untraceable(f"no formula is known of {ufunc.__name__}.{method}")
        name = SAME.get(ufunc.__name__, ufunc.__name__)
        if name == "clip":
            return np.minimum(np.maximum(traced(inputs[0]), inputs[1]), inputs[2])
        if name == "square":
            return np.multiply(traced(inputs[0]), inputs[0])
        if name == "positive":
            return traced(inputs[0])
        return _each(name, inputs)

    def __array_function__(self, func: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if func is np.where and len(args) == 3:
            return _each("where", args)
        if func is np.real:
            return args[0]
        return super().__array_function__(func, types, args, kwargs)


def traced(values: Any) -> Traced:
    """An array of formulae, of a formula, of numbers, or of a sequence of these."""
    if isinstance(values, Node):
        return _filled([values], ())
    array = np.asarray(values, dtype=object)
    return _filled([as_node(one) for one in array.reshape(-1)], array.shape)


def _filled(nodes: Sequence[Node], shape: tuple[int, ...]) -> Traced:
    array = np.empty(len(nodes), dtype=object)
    array[:] = nodes
    return array.reshape(shape).view(Traced)


def _each(operation: str, inputs: Sequence[Any]) -> Traced:
    """An operation on every element."""
    arrays = np.broadcast_arrays(*(np.asarray(traced(one)) for one in inputs))
    nodes = [make(operation, *arguments) for arguments in zip(*(a.reshape(-1) for a in arrays), strict=True)]
    return _filled(nodes, arrays[0].shape)
