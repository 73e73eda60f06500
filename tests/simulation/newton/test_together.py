"""Several records simulated at once move as each does alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH

from robotid.catalogue import assemble, with_effect
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.derivatives import DerivativeColumns
from robotid.model.joint import Joint
from robotid.signals.companion import Companion
from robotid.signals.record import Record
from robotid.simulation import simulate as simulating
from robotid.simulation.in_turns import beside_all
from robotid.simulation.newton import together
from robotid.simulation.simulate import Start, simulate, simulate_together, simulate_under
from robotid.simulation.trajectory import linearised_together, shared_dynamics

TORQUE = {"slow": (1.3, 2.0), "fast": (9.0, 3.0), "short": (4.0, 2.5)}  # [Hz], [Nm]
SAMPLES = {"slow": 900, "fast": 700, "short": 300}


def records() -> tuple[Record, ...]:
    made = []
    for name, (frequency, size) in TORQUE.items():
        t = np.arange(SAMPLES[name]) * SAMPLING_TIME
        u = size * np.sin(2 * np.pi * frequency * t)
        made.append(Record(name, "estimate", "sine", SAMPLING_TIME, u, 0 * u, 0 * u))
    return tuple(made)


def joint(*effects: str) -> tuple[Joint, Array]:
    structure = STRUCTURE
    for effect in effects:
        structure = structure.extended(effect)
    found = assemble(structure)
    truth = {name: value for name, value in TRUTH.items() if name in found.names}
    extra = {"gear.backlash.gap": 1e-5} if "gear.backlash" in effects else {}
    return found, found.parameters().with_values(truth | extra).values


@pytest.mark.parametrize("effects", [(), ("gear.backlash",)], ids=["friction", "backlash"])
@pytest.mark.parametrize("at_once", [together.AT_ONCE, 500], ids=["all", "some"])
def test_records_together_move_as_each_alone(
    effects: tuple[str, ...], at_once: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(together, "AT_ONCE", at_once)
    one, theta = joint(*effects)
    starts = [Start(np.zeros(one.nx)) for _ in records()]
    found = list(simulate_together(one, theta, records(), starts))
    for record, trajectory in zip(records(), found, strict=True):
        alone = simulate(one, theta, record, np.zeros(one.nx))
        size = np.abs(alone.x).max(axis=1, keepdims=True)
        assert np.all(np.abs(trajectory.x - alone.x) < 1e-5 * size)


def test_records_that_differ_in_their_sampling_time_go_together() -> None:
    one, theta = joint()
    slow, fast, _ = records()
    fast = replace(fast, sampling_time=2 * SAMPLING_TIME)
    found = list(simulate_together(one, theta, [slow, fast], [Start(np.zeros(one.nx))] * 2))
    alone = simulate(one, theta, fast, np.zeros(one.nx))
    assert found[1].x == pytest.approx(alone.x, abs=1e-5 * np.abs(alone.x).max())


def test_one_record_that_cannot_be_simulated_is_an_error_of_all() -> None:
    one, theta = joint()
    starts = [Start(np.zeros(one.nx)), Start(np.full(one.nx, np.nan)), Start(np.zeros(one.nx))]
    with pytest.raises(NumericsError, match="not finite"):
        list(simulate_together(one, theta, records(), starts))


def test_each_torque_of_a_record_moves_it_as_it_does_alone_and_one_that_cannot_be_is_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    one, theta = joint()
    record, start = records()[1], Start(np.zeros(one.nx))
    torques = [record.tau_m, np.full(len(record), np.nan), 0.5 * record.tau_m, 1.01 * record.tau_m]
    monkeypatch.setattr(simulating, "TOGETHER", 3 * len(record))
    first, never, *others = simulate_under(torques, one, theta, record, start)
    assert never is None
    for torque, found in zip((torques[0], *torques[2:]), (first, *others), strict=True):
        alone = simulate(one, theta, replace(record, tau_m=torque), start.x0)
        assert found is not None
        assert np.abs(found.x - alone.x).max() < 1e-5 * np.abs(alone.x).max()


def test_derivatives_together_are_those_of_each() -> None:
    one, theta = joint()
    found = list(simulate_together(one, theta, records(), [Start(np.zeros(one.nx))] * 3))
    wanted = DerivativeColumns((0, 1, 2), (0, 1))
    every = shared_dynamics(found)
    assert every is not None
    for trajectory, steps in zip(found, linearised_together(found, wanted, every), strict=True):
        alone = trajectory.linearise(slice(0, len(trajectory.u) - 1), wanted)
        assert steps.S is not None
        assert alone.S is not None
        assert np.allclose(steps.G, alone.G, rtol=1e-6, atol=1e-12)
        assert np.allclose(steps.S, alone.S, rtol=1e-6, atol=1e-9 * np.abs(alone.S).max())


def test_other_parameters_are_other_dynamics() -> None:
    one, theta = joint()
    first, other, _ = simulate_together(one, theta, records(), [Start(np.zeros(one.nx))] * 3)
    assert shared_dynamics([first, other]) is not None
    assert shared_dynamics([first, replace(other, theta=1.01 * theta)]) is None


def accompanied() -> tuple[Record, ...]:
    """Records that begin at other times, each with a motor angle and another axis of its own."""
    made = []
    for k, record in enumerate(records()):
        t = np.arange(len(record)) * SAMPLING_TIME
        swing = Companion.of(CompanionKind.ANGLE, np.sin(9.0 * t + k), SAMPLING_TIME)
        angle = 2.0 * np.sin(5.0 * t + 2.0 * k)
        made.append(replace(record, begin=3.7 * k, phi_m=angle, companions={"q2": swing}))
    return tuple(made)


def test_what_a_joint_does_not_read_keeps_no_records_apart() -> None:
    """As a disturbance that one of them was recorded with."""
    one, theta = joint()
    first, *others = accompanied()
    mixed = [one.along(record) for record in (replace(first, companions={}), *others)]
    assert len({id(other) for other in mixed}) == 3
    assert beside_all(mixed) is not None
    records = [replace(first, companions={}), *others]
    found = list(simulate_together(one, theta, records, [Start(np.zeros(one.nx))] * 3))
    assert shared_dynamics(found) is not None


BESIDE = {
    "follows": ("motor.cogging",),
    "reads": ("arm.pose_lever[q2]",),
    "warms up": ("motor.cogging", "motor.thermal_friction"),
}
VALUES = {"motor.cogging.A": 0.05, "arm.pose_lever[q2].A": 200.0, "motor.thermal_friction.c": -0.3}


@pytest.mark.parametrize("effects", BESIDE.values(), ids=BESIDE)
def test_records_that_a_joint_stands_beside_move_as_each_alone(effects: tuple[str, ...]) -> None:
    """Each by its own companion, at its own recorded angle, and in its own time."""
    structure = STRUCTURE
    for effect in effects:
        structure = with_effect(structure, effect)
    one = assemble(structure)
    values = {name: value for name, value in (TRUTH | VALUES).items() if name in one.names}
    theta = one.parameters().with_values(values).values
    assert one.depends_on_record
    starts = [Start(np.zeros(one.nx))] * 3
    found = list(simulate_together(one, theta, accompanied(), starts))
    for record, trajectory in zip(accompanied(), found, strict=True):
        alone = simulate(one, theta, record, np.zeros(one.nx))
        assert np.all(np.abs(trajectory.x - alone.x) < 1e-5 * np.abs(alone.x).max(axis=1, keepdims=True))
        np.testing.assert_array_equal(trajectory.t, record.t)
    every = shared_dynamics(found)
    assert every is not None
    wanted = DerivativeColumns(tuple(range(one.n_theta)))
    for trajectory, steps in zip(found, linearised_together(found, wanted, every), strict=True):
        single = trajectory.linearise(slice(0, len(trajectory.u) - 1), wanted)
        assert single.S is not None
        assert np.allclose(steps.S, single.S, rtol=1e-6, atol=1e-9 * np.abs(single.S).max())


def test_companions_that_are_not_sampled_alike_go_one_by_one() -> None:
    one = assemble(STRUCTURE.extended("arm.pose_lever[q2]"))
    slow, fast, _ = accompanied()
    fast = replace(fast, sampling_time=2 * SAMPLING_TIME)
    assert beside_all([one.along(slow), one.along(fast)]) is None
    theta = one.parameters().with_values(TRUTH).values
    found = list(simulate_together(one, theta, [slow, fast], [Start(np.zeros(one.nx))] * 2))
    np.testing.assert_array_equal(found[1].x, simulate(one, theta, fast, np.zeros(one.nx)).x)
