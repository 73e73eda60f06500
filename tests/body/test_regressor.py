from __future__ import annotations

import numpy as np
import pytest
from support import planar_arm

from robotid.body import pinocchio_model
from robotid.body.chain import Chain, DhRow, chain_of_rows
from robotid.body.consistent import body
from robotid.body.regressor import SLICE, own_inertia, torques

ROWS = (DhRow(a=planar_arm.LENGTH), DhRow(a=0.3))


def planar_chain(*, distal: bool = True) -> Chain:
    """The two links of `planar_arm`: both axes along z, gravity along -y."""
    rows = ROWS if distal else (DhRow(), DhRow(a=planar_arm.LENGTH))
    return chain_of_rows(("a1", "a2"), rows, distal, np.array([0.0, -planar_arm.GRAVITY, 0.0]))


def planar_links() -> np.ndarray:
    """Their inertial parameters, (20,); thin in the plane, and as long about z as Lagrange's equations have them."""
    found = []
    for link in (planar_arm.UPPER, planar_arm.LOWER):
        spread = np.diag([link.inertia / link.mass / 2, link.inertia / link.mass / 2, 0.01])
        found.append(body(link.mass, np.array([link.centre, 0.0, 0.0]), spread))
    return np.concatenate(found)


def random_chain(seed: int, *, distal: bool = True, count: int = 6) -> Chain:
    rng = np.random.default_rng(seed)
    rows = [DhRow(*rng.normal(size=4), sign=1 if rng.uniform() < 0.5 else -1) for _ in range(count)]
    return chain_of_rows([f"a{k}" for k in range(count)], rows, distal, rng.normal(size=3))


@pytest.mark.parametrize("distal", [True, False])
def test_two_links_in_a_plane_move_as_lagrange_says(distal: bool) -> None:
    q, dq, ddq = planar_arm.swing(1, np.linspace(0, 5, 200))
    expected = planar_arm.body_torque(q, dq, ddq)
    found = torques(planar_chain(distal=distal), planar_links(), q, dq, ddq)
    assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_the_own_inertia_is_the_diagonal_of_the_mass_matrix() -> None:
    q, _, _ = planar_arm.swing(2, np.linspace(0, 5, 50))
    expected = planar_arm.mass_matrix(q)
    for axis in range(2):
        assert own_inertia(planar_chain(), planar_links(), q, axis) == pytest.approx(expected[axis, axis], rel=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_no_power_is_lost_or_made(seed: int) -> None:
    """The work of the torques is the change of the kinetic energy, of which the mass matrix is half the curvature."""
    chain, rng = random_chain(seed).weightless, np.random.default_rng(seed)
    links = np.concatenate([body(1.0 + k, c, np.diag([0.1, 0.2, 0.3])) for k, c in enumerate(rng.normal(size=(6, 3)))])
    q, dq, ddq = rng.normal(size=(3, 6, 1))
    step = 1e-5

    def energy(at: float) -> float:
        angle, speed = q + at * dq + at**2 / 2 * ddq, dq + at * ddq
        return float(np.sum(speed * torques(chain, links, angle, np.zeros_like(q), speed)) / 2)

    power = float(np.sum(dq * torques(chain, links, q, dq, ddq)))
    assert power == pytest.approx((energy(step) - energy(-step)) / (2 * step), rel=1e-7)


def test_a_long_record_is_worked_on_in_slices() -> None:
    q, dq, ddq = planar_arm.swing(3, np.linspace(0, 5, SLICE + 7))
    found = torques(planar_chain(), planar_links(), q, dq, ddq)
    assert found[:, -1:] == pytest.approx(
        torques(planar_chain(), planar_links(), q[:, -1:], dq[:, -1:], ddq[:, -1:]), rel=1e-14
    )


@pytest.mark.skipif(not pinocchio_model.available(), reason="pinocchio (the extra `body`) is not installed")
@pytest.mark.parametrize("distal", [True, False])
@pytest.mark.parametrize("seed", range(4))
def test_torques_are_those_of_pinocchio(seed: int, distal: bool) -> None:
    assert pinocchio_model.difference(random_chain(seed, distal=distal)) < 1e-9
