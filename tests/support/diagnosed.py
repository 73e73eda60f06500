"""A diagnosis and an extension with something in every field, for tests of what is made of them."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import numpy as np

from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.results import (
    Cause,
    Confounded,
    DetectionLimit,
    Diagnosis,
    Event,
    Misfit,
    Rejected,
    Separation,
)
from robotid.estimate.result import End, Estimate, FitResult
from robotid.extension.results import Extension, Score
from robotid.model.structure import Structure
from robotid.signals.trace import Trace


def estimate(name: str, value: float, unit: str) -> Estimate:
    return Estimate(name, value, unit, 0.01, 0.02, 0.0, 10.0)


def trace() -> Trace:
    t = np.linspace(0, 1, 50)
    return Trace(t, np.sin(t), 0.9 * np.sin(t), "rad/s")


def curve(along: str, unit: str, bins: int = 30) -> Curve:
    x = np.linspace(-3, 3, bins)
    torque = 0.2 * np.exp(-np.abs(x)) * np.sign(x)
    if bins > 2:
        torque[2] = nan  # an empty bin
    return Curve(along, unit, x, torque, np.full(bins, 0.02), np.full(bins, 100), 0.83)


STRIBECK = Cause(
    "motor.stribeck",
    (estimate("motor.stribeck.dFs", 0.2, "Nm"), estimate("motor.stribeck.vs", 1.5, "rad/s")),
    explained=0.97,
    heldout_gain=4.2,
    p_value=1e-12,
    twins=("motor.stribeck", "motor.presliding"),
    separation=Separation("motor.presliding", '{"kind": "triangle", "amplitude": 5, "period": 2}', 7.5),
    confounded_with=(Confounded("motor.quadratic_friction", 0.92),),
)
PAYLOAD = Cause(
    "record_change.day2.arm.inertia.J",
    (estimate("record_change.day2.arm.inertia.J", 12.0, "kg m2"),),
    explained=0.02,
    heldout_gain=nan,
    p_value=3e-4,
    twins=("record_change.day2.arm.inertia.J",),
    separation=None,
    explained_of="day2",
)
PUSH = Event("set1", "bump", False, 1.7, 2.5, 0.3, 0.01, 1e-20)
STEP = Event("set1", "step", True, 2.2, 6.25, 0.16, 0.02, 1e-9)
LIMITS = (
    DetectionLimit("gear.backlash", "gap", inf, "rad"),
    DetectionLimit("motor.cogging", "A", 0.0075, "Nm"),
)

NAMED = Diagnosis(
    verdict="named",
    model="m3",
    output="speed",
    unit="rad/s",
    noise_floor=0.01,
    misfit=0.13,
    remaining=0.011,
    records={
        "set1": Misfit("estimate", 96.1, 0.132, 0.01, 0.13, 0.98),
        "check": Misfit("validate", 95.0, 0.14, 0.01, 0.139, 0.97),
    },
    causes=(STRIBECK, PAYLOAD),
    rejected=(
        Rejected("motor.cogging", 0.05, nan, "p = 0.4"),
        Rejected("gear.backlash", 0.4, -0.3, "worse on held-out records"),
    ),
    curves=(curve("dphi_m", "rad/s"), curve("record", "", 2)),
    missing={"set1": trace(), "check": trace()},
    residuals={"set1": trace(), "check": trace()},
    shape=None,
    remarks=("the records are short",),
    remaining_share=0.03,
    events=(PUSH, STEP),
    limits=LIMITS,
)
UNKNOWN = replace(NAMED, verdict="unknown", causes=(), remaining=0.13, shape=curve("phi_m", "rad"))
CLEAN = replace(
    NAMED,
    verdict="clean",
    causes=(),
    events=(),
    rejected=(),
    curves=(),
    misfit=0.0,
    remaining=0.0,
    missing={},
    remarks=(),
)

FIT = FitResult(
    name="m3",
    records=("set1",),
    output="speed",
    structure=Structure(("motor.inertia", "motor.coulomb", "motor.stribeck")),
    parameters=(estimate("motor.inertia.J", 0.01, "kg m2"), estimate("motor.stribeck.dFs", 0.2, "Nm")),
    covariance=np.eye(2),
    covariance_robust=np.eye(2),
    initial_states={"set1": np.zeros(1)},
    noise_std={"set1": 0.01},
    fit_percent={"set1": 99.8},
    cost=np.array([2.0, 1.0]),
    iterations=1,
    end=End.CONVERGED,
    seconds=0.5,
)
EXTENSION = Extension(
    model="m3",
    output="speed",
    unit="rad/s",
    model_before=("motor.inertia", "motor.coulomb"),
    model_after=("motor.inertia", "motor.coulomb", "motor.stribeck"),
    added=("motor.stribeck",),
    before={
        "set1": Score("estimate", True, 96.1, 0.132, trace()),
        "check": Score("validate", False, 95.0, 0.14, trace()),
    },
    after={
        "set1": Score("estimate", True, 99.8, 0.011, trace()),
        "check": Score("validate", False, 99.2, 0.0112, trace()),
    },
    bic_before=1000.0,
    bic_after=-4000.0,
    fit=FIT,
    dropped=(Rejected("motor.cogging", 0.001, nan, "its worth is gone"),),
)
