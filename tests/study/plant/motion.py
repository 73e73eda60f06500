"""The equations of motion, stepped finely: explicit midpoint rule, cut at every standstill.

Dry friction is set-valued. A body that comes to rest within a step ends the step there; a body at rest stays as long as
the torques on it lie between what its laws absorb in either direction. Plain floats: at 20 steps to the sample this is
faster than arrays of a few records.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from study.plant.machine import Machine


class State(NamedTuple):
    """Angles and speeds of motor and arm [rad, rad/s], directions (0 only at rest), memory of the laws, time [s]."""

    phi_m: float = 0.0
    dphi_m: float = 0.0
    s_m: int = 0
    phi_a: float = 0.0
    dphi_a: float = 0.0
    s_a: int = 0
    z: tuple[float, ...] = ()
    t: float = 0.0


Forces = Callable[[State], tuple[float, float, float, list[float]]]
Step = Callable[[State, float, float], State]


def at_rest(machine: Machine) -> State:
    """All angles and states zero."""
    return State(z=(0.0,) * sum(m.states for m in machine.memory))


def forces_of(machine: Machine) -> Forces:
    """state -> torque that the gear and the laws with memory take from the motor, torque that they give to the arm,
    torque in the gear, rates of the memory."""
    ratio, laws, gap, mesh, memories = machine.ratio, machine.gear, machine.gap, machine.mesh, machine.memory

    def forces(y: State) -> tuple[float, float, float, list[float]]:
        phi_m, dphi_m, _, phi_a, dphi_a, _, z, _ = y
        twist, slip, lever = ratio * phi_m - phi_a, ratio * dphi_m - dphi_a, ratio
        if mesh is not None:
            offset, slope = mesh(phi_m)
            twist, slip, lever = twist + offset, slip + slope * dphi_m, lever + slope
        felt, rate = twist, slip
        if gap:
            felt = twist - gap if twist > gap else twist + gap if twist < -gap else 0.0
            rate = slip if felt else 0.0
        carried = 0.0
        for law in laws:
            carried += law(felt, rate)
        taken, given, rates, first = 0.0, 0.0, [], 0
        for memory in memories:
            own = z[first : first + memory.states]
            first += memory.states
            dz = memory.rate(own, dphi_m, slip, phi_a, dphi_a)
            torque = memory.torque(own, dz)
            rates += dz
            if memory.port == "gear":
                carried += torque
            elif memory.port == "motor":
                taken += torque
            else:
                given -= torque
        return taken + lever * carried, given + carried, carried, rates

    return forces


def stepper(machine: Machine) -> Step:
    """(state, torque on the motor, dt) -> state after dt, the torque held."""
    forces, motor, arm = forces_of(machine), machine.motor, machine.arm
    per_motor, per_arm = 1.0 / machine.motor_inertia, 1.0 / machine.arm_inertia

    def absorbed(s: int, y: State, carried: float) -> float:
        total = 0.0
        for law in motor:
            total += law(s, y[1], y[0], y[3], carried, y[7])
        return total

    def held(s: int, y: State) -> float:
        total = 0.0
        for law in arm:
            total += law(s, y[4], y[3])
        return total

    def accelerations(y: State, u: float) -> tuple[float, float, list[float]]:
        taken, given, carried, rates = forces(y)
        a_m = (u - taken - absorbed(y[2], y, carried)) * per_motor if y[2] else 0.0
        if arm:
            return a_m, (given - held(y[5], y)) * per_arm if y[5] else 0.0, rates
        return a_m, given * per_arm, rates

    def midpoint(y: State, u: float, dt: float) -> State:
        h = 0.5 * dt
        phi_m, dphi_m, s_m, phi_a, dphi_a, s_a, z, t = y
        a_m, a_a, rates = accelerations(y, u)
        v_m, v_a = dphi_m + h * a_m, dphi_a + h * a_a
        y_mid = State(
            phi_m + h * dphi_m,
            v_m,
            s_m,
            phi_a + h * dphi_a,
            v_a,
            s_a,
            tuple([p + h * d for p, d in zip(z, rates, strict=True)]) if z else z,
            t + h,
        )
        a_m, a_a, rates = accelerations(y_mid, u)
        return State(
            phi_m + dt * v_m,
            dphi_m + dt * a_m,
            s_m,
            phi_a + dt * v_a,
            dphi_a + dt * a_a,
            s_a,
            tuple([p + dt * d for p, d in zip(z, rates, strict=True)]) if z else z,
            t + dt,
        )

    def directed(y: State, u: float) -> State:
        """Directions in which what rests begins to move, if it does."""
        taken, given, carried, _ = forces(y)
        s_m, s_a = y[2], y[5]
        if y[1] == 0.0:
            push = u - taken
            s_m = 1 if push > absorbed(1, y, carried) else -1 if push < absorbed(-1, y, carried) else 0
        if arm and y[4] == 0.0:
            s_a = 1 if given > held(1, y) else -1 if given < held(-1, y) else 0
        return y._replace(s_m=s_m, s_a=s_a)

    def step(y: State, u: float, dt: float) -> State:
        while True:
            if y[1] == 0.0 or (arm and y[4] == 0.0):
                y = directed(y, u)
            new = midpoint(y, u, dt)
            motor_stops, arm_stops = new[1] * y[2] < 0.0, arm and new[4] * y[5] < 0.0
            if not (motor_stops or arm_stops):
                return new
            share_m = y[1] / (y[1] - new[1]) if motor_stops else 1.0
            share_a = y[4] / (y[4] - new[4]) if arm_stops else 1.0
            used = dt * min(share_m, share_a)
            new = midpoint(y, u, used) if used else y
            y = new._replace(dphi_m=0.0, s_m=0) if share_m <= share_a else new._replace(dphi_a=0.0, s_a=0)
            if not used:  # it sets off and turns at once: let it rest for this step
                return midpoint(y, u, dt)
            dt -= used

    return step
