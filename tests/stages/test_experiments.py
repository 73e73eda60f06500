"""The experiment that is proposed to tell twins apart: a block that a record takes, and that does tell them apart."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.diagnosed import NAMED, STRIBECK
from support.small_bench import CONTROLLER, begun, records

from robotid.catalogue import assemble
from robotid.config.load import parse
from robotid.config.schema import Config
from robotid.diagnosis.experiment import with_experiments
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.results import Cause, Separation
from robotid.diagnosis.search.state import AcceptedCause, SearchResult
from robotid.estimate.residual import observed
from robotid.model.parameters import KnownParameter
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate
from robotid.stages.excite import excite
from robotid.stages.experiments import experiments

TEXT = """\
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - {name: usual, excite: {kind: triangle, amplitude: 8, period: 2, sampling_time: 0.002}}
  - name: proposed
    excite: BLOCK
plant:
  parameters: {motor.inertia.J: 0.012, motor.viscous.Fv: 0.015, motor.coulomb.Fc: 0.6}
  controller: {kind: speed, kp: 0.5, ki: 5}
"""
USUAL = '{"kind": "square", "amplitude": 5, "period": 2, "sampling_time": 0.002}'
TWINS = {
    "delays": ({"torque.torque_delay.Td": 1.3e-3}, {"speed.sensor_delay.Td": 1.3e-3}),
    "frictions": (
        {"motor.quadratic_friction.Fq": 6e-4},
        {"motor.power_friction.Fp": 3e-3, "motor.power_friction.alpha": 1.5},
    ),
}
"""What is hidden, and what is taken for it."""
FIXED = ("motor.power_friction.alpha",)
"""A free exponent would make the one law the other."""


def effect_of(values: dict[str, float]) -> str:
    return next(iter(values)).rpartition(".")[0]


def configured(block: str) -> Config:
    """A configuration with a record that takes a block as it stands: JSON is YAML."""
    return parse(TEXT.replace("BLOCK", block))


@cache
def twins(case: str) -> tuple[EvaluationData, RefittedModel, RefittedModel, RefittedModel]:
    """A bench, the model without either effect, and with each, all fitted to the same records."""
    hidden, other = TWINS[case]
    state = begun(records(hidden))
    where, first = state.data, state.model
    fitted = []
    for values in (hidden, other):
        structure, start = extended(first, effect_of(values), values)
        start = start.with_known({n: KnownParameter(values[n], fixed=True) for n in FIXED if n in values})
        fitted.append(refit(structure, [start], where, first.trajectories))
    one, rival = fitted
    return where, first, one, rival


@cache
def proposed(case: str) -> Separation:
    """What the stage says of a cause that has a twin."""
    where, first, one, rival = twins(case)
    names = tuple(effect_of(values) for values in TWINS[case])
    found = AcceptedCause(names[0], 0.9, 1.0, 1e-9, names, first, one, rival)
    growth = SearchResult(where, first, one, (found,), (), ())
    cause: Cause = replace(STRIBECK, effect=names[0], twins=names, separation=None)
    diagnosis = with_experiments(replace(NAMED, causes=(cause,)), growth, experiments(configured(USUAL)))
    (told,) = diagnosis.causes
    assert told.separation is not None
    return told.separation


def noise(where: EvaluationData) -> float:
    """Standard deviation of the speed's noise as the bench sees it."""
    return float(np.sqrt(np.mean([s.whitening.levels.output for s in where.fitted])))


def difference(one: RefittedModel, other: RefittedModel, reference: Reference) -> float:
    """RMS difference of the speeds that two models make of one experiment, from rest [rad/s]: the first under the
    controller, the second under the torque that it took."""
    joint = assemble(one.structure, angle=True)
    played: Record = VirtualRobot(joint, one.parameters.values, CONTROLLER).record(reference, 0)
    rival = assemble(other.structure)
    answer = simulate(rival, other.parameters.values, played, np.zeros(rival.nx))
    return float(np.sqrt(np.mean((played.dphi_m - observed(answer, "speed")) ** 2)))


def realised(block: str) -> Reference:
    """The reference that the excite stage makes of a proposed block."""
    return next(r for r in excite(configured(block)).references if r.block == "proposed")


@pytest.mark.parametrize("case", TWINS)
def test_the_proposal_names_the_twin_and_is_a_block_of_a_record(case: str) -> None:
    found = proposed(case)
    assert found.against == effect_of(TWINS[case][1])
    config = configured(found.excite)
    block = config.records[1].excite
    assert block is not None
    assert block.kind == json.loads(found.excite)["kind"]
    reference = realised(found.excite)
    assert len(reference.ref) > 100
    assert reference.sampling_time == pytest.approx(0.002)
    # no faster than what the joint has done on record
    assert np.abs(reference.ref).max() <= 1.05 * max(
        float(np.abs(s.record.dphi_m).max()) for s in twins(case)[0].fitted
    )


@pytest.mark.parametrize("case", TWINS)
def test_it_separates_the_models_by_what_it_claims(case: str) -> None:
    """The claim is the smaller, by the first state that suits the second model best."""
    where, _, one, rival = twins(case)
    found = proposed(case)
    ratio = difference(one, rival, realised(found.excite)) / noise(where)
    assert found.ratio == pytest.approx(ratio, rel=0.2)
    assert found.ratio**2 * len(realised(found.excite).ref) > 100  # of chi-square: told apart by one experiment


@pytest.mark.parametrize("case", TWINS)
def test_it_separates_them_better_than_the_records_that_there_are(case: str) -> None:
    where, _, one, rival = twins(case)
    apart = [b.residual - a.residual for a, b in zip(one.fitted, rival.fitted, strict=True)]
    assert proposed(case).ratio > 2 * float(np.sqrt(np.mean(np.concatenate(apart) ** 2))) / noise(where)
