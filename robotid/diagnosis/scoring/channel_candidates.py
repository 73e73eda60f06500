"""Channels as candidates: effects on the recorded torque, and on the measured signal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from robotid.diagnosis.scoring.candidate import EffectCandidate, columns_of, scored_parameters
from robotid.estimate.residual import output_columns, output_rows
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.parameters import Parameter
from robotid.model.port import Signal
from robotid.signals.record import Quantity, Record
from robotid.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class ChannelCandidate(EffectCandidate):
    """A channel on a signal that lacks it."""

    place: Signal
    effect: Channel

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.effect.parameters

    @property
    def is_late(self) -> bool:
        return self.effect.is_late


@dataclass(frozen=True, slots=True)
class TorqueChannelCandidate(ChannelCandidate):
    """A channel on the recorded torque: what it changes of that is a force on the motor."""

    @classmethod
    def forces(cls, group: Sequence[Self], motion: Trajectory, record: Record) -> Array:
        forces = np.zeros((motion.joint.masses, scored_parameters(group), len(record)))
        for one, at in zip(group, columns_of(group), strict=True):
            effect = one.effect.beside(motion.joint.companions)
            forces[0, at] = effect.partials(motion.u, record.sampling_time, one.values)[list(one.scored)]
        return forces


@dataclass(frozen=True, slots=True)
class SensorChannelCandidate(ChannelCandidate):
    """A channel on the measured signal, behind all others there: it changes the output, not the motion."""

    @classmethod
    def columns(cls, group: Sequence[Self], motion: Trajectory, output: Quantity, driven: Array) -> Array:
        return np.concatenate([driven, *(one._sensed(motion, output) for one in group)])

    def _sensed(self, motion: Trajectory, output: Quantity) -> Array:
        """Its own columns, (k, n)."""
        joint = motion.joint
        extended = joint.with_more(channels=[(self.place, self.effect)], angle=True)
        at = len(joint.names) - len(joint.changes)
        theta = np.insert(motion.theta, at, self.values)
        columns = [at + k for k in self.scored]
        rows = output_rows(extended, output, motion.speed_origin)
        still = np.zeros((len(rows), len(columns), len(motion.u)))
        return output_columns(replace(motion, joint=extended, theta=theta), output, columns, still)
