"""The size of what happened once, and how well it is known beside errors of the torque."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from support.eventful import PUSH, STEP, eventful, with_event
from support.small_bench import QUICK, evidence, fitted, records

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.results import Event
from robotid.diagnosis.search import events
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.events import (
    ModelInPieces,
    SeenEvent,
    largest_event,
    placed_again,
    resized,
    stands_out,
    with_deviation,
    without_event,
)
from robotid.diagnosis.search.rounds import find_causes
from robotid.diagnosis.search.search import Aside, _leading_event, _sized_beside_causes
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.interrupt import OutOfTime
from robotid.model.companion import CompanionKind
from robotid.signals.companion import Companion

AR = 0.99  # a memory of 0.2 s


def pushed(seed: int, error: float) -> Evidence:
    """Records with a push, beside slow errors of the torque [Nm]."""
    rng, made = np.random.default_rng(seed), []
    for record in records({}, seed=seed + 1):
        slow = lfilter([error * np.sqrt(1.0 - AR**2)], [1.0, -AR], rng.standard_normal(len(record)))
        made.append(with_event(replace(record, tau_m=record.tau_m + slow), PUSH))
    model = fitted_model(fitted(made))
    return Evidence(model, [simulate_record(model, one) for one in made if one.name in model.records], [])


def sized(seed: int, error: float) -> tuple[Event, Event]:
    """The push with its deviation by the sensors' noise and by all."""
    evidence, event = pushed(seed, error), PUSH
    for _ in range(3):
        first = first_state(without_event(evidence, event), Criteria()).first
        event = resized(event, first)
    return event, with_deviation(event, first)


def placed(seed: int) -> tuple[Event, Event]:
    """The push at the times that the records tell, beside the noise of the sensors, with its deviation at these times
    and with that of its times."""
    evidence, event, criteria = pushed(seed, 0.0), PUSH, Criteria()
    for _ in range(2):
        beside = first_state(without_event(evidence, event), criteria)
        event = placed_again(evidence, event, beside.first, beside.data, criteria)
        first = first_state(without_event(evidence, event), criteria).first
        event = resized(event, first)
    return event, with_deviation(event, first)


def test_beside_slow_errors_a_push_is_as_uncertain_as_it_scatters() -> None:
    pairs = [sized(seed, 0.01) for seed in range(1, 4)]
    off = np.array([event.torque - PUSH.torque for event, _ in pairs])
    sensors, all_noise = (np.array([one.std for one in ones]) for ones in zip(*pairs, strict=True))
    assert np.sqrt(np.mean((off / sensors) ** 2)) > 8.0
    assert np.sqrt(np.mean((off / all_noise) ** 2)) < 3.0


def test_beside_the_noise_of_the_sensors_alone_it_scatters_as_an_event_whose_times_are_found_too() -> None:
    pairs = [placed(seed) for seed in range(1, 7)]
    off = np.array([known.torque - PUSH.torque for _, known in pairs])
    at_known_times, known = (np.array([one.std for one in ones]) for ones in zip(*pairs, strict=True))
    assert np.sqrt(np.mean((off / at_known_times) ** 2)) > 2.0
    assert np.sqrt(np.mean((off / known) ** 2)) < 2.0
    assert (known < 2.0 * at_known_times).all()


@pytest.mark.parametrize("reached", [False, True])
def test_an_event_that_the_sensors_noise_does_not_show_is_sought_beside_white_errors(
    reached: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    evidence = pushed(1, 0.0)
    start = first_state(evidence, Criteria()).scored(Criteria())
    start = replace(start, data=replace(start.data, noise_reached=reached))
    by = list[object]()

    def seen(records: ModelInPieces, *_: object) -> SeenEvent | None:
        by.append(records.data.torque_errors)
        return None if len(by) == 1 else largest_event(records, Criteria())

    monkeypatch.setattr("robotid.diagnosis.search.search.largest_event", seen)
    found, white = _leading_event(Aside.of(evidence, start), Criteria(), lambda _: None)
    assert by == ([None] if reached else [None, "white"])
    assert (found is None) == (white is None) == reached
    if found is not None:
        assert (found.event.record, found.event.kind, found.leading) == (PUSH.record, PUSH.kind, True)
        assert (found.event.start, found.event.end) == pytest.approx((PUSH.start, PUSH.end), abs=0.03)


@pytest.mark.parametrize("astray", [0.0, -0.007])
def test_an_event_that_a_missing_effect_led_astray_is_sized_beside_it(astray: float) -> None:
    made, event = eventful(STEP, "stribeck"), replace(STEP, torque=STEP.torque + astray, std=0.001)
    model = fitted_model(fitted(list(made)))
    evidence = Evidence(model, [simulate_record(model, one) for one in made if one.name in model.records], [])
    criteria = replace(QUICK, skip=(*QUICK.skip, "record_change"))
    without = without_event(evidence, event)
    start = first_state(without, criteria).scored(criteria)
    found = find_causes(start, criteria, lambda _: None)
    aside = Aside.of(without, start, [event])
    result, after = _sized_beside_causes(found, aside, criteria, lambda _: None)
    (sized,) = after.events
    assert [cause.effect for cause in result.causes] == ["motor.stribeck"]
    assert (result is found) == (after is aside) == (not astray)
    assert abs(sized.torque - STEP.torque) < 0.001
    pieces, known = after.records.data.fitted, after.evidence.fitted
    assert all(np.array_equal(one.record.tau_m, run.record.tau_m) for one, run in zip(pieces, known, strict=True))


def test_an_event_stands_out_of_noise_by_three_deviations_of_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    evidence = pushed(1, 0.0)
    first = first_state(without_event(evidence, PUSH), QUICK).first
    for of_std, out in ((3.1, True), (2.9, False)):
        known = replace(PUSH, std=abs(PUSH.torque) / of_std)
        monkeypatch.setattr(events, "with_deviation", lambda *_, known=known: known)
        assert stands_out(PUSH, first, QUICK) is out


def test_no_event_is_found_where_time_runs_out_while_one_is_sought(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_late(*_: object, **__: object) -> None:
        raise OutOfTime

    seen = pushed(1, 0.0)
    start = first_state(seen, QUICK)
    records_in_pieces = ModelInPieces(seen, start.first, start.data)
    assert largest_event(records_in_pieces, QUICK, least_share=0.01) is not None
    monkeypatch.setattr(events, "find_event", too_late)
    assert largest_event(records_in_pieces, QUICK, least_share=0.01) is None


def test_what_reads_a_companion_competes_with_an_event() -> None:
    """A push that a load cell has recorded is no event, for an effect explains it."""
    made = []
    for record in records({}):
        pushed_at = with_event(record, PUSH)
        cell = Companion.of(CompanionKind.TORQUE, record.tau_m - pushed_at.tau_m, record.sampling_time)
        made.append(replace(pushed_at, companions={"cell": cell}))
    for known, leads in ((made, False), ([replace(one, companions={}) for one in made], True)):
        seen = evidence(known)
        start = first_state(seen, QUICK)
        found = largest_event(ModelInPieces(seen, start.first, start.data), QUICK)
        assert (found is not None and found.leading) is leads
