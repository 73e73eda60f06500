"""Every effect of the catalogue in a whole simulation: it converges, and its sensitivities are those of differences."""

from __future__ import annotations

import numpy as np
import pytest
from support.extended_joint import TERMS_IN_PLACE, TORQUE_CHANNELS, open_loop, structure_with, values
from support.paper_joint import STRUCTURE

from robotid.catalogue import assemble
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.simulate import simulate

RECORD = open_loop(1500)


@pytest.mark.parametrize("effect", [p for p in (*TERMS_IN_PLACE, *TORQUE_CHANNELS) if p not in STRUCTURE.terms])
def test_simulates_with_exact_sensitivities(effect: str) -> None:
    joint = assemble(structure_with(effect))
    theta, start = values(joint), np.zeros(joint.nx)
    trajectory = simulate(joint, theta, RECORD, x0=start)
    assert trajectory.fallback_windows == ()
    columns = [k for k, name in enumerate(joint.names) if name.startswith(effect)]
    exact = sensitivities(trajectory, RECORD, columns, (joint.motor_speed,))[0]
    for k, column in zip(columns, exact, strict=True):
        step = 1e-5 * abs(theta[k]) * (np.arange(len(theta)) == k)
        plus, minus = (simulate(joint, theta + s * step, RECORD, start, trajectory.x).dphi_m for s in (1, -1))
        expected = (plus - minus) / (2 * step[k])
        assert np.abs(expected).max() > 0
        assert column == pytest.approx(expected, abs=2e-4 * np.abs(expected).max())
