"""A joint with effects that it lacks: each at its null, where it changes nothing, and tells what it would add."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.port import Port
from robotid.model.port_motion import PortMotion, absent
from robotid.model.reads import reads_of
from robotid.model.term import Motion, Term


class JointWithCandidates(Joint):
    """A joint that keeps its angle, with candidates : (port, term) pairs that it lacks. Their parameters follow all
    others in theta; their memory is read from further rows of x."""

    def __init__(self, joint: Joint, candidates: Sequence[tuple[Port, Term]]) -> None:
        super().__init__(joint.structure, joint.terms, joint.channels, angle=True)
        placed, theta, memory = [], len(self.names), self.nx
        for port, term in candidates:
            placed.append(self._place(port, term, theta, memory, 0, reads_of(term), acts=False))
            theta, memory = placed[-1].at.stop, placed[-1].z.stop
        self.candidates = tuple(placed)

    def candidate_motions(self, x: Array, s: Array, t: Array, theta: Array) -> list[Motion]:
        """What each candidate feels, its memory zero. Arguments as of `candidate_forces`, x (nx, n)."""
        places = (*self.placed, *self.candidates)
        rows = sum(len(place.term.states) for place in self.candidates)
        felts = self._feel(np.concatenate([x, np.zeros((rows, x.shape[1]))]), s, t, theta, places)
        return [felt.m for felt in felts[len(self.placed) :]]

    def candidate_forces(self, x: Array, s: Array, t: Array, theta: Array) -> Array:
        """Generalised forces that the candidates' parameters add, each per unit, mean over the intervals between the
        samples, (nv, k, n - 1).

        x : (nx + their memory, n) states; s : (nv, n) directions; t : (n,); theta : (p + k,), each candidate at its
        null. A bent speed may jump where the bent position does not: there it counts by the change of the position.
        """
        places, first = (*self.placed, *self.candidates), len(self.names)
        felts = self._feel(x, s, t, theta, places)
        forces = np.zeros((self.masses, len(theta) - first, x.shape[1]))
        where = {self.nx + c: c - first for c in range(first, len(theta))}
        follow = [place.at for place in self.candidates if getattr(place.term, "follows", False)]
        jumping = [c for at in follow for c in range(at.start, at.stop)]
        for place, felt in zip(places, felts, strict=True):
            steady = {key: value for key, value in felt.v.items() if key - self.nx not in jumping}
            self._add_torque(place, replace(felt, v=steady), theta, None, forces, where)
        means = np.asarray((forces[:, :, 1:] + forces[:, :, :-1]) / 2)
        means[:, [c - first for c in jumping]] += np.diff(self._momenta(felts, theta, jumping), axis=2) / np.diff(t)
        return means

    def _momenta(self, felts: Sequence[PortMotion], theta: Array, columns: Sequence[int]) -> Array:
        """Generalised momenta of what dampers feel of changes of position with theta[columns], (nv, k, n)."""
        momenta = np.zeros((self.masses, len(columns), felts[0].m.v.size))
        for place, felt in zip(self.placed, felts, strict=False):
            slope = place.term.partials(felt.m, place.values(theta)).v
            for k, c in enumerate(columns):
                moved = felt.x.get(self.nx + c, 0.0)
                for lever in () if absent(slope) or absent(moved) else felt.levers:
                    momenta[lever.j, k] -= lever.c * slope * moved
        return momenta
