"""A motor beside two other axes, two thermometers and two load cells, of which an effect may read one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.companion import CompanionKind, Course
from robotid.model.structure import Structure
from robotid.signals.companion import Companion
from robotid.signals.record import Record, Role
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

H, DURATION = 0.004, 12.0
MODEL = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TRUTH = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.4}


@dataclass(frozen=True, slots=True)
class Beside:
    """Companions before there is a record."""

    name: str
    courses: Mapping[str, Course]


def companions(seed: int, samples: int) -> dict[str, Companion]:
    """Two of each kind, of which nothing but chance is alike."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) * H

    def swing(size: float, *frequencies: float) -> Array:
        phases = rng.uniform(0, 2 * np.pi, len(frequencies))
        waves = (np.sin(2 * np.pi * f * t + p) for f, p in zip(frequencies, phases, strict=True))
        return np.asarray(size * np.sum(list(waves), axis=0))

    def pushes() -> Array:
        edges = np.sort(rng.uniform(0, t[-1], 12))
        return np.asarray(np.where(np.searchsorted(edges, t) % 2, 1.0, 0.0))

    found = {
        "q2": (CompanionKind.ANGLE, 0.4 + swing(0.4, 0.21, 0.37)),
        "q3": (CompanionKind.ANGLE, -0.8 + swing(0.4, 0.29, 0.53)),
        "gear": (CompanionKind.TEMPERATURE, 24.0 + 14.0 * (1.0 - np.exp(-t / 5.0)) + swing(1.0, 0.09)),
        "hall": (CompanionKind.TEMPERATURE, 21.0 + swing(0.5, 0.13, 0.31)),
        "cell": (CompanionKind.TORQUE, pushes()),
        "other_cell": (CompanionKind.TORQUE, pushes()),
        "bus": (CompanionKind.VOLTAGE, 48.0 - np.abs(swing(2.0, 0.19, 0.41))),
        "pose": (CompanionKind.INERTIA, swing(0.002, 0.23, 0.33)),
    }
    return {name: Companion.of(kind, values, H) for name, (kind, values) in found.items()}


def record(effect: str = "", seed: int = 1, role: Role = "estimate", **values: float) -> Record:
    """What the motor makes of a motion under an effect with these values, none by default, with all companions."""
    samples = round(DURATION / H)
    beside = companions(100 + seed, samples)
    courses = {name: one.course(H, 0.0) for name, one in beside.items()}
    structure = MODEL.extended(effect) if effect else MODEL
    joint = assemble(structure, angle=True).along(Beside("made up", courses))
    own = {f"{effect}.{symbol}": value for symbol, value in values.items()}
    theta = joint.parameters().with_values(TRUTH | own).values
    robot = VirtualRobot(joint, theta, Controller("speed", 0.3, 2.0), 2 * np.pi / 65536, 0.005, 0.01, seed=seed)
    name = f"set{seed}"
    made = robot.record(Reference(name, H, _speeds(seed, samples), "speed"), seed)
    return replace(made, role=role, companions=beside)


def _speeds(seed: int, samples: int) -> Array:
    """A multisine over slow reversals."""
    rng, t = np.random.default_rng(seed), np.arange(samples) * H
    lines = np.arange(6, 72) / DURATION
    waves = np.sin(2 * np.pi * np.outer(t, lines) + rng.uniform(0, 2 * np.pi, len(lines))).sum(axis=1)
    slow = np.arcsin(np.sin(2 * np.pi * (0.25 * t + rng.uniform())))
    return np.asarray(6.0 * waves / np.abs(waves).max() + 6.0 * slow)
