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
    found; speeds : whether it can be found in a log with a speed, and in one without."""

    name: str
    make: Callable[[Log], Log]
    found: str
    severity: str = "fatal"
    kinds: tuple[str, ...] = ("rigid", "flexible")
    speeds: tuple[bool, ...] = (True, False)


def without_speed(log: Log) -> Log:
    """The same log, of a drive that records no speed."""
    return {name: values for name, values in log.items() if name != "dphi_m"}


def _unrelated(log: Log, seed: int = 3) -> Array:
    return np.asarray(np.std(log["tau_m"]) * np.sin(2 * np.pi * 1.7 * log["t"] + np.cumsum(_noise(log, seed)) * 0.05))


def _noise(log: Log, seed: int) -> Array:
    return np.random.default_rng(seed).standard_normal(len(log["t"]))


def _times(factor: float, *names: str) -> Callable[[Log], Log]:
    """A mistake that multiplies columns."""
    return lambda log: log | {name: factor * log[name] for name in names if name in log}


def _instead(**others: str) -> Callable[[Log], Log]:
    """A mistake that takes columns for others."""
    return lambda log: log | {name: log[other] for name, other in others.items()}


def _speed_of(log: Log) -> Array:
    return np.asarray(np.gradient(log["phi_m"], H))


def _in_counts(log: Log) -> Log:
    return log | {"phi_m": np.rint(log["phi_m"] * 65536 / (2 * np.pi))}


def _speed_as_angle(log: Log) -> Log:
    speed = _speed_of(log)
    return log | {"phi_m": speed} | ({"dphi_m": np.gradient(speed, H)} if "dphi_m" in log else {})


def _with_noisy_speed(log: Log) -> Log:
    speed = _speed_of(log)
    return log | {"tau_m": speed + 0.2 * np.std(speed) * _noise(log, 6)}


def _with_spike(log: Log) -> Log:
    torque = log["tau_m"].copy()
    torque[77] = 1e5
    return log | {"tau_m": torque}


MEASURED = (True,)
ANGLE_ONLY = (False,)
MOTION = ("phi_m", "dphi_m")
MISTAKES = (
    Mistake("torque_sign", _times(-1.0, "tau_m"), "torque_sign"),
    Mistake("angle_sign", _times(-1.0, *MOTION), "torque_sign"),
    Mistake("speed_sign", _times(-1.0, "dphi_m"), "speed_sign", speeds=MEASURED),
    Mistake("speed_zeros", _times(0.0, "dphi_m"), "speed_empty", speeds=MEASURED),
    Mistake("speed_unrelated", lambda log: log | {"dphi_m": 8.0 * _unrelated(log)}, "speed_unrelated", speeds=MEASURED),
    Mistake("speed_noise", lambda log: log | {"dphi_m": 8.0 * _noise(log, 9)}, "speed_unrelated", speeds=MEASURED),
    Mistake("speed_is_angle", _instead(dphi_m="phi_m"), "speed_unrelated", speeds=MEASURED),
    Mistake("speed_in_degrees", _times(180 / np.pi, "dphi_m"), "speed_scale", speeds=MEASURED),
    Mistake("angle_in_degrees_beside_a_speed", _times(180 / np.pi, "phi_m"), "speed_scale", speeds=MEASURED),
    Mistake("angle_in_radians_taken_for_degrees", _times(np.pi / 180, "phi_m"), "speed_scale", speeds=MEASURED),
    Mistake("time_in_milliseconds_beside_a_speed", _times(1e3, "t"), "speed_scale", speeds=MEASURED),
    Mistake("torque_unrelated", lambda log: log | {"tau_m": _unrelated(log)}, "torque_unrelated"),
    Mistake("torque_unrelated_too", lambda log: log | {"tau_m": _unrelated(log, 1)}, "torque_unrelated"),
    Mistake("torque_noise", lambda log: log | {"tau_m": 0.5 * _noise(log, 4)}, "torque_unrelated"),
    Mistake("torque_is_angle", _instead(tau_m="phi_m"), "torque_copy"),
    Mistake("torque_is_speed", lambda log: log | {"tau_m": 3.0 * log["dphi_m"] + 1.0}, "torque_copy", speeds=MEASURED),
    Mistake(
        "torque_is_derived_speed", lambda log: log | {"tau_m": 3.0 * _speed_of(log)}, "torque_copy", speeds=ANGLE_ONLY
    ),
    Mistake(
        "torque_is_a_measured_speed",
        lambda log: log | {"tau_m": _speed_of(log) + 0.02 * _noise(log, 5)},
        "torque_follows",
        speeds=ANGLE_ONLY,
    ),
    Mistake("torque_is_a_noisy_speed", _with_noisy_speed, "torque_follows"),
    Mistake(
        "torque_is_acceleration",
        lambda log: log | {"tau_m": np.gradient(log["dphi_m"])},
        "torque_copy",
        speeds=MEASURED,
    ),
    Mistake("speed_for_angle", _speed_as_angle, "angle_is_speed", kinds=("rigid",)),
    Mistake("torque_of_another_time", lambda log: log | {"tau_m": np.roll(log["tau_m"], 100)}, "torque_elsewhere"),
    Mistake(
        "torque_of_a_tenth_later",
        lambda log: log | {"tau_m": np.roll(log["tau_m"], N // 10)},
        "torque_elsewhere",
    ),
    Mistake("torque_is_time", _instead(tau_m="t"), "torque_copy"),
    Mistake("torque_with_a_spike", _with_spike, "torque_spikes"),
    Mistake("two_levels", lambda log: log | {"tau_m": np.sign(log["tau_m"])}, "torque_levels", "warning"),
    Mistake("torque_and_angle_exchanged", _instead(tau_m="phi_m", phi_m="tau_m"), "speed_exchanged", speeds=MEASURED),
    Mistake(
        "torque_and_angle_exchanged_without_a_speed",
        _instead(tau_m="phi_m", phi_m="tau_m"),
        "torque_unrelated",
        speeds=ANGLE_ONLY,
    ),
    Mistake("torque_and_speed_exchanged", _instead(tau_m="dphi_m", dphi_m="tau_m"), "speed_exchanged", speeds=MEASURED),
    Mistake("angle_and_speed_exchanged", _instead(phi_m="dphi_m", dphi_m="phi_m"), "speed_exchanged", speeds=MEASURED),
    Mistake("newton_millimetres", _times(1e3, "tau_m"), "inertia_size", kinds=("flexible",)),
    Mistake("newton_millimetres_without_a_gear", _times(1e3, "tau_m"), "inertia_size", "warning", kinds=("rigid",)),
    Mistake("angle_of_the_arm", _times(RATIO, *MOTION), "inertia_size", kinds=("flexible",)),
    Mistake("radians_taken_for_degrees", _times(np.pi / 180, *MOTION), "inertia_size", kinds=("flexible",)),
    Mistake("degrees", _times(180 / np.pi, *MOTION), "angle_unit"),
    Mistake("counts", _in_counts, "angle_counts", speeds=ANGLE_ONLY),
    Mistake("counts_beside_a_speed", _in_counts, "speed_scale", speeds=MEASURED),
    Mistake("time_in_milliseconds", _times(1e3, "t"), "sampling_size", speeds=ANGLE_ONLY),
    Mistake("time_in_microseconds", _times(1e6, "t"), "sampling_size", speeds=ANGLE_ONLY),
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
