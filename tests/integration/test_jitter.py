"""A clock that jitters leaves the noise floor as it is: axes whose torque lasts from stamp to stamp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from support.dry_axis import DryAxis, switched_torque
from support.paper_joint import multisine

from robotid.catalogue import assemble
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.measured import Selection, measured_records
from robotid.signals.readers.table import Table

H, NOISE, INERTIA, FRICTION = 2e-3, 0.084, 0.0121, 0.5


def axis(t: Array) -> dict[str, Array]:
    """The log of an inertia with viscous friction, integrated exactly from stamp to stamp, with noise on the speed."""
    k = np.arange(len(t))
    torque = 32 * multisine(k * H, 1.0) + 16 * np.sign(np.sin(2 * np.pi * 3 * k * H))
    decay = np.exp(-FRICTION / INERTIA * np.diff(t))
    speed = np.zeros(len(t))
    for i, share in enumerate(decay):
        speed[i + 1] = share * speed[i] + (1 - share) * torque[i] / FRICTION
    steady = torque[:-1] / FRICTION
    angle = np.cumsum(steady * np.diff(t) + (speed[:-1] - steady) * (1 - decay) * INERTIA / FRICTION)
    noise = NOISE * np.random.default_rng(2).standard_normal(len(t))
    return {"t": t, "tau_m": torque, "phi_m": np.concatenate([[0.0], angle]), "dphi_m": speed + noise}


def residual(log: dict[str, Array], **settings: float) -> float:
    """What the truth, simulated on the record, leaves of its speed [rad/s]."""
    ((record, _),) = measured_records(Selection("a", **settings), Table("a.csv", log))
    share = np.exp(-FRICTION / INERTIA * record.sampling_time)
    speed = np.zeros(len(record))
    for i in range(len(record) - 1):
        speed[i + 1] = share * speed[i] + (1 - share) * record.tau_m[i] / FRICTION
    return float(np.std((record.dphi_m - speed)[200:]))


def test_jitter_of_a_tenth_of_the_interval_leaves_the_noise_as_it_is() -> None:
    regular = np.arange(2000) * H
    jittered = regular + 2e-4 * np.random.default_rng(1).uniform(-1, 1, len(regular))
    log = axis(jittered)
    assert residual(axis(regular)) < 1.03 * NOISE
    assert residual(log) < 1.1 * NOISE
    assert residual({name: values for name, values in log.items() if name != "t"}, sampling_time=H) > 1.5 * NOISE


@pytest.mark.parametrize(("share", "speed"), [(0.12, True), (0.12, False), (0.3, True)])
def test_dry_friction_reverses_where_it_did_between_the_stamps(share: float, speed: bool) -> None:
    """A fit of a record with large steps of the torque leaves its noise; with the torque's mean over regular steps
    it would leave three times as much and more. Stamps that are off by up to 30 % leave half as much again."""
    h, noise, n, axis = 0.01, 0.002, 1000, DryAxis()
    rng = np.random.default_rng(2)
    stamps = np.sort(np.arange(n) * h + share * h * rng.uniform(-1, 1, n))
    stamps -= stamps[0]
    torque = switched_torque(np.arange(n) * h)
    true, angle = axis.motion(stamps, torque, stamps)
    measured = {"dphi_m": true + noise * rng.standard_normal(n)} if speed else {}
    table = Table("a.csv", {"t": stamps, "tau_m": torque, "phi_m": angle, **measured})
    ((record, report),) = measured_records(Selection("a"), table)
    assert any("ignored, the jitter would be an error of" in remark for remark in report.remarks)
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")), angle=not speed)
    start = joint.parameters().with_values(
        {"motor.inertia.J": 0.02, "motor.viscous.Fv": axis.Fv, "motor.coulomb.Fc": axis.Fc}
    )
    fit, by_means = (
        fit_model("m", joint, start, [one], FitOptions()) for one in (record, replace(record, torque_steps=None))
    )
    assert fit.noise_std["a"] < (1.2 if share < 0.2 else 1.5) * noise
    assert by_means.noise_std["a"] > 2.5 * fit.noise_std["a"]
    assert fit["motor.coulomb.Fc"].value == pytest.approx(axis.Fc, rel=3e-4)


def late_torque(stamps: Array, torque: Array, late: float) -> tuple[Array, Array]:
    """A torque that acts late, from its times on."""
    return np.concatenate([[0.0], stamps + late]), np.append(torque[0], torque)


def lagging_torque(stamps: Array, torque: Array, lag: float) -> tuple[Array, Array]:
    """A torque that builds up, in steps of a 64th of an interval, from their times on."""
    at = np.union1d(stamps, np.arange(0.0, stamps[-1], 0.01 / 64))
    aim, u, lasting = torque[np.searchsorted(stamps, at, side="right") - 1], np.empty(len(at)), torque[0]
    for k, step in enumerate(np.diff(at, append=at[-1] + 0.01 / 64)):
        rest = np.exp(-step / lag)
        u[k] = aim[k] + (lasting - aim[k]) * (1.0 - rest) * lag / step
        lasting = aim[k] + (lasting - aim[k]) * rest
    return at, u


@pytest.mark.parametrize(("share", "most"), [(0.0, 1.1), (0.12, 1.7)])
@pytest.mark.parametrize(
    ("channel", "parameter", "truth", "course"),
    [("torque_delay", "Td", 7.3e-3, late_torque), ("torque_lag", "T", 12.3e-3, lagging_torque)],
)
def test_a_torque_that_acts_late_reverses_dry_friction_where_it_did(
    channel: str,
    parameter: str,
    truth: float,
    course: Callable[[Array, Array, float], tuple[Array, Array]],
    share: float,
    most: float,
) -> None:
    """The mean torque of each step alone would leave eight to twenty times the noise, on a regular clock, too."""
    h, noise, n, axis = 0.01, 0.002, 1000, DryAxis()
    rng = np.random.default_rng(2)
    stamps = np.sort(np.arange(n) * h + share * h * rng.uniform(-1, 1, n))
    stamps -= stamps[0]
    torque = switched_torque(np.arange(n) * h)
    true, angle = axis.motion(*course(stamps, torque, truth), stamps)
    log = {"t": stamps, "tau_m": torque, "phi_m": angle, "dphi_m": true + noise * rng.standard_normal(n)}
    ((record, _),) = measured_records(Selection("a"), Table("a.csv", log))
    effects = ("motor.inertia", "motor.viscous", "motor.coulomb")
    joint, name = assemble(Structure(effects, channels=(f"torque.{channel}",))), f"torque.{channel}.{parameter}"
    start = {"motor.inertia.J": 0.02, "motor.viscous.Fv": axis.Fv, "motor.coulomb.Fc": axis.Fc, name: 0.5 * truth}
    fit = fit_model("m", joint, joint.parameters().with_values(start), [record], FitOptions())
    assert fit.noise_std["a"] < most * noise
    assert fit[name].value == pytest.approx(truth, rel=1e-3)
    assert fit["motor.coulomb.Fc"].value == pytest.approx(axis.Fc, rel=3e-4)


@pytest.mark.parametrize(("pattern", "most"), [((0.5, 1.5), 1.4), ((0.2, 0.2, 0.2, 0.2, 4.2), 10.0)])
def test_samples_in_groups_give_the_parameters(pattern: tuple[float, ...], most: float) -> None:
    """Intervals of 1 and 3 ms in turn leave little more than the noise. In the pauses between bursts the motion is
    interpolated, which costs accuracy and no truth."""
    h, noise, n, axis = 2e-3, 0.002, 2000, DryAxis()
    stamps = np.concatenate([[0.0], np.cumsum(h * np.tile(pattern, n // len(pattern)))])[:n]
    torque = switched_torque(stamps)
    true, angle = axis.motion(stamps, torque, stamps)
    speed = true + noise * np.random.default_rng(2).standard_normal(n)
    table = Table("a.csv", {"t": stamps, "tau_m": torque, "phi_m": angle, "dphi_m": speed})
    ((record, report),) = measured_records(Selection("a"), table)
    assert record.sampling_time == pytest.approx(h, rel=1e-9)
    assert any(f"the sampling intervals repeat after {len(pattern)}" in remark for remark in report.remarks)
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
    start = {"motor.inertia.J": 0.02, "motor.viscous.Fv": axis.Fv, "motor.coulomb.Fc": axis.Fc}
    fit = fit_model("m", joint, joint.parameters().with_values(start), [record], FitOptions())
    assert fit.noise_std["a"] < most * noise
    for p, value in zip(fit.parameters, (axis.J, axis.Fv, axis.Fc), strict=True):
        assert abs(p.value - value) < 4 * p.std_robust
        assert p.value == pytest.approx(value, rel=2e-3)
