"""A rigid axis on two days: records of one, a model fitted to them, and a log of the other."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from robotid.catalogue import assemble
from robotid.cli.app import main
from robotid.estimate.fitted_model import FittedModel, fitted_model
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.model.structure import Structure
from robotid.signals.record import Record, Role
from robotid.simulation.simulate import simulate

STRUCTURE = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TRUTH = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.02, "motor.coulomb.Fc": 0.3}
CONFIG = """
robot: {name: axis, model: {motor: [inertia, viscous, coulomb]}}
records:
  - {name: one, file: one.csv}
  - {name: two, file: two.csv}
"""
STEP, DURATION = 2e-3, 4.0  # [s]
SPEED_NOISE, TORQUE_NOISE = 0.02, 0.02  # [rad/s, Nm], the second with a memory of ten samples


def axis_record(
    name: str, seed: int, truth: Mapping[str, float], role: Role = "estimate", terms: Structure = STRUCTURE
) -> Record:
    """A record of the axis with noise of its own, driven by another motion for every seed."""
    generator = np.random.default_rng([seed, sum(map(ord, name))])
    t = np.arange(0.0, DURATION, STEP)
    phases = 2 * np.pi * generator.random(6)
    torque = sum(
        0.35 * np.sin(2 * np.pi * f * t + p) for f, p in zip((0.5, 0.9, 1.7, 3.1, 5.9, 11.3), phases, strict=True)
    )
    joint = assemble(terms)
    theta = joint.parameters().with_values({k: v for k, v in truth.items() if k in joint.names}).values
    slow = np.zeros_like(t)
    draw = generator.standard_normal(len(t))
    for k in range(1, len(t)):
        slow[k] = 0.9 * slow[k - 1] + draw[k]
    slow *= TORQUE_NOISE / np.sqrt(1.0 / (1.0 - 0.81))
    quiet = Record(name, role, "both", STEP, torque + slow, np.zeros_like(t), np.zeros_like(t))
    made = simulate(joint, theta, quiet, np.zeros(joint.nx))
    speed = made.dphi_m + SPEED_NOISE * generator.standard_normal(len(t))
    return Record(name, role, "both", STEP, np.asarray(torque), made.phi_m, speed)


def watched(seed: int, change: Mapping[str, float] | None = None) -> tuple[FittedModel, tuple[Record, ...], Record]:
    """A fitted model, the records of its fit, and a log on which some parameters are others."""
    fitted = tuple(axis_record(name, seed, TRUTH) for name in ("one", "two"))
    log = axis_record("log", seed, {**TRUTH, **(change or {})}, "validate")
    joint = assemble(STRUCTURE)
    result = fit_model("m", joint, joint.parameters().with_values(TRUTH), fitted, FitOptions(output="speed"))
    return fitted_model(result), fitted, log


def write_accepted_run(folder: Path) -> None:
    """Write a.yaml with a fitted run in run/, and two new logs: monday.csv, as in the fit, and friday.csv, with more
    friction."""
    for name in ("one", "two", "monday"):
        _write(folder / f"{name}.csv", axis_record(name, 1, TRUTH))
    _write(folder / "friday.csv", axis_record("friday", 1, TRUTH | {"motor.coulomb.Fc": 0.34}))
    (folder / "a.yaml").write_text(CONFIG)
    for stage in ("collect", "init-rigid", "init-flex", "fit"):
        assert main([stage, str(folder / "a.yaml"), "--out", str(folder / "run"), "--quiet"]) == 0


def _write(file: Path, r: Record) -> None:
    rows = np.column_stack([r.t, r.tau_m, r.phi_m, r.dphi_m])
    np.savetxt(file, rows, delimiter=",", header="t [s],torque [Nm],angle [rad],speed [rad/s]", comments="")
