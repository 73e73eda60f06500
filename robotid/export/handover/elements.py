"""Effects as the elements of rigid-body simulators: inertia, damper, spring, dry friction, play, constant torque.

What an effect is, its formula tells: where its torque is a constant and a sum of constants times position, speed,
acceleration and direction of motion, these constants are the element, whatever the effect is called.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.export.handover.handed_model import HandedModel
from robotid.model.array import Array
from robotid.model.hung_mass import HungMass
from robotid.model.port import Port
from robotid.model.port_motion import Placed
from robotid.model.term import Motion

PROBE = (0.3, -0.7, 1.1)  # motions at which a formula is tried
EXACT = 1e-9  # relative: two torques that differ by less are one


@dataclass(frozen=True, slots=True)
class Hung:
    """An inertia that hangs on a port by a spring and a damper, in SI."""

    inertia: float
    stiffness: float
    damping: float


@dataclass(frozen=True, slots=True)
class Element:
    """What an effect is at its port, in SI: torque = stiffness x + cubic x^3 + damping v + inertia a + friction sgn(v)
    + constant. play : half the gap [rad] that the others at the port do not see. hung : inertias that hang on it."""

    port: Port
    stiffness: float = 0.0
    cubic: float = 0.0
    damping: float = 0.0
    inertia: float = 0.0
    friction: float = 0.0
    constant: float = 0.0
    play: float = 0.0
    hung: tuple[Hung, ...] = ()

    def __add__(self, other: Element) -> Element:
        return Element(
            self.port,
            self.stiffness + other.stiffness,
            self.cubic + other.cubic,
            self.damping + other.damping,
            self.inertia + other.inertia,
            self.friction + other.friction,
            self.constant + other.constant,
            self.play + other.play,
            (*self.hung, *other.hung),
        )


def elements(model: HandedModel) -> dict[str, Element]:
    """The effects of a model that are elements, by name."""
    found = ((p.effect, element_of(p, model.theta)) for p in model.joint.placed)
    return {name: element for name, element in found if element is not None}


def by_port(found: Iterator[Element] | Sequence[Element]) -> dict[Port, Element]:
    """All elements at a port as one."""
    ports: dict[Port, Element] = {}
    for one in found:
        ports[one.port] = ports[one.port] + one if one.port in ports else one
    return ports


def element_of(place: Placed, theta: Array) -> Element | None:
    """The element that a term is, None where it is none."""
    term, p = place.term, place.values(theta)
    if place.transform is not None:
        return Element(place.port, play=p[0]) if place.transform.play else None
    if isinstance(term, HungMass):
        inertia, frequency, damping_ratio = p
        hung = Hung(inertia, inertia * frequency**2, 2.0 * damping_ratio * frequency * inertia)
        return Element(place.port, hung=(hung,))
    if term.states or term.edges or term.reads is not None or term.companion_name:
        return None
    constant = _torque(place, p, 0.0, 0.0, 0.0, 0.0)
    slopes = [_torque(place, p, *axis) - constant for axis in np.eye(4).tolist()]
    cubic = (_torque(place, p, 2.0, 0.0, 0.0, 0.0) - constant - 2.0 * slopes[0]) / 6.0
    stiffness, damping, inertia, friction = slopes
    found = Element(place.port, stiffness - cubic, cubic, damping, inertia, friction, constant)
    size = max(map(abs, (*slopes, constant)), default=0.0)
    for x in PROBE:
        for v in PROBE:
            s = float(np.sign(v))
            expected = (found.stiffness + found.cubic * x * x) * x + found.damping * v + found.inertia * x * v
            torque = _torque(place, p, x, v, x * v, s, t=v)
            if abs(expected + found.friction * s + constant - torque) > EXACT * size:
                return None
    return found


def _torque(place: Placed, p: Sequence[float], x: float, v: float, a: float, s: float, t: float = 0.0) -> float:
    x1, v1, a1, s1, t1 = (np.full(1, value) for value in (x, v, a, s, t))
    motion = Motion(x1, v1, a1, s1, t1, np.zeros((0, 1)))
    return float(np.asarray(place.term.torque(motion, p)).reshape(-1)[0])
