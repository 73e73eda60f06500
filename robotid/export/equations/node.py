"""A formula as a graph: numbers, names and operations. Equal parts are one node where one `Graph` makes them."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np


class Untraceable(TypeError):
    """What has no formula: a decision that depends on a value, or a function that no formula is known of."""


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """A number, a name, or an operation on other nodes. operation : "number", "name", or a name of `OPERATIONS`."""

    operation: str
    arguments: tuple[Node, ...] = ()
    value: float = 0.0
    name: str = ""

    @property
    def real(self) -> Node:
        """Itself: formulae are of real numbers."""
        return self

    def __bool__(self) -> bool:
        raise Untraceable("a decision depends on a value")

    def __float__(self) -> float:
        raise Untraceable("a number is needed where there is a formula")

    def __add__(self, other: Any) -> Any:
        return _binary("add", self, other)

    def __radd__(self, other: Any) -> Any:
        return _binary("add", other, self)

    def __sub__(self, other: Any) -> Any:
        return _binary("subtract", self, other)

    def __rsub__(self, other: Any) -> Any:
        return _binary("subtract", other, self)

    def __mul__(self, other: Any) -> Any:
        return _binary("multiply", self, other)

    def __rmul__(self, other: Any) -> Any:
        return _binary("multiply", other, self)

    def __truediv__(self, other: Any) -> Any:
        return _binary("divide", self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _binary("divide", other, self)

    def __pow__(self, other: Any) -> Any:
        return _binary("power", self, other)

    def __rpow__(self, other: Any) -> Any:
        return _binary("power", other, self)

    def __neg__(self) -> Node:
        return make("negative", self)

    def __abs__(self) -> Node:
        return make("absolute", self)

    def __lt__(self, other: Any) -> Any:
        return _binary("less", self, other)

    def __gt__(self, other: Any) -> Any:
        return _binary("greater", self, other)

    def sin(self) -> Node:
        """Called by numpy's function for an array of objects, as are those below."""
        return make("sin", self)

    def cos(self) -> Node:
        """As `sin`."""
        return make("cos", self)

    def tanh(self) -> Node:
        """As `sin`."""
        return make("tanh", self)

    def exp(self) -> Node:
        """As `sin`."""
        return make("exp", self)

    def log(self) -> Node:
        """As `sin`."""
        return make("log", self)

    def sqrt(self) -> Node:
        """As `sin`."""
        return make("sqrt", self)


ARITHMETIC = ("add", "subtract", "multiply", "divide", "power", "negative", "absolute")
COMPARISONS = ("less", "greater", "less_equal", "greater_equal")
FUNCTIONS = ("sin", "cos", "tan", "tanh", "arctan", "exp", "log", "sqrt", "sign", "minimum", "maximum")
OPERATIONS = frozenset({*ARITHMETIC, *COMPARISONS, *FUNCTIONS, "where"})
"""What a formula may be made of, by the names of numpy."""

ZERO, ONE = Node("number", value=0.0), Node("number", value=1.0)


def named(name: str) -> Node:
    """A variable or a parameter."""
    return Node("name", name=name)


def as_node(value: Any) -> Node:
    """A formula of a number, or of an array that holds one thing. Raises Untraceable for anything else."""
    if isinstance(value, Node):
        return value
    if isinstance(value, np.ndarray | np.generic):
        if value.size != 1:
            raise Untraceable("several values where one is meant")
        return as_node(value.reshape(()).item())
    if isinstance(value, bool | int | float) and isfinite(value):
        return Node("number", value=float(value))
    raise Untraceable(f"no formula of {value!r}")


def make(operation: str, *arguments: Any) -> Node:
    """An operation on formulae and numbers, simplified where a number is zero or one. Raises Untraceable for an
    operation that no formula is known of."""
    if operation not in OPERATIONS:
        raise Untraceable(f"no formula is known of {operation}")
    nodes = tuple(as_node(a) for a in arguments)
    simpler = _simplified(operation, nodes)
    return Node(operation, nodes) if simpler is None else simpler


def _binary(operation: str, a: Any, b: Any) -> Any:
    """An operation on two things; an array takes it over, element by element."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return NotImplemented
    return make(operation, a, b)


def _simplified(operation: str, nodes: tuple[Node, ...]) -> Node | None:
    """The result without the operation, where that is known."""
    if all(node.operation == "number" for node in nodes):
        return _worked_out(operation, [node.value for node in nodes])
    if operation == "negative":
        inner = nodes[0]
        return inner.arguments[0] if inner.operation == "negative" else None
    if len(nodes) != 2:
        return None
    a, b = nodes
    match operation:
        case "add" if is_number(a, 0.0) or is_number(b, 0.0):
            return b if is_number(a, 0.0) else a
        case "add" if b.operation == "negative":
            return make("subtract", a, b.arguments[0])
        case "add" if a.operation == "negative":
            return make("subtract", b, a.arguments[0])
        case "subtract" if is_number(a, 0.0) or is_number(b, 0.0):
            return a if is_number(b, 0.0) else make("negative", b)
        case "subtract" if b.operation == "negative":
            return make("add", a, b.arguments[0])
        case "multiply" if is_number(a, 0.0) or is_number(b, 0.0):
            return ZERO
        case "multiply" if is_number(a, 1.0) or is_number(b, 1.0):
            return b if is_number(a, 1.0) else a
        case "multiply" if is_number(a, -1.0) or is_number(b, -1.0):
            return make("negative", b if is_number(a, -1.0) else a)
        case "divide" | "power" if is_number(b, 1.0):
            return a
    return None


def _worked_out(operation: str, values: list[float]) -> Node | None:
    if operation in (*COMPARISONS, "where"):
        return None
    with np.errstate(all="ignore"):
        result = float(getattr(np, operation)(*values))
    return Node("number", value=result) if isfinite(result) else None


def is_number(node: Node, value: float) -> bool:
    """Whether a formula is this number."""
    return node.operation == "number" and node.value == value
