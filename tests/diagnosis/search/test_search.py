"""What a search finds on a small axis: effects that were hidden there, one question a test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from support.eventful import PUSH, with_event
from support.small_bench import (
    AXIS,
    QUICK,
    SPEED_NOISE,
    STRIBECK,
    TRUTH,
    fitted,
    idle_then_stribeck,
    records,
    records_of,
    searched,
    simulated,
)

from robotid.catalogue import assemble
from robotid.diagnosis.noise.colour import ColouredNoise
from robotid.diagnosis.noise.noise_estimate import TorqueErrors
from robotid.diagnosis.nonparametric.curve_fit import fit_curves
from robotid.diagnosis.results import Diagnosis, Event
from robotid.diagnosis.search import rounds
from robotid.diagnosis.search import search as searching
from robotid.diagnosis.search.agreement import Agreement
from robotid.diagnosis.search.events import SeenEvent
from robotid.diagnosis.search.record_changes import RecordChange
from robotid.diagnosis.search.state import RejectedCause, SearchResult, SearchState, is_plain, share_removed
from robotid.diagnosis.search.unexplained import without_parts
from robotid.diagnosis.verdict import verdict
from robotid.estimate.fitted_model import fitted_model
from robotid.signals.record import Record

COGGING = {"motor.cogging.A": 0.04, "motor.cogging.B": 0.03, "motor.cogging.n": 6.0}


def told(made: list[Record], growth: SearchResult) -> Diagnosis:
    return verdict(fitted_model(fitted(made)), simulated(made), growth)


def only_in_the_fit() -> list[Record]:
    """A drift of the torque on the day of the fit, gone on the day of the check."""
    return [*records({"motor.constant_torque.tau0": 0.01})[:2], records({})[2]]


@cache
def question(name: str) -> tuple[list[Record], SearchResult, Diagnosis]:
    """Records, what the search finds on them, and the verdict; each asked once."""
    made = {
        "clean": lambda: records({}),
        "stribeck": lambda: records(STRIBECK),
        "pair": lambda: records(COGGING | STRIBECK),
        "warm": lambda: records({}, changed={"motor.coulomb.Fc": 1.1}),
        "accident": only_in_the_fit,
    }[name]()
    criteria = replace(QUICK, skip=("power_friction", "record_change")) if name == "pair" else QUICK
    growth = searched(made, criteria)
    return made, growth, told(made, growth)


def values(growth: SearchResult) -> dict[str, float]:
    """Of the last model, by name."""
    return dict(zip(growth.last.parameters.names, growth.last.parameters.values.tolist(), strict=True))


def test_nothing_is_named_where_nothing_is_missing() -> None:
    _, growth, d = question("clean")
    assert (d.verdict, d.causes, d.shape) == ("clean", (), None)
    assert growth.changes == ()
    assert d.misfit < 0.5 * d.noise_floor
    assert d.remaining == d.misfit
    assert {m.explained_after for m in d.records.values()} == {0.0}
    assert all(r.explained < 0.3 for r in d.rejected)
    # the noise of the torque adds to that of the speed, and a floor is an estimate
    assert d.noise_floor == pytest.approx(SPEED_NOISE, rel=0.3)


@pytest.mark.parametrize("seed", [2, 3])
def test_nothing_is_named_under_other_noise(seed: int) -> None:
    growth = searched(records({}, seed=seed), QUICK)
    assert (growth.causes, growth.curve, growth.changes) == ((), None, ())


def test_a_hidden_stribeck_effect_is_named_with_its_amplitude() -> None:
    _, growth, d = question("stribeck")
    assert (d.verdict, [c.effect for c in d.causes]) == ("named", ["motor.stribeck"])
    (cause,) = d.causes
    estimates = {p.name: p for p in cause.parameters}
    for name, truth in STRIBECK.items():
        assert abs(estimates[name].value - truth) < 4 * estimates[name].std
        assert estimates[name].std < 0.1 * truth
    assert cause.explained > 0.95
    assert cause.p_value < 1e-9
    assert d.remaining < 0.2 * d.misfit
    assert values(growth)["motor.coulomb.Fc"] == pytest.approx(0.6, rel=0.01)


def test_the_gain_that_a_cause_claims_is_that_of_its_held_out_record() -> None:
    _, growth, _ = question("stribeck")
    (found,) = growth.causes
    assert found.gain == pytest.approx(found.after.validation_fit_percent - found.before.validation_fit_percent)
    assert found.gain > 1.0
    assert found.after.validation_energy < 1.2 * growth.data.validation_samples


def test_both_effects_of_a_pair_are_named() -> None:
    _, growth, d = question("pair")
    named = {effect for cause in d.causes for effect in cause.twins}
    assert {"motor.cogging", "motor.stribeck"} <= named
    assert d.verdict == "named"
    found = values(growth)
    assert np.hypot(found["motor.cogging.A"], found["motor.cogging.B"]) == pytest.approx(0.05, rel=0.1)
    assert found["motor.stribeck.dFs"] == pytest.approx(0.15, rel=0.1)


def test_what_causes_explain_adds_up_to_what_they_leave() -> None:
    """All by the noise that shows at last."""
    _, growth, d = question("pair")
    first, data = growth.first, growth.judging
    removed = share_removed(first, first, growth.last, data, plain=is_plain(first, data))
    assert len(d.causes) > 1
    assert sum(cause.explained for cause in d.causes) == pytest.approx(removed, abs=1e-3)
    assert sum(cause.explained for cause in d.causes) + d.remaining_share == pytest.approx(1.0, abs=1e-12)


def test_what_differs_in_one_fitted_record_is_named_with_its_size() -> None:
    """Warmer in the slow record by a tenth of the friction; which of two records is the odd one, none can tell."""
    _, growth, d = question("warm")
    first = d.causes[0]
    slow, wide = (f"record_change.{name}.motor.coulomb.Fc" for name in ("slow", "wide"))
    assert first.effect in (slow, wide)
    assert {slow, wide} <= set(first.twins)
    (estimate,) = first.parameters
    assert estimate.value == pytest.approx(0.06 if first.effect == slow else -0.06, rel=0.05)
    assert (estimate.unit, d.verdict) == ("Nm", "named")
    assert growth.causes[0].explained > 0.95


def test_an_accident_of_the_fitted_records_does_not_carry_over() -> None:
    _, growth, d = question("accident")
    assert "motor.constant_torque" not in {effect for cause in d.causes for effect in cause.twins}
    rejected = {one.effect: one for one in growth.rejected}
    one = rejected["motor.constant_torque"]
    assert one.why.startswith("does not carry over")
    assert one.gain < 0.0
    assert one.explained > 0.5
    assert ("motor.constant_torque", one.why) in {(r.effect, r.why) for r in d.rejected}


def test_a_misfit_far_above_the_noise_is_not_called_clean() -> None:
    """Nothing is named there, and no shape stands; it is a misfit all the same."""
    made, growth, _ = question("accident")
    bare = replace(growth, causes=(), changes=(), curve=None, last=growth.first, coloured=None)
    d = told(made, bare)
    assert d.misfit > 2 * d.noise_floor
    assert d.verdict == "unknown"
    assert any("far above the noise" in remark for remark in d.remarks)
    assert not any(r.why == "there is nothing to explain" for r in d.rejected)


def test_what_is_skipped_is_not_scored() -> None:
    _, growth, _ = question("clean")
    scored = {s.candidate.name for r in growth.rounds for s in r.scores}
    assert "motor.power_friction" not in scored
    assert {"motor.stribeck", "motor.presliding", "torque.torque_delay", "angle.encoder_ripple"} <= scored
    assert any(name.startswith("record_change.") for name in scored)


def test_every_rejection_tells_why_and_none_is_a_cause() -> None:
    for name in ("clean", "stribeck", "accident"):
        _, _, d = question(name)
        names = [r.effect for r in d.rejected]
        assert len(names) == len(set(names))
        assert not set(names) & {effect for cause in d.causes for effect in cause.twins}
        assert all(r.why for r in d.rejected)


def test_what_differs_on_a_record_held_out_is_told_with_its_size() -> None:
    warm = records_of(assemble(AXIS, angle=True), TRUTH | {"motor.coulomb.Fc": 0.7})[2]
    made = [*records({})[:2], warm]
    growth = searched(made, QUICK)
    (one,) = growth.changes
    assert growth.causes == ()
    assert one.effect == "record_change.check.motor.coulomb.Fc"
    assert one.value == pytest.approx(0.1, rel=0.1)
    assert told(made, growth).verdict == "named"


@pytest.mark.parametrize(
    ("reached", "named", "tried", "stands"),
    [
        (True, {None: "cause"}, [None], None),
        (True, {None: "noise"}, [None], None),  # nothing is missing
        (True, {}, [None, "coloured"], None),
        (True, {"coloured": "cause"}, [None, "coloured"], "coloured"),
        (False, {"white": "cause", None: "cause"}, ["white"], "white"),
        (False, {"white": "noise", None: "cause"}, ["white"], "white"),
        (False, {"white": "torque errors", None: "cause"}, ["white", "coloured"], "white"),
        (False, {"white": "torque errors", "coloured": "cause"}, ["white", "coloured"], "coloured"),
        (False, {"coloured": "torque errors"}, ["white", "coloured"], "coloured"),
        (True, {None: "torque errors", "coloured": "changed"}, [None, "coloured"], None),
        (True, {None: "apart", "coloured": "changed"}, [None, "coloured"], "coloured"),
        (True, {None: "apart", "coloured": "torque errors"}, [None, "coloured"], None),
        (False, {None: "cause"}, ["white", "coloured", None], None),
        (False, {None: "curve"}, ["white", "coloured", None], None),
        (False, {}, ["white", "coloured", None], "white"),
    ],
)
def test_causes_are_sought_by_another_noise_where_one_names_nothing_and_leaves_more_than_noise(
    reached: bool,
    named: dict[TorqueErrors, str],
    tried: list[TorqueErrors],
    stands: TorqueErrors,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made, one, _ = question("stribeck")
    ended = dict[TorqueErrors, SearchResult]()

    def first_state(*_: object, torque_errors: TorqueErrors = None) -> SearchState:
        data = replace(one.data, noise_reached=reached, torque_errors=torque_errors)
        return replace(idle_then_stribeck()[0], data=data)

    def find_causes(state: SearchState, *_: object) -> SearchResult:
        by = state.data.torque_errors
        curve = fit_curves(one.first, one.data)[0] if named.get(by) == "curve" else None
        causes = one.causes if named.get(by) == "cause" else ()
        last = one.last if causes else one.first
        found = replace(one, data=state.data, last=last, causes=causes, curve=curve)
        if named.get(by) == "apart":
            found = replace(found, agreement=Agreement(apart=("check",)))
        if named.get(by) == "changed":
            found = replace(found, changes=(RecordChange("record_change.check.J", 1.0, "", 1.0, 1.0, 0.0, ()),))
        return ended.setdefault(by, found)

    monkeypatch.setattr(searching, "first_state", first_state)
    monkeypatch.setattr(searching, "settled_state", lambda *_: first_state(torque_errors="coloured"))
    monkeypatch.setattr(searching, "find_causes", find_causes)

    def seen(*words: str) -> Callable[[SearchResult], bool]:
        return lambda found: named.get(found.data.torque_errors) in words

    monkeypatch.setattr(searching, "leaves_only_noise", seen("noise", "torque errors", "apart", "changed"))
    monkeypatch.setattr(searching, "prevail", seen("torque errors", "apart", "changed"))
    assert searched(made, QUICK) is ended[stands]
    assert [*ended] == tried


@pytest.mark.parametrize(("record", "leading", "told"), [("slow", True, 1), ("slow", False, 0), ("check", True, 0)])
def test_where_all_passes_for_errors_of_the_torque_a_certain_event_is_told(
    monkeypatch: pytest.MonkeyPatch, record: str, *, leading: bool, told: int
) -> None:
    """It may be the lesser part of the misfit, but leads, and is on a record of the fit."""
    event, asked = replace(PUSH, record=record, std=0.001), list[dict[str, object]]()

    def lesser(*_: object, **by: object) -> SeenEvent | None:
        asked.append(by)
        once = len([one for one in asked if one]) == 1
        return SeenEvent(event, leading=leading) if by and once else None

    monkeypatch.setattr(searching, "largest_event", lesser)
    monkeypatch.setattr(searching, "_settled", lambda _, one, __: one)
    for name in ("leaves_only_noise", "prevail", "stands_out"):
        monkeypatch.setattr(searching, name, lambda *_: True)
    result = searched([with_event(one, PUSH) for one in records({})], QUICK)
    assert {"least_share": 0.1, "doubtful": False} in asked
    assert [one.record for one in result.events] == told * ["slow"]


def test_an_event_that_causes_explain_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """A moment at which the Stribeck effect shows, taken for a bump of torque."""
    creeping = Event("slow", "bump", False, 0.5, 0.7, 0.02, 0.0, 1e-6)
    seen = iter([SeenEvent(creeping, leading=True)])
    monkeypatch.setattr(searching, "largest_event", lambda *_: next(seen, None))
    monkeypatch.setattr(searching, "_settled", lambda *_: creeping)
    result = searched(records(STRIBECK), QUICK)
    assert result.events == ()
    assert [cause.effect for cause in result.causes] == ["motor.stribeck"]
    assert result.last.parameters["motor.stribeck.dFs"] == pytest.approx(0.15, rel=0.05)


def test_a_small_effect_that_leaves_noise_explains_all_that_was_missing() -> None:
    """Its energy is no more than chance makes of that of the noise: of the squared error it removes next to nothing."""
    made = records({"motor.stribeck.dFs": 0.012, "motor.stribeck.vs": 1.0})
    growth = searched(made, QUICK)
    d = told(made, growth)
    assert growth.shares_of_removed
    assert d.verdict == "named"
    assert [(cause.effect, cause.explained) for cause in d.causes] == [("motor.stribeck", 1.0)]
    assert d.remaining_share == 0.0
    assert {one.explained_after for one in d.records.values()} == {1.0}


def test_shares_are_of_what_causes_remove_where_only_simulations_explain_the_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The energy of such noise is another one than that of its linear model, by which shares would be measured."""
    made = records(STRIBECK)
    by_energy = searched(made, QUICK)
    monkeypatch.setattr(ColouredNoise, "linearly_explained", property(lambda _: False))
    growth = searched(made, QUICK)
    assert not by_energy.shares_of_removed
    assert growth.shares_of_removed
    assert [cause.explained for cause in growth.causes] == [1.0]
    d = told(made, growth)
    assert (d.verdict, d.remaining_share) == ("named", 0.0)


@pytest.mark.parametrize(
    "size",
    [
        pytest.param(0.05, id="lost in torque errors"),
        pytest.param(0.06, id="doubtful", marks=pytest.mark.slow),
        pytest.param(0.08, id="of lesser share", marks=pytest.mark.slow),
        pytest.param(0.2, id="of most", marks=pytest.mark.slow),
    ],
)
def test_an_event_beside_a_cause_is_told(size: float) -> None:
    """It is seen once the cause is there, and the noise of the sensors behind it; or beside the cause; or before it."""
    pushed = with_event(records(STRIBECK)[0], replace(PUSH, torque=size))
    result = searched([pushed, *records(STRIBECK)[1:]], QUICK)
    assert [(event.record, event.kind) for event in result.events] == [("slow", "bump")]
    assert result.events[0].torque == pytest.approx(size, rel=0.05)
    assert [cause.effect for cause in result.causes] == ["motor.stribeck"]


def test_a_cogging_keeps_its_phase_where_errors_of_the_torque_make_a_simulated_angle_drift() -> None:
    made = records_of(
        assemble(AXIS.extended("motor.cogging"), angle=True),
        TRUTH | {"motor.cogging.A": 0.15, "motor.cogging.B": 0.1, "motor.cogging.n": 9.0},
        seed=2,
        torque_noise=0.02,
    )
    growth = searched(made, QUICK)
    assert [cause.effect for cause in growth.causes] == ["motor.cogging"]
    assert growth.causes[0].explained > 0.99
    assert values(growth)["motor.cogging.n"] == pytest.approx(9.0, rel=0.002)
    assert growth.last.energy < 1.1 * growth.last.samples


def test_causes_that_explain_nothing_by_the_noise_they_leave_are_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the noise at first they may, and lead the model astray by what errors of the torque they leave."""
    monkeypatch.setattr(rounds, "explains_more", lambda *_: False)
    found = searched(records(STRIBECK), QUICK)
    assert found.causes == ()
    assert found.last is found.first
    assert found.rejected[0].why == rounds.NOTHING


@pytest.mark.parametrize(("share", "kept"), [(1.2, True), (2.0, False)])
def test_causes_that_explain_clearly_less_than_what_makes_no_sense_are_a_part_of_it(share: float, kept: bool) -> None:
    found = searched(records(STRIBECK), QUICK)
    assert [cause.effect for cause in found.causes] == ["motor.stribeck"]
    senseless = RejectedCause("motor.cogging", share, 1.0, "makes no sense", imitates=True)
    again = without_parts(replace(found, rejected=(senseless,)))
    assert bool(again.causes) is kept
    assert again.imitated is not kept
    why = f"only a part: motor.cogging, which makes no sense here, explains {100 * share:.0f} % of the misfit"
    assert kept or again.rejected[0].why == why
