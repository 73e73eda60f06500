"""Every effect of the catalogue in a whole simulation: it converges, and its sensitivities are those of differences."""

from __future__ import annotations

import numpy as np
import pytest
from paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.channels import CHANNELS
from robotid.model.structure import Structure
from robotid.model.term import Bend
from robotid.signals.record import Record
from robotid.simulate.assemble import assemble
from robotid.simulate.simulate import sensitivities, simulate
from robotid.terms import TERMS

PLACES = [f"{port}.{term.name}" for term in TERMS.values() for port in term.ports]
PLACES += [f"torque.{c.name}" for c in CHANNELS.values() if "torque" in c.signals]
N = 1500
T = np.arange(N) * SAMPLING_TIME
U = 2.0 * np.sin(2 * np.pi * 4 * T) + 0.5 * np.sin(2 * np.pi * 11 * T + 1)
RECORD = Record("r", "estimate", "both", SAMPLING_TIME, U, 0 * U, 0 * U)


def lively(name: str, guess: float, upper: float) -> float:
    """A value at which a parameter shows, off the kinks that a delay has at whole samples."""
    typical = {
        "Jb": 100.0,
        "J": 100.0,
        "k1": 1e6,
        "d": 1e3,
        "k3": 1e10,
        "Td": 1.3e-3,
        "xs": 2e-5,
        "gap": 2e-5,
        "w": 0.7,
    }
    amplitude = 10.0 if name.startswith("arm.") and name[-2:] in (".A", ".B") else 0.0
    return typical.get(name.rsplit(".", 1)[-1]) or amplitude or guess or min(0.1, upper)


def structure_with(effect: str) -> Structure:
    """The paper's joint with one effect more, and what that one needs to show."""
    port, name = effect.split(".")
    structure, needed = STRUCTURE.extended(effect), []
    if port in ("link", "tool") and name != "third_mass":
        needed = ["link.spring", "link.damper", "tool.inertia"]
    term = TERMS.get(name)
    if port in ("arm", "tool") and (isinstance(term, Bend) or getattr(term, "reads", None)):
        needed.append(f"{port}.coulomb")
    for effect in needed:
        structure = structure if effect in structure.terms else structure.extended(effect)
    return structure


@pytest.mark.parametrize("effect", [p for p in PLACES if p not in STRUCTURE.terms])
def test_simulates_with_exact_sensitivities(effect: str) -> None:
    structure = structure_with(effect)
    joint = assemble(structure)
    declared = joint.parameters()
    values = {
        n: TRUTH.get(n, lively(n, v, hi)) for n, v, hi in zip(joint.names, declared.values, declared.upper, strict=True)
    }
    theta = declared.with_values(values).values
    trajectory = simulate(joint, theta, RECORD, x0=np.zeros(joint.nx))
    assert trajectory.rescued == ()
    columns = [k for k, name in enumerate(joint.names) if name.startswith(effect)]
    row = joint.speeds.start
    exact = sensitivities(trajectory, RECORD, columns, (row,))[0]
    for k, column in zip(columns, exact, strict=True):
        step = np.zeros(len(theta))
        step[k] = 1e-5 * abs(theta[k])
        plus, minus = (
            simulate(joint, theta + s * step, RECORD, np.zeros(joint.nx), trajectory.x).dphi_m for s in (1, -1)
        )
        expected = (plus - minus) / (2 * step[k])
        assert np.abs(expected).max() > 0
        assert column == pytest.approx(expected, abs=2e-4 * np.abs(expected).max())
