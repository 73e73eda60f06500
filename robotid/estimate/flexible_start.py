"""Where the parametric fit of a frequency response starts: notch, gain and the rigid inertia of step 1."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.linear_response import total_inertia
from robotid.estimate.notch import Reading
from robotid.estimate.rigid import RigidResult
from robotid.model.array import Array
from robotid.model.joint import Joint

DAMPING_RATIO = 0.03
MOTOR_SHARE = (0.05, 0.95)  # of the rigid inertia that the motor may have
TOOL_SHARES = (0.1, 0.3, 0.6)  # of the inertia beyond the gear
LINK_FREQUENCIES = (1.3, 2.0, 3.5)  # of the tool with the arm held, in notch frequencies
BLIND_NOTCHES = 5  # tried where none is read


def rigid_inertia(joint: Joint, values: Mapping[str, float], rigid: RigidResult) -> tuple[float, float]:
    """Inertia of all masses moving together, and its standard deviation, on the motor side [kg m2].

    Raises NumericsError where step 1 found none.
    """
    # Step 1 sees one mass: a third one is part of what it calls the arm's.
    total = total_inertia(joint, {name: v for name, v in values.items() if name != "link.third_mass.Jb"})
    sides = {"motor.inertia.J": 1.0, "joint.inertia.J": 1.0}
    stds = [sides.get(p.name, joint.ratio**2) * p.std_robust for p in rigid.parameters if p.name.endswith("inertia.J")]
    if total <= 0:
        raise NumericsError(
            f"the rigid inertia is {total:.3g} kg m2", where="init_flex", hint="mend the rigid initialisation first"
        )
    return total, float(np.linalg.norm(stds))


def starts(
    joint: Joint, values: Mapping[str, float], reading: Reading, total: float, omega: Array
) -> list[dict[str, float]]:
    """Starts of every parameter of the linear joint. values : what is known otherwise; omega (n,) : of the response."""
    motor = float(np.clip(1 / reading.gain, MOTOR_SHARE[0] * total, MOTOR_SHARE[1] * total))
    far = (total - motor) / joint.ratio**2
    blind = np.geomspace(omega[0], omega[-1], BLIND_NOTCHES + 2)[1:-1].tolist()
    notches = [reading.notch] if reading.notch is not None else blind
    third = any(name.startswith(("tool.", "link.")) for name in joint.names)
    tools = list(product(TOOL_SHARES, LINK_FREQUENCIES)) if third else [(0.0, 1.0)]
    known = {name: max(abs(values[name]), 1e-12) for name in joint.names}
    return [
        known | {name: v for name, v in _start(motor, far, notch, *tool).items() if name in known}
        for notch, tool in product(notches, tools)
    ]


def _start(motor: float, far: float, notch: float, tool_share: float, link_frequency: float) -> dict[str, float]:
    tool, link = tool_share * far, link_frequency * notch
    return {
        "motor.inertia.J": motor,
        "arm.inertia.J": (1 - tool_share) * far,
        "gear.spring.k1": notch**2 * far,
        "gear.damper.d": 2 * DAMPING_RATIO * notch * far,
        "tool.inertia.J": tool,
        "link.spring.k1": link**2 * tool,
        "link.damper.d": 2 * DAMPING_RATIO * link * tool,
        "link.third_mass.Jb": tool,
        "link.third_mass.wb": link,
        "link.third_mass.zeta": DAMPING_RATIO,
    }
