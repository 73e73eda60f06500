"""How far the first state of a record may be from what was measured.

A first state is one sample of a measured motion, and known as well as that. Were it free altogether, a model that lacks
something would begin elsewhere and simulate the record better for it: a constant torque that is not declared moved a
first speed by 57 rad/s. Between these limits least squares find it, for all samples tell it better than one.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.signals.quality import quantum
from robotid.signals.record import Record
from robotid.simulation.first_guess import MAD_OF_NORMAL

DEVIATIONS = 5.0  # of a measured sample, within which its truth lies
SHARE = 0.05  # of the RMS motion, by which a model of a real machine may err without its parameters paying for it
INTERVALS = 2.0  # by which a sensor may be late, with the motion as it is there
NEAR = 5  # samples that tell how the motion changes at the beginning
SAMPLES = 4096  # that tell the noise


def first_state_limits(joint: Joint, record: Record) -> tuple[Array, Array]:
    """Lower and upper limits of a first state, (nx,) each, about the measured one. Those of states that are not
    measured, such as the gear's and those of memory, are without end."""
    measured, away = np.zeros(joint.nx), np.full(joint.nx, np.inf)
    speed, angle = _reach(record)
    measured[joint.motor_speed], away[joint.motor_speed] = record.dphi_m[0], speed
    if joint.keeps_angle:
        measured[joint.motor_angle], away[joint.motor_angle] = record.phi_m[0], angle
    return measured - away, measured + away


def _reach(record: Record) -> tuple[float, float]:
    """How far the first speed and the first angle may be from what was measured."""
    if record not in _reaches:
        travel = record.phi_m - record.phi_m.mean()
        speed = DEVIATIONS * speed_accuracy(record) + _leeway(record.dphi_m, record.dphi_m)
        _reaches[record] = speed, DEVIATIONS * angle_accuracy(record) + _leeway(record.phi_m, travel)
    return _reaches[record]


_reaches: WeakKeyDictionary[Record, tuple[float, float]] = WeakKeyDictionary()
"""Of records that are in use: a search asks for those of its pieces with every refit, and a quantum is slow to tell."""


def speed_accuracy(record: Record) -> float:
    """Standard deviation of a measured speed [rad/s]: its noise from sample to sample, and at least the quantum's."""
    angle, speed = record.phi_m[:SAMPLES], record.dphi_m[:SAMPLES]
    return float(max(_noise(speed), quantum(angle) / np.sqrt(6.0) / record.sampling_time))


def angle_accuracy(record: Record) -> float:
    """Standard deviation of a measured angle [rad], alike."""
    angle = record.phi_m[:SAMPLES]
    return float(max(_noise(angle), quantum(angle) / np.sqrt(12.0)))


def _noise(signal: Array) -> float:
    return float(np.median(np.abs(np.diff(signal, 2))) / (MAD_OF_NORMAL * np.sqrt(6.0))) if len(signal) > 2 else 0.0


def _leeway(signal: Array, motion: Array) -> float:
    """What a late sensor and an imperfect model may add. signal : (n,); motion : (n,) whose RMS counts."""
    step = float(np.abs(np.diff(signal[:NEAR])).max(initial=0.0))
    return INTERVALS * step + SHARE * float(np.sqrt(np.mean(motion**2)))
