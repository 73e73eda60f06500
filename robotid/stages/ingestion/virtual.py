"""The virtual robot's records: what `collect` makes where the configuration excites rather than reads.

One joint moves by itself; the axes that a body couples move together, once for all of them.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

from robotid.catalogue import assemble
from robotid.config.plant import ControllerSettings, MachineSettings, OtherAxisSettings
from robotid.config.records import RecordSettings
from robotid.config.robot import structure_of
from robotid.config.schema import Config
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.signals.reference import Excitation
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.coupled.coupled_robot import CoupledRobot
from robotid.simulation.coupled.planar_chain import Link, PlanarChain


def virtual_robot(settings: Config) -> VirtualRobot:
    """The plant section as a machine that can be run."""
    plant = settings.plant
    assert plant is not None  # the configuration's own check: a record that excites needs a plant
    return _machine(settings.plant_structure(), plant)


def coupled_robot(settings: Config) -> CoupledRobot:
    """The same with all axes that the body of the plant couples."""
    plant = settings.plant
    assert plant is not None
    assert plant.body is not None
    axes = {
        name: virtual_robot(settings) if name == plant.body.axis else _other(plant.body.others[name])
        for name in plant.body.axes
    }
    links = [Link(one.mass, one.length, one.centre, one.inertia) for one in plant.body.links]
    return CoupledRobot(axes, PlanarChain(links, plant.body.gravity))


def _other(axis: OtherAxisSettings) -> VirtualRobot:
    return _machine(structure_of(axis.model, axis.gear_ratio, linear=False), axis)


def _machine(structure: Structure, plant: MachineSettings) -> VirtualRobot:
    joint = assemble(structure, angle=True)
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


class VirtualRecords:
    """The records of a virtual robot; motions of all axes together are computed once, whichever axis asks first."""

    def __init__(self) -> None:
        self._motions: dict[str, dict[str, Record]] = {}

    def of(self, settings: Config, record: RecordSettings, excitation: Excitation, first: int) -> tuple[Record, ...]:
        """One record for each realisation of a record's excitation. first : number of the first, for its own noise."""
        references = [r for r in excitation.references if r.block == record.name]
        assert settings.plant is not None
        if settings.plant.body is None:
            robot = virtual_robot(settings)
            made = [robot.record(reference, first + k) for k, reference in enumerate(references)]
        else:
            body = settings.plant.body
            for k, reference in enumerate(references):
                if reference.name not in self._motions:
                    others = {
                        name: found
                        for name in body.others
                        for found in excitation.others[name]
                        if found.name == reference.name
                    }
                    together = {name: others.get(name, reference) for name in body.axes}
                    self._motions[reference.name] = coupled_robot(settings).record(together, first + k, record.pose)
            made = [self._motions[reference.name][body.axis] for reference in references]
        return tuple(replace(one, role=record.role, use=record.use) for one in made)
