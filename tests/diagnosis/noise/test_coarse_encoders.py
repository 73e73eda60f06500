"""The noise floor of a speed that is derived from an encoder, beside what the encoder did to it."""

from __future__ import annotations

import numpy as np
import pytest
from support.mistaken_logs import RIGID

from robotid.catalogue import assemble
from robotid.diagnosis.noise.noise_floor import noise_levels
from robotid.estimate.fitted_model import SimulatedSegment
from robotid.estimate.residual import measured_output, observed
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.measured import Selection, measured_records
from robotid.signals.readers.table import Table
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate

STRIBECK = {"motor.stribeck.dFs": 0.15, "motor.stribeck.vs": 2.0}


def reference(h: float) -> Reference:
    """Three seconds of a square wave under a multisine up to 20 Hz [rad/s]."""
    t, lines = np.arange(round(3.0 / h)) * h, np.arange(1, 121)
    phases = np.random.default_rng(1).uniform(0, 2 * np.pi, len(lines))
    wave = np.sin(2 * np.pi * np.outer(t / 6.0, lines) + phases).sum(axis=1)
    return Reference(
        "log", h, 8 * wave / np.abs(wave).max() + 12 * np.sign(np.sin(2 * np.pi * t / 3.0 + 1e-9)), "speed"
    )


def segment(values: dict[str, float], record: Record) -> SimulatedSegment:
    joint = joint_of(values)
    trajectory = simulate(joint, joint.parameters().with_values(values).values, record, np.zeros(joint.nx))
    return SimulatedSegment(record, trajectory, measured_output(record, "speed") - observed(trajectory, "speed"))


def joint_of(values: dict[str, float]) -> Joint:
    return assemble(Structure(tuple(dict.fromkeys(name.rpartition(".")[0] for name in values))), angle=True)


@pytest.mark.parametrize(("h", "counts"), [(5e-4, 2**18), (5e-4, 4096), (2e-3, 100)])
def test_the_floor_is_what_the_encoder_makes_of_the_speed_with_or_without_a_misfit(h: float, counts: int) -> None:
    truth = RIGID | STRIBECK
    joint = joint_of(truth)
    theta = joint.parameters().with_values(truth).values
    plant = VirtualRobot(joint, theta, Controller("speed", 0.5, 5.0), 2 * np.pi / counts)
    log = plant.record(reference(h), 0)
    table = Table("log.csv", {"t": log.t, "tau_m": log.tau_m, "phi_m": log.phi_m})
    ((record, _),) = measured_records(Selection("log"), table)
    right, wrong = segment(truth, record), segment(RIGID, record)
    made = float(np.sqrt(np.mean(right.residual**2)))
    for one in (right, wrong):
        assert noise_levels([one], "speed")[0].floor == pytest.approx(made, rel=0.05)
