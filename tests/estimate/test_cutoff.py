"""Start values on noisy and coarse logs: within a factor of two, whatever the sensor, the sampling and the motion."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from robotid.catalogue import assemble
from robotid.estimate.cutoff import noise_limit
from robotid.estimate.rigid import RigidResult, fit_rigid
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

RATIO = 1 / 224.3
FRICTION = {"motor.inertia.J": 0.0121, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.3}
GEAR = {"gear.spring.k1": 1.46e6, "gear.damper.d": 2.63e3, "arm.inertia.J": 1130.0}
TRUTHS = {"rigid": FRICTION, "flexible": FRICTION | GEAR}
SENSORS = {
    "clean": (0.0, 0, 0.0),
    "noisy angle": (1e-3, 0, 0.0),
    "100 counts": (0.0, 100, 0.0),
    "500 counts": (0.0, 500, 0.0),
    "4096 counts": (0.0, 4096, 0.0),
    "loud torque": (0.0, 0, 0.5),
    "noisy angle, loud torque": (1e-3, 0, 0.2),
    "100 counts, loud torque": (0.0, 100, 0.2),
}
GRID = [
    (plant, h, motion, sensor)
    for plant in TRUTHS
    for h in (0.5e-3, 1e-3, 4e-3, 10e-3)
    for motion in ("triangle", "multisine")
    for sensor in SENSORS
]


@cache
def clean(plant: str, h: float, motion: str) -> Record:
    """Six seconds of a speed-controlled axis, without any noise."""
    truth, t = TRUTHS[plant], np.arange(int(6 / h)) * h
    terms = tuple(dict.fromkeys(name.rpartition(".")[0] for name in truth))
    joint = assemble(Structure(terms, gear_ratio=RATIO if plant == "flexible" else None), angle=True)
    lines = np.arange(2, 41) / 2
    phases = -np.pi * np.arange(39) * np.arange(1, 40) / 39
    sines = np.cos(2 * np.pi * np.outer(t, lines) + phases).sum(axis=1)
    triangle = 60 / np.pi * np.arcsin(np.sin(np.pi * t))
    reference = triangle if motion == "triangle" else 15 * sines / np.abs(sines).max()
    slow = 1.0 if h < 5e-3 else 0.3  # of the gains: a slow loop must be soft
    controller = Controller("speed", 0.3 * slow, 3.0 * slow**2)
    robot = VirtualRobot(joint, joint.parameters().with_values(truth).values, controller, 0.0)
    return robot.record(Reference(motion, h, reference, "speed", None, None), 1)


def measured(plant: str, h: float, motion: str, sensor: str) -> Record:
    """The same as a sensor shows it."""
    noise, counts, loud = SENSORS[sensor]
    record, rng = clean(plant, h, motion), np.random.default_rng(0)
    angle = record.phi_m + noise * rng.standard_normal(len(record))
    if counts:
        angle = 2 * np.pi / counts * np.round(0.3 + angle * counts / (2 * np.pi))
    torque = record.tau_m + loud * record.tau_m.std() * rng.standard_normal(len(record))
    return replace(record, phi_m=angle, tau_m=torque, dphi_m=np.gradient(angle, h))


def start(plant: str, record: Record) -> RigidResult:
    joint = assemble(Structure(tuple(dict.fromkeys(n.rpartition(".")[0] for n in TRUTHS[plant])), gear_ratio=RATIO))
    if plant == "rigid":
        joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
    return fit_rigid(joint, joint.parameters(), [record])


@pytest.mark.parametrize(("plant", "h", "motion", "sensor"), GRID)
def test_start_values_are_within_a_factor_of_two(plant: str, h: float, motion: str, sensor: str) -> None:
    """Inertia, and friction at the speed of the motion: how it is shared by viscous and dry friction may be unknown."""
    guesses, speed = start(plant, measured(plant, h, motion, sensor)).guesses, clean(plant, h, motion).dphi_m.std()
    inertia = [g["motor.inertia.J"] + RATIO**2 * g.get("arm.inertia.J", 0.0) for g in (guesses, TRUTHS[plant])]
    friction = [g["motor.coulomb.Fc"] + g["motor.viscous.Fv"] * speed for g in (guesses, TRUTHS[plant])]
    assert 0.5 < inertia[0] / inertia[1] < 2.0
    assert 0.5 < friction[0] / friction[1] < 2.0
    assert min(guesses.values()) >= 0.0


@pytest.mark.parametrize("sensor", ["clean", "4096 counts", "noisy angle"])
def test_dry_and_viscous_friction_of_a_triangle_are_told_apart(sensor: str) -> None:
    found = start("rigid", measured("rigid", 1e-3, "triangle", sensor)).guesses
    assert found["motor.coulomb.Fc"] == pytest.approx(FRICTION["motor.coulomb.Fc"], rel=0.2)
    assert found["motor.viscous.Fv"] == pytest.approx(FRICTION["motor.viscous.Fv"], rel=0.2)


def test_noise_lowers_the_cut_off_and_a_good_record_keeps_it() -> None:
    limits = {s: noise_limit(measured("rigid", 1e-3, "triangle", s), 2.0, 80.0) for s in SENSORS}
    assert limits["clean"] == 80.0
    assert limits["100 counts"] < limits["500 counts"] < limits["4096 counts"] <= 80.0
    assert limits["noisy angle"] < 50.0


def test_few_samples_a_period_bound_the_cut_off() -> None:
    record = clean("rigid", 10e-3, "multisine")
    assert noise_limit(record, 1.0, 40.0) == pytest.approx(1 / (12 * 10e-3))
