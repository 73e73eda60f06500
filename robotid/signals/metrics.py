"""How far one signal is from another."""

from __future__ import annotations

import numpy as np

from robotid.model.array import Array


def fit_percent(measured: Array, simulated: Array) -> float:
    """100 (1 - ||y - yhat|| / ||y - mean y||) [%]; zero where nothing varies. Both (n,).

    Wernholt & Gunnarsson 2005, eq. (15).
    """
    spread = float(np.linalg.norm(measured - measured.mean()))
    return 100 * (1 - float(np.linalg.norm(measured - simulated)) / spread) if spread > 0 else 0.0


def rmse(measured: Array, simulated: Array) -> float:
    """Root mean square of the difference, in the signals' unit."""
    return float(np.sqrt(np.mean((measured - simulated) ** 2)))


def error_percent(measured: Array, simulated: Array) -> float:
    """100 ||y - yhat|| / ||y|| [%]; zero for a signal that is zero throughout."""
    size = float(np.linalg.norm(measured))
    return 100 * float(np.linalg.norm(measured - simulated)) / size if size > 0 else 0.0
