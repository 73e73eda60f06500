"""The body of a robot whose axes are parallel: links in a plane, one behind the other.

With absolute angles theta_j = q_1 + ... + q_j of the links the kinetic energy is half the sum of
a_jk cos(theta_j - theta_k) dtheta_j dtheta_k, and Lagrange's equations are short (Siciliano, Sciavicco, Villani &
Oriolo 2009, Robotics, section 7.3). Rotors turn about axes of their own and belong to the joints (Spong 1987).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotid.model.array import Array
from robotid.model.linear_algebra import product


@dataclass(frozen=True, slots=True)
class Link:
    """mass [kg]; length [m] to the next joint; centre [m] : distance of its centre of mass from its joint, along the
    line to the next one; inertia [kg m2] about the centre of mass."""

    mass: float
    length: float
    centre: float
    inertia: float


@dataclass(frozen=True, slots=True)
class BodyTorque:
    """Torque that the body takes from the arms of k axes at n points, M(q) ddq + h(q, dq), and its derivatives.

    mass (k, k, n); rest : h (k, n); to_angles, to_speeds : of the whole torque at these accelerations, (k, k, n).
    """

    mass: Array
    rest: Array
    to_angles: Array
    to_speeds: Array


class PlanarChain:
    """Links in a plane. gravity [m/s2] acts against the direction to which an angle of +90 degrees points, where an
    angle of zero of the first axis is level; zero where the plane is.

    Angles q (k, n) [rad], speeds dq and accelerations ddq (k, n) are those of the arms, each counted from the link
    before, zero where the chain is stretched.
    """

    def __init__(self, links: Sequence[Link], gravity: float = 0.0) -> None:
        self.links = tuple(links)
        k = len(self.links)
        self._angles = np.tril(np.ones((k, k)))  # of the links, from those of the axes
        weights, coupled = np.zeros(k), np.zeros((k, k))
        for n, link in enumerate(self.links):
            levers = np.array([one.length for one in self.links[:n]] + [link.centre] + [0.0] * (k - n - 1))
            coupled += link.mass * np.outer(levers, levers)
            coupled[n, n] += link.inertia
            weights += gravity * link.mass * levers
        self._coupled, self._weights = coupled[:, :, None], weights[:, None]

    def mass(self, q: Array) -> Array:
        """Mass matrix M(q), (k, k, n)."""
        return self._by_axes(self._coupled * np.cos(self._differences(q)))

    def torque(self, q: Array, dq: Array, ddq: Array) -> Array:
        """M(q) ddq + h(q, dq), (k, n)."""
        return product(self.mass(q), ddq) + self._rest(q, dq)

    def linearise(self, q: Array, dq: Array, ddq: Array) -> BodyTorque:
        """The torque, its parts and its derivatives."""
        turned, speeds, rates = (product(self._angles[:, :, None], one) for one in (q, dq, ddq))
        between = self._differences(q)
        sine, cosine = self._coupled * np.sin(between), self._coupled * np.cos(between)
        # to the angle of the other link, and with the opposite sign to the own one
        to_other = sine * rates[None] - cosine * speeds[None] ** 2
        own = -to_other.sum(axis=1) - self._weights * np.sin(turned)
        k = np.arange(len(self.links))
        to_angles = to_other.copy()
        to_angles[k, k] += own
        return BodyTorque(
            self.mass(q), self._rest(q, dq), self._by_axes(to_angles), self._by_axes(2.0 * sine * speeds[None])
        )

    def energy(self, q: Array, dq: Array) -> Array:
        """Kinetic and potential energy [J], (n,)."""
        heights = np.sin(product(self._angles[:, :, None], q))
        return np.asarray(0.5 * (dq * product(self.mass(q), dq)).sum(axis=0) + (self._weights * heights).sum(axis=0))

    def _rest(self, q: Array, dq: Array) -> Array:
        """Centrifugal torques and weight, (k, n)."""
        turned, speeds = (product(self._angles[:, :, None], one) for one in (q, dq))
        carried = product(self._coupled * np.sin(self._differences(q)), speeds**2) + self._weights * np.cos(turned)
        return product(self._angles.T[:, :, None], carried)

    def _differences(self, q: Array) -> Array:
        """theta_j - theta_k, (k, k, n)."""
        turned = product(self._angles[:, :, None], q)
        return np.asarray(turned[:, None] - turned[None])

    def _by_axes(self, matrix: Array) -> Array:
        """A matrix over the links' angles (k, k, n) as one over those of the axes."""
        return np.asarray(np.einsum("ji,jkn,kl->iln", self._angles, matrix, self._angles))
