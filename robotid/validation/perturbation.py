"""What each parameter is worth to the fit: Table 3 of the paper."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.estimate.residual import measured_output, observed
from robotid.model.array import Array
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Record
from robotid.signals.stretches import stretches_at
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory
from robotid.validation.results import Perturbation

LARGEST_PREDICTION = 5_000_000  # derivatives in memory at once, to predict the perturbed motion
PERTURBED = 500_000  # samples of a piece: as good a mean over the motion as more, at two simulations a parameter

NOT_PERTURBED = Perturbation(0.0, (), np.zeros(0), np.zeros(0))


def perturb(model: FittedModel, simulated: Simulated, percent: float) -> Perturbation:
    """Perturb each parameter by percent of its value on a simulated record, on stretches of a piece that is longer than
    PERTURBED."""
    parts = [part for pair in zip(simulated.pieces, simulated.trajectories, strict=True) for part in _parts(*pair)]
    y = np.concatenate([measured_output(piece, model.output) for piece, _ in parts])
    columns = [int(k) for k in np.flatnonzero(model.theta)]
    steps = percent / 100 * model.theta[columns]
    squares = np.zeros((2, len(columns)))
    for piece, trajectory in parts:
        squares += _squares(model, piece, trajectory, columns, steps)
    spread = float(np.linalg.norm(y - y.mean()))
    fits = 100 * (1 - np.sqrt(squares) / spread) if spread > 0 else np.zeros_like(squares)
    plus, minus = fits - fit_percent(y, np.concatenate([observed(t, model.output) for _, t in parts]))
    return Perturbation(percent, tuple(model.joint.names[k] for k in columns), plus, minus)


def _parts(piece: Record, trajectory: Trajectory) -> Iterator[tuple[Record, Trajectory]]:
    """A piece with its motion whole, or stretches of a long one."""
    if len(piece) <= PERTURBED:
        yield piece, trajectory
        return
    for at in stretches_at(piece, PERTURBED):
        yield piece.piece(at.start, at.stop), trajectory.part(at)


def _squares(model: FittedModel, piece: Record, trajectory: Trajectory, columns: Sequence[int], steps: Array) -> Array:
    """Sum of squared output errors with each parameter raised and lowered, (2, p)."""
    y = measured_output(piece, model.output)
    squares = np.empty((2, len(columns)))
    for k, step, slope in zip(range(len(columns)), steps, _slopes(trajectory, piece, columns), strict=True):
        for sign, side in ((1.0, 0), (-1.0, 1)):
            theta = model.theta.copy()
            theta[columns[k]] += sign * step
            try:
                after = simulate(model.joint, theta, piece, trajectory.x[:, 0], trajectory.x + sign * step * slope)
                squares[side, k] = np.sum((y - observed(after, model.output)) ** 2)
            except NumericsError:
                squares[side, k] = np.nan
    return squares


def _slopes(trajectory: Trajectory, piece: Record, columns: Sequence[int]) -> Iterator[Array | float]:
    """Derivative of all states to each parameter (nx, n), that tells where to look for the perturbed motion.

    Zero for a piece too long to hold it.
    """
    nx = trajectory.joint.nx
    if nx * len(columns) * len(piece) > LARGEST_PREDICTION:
        yield from (0.0 for _ in columns)
    else:
        every = sensitivities(trajectory, piece, columns, range(nx))
        yield from (every[:, k] for k in range(len(columns)))
