"""Models on their way to another program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from robotid.catalogue import assemble
from robotid.estimate.result import End, Estimate, FitResult
from robotid.export.handover.handed_model import HandedModel
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate

RATIO = 1 / 100
VALUES = {
    "motor.inertia.J": 0.01,
    "motor.viscous.Fv": 0.02,
    "motor.coulomb.Fc": 0.4,
    "gear.spring.k1": 2e4,
    "gear.damper.d": 30.0,
    "arm.inertia.J": 60.0,
    "arm.viscous.Fv": 5.0,
    "arm.coulomb.Fc": 3.0,
    "gear.cubic_spring.k3": 2e9,
    "gear.backlash.gap": 2e-4,
    "link.spring.k1": 4e4,
    "link.damper.d": 20.0,
    "tool.inertia.J": 10.0,
    "motor.quadratic_friction.Fq": 1e-3,
    "motor.constant_torque.tau0": 0.15,
    "arm.constant_torque.tau0": 8.0,
}
STEP = 1e-3


def fit_of(structure: Structure, values: Mapping[str, float], *, keeps_angle: bool = False) -> FitResult:
    """A fit with these values, or the declared guesses."""
    p = assemble(structure).parameters()
    p = p.with_values({name: value for name, value in values.items() if name in p.names})
    estimates = tuple(
        Estimate(name, float(value), unit, 0.1, 0.2, float(low), float(high))
        for name, value, unit, low, high in zip(p.names, p.values, p.units, p.lower, p.upper, strict=True)
    )
    zero = np.zeros((len(p.names),) * 2)
    rest = ({}, {}, {"drive": 99.0}, np.ones(1), 3, End.CONVERGED, 1.0)
    fit = FitResult("m", ("drive",), "speed", structure, estimates, zero, zero, *rest)
    return replace(fit, keeps_angle=keeps_angle)


def handed(
    terms: Sequence[str], channels: Sequence[str] = (), records: Sequence[Record] = (), ratio: float | None = RATIO
) -> HandedModel:
    """A model of these effects."""
    structure = Structure(tuple(terms), tuple(channels), ratio)
    return HandedModel("toy", fit_of(structure, VALUES), records=tuple(records))


def driven(terms: Sequence[str], duration: float = 1.5, ratio: float | None = RATIO) -> tuple[HandedModel, Record]:
    """A model and a record that it makes, from rest, without any noise."""
    model = handed(terms, ratio=ratio)
    t = np.arange(0.0, duration, STEP)
    torque = 2.0 * np.sin(2 * np.pi * 1.3 * t) + 0.8 * np.sin(2 * np.pi * 7.1 * t)
    record = Record("drive", "estimate", "both", STEP, torque, np.zeros_like(t), np.zeros_like(t))
    joint = model.joint
    made = simulate(joint, model.theta, record, np.zeros(joint.nx))
    record = replace(record, phi_m=made.phi_m, dphi_m=made.dphi_m)
    return replace(model, records=(record,)), record
