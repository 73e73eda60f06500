"""What is taken off a torque before its response is read, and up to which frequency the response is the machine's."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.estimate.linear_response import fit_response, linear_part
from robotid.estimate.responses import nonlinear_torque, responses
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.frf import Frf
from robotid.signals.record import Record

H, COUNTS = 1e-3, 4096
TIME = np.arange(8000) * H
INERTIA, FRICTION, DAMPING = 0.01, 0.5, 0.1
JOINT = assemble(Structure(("motor.inertia", "motor.coulomb")))
PARAMETERS = JOINT.parameters().with_values({"motor.inertia.J": INERTIA, "motor.coulomb.Fc": FRICTION})


def motion() -> tuple[Array, Array]:
    """Angle and speed of sines of 1 to 6 Hz, with a rest of a second in the middle."""
    waves = [np.sin(2 * np.pi * f * TIME + f**2) / f for f in range(1, 7)]
    speed = 0.7 * np.sum(waves, axis=0) * np.clip(4 * np.abs(TIME - 4.0) - 2.0, 0.0, 1.0)
    return np.cumsum(speed) * H, speed


def coarse(angle: Array) -> Array:
    quantum = 2 * np.pi / COUNTS
    return np.asarray(quantum * np.floor(angle / quantum))


def record(torque: Array, angle: Array) -> Record:
    return Record("log", "estimate", "both", H, torque, angle, np.gradient(angle, H))


def test_the_noise_of_an_encoder_does_not_turn_dry_friction() -> None:
    angle, speed = motion()
    rests = speed == 0.0
    friction = np.where(rests, 0.3 * FRICTION, FRICTION * np.sign(speed))
    found = nonlinear_torque(JOINT, PARAMETERS, record(INERTIA * np.gradient(speed, H) + friction, coarse(angle)))
    assert np.sqrt(np.mean((found - friction) ** 2)) < 0.2 * FRICTION
    inside = np.flatnonzero(rests)[1:-1]
    assert found[inside] == pytest.approx(friction[inside])


def test_a_torque_that_a_controller_makes_of_noise_widens_no_band() -> None:
    angle, speed = motion()
    noisy = coarse(angle)
    controller = -DAMPING * np.gradient(noisy - angle, H)
    seen = responses(JOINT, PARAMETERS, [record(INERTIA * np.gradient(speed, H) + controller, noisy)])
    assert 6.0 < seen[0].frf.frequency[-1] < 25.0


def test_a_parameter_that_a_response_does_not_show_is_not_certain() -> None:
    joint = linear_part(
        assemble(Structure(("motor.inertia", "motor.viscous", "gear.spring", "arm.inertia"), gear_ratio=0.01))
    )
    slow = np.linspace(0.1, 1.0, 40)
    omega = 2j * np.pi * slow
    frf = Frf("slow", slow, np.full(40, 1 / 0.03) + 0.0 * omega, np.full(40, 0.1))
    start = {"motor.inertia.J": 1e-9, "motor.viscous.Fv": 0.0, "gear.spring.k1": 1e12, "arm.inertia.J": 300.0}
    fit = fit_response(joint, frf, {"motor.viscous.Fv": 0.0}, [start], (0.03, 1e-4))
    assert fit.values["motor.inertia.J"] < 1e-6
    assert fit.relative_std["motor.inertia.J"] > 1e3
    assert fit.relative_std["gear.spring.k1"] > 1e3
