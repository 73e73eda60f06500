"""Logs of a rigid axis and of a flexible joint, as they should be and with one mistake each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from robotid.catalogue import assemble
from robotid.model.array import Array
from robotid.model.structure import Structure
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

H = 0.002
N = 3000
RATIO = 1 / 224.3
Log = dict[str, Array]
"""Columns by name: t, tau_m, phi_m, dphi_m."""

RIGID = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.013, "motor.coulomb.Fc": 0.6}
FLEXIBLE = {
    "motor.inertia.J": 0.0121,
    "motor.viscous.Fv": 0.013,
    "motor.coulomb.Fc": 0.6,
    "gear.spring.k1": 1.46e6,
    "gear.damper.d": 2.63e3,
    "arm.inertia.J": 1130.0,
}
MODELS = {
    "rigid": "{motor: [inertia, viscous, coulomb]}",
    "flexible": "{motor: [inertia, viscous, coulomb], gear: [spring, damper], arm: [inertia]}",
}


def swing(*, seed: int = 1, highest: int = 120) -> Array:
    """A reference speed [rad/s]: a multisine up to highest / 6 Hz on a square wave, (n,)."""
    t = np.arange(N) * H
    rng = np.random.default_rng(seed)
    lines = np.arange(1, highest + 1)
    wave = np.sin(2 * np.pi * np.outer(t / (N * H), lines) + rng.uniform(0, 2 * np.pi, len(lines))).sum(axis=1)
    return np.asarray(8.0 * wave / np.abs(wave).max() + 12.0 * np.sign(np.sin(2 * np.pi * 2 * t / (N * H) + 1e-9)))


def log_of(truth: Mapping[str, float], reference: Array, *, noise: float = 0.005, ratio: float | None = None) -> Log:
    """A log of a joint that follows a reference speed [rad/s], (n,). noise [Nm] : of the torque."""
    terms = tuple(dict.fromkeys(name.rpartition(".")[0] for name in truth))
    joint = assemble(Structure(terms, gear_ratio=ratio), angle=True)
    values = joint.parameters().with_values(truth).values
    plant = VirtualRobot(joint, values, Controller("speed", 0.5, 5.0), 2 * np.pi / 65536, noise, 2 * noise, seed=1)
    record = plant.record(Reference("log", H, reference, "speed"), 0)
    return {"t": record.t, "tau_m": record.tau_m, "phi_m": record.phi_m, "dphi_m": record.dphi_m}


@cache
def _right(kind: str, noise: float) -> Log:
    truth, ratio = (FLEXIBLE, RATIO) if kind == "flexible" else (RIGID, None)
    return log_of(truth, swing(), noise=noise, ratio=ratio)


def right_log(kind: str, *, noise: float = 0.005) -> Log:
    """The log of a "rigid" axis or a "flexible" joint without a mistake."""
    return dict(_right(kind, noise))


@dataclass(frozen=True)
class Mistake:
    """One mistake in a log. found : the check that finds it; severity : how; kinds : of the joints on which it can be
    found."""

    name: str
    make: Callable[[Log], Log]
    found: str
    severity: str = "fatal"
    kinds: tuple[str, ...] = ("rigid", "flexible")


def _unrelated(log: Log) -> Array:
    return np.asarray(np.std(log["tau_m"]) * np.sin(2 * np.pi * 1.7 * log["t"] + np.cumsum(_noise(log, 3)) * 0.05))


def _thousandfold(log: Log) -> Log:
    return log | {"tau_m": 1e3 * log["tau_m"]}


def _noise(log: Log, seed: int) -> Array:
    return np.random.default_rng(seed).standard_normal(len(log["t"]))


MISTAKES = (
    Mistake("torque_sign", lambda log: log | {"tau_m": -log["tau_m"]}, "torque_sign"),
    Mistake("angle_sign", lambda log: log | {"phi_m": -log["phi_m"], "dphi_m": -log["dphi_m"]}, "torque_sign"),
    Mistake("speed_sign", lambda log: log | {"dphi_m": -log["dphi_m"]}, "speed_sign"),
    Mistake("speed_zeros", lambda log: log | {"dphi_m": np.zeros_like(log["t"])}, "speed_empty"),
    Mistake("speed_unrelated", lambda log: log | {"dphi_m": 8.0 * _unrelated(log)}, "speed_unrelated"),
    Mistake("torque_unrelated", lambda log: log | {"tau_m": _unrelated(log)}, "torque_unrelated"),
    Mistake("torque_noise", lambda log: log | {"tau_m": 0.5 * _noise(log, 4)}, "torque_unrelated"),
    Mistake("torque_is_angle", lambda log: log | {"tau_m": log["phi_m"]}, "torque_copy"),
    Mistake("torque_is_speed", lambda log: log | {"tau_m": 3.0 * log["dphi_m"] + 1.0}, "torque_copy"),
    Mistake("two_levels", lambda log: log | {"tau_m": np.sign(log["tau_m"])}, "torque_levels", "warning"),
    Mistake("newton_millimetres", _thousandfold, "inertia_size", kinds=("flexible",)),
    Mistake(
        "newton_millimetres_without_a_gear",
        _thousandfold,
        "inertia_size",
        "warning",
        kinds=("rigid",),
    ),
    Mistake(
        "angle_of_the_arm",
        lambda log: log | {"phi_m": RATIO * log["phi_m"], "dphi_m": RATIO * log["dphi_m"]},
        "inertia_size",
        kinds=("flexible",),
    ),
    Mistake(
        "degrees",
        lambda log: (
            {name: values for name, values in log.items() if name != "dphi_m"} | {"phi_m": np.rad2deg(log["phi_m"])}
        ),
        "angle_unit",
        "warning",
    ),
    Mistake(
        "volts",
        lambda log: log | {"tau_m": np.rint(log["tau_m"] / 2 * 4096 / 20) * 20 / 4096},
        "torque_volts",
        "warning",
    ),
)


def write_csv(path: Path, log: Log) -> None:
    """A log as a file of comma-separated values in SI, names in the first line."""
    np.savetxt(path, np.column_stack(list(log.values())), delimiter=",", header=",".join(log), comments="", fmt="%.9g")


def configuration(kind: str, files: Mapping[str, str], *, accept: tuple[str, ...] = ()) -> str:
    """A configuration of files by role."""
    ratio = f"gear_ratio: {RATIO}, " if kind == "flexible" else ""
    records = "\n".join(f"  - {{name: {role}, role: {role}, file: {file}}}" for role, file in files.items())
    check = f"check: {{accept: [{', '.join(accept)}]}}\n"
    return f"robot: {{name: axis, {ratio}model: {MODELS[kind]}}}\nrecords:\n{records}\n{check}"
