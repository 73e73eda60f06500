"""Derivatives of one quantity at many samples, as sparse tangents, and the matrices that they are summed up in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from robotid.model.array import Array

Parts = dict[int, "Array | float"]
"""Derivatives (n,), or plain numbers where they are the same at every sample, by what they are to."""


@dataclass(slots=True)
class Tangent:
    """Derivatives of one quantity: to states, by row of x, and to parameters, by index into theta. What is not there
    is zero."""

    states: Parts = field(default_factory=dict)
    parameters: Parts = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class DerivativeColumns:
    """What derivatives are wanted to, apart from the states: parameters, by index into theta, then generalised forces,
    by coordinate, and then always the motor torque. Matrices have their columns in this order."""

    parameters: tuple[int, ...] = ()
    forces: tuple[int, ...] = ()

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.parameters) + len(self.forces) + 1


@dataclass(slots=True)
class Derivatives:
    """Derivatives of k quantities at n points, summed up from tangents.

    states (k, nx, n) : to all states; columns (k, width, n) : to the wanted parameters, forces and motor torque; None
    where that is not wanted. where : column of each wanted parameter.
    """

    states: Array | None
    columns: Array | None
    where: Mapping[int, int]

    @classmethod
    def zeros(cls, rows: int, nx: int, n: int, wanted: DerivativeColumns | None) -> Derivatives:
        """No derivatives yet. rows : k; wanted : None for those to the states alone."""
        columns = None if wanted is None else np.zeros((rows, wanted.width, n))
        where = {} if wanted is None else {c: k for k, c in enumerate(wanted.parameters)}
        return cls(np.zeros((rows, nx, n)), columns, where)

    def add(self, row: int, tangent: Tangent, factor: Array | float = 1.0) -> None:
        """Add a tangent, times a factor, to the derivatives of one quantity; parameters that are not wanted are left
        out."""
        if self.states is not None:
            for k, value in tangent.states.items():
                self.states[row, k] += _times(factor, value)
        if self.columns is not None:
            for c, value in tangent.parameters.items():
                if c in self.where:
                    self.columns[row, self.where[c]] += _times(factor, value)


@dataclass(slots=True)
class SparseDerivatives:
    """Derivatives of k quantities at n points, summed up entry by entry: rows to all states, and to what is wanted
    besides, None where that is not wanted. where : column of each wanted parameter."""

    states: list[Parts]
    columns: list[Parts] | None
    where: Mapping[int, int]

    @classmethod
    def zeros(cls, rows: int, wanted: DerivativeColumns | None) -> SparseDerivatives:
        """No derivatives yet. rows : k; wanted : None for those to the states alone."""
        columns = None if wanted is None else [Parts() for _ in range(rows)]
        where = {} if wanted is None else {c: k for k, c in enumerate(wanted.parameters)}
        return cls([Parts() for _ in range(rows)], columns, where)

    def add(self, row: int, tangent: Tangent, factor: Array | float = 1.0) -> None:
        """Add a tangent, times a factor, to the derivatives of one quantity; parameters that are not wanted are left
        out."""
        accumulate(self.states[row], factor, tangent.states)
        if self.columns is not None:
            wanted = {self.where[c]: value for c, value in tangent.parameters.items() if c in self.where}
            accumulate(self.columns[row], factor, wanted)


def combine(parts: Iterable[tuple[Array | float, Tangent]]) -> Tangent:
    """Sum of tangents, each times a factor."""
    states: Parts = {}
    parameters: Parts = {}
    for factor, tangent in parts:
        if not absent(factor):
            accumulate(states, factor, tangent.states)
            accumulate(parameters, factor, tangent.parameters)
    return Tangent(states, parameters)


def accumulate(total: Parts, factor: Array | float, parts: Parts) -> None:
    """Add a multiple of some derivatives to a total, in place; without arithmetic where a factor is the number 1."""
    plain = isinstance(factor, float)
    same, less = plain and factor == 1.0, plain and factor == -1.0
    for key, value in parts.items():
        before = total.get(key)
        if less and before is not None:
            total[key] = before - value
            continue
        scaled = value if same else factor if isinstance(value, float) and value == 1.0 else factor * value
        total[key] = scaled if before is None else before + scaled


def _times(factor: Array | float, value: Array | float) -> Array | float:
    """The product, without the arithmetic where one of the two is the plain number 1."""
    return value if _one(factor) else factor if _one(value) else factor * value


def absent(partial: Array | float) -> bool:
    """Whether a partial is the plain number 0.0, which says that the quantity never depends on that argument."""
    return isinstance(partial, float) and partial == 0.0


def _one(factor: Array | float) -> bool:
    return isinstance(factor, float) and factor == 1.0
