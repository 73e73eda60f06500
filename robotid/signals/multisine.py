"""Multisines: sums of harmonically related sines, their phases random or chosen for a small crest factor.

The crest factor is the ratio of the L-infinity to the L-2 norm. Its numerator is approached through L-p norms of
growing p, each minimised from where the one before ended (Guillaume, Schoukens, Pintelon & Kollar 1991), here by a
quasi-Newton method whose gradient costs one Fourier transform.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len
from scipy.optimize import minimize

from robotid.model.array import Array

Lines = Sequence[int] | NDArray[np.integer[Any]]
"""Whole multiples of 1 / period, ascending."""

EXPONENTS = (4, 8, 16, 32, 64, 128, 256)  # p of the norms
ITERATIONS = 100  # of each
DENSITY = 12  # points a period of the highest sine, at which the norms are taken
OVERSAMPLING = 4  # of the sampled signal, at which the crest factor is judged
ATTEMPTS = 6  # starts, until the crest factor is small enough


def multisine(lines: Lines, amplitudes: Array, phases: Array, samples: int) -> Array:
    """One period of sum_k amplitudes_k cos(2 pi lines_k i / samples + phases_k), (samples,).

    lines (k,) : below samples / 2.
    """
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    spectrum[np.asarray(lines, dtype=int)] = 0.5 * samples * amplitudes * np.exp(1j * phases)
    return np.fft.irfft(spectrum, samples)


def crest_factor(u: Array) -> float:
    """Peak over RMS of one period. u : (n,) -> float. Schroeder 1970, eq. (2)."""
    return float(np.abs(u).max() / np.sqrt(np.mean(u**2)))


def judged_crest_factor(lines: Lines, amplitudes: Array, phases: Array, samples: int) -> float:
    """Crest factor between the samples too."""
    return crest_factor(multisine(lines, amplitudes, phases, OVERSAMPLING * samples))


def random_phases(count: int, rng: np.random.Generator) -> Array:
    """Independent phases [rad], uniform over the circle, (count,)."""
    return rng.uniform(0.0, 2 * np.pi, count)


def low_crest_phases(lines: Lines, amplitudes: Array, samples: int, target: float, rng: np.random.Generator) -> Array:
    """Phases [rad] (k,) of a small crest factor, judged on `samples` a period. The best of several random starts, the
    first of which to reach the target ends the search."""
    best, smallest = np.zeros(len(lines)), np.inf
    for _ in range(ATTEMPTS):
        phases = _minimise(np.asarray(lines, dtype=int), amplitudes, random_phases(len(lines), rng))
        reached = judged_crest_factor(lines, amplitudes, phases, samples)
        if reached < smallest:
            best, smallest = phases, reached
        if smallest <= target:
            break
    return best


def _minimise(lines: NDArray[np.intp], amplitudes: Array, phases: Array) -> Array:
    samples = next_fast_len(DENSITY * int(lines[-1]), real=True)
    for p in EXPONENTS:
        arguments = (lines, amplitudes, samples, p)
        phases = minimize(_log_norm, phases, arguments, "L-BFGS-B", jac=True, options={"maxiter": ITERATIONS}).x
    return phases


def _log_norm(phases: Array, lines: Lines, amplitudes: Array, samples: int, p: int) -> tuple[float, Array]:
    """log of the L-p norm, and its gradient to the phases (k,)."""
    u = multisine(lines, amplitudes, phases, samples)
    peak = np.abs(u).max()
    scaled = u / peak  # or the powers overflow
    power = np.mean(scaled**p)
    weight = scaled ** (p - 1) / (power * peak * samples)
    gradient = amplitudes * np.imag(np.exp(-1j * phases) * np.fft.rfft(weight)[np.asarray(lines, dtype=int)])
    return float(np.log(power) / p + np.log(peak)), gradient
