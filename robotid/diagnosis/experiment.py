"""The discriminating experiment: what would tell two causes apart that the records do not.

Both models are simulated on each experiment that could be driven, and compared in standard deviations of the noise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.refit.refitted_model import RefittedModel
from robotid.diagnosis.refit.settings import REFIT
from robotid.diagnosis.results import Cause, Diagnosis, Separation
from robotid.diagnosis.search.state import AcceptedCause, SearchResult
from robotid.diagnosis.settings import VERDICT
from robotid.errors import NumericsError
from robotid.estimate.least_squares import SolveOptions, solve
from robotid.estimate.residual import OutputError
from robotid.model.array import Array
from robotid.signals.record import Record
from robotid.signals.reference import Reference
from robotid.simulation.closed_loop.controller import Controller
from robotid.simulation.closed_loop.loop import ControlledJoint


@dataclass(frozen=True, slots=True)
class Experiments:
    """Experiments that could be driven. references : of speed, by the text of their excite block, for a joint that made
    these records; controller : of the speed loop, None where it is not known."""

    references: Callable[[Sequence[Record]], Mapping[str, Reference]]
    controller: Controller | None = None


def with_experiments(diagnosis: Diagnosis, found: SearchResult, experiments: Experiments) -> Diagnosis:
    """The diagnosis with a discriminating experiment for every cause that has a twin."""
    rivalled = {one.effect: one for one in found.causes if one.rival is not None}
    if not rivalled:
        return diagnosis
    references = experiments.references([segment.record for segment in found.data.fitted])
    noise = float(np.sqrt(np.mean([segment.whitening.output_variance for segment in found.data.fitted])))

    def tell_apart(cause: Cause, one: AcceptedCause) -> Cause:
        assert one.rival is not None
        controller = experiments.controller or default_speed_controller(one.after)
        proposal = design_discriminating_experiment(one.after, one.rival, one.twins[1], references, controller, noise)
        return replace(cause, separation=proposal)

    causes = (tell_apart(c, rivalled[c.effect]) if c.effect in rivalled else c for c in diagnosis.causes)
    return replace(diagnosis, causes=tuple(causes))


def design_discriminating_experiment(
    one: RefittedModel,
    other: RefittedModel,
    effect: str,
    references: Mapping[str, Reference],
    controller: Controller,
    noise: float,
) -> Separation | None:
    """The experiment on which two models differ most. references : by the text of their excite block; noise : standard
    deviation of the output. None where no experiment would tell the models apart, and where they cannot be run on any,
    as where one reads a companion: how that would move, nobody knows.
    """
    if one.joint.reads_companions or other.joint.reads_companions:
        return None
    found = []
    for block, reference in references.items():
        ratio = _difference(one, other, reference, controller, noise)
        if ratio is not None and ratio**2 * len(reference) >= VERDICT.telling:
            found.append(Separation(effect, block, ratio))
    return max(found, key=lambda s: s.ratio, default=None)


def default_speed_controller(model: RefittedModel) -> Controller:
    """A speed loop for a joint whose own is not known."""
    joint = model.joint
    _, mass = joint.slopes(np.zeros((joint.nx, 1)), np.ones((joint.masses, 1)), np.zeros(1), model.parameters.values)
    along = np.array([1.0, joint.ratio, joint.ratio])[: joint.masses]
    kp = VERDICT.speed_bandwidth * float(along @ mass[:, :, 0] @ along)
    return Controller("speed", kp, kp * VERDICT.speed_bandwidth / 4)


def _difference(
    one: RefittedModel, other: RefittedModel, reference: Reference, controller: Controller, noise: float
) -> float | None:
    """RMS error of the second model on what the first one does under the controller, over the noise."""
    try:
        return _error(other, _played(one, reference, controller)) / noise
    except NumericsError:
        return None


def _played(model: RefittedModel, reference: Reference, controller: Controller) -> Record:
    """The record that a model would make of an experiment, without noise."""
    joint = assemble(model.structure, angle=True)
    x, torque = ControlledJoint(joint, model.parameters.values, controller).follow(reference)
    phi_m, dphi_m = x[joint.motor_states]
    return Record(reference.name, "validate", "both", reference.sampling_time, torque, phi_m, dphi_m)


def _error(model: RefittedModel, record: Record) -> float:
    fixed = model.parameters.all_fixed
    problem = OutputError(model.joint, fixed, (record,), model.output, np.ones(1), max_failed_windows=REFIT.patience)
    options = SolveOptions(REFIT.max_validation_iterations, REFIT.validation_tolerance)
    found = solve(problem, problem.start(), options)
    residual: Array = found.evaluation.residuals[0]
    return float(np.sqrt(np.mean(residual**2)))
