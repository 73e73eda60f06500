"""Every flaw is repaired, said and counted, or refused."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.errors import InputError
from robotid.model.array import Array
from robotid.signals.readers.table import Table
from robotid.signals.repair import RepairedSignals, repair
from robotid.signals.sampling import Findings, Policy, repeats_after, uninterrupted, usual_step

H = 0.01
N = 400
T = np.arange(N) * H


def signals() -> dict[str, Array]:
    return {"tau_m": np.cos(3 * T), "phi_m": np.sin(3 * T)}


def run(
    found: dict[str, Array],
    t: Array | None,
    policy: Policy | None = None,
    declared: float | None = None,
    turn: float = 2 * np.pi,
) -> RepairedSignals:
    n = len(next(iter(found.values())))
    table = Table("a.csv", {}, lines=np.arange(n) + 2.0)
    return repair(Findings(table, policy or Policy(), np.arange(n)), found, t, declared, {"phi_m": (turn,)})


def without(rows: list[int]) -> tuple[dict[str, Array], Array]:
    return {name: np.delete(values, rows) for name, values in signals().items()}, np.delete(T, rows)


def test_a_clean_record_stays_as_it_is() -> None:
    repaired = run(signals(), T)
    assert repaired.remarks == ()
    assert (
        repaired.grid.sampling_time,
        repaired.grid.missing,
        repaired.duplicated,
        repaired.not_finite,
        repaired.wraps,
    ) == (
        H,
        0,
        0,
        0,
        0,
    )
    assert repaired.grid.jitter < 1e-9
    for name, values in signals().items():
        np.testing.assert_array_equal(repaired.signals[name], values)


def test_without_a_time_column() -> None:
    assert run(signals(), None, declared=0.004).grid.sampling_time == 0.004


def test_a_short_gap_is_filled() -> None:
    repaired = run(*without([100, 101, 250]))
    assert repaired.grid.missing == 3
    assert repaired.remarks == ("3 samples are missing and interpolated, the first before a.csv:102",)
    np.testing.assert_allclose(repaired.signals["phi_m"], np.sin(3 * T), atol=2e-3)


@pytest.mark.parametrize(
    ("rows", "repaired"),
    [
        ([100, 101, 102], True),
        ([100, 101, 102, 103], False),
        ([50, 110, 170, 230], True),  # one in a hundred
        ([50, 110, 170, 230, 290], False),
    ],
)
def test_three_in_a_row_and_one_in_a_hundred_are_mended(rows: list[int], repaired: bool) -> None:
    if repaired:
        assert run(*without(rows)).grid.missing == len(rows)
    else:
        with pytest.raises(InputError, match=f"{len(rows)} samples are missing"):
            run(*without(rows))


def test_many_short_gaps_are_refused_unless_asked_for() -> None:
    found, t = without(list(range(50, 350, 20)))
    with pytest.raises(InputError, match="15 samples are missing, 1 of them before this one"):
        run(found, t)
    assert run(found, t, Policy(gaps="interpolate")).grid.missing == 15


def test_samples_that_were_not_numbers() -> None:
    found = signals()
    found["tau_m"][[5, 6]] = np.nan
    found["tau_m"][90] = np.inf
    repaired = run(found, T)
    assert repaired.not_finite == 3
    assert repaired.remarks == ("tau_m: 3 samples that were not numbers are interpolated, the first at a.csv:7",)
    np.testing.assert_allclose(repaired.signals["tau_m"], np.cos(3 * T), atol=2e-3)


def test_a_time_that_was_not_a_number() -> None:
    t = T.copy()
    t[7] = np.nan
    assert run(signals(), t).remarks == ("t: 1 sample that was not a number is interpolated, the first at a.csv:9",)


def test_duplicates_are_dropped() -> None:
    found = {name: np.insert(values, 42, values[42]) for name, values in signals().items()}
    repaired = run(found, np.insert(T, 42, T[42]))
    assert repaired.duplicated == 1
    assert repaired.remarks == ("1 duplicated sample is dropped, the first at a.csv:45",)
    np.testing.assert_array_equal(repaired.signals["phi_m"], np.sin(3 * T))


@pytest.mark.parametrize("turn", [2 * np.pi, 360.0])
def test_wrap_arounds_are_unwrapped(turn: float) -> None:
    angle = turn * (0.3 + 2.5 * np.sin(T))
    repaired = run({"phi_m": (angle + turn / 2) % turn - turn / 2}, T, turn=turn)
    assert repaired.wraps > 3
    np.testing.assert_allclose(np.diff(repaired.signals["phi_m"]), np.diff(angle), atol=1e-9 * turn)


def test_a_gap_at_a_wrap_around_is_bridged_on_the_way_that_the_motor_went() -> None:
    angle = 4 * T
    wrapped = angle % (2 * np.pi)
    k = int(np.argmax(np.diff(wrapped) < 0))
    wrapped[k] = np.nan
    repaired = run({"phi_m": np.delete(wrapped, k + 1)}, np.delete(T, k + 1))
    np.testing.assert_allclose(repaired.signals["phi_m"], angle, atol=1e-9)


def test_a_dropout_is_no_wrap_around() -> None:
    """An encoder that reads zero once jumps by most of a turn, but not from edge to edge."""
    angle = 5.5 + 0.1 * np.sin(3 * T)
    angle[77] = 0.0
    assert run({"phi_m": angle}, T).wraps == 0


def test_a_turn_that_is_too_fast_to_follow() -> None:
    with pytest.raises(InputError, match="phi_m turns too far between samples to be unwrapped"):
        run({"phi_m": 2.9 * np.arange(N) % (2 * np.pi)}, T)


def test_jitter_is_measured() -> None:
    rng = np.random.default_rng(1)
    repaired = run(signals(), T + 0.05 * H * rng.uniform(-1, 1, N))
    assert 0.02 < repaired.grid.jitter_rms < repaired.grid.jitter < 0.1
    assert repaired.grid.sampling_time == pytest.approx(H, rel=1e-3)


def test_time_with_too_few_digits_is_told() -> None:
    with pytest.raises(
        InputError, match=r"time is written with too few digits; write t: null .* sampling_time instead"
    ):
        run(signals(), np.round(T / 10, 2))


@pytest.mark.parametrize(("h", "n"), [(1e-3, 25000), (0.0005, 100), (1 / 3000, 5000), (0.004, 2501)])
def test_usual_step(h: float, n: int) -> None:
    t = 1e3 + np.arange(n) * h
    assert usual_step(t) == pytest.approx(h, abs=0.5 * h / n)
    assert usual_step(np.delete(t, [20, 21])) == pytest.approx(h, abs=0.5 * h / n)


def test_round_steps_are_exact() -> None:
    assert usual_step(np.arange(20000) * 0.001 + 0.25e-9) == 0.001


def test_jitter_is_removed_by_resampling_on_the_stamps() -> None:
    t = T + 0.1 * H * np.random.default_rng(1).uniform(-1, 1, N)
    repaired = run({"tau_m": np.cos(3 * t), "phi_m": np.sin(3 * t)}, t)
    assert repaired.grid.resampled
    k = np.arange(len(repaired.signals["phi_m"]))
    phase = np.arcsin(repaired.signals["phi_m"][0]) / 3
    np.testing.assert_allclose(
        repaired.signals["phi_m"], np.sin(3 * (phase + k * repaired.grid.sampling_time)), atol=3e-6
    )


def test_a_torque_does_not_last_over_the_samples_that_a_jittering_clock_has_lost() -> None:
    """Two in a row at full slope: lasting, it would be off by the change of an interval and a half."""
    t = T + 0.1 * H * np.random.default_rng(1).uniform(-1, 1, N)
    lost = [79, 80, 210, 211]
    whole, gaps = (
        run({"tau_m": np.cos(3 * kept), "phi_m": np.sin(3 * kept)}, kept) for kept in (t, np.delete(t, lost))
    )
    assert gaps.grid.resampled
    assert gaps.grid.missing == len(lost)
    assert len(gaps.signals["tau_m"]) == len(whole.signals["tau_m"])
    error = np.abs(gaps.signals["tau_m"] - whole.signals["tau_m"])
    assert error.max() < 0.1 * 3 * H
    assert gaps.torque_steps is not None
    assert whole.torque_steps is not None
    assert np.abs(gaps.torque_steps.step).max() < 1.5 * np.abs(whole.torque_steps.step).max()


def test_stamps_that_are_only_rounded_are_not_resampled_on() -> None:
    """A third of a millisecond written with four digits is off by up to 15 % of the step."""
    t = np.arange(N) / 3000
    repaired = run({"tau_m": np.cos(3 * t), "phi_m": np.sin(3 * t)}, np.round(t, 4))
    assert not repaired.grid.resampled
    np.testing.assert_array_equal(repaired.signals["phi_m"], np.sin(3 * t))


def test_stamps_of_a_logger_that_writes_late_are_not_resampled_on() -> None:
    late = np.random.default_rng(1).uniform(0, 0.2 * H, N)
    repaired = run(signals(), T + late)
    assert not repaired.grid.resampled
    np.testing.assert_array_equal(repaired.signals["phi_m"], np.sin(3 * T))


def test_intervals_that_are_no_multiples_of_one_miss_no_samples() -> None:
    t = np.cumsum(H * np.random.default_rng(2).uniform(0.3, 1.7, N))
    repaired = run({"phi_m": np.sin(3 * t), "tau_m": np.cos(3 * t)}, t)
    assert repaired.grid.resampled
    assert repaired.grid.missing == 0
    assert repaired.remarks == ()
    assert repaired.torque_steps is not None
    assert len(repaired.torque_steps.step) == len(repaired.signals["phi_m"])
    with pytest.raises(InputError, match="samples are missing"):
        run({"phi_m": np.sin(3 * t)}, t, Policy(gaps="refuse"))


@pytest.mark.parametrize(
    ("intervals", "repeat"),
    [
        ((0.5, 1.5), 2),
        ((0.7, 1.3), 2),
        ((0.2, 0.2, 0.2, 0.2, 4.2), 5),
        ((0.1,) * 19 + (18.1,), 20),
        ((1.0, 1.0), 0),
        ((1.0, 2.0), 0),  # two of three samples of a clock
        ((1.0,) * 9 + (2.0,), 0),  # nine of ten
    ],
)
def test_intervals_that_come_in_a_pattern(intervals: tuple[float, ...], repeat: int) -> None:
    """A clock that loses every third sample is none, whatever the pattern: the torque of these samples is not known."""
    steps = H * np.tile(intervals, N // len(intervals))
    jittered = steps * (1.0 + 0.02 * np.random.default_rng(3).uniform(-1, 1, len(steps)))
    assert repeats_after(steps) == repeats_after(jittered) == repeat
    if repeat:
        assert usual_step(np.concatenate([[0.0], np.cumsum(steps)])) == pytest.approx(H * np.mean(intervals), rel=1e-9)


@pytest.mark.parametrize("intervals", [(0.5, 1.5), (0.2, 0.2, 0.2, 0.2, 4.2), (0.1,) * 9 + (9.1,)])
def test_groups_of_samples_miss_none(intervals: tuple[float, ...]) -> None:
    """Where they were taken so, the signals are those of their stamps; where only the stamps come so, they stay."""
    t = np.concatenate([[0.0], np.cumsum(H * np.tile(intervals, N // len(intervals)))])[:N]
    taken = run({"tau_m": np.cos(3 * t), "phi_m": np.sin(3 * t)}, t)
    assert taken.grid.resampled
    assert taken.grid.missing == 0
    assert taken.grid.sampling_time == pytest.approx(H)
    assert any("the sampling intervals repeat" in remark for remark in taken.remarks)
    regular = np.arange(len(taken.signals["phi_m"])) * H + np.arcsin(taken.signals["phi_m"][0]) / 3
    np.testing.assert_allclose(taken.signals["phi_m"], np.sin(3 * regular), atol=2e-5)
    stamped = run(signals(), t)
    assert not stamped.grid.resampled
    np.testing.assert_array_equal(stamped.signals["phi_m"], np.sin(3 * T))


def test_a_gap_between_bursts_cuts_and_the_pauses_do_not() -> None:
    t = np.cumsum(H * np.tile((0.1,) * 9 + (9.1,), 40))
    table = Table("a.csv", {})
    whole = Findings(table, Policy(), np.arange(len(t)))
    assert uninterrupted(whole, t) == ((0, 400),)
    t[200:] += 30 * H
    assert uninterrupted(whole, t) == ((0, 200), (200, 400))


def test_a_regular_clock_has_no_steps_within_its_intervals() -> None:
    assert run(signals(), T).torque_steps is None


def test_most_samples_missing() -> None:
    kept = np.flatnonzero(np.arange(N) % 9 < 3)
    with pytest.raises(InputError, match="264 of 399 samples are missing between the others"):
        run({name: values[kept] for name, values in signals().items()}, T[kept], Policy(gaps="interpolate"))
