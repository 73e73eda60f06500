"""The plant against textbook cases: if it is wrong, every trial is."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from study.plant.catalogue import EFFECTS
from study.plant.draw import draw
from study.plant.drive import Drive
from study.plant.experiment import Loop, Recording, experiment
from study.plant.files import write_csv
from study.plant.gear import backlash, soft_spring, third_mass, transmission_error
from study.plant.machine import Machine
from study.plant.motion import State, at_rest, stepper
from study.plant.references import multisine, square, triangle
from study.plant.rig import RATIO, Base, Rig

DT = 5e-5
SMOOTH = Base(Fv=0.0, Fc=0.0, d=0.0)
SILENT = Loop(torque_noise=0.0, speed_noise=0.0)
PLANT = Path(__file__).parent / "plant"


def run(machine: Machine, y: State, seconds: float, torque: float = 0.0) -> list[State]:
    """States one substep apart under a constant torque."""
    step, states = stepper(machine), [y]
    for _ in range(round(seconds / DT)):
        states.append(step(states[-1], torque, DT))
    return states


def test_shares_nothing_with_the_tool() -> None:
    modules = [f"study.plant.{file.stem}" for file in PLANT.glob("*.py")]
    script = f"import importlib, sys; [importlib.import_module(m) for m in {modules}]; print(*sys.modules)"
    path = {"PYTHONPATH": str(PLANT.parents[1])}
    loaded = subprocess.run([sys.executable, "-c", script], env=path, capture_output=True, text=True, check=True)
    assert "study.plant.motion" in loaded.stdout.split()
    assert not [name for name in loaded.stdout.split() if name.startswith("robotid")]


def energy(rig: Rig, y: State, tool: float = 0.0, wb: float = 0.0) -> float:
    """Kinetic energy, and that of the springs, of a machine without friction [J]."""
    b, machine = rig.base, rig.machine()
    twist = RATIO * y.phi_m - y.phi_a + (machine.mesh(y.phi_m)[0] if machine.mesh else 0.0)
    felt = np.sign(twist) * max(abs(twist) - machine.gap, 0.0)
    stretched = np.linspace(0.0, felt, 2001)
    stored = float(np.trapezoid([sum(law(x, 0.0) for law in machine.gear) for x in stretched], stretched))
    link = 0.5 * tool * (y.z[1] ** 2 + (wb * (y.phi_a - y.z[0])) ** 2) if tool else 0.0
    return 0.5 * b.motor_inertia * y.dphi_m**2 + 0.5 * b.arm_inertia * y.dphi_a**2 + stored + link


@pytest.mark.parametrize(
    ("rig", "tool", "wb"),
    [
        (Rig(SMOOTH), 0.0, 0.0),
        (Rig(replace(SMOOTH, k3=3.72e10)), 0.0, 0.0),
        (soft_spring(Rig(SMOOTH), 0.6, {"xs": 2e-4}), 0.0, 0.0),
        (backlash(Rig(SMOOTH), 1e-4, {}), 0.0, 0.0),
        (transmission_error(Rig(SMOOTH), 1e-4, {"n": 2.0, "phase": 1.0}), 0.0, 0.0),
        (third_mass(Rig(SMOOTH), 200.0, {"wb": 60.0, "zeta": 0.0}), 200.0, 60.0),
    ],
    ids=["plain", "cubic", "soft", "backlash", "transmission_error", "third_mass"],
)
def test_energy_is_kept_without_friction(rig: Rig, tool: float, wb: float) -> None:
    start = at_rest(rig.machine())._replace(dphi_m=10.0, s_m=1)
    energies = [energy(rig, y, tool, wb) for y in run(rig.machine(), start, 1.0)[::50]]
    assert energies == pytest.approx([energies[0]] * len(energies), rel=2e-4)
    assert np.ptp([y.dphi_m for y in run(rig.machine(), start, 0.2)]) > 1.0


def crossings(states: list[State]) -> np.ndarray:
    """Times at which the arm's speed turns positive, linear between substeps [s]."""
    times = [a.t - a.dphi_a * DT / (b.dphi_a - a.dphi_a) for a, b in pairwise(states) if a.dphi_a < 0 <= b.dphi_a]
    return np.diff(times)


def test_free_oscillation_has_the_textbook_frequency() -> None:
    b = SMOOTH
    states = run(Rig(b).machine(), State(phi_m=0.1), 1.0)
    omega = sqrt(b.k1 * (RATIO**2 / b.motor_inertia + 1 / b.arm_inertia))
    assert crossings(states) == pytest.approx(2 * pi / omega, rel=1e-5)


def test_a_motor_held_by_friction_rests_while_the_arm_swings() -> None:
    states = run(Rig(replace(SMOOTH, Fc=0.644)).machine(), State(phi_a=5e-5), 1.0)
    assert {y.dphi_m for y in states} == {0.0}
    assert {y.phi_m for y in states} == {0.0}
    assert crossings(states) == pytest.approx(2 * pi * sqrt(SMOOTH.arm_inertia / SMOOTH.k1), rel=1e-5)


ALONE = Machine(RATIO, 0.0121, 1130.0, motor=(lambda s, v, *_: 0.644 * s,))


def test_dry_friction_stops_the_motor_where_it_should_and_keeps_it_there() -> None:
    states = run(ALONE, State(dphi_m=10.0, s_m=1), 0.5)
    stop = 10.0 * 0.0121 / 0.644
    assert next(y.t for y in states if y.dphi_m == 0.0) == pytest.approx(stop, abs=DT)
    assert states[-1].phi_m == pytest.approx(0.5 * 10.0 * stop)
    assert states[-1].dphi_m == 0.0


@pytest.mark.parametrize(("torque", "gain"), [(0.643, 0.0), (-0.643, 0.0), (0.7, 0.056), (-0.7, -0.056)])
def test_break_away_needs_more_than_the_level(torque: float, gain: float) -> None:
    assert run(ALONE, State(), 0.1, torque)[-1].dphi_m == pytest.approx(0.1 * gain / 0.0121)


def test_a_reversal_inside_a_step_is_exact_under_constant_torque() -> None:
    step = stepper(ALONE)
    y = step(State(dphi_m=1.0, s_m=1), -2.0, 0.01)
    stop = 0.0121 / (2.0 + 0.644)
    assert y.dphi_m == pytest.approx(-(0.01 - stop) * (2.0 - 0.644) / 0.0121)


def test_teeth_part_and_meet_again_after_the_gap() -> None:
    machine = backlash(Rig(SMOOTH), 1e-4, {}).machine()
    states = run(machine, State(dphi_m=1.0, s_m=1), 0.1)
    meet = 1e-4 / RATIO
    assert {y.dphi_m for y in states if y.t < meet - DT} == {1.0}
    assert min(y.dphi_m for y in states if y.t < meet + 0.01) < 1.0


def test_bristles_carry_the_coulomb_level_once_they_slip() -> None:
    rig = EFFECTS["motor.presliding"].build(Rig(Base(Fv=0.0)), 0.03, {"s1": 0.03})
    machine = replace(rig.machine(), gear=())
    creeping, sliding = (run(machine, at_rest(machine), 1.0, torque)[-100:] for torque in (0.6, 0.8))
    assert creeping[-1].dphi_m == pytest.approx(0.0, abs=1e-3)
    assert 0.0 < creeping[-1].phi_m < 0.2
    rise = (sliding[-1].dphi_m - sliding[0].dphi_m) / (sliding[-1].t - sliding[0].t)
    assert rise == pytest.approx((0.8 - Base().Fc) / Base().motor_inertia, rel=1e-6)


def test_drive_delays_lags_and_saturates() -> None:
    assert Drive(delay=3 * DT).started(DT, 4)(1.0) == [0.0, 0.0, 0.0, 1.0]
    lag = Drive(lag=1e-3).started(DT, 20)(1.0)
    assert np.mean(lag) == pytest.approx(np.exp(-1.0))  # of a step, over one time constant: 1 - (1 - 1/e)
    assert Drive(most=5.0, gain=0.1).started(DT, 2)(100.0) == pytest.approx([5.0, 5.0])


def wide(seconds: float = 1.0) -> np.ndarray:
    return multisine(8.0, 5.0, 5.0, 1e-3, 1)[: round(seconds * 1e3)] + square(8.0, 0.5, seconds, 1e-3)


def test_the_controller_follows_a_slow_reference() -> None:
    ref = triangle(20.0, 2.0, 2.0, 1e-3)
    recording = experiment(Rig(Base()), SILENT, ref, 1e-3, seed=0)
    assert np.sqrt(np.mean((recording.speed - ref) ** 2)) < 3.0
    assert np.sqrt(np.mean(recording.speed**2)) > 9.0


def test_noise_is_as_asked_and_the_torque_that_acts_is_free_of_it() -> None:
    ref = np.zeros(4000)
    recording = experiment(Rig(Base(Fc=100.0)), Loop(torque_noise=0.1, speed_noise=0.0), ref, 1e-3, seed=3)
    assert recording.torque.std() == pytest.approx(0.1, rel=0.05)
    assert not recording.speed.any()
    noisy = experiment(Rig(Base(Fc=100.0)), Loop(0.0, 0.0, speed_noise=0.02), ref, 1e-3, seed=3)
    assert noisy.speed.std() == pytest.approx(0.02, rel=0.05)


@pytest.mark.parametrize("name", ["motor.stribeck", "gear.backlash", "motor.presliding", "gear.hysteresis"])
def test_finer_steps_change_far_less_than_the_noise(name: str) -> None:
    effect = EFFECTS[name]
    rig = effect.build(Rig(Base()), effect.size, effect.shape(np.random.default_rng(0)))
    usual, fine = (experiment(rig, SILENT, wide(), 1e-3, 0, substeps) for substeps in (20, 80))
    assert np.sqrt(np.mean((usual.speed - fine.speed) ** 2)) < 0.1 * 0.02


@pytest.fixture(scope="module")
def untouched() -> Recording:
    return experiment(Rig(Base()), SILENT, wide(0.7), 1e-3, 0)


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_moves_the_machine_otherwise(name: str, untouched: Recording) -> None:
    effect = EFFECTS[name]
    rig = effect.build(Rig(Base()), 3 * effect.size, effect.shape(np.random.default_rng(0)))
    recording = experiment(rig, SILENT, wide(0.7), 1e-3, 0)
    torque, speed = recording.torque - untouched.torque, recording.speed - untouched.speed
    assert max(abs(torque).max() / 0.005, abs(speed).max() / 0.02) > 1.0


def test_draws_repeat_and_stay_within_their_spread() -> None:
    one, again, other = (draw(np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert one.base == again.base != other.base
    assert all(np.array_equal(a.ref, b.ref) for a, b in zip(one.plans, again.plans, strict=True))
    ratios = np.array(one.base.values()[:-1]) / np.array(Base().values()[:-1])
    assert np.abs(ratios - 1.0).max() <= 0.3


def test_csv_holds_the_signals(tmp_path: Path) -> None:
    recording = experiment(Rig(Base()), Loop(), wide(0.1), 1e-3, 0)
    write_csv(tmp_path / "a.csv", recording)
    t, torque, angle, speed = np.loadtxt(tmp_path / "a.csv", delimiter=",", skiprows=1, unpack=True)
    assert t == pytest.approx(np.arange(100) * 1e-3)
    assert torque == pytest.approx(recording.torque, rel=1e-8)
    assert angle == pytest.approx(recording.angle, rel=1e-8)
    assert speed == pytest.approx(recording.speed, rel=1e-8)
