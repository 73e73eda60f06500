"""Small logs of a motor, as a person would have them: arrays by name, from a simulated motion of known parameters."""

from __future__ import annotations

import numpy as np

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

TRUTH = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.6}
STRIBECK = {"motor.stribeck.dFs": 0.25, "motor.stribeck.vs": 2.0}
H = 0.002


def motor_log(*, seed: int = 1, stribeck: bool = False, duration: float = 4.0) -> dict[str, Array]:
    """Time [s], torque [Nm] and angle_deg of a motor under a speed controller, (n,) each. seed : of the reference and
    the noise; stribeck : its friction has a Stribeck effect."""
    truth = TRUTH | (STRIBECK if stribeck else {})
    structure = Structure(tuple(dict.fromkeys(name.rpartition(".")[0] for name in truth)))
    joint = assemble(structure, angle=True)
    t = np.arange(round(duration / H)) * H
    rng = np.random.default_rng(seed)
    lines = np.arange(1, 25)
    phase, peak = rng.uniform(0, 2 * np.pi, len(lines)), 12.0 + 2.0 * seed
    wave = np.sin(2 * np.pi * np.outer(t, lines) / duration + phase).sum(axis=1) - np.sin(phase).sum()
    reference = peak * (wave / np.abs(wave).max() + 0.5 * np.sin(2 * np.pi * 2 * t / duration))
    values = joint.parameters().with_values(truth).values
    plant = VirtualRobot(joint, values, Controller("speed", 0.5, 5.0), 2 * np.pi / 65536, 0.005, 0.0, seed=seed)
    record = plant.record(Reference("log", H, reference, "speed"), 0)
    return {"time": record.t, "torque": record.tau_m, "angle_deg": np.rad2deg(record.phi_m)}
