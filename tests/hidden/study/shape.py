"""The true shape of an unknown torque, to compare with the shape that the tool reports."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hidden.plant.catalogue import UNKNOWN
from hidden.plant.experiment import Array, Recording
from hidden.plant.rig import RATIO
from hidden.study.case import Hidden
from robotid.judge.location import Curve

LEAST_SAMPLES = 5  # of a bin that counts


def correlation(curve: Curve, hidden: Hidden, records: Mapping[str, Recording]) -> float:
    """Of the reported curve with the true torque, binned likewise; nan along what is no variable of the motion.

    records : those of the fit. What a base model can imitate of the torque (a part along acceleration, speed and
    direction of motion) does not count: the fit has taken it. The tool signs torques as applied, the plant as absorbed.
    """
    along = [_variables(r).get(curve.along) for r in records.values()]
    if len(curve.x) < 3 or any(values is None for values in along):
        return float("nan")
    torque = np.concatenate([_torque(hidden, r) for r in records.values()])
    imitated = np.concatenate([_imitated(r) for r in records.values()])
    left = torque - imitated @ np.linalg.lstsq(imitated, torque, rcond=None)[0]
    variable = np.concatenate([values for values in along if values is not None])
    edges = 0.5 * (curve.x[1:] + curve.x[:-1])
    bins = np.searchsorted(edges, variable)
    count = np.bincount(bins, minlength=len(curve.x))
    mean = np.bincount(bins, left, minlength=len(curve.x)) / np.maximum(count, 1)
    full = count >= LEAST_SAMPLES
    return float(-np.corrcoef(curve.missing_torque[full], mean[full])[0, 1])


def _torque(hidden: Hidden, recording: Recording) -> Array:
    """The unknown torque as it acted, absorbed, (n,); at rest what friction held is not told apart from it."""
    law = UNKNOWN[hidden.name].law(hidden.size, hidden.shape)
    return np.array([law(y.s_m, y.dphi_m, y.phi_m, y.phi_a, 0.0, y.t) if y.s_m else 0.0 for y in recording.states])


def _imitated(recording: Recording) -> Array:
    """What torques of a base model are made of, (n, 3)."""
    v = np.array([y.dphi_m for y in recording.states])
    return np.column_stack([np.gradient(v, recording.sampling_time), v, np.sign(v)])


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
