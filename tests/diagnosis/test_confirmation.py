"""What a fit does not confirm is rejected, and all shares still make one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.diagnosed import FIT, NAMED, PAYLOAD, STRIBECK, estimate

from robotid.diagnosis.confirmation import (
    NOT_CONFIRMED,
    is_idle,
    uncertain,
    unconfirmed,
    unsized,
    with_limits,
    without_causes,
)
from robotid.diagnosis.results import Cause


def cause(gain: float) -> Cause:
    return replace(STRIBECK, heldout_gain=gain)


def idle(*causes: Cause) -> dict[str, str]:
    return {one.effect: NOT_CONFIRMED for one in causes}


def change(value: float) -> Cause:
    """The Stribeck friction of a record that was held out, and how it differs."""
    effect = "record_change.day2.motor.stribeck.dFs"
    return replace(PAYLOAD, effect=effect, parameters=(estimate(effect, value, "Nm"),), explained_of="day2")


@pytest.mark.parametrize(("gain", "idle"), [(0.001, True), (-0.2, True), (0.01, False), (float("nan"), False)])
def test_a_cause_is_confirmed_by_its_gain_where_there_is_one_to_measure(gain: float, idle: bool) -> None:
    assert is_idle(cause(gain)) == idle


def test_without_its_only_cause_a_large_misfit_is_unknown() -> None:
    one = cause(0.0)
    found = without_causes(replace(NAMED, causes=(one,), remaining_share=1.0 - one.explained), idle(one))
    assert (found.verdict, found.causes, found.remaining) == ("unknown", (), NAMED.misfit)
    assert found.remaining_share == pytest.approx(1.0)
    assert (found.rejected[0].effect, found.rejected[0].heldout_gain) == (one.effect, 0.0)
    assert "does not confirm" in found.rejected[0].why
    assert all(record.explained_after == pytest.approx(0.0) for record in found.records.values())


def test_without_its_only_cause_a_small_misfit_is_clean() -> None:
    one = cause(0.0)
    little = replace(NAMED, causes=(one,), misfit=0.019, events=(), shape=None)
    assert without_causes(little, idle(one)).verdict == "clean"
    assert without_causes(replace(little, events=NAMED.events), idle(one)).verdict == "named"
    assert without_causes(replace(little, shape=NAMED.curves[0]), idle(one)).verdict == "unknown"


def test_what_a_rejected_cause_explained_is_left() -> None:
    minor = replace(cause(0.0), effect="motor.cogging", explained=0.2)
    first = replace(STRIBECK, explained=0.7)
    found = without_causes(replace(NAMED, causes=(first, minor), remaining_share=0.1), idle(minor))
    assert found.causes == (first,)
    assert found.remaining_share + sum(one.explained for one in found.causes) == pytest.approx(1.0)
    assert NAMED.remaining < found.remaining < NAMED.misfit
    assert found.verdict == "named"


@pytest.mark.parametrize(("apart", "none"), [(0.05, False), (-0.15, False), (0.25, True), (-0.3, True)])
def test_a_cause_of_another_size_on_a_held_out_record_imitates_something(apart: float, none: bool) -> None:
    """0.2 Nm in every record but one."""
    first = replace(cause(4.0), explained=0.9)
    assert first.parameters[0].value == 0.2
    found = replace(NAMED, causes=(first, change(apart), PAYLOAD), remaining_share=0.1)
    why = unconfirmed(found)
    assert set(why) == ({first.effect, change(apart).effect, PAYLOAD.effect} if none else set())
    left = without_causes(found, why)
    assert left.verdict == ("unknown" if none else "named")
    assert left.remaining_share == pytest.approx(1.0 if none else 0.1)
    if none:
        assert "dFs of day2" in left.rejected[0].why


def test_a_cause_that_carries_over_only_beside_another_goes_with_it() -> None:
    other = replace(cause(0.0), effect="motor.cogging", explained=0.2)
    first = replace(cause(0.3), explained=0.7, beside=other.effect)
    found = replace(NAMED, causes=(first, other), remaining_share=0.1)
    left = without_causes(found, unconfirmed(found))
    assert left.causes == ()
    assert left.rejected[0].why == "carries over only beside motor.cogging, which is no cause"
    assert without_causes(found, {first.effect: "another reason"}).causes == (other,)


def test_what_rests_on_a_cause_goes_with_it() -> None:
    found = replace(NAMED, causes=(cause(0.0), change(0.05)), remaining_share=0.03)
    left = without_causes(found, unconfirmed(found))
    assert left.causes == ()
    assert left.remaining_share == pytest.approx(1.0)


@pytest.mark.parametrize(("deviation", "none"), [(0.05, False), (0.06, True), (0.3, True), (float("nan"), False)])
def test_a_cause_whose_size_no_fit_tells_is_none(deviation: float, none: bool) -> None:
    first, *others = cause(0.03).parameters
    one = replace(cause(0.03), parameters=(replace(first, std_robust=deviation), *others))
    assert first.value == 0.2
    assert set(unconfirmed(replace(NAMED, causes=(one, PAYLOAD)))) == ({one.effect} if none else set())
    assert not none or f"dFs = 0.2, known to {deviation:g}" in unconfirmed(replace(NAMED, causes=(one,)))[one.effect]


@pytest.mark.parametrize(("gain", "none"), [(1.0, True), (0.5, True), (1e-4, False)])
def test_a_gain_on_records_held_out_tells_of_a_cause_beside_its_size(gain: float, none: bool) -> None:
    """Neither knows of the other. Three deviations are asked for in any case."""
    first, *others = cause(0.03).parameters
    for deviation, too_large in ((0.06, none), (0.07, True)):
        parameters = (replace(first, std_robust=deviation), *others)
        one = replace(cause(0.03), parameters=parameters, gain_p_value=gain)
        assert bool(unsized(replace(NAMED, causes=(one,)))) is too_large


@pytest.mark.parametrize(("deviation", "gain"), [(0.06, 1.0), (0.07, 0.002)])
def test_the_limit_of_a_cause_that_goes_for_its_size_is_the_size_that_the_fit_would_tell(
    deviation: float, gain: float
) -> None:
    """The limits of a search are those of effects that it has not found."""
    gained = replace(cause(0.03), gain_p_value=gain)
    first, shape = gained.parameters
    covariance = np.diag([deviation**2, 0.01])
    fit = replace(FIT, parameters=(first, shape), covariance=covariance, covariance_robust=covariance)
    found = replace(NAMED, causes=(gained, PAYLOAD))
    assert set(unsized(found, fit)) == {"motor.stribeck"}
    known = with_limits(found, unsized(found, fit), fit)
    limit = {one.effect: one for one in known.limits}["motor.stribeck"]
    assert (limit.symbol, limit.unit) == ("dFs", "Nm")

    def of_size(size: float) -> Cause:
        return replace(gained, parameters=(replace(first, value=size), shape))

    assert "motor.stribeck" in unsized(replace(found, causes=(of_size(0.99 * limit.size), PAYLOAD)), fit)
    assert unsized(replace(found, causes=(of_size(1.01 * limit.size), PAYLOAD)), fit) == {}


def test_a_change_of_one_record_is_judged_without_any_limit() -> None:
    alone = replace(NAMED, causes=(PAYLOAD,), limits=())
    assert unconfirmed(alone) == {}


def test_errors_beside_a_rejected_cause_explain_nothing_of_what_it_did() -> None:
    one = cause(0.0)
    little = replace(NAMED, causes=(one,), misfit=0.019, events=(), shape=None, torque_errors=0.1)
    found = without_causes(little, idle(one))
    assert (found.verdict, found.torque_errors) == ("unknown", 0.0)
    quiet = without_causes(replace(little, misfit=0.5 * NAMED.noise_floor), idle(one))
    assert (quiet.verdict, quiet.torque_errors) == ("clean", 0.1)


def test_a_curve_beside_a_rejected_cause_stays_what_the_remarks_say() -> None:
    """Where nothing passed for errors of the torque, nothing is taken back of it."""
    one = cause(0.0)
    shaped = replace(NAMED, causes=(one,), shape=NAMED.curves[0], torque_errors=0.0)
    found = without_causes(shaped, idle(one))
    assert (found.verdict, found.remarks) == ("unknown", shaped.remarks)


@pytest.mark.parametrize(("correlation", "none"), [(0.0, True), (0.95, True), (-0.95, False)])
def test_amplitudes_that_only_their_sum_is_known_of_are_judged_together(correlation: float, none: bool) -> None:
    """A weight on a short way is a constant torque, and of its two parts the records tell the sum."""
    names = ("arm.gravity.G", "arm.gravity.H")
    both = tuple(replace(estimate(name, 0.2, "Nm"), std_robust=0.15) for name in names)
    one = replace(cause(1.0), effect="arm.gravity", parameters=both)
    covariance = 0.15**2 * np.array([[1.0, correlation], [correlation, 1.0]])
    fit = replace(FIT, parameters=both, covariance=covariance, covariance_robust=covariance)
    assert (uncertain(one, fit) is not None) == none


@pytest.mark.parametrize(
    ("deviation", "correlation", "none"), [(0.1, 0.98, False), (0.1, 0.5, True), (0.3, 0.999, True)]
)
def test_a_size_is_certain_in_its_shape_or_not_at_all(deviation: float, correlation: float, none: bool) -> None:
    """What warms up over a time that is longer than the record tells size and time only together; but where the size
    may be several times itself, nothing is known of it."""
    names = ("motor.thermal_friction.c", "motor.thermal_friction.T")
    size, time = estimate(names[0], 0.2, "1"), estimate(names[1], 20.0, "s")
    both = (replace(size, std_robust=deviation), replace(time, std_robust=10.0))
    one = replace(cause(1.0), effect="motor.thermal_friction", parameters=both)
    apart = correlation * deviation * 10.0
    covariance = np.array([[deviation**2, apart], [apart, 100.0]])
    fit = replace(FIT, parameters=both, covariance=covariance, covariance_robust=covariance)
    assert (uncertain(one, fit) is not None) == none


def test_a_size_that_is_certain_beside_its_shape_is_certain() -> None:
    """Of errors that are far from white, the shape held may tell less."""
    names = ("motor.stribeck.dFs", "motor.stribeck.vs")
    both = (
        replace(estimate(names[0], 0.01, "Nm"), std_robust=0.001),
        replace(estimate(names[1], 4.0, "rad/s"), std_robust=1.0),
    )
    one = replace(cause(1.0), parameters=both)
    plain = np.array([[1e-6, 0.9e-3], [0.9e-3, 1.0]])
    robust = np.array([[1e-6, -0.9e-3], [-0.9e-3, 9.0]])
    fit = replace(FIT, parameters=both, covariance=plain, covariance_robust=robust)
    assert uncertain(one, fit, 1e-4) is None
