"""Tuning constants of free curves."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class CurveSettings:
    """How fine free curves are, and how they are fitted."""

    edge_percent: float = 0.5  # per cent of the samples beyond the first and the last knot: a few that went far
    coarse_knots: int = 12  # of the curves that all variables are compared by
    fine_knots: tuple[int, ...] = (24, 48)  # of the finalists, as many as the residual asks for
    finalists: int = 2  # variables that are fitted finely
    faded_share: float = 0.03  # of a curve's energy: with less left of it, the fit may have taken the rest
    ridge: float = 1e-9  # of the energy of all curves, relative: keeps curves apart that no motion shows
    max_sweeps: int = 4  # of a curve that acts on the motion that it lies along
    settled_gain: float = 1e-3  # of what a curve explains: a sweep that gains less is the last
    likely_torque: float = 0.5  # of the recorded torque's RMS: as large as a missing torque is likely to be
    patience: int = 4  # windows that may fail to settle: a curve with more is no torque that exists
    max_iterations: int = 4  # of a refit with a curve: the next sweep goes on


CURVES = CurveSettings()
