"""The tool as a user has it: a configuration and CSV files in a folder, stages one after another."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from robotid.config.load import load
from robotid.diagnosis.results import Diagnosis
from robotid.extension.results import Extension
from robotid.estimate.fitted_model import fitted_model, simulate_record
from robotid.pipeline.run import Run
from robotid.pipeline.execute import execute

TO_FIT = ("excite", "collect", "init-rigid", "init-flex", "fit")


@dataclass(frozen=True, slots=True)
class Fitted:
    """A fitted model. rmse : of the speed on all held-out samples [rad/s]; values : parameters by name."""

    run: Run
    rmse: float
    values: dict[str, float]


def fit(config: Path) -> Fitted:
    """Every stage up to the fit, in a run directory named like the configuration. Raises RobotidError."""
    run = Run(load(config), config.with_suffix(""))
    contents: dict[str, Any] = {stage: execute(run, stage).content for stage in TO_FIT}
    best = contents["fit"].models[contents["fit"].best]
    model = fitted_model(best)
    held = [r for r in contents["collect"].records if r.role == "validate"]
    if not held:  # a condition without such records
        return Fitted(run, float("nan"), {p.name: p.value for p in best.parameters})
    residuals = np.concatenate([r.dphi_m - simulate_record(model, r).signal("speed") for r in held])
    return Fitted(run, float(np.sqrt(np.mean(residuals**2))), {p.name: p.value for p in best.parameters})


def diagnosed(fitted: Fitted) -> Diagnosis:
    """What the tool says is missing. Raises RobotidError."""
    found: Diagnosis = execute(fitted.run, "diagnose").content
    return found


def diagnose(fitted: Fitted) -> tuple[Diagnosis, Extension]:
    """What the tool says is missing, and its model with that. Raises RobotidError."""
    return diagnosed(fitted), execute(fitted.run, "extend").content


def heldout_rmse(extension: Extension, samples: dict[str, int]) -> float:
    """Of the extended model's speed on all held-out samples [rad/s]. samples : by held-out record."""
    energy = sum(n * extension.after[name].rmse ** 2 for name, n in samples.items())
    return float(np.sqrt(energy / sum(samples.values())))
