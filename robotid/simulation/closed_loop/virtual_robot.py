"""The virtual robot: a joint under its controller, as its encoder and its noisy sensors show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.loop import ControlledJoint, quantise
from robotid.simulation.sensors import sensor_signals


@dataclass(frozen=True, slots=True, eq=False)
class VirtualRobot(ControlledJoint):
    """A controlled joint whose theta is the truth, with the noise of its sensors.

    torque_noise [Nm] : standard deviation, white, on the recorded torque; speed_noise [rad/s] : likewise on the
    measured speed, which the controller sees too; seed : of all noise.
    """

    torque_noise: float = 0.0
    speed_noise: float = 0.0
    seed: int = 0

    def record(self, reference: Reference, number: int) -> Record:
        """The motion that a reference causes from rest, as recorded. number : of the record, for its own noise."""
        rng = np.random.default_rng([self.seed, number])
        noise = self.speed_noise * rng.standard_normal(len(reference.ref))
        x, torque = self.follow(reference, noise)
        return self.as_recorded(reference, x, torque, noise, rng)

    def as_recorded(
        self, reference: Reference, x: Array, torque: Array, speed_noise: Array, rng: np.random.Generator
    ) -> Record:
        """What a recorder keeps of a run: states x (nx, n), torque (n,), noise of the speed (n,); rng draws that of the
        torque."""
        phi_m, dphi_m = sensor_signals(self.joint, self.theta, reference.sampling_time, *x[self.joint.motor_states])
        return Record(
            name=reference.name,
            role="estimate",
            use="both",
            sampling_time=reference.sampling_time,
            tau_m=torque + self.torque_noise * rng.standard_normal(len(torque)),
            phi_m=quantise(phi_m, self.quantum),
            dphi_m=dphi_m + speed_noise,
            ref=reference.ref,
            ref_kind=reference.kind,
            period=reference.period,
            band=reference.band,
        )
