"""The torque that acts on a joint: the recorded one after the channels between the drive and the motor.

A channel with memory, a lag or a delay, makes a torque that changes within the sampling intervals, also of one that is
held over each. When in an interval it changes decides when dry friction reverses, so the channels are applied to equal
parts of the intervals, and of what they yield the mean and one step are kept (`TorqueSteps`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.joint import Joint
from robotid.model.port import Signal
from robotid.signals.record import Record
from robotid.signals.torque_steps import PARTS, TorqueColumn, TorqueSteps
from robotid.simulation.friction.step import Steps


@dataclass(frozen=True, slots=True, eq=False)
class ActingTorque:
    """The torque that acts on a motor. mean : (n,) [Nm] over each interval; steps : how it changes within them, None
    where it is held."""

    mean: Array
    steps: TorqueSteps | None = None

    def take(self, where: slice) -> ActingTorque:
        """That of these intervals."""
        return ActingTorque(self.mean[where], None if self.steps is None else self.steps.take(where))


def acting_torque(joint: Joint, theta: Array, record: Record) -> ActingTorque:
    """The torque of a record as it acts on the motor."""
    return through_channels(joint, theta, record.sampling_time, record.tau_m, record.torque_steps)


def through_channels(
    joint: Joint, theta: Array, sampling_time: float, torque: Array, steps: TorqueSteps | None = None
) -> ActingTorque:
    """What channels make of a torque, (n,) [Nm] mean over each interval, that changes within them by these steps."""
    parts, signal = _in_parts(joint, torque, steps)
    for channel, p, _ in _channels(joint, theta, parts):
        signal = channel.apply(signal, sampling_time / parts, p)
    return ActingTorque(signal, steps) if parts == 1 else ActingTorque(*TorqueSteps.of_parts(signal, parts))


def effective_torque(joint: Joint, theta: Array, sampling_time: float, torque: Array) -> Array:
    """The torque that acts, mean over each interval, for a torque (n,) [Nm] that is constant between samples, (n,)."""
    for channel, p, _ in _channels(joint, theta, 1):
        torque = channel.apply(torque, sampling_time, p)
    return torque


def torque_columns(joint: Joint, theta: Array, record: Record) -> dict[int, TorqueColumn]:
    """Derivatives of the torque that acts to the channels' parameters, by index into theta."""
    columns, h = dict[int, Array](), record.sampling_time
    parts, signal = _in_parts(joint, record.tau_m, record.torque_steps)
    for channel, p, first in _channels(joint, theta, parts):
        columns = {k: channel.push(c, signal, h / parts, p) for k, c in columns.items()}
        columns |= dict(enumerate(channel.partials(signal, h / parts, p), start=first))
        signal = channel.apply(signal, h / parts, p)
    if parts == 1:
        return {k: TorqueColumn(c) for k, c in columns.items()}
    return {k: TorqueSteps.change_of_parts(signal, c, parts) for k, c in columns.items()}


def torque_response(steps: Steps, column: TorqueColumn, at: slice) -> Array:
    """What a change of the torque, by its column over a record, changes of the ends of these of its steps, (nx, n)."""
    assert steps.S is not None
    response = steps.S[:, -1] * column.mean[at]
    if steps.within is not None and column.step is not None and column.share is not None:
        response += steps.within[:, 0] * column.step[at] + steps.within[:, 1] * column.share[at]
    return np.asarray(response)


def changes_within(joint: Joint) -> bool:
    """Whether channels make a held torque change within the sampling intervals."""
    return any(signal is Signal.TORQUE and channel.has_memory for signal, channel in joint.channels)


def _in_parts(joint: Joint, torque: Array, steps: TorqueSteps | None) -> tuple[int, Array]:
    """Into how many parts intervals are cut, one where no channel sees a change within them, and the mean torque of
    each."""
    if not (changes_within(joint) if steps is None else any(signal is Signal.TORQUE for signal, _ in joint.channels)):
        return 1, torque
    return PARTS, np.repeat(torque, PARTS) if steps is None else steps.in_parts(torque, PARTS)


def _channels(joint: Joint, theta: Array, parts: int) -> Iterator[tuple[Channel, list[float], int]]:
    """The channels on the torque in their order, for signals with parts of intervals as samples, with their parameters
    and the index of the first of these in theta."""
    for _, channel, p, first in joint.channels_on(theta, Signal.TORQUE):
        yield channel.on_parts(parts), p, first
