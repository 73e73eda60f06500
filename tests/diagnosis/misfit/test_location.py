"""What orders a missing torque is found, and how it runs along it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.hidden_records import SPEED_NOISE, TORQUE_NOISE, Hidden, hidden

from robotid.diagnosis.misfit.curve import Curve
from robotid.diagnosis.misfit.location import locate
from robotid.diagnosis.misfit.missing_torque import MissingTorque, missing_torque
from robotid.model.array import Array

Law = Callable[[Array, Array, Array], Array]
COGGING = {"A": 0.05, "B": 0.02, "n": 6.0}


def case(found: Hidden) -> MissingTorque:
    [segment] = found.simulated.segments("speed")
    return missing_torque(segment, "speed", SPEED_NOISE, TORQUE_NOISE)


def told(one: MissingTorque, torque: Array) -> MissingTorque:
    """The same motion as if this torque were missing."""
    return replace(one, torque=torque)


def speed_of(one: MissingTorque) -> Array:
    return np.asarray(one.x[one.segment.trajectory.joint.motor_speed])


@pytest.fixture(scope="module")
def clean() -> tuple[MissingTorque, ...]:
    return tuple(case(hidden("constant_torque", {"tau0": 0.0}, number=number)) for number in (1, 2))


def named(curves: tuple[Curve, ...], along: str) -> Curve:
    return next(curve for curve in curves if curve.along == along)


@pytest.mark.parametrize(
    ("effect", "values", "along", "least"),
    [
        ("stribeck", {"dFs": 0.15, "vs": 2.0}, "dphi_m", 0.5),
        ("quadratic_friction", {"Fq": 2e-4}, "dphi_m", 0.9),
        ("cogging", COGGING, "phi_m mod 2 pi", 0.7),
        ("position_friction", {"A": 0.05, "B": 0.02, "n": 1.0}, "phi_m mod 2 pi, by direction", 0.8),
    ],
)
def test_what_orders_it_comes_first_with_the_true_curve(
    effect: str, values: dict[str, float], along: str, least: float
) -> None:
    found = [hidden(effect, values, number=number) for number in (1, 2)]
    cases = [case(one) for one in found]
    best = locate(cases)[0]
    assert best.along == along
    assert best.order > least
    true = locate([told(one, hid.missing) for one, hid in zip(cases, found, strict=True)])
    assert np.corrcoef(best.missing_torque, named(true, along).missing_torque)[0, 1] > 0.97


def test_noise_has_no_order(clean: tuple[MissingTorque, ...]) -> None:
    noise = [told(one, np.random.default_rng(k).standard_normal(6000)) for k, one in enumerate(clean)]
    assert max(curve.order for curve in locate(noise)) < 0.01


def test_correlation_in_time_alone_orders_little(clean: tuple[MissingTorque, ...]) -> None:
    walk = [told(one, np.cumsum(np.random.default_rng(k).standard_normal(6000))) for k, one in enumerate(clean)]
    curves = locate(walk)
    assert max(named(curves, along).order for along in ("dphi_m", "phi_m mod 2 pi", "twist", "reversal")) < 0.1


@pytest.mark.parametrize(
    ("along", "law"),
    [
        ("phi_a, by speed", lambda v, phi, t: -1e-3 * v * phi),
        ("t, by direction", lambda v, phi, t: -0.1 * np.exp(-t / 2) * np.sign(v)),
        ("phi_a", lambda v, phi, t: 0.1 * np.sin(phi / 20)),
    ],
)
def test_torques_that_turn_with_the_motion_are_ordered_too(
    clean: tuple[MissingTorque, ...], along: str, law: Law
) -> None:
    hidden_in = [told(one, law(speed_of(one), one.segment.record.phi_m, one.segment.record.t)) for one in clean]
    best = locate(hidden_in)[0]
    assert best.along == along
    assert best.order > 0.9


def test_a_difference_between_records_shows_along_the_records(clean: tuple[MissingTorque, ...]) -> None:
    curve = named(locate([told(one, np.full(6000, 0.1 * k)) for k, one in enumerate(clean)]), "record")
    assert curve.missing_torque == pytest.approx([0.0, 0.1])
    assert curve.order == pytest.approx(1.0)


def test_what_follows_the_speed_alone_is_no_merit_of_what_it_is_counted_along(clean: tuple[MissingTorque, ...]) -> None:
    curves = locate([told(one, -1e-3 * speed_of(one)) for one in clean])
    assert curves[0].along == "dphi_m"
    assert curves[0].order > 0.95
    assert max(curve.order for curve in curves if curve.along.endswith(("by speed", "by direction"))) < 0.7
    assert named(curves, "record, by speed").order < 0.01


def test_no_bin_of_a_speed_crosses_zero(clean: tuple[MissingTorque, ...]) -> None:
    fast = [told(one, np.sign(speed_of(one))) for one in clean]
    curve = named(locate(fast), "dphi_m")
    assert np.abs(curve.missing_torque) == pytest.approx(np.ones(len(curve.x)))
    assert np.all(np.sign(curve.x) == curve.missing_torque)
    assert 20 <= len(curve.x) <= 40


def test_every_moving_sample_is_counted_once(clean: tuple[MissingTorque, ...]) -> None:
    curves = [c for c in locate(clean) if not c.along.startswith(("reversal", "frequency"))]
    assert len({float(curve.count.sum()) for curve in curves}) == 1
    assert all(np.isfinite(np.concatenate([c.x, c.missing_torque, c.spread, [c.order]])).all() for c in curves)


def test_what_does_not_vary_has_no_curve(clean: tuple[MissingTorque, ...]) -> None:
    missing = clean[0]
    trajectory = missing.segment.trajectory
    x = missing.x.copy()
    x[trajectory.joint.motor_speed] = np.linspace(5.0, 9.0, 6000)
    onward = {curve.along for curve in locate([replace(missing, x=x)])}
    assert not {"reversal", "record"} & onward
    at_rest = locate([replace(missing, x=0 * x)])
    assert {curve.along for curve in at_rest} == {"frequency"}


def test_frequencies_carry_the_whole_of_it(clean: tuple[MissingTorque, ...]) -> None:
    one = clean[0]
    wave = told(one, 0.2 * np.sin(2 * np.pi * 10 * one.segment.record.t))
    curve = named(locate([wave]), "frequency")
    assert np.sqrt(np.sum(curve.missing_torque**2)) == pytest.approx(0.2 / np.sqrt(2), rel=1e-3)
    assert curve.x[np.argmax(curve.missing_torque)] == pytest.approx(10, rel=0.3)
