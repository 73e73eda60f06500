"""The motion as a term feels it: that of its port, bent by the bends there, with the torques it reads.

Every quantity comes with its tangent, so derivatives pass through bends and readings by themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.model.array import Array
from robotid.model.geometry import Selection
from robotid.model.port import Port
from robotid.model.term import Motion, MotionTransform, Partials, Term

Tangent = dict[int, "Array | float"]
"""Derivatives of one signal: row of the state, or number of states + index into theta, to (n,) or a number."""


@dataclass(frozen=True, slots=True)
class Placed:
    """A term at its port. at : slice of theta; x, v : the port's position and speed as sums over the state; q : its
    selection S of the coordinates; z : slice of its memory in the state; side : slice of its edges in the
    directions. transform : the term where it transforms the motion rather than absorbs a torque; acts : False for a
    candidate, an effect at its null that takes part in the motion but adds nothing to it."""

    port: Port
    term: Term
    at: slice
    x: Selection
    v: Selection
    q: Selection
    z: slice
    side: slice
    reads_acceleration: bool
    transform: MotionTransform | None
    acts: bool

    def values(self, theta: Array) -> list[float]:
        """The term's own of all parameters (p,)."""
        own: list[float] = theta[self.at].tolist()
        return own


@dataclass(slots=True)
class Lever:
    """Where a torque acts: on coordinate j, by factor c; dc is the tangent of a factor that changes."""

    j: int
    c: Array | float
    dc: Tangent = field(default_factory=dict)


@dataclass(slots=True)
class PortMotion:
    """A motion m, the tangents of its position, speed, direction and of the torque read, and the levers of a torque."""

    m: Motion
    x: Tangent
    v: Tangent
    s: Tangent
    tau: Tangent
    levers: tuple[Lever, ...]

    def chain(self, d: Partials, own: Tangent) -> Tangent:
        """Tangent of a quantity with these partials; own : that to the term's own states and parameters."""
        return combine([(d.x, self.x), (d.v, self.v), (d.s, self.s), (d.tau, self.tau), (1.0, own)])

    def accelerated(self, a: Array) -> PortMotion:
        """The same motion at an acceleration (n,)."""
        m = self.m
        m = Motion(m.x, m.v, a, m.s, m.t, m.z, m.tau, m.xw, m.vw, m.side)
        return PortMotion(m, self.x, self.v, self.s, self.tau, self.levers)


def combine(parts: Iterable[tuple[Array | float, Tangent]]) -> Tangent:
    """Sum of tangents, each times a factor."""
    total: Tangent = {}
    for factor, tangent in parts:
        if absent(factor):
            continue
        for key, value in tangent.items():
            scaled = value if _one(factor) else factor if _one(value) else factor * value
            total[key] = total[key] + scaled if key in total else scaled
    return total


def absent(partial: Array | float) -> bool:
    """Whether a partial is the structural zero of `Partials`."""
    return isinstance(partial, float) and partial == 0.0


def _one(factor: Array | float) -> bool:
    return isinstance(factor, float) and factor == 1.0


def own_tangent(place: Placed, d: Partials, nx: int, *, parameters: bool = True) -> Tangent:
    """Derivatives to the term's own states and, where wanted, parameters; a candidate's states are none of the
    joint's."""
    own = dict(enumerate(d.z, start=place.z.start)) if place.acts and d.z else {}
    if parameters:
        own |= dict(enumerate(d.theta, start=nx + place.at.start))
    return {key: value for key, value in own.items() if not absent(value)}


def bent(
    place: Placed, felt: PortMotion, m: Motion, watched: PortMotion | None, p: Sequence[float], nx: int
) -> PortMotion:
    """What is felt at a port behind one more bend.

    felt : before it; m : the same motion with the bend's own memory and sides; watched : the raw motion of the port
    that the transform watches.
    """
    transform = place.transform
    assert transform is not None
    if watched is not None:
        m = replace(m, xw=watched.m.x, vw=watched.m.v)
    dx, dv, ds = transform.transform_partials(m, p)

    def tangent(d: Partials) -> Tangent:
        watching = [] if watched is None else [(d.xw, watched.x), (d.vw, watched.v)]
        return combine([(1.0, felt.chain(d, own_tangent(place, d, nx))), *watching])

    levers = felt.levers
    if watched is not None:
        # The bent speed is linear in the watched one: at v = 0, vw = 1 its value is the lever, its slope the lever's.
        unit = transform.transform_partials(replace(m, v=np.zeros_like(m.v), vw=np.ones_like(m.v)), p)[1]
        turns = combine([(unit.xw, watched.x), (1.0, own_tangent(place, unit, nx))])
        levers += tuple(
            Lever(lever.j, lever.c * dv.vw, {key: lever.c * value for key, value in turns.items()})
            for lever in watched.levers
        )
    if not place.acts:
        return _glimpsed(felt, (tangent(dx), tangent(dv), tangent(ds)), levers, nx + place.at.start)
    x, v, s = transform.transform(m, p)
    return PortMotion(replace(felt.m, x=x, v=v, s=s), tangent(dx), tangent(dv), tangent(ds), felt.tau, levers)


def _glimpsed(
    felt: PortMotion, tangents: tuple[Tangent, Tangent, Tangent], levers: tuple[Lever, ...], first: int
) -> PortMotion:
    """The motion unbent, as at the null of a candidate, with the derivatives to the candidate's parameters."""
    x, v, s = ({key: value for key, value in tangent.items() if key >= first} for tangent in tangents)
    turned = tuple(
        Lever(lever.j, 0.0, {key: value for key, value in lever.dc.items() if key >= first})
        for lever in levers[len(felt.levers) :]
    )
    return PortMotion(felt.m, felt.x | x, felt.v | v, felt.s | s, felt.tau, felt.levers + turned)
