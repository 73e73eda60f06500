"""A clock that jitters leaves the noise floor as it is: an axis whose torque lasts from stamp to stamp."""

from __future__ import annotations

import numpy as np
from support.paper_joint import multisine

from robotid.model.array import Array
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
