"""Fits that ended well and cannot be believed, and what a constant torque would change."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from support.mistaken_logs import FLEXIBLE, RATIO, swing

from robotid.catalogue import assemble
from robotid.diagnosis.procedure import DiagnosisOptions, diagnose
from robotid.errors import NumericsError
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.identify import starting_parameters
from robotid.estimate.result import FitResult
from robotid.estimate.rigid import fit_rigid
from robotid.estimate.scrutiny import FitTask, doubts, scrutinised_fit
from robotid.estimate.scrutiny import task as fitting
from robotid.estimate.scrutiny.instability import growth_rate
from robotid.estimate.scrutiny.scrutinise import LEFT_OUT
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

TERMS = ("motor.inertia", "motor.viscous", "motor.coulomb")
JOINT = assemble(Structure(TERMS))
TRUTH = {"motor.inertia.J": 1.2e-4, "motor.viscous.Fv": 1e-4, "motor.coulomb.Fc": 0.012}
H = 1e-3


@cache
def record(offset: float) -> Record:
    """A small axis on a triangle of speed for four seconds, with a constant torque that the model does not have."""
    joint = assemble(Structure((*TERMS, "motor.constant_torque")), angle=True)
    truth = joint.parameters().with_values(TRUTH | {"motor.constant_torque.tau0": offset})
    robot = VirtualRobot(joint, truth.values, Controller("speed", 0.006, 0.06), 1e-4, 1e-4, 0.05, seed=1)
    reference = 80 / np.pi * np.arcsin(np.sin(np.pi * np.arange(4000) * H))
    return robot.record(Reference("log", H, reference, "speed", None, None), 1)


@cache
def start(offset: float) -> Parameters:
    return starting_parameters(JOINT, {}, fit_rigid(JOINT, JOINT.parameters(), [record(offset)]).guesses)


@cache
def scrutinised(offset: float) -> FitResult:
    return scrutinised_fit(FitTask("m", JOINT, start(offset), [record(offset)], FitOptions())).fit


def test_a_fit_without_fault_stays_as_it_is() -> None:
    plain, found = fit_model("m", JOINT, start(0.0), [record(0.0)], FitOptions()), scrutinised(0.0)
    assert found.remarks == ()
    assert [p.value for p in found.parameters] == [p.value for p in plain.parameters]


@pytest.mark.parametrize("offset", [0.003, 0.012])
def test_a_constant_torque_that_is_not_declared_is_named_with_what_it_changes(offset: float) -> None:
    found = scrutinised(offset)
    assert [p.name for p in found.parameters] == list(TRUTH), "the model stays as declared"
    assert any("went into the parameters" in remark for remark in found.remarks)
    assert any("the estimated first speed of log, " in remark for remark in found.remarks)
    assert abs(found.initial_states["log"][0] - record(offset).dphi_m[0]) < 2.0
    assert found["motor.inertia.J"].value == pytest.approx(TRUTH["motor.inertia.J"], rel=0.5)
    advice = found.remarks[-1]
    assert f"with a constant torque of {offset:.3g} Nm" in advice
    assert "motor.inertia.J = 0.00012 kg m2" in advice
    assert "add constant_torque to robot.model.motor" in advice


@pytest.mark.parametrize("offset", [0.003, 0.012])
def test_a_doubtful_fit_is_tried_again_with_a_constant_torque_free(offset: float) -> None:
    """What went into inertia and friction, by a factor of up to seventeen, is in the constant torque."""
    found = scrutinised_fit(FitTask("m", JOINT, start(offset), [record(offset)], FitOptions())).with_offset
    assert found is not None
    assert found.name == "m_offset"
    for name, value in (TRUTH | {"motor.constant_torque.tau0": offset}).items():
        assert found[name].value == pytest.approx(value, rel=0.02)
    assert found.fit_percent["log"] > 99.0
    (remark,) = found.remarks
    assert remark == f"m with a constant torque of {offset:.3g} Nm, which it does not have"


def test_a_fit_without_fault_is_not_tried_again() -> None:
    assert scrutinised_fit(FitTask("m", JOINT, start(0.0), [record(0.0)], FitOptions())).with_offset is None


@cache
def pushed() -> tuple[Record, Parameters]:
    """The axis without fault, leant on for half a second with as much as its dry friction; and a start on it."""
    plain = record(0.0)
    push = np.where((plain.t > 1.5) & (plain.t < 2.0), 0.012, 0.0)
    found = replace(plain, tau_m=plain.tau_m - push)
    return found, starting_parameters(JOINT, {}, fit_rigid(JOINT, JOINT.parameters(), [found]).guesses)


def test_what_an_open_simulation_adds_up_does_not_go_into_the_parameters_of_short_pieces() -> None:
    found, begin = pushed()
    task = FitTask("m", JOINT, begin, [found], FitOptions())
    whole, chosen = task.fit(), scrutinised_fit(task).fit
    assert any("went into the parameters" in doubt for doubt in doubts(whole, JOINT, begin, [found]))
    assert chosen.horizon is not None
    assert 0.1 <= chosen.horizon <= 0.25
    assert "meets the torque as its start does" in chosen.remarks[-1]
    for name in ("motor.viscous.Fv", "motor.coulomb.Fc"):
        assert abs(chosen[name].value - TRUTH[name]) < 0.5 * abs(whole[name].value - TRUTH[name])
    given = replace(task, options=FitOptions(horizon=2.0))
    assert scrutinised_fit(given).fit.horizon is None, "pieces that are asked for stay as they are"


def test_a_friction_that_vanishes_is_said() -> None:
    assert "motor.coulomb.Fc ended at its lower bound, 0, from a start at 0.0128" in scrutinised(0.012).remarks


def test_a_declared_constant_torque_is_not_tried_again() -> None:
    joint = assemble(Structure((*TERMS, "motor.constant_torque")))
    rigid = fit_rigid(joint, joint.parameters(), [record(0.012)])
    found = scrutinised_fit(
        FitTask("m", joint, starting_parameters(joint, {}, rigid.guesses), [record(0.012)], FitOptions())
    ).fit
    assert found.remarks == ()
    assert found["motor.inertia.J"].value == pytest.approx(TRUTH["motor.inertia.J"], rel=0.01)


def test_another_inertia_than_the_start_is_said() -> None:
    fit = scrutinised(0.0)
    far = start(0.0).with_values({"motor.inertia.J": 3e-4})
    (remark,) = doubts(fit, JOINT, far, [record(0.0)])
    assert remark.startswith("the inertia of the fit is 0.4 times that of its start")
    fixed = replace(far, free=np.zeros(3, dtype=bool))
    assert list(doubts(fit, JOINT, fixed, [record(0.0)])) == []


def test_of_a_record_in_pieces_the_first_speed_is_that_of_the_first() -> None:
    log = record(0.0)
    pieces = (log.piece(0, 2500), log.piece(2500, 4000))
    found = scrutinised_fit(FitTask("m", JOINT, start(0.0), pieces, FitOptions())).fit
    assert pieces[1].dphi_m[0] > 10.0 + pieces[0].dphi_m[0]
    assert found.remarks == ()


@cache
def pendulum(offset: float = 0.0, samples: int = 2500) -> tuple[Joint, Parameters, Record]:
    """A pendulum that is held about its upper rest by its controller: an open simulation falls. offset [Nm] : a
    constant torque that the joint does not have."""
    truth = {"motor.inertia.J": 0.01, "motor.viscous.Fv": 0.01, "motor.coulomb.Fc": 0.02, "arm.gravity.G": 1.0}
    structure = Structure((*TERMS, "arm.gravity"), gear_ratio=1.0)
    angled, t = assemble(structure.extended("motor.constant_torque"), angle=True), np.arange(samples) * 2e-3
    truth |= {"arm.gravity.H": 0.0, "motor.constant_torque.tau0": offset}
    values = angled.parameters().with_values(truth).values
    robot = VirtualRobot(angled, values, Controller("speed", 0.3, 2.0), 2 * np.pi / 4096, 0.01, 0.02, seed=1)
    reference = 4 * np.sin(2 * np.pi * 0.3 * t) + 1.5 * np.sin(2 * np.pi * 1.1 * t)
    log = robot.record(Reference("log", 2e-3, reference, "speed", None, None), 1)
    joint = assemble(structure)
    begin = starting_parameters(joint, {}, fit_rigid(joint, joint.parameters(), [log]).guesses)
    return joint, begin, log


def test_an_unstable_motion_is_fitted_in_pieces() -> None:
    joint, begin, log = pendulum()
    assert growth_rate(joint, begin.values, log) > 2.0
    assert fit_model("m", joint, begin, [log], FitOptions()).fit_percent["log"] < 90.0
    found = scrutinised_fit(FitTask("m", joint, begin, [log], FitOptions())).fit
    assert found.fit_percent["log"] > 98.0
    assert found["motor.inertia.J"].value == pytest.approx(0.01, rel=0.02)
    assert found["arm.gravity.G"].value == pytest.approx(1.0, rel=0.02)
    assert found.horizon == 1.0
    assert "fitted, validated and diagnosed in pieces of 1 s" in found.remarks[-1]


def test_whole_records_that_no_simulation_follows_are_not_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit of these took minutes, and ended worse than rest."""
    joint, begin, log = pendulum(samples=6000)
    horizons, fit = list[float | None](), fitting.fit_model

    def watched(*arguments: Any) -> FitResult:
        horizons.append(arguments[4].horizon)
        return fit(*arguments)

    monkeypatch.setattr(fitting, "fit_model", watched)
    found = scrutinised_fit(FitTask("m", joint, begin, [log], FitOptions())).fit
    assert (found.horizon, horizons) == (1.0, [1.0])
    assert "no simulation of whole records stays near them: fitted, validated and diagnosed in" in found.remarks[-1]


def test_a_weight_that_is_not_declared_chooses_the_pieces_in_which_it_can_be_found() -> None:
    """Of whole records, neither the fit nor a refit with gravity comes near: the diagnosis found no cause."""
    _, _, log = pendulum()
    joint = assemble(Structure(TERMS, gear_ratio=1.0))
    begin = starting_parameters(joint, {}, fit_rigid(joint, joint.parameters(), [log]).guesses)
    found = scrutinised_fit(FitTask("m", joint, begin, [log], FitOptions())).fit
    assert found.horizon == 1.0
    assert found.remarks[-1].startswith("with a weight, which the model does not have, the torque is met to ")
    (cause,) = diagnose(found, [log], options=DiagnosisOptions(1.0)).causes
    assert cause.effect.endswith(".gravity")


def test_a_constant_torque_that_is_not_declared_chooses_the_pieces_as_well() -> None:
    """Of whole records neither a fit nor a refit with it comes near."""
    joint, begin, log = pendulum(0.3, 4000)
    found = scrutinised_fit(FitTask("m", joint, begin, [log], FitOptions(max_iterations=5))).fit
    assert found.horizon == 1.0
    assert found.remarks[-1].startswith("with a constant torque, which the model does not have, the torque is met to ")


def test_pieces_are_chosen_where_that_is_asked() -> None:
    joint, begin, log = pendulum()
    found = scrutinised_fit(FitTask("m", joint, begin, [log], FitOptions(choose_horizon=True))).fit
    assert found.horizon == 1.0
    assert found.remarks[-1].startswith("horizon: auto fits pieces of 1 s, for an error of the open simulation grows")
    stable = scrutinised_fit(FitTask("m", JOINT, start(0.0), [record(0.0)], FitOptions(choose_horizon=True))).fit
    assert stable.horizon is None
    (note,) = stable.remarks
    assert note.startswith("horizon: auto fits whole records, for no error of an open simulation grows far")


def test_a_stable_axis_lets_no_error_grow() -> None:
    assert growth_rate(JOINT, start(0.0).values, record(0.0)) == 0.0


def test_a_start_from_which_the_motor_does_not_move_is_left_for_the_regression() -> None:
    """Locked by friction, a simulation has no derivatives, and the fit ended as converged where it began."""
    far = JOINT.parameters().with_values({name: 5.0 * value for name, value in TRUTH.items()})
    assert fit_model("m", JOINT, far, [record(0.0)], FitOptions()).fit_percent["log"] < 60.0
    found = scrutinised_fit(FitTask("m", JOINT, far, [record(0.0)], FitOptions())).fit
    assert found.fit_percent["log"] > 99.0
    for name, value in TRUTH.items():
        assert found[name].value == pytest.approx(value, rel=0.02)
    assert any("far from the start that was given" in remark for remark in found.remarks)


def test_nothing_is_added_to_a_fit_that_has_nothing_to_do_with_its_record(monkeypatch: pytest.MonkeyPatch) -> None:
    astray = replace(scrutinised(0.0), fit_percent={"log": -2000.0})
    monkeypatch.setattr("robotid.estimate.scrutiny.task.fit_model", lambda *_: astray)
    with pytest.raises(NumericsError, match="the fit of log ends with a simulation that is wrong by 21 times the mot"):
        scrutinised_fit(FitTask("m", JOINT, start(0.0), [record(0.0)], FitOptions()))


@cache
def flexible() -> tuple[Joint, Record]:
    """A joint that flexes, on a multisine over a square wave."""
    names = tuple(dict.fromkeys(name.rpartition(".")[0] for name in FLEXIBLE))
    joint = assemble(Structure(names, gear_ratio=RATIO), angle=True)
    values = joint.parameters().with_values(FLEXIBLE).values
    robot = VirtualRobot(joint, values, Controller("speed", 0.5, 5.0), 1e-4, 0.005, 0.01, seed=1)
    return joint, robot.record(Reference("log", 0.002, swing(), "speed", None, None), 1)


def far_start(stiffness: float) -> FitTask:
    """A fit from a spring so many times as stiff, a light arm and next to no damping."""
    joint, log = flexible()
    given = FLEXIBLE | {"gear.spring.k1": stiffness * FLEXIBLE["gear.spring.k1"], "arm.inertia.J": 50.0}
    start = joint.parameters().with_values(given | {"gear.damper.d": 10.0})
    return FitTask("m", joint, start, [log], FitOptions(), found={name: 1.1 * v for name, v in FLEXIBLE.items()})


def test_a_joint_whose_given_start_is_far_from_what_was_found_is_fitted_from_there() -> None:
    """From a notch far away no derivative points to the true one."""
    task = far_start(0.01)
    assert scrutinised_fit(replace(task, found={})).fit.fit_percent["log"] < 90.0
    found = scrutinised_fit(task).fit
    assert found.fit_percent["log"] > 99.0
    assert found["gear.spring.k1"].value == pytest.approx(FLEXIBLE["gear.spring.k1"], rel=0.01)
    assert found.remarks == ("fitted once more from what the initialisation found, far from the start that was given",)


def test_a_given_start_that_cannot_be_simulated_is_left_for_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotid.estimate.grey_box.HOPELESS", 0.3)
    task = far_start(1000.0)
    with pytest.raises(NumericsError):
        scrutinised_fit(replace(task, found={}))
    assert scrutinised_fit(task).fit.fit_percent["log"] > 99.0


def left_out(share: float) -> Parameters:
    """A start that is not trusted, this share of the truth."""
    joint, _ = flexible()
    return joint.parameters().with_values({name: share * value for name, value in FLEXIBLE.items()})


def test_a_start_that_is_not_trusted_is_kept_where_it_leads_to_a_fit_that_can_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    task = replace(far_start(0.01), found={}, left_out=(left_out(0.7),))
    started = list[float]()

    def counted(name: str, joint: Joint, parameters: Parameters, *rest: Any) -> FitResult:
        started.append(parameters["gear.spring.k1"])
        return fit_model(name, joint, parameters, *rest)

    monkeypatch.setattr("robotid.estimate.scrutiny.task.fit_model", counted)
    found = scrutinised_fit(task).fit
    assert started == [0.7 * FLEXIBLE["gear.spring.k1"]]
    assert found.fit_percent["log"] > 99.0
    assert found.remarks == (LEFT_OUT,)


def test_the_same_start_is_not_tried_twice() -> None:
    joint, log = flexible()
    task = FitTask("m", joint, left_out(0.9), [log], FitOptions(), left_out=(left_out(0.9),))
    assert scrutinised_fit(task).fit.remarks == ()


def test_a_start_that_is_not_trusted_and_leads_nowhere_changes_nothing() -> None:
    joint, log = flexible()
    nowhere = joint.parameters().with_values(FLEXIBLE | {"motor.coulomb.Fc": 1e5})
    task = FitTask("m", joint, left_out(0.9), [log], FitOptions())
    assert scrutinised_fit(replace(task, left_out=(nowhere,))).fit.remarks == scrutinised_fit(task).fit.remarks == ()


@pytest.mark.parametrize("factor", [20.0, 200.0])
def test_a_start_far_off_from_which_the_motor_moves_is_fitted_at_once(factor: float) -> None:
    far = JOINT.parameters().with_values({name: factor * value for name, value in TRUTH.items()})
    found = fit_model("m", JOINT, far, [record(0.0)], FitOptions())
    assert found.fit_percent["log"] > 99.0
    for name, value in TRUTH.items():
        assert found[name].value == pytest.approx(value, rel=0.02)
