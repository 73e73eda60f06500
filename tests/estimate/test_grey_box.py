"""The third step recovers what a virtual robot is made of, and says how sure it is."""

from __future__ import annotations

import signal
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH, references

from robotid.catalogue import assemble
from robotid.errors import NumericsError
from robotid.estimate import grey_box
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.least_squares import Solution
from robotid.estimate.lifted import engine
from robotid.estimate.result import End, FitResult
from robotid.interrupt import interruptible
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.progress import Iteration
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate

JOINT = assemble(STRUCTURE)
TYPICAL = {"motor.inertia.J": 0.0123, "arm.inertia.J": 1000.0, "gear.spring.k1": 1.2e6, "gear.damper.d": 2000.0}


def start(**changed: float) -> Parameters:
    return JOINT.parameters().with_values(TRUTH | TYPICAL | changed)


@pytest.fixture(scope="module")
def records() -> tuple[Record, ...]:
    joint = assemble(STRUCTURE, angle=True)
    truth = joint.parameters().with_values(TRUTH).values
    plant = VirtualRobot(joint, truth, Controller("speed", kp=0.5, ki=5.0), 1e-4, 0.005, 0.02, seed=7)
    made = [Reference(f"set{k + 1}", SAMPLING_TIME, ref[:6000], "speed") for k, ref in enumerate(references())]
    return tuple(plant.record(reference, k) for k, reference in enumerate(made))


@pytest.fixture(scope="module")
def fitted(records: tuple[Record, ...]) -> FitResult:
    return fit_model("m3", JOINT, start(), records, FitOptions())


def test_recovers_the_truth_within_its_own_uncertainty(fitted: FitResult) -> None:
    assert fitted.end is End.CONVERGED
    for estimate in fitted.parameters:
        assert abs(estimate.value - TRUTH[estimate.name]) < 3.5 * estimate.std_robust, estimate


def test_torque_errors_count_in_the_robust_deviation_only(fitted: FitResult) -> None:
    friction = fitted["motor.viscous.Fv"]
    assert friction.std_robust > 2 * friction.std


def test_finds_the_noise_of_the_speed_sensor(fitted: FitResult) -> None:
    assert list(fitted.noise_std.values()) == pytest.approx([0.02] * 3, rel=0.05)
    assert min(fitted.fit_percent.values()) > 99


def test_a_fixed_parameter_stays_and_has_no_deviation(records: tuple[Record, ...]) -> None:
    held = start()
    held = replace(held, free=np.array([name != "gear.damper.d" for name in held.names]))
    fit = fit_model("m", JOINT, held, records[1:2], FitOptions(max_iterations=15))
    damper = fit["gear.damper.d"]
    assert damper.value == 2000.0
    assert damper.fixed
    assert np.isnan(damper.std)


def test_a_bound_holds_and_is_said(records: tuple[Record, ...]) -> None:
    bounded = start()
    upper = bounded.upper.copy()
    upper[bounded.names.index("arm.inertia.J")] = 1050.0
    fit = fit_model("m", JOINT, replace(bounded, upper=upper), records[1:2], FitOptions(max_iterations=15))
    assert fit["arm.inertia.J"].value == 1050.0
    assert fit["arm.inertia.J"].remark == "at its upper bound"


def test_twins_are_named_as_one_unidentifiable_direction() -> None:
    structure = STRUCTURE.extended("motor.constant_torque").extended("motor.asymmetric_coulomb")
    joint = assemble(structure)
    t = np.arange(3000) * SAMPLING_TIME
    u = 1.5 + 0.8 * np.sin(2 * np.pi * 5 * t)
    record = Record("one way", "estimate", "both", SAMPLING_TIME, u, 0 * u, 20.0 + 0 * u)
    values = TRUTH | {"motor.constant_torque.tau0": 0.1, "motor.asymmetric_coulomb.dFc": 0.1}
    fit = fit_model("m", joint, joint.parameters().with_values(values), (record,), FitOptions(max_iterations=3))
    assert "motor.asymmetric_coulomb.dFc" in fit["motor.constant_torque.tau0"].remark
    assert fit["motor.constant_torque.tau0"].remark.startswith("unidentifiable together with")


def interrupt(iteration: Iteration) -> None:
    if iteration.number == 2:
        raise KeyboardInterrupt


@pytest.mark.parametrize("multistart", [0, 1])
def test_the_keyboard_leaves_the_last_iterate(multistart: int, records: tuple[Record, ...]) -> None:
    options = FitOptions(multistart=multistart, interruptible=True)
    fit = fit_model("m", JOINT, start(), records[1:2], options, interrupt)
    assert fit.end is End.INTERRUPTED
    assert fit.iterations == 2
    assert fit["arm.inertia.J"].value != 1000.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_the_last_iterate(number: signal.Signals, records: tuple[Record, ...]) -> None:
    def send(iteration: Iteration) -> None:
        if iteration.number == 2:
            signal.raise_signal(number)

    with interruptible():
        fit = fit_model("m", JOINT, start(), records[1:2], FitOptions(interruptible=True), send)
    assert fit.end is End.INTERRUPTED
    assert fit.iterations == 2


def test_the_keyboard_ends_what_asks_for_no_last_iterate(records: tuple[Record, ...]) -> None:
    with pytest.raises(KeyboardInterrupt):
        fit_model("m", JOINT, start(), records[1:2], FitOptions(), interrupt)


def test_the_keyboard_ends_further_starts_with_the_best_so_far(records: tuple[Record, ...]) -> None:
    begun = list[int]()

    def interrupt_the_second(iteration: Iteration) -> None:
        begun.extend([iteration.number] * (iteration.number == 1))
        if len(begun) == 2:
            raise KeyboardInterrupt

    options = FitOptions(multistart=3, interruptible=True)
    once = fit_model("m", JOINT, start(), records[1:2], FitOptions())
    fit = fit_model("m", JOINT, start(), records[1:2], options, interrupt_the_second)
    assert fit.end is End.INTERRUPTED
    assert fit.cost[-1] == once.cost[-1]
    assert len(begun) == 2


RIGID = assemble(Structure(("motor.inertia", "motor.viscous")), angle=True)
LIGHT = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.03}


def light(name: str = "r", noise: float = 0.01, seed: int = 1, offset: float = 0.0, **changed: float) -> Record:
    """Two seconds of an axis of inertia and viscous friction. offset : of the recorded torque [Nm]."""
    t = np.arange(400) * 0.005
    u = 0.5 * np.sin(4 * t) + 0.3 * np.sin(17 * t)
    asked = Record(name, "estimate", "both", 0.005, u, 0 * u, 0 * u)
    motion = simulate(RIGID, RIGID.parameters().with_values(LIGHT | changed).values, asked, np.zeros(RIGID.nx))
    speed = motion.dphi_m + noise * np.random.default_rng(seed).standard_normal(len(u))
    return replace(asked, tau_m=u + offset, phi_m=motion.phi_m, dphi_m=speed)


def fit_light(*made: Record, **options: Any) -> FitResult:
    joint = assemble(RIGID.structure)
    return fit_model("m", joint, joint.parameters().with_values(LIGHT), made, FitOptions(**options))


def test_deviations_are_those_of_repeated_experiments() -> None:
    fits = [fit_light(light(noise=0.1, seed=seed)) for seed in range(40)]
    for name in LIGHT:
        spread = np.std([fit[name].value for fit in fits], ddof=1)
        for kind in ("std", "std_robust"):
            assert 0.7 < np.mean([getattr(fit[name], kind) for fit in fits]) / spread < 1.4


def test_pieces_of_a_horizon_start_afresh() -> None:
    drifting = light(offset=0.1)
    whole, pieces = fit_light(drifting), fit_light(drifting, horizon=0.2)
    assert list(pieces.fit_percent) == ["r"]
    assert pieces.noise_std["r"] < 0.5 * whole.noise_std["r"]


def test_a_weight_draws_the_fit_to_its_record() -> None:
    one, other = light("one"), light("other", seed=2, **{"motor.viscous.Fv": 0.04})
    found = {w: fit_light(one, other, weights={"other": w})["motor.viscous.Fv"].value for w in (0.01, 1.0, 100.0)}
    assert found[0.01] == pytest.approx(0.03, rel=0.01)
    assert 0.032 < found[1.0] < 0.038
    assert found[100.0] == pytest.approx(0.04, rel=0.01)


def test_a_horizon_fits_pieces_and_reports_whole_records(records: tuple[Record, ...]) -> None:
    fit = fit_model("m", JOINT, start(), records[:1], FitOptions(horizon=1.0))
    assert list(fit.fit_percent) == ["set1"]
    assert fit["motor.viscous.Fv"].value == pytest.approx(TRUTH["motor.viscous.Fv"], rel=0.02)


def test_multistart_is_no_worse_than_one_start(records: tuple[Record, ...]) -> None:
    once = fit_model("m", JOINT, start(), records[1:2], FitOptions())
    more = fit_model("m", JOINT, start(), records[1:2], FitOptions(multistart=1))
    assert more.cost[-1] <= once.cost[-1] * (1 + 1e-6)


def test_multistart_keeps_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    solve, costs = grey_box._solve, list[float]()

    def noted(*arguments: Any) -> Solution:
        found = solve(*arguments)
        costs.append(found.evaluation.cost)
        return found

    monkeypatch.setattr(grey_box, "_solve", noted)
    joint = assemble(RIGID.structure)
    far = joint.parameters().with_values({"motor.inertia.J": 0.2, "motor.viscous.Fv": 1.0})
    found = fit_model("m", joint, far, (light(),), FitOptions(max_iterations=1, multistart=3))
    assert len(costs) == 4
    assert found.cost[-1] == min(costs) < costs[0]


def test_what_was_simulated_from_the_start_on_is_not_begun_again(
    records: tuple[Record, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    def unsettled(*_: object, **__: object) -> None:
        raise NumericsError("for a test")

    monkeypatch.setattr(engine, "attempt", unsettled)
    logged = list[Iteration]()
    found = fit_model("m3", JOINT, start(), records[:1], FitOptions(max_iterations=2), logged.append)
    assert found.end is End.ITERATIONS
    assert [one.number for one in logged] == [1, 2]


def test_a_diverging_start_is_refused(records: tuple[Record, ...]) -> None:
    with pytest.raises(NumericsError, match="the simulation diverges"):
        fit_model("m", JOINT, start(**{"motor.inertia.J": np.nan}), records[1:2], FitOptions())


def test_the_better_of_two_starts_begins(records: tuple[Record, ...]) -> None:
    far, near, lost = start(**{"motor.coulomb.Fc": 3.0}), start(), start(**{"motor.inertia.J": 1e-12})
    options = FitOptions(max_iterations=1)
    expected = fit_model("m", JOINT, near, records[1:2], replace(options, other_starts=(near,))).cost[0]
    assert fit_model("m", JOINT, far, records[1:2], replace(options, other_starts=(far,))).cost[0] > 2 * expected
    for first, others in ((far, [near]), (near, [far]), (lost, [near]), (near, [lost])):
        assert fit_model("m", JOINT, first, records[1:2], replace(options, other_starts=others)).cost[
            0
        ] == pytest.approx(expected)


def test_a_hopeless_fit_is_given_up_in_one_line() -> None:
    """An inertia that is fixed at next to nothing: no offset of the torque slows the simulation down."""
    joint = assemble(Structure(("motor.inertia", "motor.constant_torque")))
    begin = joint.parameters().with_values({"motor.inertia.J": 1e-9, "motor.constant_torque.tau0": 0.3})
    fixed = replace(begin, lower=np.full(2, -1.0), free=np.array([False, True]))
    t = np.arange(400) * 1e-3
    log = Record.from_arrays(np.sin(40 * t) + 0.5 * np.sin(91 * t), -np.sin(40 * t) / 16, 1e-3, name="log")
    seen: list[Iteration] = []
    with pytest.raises(NumericsError, match=r"the simulation of log is wrong by \S+ times the motion; `robotid check`"):
        fit_model("m1", joint, fixed, [log], FitOptions(), seen.append)
    assert len(seen) <= 2
