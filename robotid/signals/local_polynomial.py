"""Local polynomial method: a frequency response from one stretch of data, its transient and its error.

Around each line the response and the transient (what start and end of the stretch leak into the lines) are smooth, so
both are polynomials there, and the spectra are linear in the coefficients (Pintelon, Schoukens, Vandersteen & Barbe
2010).
"""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array, Complex, Index

ORDER = 2
HALF_WIDTH = 5  # lines to either side: eleven lines for six unknowns


def local_response(
    torque: Complex,
    output: Complex,
    instrument: Complex,
    at: Index,
    band: tuple[int, int],
    spacing: int = 1,
) -> tuple[Complex, Array]:
    """Response from torque to output at some lines, by way of the instrument, and the standard deviation of its error.

    torque, output, instrument (lines,) : spectra; at (k,) : where; band : first and last line to use, more where
    they are too few; spacing : lines from one that is excited to the next. Returns (k,), (k,).
    """
    half = HALF_WIDTH * spacing
    width = min(2 * half + 1, len(torque))
    lowest = max(0, min(band[0], len(torque) - width))
    highest = max(band[1], lowest + width - 1)
    response, std = np.empty(len(at), dtype=np.complex128), np.empty(len(at))
    for i, line in enumerate(at):
        first = min(max(line - half, lowest), highest + 1 - width)
        near = slice(first, first + width)
        x = (np.arange(first, first + width) - line) / half
        response[i], std[i] = _at_centre(x, torque[near], output[near], instrument[near])
    return response, std


def _at_centre(x: Array, torque: Complex, output: Complex, instrument: Complex) -> tuple[complex, float]:
    powers = x ** np.arange(ORDER + 1)[:, None]
    regressor = np.vstack([powers * instrument, powers]).T
    scale = np.maximum(np.linalg.norm(regressor, axis=0), np.finfo(np.float64).tiny)
    both = np.array([torque, output]).T
    inverse = np.linalg.pinv(regressor / scale) / scale[:, None]
    coefficients = inverse @ both
    to_torque, to_output = coefficients[0]
    ratio = complex(to_output / to_torque)
    residual = both - regressor @ coefficients
    error = residual[:, 1] - ratio * residual[:, 0]
    spare = max(1, len(x) - regressor.shape[1])
    gain = np.linalg.norm(inverse[0]) / abs(to_torque)
    return ratio, float(np.linalg.norm(error) / np.sqrt(spare) * gain)
