"""The refit: all free parameters and first states of a model, through the whitening of its records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.evaluation_data import EvaluationData
from robotid.diagnosis.refit.refitted_model import UNKNOWN, RefittedModel, Trajectories, Unknowns, segment_fit
from robotid.diagnosis.refit.settings import REFIT
from robotid.errors import NumericsError
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.lifted.coarse import coarse_factor, coarse_nodes, coarsened, refined
from robotid.estimate.residual import Evaluation, OutputError
from robotid.estimate.sensing import joint_for
from robotid.estimate.separately import solve_by_pieces, solve_in_a_row
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.parallel import each
from robotid.signals.record import Record
from robotid.simulation.first_guess import measured_guess
from robotid.simulation.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class RefitOptions:
    """How far a refit goes.

    start_below : energy of a start that is low enough, so that no other start is tried. reject_above : energy that a
    refit must undercut. careful : the closer to the minimum the less misfit is left, and however many windows fail to
    settle, as the model that is diagnosed deserves. patience : windows that may fail to settle all the same, None where
    the settings of all refits will do; max_iterations : of the fit, likewise.
    """

    start_below: float = 0.0
    reject_above: float = np.inf
    careful: bool = False
    patience: int | None = None
    max_iterations: int | None = None

    @property
    def max_failed_windows(self) -> int | None:
        """As of `simulate`, None for any number."""
        usual = None if self.careful else REFIT.patience
        return usual if self.patience is None else self.patience


class NoBetter(NumericsError):
    """A model can be simulated and fitted, and explains no more than without."""


QUICK = RefitOptions()
CAREFUL = RefitOptions(careful=True)
CONFIRMING = RefitOptions(careful=True, patience=REFIT.patience)
"""As exact, for a model that may turn out to be none."""
AS_IT_IS = RefitOptions(careful=True, max_iterations=0)
"""Nothing is fitted: the model as it starts."""


def refit(
    model: Structure | Joint,
    starts: Sequence[Parameters],
    data: EvaluationData,
    near: Trajectories = UNKNOWN,
    options: RefitOptions = QUICK,
) -> RefittedModel:
    """Refit all free parameters from the best of `starts`, the boldest first, or the first that is low enough.

    near : trajectories of the same segments by a model nearby. Raises NumericsError where the model cannot be
    simulated, or its energy is not below what the options ask for.
    """
    records = [segment.record for segment in data.fitted]
    joint = model if isinstance(model, Joint) else joint_for(model, data.output, records)
    rough = None if options.careful else _by_fewer_samples(joint, starts, data, near.fitted, options)
    problem, at = rough or _best_start(joint, starts, data, near.fitted, options)
    effort = solve_effort(data.samples, 2.0 * at.cost, options)

    def solver(begun: Evaluation | None) -> Solution:
        begun = at if begun is None else begun
        return solve(problem, begun.unknowns, effort, initial=begun)

    solution = solve_by_pieces(problem, at, solver)
    end = solution.evaluation
    if 2.0 * end.cost >= options.reject_above:
        raise NoBetter("the fit is no better than without")
    parameters = problem.parameters.with_values(problem.theta(end.unknowns))
    fitted = zip(data.fitted, end.trajectories, strict=True)
    validated = zip(data.validation, _validate(problem, parameters, data, near.validation), strict=True)
    return RefittedModel(
        joint=joint,
        parameters=parameters,
        unknowns=unknowns_of(problem),
        factor=solution.factor,
        fitted=tuple(segment_fit(segment, t, data.output) for segment, t in fitted),
        validation=tuple(segment_fit(segment, t, data.output) for segment, t in validated),
    )


def refit_to_confirm(
    structure: Structure, start: Parameters, data: EvaluationData, near: Trajectories
) -> RefittedModel | None:
    """A model that may turn out to be none, refitted from given values; None where it cannot be simulated. near : as of
    `refit`."""
    try:
        return refit(structure, [start], data, near, CONFIRMING)
    except NumericsError:
        return None


def unknowns_of(problem: OutputError) -> Unknowns:
    """What a fit of this problem shapes."""
    return Unknowns(problem.output, problem.columns, problem.free_states)


def solve_effort(samples: int, energy: float, options: RefitOptions) -> SolveOptions:
    """When a fit ends that starts at this energy: a misfit hides what finer steps would gain."""
    asked = options.max_iterations
    most, further = (REFIT.max_iterations, REFIT.further_iterations) if asked is None else (asked, 0)
    effort = SolveOptions(most, REFIT.careful_tolerance, steady=REFIT.steady, further=further)
    misfit = max(0.0, 1.0 - samples / max(energy, 1e-300))
    if options.careful and misfit < REFIT.little_misfit:
        return effort
    tolerance = max(REFIT.tolerance, REFIT.misfit_tolerance * misfit)
    return replace(effort, tolerance=tolerance, max_small_steps=1)


Begun = tuple[OutputError, Evaluation]
"""A problem, and its evaluation where a fit starts."""


def _by_fewer_samples(
    joint: Joint, starts: Sequence[Parameters], data: EvaluationData, near: Sequence[Trajectory], options: RefitOptions
) -> Begun | None:
    """The problem where the same fit on every k-th sample ends, by white noise: the first iterations cost a k-th.

    None where so few samples do not show the motion, or where all of them refute the end.
    """
    fine = _problem(joint, starts[0], data.fitted, data, options.max_failed_windows)
    plain = replace(fine, weights=np.array([s.whitening.output_variance**-0.5 for s in data.fitted]), whiten=())
    factor = coarse_factor(plain) if len(near) == len(data.fitted) else 1
    if factor == 1:
        return None
    rough = replace(coarsened(plain, factor), max_failed_windows=0)  # else it is dear, and the motion does not show
    known = [replace(t, x=t.x[:, coarse_nodes(t.x.shape[1], factor)]) for t in near]
    try:
        problem, at = _best_begin(
            [replace(rough, parameters=start) for start in starts], known, replace(options, start_below=0.0)
        )
        end = solve(problem, at.unknowns, solve_effort(data.samples, 2.0 * at.cost, options), initial=at).evaluation
        nodes = [refined(t.x, factor, len(record)) for t, record in zip(end.trajectories, fine.records, strict=True)]
        begun = fine.evaluate(end.unknowns, guesses=nodes, max_cost=0.5 * options.reject_above)
    except NumericsError:
        return None
    found = problem.parameters.with_values(problem.theta(end.unknowns))
    return (replace(fine, parameters=found), begun) if 2.0 * begun.cost < options.reject_above else None


def _best_start(
    joint: Joint, starts: Sequence[Parameters], data: EvaluationData, near: Sequence[Trajectory], options: RefitOptions
) -> Begun:
    """The problem at the start of least cost. Raises NumericsError where none can be simulated."""
    return _best_begin(
        [_problem(joint, s, data.fitted, data, options.max_failed_windows) for s in starts], near, options
    )


def _best_begin(problems: Sequence[OutputError], near: Sequence[Trajectory], options: RefitOptions) -> Begun:
    """The problem whose own start has the least cost, the boldest first. Raises NumericsError where none can be
    simulated."""
    enough, left = options.start_below, list(problems)
    best: Begun | None = None
    while left:
        problem = left.pop(0)
        most = 0.5 * REFIT.hopeless_start * enough or np.inf
        try:
            at = _begin(problem, near, most if best is None else best[1].cost)
            if best is None and len(at.residuals) < len(problem.records):
                raise NumericsError("the start is far from the records")
        except NumericsError:
            if best is None:
                if not left:
                    raise
                del left[:-1]  # where the boldest leads astray, only the most cautious is likely not to
            continue
        if best is not None and at.cost >= best[1].cost:
            break
        best = (problem, at)
        if 2.0 * at.cost <= enough:
            break
    assert best is not None
    return best


def _problem(
    joint: Joint, parameters: Parameters, segments: Sequence[Segment], data: EvaluationData, patience: int | None
) -> OutputError:
    records, filters = tuple(s.record for s in segments), tuple(s.whitening for s in segments)
    weights = np.ones(len(records))
    return OutputError(joint, parameters, records, data.output, weights, data.estimate_states, filters, patience)


def _begin(problem: OutputError, near: Sequence[Trajectory], most: float = np.inf) -> Evaluation:
    """A problem where its iteration starts: at its parameters, and at trajectories nearby as far as these are known.

    most : cost that is of interest, as of `OutputError.evaluate`.
    """
    unknowns, own = problem.start(), len(problem.free_states)
    guesses = []
    for k, (record, known) in enumerate(zip(problem.records, near, strict=False)):
        guess = _guess(problem.joint, problem.parameters.values, record, known)
        guesses.append(guess)
        first = len(problem.columns) + k * own
        unknowns[first : first + own] = guess[list(problem.free_states), 0]
    return problem.evaluate(np.clip(unknowns, *problem.bounds()), guesses=guesses, max_cost=most)


def _guess(joint: Joint, theta: Array, record: Record, known: Trajectory) -> Array:
    """States (nx, n) of a joint as far as another's trajectory has them, the others as measured."""
    guess = measured_guess(joint, joint.in_record(theta, record.name), record)
    row = {name: i for i, name in enumerate(known.joint.state_names)}
    for i, name in enumerate(joint.state_names):
        if name in row:
            guess[i] = known.x[row[name]]
    return guess


def _validate(
    problem: OutputError, parameters: Parameters, data: EvaluationData, near: Sequence[Trajectory]
) -> list[Trajectory]:
    """The validation segments with the parameters fixed, each from the first states that suit it best."""
    alone = replace(problem, parameters=parameters.all_fixed, records=(), weights=np.ones(1), whiten=())
    begun = [(segment, near[k : k + 1]) for k, segment in enumerate(data.validation)]
    items = [list(own) for _, own in groupby(begun, lambda one: one[0].record.name)]
    samples = data.validation_samples // max(1, len(items))
    return [one for found in each(_validated, alone, items, samples=samples) for one in found]


def _validated(alone: OutputError, items: Sequence[tuple[Segment, Sequence[Trajectory]]]) -> list[Trajectory]:
    """The validation segments of one record. alone : the problem without records."""
    problems = [replace(alone, records=(segment.record,), whiten=(segment.whitening,)) for segment, _ in items]
    effort = SolveOptions(REFIT.max_validation_iterations, REFIT.validation_tolerance, max_small_steps=1)
    begun = [_begin(one, near) for one, (_, near) in zip(problems, items, strict=True)]
    return [one.evaluation.trajectories[0] for one in solve_in_a_row(problems, begun, effort)]
