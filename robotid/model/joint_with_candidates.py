"""A joint with effects that it lacks: each at its null, where it changes nothing but shows what it would add."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.model.array import Array
from robotid.model.derivatives import Derivatives, Tangent, absent
from robotid.model.joint import Joint
from robotid.model.port import Port
from robotid.model.port_motion import PortMotion
from robotid.model.reads import reads_of
from robotid.model.term import Motion, Term


class JointWithCandidates(Joint):
    """A joint that keeps its angle, with candidates : (port, term) pairs that it lacks. Their parameters follow all
    others in theta; their memory is read from further rows of x."""

    def __init__(self, joint: Joint, candidates: Sequence[tuple[Port, Term]]) -> None:
        super().__init__(joint.structure, joint.terms, joint.channels, angle=True)
        self.companions = joint.companions
        placed, theta, memory = [], len(self.names), self.nx
        for port, term in candidates:
            placed.append(self._place(port, term, theta, memory, 0, reads_of(term), acts=False))
            theta, memory = placed[-1].at.stop, placed[-1].z.stop
        self.candidates = tuple(placed)

    def candidate_motions(self, x: Array, s: Array, t: Array, theta: Array) -> list[Motion]:
        """The motion that each candidate acts on, its memory zero. Arguments as of `candidate_forces`, x (nx, n)."""
        places = (*self.placed, *self.candidates)
        rows = sum(len(place.term.states) for place in self.candidates)
        motions = self._port_motions(np.concatenate([x, np.zeros((rows, x.shape[1]))]), s, t, theta, places)
        return [motion.m for motion in motions[len(self.placed) :]]

    def candidate_forces(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Generalised forces that the candidates' parameters add, each per unit, mean over the intervals between the
        samples, (nv, k, n - 1).

        x : (nx + their memory, n) states; s : (nv, n) directions; t : (n,); theta : (p + k,), each candidate at its
        null. A transformed speed may jump where the transformed position does not: there it counts by the change of the
        position.
        """
        places, first = (*self.placed, *self.candidates), len(self.names)
        motions = self._port_motions(x, s, t, theta, places)
        forces = np.zeros((self.masses, len(theta) - first, x.shape[1]))
        wanted = Derivatives(None, forces, {c: c - first for c in range(first, len(theta))})
        follow = [place.at for place in self.candidates if place.transform is not None and place.transform.follows]
        jumping = [c for at in follow for c in range(at.start, at.stop)]
        for place, motion in zip(places, motions, strict=True):
            steady = {c: value for c, value in motion.v.parameters.items() if c not in jumping}
            self._add_torque(place, replace(motion, v=Tangent(motion.v.states, steady)), theta, wanted)
        means = np.asarray((forces[:, :, 1:] + forces[:, :, :-1]) / 2)
        means[:, [c - first for c in jumping]] += np.diff(self._momenta(motions, theta, jumping), axis=2) / np.diff(t)
        self._add_accelerated(means, motions[len(self.placed) :], x, t, theta)
        return means

    def _add_accelerated(self, means: Array, motions: Sequence[PortMotion], x: Array, t: Array, theta: Array) -> None:
        """Add what the accelerations cause, to which torques are affine: its mean is known exactly, from the speeds."""
        first, n = len(self.names), x.shape[1]
        for place, motion in zip(self.candidates, motions, strict=True):
            if not place.reads_acceleration:
                continue
            where = {c: k for k, c in enumerate(range(place.at.start, place.at.stop))}
            unit, rest = (np.zeros((self.masses, len(where), n)) for _ in range(2))
            self._add_torque(place, motion.accelerated(np.ones(n)), theta, Derivatives(None, unit, where))
            self._add_torque(place, motion, theta, Derivatives(None, rest, where))
            slope, speed = unit - rest, np.sum([c * x[row] for row, c in place.v], axis=0)
            columns = slice(place.at.start - first, place.at.stop - first)
            means[:, columns] += (slope[:, :, 1:] + slope[:, :, :-1]) / 2 * np.diff(speed) / np.diff(t)

    def _momenta(self, motions: Sequence[PortMotion], theta: Array, jumping: Sequence[int]) -> Array:
        """Generalised momenta of what dampers absorb of changes of position with the parameters `jumping`,
        (nv, k, n)."""
        momenta = np.zeros((self.masses, len(jumping), motions[0].m.v.size))
        for place, motion in zip(self.placed, motions, strict=False):
            slope = place.term.partials(motion.m, place.values(theta)).v
            for k, c in enumerate(jumping):
                moved = motion.x.parameters.get(c, 0.0)
                for lever in () if absent(slope) or absent(moved) else motion.levers:
                    momenta[lever.j, k] -= lever.c * slope * moved
        return momenta
