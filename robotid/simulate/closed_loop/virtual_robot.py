"""The virtual robot: a joint under its controller, as its encoder and its noisy sensors show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulate.closed_loop.controller import Controller
from robotid.simulate.closed_loop.loop import ClosedLoop, quantise, run_closed_loop
from robotid.simulate.sensors import shown


@dataclass(frozen=True, slots=True, eq=False)
class Plant:
    """A joint that keeps its angle, with its truth theta (p,), controller, encoder and sensors.

    quantum [rad] of the encoder, zero for a perfect one; torque_noise [Nm], white, on the recorded torque; speed_noise
    [rad/s], white, on the measured speed, which the controller sees too.
    """

    joint: Joint
    theta: Array
    controller: Controller
    quantum: float = 0.0
    torque_noise: float = 0.0
    speed_noise: float = 0.0
    seed: int = 0

    def record(self, reference: Reference, number: int) -> Record:
        """The motion that a reference causes from rest, as recorded. number : of the record, for its own noise."""
        rng = np.random.default_rng([self.seed, number])
        n = len(reference.ref)
        noise = self.speed_noise * rng.standard_normal(n)
        x, torque = follow(self.joint, self.theta, self.controller, reference, noise, self.quantum)
        start = self.joint.speeds.start
        phi_m, dphi_m = shown(self.joint, self.theta, reference.sampling_time, x[start - 1], x[start])
        return Record(
            name=reference.name,
            role="estimate",
            use="both",
            sampling_time=reference.sampling_time,
            tau_m=torque + self.torque_noise * rng.standard_normal(n),
            phi_m=quantise(phi_m, self.quantum),
            dphi_m=dphi_m + noise,
            ref=reference.ref,
            ref_kind=reference.kind,
            period=reference.period,
            band=reference.band,
        )


def follow(
    joint: Joint,
    theta: Array,
    controller: Controller,
    reference: Reference,
    speed_noise: Array | None = None,
    quantum: float = 0.0,
    x0: Array | None = None,
) -> tuple[Array, Array]:
    """Motion under a controller. speed_noise (n,) -> states x (nx, n) of the joint, torque command (n,)."""
    ref, h, n = reference.ref, reference.sampling_time, len(reference.ref)
    noise = np.zeros(n) if speed_noise is None else speed_noise
    if x0 is None:
        x0 = np.zeros(joint.nx)
        x0[joint.speeds.start - 1] = ref[0] if reference.kind == "position" else 0.0
    loop = ClosedLoop(joint, theta, np.zeros(n - 1), h, _guess(joint, reference), controller, ref, noise, quantum)
    x = run_closed_loop(loop, x0)
    return x[:-1], loop.command


def _guess(joint: Joint, reference: Reference) -> Array:
    """The reference followed to the letter, all parts rigid, (nx + 1, n)."""
    ref, h = reference.ref, reference.sampling_time
    speed = np.gradient(ref, h) if reference.kind == "position" else ref
    guess = np.zeros((joint.nx + 1, len(ref)))
    start = joint.speeds.start
    guess[start - 1] = ref if reference.kind == "position" else np.cumsum(ref) * h
    guess[start] = speed
    guess[start + 1 : joint.speeds.stop] = joint.ratio * speed
    return guess
