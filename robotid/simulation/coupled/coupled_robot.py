"""The virtual robot of several axes: coupled joints under their controllers, as their noisy sensors show them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from robotid.model.companion import CompanionKind, drive_of
from robotid.signals.companion import Companion
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.coupled.loop import follow
from robotid.simulation.coupled.planar_chain import PlanarChain


@dataclass(frozen=True, slots=True, eq=False)
class CoupledRobot:
    """axes : from the base to the tip, each with its truth, controller, noise and seed; body : what couples them.

    The record of an axis has the angles of all others behind their gears as companions of their names, as far as their
    encoders show them, and their torques as drives.
    """

    axes: Mapping[str, VirtualRobot]
    body: PlanarChain

    def record(
        self, references: Mapping[str, Reference], number: int, pose: Mapping[str, float] | None = None
    ) -> dict[str, Record]:
        """The motion that references, one each axis, cause from rest, as recorded, by axis.

        number : of the record, for its own noise; pose : angles [rad] of arms at the start, zero where none is given.
        """
        order, names = list(self.axes.values()), list(self.axes)
        drawn = [np.random.default_rng([robot.seed, number, k]) for k, robot in enumerate(order)]
        n = len(references[names[0]])
        noise = np.array([one.speed_noise * rng.standard_normal(n) for one, rng in zip(order, drawn, strict=True)])
        start = [(pose or {}).get(name, 0.0) for name in names]
        runs = follow(order, self.body, [references[name] for name in names], noise, start)
        records = {
            name: robot.as_recorded(references[name], run.x, run.torque, own, rng)
            for name, robot, run, own, rng in zip(names, order, runs, noise, drawn, strict=True)
        }
        h = references[names[0]].sampling_time
        angles = {
            name: Companion.of(CompanionKind.ANGLE, robot.joint.ratio * records[name].phi_m, h)
            for name, robot in self.axes.items()
        }
        drives = {name: Companion.of(CompanionKind.DRIVE, record.tau_m, h) for name, record in records.items()}
        return {
            name: replace(
                record,
                companions={other: angle for other, angle in angles.items() if other != name}
                | {drive_of(other): drive for other, drive in drives.items() if other != name},
            )
            for name, record in records.items()
        }
