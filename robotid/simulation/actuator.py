"""The torque that acts on a joint: the recorded one after the channels between the drive and the motor."""

from __future__ import annotations

from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.port import Signal
from robotid.signals.record import Record
from robotid.signals.torque_steps import TorqueSteps


def effective_torque(joint: Joint, theta: Array, sampling_time: float, torque: Array) -> Array:
    """The torque that acts, mean over each interval, for a torque (n,) [Nm] that is constant between samples, (n,)."""
    for _, channel, p, _ in joint.channels_on(theta, Signal.TORQUE):
        torque = channel.apply(torque, sampling_time, p)
    return torque


def effective_steps(joint: Joint, record: Record) -> TorqueSteps | None:
    """How the torque that acts changes within the intervals of a record; None where it is held over each, and where a
    channel makes another course of it, which is known by its mean only."""
    changed = any(signal is Signal.TORQUE for signal, _ in joint.channels)
    return None if changed else record.torque_steps


def torque_columns(joint: Joint, theta: Array, sampling_time: float, torque: Array) -> dict[int, Array]:
    """Derivatives of the effective torque to the channels' parameters: index into theta -> (n,)."""
    columns = dict[int, Array]()
    for _, channel, p, first in joint.channels_on(theta, Signal.TORQUE):
        columns = {k: channel.push(c, torque, sampling_time, p) for k, c in columns.items()}
        columns |= dict(enumerate(channel.partials(torque, sampling_time, p), start=first))
        torque = channel.apply(torque, sampling_time, p)
    return columns
