"""The true shape of an unknown torque, to compare with the shape that the tool reports."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hidden.plant.catalogue import UNKNOWN
from hidden.plant.experiment import Array, Recording
from hidden.plant.rig import RATIO
from hidden.study.case import Hidden
from robotid.judge.location import Curve


def correlation(curve: Curve, hidden: Hidden, records: Mapping[str, Recording]) -> float:
    """Of the torque that the reported curve makes of the true motion with the true torque; nan along what is no
    variable of the motion.

    records : those of the fit. What a base model can imitate of either torque (a part along acceleration, speed,
    direction of motion, and a constant) does not count: the fit may have taken it. The tool signs torques as applied,
    the plant as absorbed.
    """
    name, _, counted = curve.along.partition(", ")
    if len(curve.x) < 3 or any(name not in _variables(r) for r in records.values()):
        return float("nan")
    imitated = np.concatenate([_imitated(r) for r in records.values()])
    told = np.concatenate([_followed(curve, _variables(r)[name], counted, r) for r in records.values()])
    torque = np.concatenate([_torque(hidden, r) for r in records.values()])
    left = [signal - imitated @ np.linalg.lstsq(imitated, signal, rcond=None)[0] for signal in (told, torque)]
    return float(-np.corrcoef(*left)[0, 1])


def _followed(curve: Curve, variable: Array, counted: str, recording: Recording) -> Array:
    """The torque of a curve along a record, (n,); a knot that is there twice is one on either side of a jump."""
    v = np.array([y.dphi_m for y in recording.states])
    side = np.interp(variable, curve.x, curve.missing_torque)
    twice = np.flatnonzero(np.diff(curve.x) == 0.0)
    if twice.size:
        k = int(twice[0]) + 1
        lower, upper = (
            np.interp(variable, curve.x[part], curve.missing_torque[part]) for part in (slice(k), slice(k, None))
        )
        side = np.where(variable < 0, lower, upper)
    return side * {"": np.ones_like(v), "by direction": np.sign(v), "by speed": v / curve.at}[counted]


def _torque(hidden: Hidden, recording: Recording) -> Array:
    """The unknown torque as it acted, absorbed, (n,); at rest what friction held is not told apart from it."""
    law = UNKNOWN[hidden.name].law(hidden.size, hidden.shape)
    return np.array([law(y.s_m, y.dphi_m, y.phi_m, y.phi_a, 0.0, y.t) if y.s_m else 0.0 for y in recording.states])


def _imitated(recording: Recording) -> Array:
    """What torques of a base model are made of, (n, 4)."""
    v = np.array([y.dphi_m for y in recording.states])
    return np.column_stack([np.gradient(v, recording.sampling_time), v, np.sign(v), np.ones_like(v)])


def _variables(recording: Recording) -> dict[str, Array]:
    """The true motion by the names of the tool's curves, (n,) each."""
    phi_m, phi_a = (np.array([getattr(y, name) for y in recording.states]) for name in ("phi_m", "phi_a"))
    v = np.array([y.dphi_m for y in recording.states])
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
