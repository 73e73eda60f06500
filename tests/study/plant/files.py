"""What is handed over: one CSV file a record, as a recorder would write it, and a configuration for the tool."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from study.plant.draw import Draw, Plan
from study.plant.experiment import Recording
from study.plant.rig import RATIO

COLUMNS = "time [s],torque [Nm],angle [rad],speed [rad/s]"
BASE = ("motor.inertia", "motor.viscous", "motor.coulomb", "gear.spring", "gear.damper", "arm.inertia")


def write_csv(file: Path, recording: Recording, *, speed: bool = True) -> None:
    """Nine digits are more than any of the signals holds. speed : whether the recorder keeps it."""
    signals = [recording.t, recording.torque, recording.angle, recording.speed][: 4 if speed else 3]
    header = ",".join(COLUMNS.split(",")[: len(signals)])
    np.savetxt(file, np.column_stack(signals), fmt="%.9g", delimiter=",", header=header, comments="")


def write_config(
    file: Path,
    draw: Draw,
    effects: Sequence[str],
    parameters: Mapping[str, Mapping[str, Any]] | None = None,
) -> None:
    """The configuration of a joint of these effects, beside its CSV files."""
    model: dict[str, list[str]] = {}
    changes: dict[str, list[str]] = {}
    for effect in effects:
        first, rest = effect.split(".", 1)
        if first == "record_change":
            record, parameter = rest.split(".", 1)
            changes.setdefault(record, []).append(parameter)
        else:
            model.setdefault(first, []).append(rest)
    document = {
        "robot": {
            "name": "hidden",
            "gear_ratio": RATIO,
            "model": model,
            **({"changes": changes} if changes else {}),
            "parameters": {name: dict(said) for name, said in (parameters or {}).items()},
        },
        "records": [_record(plan) for plan in draw.plans],
        "init_flex": {"band": [1, 40], "window": 5},
        "fit": {"models": {"m": [plan.name for plan in draw.plans if plan.role == "estimate"]}},
    }
    file.write_text(yaml.safe_dump(document, sort_keys=False))


def _record(plan: Plan) -> dict[str, str]:
    return {"name": plan.name, "role": plan.role, "use": plan.use, "file": f"{plan.name}.csv"}
