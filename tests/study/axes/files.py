"""What the tool receives of a trial: CSV files of both axes, and the configuration of the one that is identified."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from study.axes.arms import RATIOS, SAMPLING_TIME, Arms, Extra
from study.axes.plan import Spec

POSE, COUPLING = "arm.pose_inertia[q2]", "arm.coupling[q2]"
"""Effects by which the second axis of a chain in a level plane acts on the first."""
STRUCTURE = (
    "motor.inertia",
    "motor.viscous",
    "motor.coulomb",
    "gear.spring",
    "gear.damper",
    "arm.inertia",
    POSE,
    COUPLING,
)


def hidden(spec: Spec) -> str:
    """The effect that the model lacks, empty for none."""
    return {
        "coupling": COUPLING,
        "pose": POSE,
        "friction": f"motor.{spec.friction}",
        "temperature": "motor.temperature_friction[temp]",
        "clean": "",
    }[spec.kind]


def truth(arms: Arms, extra: Extra) -> dict[str, float]:
    """Values of the tool's parameters in the true structure."""
    joint, b = arms.joints[0], arms.links
    lever, far = b.m2 * b.l1 * b.c2, b.I2 + b.m2 * b.c2**2
    values = {
        "motor.inertia.J": joint.motor_inertia,
        "motor.viscous.Fv": joint.Fv,
        "motor.coulomb.Fc": joint.Fc,
        "gear.spring.k1": joint.k,
        "gear.damper.d": joint.d,
        "arm.inertia.J": joint.flange + b.I1 + b.m1 * b.c1**2 + far + b.m2 * b.l1**2,
    }
    values |= {f"{POSE}.A": 0.0, f"{POSE}.B": 2.0 * lever, f"{POSE}.n": 1.0}
    values |= {f"{COUPLING}.H": far, f"{COUPLING}.A": 0.0, f"{COUPLING}.B": lever}
    return values | _of_friction(extra)


def _of_friction(extra: Extra) -> dict[str, float]:
    effect, shape = f"motor.{extra.name}", dict(extra.shape or {})
    if extra.name == "stribeck":
        return {f"{effect}.dFs": extra.size, f"{effect}.vs": shape["vs"]}
    if extra.name == "asymmetric_coulomb":
        return {f"{effect}.dFc": extra.size}
    if extra.name == "quadratic_friction":
        return {f"{effect}.Fq": extra.size}
    if extra.name == "position_friction":
        A, B = extra.size * np.cos(shape["phase"]), extra.size * np.sin(shape["phase"])
        return {f"{effect}.A": float(A), f"{effect}.B": float(B), f"{effect}.n": shape["n"]}
    return {"motor.temperature_friction[temp].c": extra.size} if extra.name == "temperature" else {}


def write(folder: Path, spec: Spec, arms: Arms, extra: Extra) -> None:
    """CSV files, base.yaml without what is hidden, and oracle.yaml with the true structure and a start at the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    names = ["time [s]"] + [f"{signal}{k}" for k in (1, 2) for signal in ("torque", "angle", "speed")] + ["temperature"]
    for number, plan in enumerate(arms.plans):
        made = arms.record(number, extra)
        columns = [np.arange(len(plan.temperature)) * SAMPLING_TIME]
        columns += [signal for axis in made for signal in (axis.torque, axis.angle, axis.speed)]
        columns.append(arms.measured_temperature(number))
        file, table = folder / f"{plan.name}.csv", np.column_stack(columns)
        np.savetxt(file, table, fmt="%.9g", delimiter=",", header=",".join(names), comments="")
    lacking = hidden(spec)
    _config(folder / "base.yaml", arms, [effect for effect in STRUCTURE if effect != lacking], {})
    more = [lacking] if lacking and lacking not in STRUCTURE else []
    _config(folder / "oracle.yaml", arms, [*STRUCTURE, *more], truth(arms, extra))


def _config(file: Path, arms: Arms, effects: list[str], values: Mapping[str, float]) -> None:
    model: dict[str, list[str]] = {}
    for effect in effects:
        port, name = effect.split(".", 1)
        model.setdefault(port, []).append(name)
    columns = {"t": "time"} | {
        signal: {"name": f"{word}1", "unit": unit}
        for signal, word, unit in (
            ("tau_m", "torque", "Nm"),
            ("phi_m", "angle", "rad"),
            ("dphi_m", "speed", "rad/s"),
        )
    }
    angle = {"name": "angle2", "unit": "rad", "scale": RATIOS[1], "kind": "angle"}
    signals = {"q2": angle, "temp": {"name": "temperature", "unit": "degC", "kind": "temperature"}}
    records: list[dict[str, Any]] = [
        {"name": plan.name, "role": plan.role, "use": plan.use, "file": f"{plan.name}.csv"}
        | {"columns": columns, "signals": signals}
        for plan in arms.plans
    ]
    document = {
        "robot": {
            "name": "hidden",
            "gear_ratio": RATIOS[0],
            "model": model,
            "parameters": {name: {"guess": value} for name, value in values.items()},
        },
        "records": records,
        "init_flex": {"band": [1, 12], "window": 5},
        "fit": {"models": {"m": [plan.name for plan in arms.plans if plan.role == "estimate"]}},
    }
    file.write_text(yaml.safe_dump(document, sort_keys=False))
