"""Signals over time: strips one above the other on a common time, drawn here or by the page, which can zoom them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase

from robotid.extension.results import Extension
from robotid.model.array import Array, Mask
from robotid.numerals import fixed
from robotid.report.events import accounted_for
from robotid.report.evidence.law import Law
from robotid.report.style.axes import BLUE, FAINT, INK, MAX_POINTS, VERMILLION, Units, axis_label, envelope, style_axes
from robotid.signals.record import Quantity, Record
from robotid.signals.reference import Reference
from robotid.signals.trace import Trace
from robotid.validation.results import RecordValidation

OUTPUT = {"speed": "motor speed [{}]", "position": "motor position [{}]"}
REFERENCE = {"speed": "reference speed [{}]", "position": "reference position [{}]"}
UNIT = {"speed": "rad/s", "position": "rad"}
ROOM = 0.06  # about the curves of a strip whose range is given, of that range
COMPACT = 0.55  # of the height of a plot with little to see
THIN, USUAL, THICK, HEAVY = 0.7, 0.9, 1.6, 2.4  # lines [pt]


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """A curve, t and values (n,). A name that several strips share is one curve to the reader; an empty one is not
    listed. ranged : whether the range of its strip shows all of it; where it leaves that range, a mark stands."""

    name: str
    t: Array
    values: Array
    colour: str
    width: float = USUAL
    ranged: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class Strip:
    """Curves on one pair of axes, one of them ranged at least. label : quantity and unit. height : relative to the
    other strips."""

    label: str
    series: tuple[Series, ...]
    height: float = 1.0
    zero: bool = False

    @property
    def reach(self) -> tuple[float, float]:
        """The range that shows all of the curves that are ranged, and zero where that is drawn, with some room."""
        values = [np.zeros(1)] * self.zero + [series.values for series in self.series if series.ranged]
        low, high = min(float(np.nanmin(one)) for one in values), max(float(np.nanmax(one)) for one in values)
        room = ROOM * (high - low) or 1.0
        return low - room, high + room

    def beyond(self, series: Series) -> Mask:
        """Where a curve leaves the range, (n,)."""
        low, high = self.reach
        return np.asarray((series.values < low) | (series.values > high)) & (not series.ranged)


@dataclass(frozen=True, slots=True, eq=False)
class TimePlot:
    """Strips on a common time, the upper one first. compact : there is little to see, so they are lower."""

    title: str
    strips: tuple[Strip, ...]
    compact: bool = False

    @property
    def heights(self) -> tuple[float, ...]:
        """Of the strips, relative."""
        return tuple((COMPACT if self.compact else 1.0) * strip.height for strip in self.strips)


def record_plot(record: Record, units: Units = str) -> TimePlot:
    """Torque above, speed below, with the reference where it is one of speed."""
    torque = Series("", record.t, record.tau_m, BLUE, THIN)
    speed = Series("measured", record.t, record.dphi_m, BLUE)
    asked: tuple[Series, ...] = ()
    if record.ref is not None and record.ref_kind == "speed":
        asked = (Series("reference", record.t, record.ref, FAINT, THIN),)
    return TimePlot(
        f"{record.name} ({record.role})",
        (
            Strip(f"{axis_label('motor torque', units)} [{units('Nm')}]", (torque,), 1.0),
            Strip(OUTPUT["speed"].format(units("rad/s")), (*asked, speed), 1.4),
            *_angles(record, units),
        ),
    )


def _angles(record: Record, units: Units) -> Iterator[Strip]:
    """Motor angle with its reference, and the arm's where it was measured."""
    angle = Series("measured", record.t, record.phi_m, BLUE)
    asked: tuple[Series, ...] = ()
    if record.ref is not None and record.ref_kind == "position":
        asked = (Series("reference", record.t, record.ref, FAINT, THIN),)
    yield Strip(f"{axis_label('motor angle', units)} [{units('rad')}]", (*asked, angle), 1.0)
    if record.phi_a is not None:
        arm = Series("measured", record.t, record.phi_a, BLUE)
        yield Strip(f"{axis_label('arm angle', units)} [{units('rad')}]", (arm,), 1.0)


def reference_plot(reference: Reference, units: Units = str) -> TimePlot:
    """What the controller is to follow."""
    label = REFERENCE[reference.kind].format(units(UNIT[reference.kind]))
    return TimePlot(reference.name, (Strip(label, (Series("", reference.t, reference.ref, BLUE),), 2.0),))


def trace_plot(name: str, validation: RecordValidation, output: Quantity, units: Units = str) -> TimePlot:
    """Measured and simulated output above, their difference below."""
    kind = "fitted" if validation.used else "held out"
    title = f"{name} ({kind}): fit {fixed(validation.fit_percent)} %"
    return simulated_plot(title, validation.trace, output, units)


def simulated_plot(title: str, trace: Trace, output: Quantity, units: Units = str) -> TimePlot:
    """Measured and simulated output above, their difference below, under a title."""
    return _compared(title, {"simulated": (trace, BLUE)}, output, units)


def extended_plot(extension: Extension, name: str, units: Units = str) -> TimePlot:
    """The same before and after the extension of the model."""
    before, after, output = extension.before[name], extension.after[name], extension.output
    kind = "fitted" if after.used else "held out"
    remark = accounted_for(extension.events_of(name))
    title = f"{name} ({kind}{remark and f', {remark}'}): fit {fixed(before.fit_percent)} → {fixed(after.fit_percent)} %"
    both = {"before the extension": (before.trace, VERMILLION), "after it": (after.trace, BLUE)}
    return _compared(title, both, output, units)


def missing_plot(
    name: str, missing: Trace, units: Units = str, law: Law | None = None, *, causes: bool = True
) -> TimePlot:
    """The torque that the residual asks for, the law that an extension adds, where it is known, and what is still asked
    for once the causes are there, where there are any: on one scale, which is that of the residual. A law is computed,
    not measured: where the model before jumps between sticking and slipping, it may be many times as large."""
    what = axis_label("missing torque", units)
    curves = [Series("asked for by the residual", missing.t, missing.measured, VERMILLION, THICK)]
    if law is not None:
        curves.append(Series("law of the extension", law.t, law.torque, INK, USUAL, ranged=False))
    if causes and np.any(missing.simulated):
        left = missing.measured - missing.simulated
        curves.append(Series("still asked for, after", missing.t, left, BLUE, USUAL))
    return TimePlot(f"{what} of {name}", (Strip(f"{what} [{units('Nm')}]", tuple(curves), 2.0, zero=True),))


def draw_strips(pair: Sequence[Axes], plot: TimePlot, *, most: int = MAX_POINTS) -> None:
    """A plot over as many axes as it has strips."""
    for axes, strip in zip(pair, plot.strips, strict=True):
        for series in strip.series:
            t, values = envelope(series.t, series.values, most)
            axes.plot(t, values, color=series.colour, linewidth=series.width, label=series.name or None)
        if not all(series.ranged for series in strip.series):
            _keep_to_range(axes, strip)
        if strip.zero:
            axes.axhline(0.0, color=INK, linewidth=0.6)
        last = strip is plot.strips[-1]
        style_axes(axes, "time [s]" if last else "", strip.label, plot.title if strip is plot.strips[0] else "")
        axes.tick_params(labelbottom=last)


def _keep_to_range(axes: Axes, strip: Strip) -> None:
    """Show the curves that are ranged, and triangles at the edge where others go beyond it."""
    low, high = strip.reach
    axes.set_ylim(low, high)
    for series in strip.series:
        outside, above = strip.beyond(series), series.values > high
        for here, at, mark in ((outside & ~above, low, "v"), (outside & above, high, "^")):
            if not len(first := np.flatnonzero(here & ~np.r_[False, here[:-1]])):
                continue
            axes.plot(series.t[first], np.full(len(first), at), mark, color=series.colour, markersize=4, clip_on=False)


def name_curves(figure: FigureBase, every: Sequence[Axes]) -> None:
    """What the curves are called, as on the axes that name most, below them all, where no signal runs."""
    found = [axes.get_legend_handles_labels() for axes in every]
    handles, names = max(found, key=lambda one: len(one[1]), default=([], []))
    if names:
        figure.legend(handles, names, fontsize=8, frameon=False, ncols=len(names), loc="outside lower center")


def _compared(title: str, traces: dict[str, tuple[Trace, str]], output: Quantity, units: Units) -> TimePlot:
    unit = units(UNIT[output])
    first = next(iter(traces.values()))[0]
    measured = Series("measured", first.t, first.measured, FAINT, HEAVY)
    simulated = [Series(name, t.t, t.simulated, colour) for name, (t, colour) in traces.items()]
    left = [Series(name, t.t, t.measured - t.simulated, colour, THIN) for name, (t, colour) in traces.items()]
    return TimePlot(
        title,
        (
            Strip(OUTPUT[output].format(unit), (measured, *simulated), 2.6),
            Strip(f"residual\n[{unit}]", tuple(left), 1.0, zero=True),
        ),
    )
