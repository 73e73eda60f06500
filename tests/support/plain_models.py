"""Refitted models that nobody fitted: what they leave is prescribed, for tests of what is decided by it."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, Unknowns
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

AXIS = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
SAMPLES = 1000


def plain_record(samples: int = SAMPLES, name: str = "plain") -> Record:
    """A record of nothing, with noise of unit variance."""
    nothing = np.zeros(samples)
    return Record(name, "estimate", "both", 0.01, nothing, nothing, nothing)


@cache
def plain_trajectory(samples: int = SAMPLES) -> Trajectory:
    """The axis at rest."""
    joint = assemble(AXIS)
    return simulate(joint, joint.parameters().values, plain_record(samples))


def plain_segment(energy: float, *, samples: int = SAMPLES, fit_percent: float = 90.0) -> SegmentFit:
    """A segment that leaves this energy."""
    residual = np.full(samples, np.sqrt(energy / samples))
    return SegmentFit(plain_record(samples), plain_trajectory(samples), residual, UNIT_WHITENING, energy, fit_percent)


def plain_model(energy: float, validation_energy: float = 1.0, **changed: Any) -> RefittedModel:
    """A model that leaves these energies on a thousand samples each."""
    joint = assemble(AXIS)
    values: dict[str, Any] = {
        "joint": joint,
        "parameters": joint.parameters(),
        "unknowns": Unknowns("speed", (0, 1, 2), (0,)),
        "factor": np.eye(4),
        "fitted": (plain_segment(energy),),
        "validation": (plain_segment(validation_energy, fit_percent=100.0 - 1e-3 * validation_energy),),
    }
    return RefittedModel(**(values | changed))


def plain_data(*, noise_reached: bool = True, validation: bool = True) -> EvaluationData:
    """The data of such models."""
    segment = Segment(plain_record(), UNIT_WHITENING)
    held = (segment,) if validation else ()
    return EvaluationData((segment,), held, "speed", True, noise_reached, torque_errors=None)


def plain_blocks(columns: int, blocks: int = 40) -> BlockedRegression:
    """A regression in which every column counts in every block alike, but for a thousandth."""
    moment = 1.0 + 1e-3 * np.random.default_rng(1).standard_normal((blocks, columns))
    return BlockedRegression(np.tile(np.eye(columns), (blocks, 1, 1)), moment, np.full(blocks, 2.0 * columns))
