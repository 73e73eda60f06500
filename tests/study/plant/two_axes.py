"""Two revolute axes in a plane, one behind the other, with flexible gears: Lagrange's equations written out.

Links: masses m1, m2, length l1 of the first, distances c1, c2 of the centres of mass from the joints, inertias I1, I2
about them. With q1, q2 the angles of the arms, q2 counted from the first link, the Lagrangian gives

    M11 = I1 + m1 c1^2 + I2 + m2 (l1^2 + c2^2 + 2 l1 c2 cos q2)
    M12 = I2 + m2 (c2^2 + l1 c2 cos q2),   M22 = I2 + m2 c2^2
    b = m2 l1 c2 sin q2 :   h1 = -b (2 dq1 dq2 + dq2^2),   h2 = b dq1^2
    weight: G1 = ((m1 c1 + m2 l1) cos q1 + m2 c2 cos(q1 + q2)) g,   G2 = m2 c2 g cos(q1 + q2).

Each arm has besides a flange's own inertia. Rotors turn fast about axes of their own, which the links' slow turning
does not change (Spong 1987). The motors' dry friction is set-valued: a step ends where a motor comes to rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin
from typing import NamedTuple

from study.plant.machine import Machine


@dataclass(frozen=True, slots=True)
class Links:
    """SI; gravity [m/s2], zero for a level plane."""

    m1: float
    l1: float
    c1: float
    I1: float
    m2: float
    c2: float
    I2: float
    gravity: float = 0.0


class Side(NamedTuple):
    """One axis: angles and speeds of motor and arm [rad, rad/s]; direction of the motor, 0 only at rest."""

    phi_m: float = 0.0
    dphi_m: float = 0.0
    s: int = 0
    phi_a: float = 0.0
    dphi_a: float = 0.0


class Pair(NamedTuple):
    """Both axes, and the time [s]."""

    one: Side = Side()
    two: Side = Side()
    t: float = 0.0


PairStep = Callable[[Pair, float, float, float], Pair]


def posed(machines: tuple[Machine, Machine], q1: float, q2: float) -> Pair:
    """At rest, the arms at these angles, the gears without twist."""
    one, two = (Side(phi_m=q / machine.ratio, phi_a=q) for q, machine in zip((q1, q2), machines, strict=True))
    return Pair(one, two)


def stepper(machines: tuple[Machine, Machine], links: Links) -> PairStep:
    """(state, torques on both motors, dt) -> state after dt, the torques held.

    Of a machine, inertias, ratio, and the laws on its motor and in its gear count; its arm inertia is the flange's.
    """
    b = links
    l1c2, g = b.m2 * b.l1 * b.c2, b.gravity
    fixed11 = b.I1 + b.m1 * b.c1**2 + b.I2 + b.m2 * (b.l1**2 + b.c2**2) + machines[0].arm_inertia
    fixed12, M22 = b.I2 + b.m2 * b.c2**2, b.I2 + b.m2 * b.c2**2 + machines[1].arm_inertia
    weight1, weight2 = (b.m1 * b.c1 + b.m2 * b.l1) * g, b.m2 * b.c2 * g

    def gear(machine: Machine, y: Side) -> float:
        twist, rate = machine.ratio * y.phi_m - y.phi_a, machine.ratio * y.dphi_m - y.dphi_a
        return sum([law(twist, rate) for law in machine.gear])

    def absorbed(machine: Machine, y: Side, s: int, carried: float, t: float) -> float:
        return sum([law(s, y.dphi_m, y.phi_m, y.phi_a, carried, t) for law in machine.motor])

    def motor(machine: Machine, y: Side, u: float, carried: float, t: float) -> float:
        if not y.s:
            return 0.0
        return (u - machine.ratio * carried - absorbed(machine, y, y.s, carried, t)) / machine.motor_inertia

    def accelerations(y: Pair, u1: float, u2: float) -> tuple[float, float, float, float]:
        one, two, t = y
        carried1, carried2 = gear(machines[0], one), gear(machines[1], two)
        turned, bent = l1c2 * cos(two.phi_a), l1c2 * sin(two.phi_a)
        M11, M12 = fixed11 + 2.0 * turned, fixed12 + turned
        given1 = carried1 + bent * (2.0 * one.dphi_a + two.dphi_a) * two.dphi_a
        given2 = carried2 - bent * one.dphi_a**2
        if g:
            far = weight2 * cos(one.phi_a + two.phi_a)
            given1, given2 = given1 - weight1 * cos(one.phi_a) - far, given2 - far
        det = M11 * M22 - M12 * M12
        return (
            motor(machines[0], one, u1, carried1, t),
            (M22 * given1 - M12 * given2) / det,
            motor(machines[1], two, u2, carried2, t),
            (M11 * given2 - M12 * given1) / det,
        )

    def moved(y: Side, at: Side, a_m: float, a_a: float, dt: float) -> Side:
        return Side(
            y.phi_m + dt * at.dphi_m,
            y.dphi_m + dt * a_m,
            y.s,
            y.phi_a + dt * at.dphi_a,
            y.dphi_a + dt * a_a,
        )

    def midpoint(y: Pair, u1: float, u2: float, dt: float) -> Pair:
        a = accelerations(y, u1, u2)
        one = moved(y.one, y.one, a[0], a[1], 0.5 * dt)
        two = moved(y.two, y.two, a[2], a[3], 0.5 * dt)
        a = accelerations(Pair(one, two, y.t + 0.5 * dt), u1, u2)
        return Pair(moved(y.one, one, a[0], a[1], dt), moved(y.two, two, a[2], a[3], dt), y.t + dt)

    def directed(machine: Machine, y: Side, u: float, t: float) -> Side:
        """The direction in which a motor at rest begins to move, if it does."""
        carried = gear(machine, y)
        push = u - machine.ratio * carried
        forward, back = absorbed(machine, y, 1, carried, t), absorbed(machine, y, -1, carried, t)
        return y._replace(s=1 if push > forward else -1 if push < back else 0)

    def step(y: Pair, u1: float, u2: float, dt: float) -> Pair:
        while True:
            if y.one.dphi_m == 0.0:
                y = y._replace(one=directed(machines[0], y.one, u1, y.t))
            if y.two.dphi_m == 0.0:
                y = y._replace(two=directed(machines[1], y.two, u2, y.t))
            new = midpoint(y, u1, u2, dt)
            shares = [
                before.dphi_m / (before.dphi_m - after.dphi_m) if after.dphi_m * before.s < 0.0 else 1.0
                for before, after in zip(y[:2], new[:2], strict=True)
            ]
            used = dt * min(shares)
            if used == dt:
                return new
            new = midpoint(y, u1, u2, used) if used else y
            first = shares[0] <= shares[1]
            stopped = (new.one if first else new.two)._replace(dphi_m=0.0, s=0)
            y = new._replace(one=stopped) if first else new._replace(two=stopped)
            if not used:  # it sets off and turns at once: let it rest for this step
                return midpoint(y, u1, u2, dt)
            dt -= used

    return step
