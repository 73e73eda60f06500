"""What happened once is found with its time and size, and what a machine always does is no event."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from support.eventful import DRIFT, KNOCK, LEANED, PUSH, STEP, eventful, found
from support.small_bench import fitted

from robotid.diagnosis import Criteria, diagnose
from robotid.diagnosis.events.applied import event_torque, without_events
from robotid.diagnosis.events.detection import energy_of, is_late_torque
from robotid.diagnosis.refit.refitted_model import SegmentFit, Unknowns
from robotid.diagnosis.results import Event
from robotid.diagnosis.scoring.candidate import EffectCandidate
from robotid.diagnosis.scoring.scan import Scan, scans
from robotid.diagnosis.search import events as searching
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.events import ModelInPieces, largest_event, without_event
from robotid.diagnosis.search.state import SearchState
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.extension import extension_task
from robotid.report.tables.diagnose import sentence


@pytest.mark.parametrize(
    "event", [PUSH, LEANED, KNOCK, STEP, DRIFT], ids=["push", "gradual push", "knock", "step", "drift"]
)
def test_an_event_is_found_with_its_time_and_size(event: Event) -> None:
    seen = found(event)
    assert seen is not None
    assert (seen.event.record, seen.event.kind, seen.event.friction) == (event.record, event.kind, event.friction)
    assert seen.event.gradual is event.gradual
    assert seen.event.start == pytest.approx(event.start, abs=0.02)
    assert seen.event.end == pytest.approx(event.end, abs=0.02)
    assert seen.event.torque == pytest.approx(event.torque, rel=0.2)
    assert seen.event.p_value < 1e-3


def test_a_push_beside_a_missing_effect_is_found_too() -> None:
    push = replace(PUSH, torque=0.08)  # what the effect leaves wanders, and a smaller one might be a part of that
    seen = found(push, "stribeck")
    assert seen is not None
    assert (seen.event.record, seen.event.kind) == ("slow", "bump")
    assert (seen.event.start, seen.event.end) == pytest.approx((push.start, push.end), abs=0.02)
    assert seen.event.torque == pytest.approx(push.torque, rel=0.1)


@pytest.mark.parametrize("lacking", ["nothing", "stribeck"])
def test_noise_and_what_a_machine_always_does_are_no_events(lacking: str) -> None:
    assert found(None, lacking) is None


def test_taking_an_event_out_undoes_it() -> None:
    plain, pushed = eventful(None)[0], eventful(PUSH)[0]
    assert np.allclose(without_events(pushed, [PUSH]).tau_m, plain.tau_m)
    assert without_events(plain, [KNOCK]) is plain
    half = pushed.piece(len(pushed) // 2, len(pushed))
    assert np.allclose(without_events(half, [PUSH]).tau_m, plain.tau_m[len(plain) // 2 :])


def test_a_gradual_bump_grows_to_its_size_in_its_middle_and_fades() -> None:
    record = eventful(None)[0]
    torque, t = event_torque(LEANED, record), record.t
    assert torque.max() == pytest.approx(LEANED.torque, rel=1e-3)
    assert t[np.argmax(torque)] == pytest.approx(2.0, abs=2 * record.sampling_time)
    assert np.sum(torque) * record.sampling_time == pytest.approx(LEANED.torque * 1.2 / 2)
    assert not torque[(t < 1.4 - record.sampling_time) | (t >= 2.6)].any()


def test_friction_that_jumps_opposes_the_motion_from_then_on() -> None:
    record = eventful(None)[0]
    torque, t = event_torque(STEP, record), record.t
    assert not torque[t < 2.19].any()
    fast = (t > 2.21) & (np.abs(record.dphi_m) > 1.0)
    assert np.allclose(torque[fast], -STEP.torque * np.sign(record.dphi_m[fast]))


def test_an_edge_between_two_samples_counts_in_part() -> None:
    record = eventful(None)[0]
    h = record.sampling_time
    torque = event_torque(Event("slow", "bump", False, 10.25 * h, 12.5 * h, 1.0, 0.0, 0.0), record)
    assert torque[9:14] == pytest.approx([0.0, 0.75, 1.0, 0.5, 0.0])


@pytest.mark.parametrize("split", [False, True], ids=["whole", "in pieces"])
def test_a_torque_that_changed_between_two_samples_is_no_event(split: bool) -> None:
    record = eventful(None)[0]
    h, torque = record.sampling_time, np.zeros(len(record))
    torque[1000:] = 2.0
    stepped = replace(record, tau_m=torque)
    pieces = [stepped.piece(0, 1000), stepped.piece(1000, len(stepped))] if split else [stepped]
    t = float(stepped.t[1000])

    def bump(start: float, size: float) -> Event:
        return Event("slow", "bump", False, start, start + 4 * h, size, 0.0, 0.0)

    assert is_late_torque(bump(t, 0.45), pieces)
    assert not is_late_torque(bump(t, 0.55), pieces)
    assert is_late_torque(replace(bump(t, 0.9), gradual=True), pieces)
    assert not is_late_torque(bump(t + 10 * h, 0.45), pieces)


def test_a_push_is_reported_beside_the_verdict_and_no_cause_is_named_for_it() -> None:
    made = eventful(PUSH)
    fit = fitted(list(made))
    d = diagnose(fit, made, Criteria(max_refits=1, max_causes=1, skip=("power_friction", "record_change")))
    (push,) = d.events
    assert (d.verdict, d.causes) == ("named", ())
    assert f"a bump of torque by {push.torque:.2g} Nm in {push.record}" in sentence(d)
    assert (push.start, push.end) == pytest.approx((1.7, 2.5), abs=0.01)
    assert push.torque == pytest.approx(0.05, abs=4 * push.std)
    assert d.misfit < d.noise_floor
    task = extension_task(d, fit, made)
    assert task.events == d.events
    cleaned = task.records
    assert np.allclose(cleaned[0].tau_m, eventful(None)[0].tau_m, atol=0.06)


def scored(event: Event | None, lacking: str = "nothing") -> tuple[Evidence, SearchState]:
    """The fitted records with an event, and the first state of a search there with one round of the score."""
    made = eventful(event, lacking)
    model = fitted_model(fitted(list(made)))
    evidence = Evidence(model, [simulate_record(model, r) for r in made if r.name in model.records], [])
    start = first_state(evidence, Criteria(skip=("record_change",))).scored(Criteria())
    return evidence, start


def test_no_event_is_sought_that_could_not_be_worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no event can explain enough, no record is simulated; where none can lead, no catalogue is scored, and one
    that could is compared with the best effects first. What was simulated once is not simulated again."""
    evidence, start = scored(None, "stribeck")
    asked = list[int]()

    def counted(
        segments: Sequence[SegmentFit], unknowns: Unknowns, some: Sequence[EffectCandidate]
    ) -> tuple[Scan, ...]:
        asked.append(len(some))
        return scans(segments, unknowns, some)

    monkeypatch.setattr(searching, "scans", counted)
    records, arguments = ModelInPieces(evidence, start.first, start.data), (Criteria(), start.round.scores)
    assert largest_event(records, *arguments, least=3.0 * start.first.energy) is None
    assert asked == []
    assert largest_event(records, *arguments) is None
    assert asked == [0]
    monkeypatch.setattr(searching, "leads", lambda energy, rival, *_: rival == 0.0)
    assert largest_event(records, *arguments) is None
    assert asked == [0, searching.RIVALS]


def test_what_shows_only_where_a_piece_begins_is_no_event(monkeypatch: pytest.MonkeyPatch) -> None:
    """A push explains about as much of the records however they are cut into pieces."""
    evidence, start = scored(PUSH)
    energies = list[float]()

    def told(event: Event, scans: Sequence[Scan]) -> float:
        energies.append(energy_of(event, scans))
        return energies[-1]

    monkeypatch.setattr(searching, "energy_of", told)
    arguments = ModelInPieces(evidence, start.first, start.data), Criteria(), start.round.scores
    seen = largest_event(*arguments)
    assert seen is not None
    assert energies == [pytest.approx(seen.energy, rel=0.5)]
    monkeypatch.setattr(searching, "energy_of", lambda *_: 0.05 * seen.energy)
    assert largest_event(*arguments) is None


def test_what_leaves_no_less_once_it_is_taken_out_is_no_event() -> None:
    """Where a motor hardly sets off, a torque that ought to explain what is missing may leave more than there was."""
    evidence, start = scored(PUSH)
    records = ModelInPieces(evidence, start.first, start.data)
    settled = first_state(without_event(evidence, PUSH), Criteria()).first
    assert records.is_better_without(PUSH, settled)
    assert not records.is_better_without(replace(PUSH, torque=-PUSH.torque), start.first)
    assert not records.is_better_without(replace(PUSH, torque=3.0 * PUSH.torque), start.first)
