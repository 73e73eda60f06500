"""A rigid axis that lacks something, taken through the command line as a user would, for tests. Asked once a case."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from robotid.cli.app import main
from robotid.pipeline.table import STAGES

MODELS = {"named": "[inertia, viscous, coulomb, stribeck]", "clean": "[inertia, viscous, coulomb]"}
TRUTHS = {"named": "\n    motor.stribeck.dFs: 0.15\n    motor.stribeck.vs: 1.0", "clean": ""}
TEXT = """\
robot: {{name: axis, model: {{motor: [inertia, viscous, coulomb]}}}}
records:
  - name: slow
    excite: {{kind: triangle, amplitude: 6, period: 2, duration: 4, sampling_time: 0.002}}
  - name: wide
    excite:
      kind: sum
      sampling_time: 0.002
      of:
        - {{kind: triangle, amplitude: 15, period: 1}}
        - {{kind: multisine, band: [0.5, 15], period: 4, peak: 4, crest_factor: null}}
  - name: check
    role: validate
    excite: {{kind: triangle, amplitude: 10, period: 1.6, duration: 4.8, sampling_time: 0.002}}
plant:
  model: {{motor: {model}}}
  parameters:
    motor.inertia.J: 0.012
    motor.viscous.Fv: 0.015
    motor.coulomb.Fc: 0.6{truth}
  controller: {{kind: speed, kp: 0.5, ki: 5}}
  encoder: {{counts_per_rev: 65536}}
  noise: {{speed: 0.02, torque: 0.005}}
  seed: 1
diagnose: {{skip: [power_friction]}}
"""
FOLDERS: list[TemporaryDirectory[str]] = []


def configuration(case: str) -> str:
    """ "named" lacks a Stribeck effect, "clean" lacks nothing."""
    return TEXT.format(model=MODELS[case], truth=TRUTHS[case])


@cache
def ran(case: str) -> tuple[Path, Path]:
    """The configuration, and the run directory with the artifacts of all stages but validate."""
    FOLDERS.append(TemporaryDirectory(prefix="robotid-"))
    folder = Path(FOLDERS[-1].name)
    config = folder / f"{case}.yaml"
    config.write_text(configuration(case), encoding="utf-8")
    for stage in STAGES:
        if stage != "validate":
            assert main([stage, str(config), "--out", str(folder / "out"), "--quiet"]) == 0
    return config, folder / "out"
