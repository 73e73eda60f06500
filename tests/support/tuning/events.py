"""Checks of the constants of the detection of events."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import f as fisher

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.events.applied import direction
from robotid.diagnosis.events.bins import BinnedRecord, _basis, even_edges
from robotid.diagnosis.events.detection import _cut, _Placed, hopeful, is_its_own
from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.events.shapes import TORQUE, Shape, _like_drifts, best_shapes, significance, strength
from robotid.diagnosis.events.torque_errors import rippled
from robotid.diagnosis.events.wander import Wander, tried_levels
from robotid.diagnosis.results import Event
from robotid.diagnosis.search import search as searching
from robotid.diagnosis.search.data import Evidence
from robotid.diagnosis.search.events import SeenEvent, leads, leaves_something, shows_again
from robotid.diagnosis.search.state import SearchResult
from robotid.model.array import Array
from support.eventful import PUSH, scanned
from support.plain_models import plain_data, plain_model
from support.tuning import sees


def binned(moment: Array, *, left: float = 1.0) -> BinnedRecord:
    """A record of ten seconds whose bins have nothing to do with each other; of each a part is left."""
    count = moment.shape[1]
    product = left * np.eye(2 * count).reshape(2, count, 2, count)
    return BinnedRecord(
        "a", np.linspace(0.0, 10.0, count + 1), product, moment, np.zeros((2, count, 0)), 1 + 0 * moment
    )


def spike(size: float, count: int = 48) -> BinnedRecord:
    """One bin stands out."""
    moment = np.zeros((2, count))
    moment[TORQUE, 20] = size
    return binned(moment)


@sees(EVENTS, "bins")
def check_a_record_has_four_dozen_bins() -> None:
    assert len(even_edges(scanned(None), "slow")) == 49


@sees(EVENTS, "fine_bins")
def check_an_edge_is_placed_to_an_eighth_of_a_bin() -> None:
    assert np.diff(_cut(np.arange(10.0), 5)) == pytest.approx(1 / 8)


@sees(EVENTS, "longest_bump")
def check_no_bump_is_longer_than_two_fifths() -> None:
    moment = np.zeros((2, 48))
    moment[TORQUE, 1:40] = 1.0
    bumps = [shape for shape in best_shapes(binned(moment)) if shape.kind == "bump"]
    assert max(shape.last - shape.first for shape in bumps if not shape.gradual) == 19
    assert max((shape.last - shape.first for shape in bumps if shape.gradual), default=38) <= 38


@sees(EVENTS, "standstill")
def check_direction_fades_at_a_fiftieth_of_the_speed() -> None:
    speed = np.array([0.01, 0.02, 0.1, 1.0])
    assert direction(speed) == pytest.approx([0.5, 1.0, 1.0, 1.0])


@sees(EVENTS, "step_ways")
def check_a_step_is_judged_by_six_others() -> None:
    moment = np.zeros((2, 48))
    moment[TORQUE, 24:] = 3.0
    p, usual = significance(binned(moment), Shape("step", TORQUE, 24, 48), 1)
    assert usual == 1.0
    assert p == pytest.approx(fisher.sf(24 * 3.0**2, 1, 6))


@sees(EVENTS, "drift_ways")
def check_a_drift_is_judged_by_five_waves() -> None:
    assert len(_like_drifts(spike(1.0), Shape("drift", TORQUE, 0, 48))) == 5


def _wandering(memory: float, level: float) -> tuple[BinnedRecord, Array]:
    """A record of whose torque a process is all that shows, and what it left in each bin."""
    rng, count = np.random.default_rng(5), 48
    t = np.arange(count) / count
    root = np.linalg.cholesky(level * np.exp(-np.abs(t[:, None] - t) / memory) + 1e-12 * np.eye(count))
    torque = root @ rng.standard_normal(count)
    moment = np.stack([torque + rng.standard_normal(count), rng.standard_normal(count)])
    return binned(moment), moment.ravel()


def _found(memory: float) -> float:
    """Variance of the largest wave of such a record's torque, as it is found, over that of the forty-first."""
    seen, left = _wandering(memory, 1e4)
    variances = (Wander.of(np.eye(48, 96), seen.edges)._likeliest_root(left) ** 2).sum(axis=0)
    return float(variances.max() / np.sort(variances)[-41])


@sees(EVENTS, "memories")
def check_a_torque_that_wanders_has_one_of_four_memories() -> None:
    assert (_found(0.01), _found(0.1), _found(10.0)) == pytest.approx((1.6, 81.0, 37e3), rel=0.1)


@sees(EVENTS, "least_wander")
def check_the_smallest_wander_is_a_hundredth_of_the_noise() -> None:
    assert tried_levels()[1] == pytest.approx(1e-2)


@sees(EVENTS, "most_wander")
def check_the_largest_wander_is_a_hundred_million_times_the_noise() -> None:
    assert tried_levels()[-1] == pytest.approx(1e8)


@sees(EVENTS, "levels")
def check_a_wander_is_tried_at_four_levels_a_decade() -> None:
    assert tried_levels()[2] / tried_levels()[1] == pytest.approx(10**0.25)


@sees(EVENTS, "wander_draws")
def check_what_an_event_gains_by_chance_is_drawn_two_hundred_times() -> None:
    seen, left = _wandering(1.0, 1.0)
    assert len(Wander.of(np.eye(48, 96), seen.edges).drawn_gains(left, np.eye(1, 96))) == 200


@sees(EVENTS, "dependent")
def check_what_differs_by_less_than_a_billionth_is_one_direction() -> None:
    def directions(apart: float) -> int:
        return _basis(np.array([[1.0, 1.0 - apart], [1.0 - apart, 1.0]])).shape[1]

    assert (directions(4e-9), directions(1e-9)) == (2, 1)


@sees(EVENTS, "least_left")
def check_an_event_of_which_a_ten_thousandth_is_left_is_none() -> None:
    moment = spike(1.0).moment
    for left, seen in ((2e-4, True), (5e-5, False)):
        one = binned(moment, left=left)
        assert (strength(one, Shape("bump", TORQUE, 20, 21)).energy > 0.0) is seen


@sees(EVENTS, "hopeful_share")
def check_half_of_the_largest_event_is_hopeful() -> None:
    shape = Shape("bump", TORQUE, 20, 21)
    placed = [_Placed(spike(float(np.sqrt(energy))), shape) for energy in (100.0, 55.0, 45.0)]
    assert len(hopeful(placed)) == 2


@sees(EVENTS, "own_share")
def check_an_event_is_its_own_from_a_fiftieth_that_effects_leave() -> None:
    assert is_its_own(2.1, 100.0)
    assert not is_its_own(1.9, 100.0)


@sees(EVENTS, "cut_share")
def check_an_event_of_which_a_tenth_shows_where_records_are_cut_elsewhere_is_none_of_the_cut() -> None:
    assert shows_again(11.0, 100.0)
    assert not shows_again(9.0, 100.0)


@sees(EVENTS, "leading_share")
def check_an_event_goes_before_effects_from_four_fifths_of_what_they_explain() -> None:
    assert leads(81.0, 100.0, 1.0)
    assert not leads(79.0, 100.0, 1.0)


@sees(EVENTS, "least_share")
def check_an_event_that_goes_before_effects_is_half_of_the_misfit() -> None:
    assert leads(100.0, 0.0, 0.51)
    assert not leads(100.0, 0.0, 0.49)


@sees(EVENTS, "chance")
def check_three_deviations_of_the_energy_of_noise_are_chance() -> None:
    deviation = np.sqrt(2000.0)
    assert leaves_something(plain_model(1000.0 + 3.1 * deviation), plain_data())
    assert not leaves_something(plain_model(1000.0 + 2.9 * deviation), plain_data())


@sees(EVENTS, "pieces")
def check_records_are_cut_into_a_dozen_pieces() -> None:
    assert sum(one.segment.record.name == "slow" for one in scanned.__wrapped__(None)) == 12


@sees(EVENTS, "ripples")
def check_a_torque_may_ripple_up_to_two_dozen_times_a_turn() -> None:
    assert len(rippled(scanned(None)[0].segment.record)) == 25


@sees(EVENTS, "max_events")
def check_four_events_are_set_aside() -> None:
    result = SearchResult(plain_data(), plain_model(1.0), plain_model(1.0), (), (), ())
    with pytest.MonkeyPatch.context() as patch:
        seen = SimpleNamespace(scores=())
        state = SimpleNamespace(first=None, data=None, round=seen, rounds=(seen,))
        patch.setattr(searching, "first_state", lambda *_: state)
        patch.setattr(searching.ModelInPieces, "is_better_without", lambda *_: True)
        patch.setattr(searching, "largest_event", lambda *_: SeenEvent(replace(PUSH, std=0.001), leading=True))
        patch.setattr(searching, "_settled", lambda _, event, __: event)
        patch.setattr(searching, "without_event", lambda evidence, _: evidence)
        patch.setattr(searching, "_by_each_noise", lambda *_: result)
        found = searching.search(Evidence(SimpleNamespace(), [], []), Criteria(), lambda _: None)  # type: ignore[arg-type]
    assert len(found.events) == 4


@sees(EVENTS, "max_resizings")
def check_an_event_is_sized_three_times() -> None:
    sized = list[Event]()

    def larger(event: Event, _: object) -> Event:
        sized.append(replace(event, torque=event.torque + 1.0, std=0.1))
        return sized[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(searching, "first_state", lambda *_: SimpleNamespace(first=None, data=None))
        patch.setattr(searching, "placed_again", lambda _, event, *__: event)
        patch.setattr(searching, "without_event", lambda evidence, _: evidence)
        patch.setattr(searching, "resized", larger)
        searching._settled(None, PUSH, Criteria())  # type: ignore[arg-type]
    assert len(sized) == 3
