"""The report as one HTML page that needs nothing but itself."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib.resources import files
from itertools import groupby
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup, escape
from matplotlib.figure import Figure

from robotid.interrupt import check
from robotid.model.array import Array
from robotid.model.units import typeset
from robotid.numerals import significant
from robotid.parallel import each
from robotid.report.drawing.layout import time_figure
from robotid.report.drawing.time import Series, TimePlot
from robotid.report.findings import Findings
from robotid.report.origin import Origin
from robotid.report.sections import SECTIONS, FigureSpec, Section
from robotid.report.style.axes import envelope
from robotid.report.style.svg import COLOURS, identifier, inline
from robotid.report.summary import remarks, robot_summary, summary
from robotid.report.tables.overview import overview
from robotid.report.tables.table import Table, for_people

MAX_VALUES = 400_000  # of all signals that can be zoomed, together, their times among them: 2.1 MB
MIN_SAMPLES = 2000  # of one of them
SAMPLES = tuple(round(MIN_SAMPLES * 1.1**k) for k in range(60))  # that a signal may keep, up to half a million
MAX_ROWS, SHOWN_ROWS = 40, 20  # of a table: of a longer one so many are shown until it is opened
MAX_UNFOLDED = 30  # characters of a cell that may be folded
AXIS_FIGURES = 4  # narrow ones, and wide ones, of a section where there are several axes
LIKE_A_FIGURE = 10_000  # samples of a fit that takes as long as a figure
STATIC_POINTS = 1200  # points of a curve where the page cannot draw: without JavaScript
MINUS = re.compile(r"-(?=\d)")
NEGATIVE = re.compile(r"(?<![\w.)\]-])-(?=\d)")  # the sign of a number in a sentence, no part of a name or a date
NUMBERS = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?(%|\*| (/|to) [-+]?[\d.]+(e[-+]?\d+)?)?")
NUMBER = re.compile(r"<?[-+–−]?[\d.]+(e[-+]?\d+)?\s*[%*]?|-|–|")


@dataclass(frozen=True, slots=True)
class StageTables:
    """What the command line prints of a stage, under a heading."""

    heading: str
    tables: tuple[Table, ...]


@dataclass(frozen=True, slots=True)
class Mark:
    """A verdict as the head shows it. axis : whose, empty where there is one joint."""

    verdict: str
    axis: str = ""


@dataclass(frozen=True, slots=True)
class Head:
    """What a page begins with. summary : the answer, under the title; marks : the verdicts, of each axis that has been
    diagnosed; facts : what stands beside them; remarks : below the answer, what to know beside it."""

    title: str
    summary: str
    marks: tuple[Mark, ...] = ()
    facts: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PageSection:
    """A section of a page, left out where it has no figures. note : above them; tables : below them."""

    title: str
    note: str
    figures: tuple[FigureSpec, ...]
    tables: tuple[Table, ...] = ()


@dataclass(frozen=True, slots=True)
class AxisPage:
    """What a page shows of one axis. stages : tables of each stage that has run, in order."""

    findings: Findings
    stages: Sequence[StageTables]


def page(findings: Findings, stages: Sequence[StageTables], origin: Origin, title: str | None = None) -> str:
    """The HTML. stages : tables of each stage that has run, in order. title : the heading, absent: the robot's name."""
    marks, facts = _marks({"": findings}), _facts(findings, origin)
    head = Head(title or findings.robot, summary(findings), marks, facts, remarks(findings))
    return rendered(head, _sections(findings), stages, origin)


def robot_page(axes: Mapping[str, AxisPage], origin: Origin, title: str, common: Sequence[Table] = ()) -> str:
    """The HTML for a robot of several axes: an overview, and the sections of each axis, of which the first figures are
    shown where there are several axes. axes : by name; common : tables of the whole robot."""
    findings = {axis: one.findings for axis, one in axes.items()}
    several = len(axes) > 1
    most = AXIS_FIGURES if several else None
    parts = [
        _Part(
            axis,
            summary(one.findings) if several else "",
            _sections(one.findings, axis, most),
            one.stages,
            remarks(one.findings) if several else (),
        )
        for axis, one in axes.items()
    ]
    first = next(iter(findings.values()))
    beside = () if several else remarks(first)
    head = Head(title, robot_summary(findings), _marks(findings), _facts(first, origin), beside)
    return _rendered(head, parts, origin, (overview(findings), *common))


def rendered(head: Head, sections: Sequence[PageSection], stages: Sequence[StageTables], origin: Origin) -> str:
    """The HTML of any page."""
    return _rendered(head, [_Part("", "", sections, stages)], origin)


def _sections(findings: Findings, axis: str = "", most: int | None = None) -> list[PageSection]:
    """All sections; the names of figures begin with that of the axis. most : figures of a section that are shown."""
    return [_section(one, findings, axis, most) for one in SECTIONS]


def _section(section: Section, findings: Findings, axis: str, most: int | None) -> PageSection:
    prefix = f"{axis}-" if axis else ""
    specs = tuple(replace(spec, name=f"{prefix}{spec.name}") for spec in section.figures(findings))
    shown, note = specs if most is None else _first(specs, most), section.note(findings)
    if left := len(specs) - len(shown):
        more = f"{left} more figure{'s are' if left > 1 else ' is'}"
        note = f"{note} {more} on the page that `robotid report --axis {axis}` writes.".lstrip()
    return PageSection(section.title, note, shown, tuple(section.tables(findings)))


def _first(specs: Sequence[FigureSpec], most: int) -> tuple[FigureSpec, ...]:
    """The first figures that are not folded, so many narrow ones and so many as wide as the page."""
    shown = [spec for spec in specs if not spec.folded]
    kept = {id(spec) for wide in (True, False) for spec in [one for one in shown if one.wide is wide][:most]}
    return tuple(spec for spec in shown if id(spec) in kept)


@dataclass(frozen=True, slots=True)
class _ShownSection:
    """A section as the template takes it. folded : figures that are shown on request."""

    title: str
    note: str
    figures: list[_Shown]
    folded: list[_Shown]
    tables: list[_Grid]


@dataclass(frozen=True, slots=True)
class _Part:
    """What is shown of one axis, its name empty where it is the whole page. summary, remarks : under its name."""

    name: str
    summary: str
    sections: Sequence[PageSection]
    stages: Sequence[StageTables]
    remarks: tuple[str, ...] = ()

    @property
    def anchor(self) -> str:
        """How the identifiers of its sections begin."""
        return f"{self.name}-" if self.name else ""

    @property
    def level(self) -> int:
        """Of the headings of its sections."""
        return 3 if self.name else 2

    def shown(self, figures: Mapping[int, _Shown]) -> list[_ShownSection]:
        """The sections that have figures. figures : as of `_all_shown`."""
        return [
            _ShownSection(
                one.title,
                one.note,
                _in_pairs([figures[id(spec)] for spec in one.figures if not spec.folded]),
                _in_pairs([figures[id(spec)] for spec in one.figures if spec.folded]),
                [_grid(table) for table in one.tables],
            )
            for one in self.sections
            if one.figures
        ]

    def tables(self) -> list[tuple[str, list[_Grid]]]:
        """Heading and tables of each stage, the last first."""
        return [(one.heading, [_grid(table) for table in one.tables if table.rows]) for one in reversed(self.stages)]


def _rendered(head: Head, parts: Sequence[_Part], origin: Origin, of_robot: Sequence[Table] = ()) -> str:
    figures = _all_shown([spec for part in parts for one in part.sections for spec in one.figures])
    return _template().render(
        title=head.title,
        summary=head.summary,
        remarks=head.remarks,
        marks=head.marks,
        facts=head.facts,
        of_robot=[_grid(table) for table in of_robot],
        axes=[
            {
                "name": part.name,
                "summary": part.summary,
                "remarks": part.remarks,
                "anchor": part.anchor,
                "level": part.level,
                "sections": part.shown(figures),
                "tables": part.tables(),
            }
            for part in parts
        ],
        origin=origin,
        style=Markup(_own("page.css")),
        script=Markup(_own("page.js")),
        policy=content_policy(_own("page.js")),
    )


def _marks(axes: Mapping[str, Findings]) -> tuple[Mark, ...]:
    """The verdicts that there are. axes : by name, which is empty for a single joint."""
    return tuple(Mark(f.diagnosis.verdict, axis) for axis, f in axes.items() if f.diagnosis is not None)


def _facts(f: Findings, origin: Origin) -> tuple[str, ...]:
    """What the head states beside the verdict: date, data and version."""
    last = max(origin.sources, key=lambda source: source.created, default=None)
    made = () if last is None else (_instant(last.created), f"robotid {last.version}")
    if f.recordings is None:
        return made
    records = f.recordings.records
    kinds = [len([r for r in records if r.role == role]) for role in ("estimate", "validate")]
    length = significant(sum(record.duration for record in records))
    counted = f"{len(records)} records" if len(records) != 1 else "1 record"
    data = f"{counted}, {length} s: {kinds[0]} to fit, {kinds[1]} held out"
    return (*made[:1], data, *made[1:])


def _instant(created: str) -> str:
    """When an artifact was made, to a minute."""
    return f"{created[:16].replace('T', ' ')}{' UTC' * created.endswith('+00:00')}"


def content_policy(script: str) -> str:
    """What a browser may do with the page: run this script and no other, draw, and load nothing from anywhere."""
    found = base64.b64encode(hashlib.sha256(f"\n{script}\n".encode()).digest()).decode()  # as the template sets it
    return (
        f"default-src 'none'; script-src 'sha256-{found}'; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )


@dataclass(frozen=True, slots=True)
class _Shown:
    """A figure as the template takes it: svg, the figure itself, and data, what the script draws instead, None of a
    figure that cannot be zoomed. thinned : that not all samples are drawn, where that is so. alone : it has the row to
    itself, its caption beside it."""

    spec: FigureSpec
    svg: Markup
    data: Markup | None = None
    thinned: str = ""
    alone: bool = False


def _all_shown(specs: Sequence[FigureSpec]) -> dict[int, _Shown]:
    """The figures of a page, which take most of its time, drawn by all processes; by the identity of their specs."""
    most = _samples_of_each([spec.plot for spec in specs if spec.plot is not None])
    drawings = [(_still(spec), spec.name) for spec in specs]
    pictures = each(_drawn, drawings, range(len(specs)), samples=LIKE_A_FIGURE)
    return {id(spec): _shown(spec, picture, most) for spec, picture in zip(specs, pictures, strict=True)}


def _still(spec: FigureSpec) -> Callable[[], Figure]:
    """What draws a figure as it is before it is zoomed."""
    return spec.draw if spec.plot is None else partial(time_figure, _thinned(spec.plot, STATIC_POINTS))


def _drawn(drawings: Sequence[tuple[Callable[[], Figure], str]], k: int) -> str:
    check()
    draw, name = drawings[k]
    return inline(draw(), name)


def _shown(spec: FigureSpec, picture: str, most: int) -> _Shown:
    """picture : what is drawn of it; most : samples of a signal that can be zoomed."""
    if spec.plot is None:
        return _Shown(spec, Markup(picture), Markup(_json(_bins(spec))) if spec.bins else None)
    plot = _thinned(spec.plot, most)
    drawn = max(len(series.t) for strip in plot.strips for series in strip.series)
    thinned = f"{drawn} of {spec.samples} samples, the extremes of every stretch among them." * (drawn < spec.samples)
    return _Shown(spec, Markup(picture), Markup(_json(_document(plot))), thinned)


def _in_pairs(figures: Sequence[_Shown]) -> list[_Shown]:
    """Figures in two columns: of every run between those as wide as the page, the last one is alone in its row where
    their number is odd."""
    found: list[_Shown] = []
    for wide, run in groupby(figures, lambda one: one.spec.wide):
        shown = list(run)
        if not wide and len(shown) % 2:
            shown[-1] = replace(shown[-1], alone=True)
        found += shown
    return found


def _json(document: Any) -> str:
    """JSON that no name in it can end."""
    return json.dumps(document).replace("<", "\\u003c")


def _bins(spec: FigureSpec) -> dict[str, Any]:
    """When each record is in each bin, to a millisecond."""
    return {
        "bins": [
            {
                "where": one.where,
                "times": {name: [[round(a, 3), round(b, 3)] for a, b in times] for name, times in one.times.items()},
            }
            for one in spec.bins
        ]
    }


def _samples_of_each(plots: Sequence[TimePlot]) -> int:
    """How many samples of a signal plots can hold, so that all of them together have no more than MAX_VALUES."""
    affordable = (most for most in SAMPLES if sum(_values(plot, most) for plot in plots) <= MAX_VALUES)
    return max(affordable, default=MIN_SAMPLES)


def _values(plot: TimePlot, most: int) -> int:
    """Numbers that a plot holds, its curves thinned to so many samples: a thinned curve has times of its own."""
    lengths = [len(series.t) for strip in plot.strips for series in strip.series]
    whole = [n for n in lengths if n <= most]
    return sum(whole) + max(whole, default=0) + 2 * most * (len(lengths) - len(whole))


def _thinned(plot: TimePlot, most: int) -> TimePlot:
    """A plot whose curves have so many samples at most, the extremes of every stretch among them."""
    strips = []
    for strip in plot.strips:
        pairs = [(series, *envelope(series.t, series.values, most)) for series in strip.series]
        strips.append(replace(strip, series=tuple(replace(s, t=t, values=values) for s, t, values in pairs)))
    return replace(plot, strips=tuple(strips))


def _document(plot: TimePlot) -> dict[str, Any]:
    times: list[Array] = []
    return {
        "strips": [
            {
                "label": strip.label.replace("\n", " "),
                "height": height,
                "zero": strip.zero,
                "series": [_series(series, times) for series in strip.series],
            }
            for strip, height in zip(plot.strips, plot.heights, strict=True)
        ],
        "times": [_time(t) for t in times],
    }


def _series(series: Series, times: list[Array]) -> dict[str, Any]:
    at = next((k for k, t in enumerate(times) if np.array_equal(t, series.t)), len(times))
    if at == len(times):
        times.append(series.t)
    return {
        "name": series.name,
        "colour": COLOURS[series.colour],
        "width": series.width,
        "ranged": series.ranged,
        "time": at,
        "values": _packed(series.values),
    }


def _time(t: Array) -> dict[str, Any]:
    """Times in shortest steps since the first: evenly sampled ones are whole numbers, exact in single precision."""
    step = float(np.diff(t).min()) if len(t) > 1 else 1.0
    return {"start": float(t[0]), "step": step, "samples": _packed(np.round((t - t[0]) / step, 3))}


def _packed(values: Array) -> str:
    """Single-precision numbers, little end first, in base 64."""
    return base64.b64encode(values.astype("<f4").tobytes()).decode()


@dataclass(frozen=True, slots=True)
class _Grid:
    """A table without its empty columns. kinds : attributes of the columns' cells, by what they hold."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    kinds: tuple[Markup, ...]
    note: str


def _grid(plain: Table) -> _Grid:
    table = for_people(plain)
    kept = [k for k in range(len(table.columns)) if not k or any(row[k] for row in table.rows)]
    rows = tuple(tuple(row[k] for k in kept) for row in table.rows)
    kinds = tuple(_kind([row[k] for row in rows]) for k in range(len(kept)))
    rows = tuple(tuple(_signed(cell) for cell in row) for row in rows)
    return _Grid(table.title, tuple(table.columns[k] for k in kept), rows, kinds, table.note)


def _signed(cell: str) -> str:
    """A number with the sign that is as wide as a plus."""
    return MINUS.sub("−", cell) if NUMBERS.fullmatch(cell) else cell


def written(sentence: str) -> Markup:
    """A sentence as it is set: percent signs stay with their numbers, negative ones have a minus sign, powers of units
    are raised, commands stand apart."""
    parts = sentence.split("`")  # every other one is a command
    parts[::2] = [NEGATIVE.sub("−", escape(typeset(part)).replace(" %", "\u00a0%")) for part in parts[::2]]
    parts[1::2] = [Markup("<code>{}</code>").format(part) for part in parts[1::2]]
    return Markup("").join(Markup(part) for part in parts)


def _kind(cells: Sequence[str]) -> Markup:
    if all(NUMBER.fullmatch(cell.strip()) for cell in cells):
        return Markup(' class="number"')
    return Markup(' class="long"' if any(len(cell) > MAX_UNFOLDED for cell in cells) else "")


def _own(name: str) -> str:
    return files("robotid.report").joinpath("assets", name).read_text(encoding="utf-8")


@cache
def _template() -> Template:
    loader = PackageLoader("robotid.report", package_path="assets")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.globals |= {"most_rows": MAX_ROWS, "shown_rows": SHOWN_ROWS}
    environment.filters["slug"] = lambda text: re.sub(r"\W+", "-", text.lower())
    environment.filters["identifier"] = identifier
    environment.filters["prose"] = written
    environment.filters["typeset"] = typeset
    return environment.get_template("page.html")
