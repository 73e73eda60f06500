"""Records of the paper's joint with an effect that its model lacks, and what that model makes of them, for tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from robotid.catalogue import assemble
from robotid.estimate.fitted_model import FittedModel, Simulated, simulate_record
from robotid.model.array import Array, Mask
from robotid.model.joint import Joint
from robotid.model.term import Motion
from robotid.signals.record import Quantity, Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot
from robotid.simulation.simulate import simulate
from robotid.terms import TERMS
from support.paper_joint import SAMPLING_TIME, STRUCTURE, TRUTH, references

SPEED_NOISE, TORQUE_NOISE, QUANTUM = 0.02, 0.005, 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Hidden:
    """One record. missing (n,) [Nm] : the torque of the hidden effect on the motor; moving (n,) : it slips."""

    record: Record
    model: FittedModel
    simulated: Simulated
    missing: Array
    moving: Mask

    def residual(self, output: Quantity = "speed") -> Array:
        return self.simulated.residual(output)


def hidden(
    effect: str,
    values: Mapping[str, float],
    *,
    number: int = 1,
    samples: int = 6000,
    speed_noise: float = SPEED_NOISE,
    torque_noise: float = TORQUE_NOISE,
    output: Quantity = "speed",
    reference: Reference | None = None,
) -> Hidden:
    """Set `number` of the paper cut short, under a motor effect with these values beside the paper's truth.

    The model that simulates it has the true values, and not the effect.
    """
    joint = assemble(STRUCTURE.extended(f"motor.{effect}"), angle=True)
    own = {f"motor.{effect}.{symbol}": value for symbol, value in values.items()}
    theta = joint.parameters().with_values(TRUTH | own).values
    plant = VirtualRobot(joint, theta, Controller("speed", 0.5, 5.0), QUANTUM, torque_noise, speed_noise, seed=number)
    reference = reference or Reference(f"set{number}", SAMPLING_TIME, references()[number - 1][:samples], "speed")
    record = plant.record(reference, number)
    known = assemble(STRUCTURE, angle=output == "position")
    model = FittedModel("m", known, known.parameters().with_values(TRUTH), output, (), {})
    simulated = simulate_record(model, record)
    return Hidden(record, model, simulated, *_missing(effect, values, joint, theta, record))


def _missing(effect: str, own: Mapping[str, float], joint: Joint, theta: Array, record: Record) -> tuple[Array, Mask]:
    """The effect's torque along the true motion, and where that motion slips."""
    truth = simulate(joint, theta, record, np.zeros(joint.nx))
    v, none = truth.dphi_m, np.zeros((0, len(record)))
    motion = Motion(truth.phi_m, v, np.zeros(len(v)), np.sign(v), record.t, none)
    term = TERMS[effect]
    absorbed = term.torque(motion, [own[p.symbol] for p in term.parameters])
    return np.broadcast_to(-np.asarray(absorbed), v.shape), np.abs(v) > 0.05
