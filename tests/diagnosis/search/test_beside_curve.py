"""Causes beside a torque that no effect explains, once that acts on the records as a curve."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.small_bench import AXIS, STRIBECK, TRUTH, evidence, records_of

from robotid.catalogue import TERMS
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.misfit.curve import BY_SPEED
from robotid.diagnosis.nonparametric.basis import Variable
from robotid.diagnosis.nonparametric.curve_course import NAMES, READERS, is_course
from robotid.diagnosis.nonparametric.curve_fit import fit_acting_along
from robotid.diagnosis.search.beside_curve import explain_most, with_causes, with_curve, without_readers
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.rounds import as_result, find_causes
from robotid.diagnosis.search.state import SearchResult, misfit_energy
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameter
from robotid.model.port import Port
from robotid.model.term import Motion, Partials, Term
from robotid.signals.record import Record

PLACE = Variable("phi_m", "rad", BY_SPEED)
CRITERIA = Criteria(skip=("power_friction", "record_change"))


class PlacedDamping(Term):
    """Damping that grows with the position, which is in no catalogue."""

    name = "placed_damping"
    ports = (Port.MOTOR,)
    parameters = (Parameter("A", "Nm s/rad2", "size", guess=1e-3, bounds=(-1.0, 1.0), null=0.0),)
    formula = source = signature = "of the tests alone"

    def torque(self, m: Motion, p: tuple[float, ...]) -> Array:  # type: ignore[override]
        return np.asarray(p[0] * m.v * m.x)

    def partials(self, m: Motion, p: tuple[float, ...]) -> Partials:  # type: ignore[override]
        return Partials(x=p[0] * m.v, v=p[0] * m.x, theta=(m.v * m.x,))


@cache
def made() -> list[Record]:
    """Records of the axis with a Stribeck effect, and such a damping."""
    structure = AXIS.extended("motor.stribeck")
    listed = [(Port.MOTOR, TERMS[name.partition(".")[2]]) for name in structure.terms]
    joint = Joint(structure, [*listed, (Port.MOTOR, PlacedDamping())], angle=True)
    return records_of(joint, TRUTH | STRIBECK | {"motor.placed_damping.A": 2e-3})


@cache
def found() -> tuple[SearchResult, Evidence]:
    """A search that has named nothing but the curve of the damping, and the records beside that."""
    seen = evidence(made())
    state = first_state(seen, CRITERIA).scored(CRITERIA)
    curve = fit_acting_along(PLACE, state.model, state.data)
    share = curve.energy / misfit_energy(state.first, state.data)
    result = replace(as_result(state), curve=curve, curve_share=share)
    beside = with_curve(seen, result)
    assert beside is not None
    return result, beside


@cache
def again() -> SearchResult:
    """What is found beside the curve."""
    criteria = without_readers(CRITERIA)
    return find_causes(first_state(found()[1], criteria), criteria, lambda _: None)


def test_the_curve_acts_on_every_record_as_a_torque_that_no_effect_may_read() -> None:
    _, beside = found()
    for record in [*(run.record for run in beside.fitted), *beside.validation]:
        assert set(record.companions) == {NAMES[Port.MOTOR]}
        assert len(record.companions[NAMES[Port.MOTOR]].values) == len(record)
    (effect,) = (effect for effect in beside.model.joint.structure.effects if is_course(effect))
    assert beside.model.parameters[f"{effect}.g"] == 1.0
    assert not beside.model.parameters.free[beside.model.parameters.names.index(f"{effect}.g")]
    assert not any("known_torque" in one.candidate.name for seen in again().rounds for one in seen.scores)
    assert {*READERS, "torque_gain"} <= set(without_readers(CRITERIA).skip)


def test_the_cause_that_it_hid_is_named_beside_it() -> None:
    assert [cause.effect for cause in again().causes][:1] == ["motor.stribeck"]
    assert explain_most(again())
    assert not explain_most(replace(again(), causes=()))


def test_the_answer_has_the_cause_and_the_curve_with_shares_of_all_that_was_missing() -> None:
    result, _ = found()
    told = with_causes(result, again())
    assert told.causes[0].effect == "motor.stribeck"
    assert not any(map(is_course, told.last.structure.effects))
    assert "motor.stribeck" in told.last.structure.effects
    assert told.curve is result.curve
    assert 0.0 < told.causes[0].explained < again().causes[0].explained
    assert told.curve_share + sum(cause.explained for cause in told.causes) <= 1.0 + 1e-9
    assert told.last.parameters["motor.stribeck.dFs"] == pytest.approx(0.15, rel=0.2)
    assert misfit_energy(told.last, told.data) < misfit_energy(told.first, told.data)
    assert told.beside_curve
    assert not result.beside_curve
