"""Figures of where a misfit sits: the missing torque along the variables of the motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from robotid.diagnosis.misfit.curve import BY_DIRECTION, BY_SPEED, Curve
from robotid.model.array import Array
from robotid.numerals import percent, significant
from robotid.report.style.axes import BLUE, INK, VERMILLION, Units, axis_label, style_axes, write_out_ticks

VARIABLES = {
    "dphi_m": "motor speed",
    "phi_m": "motor angle",
    "phi_m mod 2 pi": "motor angle within a turn",
    "phi_a": "arm angle",
    "twist": "gear twist",
    "ddphi_m": "motor acceleration",
    "tau_m": "motor torque",
    "t": "time",
    "reversal": "time since reversal",
    "record": "record",
    "frequency": "frequency",
}
ROOM = 1.15  # about the curves


def variable(curve: Curve, units: Units = str) -> str:
    """What a curve runs along, in words."""
    name = curve.along.partition(",")[0]
    return axis_label(VARIABLES.get(name, name), units)


def counted(curve: Curve, units: Units = str) -> str:
    """The missing torque as the curve counts it, in words."""
    _, _, how = curve.along.partition(",")
    missing = axis_label("missing torque", units)
    if curve.along == "frequency":
        return f"{missing}, RMS"
    if how == BY_SPEED:
        return f"{missing} in proportion to speed, at {significant(curve.at, 2)} {units('rad/s')}"
    return f"{missing} along the motion" if how == BY_DIRECTION else missing


def best_of_each(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """The curve that orders best along each variable, those without bins left out."""
    found: dict[str, Curve] = {}
    for curve in sorted(curves, key=lambda c: -c.order):
        if len(curve.x) and np.isfinite(curve.missing_torque).any():
            found.setdefault(variable(curve), curve)
    return tuple(found.values())


def reach_of(curves: Sequence[Curve]) -> float:
    """A common scale of curves [Nm]: how far means and spreads go, rare bins left out."""
    reaches = [np.abs(_seen(c, c.missing_torque)) + _seen(c, c.spread) for c in curves]
    return ROOM * max((float(np.nanmax(r)) for r in reaches if np.isfinite(r).any()), default=1.0) or 1.0


def _seen(curve: Curve, values: Array) -> Array:
    """Values of the bins that hold anything to speak of."""
    return np.where(curve.count >= 0.01 * curve.count.max(initial=0.0), values, np.nan)


def draw_curve(
    axes: Axes, curve: Curve, units: Units = str, names: Sequence[str] = (), reach: float | None = None
) -> None:
    """Mean and spread of the missing torque in bins. names : of the records; reach : of the ordinate."""
    unit = f" [{units(curve.unit)}]" if curve.unit not in ("", "1") else ""
    known = np.isfinite(curve.missing_torque)
    x, mean, spread = curve.x[known], curve.missing_torque[known], curve.spread[known]
    if curve.along.startswith("record"):
        axes.errorbar(x, mean, spread, fmt="o", color=BLUE, markersize=5, capsize=3, linewidth=1.2)
        axes.set_xlim(x.min() - 0.5, x.max() + 0.5)
        axes.set_xticks(x, [names[int(k)] if int(k) < len(names) else str(int(k)) for k in x])
    elif curve.along == "frequency":
        axes.semilogx(x, mean, "o-", color=BLUE, markersize=3, linewidth=1.4)
        axes.set_ylim(bottom=0.0)
        write_out_ticks(axes.xaxis)
    else:
        axes.fill_between(x, mean - spread, mean + spread, color=BLUE, alpha=0.18, linewidth=0)
        axes.plot(x, mean, "o-", color=BLUE, markersize=2.6, linewidth=1.4)
        axes.xaxis.set_major_locator(MaxNLocator(6))
    if reach is not None and curve.along != "frequency":
        axes.set_ylim(-reach, reach)
    axes.axhline(0.0, color=INK, linewidth=0.6)
    what, torque = variable(curve, units), counted(curve, units).replace(" in proportion", "\nin proportion")
    orders = f": orders {percent(curve.order, 0)} %" if curve.along != "frequency" else ""
    style_axes(axes, f"{what}{unit}", f"{torque} [{units('Nm')}]", f"{what}{orders}")


def draw_shape(axes: Axes, curve: Curve, units: Units = str, names: Sequence[str] = ()) -> None:
    """The missing torque that no known effect explains."""
    draw_curve(axes, curve, units, names)
    for line in axes.get_lines()[:1]:
        line.set_color(VERMILLION)
    title = f"unknown: {axis_label('missing torque', units)} along {variable(curve, units)}"
    axes.set_title(title, fontsize=10, loc="left", color=INK)
