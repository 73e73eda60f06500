"""What encoder and speed sensor show of a motion, after the channels on them, and its derivatives.

The speed is the time derivative of the angle that is recorded: what distorts the angle distorts it, too. Where the
record has no sensor for it, the simulated speed is derived from the simulated angle by the operator of the record.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.joint import Joint
from robotid.model.port import Signal
from robotid.signals.record import OPERATORS, SpeedOrigin
from robotid.simulation.trajectory import Trajectory

COMPLEX_STEP = 1e-30  # so small that its square vanishes


def sensor_signals(
    joint: Joint,
    theta: Array,
    sampling_time: float,
    phi_m: Array,
    dphi_m: Array,
    speed_origin: SpeedOrigin = "sensor",
) -> tuple[Array, Array]:
    """Angle and speed as sensors show them. phi_m, dphi_m (n,) -> the same."""
    if speed_origin in OPERATORS:
        for _, channel, p, _ in joint.channels_on(theta, Signal.ANGLE):
            phi_m = channel.apply(phi_m, sampling_time, p)
        dphi_m = OPERATORS[speed_origin](phi_m, sampling_time)
        for _, channel, p, _ in joint.channels_on(theta, Signal.SPEED):
            dphi_m = channel.apply(dphi_m, sampling_time, p)
        return phi_m, dphi_m
    for signal, channel, p, _ in joint.channels_on(theta, Signal.ANGLE, Signal.SPEED):
        if signal is Signal.SPEED:
            dphi_m = channel.apply(dphi_m, sampling_time, p)
        else:
            dphi_m = channel.push(dphi_m, phi_m, sampling_time, p)
            phi_m = channel.apply(phi_m, sampling_time, p)
    return phi_m, dphi_m


def sensor_columns(
    trajectory: Trajectory, columns: Sequence[int], to_phi: Array, to_dphi: Array
) -> tuple[Array, Array]:
    """Derivatives of what sensors show, from those of the motion itself, to_phi and to_dphi (m, n): those to
    theta[columns] first. Of a speed that is derived from the angle to_phi alone counts."""
    if trajectory.speed_origin in OPERATORS:
        return _derived_columns(trajectory, columns, to_phi)
    phi, dphi, h = trajectory.phi_m, trajectory.dphi_m, trajectory.sampling_time
    for signal, channel, p, wanted in _wanted(trajectory, columns, Signal.ANGLE, Signal.SPEED):
        if signal is Signal.SPEED:
            to_dphi = _with_own(channel.push(to_dphi, dphi, h, p), channel.partials(dphi, h, p), wanted)
            dphi = channel.apply(dphi, h, p)
            continue
        analytic: Any = channel  # though typed for real signals only
        moved, moving = phi + 1j * COMPLEX_STEP * to_phi, phi + 1j * COMPLEX_STEP * dphi
        by_angle = np.imag(analytic.push(dphi, moved, h, p)) / COMPLEX_STEP if to_phi.any() else 0.0
        own = np.imag(analytic.partials(moving, h, p)) / COMPLEX_STEP
        to_dphi = _with_own(channel.push(to_dphi, phi, h, p) + by_angle, own, wanted)
        to_phi = _with_own(channel.push(to_phi, phi, h, p), channel.partials(phi, h, p), wanted)
        phi, dphi = channel.apply(phi, h, p), channel.push(dphi, phi, h, p)
    return to_phi, to_dphi


def _derived_columns(trajectory: Trajectory, columns: Sequence[int], to_phi: Array) -> tuple[Array, Array]:
    """The same where the speed is derived from the angle: the operator is linear, and takes columns as signals."""
    phi, h = trajectory.phi_m, trajectory.sampling_time
    derive = OPERATORS[trajectory.speed_origin]
    for _, channel, p, wanted in _wanted(trajectory, columns, Signal.ANGLE):
        to_phi = _with_own(channel.push(to_phi, phi, h, p), channel.partials(phi, h, p), wanted)
        phi = channel.apply(phi, h, p)
    dphi, to_dphi = derive(phi, h), derive(to_phi, h)
    for _, channel, p, wanted in _wanted(trajectory, columns, Signal.SPEED):
        to_dphi = _with_own(channel.push(to_dphi, dphi, h, p), channel.partials(dphi, h, p), wanted)
        dphi = channel.apply(dphi, h, p)
    return to_phi, to_dphi


def _wanted(
    trajectory: Trajectory, columns: Sequence[int], *signals: Signal
) -> Iterator[tuple[Signal, Channel, Sequence[float], list[tuple[int, int]]]]:
    """The channels on signals, with their parameters, and for each of these that is among theta[columns] its place
    there and its number."""
    places = {c: k for k, c in enumerate(columns)}
    for signal, channel, p, first in trajectory.joint.channels_on(trajectory.theta, *signals):
        yield signal, channel, p, [(places[first + i], i) for i in range(len(p)) if first + i in places]


def _with_own(columns: Array, own: Array, wanted: Sequence[tuple[int, int]]) -> Array:
    """Columns (m, n) with a channel's own derivatives (p, n) added where they are wanted."""
    columns = columns.copy()
    for k, i in wanted:
        columns[k] += own[i]
    return columns
