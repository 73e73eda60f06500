"""The torque that a model misses: what, added to the recorded one, would make it move as was measured.

Found by smoothing: among all torques that leave no more than noise between simulated and measured output, the one that
changes least from sample to sample. Linearised about the measured motion, and again about the smoothed one, so that a
model whose reversals come at the wrong time does no harm. How much it may change is what makes the record most likely.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.diagnosis.misfit.settings import MISFIT
from robotid.diagnosis.misfit.smoother import Chain, Smoothed
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.model.array import Array, blocks
from robotid.model.derivatives import DerivativeColumns
from robotid.signals.derivation import Derivation
from robotid.signals.record import Quantity, Record
from robotid.simulation.first_guess import follow_motor, measured_guess
from robotid.simulation.newton.problem import Problem
from robotid.simulation.trajectory import BLOCK, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class MissingTorque:
    """The torque that a model misses on a segment: torque (n,) [Nm] at the motor, with which it moves as x (nx, n).

    Where friction locks the motor no torque is seen, and it is interpolated.
    """

    segment: SimulatedSegment
    torque: Array
    x: Array


def missing_torque(
    segment: SimulatedSegment, output: Quantity, output_noise: float, torque_noise: float = 0.0
) -> MissingTorque:
    """What the motor torque lacks on a segment.

    It is signed as an applied torque: friction that the model lacks is a torque against the motion. output_noise,
    torque_noise [Nm] : standard deviations of the noise of the output and of the recorded torque, which are not to be
    taken for missing. Raises NumericsError where no motion follows the measured one.
    """
    trajectory, record, residual = segment.trajectory, segment.record, segment.residual
    row, derivation = trajectory.joint.output_row(output), Derivation.of(record)
    if derivation is not None and output == "speed" and trajectory.joint.keeps_angle:
        # the speed lacks what a difference smooths away, and its noise is blue: the angle has neither fault
        row, residual = trajectory.joint.motor_angle, derivation.centred_angle(residual)
        output_noise /= float(np.sqrt(derivation.gain))
    y, size = trajectory.x[row] + residual, float(np.abs(trajectory.u).max()) or 1.0
    moved, nothing = _as_measured(trajectory, record), np.zeros(len(y))
    spread = np.maximum(np.abs(moved).max(axis=1), 1e-9)

    def smooth(x: Array, w: Array, powers: Array) -> tuple[float, Smoothed]:
        linear = _linearised(trajectory, x, w)
        chain = Chain(
            *linear,
            y,
            row,
            max(output_noise, MISFIT.least_noise * spread[row]),
            torque_noise,
            x[:, 0].copy(),
            spread,
            size,
        )
        power = _likeliest(chain, powers)
        return power, chain.smooth(size * 10**power)

    small = float(np.std(residual)) < MISFIT.small_residual * output_noise
    tried = [
        smooth(x, nothing, np.array(MISFIT.coarse_powers))
        for x in ((trajectory.x,) if small else (trajectory.x, moved))
    ]
    for _ in range(0 if small else MISFIT.max_sweeps):
        power, last = max(tried, key=_evidence)
        tried.append(smooth(last.x, last.w, power + np.array(MISFIT.fine_powers)))
        if _evidence(tried[-1]) < _finite(last.evidence) + MISFIT.telling_evidence:
            break
    best = max(tried, key=_evidence)[1]
    if not np.isfinite(best.evidence):
        raise NumericsError(f"no torque makes the model follow {record.name}", hint="check the parameters")
    return MissingTorque(segment, best.w, best.x)


def _evidence(tried: tuple[float, Smoothed]) -> float:
    return _finite(tried[1].evidence)


def _finite(evidence: float) -> float:
    return evidence if np.isfinite(evidence) else -np.inf


def _as_measured(trajectory: Trajectory, record: Record) -> Array:
    """The motor moving as measured, and driving the rest, (nx, n)."""
    joint, theta = trajectory.joint, trajectory.theta
    x = measured_guess(joint, theta, record)
    u = trajectory.u[:-1]
    return follow_motor(Problem(joint, theta, u, trajectory.sampling_time, x, begin=trajectory.begin), x[:, 0])


def _linearised(trajectory: Trajectory, x: Array, w: Array) -> tuple[Array, Array, Array]:
    """Steps about states x (nx, n) under additional torque w (n,): G (nx, nx, n - 1), g and b (nx, n - 1)."""
    joint, n = trajectory.joint, x.shape[1]
    moved = replace(trajectory, u=trajectory.u + w, x=x)
    G, g, b = np.empty((joint.nx, joint.nx, n - 1)), np.empty((joint.nx, n - 1)), np.empty((joint.nx, n - 1))
    for at in blocks(n - 1, BLOCK):
        x0, x1 = x[:, at], x[:, at.start + 1 : at.stop + 1]
        steps = moved.linearise(at, DerivativeColumns())
        assert steps.S is not None
        G[:, :, at], b[:, at] = steps.G, steps.S[:, -1]
        g[:, at] = x1 + steps.c - np.einsum("ijn,jn->in", steps.G, x0) - b[:, at] * w[at]
    return G, g, b


def _likeliest(chain: Chain, powers: Array) -> float:
    """The power of ten at which the evidence is largest, between evenly spaced ones."""
    excerpt = chain.excerpt()
    evidence = [_finite(excerpt.smooth(chain.size * 10**power).evidence) for power in powers]
    best = int(np.clip(np.argmax(evidence), 1, len(powers) - 2))
    low, middle, high = evidence[best - 1 : best + 2]
    curvature = low - 2 * middle + high
    shift = 0.5 * (low - high) / curvature if -np.inf < curvature < 0 else np.sign(np.argmax([low, middle, high]) - 1.0)
    return float(powers[best] + np.clip(shift, -1.0, 1.0) * (powers[1] - powers[0]))
