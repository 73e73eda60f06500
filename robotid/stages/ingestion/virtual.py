"""The virtual robot's records: what `collect` makes where the configuration excites rather than reads."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from robotid.catalogue import assemble
from robotid.config.plant import ControllerSettings
from robotid.config.records import RecordSettings
from robotid.config.schema import Config
from robotid.signals.record import Record
from robotid.signals.reference import Excitation
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot


def virtual_robot(settings: Config) -> VirtualRobot:
    """The plant section as a machine that can be run."""
    plant = settings.plant
    assert plant is not None  # the configuration's own check: a record that excites needs a plant
    joint = assemble(settings.plant_structure(), angle=True)
    return VirtualRobot(
        joint,
        joint.parameters().with_values(plant.parameters).values,
        controller_of(plant.controller),
        plant.encoder.step,
        plant.noise.torque,
        plant.noise.speed,
        plant.seed,
    )


def controller_of(settings: ControllerSettings) -> Controller:
    """The controller section as a controller."""
    return Controller(
        settings.kind,
        settings.kp,
        settings.ki,
        settings.kpos or 0.0,
        settings.feedforward_inertia,
        inf if settings.limit is None else settings.limit,
    )


def virtual_records(
    robot: VirtualRobot, record: RecordSettings, excitation: Excitation, first: int
) -> tuple[Record, ...]:
    """One record for each realisation of a record's excitation. first : number of the first, for its own noise."""
    references = [r for r in excitation.references if r.block == record.name]
    made = (robot.record(reference, first + k) for k, reference in enumerate(references))
    return tuple(replace(one, role=record.role, use=record.use) for one in made)
