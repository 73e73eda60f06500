"""How an error of the recorded torque shows in the output of a simulated joint.

Where a speed is derived from an angle, noise of the sensor and of the torque pass the same difference: the response is
then that of the angle, and the derivation stands beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.covariance import zero_order_hold_response
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.derivation import Derivation
from robotid.signals.record import Quantity
from robotid.simulation.newton.block_bidiagonal import solve_block_bidiagonal

WELL_APART = 1e8  # condition of the modes up to which half of the digits are left
FASTEST = np.e  # growth within a sampling time of what a sampled controller could still have held
LINES = 4096  # frequencies whose matrices are in memory at once


@dataclass(frozen=True, slots=True, eq=False)
class TorqueResponse:
    """x[n + 1] = A x[n] + b u[n], y[n] = x[row, n]: the joint about to slip, its springs at rest, a torque u held.

    A (d, d), b (d,); sampling_time [s]; derivation : by which a speed comes from y, which is the angle; None where the
    output is y itself; share : of the time in which the joint slips, by which noise shows less power.
    """

    A: Array
    b: Array
    row: int
    sampling_time: float
    derivation: Derivation | None = None
    share: float = 1.0

    def some_of_the_time(self, share: float) -> TorqueResponse:
        """That of a joint which slips during a share of the time only."""
        return replace(self, b=np.sqrt(share) * self.b, share=share * self.share)

    def impulse(self, n: int) -> Array:
        """What a torque of one in the first of n samples leaves in y, (n,)."""
        columns = np.zeros((len(self.b), 1, n))
        columns[:, 0, 1:2] = self.b[:, None]
        return np.asarray(solve_block_bidiagonal(self.A[:, :, None], columns)[self.row, 0])

    def to_torques(self, torques: Array) -> Array:
        """What torques (k, n) leave in the output, (k, n)."""
        n = torques.shape[1]
        spectra = np.fft.rfft(torques, 2 * n, axis=1) * np.fft.rfft(self.impulse(n), 2 * n)
        found = np.fft.irfft(spectra, 2 * n, axis=1)[:, :n]
        return found if self.derivation is None else self.derivation.speed(found)

    def squared(self, omega: Array) -> Array:
        """Squared magnitude from the torque to y. omega (n,) [rad per sample], none zero -> (n,).

        By the modes where these are well apart, else frequency by frequency.
        """
        z = np.exp(1j * np.asarray(omega))
        poles, modes = np.linalg.eig(self.A)
        if np.linalg.cond(modes) < WELL_APART:
            weights = modes[self.row] * np.linalg.solve(modes, self.b)
            found = np.zeros(len(z), dtype=np.complex128)
            for pole, weight in zip(poles, weights, strict=True):
                found += weight / (z - pole)
            return np.asarray(np.abs(found) ** 2)
        eye, columns = np.eye(len(self.b)), self.b[:, None]
        parts = [
            np.linalg.solve(part[:, None, None] * eye - self.A, columns)[:, self.row, 0]
            for part in np.array_split(z, len(z) // LINES + 1)
        ]
        return np.asarray(np.abs(np.concatenate(parts)) ** 2)


def torque_response(
    joint: Joint, theta: Array, sampling_time: float, output: Quantity, derivation: Derivation | None = None
) -> TorqueResponse:
    """The response of a joint's speed or position. theta : (p,) as the record has them; derivation : of the record's
    speed, None where that was measured.

    Raises NumericsError where the joint runs away within a sampling time.
    """
    A, b = zero_order_hold_response(joint, theta, sampling_time)
    finite = np.isfinite(A).all() and np.isfinite(b).all()
    if not finite or np.abs(np.linalg.eigvals(A)).max() > FASTEST:
        raise NumericsError(
            "the joint runs away within a sampling time", hint="`robotid check` examines the records it was fitted to"
        )
    derived = derivation is not None and output == "speed"
    row = joint.motor_angle if derived and joint.keeps_angle else joint.output_row(output)
    kept = [k for k in range(joint.speeds.stop) if k == row or not (joint.keeps_angle and k == joint.motor_angle)]
    A, b, row = A[np.ix_(kept, kept)], b[kept], kept.index(row)
    if derived and not joint.keeps_angle:
        A, b, row = *_with_angle(A, b, row, sampling_time), 0
    return TorqueResponse(A, b, row, sampling_time, derivation if derived else None)


def _with_angle(A: Array, b: Array, speed: int, sampling_time: float) -> tuple[Array, Array]:
    """The same with the angle as a first state, which sums up the speed by trapezoids."""
    d, half = len(b), sampling_time / 2
    wider, longer = np.zeros((d + 1, d + 1)), np.append(half * b[speed], b)
    wider[0, 0], wider[0, 1:], wider[1:, 1:] = 1.0, half * A[speed], A
    wider[0, 1 + speed] += half
    return wider, longer
