"""What every reader returns: columns by name."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robotid.errors import ConfigError
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A file's numeric columns. path : as messages name it; columns : dotted name to (n,) or a matrix; units : by name,
    where the file tells them; lines : line of the file of the first row, 0 where rows have none."""

    path: str
    columns: dict[str, Array]
    units: dict[str, str] = field(default_factory=dict)
    first_line: int = 0

    def pick(self, name: str, column: int | None) -> Array:
        """One column, (n,). column : of a matrix, whichever way it lies. Raises ConfigError where it is not there."""
        if name not in self.columns:
            raise ConfigError(f'there is no column "{name}"', where=self.path, hint=self.offer())
        values = self.columns[name]
        if values.ndim == 1:
            if column not in (None, 0):
                raise ConfigError(f'"{name}" is a single column, not a matrix', where=self.path, hint="leave out `column`")
            return values
        rows = values if values.shape[0] < values.shape[1] else values.T
        if column is None:
            what = f'"{name}" is a matrix of {len(rows)} columns'
            raise ConfigError(what, where=self.path, hint=f"say which: {{name: {name}, column: 0}}")
        if column >= len(rows):
            raise ConfigError(f'"{name}" has columns 0 to {len(rows) - 1}, not {column}', where=self.path)
        return np.ascontiguousarray(rows[column])

    def offer(self) -> str:
        """What the file holds, for a message."""
        long = [n for n, v in self.columns.items() if v.size > 1]
        return "it holds " + (", ".join(long[:12]) + (", ..." if len(long) > 12 else "") if long else "no numeric column")

    def where(self, row: int) -> str:
        """A row as a place in the file."""
        return f"{self.path}:{self.first_line + row}" if self.first_line else f"{self.path}, sample {row}"
