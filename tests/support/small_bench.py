"""A small rigid axis on its virtual robot, with effects that its model lacks, and searches for them, for tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.refit.refit import refit
from robotid.diagnosis.refit.refitted_model import RefittedModel, extended
from robotid.diagnosis.search.data import Evidence, first_state
from robotid.diagnosis.search.search import search
from robotid.diagnosis.search.state import SearchResult, SearchState
from robotid.estimate.fitted_model import Simulated, fitted_model, simulate_record
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.result import FitResult
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.structure import Structure
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.virtual_robot import VirtualRobot

AXIS = Structure(("motor.inertia", "motor.viscous", "motor.coulomb"))
TRUTH = {"motor.inertia.J": 0.012, "motor.viscous.Fv": 0.015, "motor.coulomb.Fc": 0.6}
SAMPLING_TIME, DURATION = 0.002, 4.0
SPEED_NOISE, TORQUE_NOISE = 0.02, 0.005
CONTROLLER = Controller("speed", 0.5, 5.0)
STRIBECK = {"motor.stribeck.dFs": 0.15, "motor.stribeck.vs": 1.0}
QUICK = Criteria(skip=("power_friction",))
"""Without the slowest refit, where it decides nothing."""


def references() -> dict[str, Array]:
    """Reference speeds [rad/s]: slow and fast reversals, and two mixtures of many frequencies."""
    t = np.arange(round(DURATION / SAMPLING_TIME)) * SAMPLING_TIME
    return {
        "slow": _triangle(t, 6.0, 2.0),
        "wide": _triangle(t, 15.0, 1.0) + _multisine(t, 4.0, 1),
        "check": _triangle(t, 10.0, 1.6) + _multisine(t, 2.0, 2),
    }


def records(
    hidden: Mapping[str, float], *, seed: int = 1, changed: Mapping[str, float] | None = None, quiet: bool = False
) -> list[Record]:
    """Two records to fit, slow and wide, and one to check. hidden : parameters of effects beyond the axis, by dotted
    name; changed : factors on the truth in the record slow; quiet : without noise."""
    structure = AXIS
    for effect in dict.fromkeys(name.rpartition(".")[0] for name in hidden):
        structure = structure.extended(effect)
    joint = assemble(structure, angle=True)
    noise = (0.0, 0.0) if quiet else (TORQUE_NOISE, SPEED_NOISE)
    made = []
    for number, (name, ref) in enumerate(references().items()):
        factors = dict(changed or {}) if name == "slow" else {}
        truth = {key: value * factors.get(key, 1.0) for key, value in (TRUTH | dict(hidden)).items()}
        plant = VirtualRobot(joint, joint.parameters().with_values(truth).values, CONTROLLER, 0.0, *noise, seed)
        made.append(plant.record(Reference(name, SAMPLING_TIME, ref, "speed"), number))
    return [*made[:2], replace(made[2], role="validate")]


def records_of(
    joint: Joint,
    truth: Mapping[str, float],
    seed: int = 1,
    wanted: Mapping[str, Array] | None = None,
    torque_noise: float = TORQUE_NOISE,
) -> list[Record]:
    """The same experiments on another joint, or three others. wanted : reference speeds [rad/s], by name."""
    made = _made(joint, truth, references() if wanted is None else wanted, seed, torque_noise)
    return [*made[:2], replace(made[2], role="validate")]


def made_along(wanted: Mapping[str, Array], truth: Mapping[str, float] = TRUTH, seed: int = 1) -> list[Record]:
    """Records of the axis along reference speeds [rad/s], by name."""
    return _made(assemble(AXIS, angle=True), truth, wanted, seed)


def _made(
    joint: Joint,
    truth: Mapping[str, float],
    wanted: Mapping[str, Array],
    seed: int,
    torque_noise: float = TORQUE_NOISE,
) -> list[Record]:
    plant = VirtualRobot(
        joint, joint.parameters().with_values(truth).values, CONTROLLER, 0.0, torque_noise, SPEED_NOISE, seed
    )
    return [
        plant.record(Reference(name, SAMPLING_TIME, ref, "speed"), number)
        for number, (name, ref) in enumerate(wanted.items())
    ]


def fitted(made: list[Record]) -> FitResult:
    """The axis without anything hidden, as the pipeline fits it."""
    joint = assemble(AXIS)
    start = joint.parameters().with_values({name: 1.1 * value for name, value in TRUTH.items()})
    return fit_model("m", joint, start, made[:2], FitOptions())


def evidence(made: list[Record]) -> Evidence:
    """What a search is given: the model as it is fitted to the first two records."""
    return Evidence(fitted_model(fitted(made)), simulated(made)[:2], made[2:])


def searched(made: list[Record], criteria: Criteria | None = None) -> SearchResult:
    """What a search finds on such records."""
    return search(evidence(made), criteria or Criteria(), lambda _: None)


def simulated(made: list[Record]) -> list[Simulated]:
    """All records by the model as it is fitted."""
    model = fitted_model(fitted(made))
    return [simulate_record(model, record) for record in made]


def begun(made: list[Record], criteria: Criteria | None = None) -> SearchState:
    """The state in which a search begins: the records with their noise, and the model as it is fitted to them."""
    return first_state(evidence(made), criteria or Criteria())


@cache
def idle_then_stribeck() -> tuple[SearchState, RefittedModel, RefittedModel]:
    """The axis, with a cogging that it does not have, and with the Stribeck effect that it has besides."""
    state = begun(records(STRIBECK), QUICK)
    cogging = {f"motor.cogging.{k}": v for k, v in (("A", 0.01), ("n", 6.0))}
    structure, start = extended(state.first, "motor.cogging", cogging)
    idle = refit(structure, [start], state.data, state.first.trajectories)
    structure, start = extended(idle, "motor.stribeck", STRIBECK)
    return state, idle, refit(structure, [start], state.data, idle.trajectories)


def _triangle(t: Array, amplitude: float, period: float) -> Array:
    return np.asarray(amplitude * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * t / period)))


def _multisine(t: Array, peak: float, seed: int) -> Array:
    lines = np.arange(2, 60)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(lines))
    y = np.sin(2 * np.pi / DURATION * np.outer(t, lines) + phase).sum(axis=1) - np.sin(phase).sum()
    return np.asarray(peak * y / np.abs(y).max())
