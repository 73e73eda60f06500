"""Figures of where a misfit sits: the missing torque along the variables of the motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from robotid.diagnosis.misfit.curve import IN_PROPORTION, Curve
from robotid.model.array import Array, Mask
from robotid.numerals import portion, significant
from robotid.report.evidence.samples import Samples, in_bins
from robotid.report.style.axes import (
    BLUE,
    FAINT,
    INK,
    VERMILLION,
    Units,
    axis_label,
    legend,
    style_axes,
    write_out_ticks,
)
from robotid.report.variables import MIN_SHARE, UNITS, counting_of, ordering_of, variable_of

ROOM = 1.15  # about the curves
SAME_SHARE = 0.01  # by which the arm's angle must tell more than the motor's, which it follows through the gear
MAX_DOTS = 400  # samples that are drawn behind a curve


def variable(curve: Curve, units: Units = str) -> str:
    """What a curve runs along, in words."""
    return axis_label(variable_of(curve), units)


def ordering(curve: Curve, units: Units = str) -> str:
    """What a torque follows that a curve orders, in words."""
    return axis_label(ordering_of(curve), units)


def counted(curve: Curve, units: Units = str) -> str:
    """The missing torque as the curve counts it, in words."""
    _, _, how = curve.along.partition(",")
    missing = axis_label("missing torque", units)
    if curve.along == "frequency":
        return f"{missing}, RMS"
    if how in IN_PROPORTION:
        unit = units(UNITS[IN_PROPORTION[how]])
        return f"{missing} {counting_of(curve)}, at {significant(curve.at, 2)} {unit}"
    return f"{missing} {counting_of(curve)}".strip()


def best_of_each(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """The curve that orders best along each variable, those without bins left out."""
    found: dict[str, Curve] = {}
    for curve in sorted(curves, key=lambda c: -c.order):
        if len(curve.x) and np.isfinite(curve.missing_torque).any():
            found.setdefault(variable(curve), curve)
    return tuple(found.values())


def telling(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """The curves of which there is something to see: those along frequency, and those that account for a share of the
    missing torque, that along the arm's angle only where it tells more than the motor's, which it follows."""
    shares = {curve.along: curve.order for curve in curves}
    return tuple(c for c in curves if c.along == "frequency" or (c.order >= MIN_SHARE and not _repeats(c, shares)))


def _repeats(curve: Curve, shares: Mapping[str, float]) -> bool:
    """Whether a curve along the arm's angle is that along the motor's, which is there as well."""
    name, comma, how = curve.along.partition(",")
    return name == "phi_a" and curve.order < shares.get(f"phi_m{comma}{how}", -1.0) + SAME_SHARE


def reach_of(curves: Sequence[Curve]) -> float:
    """A common scale of curves [Nm]: how far means and spreads go, rare bins left out."""
    reaches = [np.abs(_seen(c, c.missing_torque)) + _seen(c, c.spread) for c in curves]
    return ROOM * max((float(np.nanmax(r)) for r in reaches if np.isfinite(r).any()), default=1.0) or 1.0


def _seen(curve: Curve, values: Array) -> Array:
    """Values of the bins that hold anything to speak of."""
    return np.where(curve.count >= 0.01 * curve.count.max(initial=0.0), values, np.nan)


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """A curve of the missing torque with what is drawn about it. names : of the records; reach : of the ordinate [Nm],
    None where the curve is alone. samples : behind it, as far as they are known."""

    curve: Curve
    units: Units = str
    names: Sequence[str] = ()
    reach: float | None = None
    samples: tuple[Samples, ...] = ()

    @property
    def title(self) -> str:
        """The variable, and how much it tells of the missing torque."""
        share = f": accounts for {portion(self.curve.order, 0)}" if self.curve.along != "frequency" else ""
        return f"{variable(self.curve, self.units)}{share}"


def draw_curve(axes: Axes, located: Located) -> None:
    """Mean and spread of the missing torque in bins, before the extension and after it, over the faint samples; the
    law of the extension as a line."""
    curve, units = located.curve, located.units
    unit = f" [{units(curve.unit)}]" if curve.unit not in ("", "1") else ""
    known = np.isfinite(curve.missing_torque)
    x, mean, spread = curve.x[known], curve.missing_torque[known], curve.spread[known]
    shade = VERMILLION if located.samples else BLUE
    if curve.along.startswith("record"):
        axes.errorbar(x, mean, spread, fmt="o", color=BLUE, markersize=5, capsize=3, linewidth=1.2)
        axes.set_xlim(x.min() - 0.5, x.max() + 0.5)
        names = located.names
        axes.set_xticks(x, [names[int(k)] if int(k) < len(names) else str(int(k)) for k in x])
    elif curve.along == "frequency":
        axes.semilogx(x, mean, "o-", color=BLUE, markersize=3, linewidth=1.4)
        axes.set_ylim(bottom=0.0)
        write_out_ticks(axes.xaxis)
    else:
        _dots(axes, located.samples)
        _bins(axes, x, mean, spread, shade, _name(located) if located.samples else "")
        _after(axes, located, known)
        axes.xaxis.set_major_locator(MaxNLocator(6))
        room = 0.03 * float(np.ptp(x)) or 1.0
        axes.set_xlim(x.min() - room, x.max() + room)
        if located.samples:
            _targets(axes, x)
    if located.reach is not None and curve.along != "frequency":
        axes.set_ylim(-located.reach, located.reach)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    torque = (
        counted(curve, units)
        .replace(" in proportion", "\nin proportion")
        .replace(" acceleration, ", " acceleration,\n")
    )
    style_axes(axes, f"{variable(curve, units)}{unit}", f"{torque} [{units('Nm')}]", located.title)
    if found := legend(axes, columns=2, below=True):
        for handle in found.legend_handles:
            if isinstance(handle, Line2D) and handle.get_color() == FAINT:
                handle.set(markersize=4, alpha=1.0)


def _name(located: Located) -> str:
    """Of the curve of the misfit: "before" where a curve after the extension stands beside it."""
    after = all(one.left is not None for one in located.samples)
    return "asked for, before" if after else "asked for"


def _targets(axes: Axes, x: Array) -> None:
    """What a page lets be clicked: a strip a bin, seen through."""
    edges = np.concatenate([axes.get_xlim()[:1], (x[1:] + x[:-1]) / 2, axes.get_xlim()[1:]])
    for k, (left, right) in enumerate(pairwise(edges.tolist())):
        strip = axes.axvspan(left, right, facecolor=BLUE, alpha=0.0, linewidth=0, zorder=5)
        strip.set_gid(f"bin-{k}")


def _after(axes: Axes, located: Located, known: Mask) -> None:
    """What is asked for once the causes are there, and what the law of the extension gives."""
    x = located.curve.x[known]
    left, law = (in_bins(located.curve, located.samples, name) for name in ("left", "law"))
    if left is not None:
        _bins(axes, x, left.mean[known], left.spread[known], BLUE, "still asked for, after")
    if law is not None:
        axes.plot(x, law.mean[known], color=INK, linewidth=1.6, linestyle=(0, (4, 1.5)), label="law of the extension")


def _bins(axes: Axes, x: Array, mean: Array, spread: Array, shade: str, label: str) -> None:
    axes.fill_between(x, mean - spread, mean + spread, color=shade, alpha=0.18, linewidth=0)
    axes.plot(x, mean, "o-", color=shade, markersize=2.6, linewidth=1.4, label=label or None)


def _dots(axes: Axes, found: tuple[Samples, ...]) -> None:
    """Some of the samples."""
    if not found:
        return
    x, y = (np.concatenate([getattr(one, name) for one in found]) for name in ("x", "asked"))
    chosen = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    chosen = chosen[:: max(1, -(-len(chosen) // MAX_DOTS))]
    axes.plot(x[chosen], y[chosen], "o", color=FAINT, markersize=1.6, alpha=0.6, markeredgewidth=0, label="samples")


def draw_shape(axes: Axes, located: Located) -> None:
    """The missing torque that no known effect explains."""
    draw_curve(axes, located)
    curve, units = located.curve, located.units
    for line in axes.get_lines()[:1]:
        line.set_color(VERMILLION)
    title = f"unknown: {axis_label('missing torque', units)} along {variable(curve, units)}"
    axes.set_title(title, fontsize=10, loc="left", color=INK)
