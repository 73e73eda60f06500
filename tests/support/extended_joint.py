"""The paper's joint with any one effect more, for promises over the whole catalogue."""

from __future__ import annotations

import numpy as np

from robotid.catalogue import reading
from robotid.channels import CHANNELS
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.companion import CompanionKind, companion_of, with_companion
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.model.term import MotionTransform, Term
from robotid.signals.companion import Companion
from robotid.signals.record import Record
from robotid.terms import TERMS
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH


def written(effect: Term | Channel) -> str:
    """An effect's name as a model lists it: one that reads a companion reads that named after its kind."""
    return effect.name if effect.companion is None else with_companion(effect.name, effect.companion)


def kind_of(effect: str) -> Term | Channel:
    """The effect of a name that a model lists, port and companion included."""
    plain, companion = companion_of(effect.partition(".")[2])
    kind: Term | Channel = TERMS.get(plain) or CHANNELS[plain]
    return reading(kind, companion) if companion else kind


TERMS_IN_PLACE = [f"{port}.{written(term)}" for term in TERMS.values() for port in term.ports]
TORQUE_CHANNELS = [f"torque.{written(c)}" for c in CHANNELS.values() if "torque" in c.signals]


def structure_with(effect: str) -> Structure:
    """The paper's joint with one effect more, and what that one needs to show."""
    port, name = effect.split(".")
    structure, needed = STRUCTURE if effect in STRUCTURE.terms else STRUCTURE.extended(effect), list[str]()
    if port in ("link", "tool") and name != "third_mass":
        needed = ["link.spring", "link.damper", "tool.inertia"]
    term = kind_of(effect)
    if port in ("arm", "tool") and (isinstance(term, MotionTransform) or getattr(term, "reads", None)):
        needed.append(f"{port}.coulomb")
    for other in needed:
        structure = structure if other in structure.terms else structure.extended(other)
    return structure


def lively(name: str, guess: float, upper: float) -> float:
    """A value at which a parameter shows, off the kinks that a delay has at whole samples."""
    typical = {
        "Jb": 100.0,
        "J": 100.0,
        "k1": 1e6,
        "d": 1e3,
        "k3": 1e10,
        "Td": 1.3e-3,
        "xs": 2e-5,
        "gap": 2e-5,
        "w": 0.7,
    }
    amplitude = 10.0 if name.startswith("arm.") and name[-2:] in (".A", ".B") else 0.0
    return TRUTH.get(name) or typical.get(name.rsplit(".", 1)[-1]) or amplitude or guess or min(0.1, upper)


def values(joint: Joint, **given: float) -> Array:
    """All parameters, where they show. given : others."""
    declared = joint.parameters()
    shown = zip(joint.names, declared.values.tolist(), declared.upper.tolist(), strict=True)
    return declared.with_values({name: lively(name, guess, upper) for name, guess, upper in shown} | given).values


def open_loop(samples: int) -> Record:
    """A torque that reverses the motor a few times, rest included; the motion is not measured."""
    t = np.arange(samples) * SAMPLING_TIME
    u = 2.0 * np.sin(2 * np.pi * 4 * t) + 0.5 * np.sin(2 * np.pi * 11 * t + 1)
    return Record("r", "estimate", "both", SAMPLING_TIME, u, 0 * u, 0 * u, companions=companions(t))


def companions(t: Array) -> dict[str, Companion]:
    """One of every kind along times t (n,), named after it."""
    courses = {
        CompanionKind.ANGLE: 0.4 + 0.8 * np.sin(2 * np.pi * 1.7 * t),
        CompanionKind.TEMPERATURE: 45.0 + 40.0 * t,
        CompanionKind.TORQUE: 0.3 * np.sin(2 * np.pi * 3.1 * t),
        CompanionKind.VOLTAGE: 48.0 - 4.0 * np.cos(2 * np.pi * 2.3 * t),
        CompanionKind.INERTIA: 0.003 * np.sin(2 * np.pi * 1.9 * t),
    }
    return {str(kind): Companion.of(kind, values, SAMPLING_TIME) for kind, values in courses.items()}
