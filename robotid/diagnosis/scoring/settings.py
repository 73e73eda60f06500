"""Tuning constants of the score."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ScoringSettings:
    """Which columns count, and which shapes are tried beside the grids."""

    dependent: float = 1e-5  # of a column's length left after projection: less is rounding
    negligible: float = 1e-10  # relative singular value of the saturated regression, the square of a column's share
    confounded: float = 0.7  # correlation from which an effect's answer counts as much like another's
    blocks: int = 40  # of time, into which all records are cut: enough for a deviation to a ninth of itself
    period_peaks: int = 3  # of the misfit's spectrum over an angle, the highest and the most prominent
    bins_a_period: int = 16  # of the shortest period of the grid: a wave loses a hundredth of its height
    zero_padding: int = 4  # points of the spectrum in its resolution: a peak is found to an eighth of it
    peak_shift: int = 1  # points of the spectrum by which what the fit has taken may shift a high peak
    max_spectrum_points: int = 2**21  # of the spectrum over an angle: 16 MB; longer motions are left to the grid
    peak_surroundings: int = 101  # points of the spectrum that a prominent peak must stand out from
    resonance_peaks: int = 2  # of the response's gain that are tried, the highest
    resonance_points: int = 200  # of frequency over the range of the grid, a few per cent apart
    resonance_range: float = 2.0  # times the grid's highest frequency: above it the effect no longer moves


SCORING = ScoringSettings()
