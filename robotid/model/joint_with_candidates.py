"""A joint with effects that it lacks: each at its null, where it changes nothing but shows what it would add."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from robotid.model.array import Array
from robotid.model.derivatives import Derivatives, SparseDerivatives, Tangent, absent
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

    def candidate_forces(
        self, x: Array, s: Array, t: Array, theta: Array, wanted: Sequence[int], out: Array | None = None
    ) -> Array:
        """Generalised forces that the candidates' parameters `wanted` of theta add, each per unit, mean over the
        intervals between the samples, (nv, k, n - 1); written to `out` where that is given, which is zero.

        x : (nx + their memory, n) states; s : (nv, n) directions; t : (n,); theta : (p + k,), each candidate at its
        null. A transformed speed may jump where the transformed position does not: there it counts by the change of the
        position.
        """
        places, column = (*self.placed, *self.candidates), {c: k for k, c in enumerate(wanted)}
        motions = self._port_motions(x, s, t, theta, places)
        forces = SparseDerivatives([{} for _ in range(self.masses)], [{} for _ in range(self.masses)], column)
        follow = [place.at for place in self.candidates if place.transform is not None and place.transform.follows]
        jumping = [c for at in follow for c in range(at.start, at.stop) if c in column]
        for place, motion in zip(places, motions, strict=True):
            steady = {c: value for c, value in motion.v.parameters.items() if c not in jumping}
            moving = PortMotion(
                motion.m, motion.x, Tangent(motion.v.states, steady), motion.s, motion.tau, motion.levers
            )
            self._add_torque(place, moving, theta, forces)
        means = np.zeros((self.masses, len(wanted), x.shape[1] - 1)) if out is None else out
        for rows, found in zip(means, forces.columns or (), strict=True):
            for k, value in found.items():
                if np.size(value) == 1:
                    rows[k] = value
                else:
                    np.add(value[1:], value[:-1], out=rows[k])  # type: ignore[index]
                    rows[k] *= 0.5
        means[:, [column[c] for c in jumping]] += np.diff(self._momenta(motions, theta, jumping), axis=2) / np.diff(t)
        self._add_accelerated(means, column, motions[len(self.placed) :], x, t, theta)
        return means

    def _add_accelerated(
        self,
        means: Array,
        column: Mapping[int, int],
        motions: Sequence[PortMotion],
        x: Array,
        t: Array,
        theta: Array,
    ) -> None:
        """Add what the accelerations cause, to which torques are affine: its mean is known exactly, from the speeds."""
        n = x.shape[1]
        for place, motion in zip(self.candidates, motions, strict=True):
            where = {c: k for k, c in enumerate(c for c in range(place.at.start, place.at.stop) if c in column)}
            if not place.reads_acceleration or not where:
                continue
            unit, rest = (np.zeros((self.masses, len(where), n)) for _ in range(2))
            self._add_torque(place, motion.accelerated(np.ones(n)), theta, Derivatives(None, unit, where))
            self._add_torque(place, motion, theta, Derivatives(None, rest, where))
            slope, speed = unit - rest, np.sum([c * x[row] for row, c in place.v], axis=0)
            mean = (slope[:, :, 1:] + slope[:, :, :-1]) / 2 * np.diff(speed) / np.diff(t)
            means[:, [column[c] for c in where]] += mean

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
