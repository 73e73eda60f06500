"""The virtual motor of data/motor_plant.yaml, with another effect in the place of its own."""

from __future__ import annotations

import yaml

from support.paths import ROOT

PLANT, OWN = ROOT / "data" / "motor_plant.yaml", "motor.stribeck"


def motor_with(effect: str, **parameters: float) -> str:
    """The configuration of a motor with this effect, and of the model without it."""
    machine = yaml.safe_load(PLANT.read_text())
    kept = {name: value for name, value in machine["plant"]["parameters"].items() if not name.startswith(OWN)}
    machine["plant"]["parameters"] = kept | {f"motor.{effect}.{symbol}": value for symbol, value in parameters.items()}
    machine["plant"]["model"]["motor"] = [*machine["robot"]["model"]["motor"], effect]
    return yaml.safe_dump(machine)
