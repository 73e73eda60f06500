"""Records of the paper's joint, or one like it, from the virtual robot, and a configuration for them, for tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from robotid.catalogue import assemble
from robotid.config.schema import Config
from robotid.model.structure import Structure
from robotid.signals.quality import Recordings
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from support.paper_joint import RATIO, SAMPLING_TIME, STRUCTURE, TRUTH, references

TWO_MASSES = {
    "motor": ("inertia", "viscous", "coulomb"),
    "gear": ("spring", "cubic_spring", "damper"),
    "arm": ("inertia",),
}


def paper_records(structure: Structure, truth: Mapping[str, float]) -> tuple[Record, Record, Record]:
    """Sets 1 (use: rigid), 2 and 3 (use: flex), with a 16-bit encoder and some noise."""
    joint = assemble(structure, angle=True)
    theta = joint.parameters().with_values(truth).values
    plant = VirtualRobot(joint, theta, Controller("speed", 0.5, 5.0), 2 * np.pi / 2**16, 0.01, 0.01, seed=1)
    set1, set2, set3 = (
        plant.record(Reference(f"set{k + 1}", SAMPLING_TIME, ref, "speed", 5.0, (1.0, 40.0) if k else None), k)
        for k, ref in enumerate(references())
    )
    return replace(set1, use="rigid"), replace(set2, use="flex"), replace(set3, use="flex")


@cache
def true_records() -> tuple[Record, Record, Record]:
    """Those of the paper's joint itself."""
    return paper_records(STRUCTURE, TRUTH)


def recordings(*chosen: Record) -> Recordings:
    """These, or all of the paper's joint, as a stage reads them."""
    return Recordings(records=chosen or true_records(), reports=())


def configured(model: Mapping[str, tuple[str, ...]] = TWO_MASSES, **sections: Any) -> Config:
    """A configuration of the paper's joint with other sections, or keys of robot."""
    robot = {"name": "irb", "gear_ratio": RATIO, "model": model} | sections.pop("robot", {})
    return Config.model_validate({"robot": robot, "records": ({"name": "set1", "file": "set1.csv"},), **sections})
