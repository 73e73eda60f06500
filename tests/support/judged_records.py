"""A short noise-free pair of records of the paper's joint, and models to judge on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np

from robotid.catalogue import assemble
from robotid.estimate.fitted_model import FittedModel
from robotid.model.array import Array
from robotid.model.linear import linearise
from robotid.signals.frf import Frf
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH, references

CONTROLLER = Controller("speed", kp=0.5, ki=5.0)
SAMPLES = 3000


@cache
def clean_records() -> tuple[Record, ...]:
    """The first 1.5 s of sets 2 and 3, without noise; the second is held out."""
    joint = assemble(STRUCTURE, angle=True)
    plant = VirtualRobot(joint, joint.parameters().with_values(TRUTH).values, CONTROLLER)
    names = ("small", "large")
    made = [
        Reference(name, SAMPLING_TIME, ref[:SAMPLES], "speed")
        for name, ref in zip(names, references()[1:], strict=True)
    ]
    small, large = (plant.record(reference, k) for k, reference in enumerate(made))
    return small, replace(large, role="validate")


def clean_responses() -> tuple[Frf, ...]:
    """The truth's own response, as if measured on either record."""
    truth = model({})
    frequency = np.linspace(1.0, 40.0, 80)
    response = linearise(truth.joint, truth.theta).response(2 * np.pi * frequency)
    return tuple(Frf(record.name, frequency, response, 0.01 * np.abs(response)) for record in clean_records())


def model(values: Mapping[str, float], *, name: str = "m", records: tuple[str, ...] = ("small",)) -> FittedModel:
    """The paper's joint with the truth but for these values, from rest."""
    joint = assemble(STRUCTURE)
    parameters = joint.parameters().with_values(TRUTH | dict(values))
    at_rest: dict[str, Array] = {record.name: np.zeros(joint.nx) for record in clean_records()}
    return FittedModel(name, joint, parameters, "speed", records, at_rest, estimate_states=False)
