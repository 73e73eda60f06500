"""What other axes make of a torque is taken out of it, and what is left must be that of the axis' own motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.mistaken_logs import H, N, right_log

from robotid.model.array import Array
from robotid.model.companion import CompanionKind
from robotid.signals.companion import Companion
from robotid.signals.plausibility import Axis, check_records
from robotid.signals.plausibility.evidence import Evidence
from robotid.signals.plausibility.relation import Relation
from robotid.signals.plausibility.settings import CHECK
from robotid.signals.quality import Recordings, inspect
from robotid.signals.record import Record

T = np.arange(N) * H
SIZE = 40.0  # times the axis' own torque


def other_angle(seed: int = 7) -> Array:
    """The angle of another axis [rad], up to 8 Hz, (n,)."""
    rng, lines = np.random.default_rng(seed), np.arange(1, 49)
    waves = np.sin(2 * np.pi * np.outer(T / (N * H), lines) + rng.uniform(0, 2 * np.pi, len(lines))) / lines
    return np.asarray(0.6 + 0.5 * waves.sum(axis=1))


def beside(own: float, torque: Array, w: Array, kind: CompanionKind = CompanionKind.ANGLE) -> Record:
    """The rigid axis with `own` times its torque, and a torque (n,) of what the companion w (n,) measures."""
    log = right_log("rigid")
    scale = SIZE * float(np.std(log["tau_m"]) / np.std(torque))
    record = Record.from_arrays(own * log["tau_m"] + scale * torque, log["phi_m"], H, speed=log["dphi_m"], name="log")
    return replace(record, companions={"q2": Companion.of(kind, w, H)})


def coupled() -> Array:
    """What another axis does to this one: inertia that both move, what centrifuges, and weight, (n,)."""
    w = other_angle()
    rate, change = np.gradient(w, H), np.gradient(np.gradient(w, H), H)
    wave, slope = 0.7 * np.cos(w) + 0.4 * np.sin(w), 0.4 * np.cos(w) - 0.7 * np.sin(w)
    return np.asarray((1.0 + wave) * change + slope * rate**2 + 30.0 * np.sin(w))


def noise() -> Array:
    return np.random.default_rng(5).standard_normal(N)


def fatal(record: Record) -> list[str]:
    return [f.name for f in check_records(Recordings((record,), (inspect(record, "log"),)), Axis()).fatal]


def test_a_torque_that_another_axis_makes_most_of_is_related_to_the_motion() -> None:
    record = beside(1.0, coupled(), other_angle())
    assert fatal(record) == []
    found = Evidence(record, inspect(record, "log"), Axis()).regression
    assert found.left < 3.0 / SIZE**2
    assert found.relation.explained > 0.9
    assert found.inertia.value == pytest.approx(0.012, rel=0.05)


def test_it_is_not_where_the_other_axis_is_not_recorded() -> None:
    assert fatal(replace(beside(1.0, coupled(), other_angle()), companions={})) == ["torque_unrelated"]


def test_a_torque_that_is_recorded_counts_as_well() -> None:
    pushes = np.cumsum(noise())
    assert fatal(beside(1.0, pushes, pushes, CompanionKind.TORQUE)) == []


def test_the_torque_of_the_other_axis_is_unrelated() -> None:
    assert fatal(beside(0.0, coupled() + 3.0 * noise(), other_angle())) == ["torque_unrelated"]


def test_a_torque_that_neither_axis_makes_is_unrelated() -> None:
    assert fatal(beside(1.0, np.cumsum(noise()), other_angle())) == ["torque_unrelated"]


def test_the_wrong_sign_is_found_under_the_torque_of_another_axis() -> None:
    assert fatal(beside(-1.0, coupled(), other_angle())) == ["torque_sign"]


def test_an_axis_that_moves_alike_is_left_out() -> None:
    log = right_log("rigid")
    record = Record.from_arrays(log["tau_m"], log["phi_m"], H, speed=log["dphi_m"], name="log")
    alike = replace(record, companions={"q2": Companion.of(CompanionKind.ANGLE, 0.01 * log["phi_m"], H)})
    found, plain = (Evidence(one, inspect(one, "log"), Axis()).regression for one in (alike, record))
    assert found.left == plain.left == 1.0
    assert (found.relation.explained, found.inertia) == (plain.relation.explained, plain.inertia)


def test_shares_are_compared_by_what_they_leave() -> None:
    assert Relation(0.99, 0.9, True).above_chance == pytest.approx(11.0)
    assert Relation(0.02, 0.01, True).above_chance == pytest.approx(2.0, rel=0.02)
    assert Relation(0.99, 0.9, True).above_chance > Relation(0.5, 0.37, True).above_chance


def test_the_rest_that_companions_leave_does_not_turn_the_sign_of_a_torque(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a heavy axis dozens of columns of other axes take nearly all, and the rest may be their errors."""
    record, log = beside(-1.0, coupled(), other_angle()), right_log("rigid")
    right = Record.from_arrays(log["tau_m"], log["phi_m"], H, speed=log["dphi_m"], name="log")
    whole = Evidence(right, inspect(right, "log"), Axis()).regression
    assert whole.inertia.ratio > 10.0
    monkeypatch.setattr(Evidence, "regression_alone", whole)
    assert fatal(record) == []


def test_companions_that_have_more_columns_than_a_slow_torque_has_samples_are_no_evidence() -> None:
    t = np.arange(2500) * 0.004
    phi = 60.0 * np.sin(0.7 * t) + 20.0 * np.sin(1.9 * t + 1.0)
    v, a = np.gradient(phi, t), np.gradient(np.gradient(phi, t), t)
    rng = np.random.default_rng(2)
    unrelated = 6.0 * np.sin(np.outer([0.9, 1.3, 2.3, 2.9], t)).sum(axis=0)  # one would be taken for a resonance
    record = Record.from_arrays(0.02 * a + 0.01 * v + 0.3 * np.sign(v) + unrelated, phi, 0.004, name="log")
    slow = [0.3 * np.sin(rng.uniform(0.5, 3.0) * t + rng.uniform(0.0, 6.0)) for _ in range(5)]
    crowded = replace(
        record, companions={f"q{k}": Companion.of(CompanionKind.ANGLE, w, 0.004) for k, w in enumerate(slow)}
    )
    alone = Evidence(record, inspect(record, "log"), Axis(0.01)).regression
    found = Evidence(crowded, inspect(crowded, "log"), Axis(0.01)).regression
    assert alone.relation.above_chance < CHECK.lone_chance, "so that companions are asked"
    assert found.left == 1.0
    assert found.relation.explained == alone.relation.explained
