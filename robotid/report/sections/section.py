"""What a section of a report is: a title, figures, and a note above them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from matplotlib.figure import Figure

from robotid.report.drawing.layout import time_figure
from robotid.report.drawing.time import TimePlot
from robotid.report.findings import Findings


@dataclass(frozen=True, slots=True)
class FigureSpec:
    """One figure. name : of its file, without ending. alt : what is to be seen, in words.

    draw : makes the figure. plot : signals over time, which the page draws by itself so that they can be zoomed, and
    samples : how many the record has. wide : takes the whole width of a page.
    """

    name: str
    title: str
    alt: str
    draw: Callable[[], Figure]
    plot: TimePlot | None = None
    samples: int = 0
    wide: bool = False


class Section(ABC):
    """A section of the page; it is left out where it has no figures."""

    title: ClassVar[str]

    @abstractmethod
    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """The figures that the findings allow, in order."""

    def note(self, f: Findings) -> str:
        """A sentence above the figures, empty where there is none."""
        return ""


def over_time(name: str, plot: TimePlot, alt: str, samples: int = 0) -> FigureSpec:
    """A figure of signals over time. samples : of the whole record."""
    return FigureSpec(name, plot.title, alt, partial(time_figure, plot), plot, samples, wide=True)
