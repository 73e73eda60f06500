"""Multisines for several axes at once whose experiments tell the axes apart at every frequency.

As many experiments as axes: the phases of an axis are random, and from one experiment to the next they advance by a
step of its own, so that at every line the matrix of amplitudes, axes by experiments, is a random diagonal matrix times
the matrix of a discrete Fourier transform. Its columns are orthogonal, and all axes move with all their power all the
time (Dobrowiecki, Schoukens & Guillaume 2006, IEEE Trans. Instrum. Meas. 55(5); Wernholt & Moberg 2008, IFAC World
Congress). Two axes have Hadamard's matrix: the second one turns its sign in the second experiment.
"""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array


def advanced(phases: Array, axis: int, axes: int, experiment: int) -> Array:
    """The phases [rad] of an axis, counted from 0, in one of the experiments, counted from 0; every `axes` experiments
    they repeat, and phases drawn anew are due. phases (k,) : those of the first experiment."""
    return np.asarray(phases + 2.0 * np.pi * (axis * experiment % axes) / axes)


def orthogonal_phases(axes: int, count: int, rng: np.random.Generator) -> Array:
    """Random phases [rad] at `count` lines, (experiments, axes, count), as many experiments as axes."""
    random = rng.uniform(0.0, 2.0 * np.pi, (axes, count))
    return np.array([[advanced(random[k], k, axes, e) for k in range(axes)] for e in range(axes)])
