"""Fit and simulation solved together: where whole simulations lead, or lower; and what happens where that fails."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.noise import speed_whitening
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH, references

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate import least_squares, lifted
from robotid.estimate.least_squares import SolveOptions
from robotid.estimate.lifted import engine
from robotid.estimate.lifted.coarse import coarse_factor, coarsened, refined
from robotid.estimate.lifted.iterate import advanced_nodes, iterate
from robotid.estimate.residual import OutputError
from robotid.estimate.result import End
from robotid.model.structure import change
from robotid.progress import Iteration
from robotid.signals.record import Quantity, Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

SAMPLES = 4096
START = {
    "motor.inertia.J": 0.0123,
    "motor.viscous.Fv": 0.0136,
    "motor.coulomb.Fc": 0.642,
    "gear.spring.k1": 1.2e6,
    "gear.cubic_spring.k3": 5.4e10,
    "gear.damper.d": 500.0,
    "arm.inertia.J": 1000.0,
}
STRIBECK = {"motor.stribeck.dFs": 0.2, "motor.stribeck.vs": 2.0}
HYSTERESIS = {"gear.hysteresis.kh": 100.0, "gear.hysteresis.xs": 1e-4}
LAG = {"torque.torque_lag.T": 2e-3}
CHANGE = change("set2", "arm.inertia.J")
OPTIONS = SolveOptions(tolerance=1e-7)
NOISE_VARIANCES = (0.02**2, 0.005**2)


@cache
def records(hidden: tuple[tuple[str, float], ...] = ()) -> tuple[Record, ...]:
    """Two experiments on the paper's joint with effects hidden in it, at a speed sensor's and a torque's noise."""
    structure = STRUCTURE
    for effect in dict.fromkeys(name.rpartition(".")[0] for name, _ in hidden):
        structure = structure.extended(effect)
    joint = assemble(structure, angle=True)
    truth = joint.parameters().with_values(TRUTH | dict(hidden)).values
    plant = VirtualRobot(joint, truth, Controller("speed", 0.3, 3.0), 1e-5, 0.005, 0.02, seed=1)
    made = [Reference(f"set{k + 1}", SAMPLING_TIME, ref[:SAMPLES], "speed") for k, ref in enumerate(references())]
    return tuple(plant.record(reference, k) for k, reference in enumerate(made[1:]))


def problem(
    hidden: Mapping[str, float] | None = None,
    *,
    effects: tuple[str, ...] = (),
    output: Quantity = "speed",
    estimate_states: bool = True,
    start: Mapping[str, float] | None = None,
    upper: Mapping[str, float] | None = None,
) -> OutputError:
    """The paper's joint with further effects, on records of one that has hidden ones."""
    structure = STRUCTURE
    for effect in effects:
        structure = structure.extended(effect)
    joint = assemble(structure, angle=output == "position")
    parameters = joint.parameters().with_values(START | dict(start or {}))
    bounds = parameters.upper.copy()
    for name, value in (upper or {}).items():
        bounds[parameters.names.index(name)] = value
    parameters = replace(parameters, upper=bounds, values=np.minimum(parameters.values, bounds))
    data = records(tuple((hidden or {}).items()))
    return OutputError(joint, parameters, data, output, np.ones(len(data)), estimate_states)


def whitened() -> OutputError:
    plain = problem()
    theta = plain.joint.parameters().with_values(TRUTH).values
    filters = [speed_whitening(plain.joint, theta, SAMPLING_TIME, NOISE_VARIANCES) for _ in plain.records]
    return replace(plain, whiten=tuple(filters))


CASES = {
    "the paper's joint": problem,
    "whitened": whitened,
    "first states as measured": lambda: problem(estimate_states=False),
    "a parameter that differs in one record": lambda: problem(effects=(CHANGE,)),
    "a lag of the torque": lambda: problem(LAG, effects=("torque.torque_lag",)),
    "an active bound": lambda: problem(upper={"motor.inertia.J": 0.0115}),
    "a model that lacks an effect": lambda: problem(STRIBECK),
}


@pytest.mark.parametrize("case", CASES)
def test_it_ends_where_whole_simulations_lead(case: str) -> None:
    sought = CASES[case]()
    start = sought.start()
    expected = least_squares.solve(sought, start, OPTIONS)
    found = lifted.solve(sought, start, OPTIONS)
    assert found.end is End.CONVERGED
    assert found.evaluation.cost < expected.evaluation.cost * (1 + 2e-5)
    if expected.end is End.CONVERGED and found.evaluation.cost > expected.evaluation.cost * (1 - 1e-6):
        step = expected.factor @ (found.evaluation.unknowns - expected.evaluation.unknowns)
        noise = np.sqrt(2 * expected.evaluation.cost / sum(map(len, sought.records)))
        assert np.linalg.norm(step) < 0.1 * noise * np.sqrt(len(start))


@pytest.mark.parametrize("hidden", [STRIBECK, HYSTERESIS])
def test_it_reaches_the_noise_from_where_whole_simulations_may_not(hidden: dict[str, float]) -> None:
    effect = next(iter(hidden)).rpartition(".")[0]
    sought = problem(hidden, effects=(effect,), start={name: 0.7 * value for name, value in hidden.items()})
    found = lifted.solve(sought, sought.start(), OPTIONS)
    samples = sum(map(len, sought.records))
    assert found.end is End.CONVERGED
    assert np.sqrt(2 * found.evaluation.cost / samples) < 1.1 * 0.02


@pytest.mark.parametrize("output", ["speed", "position"])
def test_its_trajectories_are_simulations(output: Quantity) -> None:
    sought = problem(output=output)
    found = lifted.solve(sought, sought.start(), OPTIONS).evaluation
    again = sought.evaluate(found.unknowns)
    assert found.cost == pytest.approx(again.cost, rel=1e-4)
    for one, other in zip(found.trajectories, again.trajectories, strict=True):
        scale = np.abs(other.x).max(axis=1, keepdims=True)
        assert np.abs(one.x - other.x).max() < 1e-3 * scale.max()


def test_a_bound_that_holds_is_met_exactly() -> None:
    sought = problem(upper={"motor.inertia.J": 0.0115})
    found = lifted.solve(sought, sought.start(), OPTIONS)
    assert sought.theta(found.evaluation.unknowns)[sought.parameters.names.index("motor.inertia.J")] == 0.0115


def test_the_derivatives_are_those_of_simulations() -> None:
    sought = problem(LAG, effects=("torque.torque_lag", CHANGE))
    at = sought.evaluate(sought.start())
    part = iterate(sought, at.unknowns, [t.x for t in at.trajectories]).parts
    for k, one in enumerate(part):
        jacobian = sought.jacobian(at, k)
        assert one.where.tolist() == jacobian.unknowns.tolist()
        size = np.abs(jacobian.values).max(axis=1, keepdims=True)
        assert np.abs(one.derivatives - jacobian.values).max() < 1e-9 * size.max()
        assert np.abs(one.derivatives - jacobian.values)[size[:, 0] > 0].max() < 1e-9 * size.max()


def test_the_first_node_of_every_record_is_corrected_to_its_own_state() -> None:
    sought = problem()
    start = sought.start()
    nodes = [t.x.copy() for t in sought.evaluate(start).trajectories]
    for k, x in enumerate(nodes):
        x[:, 0] += (k + 1) * np.array([1e-6, 1e-2, 1e-4])
    for k, part in enumerate(iterate(sought, start, nodes).parts):
        assert part.correction_of_nodes[:, 0] == pytest.approx(-(k + 1) * np.array([1e-6, 1e-2, 1e-4]))


def test_corrected_nodes_approach_a_simulation_quadratically() -> None:
    sought = problem()
    start = sought.evaluate(sought.start())
    rng = np.random.default_rng(1)
    defects = []
    for size in (1e-4, 1e-5):
        nodes = [t.x * (1 + size * rng.standard_normal(t.x.shape)) for t in start.trajectories]
        for x, t in zip(nodes, start.trajectories, strict=True):
            x[:, 0] = t.x[:, 0]
        at = iterate(sought, start.unknowns, nodes)
        after = iterate(sought, start.unknowns, advanced_nodes(sought, at, np.zeros(len(start.unknowns))))
        defects.append(np.sqrt(after.defect / at.defect))
    assert defects[1] < 0.1
    assert defects[1] < 0.5 * defects[0] + 1e-6


def test_where_it_does_not_settle_whole_simulations_go_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def unsettled(*_: object, **__: object) -> None:
        raise engine.NotSettling("for a test")

    sought = problem()
    expected = least_squares.solve(sought, sought.start(), OPTIONS)
    monkeypatch.setattr(engine, "attempt", unsettled)
    found = lifted.solve(sought, sought.start(), OPTIONS)
    assert found.end is End.CONVERGED
    assert found.evaluation.cost == pytest.approx(expected.evaluation.cost, rel=1e-5)


def test_a_start_that_diverges_is_refused_as_before() -> None:
    sought = problem(start={"motor.inertia.J": np.nan})
    with pytest.raises(NumericsError):
        lifted.solve(sought, sought.start(), OPTIONS)


def test_a_coarse_grid_is_taken_where_it_shows_the_motion() -> None:
    slow = problem()
    assert coarse_factor(slow) == 8
    assert coarse_factor(whitened()) == 1
    t = np.arange(SAMPLES) * SAMPLING_TIME
    fast = replace(slow.records[0], tau_m=slow.records[0].tau_m + 20.0 * np.sin(2 * np.pi * 400.0 * t))
    assert coarse_factor(replace(slow, records=(fast,), weights=np.ones(1))) == 2
    short = slow.records[0].piece(0, 900)
    assert coarse_factor(replace(slow, records=(short,), weights=np.ones(1))) == 1


def test_a_coarse_problem_holds_the_mean_torque_and_the_cost() -> None:
    sought = problem()
    coarse = coarsened(sought, 4)
    record, fine = coarse.records[0], sought.records[0]
    assert record.sampling_time == 4 * SAMPLING_TIME
    assert record.tau_m[7] == pytest.approx(fine.tau_m[28:32].mean())
    assert (record.dphi_m[:-1] == fine.dphi_m[: 4 * (len(record) - 1) : 4]).all()
    theta = sought.joint.parameters().with_values(TRUTH)
    costs = [replace(one, parameters=theta).evaluate(one.start()).cost for one in (sought, coarse)]
    assert costs[1] == pytest.approx(costs[0], rel=0.2)


def test_coarse_nodes_are_joined_by_straight_lines() -> None:
    x = np.array([[0.0, 4.0, 8.0]])
    assert refined(x, 4, 10)[0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 8.0]


def test_every_iterate_costs_what_it_costs_on_all_samples() -> None:
    """The first iterates see every eighth sample only; their cost is that of all of them, and it falls."""
    sought = problem()
    assert coarse_factor(sought) > 1
    logged = list[Iteration]()
    found = lifted.solve(sought, sought.start(), OPTIONS, log=logged.append)
    assert found.end is End.CONVERGED
    assert np.all(np.diff(found.cost) < 2e-3 * np.array(found.cost[:-1]))  # straight between coarse nodes
    assert found.cost[-1] == pytest.approx(found.evaluation.cost)
    assert [one.number for one in logged] == list(range(1, len(found.cost)))
    costs = [one.cost for one in logged]
    assert np.all(np.diff(costs) < 2e-3 * np.array(costs[:-1]))
    assert costs[0] == pytest.approx(found.cost[1])
    assert costs[-1] == pytest.approx(found.cost[-1], rel=1e-3)
