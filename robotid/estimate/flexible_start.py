"""Where the parametric fit of a frequency response starts: notch, gain and the rigid inertia of step 1."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.linear_response import total_inertia
from robotid.estimate.notch import Reading
from robotid.estimate.rigid import RigidResult
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.port import GROUNDED, Port
from robotid.model.port_motion import Placed
from robotid.model.term import Oscillation, Role

DAMPING_RATIO = 0.03
MOTOR_SHARE = (0.05, 0.95)  # of the rigid inertia that the motor may have
TOOL_SHARES = (0.1, 0.3, 0.6)  # of the inertia beyond the gear
LINK_FREQUENCIES = (1.3, 2.0, 3.5)  # of the tool with the arm locked, in notch frequencies
BLIND_NOTCHES = 5  # tried where none is read
GROUND_FREQUENCIES = 3  # tried of the whole joint on a spring to ground, between the lowest line and the notch


def rigid_inertia(joint: Joint, values: Mapping[str, float], rigid: RigidResult) -> tuple[float, float]:
    """Inertia of all masses moving together, and its standard deviation, on the motor side [kg m2].

    Raises NumericsError where step 1 found none.
    """
    # Step 1 sees one mass: one that hangs on a spring of its own is part of what it calls the arm's.
    seen = {name: place for name, place in joint.playing(Role.MASS).items() if not place.term.states}
    total = total_inertia(joint, {name: values[name] for name in seen})
    factors = {f"joint.{name.partition('.')[2]}": 1.0 for name in seen}  # a sum is on the motor side already
    factors |= {name: joint.rigid_speed(place.port) ** 2 for name, place in seen.items()}
    stds = [factors[p.name] * p.std_robust for p in rigid.parameters if p.name in factors]
    if total <= 0:
        raise NumericsError(
            f"the rigid inertia is {total:.3g} kg m2", where="init_flex", hint="repair the rigid initialisation first"
        )
    return total, float(np.linalg.norm(stds))


def starts(
    joint: Joint, values: Mapping[str, float], reading: Reading, total: float, omega: Array
) -> list[dict[str, float]]:
    """Starts of every parameter of the linear joint. values : what is known otherwise; omega (n,) : of the response.

    Every term is sized for the oscillation that its port takes part in: motor and arm against each other at the notch,
    tool against arm above it, and all of them together on a spring to ground below it.
    """
    motor = float(np.clip(1 / reading.gain, MOTOR_SHARE[0] * total, MOTOR_SHARE[1] * total))
    far = (total - motor) / joint.ratio**2
    blind = np.geomspace(omega[0], omega[-1], BLIND_NOTCHES + 2)[1:-1].tolist()
    notches = [reading.notch] if reading.notch is not None else blind
    third = any(place.port in (Port.LINK, Port.TOOL) for place in joint.placed)
    tools = list(product(TOOL_SHARES, LINK_FREQUENCIES)) if third else [(0.0, 1.0)]
    known = {name: max(abs(values[name]), 1e-12) for name in joint.names}
    found = []
    for notch, (share, link_frequency) in product(notches, tools):
        tool = Oscillation(share * far, link_frequency * notch, DAMPING_RATIO)
        between = {
            Port.MOTOR: Oscillation(motor, notch, DAMPING_RATIO),
            Port.GEAR: Oscillation(far, notch, DAMPING_RATIO),
            Port.ARM: Oscillation((1 - share) * far, notch, DAMPING_RATIO),
            Port.LINK: tool,
            Port.TOOL: tool,
        }
        found += [known | _sized(joint, between, ground) for ground in _on_ground(joint, total, omega[0], notch)]
    return found


def _on_ground(joint: Joint, total: float, lowest: float, notch: float) -> Iterator[dict[Port, Oscillation]]:
    """The whole joint on a spring to ground at each of the ports, at some frequencies; once, where there is none."""
    tried = np.geomspace(min(lowest, notch), notch, GROUND_FREQUENCIES + 2)[1:-1].tolist()
    for frequency in tried if any(map(_to_ground, joint.placed)) else tried[:1]:
        yield {
            port: Oscillation(total / speed**2, frequency, DAMPING_RATIO)
            for port in GROUNDED
            if (speed := joint.rigid_speed(port))
        }


def _to_ground(place: Placed) -> bool:
    return place.port in GROUNDED and place.term.role in (Role.SPRING, Role.DAMPER)


def _sized(joint: Joint, between: Mapping[Port, Oscillation], ground: Mapping[Port, Oscillation]) -> dict[str, float]:
    """Parameters of all terms that take part in an oscillation, by dotted name."""
    found: dict[str, float] = {}
    for place in joint.placed:
        values = place.term.sized((ground if _to_ground(place) else between)[place.port])
        found |= zip(joint.names[place.at], values, strict=False)
    return found
