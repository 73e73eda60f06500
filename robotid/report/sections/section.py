"""What a section of a report is: a title, figures, and a note above them."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from matplotlib.figure import Figure

from robotid.report.drawing.layout import time_figure
from robotid.report.drawing.time import TimePlot
from robotid.report.findings import Findings
from robotid.report.tables.table import Table


@dataclass(frozen=True, slots=True)
class Bin:
    """A bin of a curve. where : in words. times : by record, stretches from one time to another [s]."""

    where: str
    times: Mapping[str, Sequence[tuple[float, float]]]


@dataclass(frozen=True, slots=True)
class FigureSpec:
    """One figure. name : of its file, without ending. alt : what is to be seen, in words.

    draw : makes the figure. plot : signals over time, which the page draws by itself so that they can be zoomed, and
    samples : how many the record has. wide : takes the whole width of a page. record : whose signals these are, so
    that figures of one record move together. folded : shown on request only. bins : of a curve, when each record is in
    each bin [s].
    """

    name: str
    title: str
    alt: str
    draw: Callable[[], Figure]
    plot: TimePlot | None = None
    samples: int = 0
    wide: bool = False
    record: str = ""
    folded: bool = False
    bins: tuple[Bin, ...] = ()


class Section(ABC):
    """A section of the page; it is left out where it has neither figures nor tables."""

    title: ClassVar[str]

    @abstractmethod
    def figures(self, f: Findings) -> Iterator[FigureSpec]:
        """The figures that the findings allow, in order."""

    def tables(self, f: Findings) -> Iterator[Table]:
        """Tables below the figures, none unless the section says so."""
        return iter(())

    def note(self, f: Findings) -> str:
        """A sentence above the figures, empty where there is none."""
        return ""


def slug(name: str) -> str:
    """A name as a part of the name of a file."""
    return re.sub(r"[^A-Za-z0-9_]+", "-", name).strip("-")


def over_time(name: str, plot: TimePlot, alt: str, record: str, samples: int = 0) -> FigureSpec:
    """A figure of signals over time. samples : of the whole record."""
    return FigureSpec(name, plot.title, alt, partial(time_figure, plot), plot, samples, wide=True, record=record)
