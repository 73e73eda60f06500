"""Repeated experiments on a virtual robot, each with noise of its own; the share of 95 % intervals with the truth.

Smoke's two short records, the paper's joint and a rigid axis, under white noise on speed and torque, under a coloured
error of the torque besides, and without any error of the torque.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from itertools import repeat

import numpy as np
from scipy.signal import lfilter
from support.paper_joint import STRUCTURE, TRUTH, references

from robotid.catalogue import assemble
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from study.plant.references import multisine, square, triangle

SPEED_NOISE, TORQUE_NOISE, QUANTUM = 0.02, 0.005, 2 * np.pi / 2**16
COLOURED, POLE = 0.02, 0.99
QUANTILE = 1.96
RIGID = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
FLEXIBLE = Structure(tuple(name for name in STRUCTURE.terms if "cubic" not in name), gear_ratio=STRUCTURE.gear_ratio)


@dataclass(frozen=True, slots=True)
class Experiment:
    """A joint with its truth, and the reference speeds that it follows [rad/s]."""

    structure: Structure
    truth: Mapping[str, float]
    references: tuple[np.ndarray, ...]
    sampling_time: float


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of the torque's white noise and of its coloured error [Nm]."""

    torque: float
    coloured: float = 0.0


NOISES = {
    "no torque error": Noise(0.0),
    "white": Noise(TORQUE_NOISE),
    "white and AR 0.99": Noise(TORQUE_NOISE, COLOURED),
}


@cache
def experiments() -> dict[str, Experiment]:
    """By name."""
    h = 1e-3
    wide = multisine(8.0, 2.0, 2.0, h, 1) + square(10.0, 2.0, 2.0, h)
    own = {name: value for name, value in TRUTH.items() if name.rpartition(".")[0] in FLEXIBLE.terms}
    axis = {name: value for name, value in TRUTH.items() if name.rpartition(".")[0] in RIGID.terms}
    return {
        "smoke": Experiment(FLEXIBLE, own, (triangle(30.0, 2.0, 3.0, h), wide), h),
        "paper": Experiment(STRUCTURE, TRUTH, references(), 5e-4),
        "rigid axis": Experiment(RIGID, axis, (triangle(20.0, 2.0, 4.0, h), wide), h),
    }


def estimate(name: str, noise: str, seed: int) -> dict[str, float]:
    """Error over the robust standard deviation of every parameter, in one repetition."""
    experiment, level = experiments()[name], NOISES[noise]
    joint = assemble(experiment.structure, angle=True)
    truth = joint.parameters().with_values(experiment.truth)
    robot = VirtualRobot(
        joint, truth.values, Controller("speed", 0.5, 5.0), QUANTUM, level.torque, SPEED_NOISE, seed=seed
    )
    rng = np.random.default_rng([seed, 7])
    records = [
        _coloured(robot.record(Reference(f"r{k}", experiment.sampling_time, ref, "speed"), k), level.coloured, rng)
        for k, ref in enumerate(experiment.references)
    ]
    bare = assemble(experiment.structure)
    fit = fit_model("m", bare, bare.parameters().with_values(experiment.truth), records, FitOptions())
    return {p.name: (p.value - experiment.truth[p.name]) / p.std_robust for p in fit.parameters}


def _coloured(record: Record, size: float, rng: np.random.Generator) -> Record:
    if size == 0.0:
        return record
    pole = POLE ** (record.sampling_time / 1e-3)
    drive = np.sqrt(1 - pole**2) * rng.standard_normal(len(record) + 5000)
    return replace(record, tau_m=record.tau_m + size * lfilter([1.0], [1.0, -pole], drive)[5000:])


def main() -> None:
    """Print a row a parameter."""
    parser = argparse.ArgumentParser(prog="study.coverage", description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--only", action="append", default=[], help="experiment or noise; repeatable")
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    only = set(asked.only)
    print("| experiment | noise | parameter | in its 95 % interval | spread over what is stated |")
    print("| --- | --- | --- | --- | --- |")
    with ProcessPoolExecutor(asked.jobs) as pool:
        for name in experiments():
            for noise in NOISES:
                if only and not (name in only and (noise in only or not only & set(NOISES))):
                    continue
                seeds = range(asked.first, asked.first + asked.seeds)
                errors = list(pool.map(estimate, repeat(name), repeat(noise), seeds))
                for parameter in errors[0]:
                    z = np.array([one[parameter] for one in errors])
                    share = 100 * np.mean(np.abs(z) < QUANTILE)
                    print(f"| {name} | {noise} | `{parameter}` | {share:.0f} % | {np.std(z):.2f} |", flush=True)
                print(f"{name}, {noise}: done", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
