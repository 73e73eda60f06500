"""What every reader returns: columns by name."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from robotid.errors import ConfigError
from robotid.model.array import Array


@dataclass(frozen=True, slots=True, eq=False)
class Table:
    """A file's numeric columns. path : as messages name it; columns : dotted name to (n,) or a matrix; units : by name,
    where the file tells them; lines : (n,) line of the file of each row, where the file has lines."""

    path: str
    columns: dict[str, Array]
    units: dict[str, str] = field(default_factory=dict)
    lines: Array | None = None

    def pick(self, name: str, column: int | None) -> Array:
        """One column, (n,). column : of a matrix, whichever way it lies. Raises ConfigError where it is not there."""
        if name not in self.columns:
            raise ConfigError(f'there is no column "{name}"', where=self.path, hint=self.offer())
        values = self.columns[name]
        if values.ndim == 1:
            if column not in (None, 0):
                what = f'"{name}" is a single column, not a matrix'
                raise ConfigError(what, where=self.path, hint="leave out `column`")
            return values
        rows = values if values.shape[0] < values.shape[1] else values.T
        hint = f"say which: {{name: {name}, column: 0}}"
        if column is None:
            raise ConfigError(f'"{name}" is a matrix of {len(rows)} columns', where=self.path, hint=hint)
        if column >= len(rows):
            what = f'"{name}" has columns 0 to {len(rows) - 1}, not {column}'
            raise ConfigError(what, where=self.path, hint="columns are counted from 0")
        return np.ascontiguousarray(rows[column])

    def offer(self) -> str:
        """What the file holds, for a message."""
        names = list(self.columns)
        return (
            f"it holds {', '.join(names[:12])}{', ...' * (len(names) > 12)}" if names else "it holds no numeric column"
        )

    def where(self, row: int) -> str:
        """A row as a place in the file."""
        return f"{self.path}, sample {row}" if self.lines is None else f"{self.path}:{int(self.lines[row])}"
