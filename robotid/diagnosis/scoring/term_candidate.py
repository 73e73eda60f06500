"""Terms as candidates: effects that add torques at a port of the joint."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from robotid.diagnosis.scoring.candidate import EffectCandidate, ForceGradient, scored_parameters
from robotid.diagnosis.scoring.measured_motion import as_measured, with_angle
from robotid.diagnosis.scoring.periods import Wave, period_peaks
from robotid.diagnosis.scoring.resonances import Drive, resonance_peaks
from robotid.model.array import Array, blocks
from robotid.model.joint_with_candidates import JointWithCandidates
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.port_motion import Placed
from robotid.model.term import Motion, MotionTransform, Term
from robotid.signals.record import Record
from robotid.simulation.friction.mode import friction_mode
from robotid.simulation.internal_states import simulate_internal_states
from robotid.simulation.trajectory import BLOCK, Trajectory

COORDINATES = {Port.MOTOR: 0, Port.ARM: 1}
"""On which a plain torque at a port acts."""


@dataclass(frozen=True, slots=True)
class TermCandidate(EffectCandidate):
    """A term that a joint lacks, at a port."""

    place: Port
    effect: Term

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.effect.parameters

    @classmethod
    def forces(cls, group: Sequence[Self], motion: Trajectory, record: Record) -> Array:
        """All terms are placed in one joint, and evaluated along the motion together; zero after the last sample."""
        joint, theta = joint_with(motion, group)
        wanted = [placed.at.start + k for placed, one in zip(joint.candidates, group, strict=True) for k in one.scored]
        n = len(motion.u)
        memory = _memory(motion, [one for one in group if one.effect.states])
        forces = np.zeros((joint.masses, scored_parameters(group), n))
        for interval in blocks(n - 1, BLOCK):
            at = slice(interval.start, interval.stop + 1)
            x = np.concatenate([motion.x[:, at], memory[:, at]])
            s = friction_mode(motion.step_inputs(at), motion.x[:, at]).s
            joint.candidate_forces(x, s, motion.t[at], theta, wanted, out=forces[:, :, interval])
        return forces

    @property
    def family(self) -> Hashable:
        if self._counted is not None:
            return ("periods", self.name)
        if self._ringing is not None:
            return ("resonance", self.name, self.at(self._ringing, 0.0).values)
        return None

    def refine(self, gradients: Sequence[ForceGradient]) -> Iterator[Self]:
        """At the peaks of the misfit's spectrum over the angle that it goes round with, or over frequency."""
        if self._counted is not None:
            grid = self.parameters[self._counted].grid
            waves = [self._wave(self._counted, one) for one in gradients]
            linear = gradients[0].segment.trajectory.joint.structure.linear
            yield from (self.at(self._counted, n) for n in period_peaks(waves, grid, linear=linear))
        elif self._ringing is not None:
            k = self._ringing
            size = self.parameters[self.scored[0]]
            drives = [self._drive(one) for one in gradients]
            one_sided = size.bounds[0] == size.null
            peaks = resonance_peaks(drives, lambda w: self.at(k, w)._response, self.parameters[k].grid, one_sided)
            yield from (self.at(k, w) for w in peaks)

    @property
    def _counted(self) -> int | None:
        """The parameter that counts periods, of a plain torque on one coordinate or of teeth that go with the motor."""
        plain = self.place in COORDINATES and not isinstance(self.effect, MotionTransform)
        if self.effect.states or not (plain or self._meshes):
            return None
        return self.counting

    @property
    def _meshes(self) -> bool:
        return isinstance(self.effect, MotionTransform) and self.effect.watches is Port.MOTOR

    @property
    def _ringing(self) -> int | None:
        """The parameter that is the frequency of a resonance."""
        return next((k for k, p in enumerate(self.parameters) if p.rings), None)

    def _wave(self, counted: int, one: ForceGradient) -> Wave:
        """The angle that the effect goes round with, and what the residual gains from a wave of no periods."""
        motion, gradient = as_measured(one.segment.trajectory, one.segment.record), one.gradient
        if self._meshes:  # little but the twist of a stiff gear: a torque between motor and arm
            return Wave(motion.phi_m, motion.joint.ratio * gradient[0] - gradient[1])
        flat = self.at(counted, 0.0)
        [placed], [m] = port_motions(motion, [flat])
        partials = placed.term.partials(m, flat.values).theta
        factor = sum((np.asarray(partials[i]) for i in flat.scored), np.zeros(gradient.shape[1]))
        return Wave(m.x, factor * gradient[COORDINATES[placed.port]])

    def _drive(self, one: ForceGradient) -> Drive:
        """The speed of the effect's port, and what the residual gains from a torque there."""
        [placed], [m] = port_motions(with_angle(one.segment.trajectory), [self])
        gain = sum((-c * one.gradient[j] for j, c in placed.q), np.zeros(len(m.v)))
        return Drive(m.v, gain, one.segment.record.sampling_time)

    def _response(self, omega: Array) -> Array:
        """Torque of the first scored parameter, per unit, to the speed of the port, of a linear, underdamped effect, at
        the frequencies omega [rad/s], (n,)."""
        term = self.effect
        q = len(term.states)
        units, zero = np.eye(q + 1), np.zeros(q + 1)  # the speed, and each of the states
        m = Motion(zero, units[0], zero, zero, zero, units[1:])
        rates = np.stack([np.broadcast_to(rate, (q + 1,)) for rate in term.rate(m, self.values)])
        torque = np.broadcast_to(term.partials(m, self.values).theta[self.scored[0]], (q + 1,))
        poles, shapes = np.linalg.eig(rates[:, 1:])
        weights = (torque[1:] @ shapes) * np.linalg.solve(shapes, rates[:, 0])
        return np.asarray(torque[0] + (weights / (1j * omega[:, None] - poles)).sum(axis=1))


def joint_with(motion: Trajectory, group: Sequence[TermCandidate]) -> tuple[JointWithCandidates, Array]:
    """The joint of a trajectory with terms that it lacks, and all its parameters (p,)."""
    joint = JointWithCandidates(motion.joint, [(one.place, one.effect) for one in group])
    return joint, np.concatenate([motion.theta, *(np.array(one.values) for one in group)])


def port_motions(motion: Trajectory, group: Sequence[TermCandidate]) -> tuple[tuple[Placed, ...], list[Motion]]:
    """Where terms act, and the motion of their ports along a trajectory of a joint that keeps its angle."""
    joint, theta = joint_with(motion, group)
    return joint.candidates, joint.candidate_motions(motion.x, np.sign(motion.x[joint.speeds]), motion.t, theta)


def _memory(motion: Trajectory, group: Sequence[TermCandidate]) -> Array:
    """States of terms with memory, as the motion drives them, (rows, n)."""
    places, motions = port_motions(motion, group)
    rows = [
        simulate_internal_states(placed.term, m, one.values, motion.sampling_time)
        for placed, m, one in zip(places, motions, group, strict=True)
    ]
    return np.concatenate([np.zeros((0, len(motion.u))), *rows])
