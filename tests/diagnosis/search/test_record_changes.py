"""What changed on a validation record must explain it, and its fit must rise with it; several parameters must leave
nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from support.plain_models import plain_model, plain_segment
from support.small_bench import AXIS, TRUTH, Criteria, FitOptions, records_of

from robotid.catalogue import assemble
from robotid.diagnosis.noise.whitening import UNIT_WHITENING, Segment
from robotid.diagnosis.procedure import DiagnosisOptions, diagnose
from robotid.diagnosis.refit.refitted_model import RecordFit
from robotid.diagnosis.results import Diagnosis
from robotid.diagnosis.scoring.record_change_candidate import RecordChangeCandidate
from robotid.diagnosis.search import changed_record, record_changes
from robotid.diagnosis.search.changed_record import Halves, _parts
from robotid.estimate.grey_box import fit_model
from robotid.model.array import Array
from robotid.report.tables.diagnose import sentence

WEIGHT = {"motor.gravity.G": 0.8, "motor.gravity.H": 0.1}


@pytest.mark.parametrize(("gain", "asked"), [(0.1, 3), (-0.3, 0)])
def test_a_change_with_which_the_fit_falls_is_none(gain: float, asked: int, monkeypatch: pytest.MonkeyPatch) -> None:
    one, model = plain_segment(2000.0), plain_model(1000.0)
    before = RecordFit((one,), "speed")
    after = RecordFit((plain_segment(1000.0, fit_percent=one.fit_percent + gain),), "speed")
    monkeypatch.setattr(changed_record, "_fitted_values", lambda *_: (0.1,))
    monkeypatch.setattr(changed_record, "simulated", lambda *_: after)
    halves = Halves(model, (Segment(one.record, UNIT_WHITENING),), before, 1.0)
    assert len(record_changes._asked_for(halves, halves.unchanged)) == asked


def weighted(changed: Mapping[str, float]) -> Diagnosis:
    """The diagnosis of an axis with a weight, some of whose parameters are so many times as large on the record that
    was held out."""
    structure = replace(AXIS.extended("motor.gravity"), recorded_angle=True)
    plant = assemble(replace(structure, recorded_angle=False), angle=True)
    truth = TRUTH | WEIGHT
    other = {name: value * changed.get(name, 1.0) for name, value in truth.items()}
    made = [*records_of(plant, truth)[:2], records_of(plant, other)[2]]
    joint = assemble(structure)
    start = joint.parameters().with_values({name: 1.1 * value for name, value in truth.items()})
    return diagnose(fit_model("m", joint, start, made[:2], FitOptions()), made, Criteria(max_refits=1))


@pytest.mark.parametrize(
    "changed",
    [
        pytest.param({"motor.inertia.J": 1.3, "motor.gravity.G": 1.4}, id="inertia and weight"),
        pytest.param(
            {"motor.inertia.J": 1.3, "motor.gravity.G": 1.4, "motor.gravity.H": 1.4},
            id="and its place",
            marks=pytest.mark.slow,
        ),
        pytest.param({"motor.inertia.J": 1.3}, id="inertia alone"),
    ],
)
def test_all_that_a_payload_changes_is_named(changed: dict[str, float]) -> None:
    found = weighted(changed)
    assert found.verdict == "named"
    sizes = {cause.effect: cause.parameters[0].value for cause in found.causes}
    truth = {f"record_change.check.{n}": (factor - 1.0) * (TRUTH | WEIGHT)[n] for n, factor in changed.items()}
    assert sizes == pytest.approx(truth, rel=0.05)
    for cause in found.causes:
        (one,) = cause.parameters
        assert abs(one.value - truth[cause.effect]) < 4.0 * one.std < 0.2 * abs(one.value)
    assert sum(cause.explained for cause in found.causes) == pytest.approx(1.0, abs=0.01)
    assert all(cause.explained > 0.0 < cause.heldout_gain for cause in found.causes)
    assert all(name.removeprefix("record_change.check.") in sentence(found) for name in sizes)


def test_a_set_of_changes_that_leaves_something_is_none() -> None:
    """Friction that one direction has more of, on the record that was held out only."""
    plant = assemble(AXIS.extended("motor.asymmetric_coulomb"), angle=True)
    even = TRUTH | {"motor.asymmetric_coulomb.dFc": 0.0}
    made = [*records_of(plant, even)[:2], records_of(plant, even | {"motor.asymmetric_coulomb.dFc": 0.15})[2]]
    joint = assemble(AXIS)
    found = diagnose(fit_model("m", joint, joint.parameters().with_values(TRUTH), made[:2], FitOptions()), made)
    assert len(found.causes) <= 1


def split(samples: int, energy: Array, pieces: int = 1) -> tuple[list[int], list[int]]:
    """How many samples the segments of both parts of a record have, whose residual has such an energy."""
    whole = plain_segment(1.0)
    edges = np.linspace(0, samples, pieces + 1).astype(int).tolist()
    seen = [replace(whole, record=whole.record.piece(a, b), residual=np.sqrt(energy[a:b])) for a, b in pairwise(edges)]
    first, second = _parts(seen)
    return [len(one.record) for one in first], [len(one.record) for one in second]


def test_each_part_has_half_of_what_is_wrong() -> None:
    n = 400
    energy = np.where(np.arange(n) < n // 2, 1.0, 0.0)  # it rests in the second half
    (first,), (second,) = split(n, energy)
    assert abs(first - n // 4) <= 1
    assert first + second == n


def test_a_short_piece_is_halved() -> None:
    assert split(12, np.eye(12)[0]) == ([6], [6])


def test_pieces_go_to_one_part_or_the_other() -> None:
    assert split(300, np.ones(300), 3) == ([100, 49], [51, 100])
    assert split(330, np.where(np.arange(330) < 210, 1.0, 0.0), 3) == ([110], [110, 110])  # five more are no segment


@pytest.mark.parametrize("horizon", [None, 0.5])
def test_a_change_is_found_in_pieces_of_a_record_as_in_all_of_it(horizon: float | None) -> None:
    plant = assemble(AXIS, angle=True)
    other = TRUTH | {"motor.inertia.J": 1.3 * TRUTH["motor.inertia.J"]}
    made = [*records_of(plant, TRUTH)[:2], records_of(plant, other)[2]]
    joint = assemble(AXIS)
    fit = fit_model("m", joint, joint.parameters().with_values(TRUTH), made[:2], FitOptions(horizon=horizon))
    found = diagnose(fit, made, options=DiagnosisOptions(horizon))
    (cause,) = found.causes
    assert cause.effect == "record_change.check.motor.inertia.J"
    (one,) = cause.parameters
    assert one.value == pytest.approx(0.3 * TRUTH["motor.inertia.J"], abs=3.0 * one.std)
    assert 10.0 * one.std < one.value


def test_the_change_that_gains_most_comes_first_and_the_shares_add_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a payload, the inertia alone may lower the fit that it raises beside the weight."""
    one, model = plain_segment(2000.0), plain_model(1000.0)
    halves = Halves(model, (Segment(one.record, UNIT_WHITENING),), RecordFit((one,), "speed"), 0.0)
    first, second, *_ = (candidate.name for candidate in halves.candidates)
    ends = {(): (2000.0, 80.0), (first,): (2200.0, 78.0), (second,): (800.0, 84.0), (second, first): (200.0, 85.0)}

    def simulated(_: object, __: object, candidates: list[RecordChangeCandidate], ___: object) -> RecordFit:
        energy, fit = ends[tuple(candidate.name for candidate in candidates)]
        return RecordFit((plain_segment(energy, fit_percent=fit),), "speed")

    monkeypatch.setattr(record_changes, "simulated", simulated)
    made = tuple(record_changes.RecordChange(name, 1.0, "1", 0.0, -2.0, 1e-9, (name,)) for name in (first, second))
    found = record_changes._with_gains(halves, halves.before, made)
    assert [change.effect for change in found] == [second, first]
    assert [change.gain for change in found] == pytest.approx([4.0, 1.0])
    assert [change.explained for change in found] == pytest.approx([0.6, 0.3], abs=0.01)
