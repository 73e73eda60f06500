"""Linearised joints against formulae of their own."""

from __future__ import annotations

import numpy as np
import pytest
from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble
from robotid.model.linear import channel_response, linearise
from robotid.model.structure import Structure

OMEGA = 2 * np.pi * np.geomspace(0.5, 80, 200)


def test_equation_13():
    joint = assemble(STRUCTURE)
    theta = joint.parameters().with_values(TRUTH | {"gear.damper.d": 0.0}).values
    jm, fv, _, k, _, _, ja = TRUTH.values()
    s = 1j * OMEGA
    expected = s * (ja * s**2 + k) / (s**3 * ja * jm + s**2 * ja * fv + s * k * (jm + RATIO**2 * ja) + k * fv)
    np.testing.assert_allclose(linearise(joint, theta).response(OMEGA), expected, rtol=1e-9)


def test_matrices_and_states_tell_the_same():
    joint = assemble(STRUCTURE)
    linear = linearise(joint, joint.parameters().with_values(TRUTH).values)
    s = 1j * OMEGA[:, None, None]
    q = np.linalg.solve(s**2 * linear.M + s * linear.D + linear.K, np.broadcast_to([[1.0], [0.0]], (len(OMEGA), 2, 1)))
    np.testing.assert_allclose(linear.speed_response(OMEGA), (s * q)[:, 0, 0], rtol=1e-8)
    k1 = TRUTH["gear.spring.k1"]
    np.testing.assert_allclose(linear.K, k1 * np.array([[RATIO**2, -RATIO], [-RATIO, 1.0]]))
    np.testing.assert_allclose(np.diag(linear.M), [TRUTH["motor.inertia.J"], TRUTH["arm.inertia.J"]])


def test_notch_of_two_masses():
    joint = assemble(STRUCTURE)
    theta = joint.parameters().with_values(TRUTH | {"gear.damper.d": 0.0}).values
    notch = np.sqrt(TRUTH["gear.spring.k1"] / TRUTH["arm.inertia.J"])
    near = np.abs(linearise(joint, theta).response(notch * np.array([0.999, 1.0, 1.001])))
    assert near[1] < 1e-6 * near[0] < near[2]


def test_stribeck_has_a_negative_slope_when_slow():
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.stribeck")))
    theta = joint.parameters().with_values(
        {"motor.viscous.Fv": 0.1, "motor.stribeck.dFs": 2.0, "motor.stribeck.vs": 1.0}
    )
    slope = 0.1 - 2 * 0.5 * 2.0 * np.exp(-(0.5**2))
    assert linearise(joint, theta.values, speed=0.5).D[0, 0] == pytest.approx(slope)
    assert linearise(joint, theta.values, speed=-0.5).D[0, 0] == pytest.approx(slope)
    assert linearise(joint, theta.values, speed=50.0).D[0, 0] == pytest.approx(0.1)


def test_channels_delay_and_lag():
    joint = assemble(Structure(("motor.inertia",), ("torque.torque_delay",)))
    theta = joint.parameters().with_values({"torque.torque_delay.Td": 3 * SAMPLING_TIME}).values
    np.testing.assert_allclose(
        channel_response(joint, theta, OMEGA, SAMPLING_TIME), np.exp(-3j * OMEGA * SAMPLING_TIME), rtol=1e-9
    )
    joint = assemble(Structure(("motor.inertia",), ("torque.torque_lag",)))
    theta = joint.parameters().with_values({"torque.torque_lag.T": 0.01}).values
    np.testing.assert_allclose(
        np.abs(channel_response(joint, theta, OMEGA, SAMPLING_TIME)), 1 / np.hypot(1, 0.01 * OMEGA), rtol=1e-2
    )


def test_third_mass_adds_a_second_resonance():
    joint = assemble(Structure((*STRUCTURE.terms, "link.third_mass"), gear_ratio=RATIO))
    theta = joint.parameters().with_values(TRUTH | {"link.third_mass.Jb": 300.0, "link.third_mass.wb": 70.0}).values
    level = np.abs(linearise(joint, theta).response(np.linspace(10, 250, 4000)))
    peaks = np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:]))
    assert len(peaks) == 2
