"""The noise floor of a speed that is derived from an encoder, beside what the encoder did to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.mistaken_logs import RIGID

from robotid.catalogue import assemble
from robotid.diagnosis.noise.noise_floor import noise_levels
from robotid.diagnosis.noise.quantisation import between_counts, quantisation_spectrum, rounding_error
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


def reference(h: float, speed: float = 20.0) -> Reference:
    """Three seconds of a square wave under a multisine up to 20 Hz, up to a speed [rad/s]."""
    t, lines = np.arange(round(3.0 / h)) * h, np.arange(1, 121)
    phases = np.random.default_rng(1).uniform(0, 2 * np.pi, len(lines))
    wave = np.sin(2 * np.pi * np.outer(t / 6.0, lines) + phases).sum(axis=1)
    square = np.sign(np.sin(2 * np.pi * t / 3.0 + 1e-9))
    return Reference("log", h, speed * (0.4 * wave / np.abs(wave).max() + 0.6 * square), "speed")


def recorded(h: float, counts: int, speed: float) -> Record:
    """By an encoder alone."""
    truth = RIGID | STRIBECK
    joint = joint_of(truth)
    theta = joint.parameters().with_values(truth).values
    plant = VirtualRobot(joint, theta, Controller("speed", 0.5, 5.0), 2 * np.pi / counts)
    log = plant.record(reference(h, speed), 0)
    table = Table("log.csv", {"t": log.t, "tau_m": log.tau_m, "phi_m": log.phi_m})
    ((record, _),) = measured_records(Selection("log"), table)
    return record


def segment(values: dict[str, float], record: Record) -> SimulatedSegment:
    joint = joint_of(values)
    trajectory = simulate(joint, joint.parameters().with_values(values).values, record, np.zeros(joint.nx))
    return SimulatedSegment(record, trajectory, measured_output(record, "speed") - observed(trajectory, "speed"))


def joint_of(values: dict[str, float]) -> Joint:
    return assemble(Structure(tuple(dict.fromkeys(name.rpartition(".")[0] for name in values))), angle=True)


@pytest.mark.parametrize(("h", "counts"), [(5e-4, 2**18), (5e-4, 4096), (2e-3, 100)])
def test_the_floor_is_what_the_encoder_makes_of_the_speed_with_or_without_a_misfit(h: float, counts: int) -> None:
    record = recorded(h, counts, 20.0)
    right, wrong = segment(RIGID | STRIBECK, record), segment(RIGID, record)
    made = float(np.sqrt(np.mean(right.residual**2)))
    for one in (right, wrong):
        assert noise_levels([one], "speed")[0].floor == pytest.approx(made, rel=0.05)


@pytest.mark.parametrize(
    ("h", "counts", "speed"),
    [(5e-4, 100, 20.0), (5e-4, 100, 4.0), (2e-3, 100, 4.0), (2e-3, 100, 1.0), (4e-3, 100, 1.0), (5e-4, 4096, 1.0)],
)
def test_so_it_is_where_the_motor_takes_several_samples_from_count_to_count(
    h: float, counts: int, speed: float
) -> None:
    one = segment(RIGID | STRIBECK, recorded(h, counts, speed))
    made = float(np.sqrt(np.mean(one.residual**2)))
    assert noise_levels([one], "speed")[0].floor == pytest.approx(made, rel=0.05)


def test_an_encoder_that_passes_many_quanta_a_sample_adds_white_noise() -> None:
    encoder = quantisation_spectrum(recorded(2e-3, 4096, 20.0), "speed")
    assert encoder is not None
    for band in np.array_split(encoder[8:], 4):
        assert band.mean() == pytest.approx(1.0, rel=0.1)


def test_a_measured_speed_has_no_noise_of_an_encoder() -> None:
    record = recorded(2e-3, 100, 4.0)
    assert quantisation_spectrum(replace(record, speed_origin="sensor"), "speed") is None
    smooth = replace(record, phi_m=np.sin(record.t) + 1e-3 * np.sin(1e5 * record.t))
    assert quantisation_spectrum(smooth, "speed") is None
    assert quantisation_spectrum(record, "position") is not None


def test_between_counts_an_angle_passes_in_straight_lines() -> None:
    ramp = 0.13 * np.arange(400.0)
    found = between_counts(np.rint(ramp), 1.0, np.random.default_rng(2))
    assert np.abs(found - ramp)[8:-8].max() < 0.2
    assert np.abs(rounding_error(ramp, 1.0, 0.3)).max() <= 0.5
    assert not between_counts(np.zeros(9), 1.0, np.random.default_rng(2)).any()
