"""One trial on two axes: the tool gets the files alone, and what it names is set beside the truth."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from math import pi
from pathlib import Path

import numpy as np

from robotid.errors import RobotidError
from study.axes.arms import JOINTS, Extra, draw
from study.axes.files import POSE, hidden, write
from study.axes.plan import Spec
from study.trials.tool import diagnose, fit, heldout_rmse

SHARE = 0.95  # of the oracle's gain
SIZES = {"stribeck": 0.5, "asymmetric_coulomb": 0.05, "quadratic_friction": 1e-4, "position_friction": 0.15}
"""Of friction effects, in Coulomb levels of the axis; of drag, a level for each (rad/s)^2."""

SAME_LAW = {POSE: "arm.pose_lever[q2]", "motor.asymmetric_coulomb": "motor.constant_torque"}
"""The law that the plant has, by another name: the inertia of a chain in a plane follows the cosine alone, which is a
lever, and friction that one direction has more of is a constant torque, at rest, too."""


@dataclass(frozen=True, slots=True)
class Result:
    """What a trial came to, ready for JSON. hidden : what the model lacks, empty for nothing; causes : effect and its
    class, in order; rmse : of the models without the effect, of the oracle, and extended, on held-out records
    [rad/s]."""

    key: str
    kind: str
    hidden: str
    size: float = 0.0
    shape: dict[str, float] = field(default_factory=dict)
    verdict: str = ""
    causes: tuple[tuple[str, tuple[str, ...]], ...] = ()
    rmse: dict[str, float] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    error: str = ""

    @property
    def first(self) -> bool:
        """What is hidden, or the same law by another name, is the first cause."""
        return any(effect in (self.hidden, SAME_LAW.get(self.hidden)) for effect, _ in self.causes[:1])

    @property
    def in_class(self) -> bool:
        """What is hidden is in the class of the first cause."""
        return any(self.hidden in (effect, *twins) for effect, twins in self.causes[:1])

    @property
    def false(self) -> int:
        """Causes in whose class the hidden effect is not."""
        return sum(self.hidden not in (effect, *twins) for effect, twins in self.causes)

    @property
    def share(self) -> float:
        """Gain on held-out records over the oracle's; nan where nothing is hidden."""
        base, oracle = (self.rmse.get(name, np.nan) for name in ("base", "oracle"))
        return (base - self.rmse.get("extended", base)) / (base - oracle) if self.hidden else float("nan")


def run(spec: Spec, folder: Path) -> Result:
    """The whole trial in a folder of its own. An error of the tool is part of the result."""
    rng = spec.rng()
    arms, extra = draw(rng), drawn_extra(spec, rng)
    result = Result(spec.key, spec.kind, hidden(spec), extra.size, dict(extra.shape or {}))
    rmse, seconds, begin = result.rmse, result.seconds, time.perf_counter()
    try:
        write(folder, spec, arms, extra)
        seconds["plant"] = time.perf_counter() - begin
        base = fit(folder / "base.yaml")
        rmse["base"], rmse["oracle"] = base.rmse, fit(folder / "oracle.yaml").rmse
        begin = time.perf_counter()
        diagnosis, extension = diagnose(base)
        seconds["tool"] = time.perf_counter() - begin
        held = {plan.name: len(plan.temperature) for plan in arms.plans if plan.role == "validate"}
        rmse["extended"] = heldout_rmse(extension, held)
        causes = tuple((c.effect, c.twins) for c in diagnosis.causes)
        return replace(result, verdict=diagnosis.verdict, causes=causes)
    except RobotidError as error:
        return replace(result, error=f"{type(error).__name__}: {error}")


def drawn_extra(spec: Spec, rng: np.random.Generator) -> Extra:
    """The friction that is hidden, with its size and shape."""
    level = JOINTS[0].Fc
    if spec.kind == "temperature":
        return Extra("temperature", -float(rng.uniform(0.008, 0.02)))
    if not spec.friction:
        return Extra()
    size = SIZES[spec.friction] * level * float(rng.uniform(0.7, 1.3))
    shape = {
        "stribeck": {"vs": float(np.exp(rng.uniform(np.log(1.0), np.log(8.0))))},
        "position_friction": {"n": float(rng.uniform(0.2, 1.5)), "phase": float(rng.uniform(0.0, 2.0 * pi))},
    }.get(spec.friction)
    return Extra(spec.friction, size, shape)
