"""The true shape of an unknown torque, to compare with the shape that the tool reports."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from support.followed_curve import correlation_beyond, followed, imitable

from study.plant.catalogue import UNKNOWN
from study.plant.experiment import Array, Recording
from study.plant.rig import RATIO
from study.trials.case import Hidden
from robotid.diagnosis.misfit.curve import Curve


def correlation(curve: Curve, hidden: Hidden, records: Mapping[str, Recording]) -> float:
    """Of the torque that the reported curve makes of the true motion with the true torque; nan along what is no
    variable of the motion.

    records : those of the fit. What a base model can imitate of either torque (a part along acceleration, speed,
    direction of motion, and a constant) does not count: the fit may have taken it. The tool signs torques as applied,
    the plant as absorbed.
    """
    name = curve.along.partition(", ")[0]
    if len(curve.x) < 3 or any(name not in _variables(r) for r in records.values()):
        return float("nan")
    speeds = [_speed(r) for r in records.values()]
    known = [imitable(v, r.sampling_time) for v, r in zip(speeds, records.values(), strict=True)]
    told = [followed(curve, _variables(r)[name], v) for v, r in zip(speeds, records.values(), strict=True)]
    true = [-_torque(hidden, r) for r in records.values()]
    return correlation_beyond(*map(np.concatenate, (told, true, known)))


def _speed(recording: Recording) -> Array:
    """True motor speed, (n,)."""
    return np.array([y.dphi_m for y in recording.states])


def _torque(hidden: Hidden, recording: Recording) -> Array:
    """The unknown torque as it acted, absorbed, (n,); at rest what friction held is not told apart from it."""
    law = UNKNOWN[hidden.name].law(hidden.size, hidden.shape)
    return np.array([law(y.s_m, y.dphi_m, y.phi_m, y.phi_a, 0.0, y.t) if y.s_m else 0.0 for y in recording.states])


def _variables(recording: Recording) -> dict[str, Array]:
    """The true motion by the names of the tool's curves, (n,) each."""
    phi_m, phi_a = (np.array([getattr(y, name) for y in recording.states]) for name in ("phi_m", "phi_a"))
    v = _speed(recording)
    t = np.arange(len(v)) * recording.sampling_time
    turns = np.flatnonzero(np.diff(np.sign(v)) != 0) + 1
    last = np.concatenate([[0], turns])[np.searchsorted(turns, np.arange(len(v)), side="right")]
    return {
        "dphi_m": v,
        "phi_m": phi_m,
        "phi_a": phi_a,
        "twist": RATIO * phi_m - phi_a,
        "ddphi_m": np.gradient(v, recording.sampling_time),
        "tau_m": recording.torque,
        "t": t,
        "reversal": t - t[last],
    }
