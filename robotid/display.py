"""How a result shows itself: as a table in a terminal and in a notebook, as a data frame, as a figure.

A result is a plain dataclass in a low room, and tables and figures are made by the report, several rooms above. So that
no low room imports the report, this module alone knows where the renderer is, by name, and imports it when something is
to be shown.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RENDERER = "robotid.report.display"


class Renderer(Protocol):
    """What the module called RENDERER offers."""

    def line(self, content: object) -> str:
        """The result in a line."""

    def text(self, content: object, *, brief: bool) -> str:
        """Its tables as plain text."""

    def html(self, content: object) -> str:
        """Its tables as HTML."""

    def frame(self, content: object) -> Any:
        """Its numbers as a pandas data frame."""

    def figure(self, content: object) -> Figure:
        """Its figure."""


class Displayed:
    """A result that shows itself.

    `print(result)` prints its most important tables, a notebook shows the same; `table()` has all of them as text,
    `to_frame()` the numbers as a data frame, `plot()` a figure. It has no fields, so that a dataclass that inherits it
    is stored as before; such a dataclass is declared with `repr=False`.
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return _renderer().line(self)

    def __str__(self) -> str:
        return _renderer().text(self, brief=True)

    def _repr_html_(self) -> str:
        return _renderer().html(self)

    def table(self) -> str:
        """All tables of the result as text, as `robotid show` prints them."""
        return _renderer().text(self, brief=False)

    def to_frame(self) -> Any:
        """The numbers of the result as a pandas data frame, in SI units. Raises ConfigError where pandas is not
        installed, or where the result has no numbers to list."""
        return _renderer().frame(self)

    def plot(self) -> Figure:
        """The figure of the result, a matplotlib `Figure`: `result.plot().savefig("result.pdf")`. Raises ConfigError
        where there is nothing to see."""
        return _renderer().figure(self)


def _renderer() -> Renderer:
    return cast(Renderer, importlib.import_module(RENDERER))
