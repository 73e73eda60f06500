"""From records to the start of a flexible joint: readings, parametric fits, spring laws."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH
from support.virtual_records import paper_records, true_records

from robotid.catalogue import assemble
from robotid.estimate.average_stiffness import equivalent_law, published_law, simulate_twist
from robotid.estimate.flexible import FlexResult, fit_flexible
from robotid.estimate.linear_response import fit_response, linear_part, linear_response, total_inertia
from robotid.estimate.notch import read_off
from robotid.estimate.responses import ResponseOptions, responses
from robotid.estimate.rigid import RigidResult, fit_rigid
from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.model.structure import Structure
from robotid.signals.companion import Companion
from robotid.signals.frf import Complex, Frf
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

LINEAR = linear_part(assemble(STRUCTURE))
OMEGA = 2 * np.pi * np.arange(1.0, 40.2, 0.2)
THREE = replace(STRUCTURE, terms=(*STRUCTURE.terms, "link.spring", "link.damper", "tool.inertia"))
THIRD = replace(STRUCTURE, terms=(*STRUCTURE.terms, "link.third_mass"))
TOOL = {"arm.inertia.J": 800.0, "tool.inertia.J": 330.0, "link.spring.k1": 2.3e6, "link.damper.d": 1500.0}
POSED = "arm.pose_lever[q2].A"
HUNG = {"arm.inertia.J": 800.0, "link.third_mass.Jb": 330.0, "link.third_mass.wb": 80.0, "link.third_mass.zeta": 0.03}


def published_transfer(omega: Array, Jm: float, Ja: float, k: float, Fv: float) -> Complex:
    """Eq. (13) in arm-side k: torque to acceleration of two masses without damping."""
    s, r = 1j * omega, RATIO
    return np.asarray(s * (Ja * s**2 + k) / (s**3 * Ja * Jm + s**2 * Ja * Fv + s * k * (Jm + r**2 * Ja) + k * Fv))


def theta(**change: float) -> Array:
    values = TRUTH | {name.replace("_", "."): value for name, value in change.items()}
    return np.array([values[name] for name in LINEAR.names])


def exact_frf(relative_std: float = 1e-3) -> Frf:
    response = linear_response(LINEAR, theta(), OMEGA)
    return Frf("exact", OMEGA / (2 * np.pi), response, relative_std * np.abs(response))


@cache
def initialised(structure: Structure, more: tuple[tuple[str, float], ...] = ()) -> tuple[RigidResult, FlexResult]:
    truth = TRUTH | dict(more)
    set1, set2, set3 = paper_records(structure, truth)
    joint = assemble(structure)
    rigid = fit_rigid(joint, joint.parameters(), [set1])
    return rigid, fit_flexible(joint, joint.parameters().with_values(rigid.guesses), rigid, [set2, set3])


def test_the_linear_joint_is_equation_13() -> None:
    expected = published_transfer(OMEGA, 0.0121, 1130.0, 1.46e6, 0.013)
    assert linear_response(LINEAR, theta(gear_damper_d=0.0), OMEGA) == pytest.approx(expected, rel=1e-9)


def test_the_linear_part_leaves_out_what_is_not_linear() -> None:
    nonlinear = {"motor.coulomb", "gear.cubic_spring"}
    assert LINEAR.structure.terms == tuple(name for name in STRUCTURE.terms if name not in nonlinear)


def test_notch_resonance_and_gain_are_read_off() -> None:
    reading = read_off(exact_frf())
    assert reading.notch == pytest.approx(np.sqrt(1.46e6 / 1130), rel=0.01)
    assert reading.resonance == pytest.approx(np.sqrt(1.46e6 * (1 / 1130 + RATIO**2 / 0.0121)), rel=0.01)
    assert reading.gain == pytest.approx(1 / 0.0121, rel=0.08)


def test_a_response_of_another_inertia_than_that_of_slow_motion_is_left_out() -> None:
    rigid, agreed = initialised(STRUCTURE)
    _, set2, set3 = paper_records(STRUCTURE, TRUTH)
    joint = assemble(STRUCTURE)
    light = {name: value / 6 if "inertia" in name else value for name, value in rigid.guesses.items()}
    found = fit_flexible(joint, joint.parameters().with_values(light), rigid, [set2, set3])
    assert agreed.parameters
    assert not found.parameters
    assert sum("asks for a rigid inertia of" in remark for remark in found.remarks) == 2


def test_noise_is_no_notch() -> None:
    rng = np.random.default_rng(1)
    noise = rng.standard_normal(len(OMEGA)) + 1j * rng.standard_normal(len(OMEGA))
    frf = Frf("flat", OMEGA / (2 * np.pi), 100 * (1 + 0.1 * noise), np.full(len(OMEGA), 14.0))
    reading = read_off(frf)
    assert reading.notch is None
    assert reading.resonance is None
    assert reading.gain == pytest.approx(100, rel=0.1)


def test_the_parametric_fit_is_exact_on_an_exact_response() -> None:
    start = {name: 1.5 * value for name, value in TRUTH.items() if name in LINEAR.names}
    held = {"motor.viscous.Fv": 0.013}
    fit = fit_response(LINEAR, exact_frf(), held, [start], (total_inertia(LINEAR, TRUTH), 1e-5))
    for name in LINEAR.names:
        assert fit.values[name] == pytest.approx(TRUTH[name], rel=1e-4)
    assert set(fit.relative_std) == set(LINEAR.names) - {"motor.viscous.Fv"}
    assert fit.misfit < 1e-2


def test_a_fit_that_comes_near_masses_bound_beyond_floating_point_ends() -> None:
    """A step further there is no response, and so no difference quotient."""
    joint, values = linear_part(assemble(THIRD)), TRUTH | HUNG
    theta = np.array([values[name] for name in joint.names])
    response = linear_response(joint, theta, OMEGA)
    start = {name: values[name] for name in joint.names} | {"link.third_mass.zeta": np.exp(37.0)}
    frf = Frf("exact", OMEGA, response, 1e-4 * np.abs(response))
    fit = fit_response(joint, frf, {}, [start], (total_inertia(joint, values), 1e-3))
    assert np.isfinite(fit.misfit)
    assert np.isfinite(list(fit.values.values())).all()


def test_the_twist_of_a_linear_spring() -> None:
    structure = replace(STRUCTURE, terms=tuple(t for t in STRUCTURE.terms if t != "gear.cubic_spring"))
    joint = assemble(structure)
    values = np.array([TRUTH[name] for name in joint.names])
    t = np.arange(8000) * SAMPLING_TIME
    drive = Record("r", "estimate", "flex", SAMPLING_TIME, 2 * np.sin(20 * t), 0 * t, 0 * t)
    trajectory = simulate(joint, values, drive, np.zeros(joint.nx))
    assert trajectory.twist is not None
    twist = simulate_twist(trajectory.dphi_m, SAMPLING_TIME, RATIO, 1.46e6, 2630.0, 1130.0)
    assert twist == pytest.approx(trajectory.twist, abs=1e-3 * np.abs(trajectory.twist).max())


def test_the_spring_laws_of_two_amplitudes() -> None:
    """k_i of the nearest linear spring: equivalent linearisation undoes it, eq. (14) falls short of the cubic part."""
    t = np.linspace(0, 100, 20_001)
    twists = [amplitude * np.sin(t) for amplitude in (5e-4, 1e-3)]
    k = np.array([1e6 + 1e11 * 0.75 * amplitude**2 for amplitude in (5e-4, 1e-3)])
    cubes = [x**3 for x in twists]
    law = equivalent_law(twists, cubes, k, 1e-3 * k)
    assert (law.k1, law.k3) == pytest.approx((1e6, 1e11), rel=0.01)
    assert law.stiffens
    published = published_law(twists, cubes, k, 1e-3 * k)
    assert 0 < published.k3 < 0.8e11
    cost = [
        sum(np.sum((ki * x - k1 * x - k3 * x**3) ** 2) for ki, x in zip(k, twists, strict=True))
        for k1, k3 in (
            (published.k1, published.k3),
            (1.001 * published.k1, published.k3),
            (published.k1, 1.1 * published.k3),
        )
    ]
    assert cost[0] == min(cost)


def test_equal_stiffness_does_not_stiffen() -> None:
    x = np.sin(np.linspace(0, 100, 1001))
    k = np.array([1.0e6, 0.99e6])
    twists = [1e-3 * x, 2e-3 * x]
    assert not equivalent_law(twists, [twist**3 for twist in twists], k, 0.01 * k).stiffens


def test_the_paper_joint_within_a_few_percent() -> None:
    rigid, flex = initialised(STRUCTURE)
    guesses = rigid.guesses | flex.guesses
    for name in ("motor.inertia.J", "motor.viscous.Fv", "motor.coulomb.Fc", "arm.inertia.J", "gear.spring.k1"):
        assert guesses[name] == pytest.approx(TRUTH[name], rel=0.05)
    assert guesses["gear.damper.d"] == pytest.approx(TRUTH["gear.damper.d"], rel=0.1)


def test_the_paper_joint_does_not_tell_its_cubic_spring() -> None:
    flex = initialised(STRUCTURE)[1]
    assert flex.guesses["gear.cubic_spring.k3"] == 0.0
    assert any("do not separate k1 from k3" in remark for remark in flex.remarks)
    assert [law.method for law in flex.springs] == ["least squares of the spring torque", "equivalent linearisation"]


def test_readings_as_in_the_paper() -> None:
    flex = initialised(STRUCTURE)[1]
    assert [reading.record for reading in flex.readings] == ["set2", "set3"]
    for reading in flex.readings:
        assert reading.notch == pytest.approx(np.sqrt(1.46e6 / 1130), rel=0.03)
        assert reading.Jm == pytest.approx(0.0121, rel=0.1)
        assert reading.k == pytest.approx(1.46e6, rel=0.1)
        assert 2e-4 < reading.twist < 3e-3


def test_a_strong_cubic_spring_is_found() -> None:
    flex = initialised(STRUCTURE, (("gear.cubic_spring.k3", 1.5e12),))[1]
    assert flex.guesses["gear.cubic_spring.k3"] == pytest.approx(1.5e12, rel=0.3)
    assert flex.guesses["gear.spring.k1"] == pytest.approx(1.46e6, rel=0.1)


@pytest.mark.parametrize(("structure", "tool"), [(THREE, TOOL), (THIRD, HUNG)], ids=["masses", "term"])
def test_a_third_mass_is_found(structure: Structure, tool: dict[str, float]) -> None:
    rigid, flex = initialised(structure, tuple(tool.items()))
    guesses = rigid.guesses | flex.guesses
    for name, value in (TRUTH | tool).items():
        if name != "gear.cubic_spring.k3":
            assert guesses[name] == pytest.approx(value, rel=0.15), name


def test_a_tool_that_is_not_there_is_said() -> None:
    set1, set2, _ = true_records()
    joint = assemble(THREE)
    rigid = fit_rigid(joint, joint.parameters(), [set1])
    flex = fit_flexible(joint, joint.parameters().with_values(rigid.guesses), rigid, [set2])
    assert any("no second resonance" in remark for remark in flex.remarks)


def test_a_fixed_parameter_is_held() -> None:
    set1, set2, _ = true_records()
    joint = assemble(STRUCTURE)
    parameters = joint.parameters().with_values({"motor.inertia.J": 0.0121})
    parameters = replace(parameters, free=np.array([name != "motor.inertia.J" for name in joint.names]))
    rigid = fit_rigid(joint, parameters, [set1])
    flex = fit_flexible(joint, parameters.with_values(rigid.guesses), rigid, [set2])
    assert "motor.inertia.J" not in flex.guesses
    assert flex.readings[0].values["motor.inertia.J"] == 0.0121
    assert flex.guesses["arm.inertia.J"] == pytest.approx(1130, rel=0.05)


@pytest.mark.parametrize(("amplitude", "arm"), [(300.0, 830.0), (-200.0, 1330.0)])
def test_a_response_shows_the_arm_with_what_its_pose_adds(amplitude: float, arm: float) -> None:
    flex = posed(amplitude)
    assert flex.guesses["arm.inertia.J"] == pytest.approx(arm, rel=0.05)
    assert {e.name: e.value for e in flex.parameters}["arm.inertia.J"] == flex.guesses["arm.inertia.J"]
    assert POSED not in flex.guesses


def test_a_pose_that_would_leave_no_mass_starts_absent() -> None:
    flex = posed(1500.0)
    assert (flex.guesses["arm.inertia.J"], flex.guesses[POSED]) == (pytest.approx(1130, rel=0.05), 0.0)
    assert any(f"{POSED} start absent" in remark for remark in flex.remarks)


def posed(amplitude: float) -> FlexResult:
    """The start of the joint beside an axis at a right angle, whose pose step 1 gave this amplitude [kg m2]."""
    set1, set2, _ = true_records()
    upright = Companion.of(CompanionKind.ANGLE, np.full(len(set2), 0.5 * np.pi), SAMPLING_TIME)
    rigid = fit_rigid(assemble(STRUCTURE), assemble(STRUCTURE).parameters(), [set1])
    joint = assemble(STRUCTURE.extended("arm.pose_lever[q2]"))
    parameters = joint.parameters().with_values(rigid.guesses | {POSED: amplitude})
    return fit_flexible(joint, parameters, rigid, [replace(set2, companions={"q2": upright})])


def test_slow_motion_tells_no_stiffness() -> None:
    set1, *_ = true_records()
    joint = assemble(STRUCTURE)
    rigid = fit_rigid(joint, joint.parameters(), [set1])
    options = ResponseOptions((0.2, 2.0))
    flex = fit_flexible(joint, joint.parameters().with_values(rigid.guesses), rigid, [set1], options)
    assert flex.parameters == ()
    assert any("flexes just above what was excited" in remark for remark in flex.remarks)
    start = theta(**{name.replace(".", "_"): value for name, value in flex.guesses.items()})
    values = dict(zip(LINEAR.names, start.tolist(), strict=True))
    known = {name: value for name, value in rigid.guesses.items() if name in values}
    assert total_inertia(LINEAR, values) == pytest.approx(total_inertia(LINEAR, TRUTH | known))
    notch = np.sqrt(values["gear.spring.k1"] / values["arm.inertia.J"])
    assert notch == pytest.approx(flex.frfs[0].omega[-1])
    (asked_for,) = flex.left_out
    assert asked_for == {name: flex.readings[0].values[name] for name in flex.guesses}


def test_a_response_that_tells_the_stiffness_is_not_left_out() -> None:
    _, flex = initialised(STRUCTURE)
    assert flex.parameters
    assert flex.left_out == ()


def test_a_rigid_axis_gives_an_empty_result() -> None:
    set1, *_ = true_records()
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
    flex = fit_flexible(joint, joint.parameters(), fit_rigid(joint, joint.parameters(), [set1]), [set1])
    assert flex.frfs == ()
    assert flex.guesses == {}
    assert flex.remarks == ("a rigid axis has no flexibility",)


def test_realisations_become_one_response() -> None:
    """Two phase realisations, told by equal band, period and reference RMS; another amplitude stays apart."""
    _, set2, set3 = true_records()
    assert set2.ref is not None
    joint = assemble(STRUCTURE)
    parameters = joint.parameters().with_values(TRUTH)
    turned = replace(set2, name="set2_r2", ref=-set2.ref, tau_m=-set2.tau_m, phi_m=-set2.phi_m, dphi_m=-set2.dphi_m)
    found = responses(joint, parameters, [set2, turned, set3])
    assert [response.frf.record for response in found] == ["set2+set2_r2", "set3"]
    assert found[0].frf.distortion_std is not None
    assert [len(response.records) for response in found] == [2, 1]
