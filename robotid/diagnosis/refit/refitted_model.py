"""A model on trial: refitted as a whole through the whitening of its records, and measured on those held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.noise.whitening import Whitening
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import SimulatedSegment, simulated_segment
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError, measured_output, observed
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Quantity, Record
from robotid.simulation.first_guess import measured_guess
from robotid.simulation.trajectory import Trajectory

UNIDENTIFIABLE = 1e-9  # smallest singular value of the scaled Jacobian
PATIENCE = 8  # windows that may fail to settle; a model near its best has three at most
MOST_ITERATIONS, TOLERANCE, CAREFUL = 12, 1e-4, 1e-5
WILD = 20.0  # times the energy that is low enough: a start that leaves more is none
CLOSE = 3e-3  # of the misfit: a step that gains less is not worth it while there is so much of it
LITTLE = 0.5  # of a model's energy: with less misfit its parameters are worth the finest steps
MOST_ITERATIONS_HELD, TOLERANCE_HELD = 8, 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class EvaluationData:
    """Records to be fitted and records held out (pieces of experiments), with the whitening of each. reached : all
    known effects and free curves together leave no more than the sensors' noise; errors : what they leave counts as
    torque errors, and so as noise."""

    fitted: tuple[Record, ...]
    held: tuple[Record, ...]
    whiten: tuple[Whitening, ...]
    whiten_held: tuple[Whitening, ...]
    output: Quantity
    estimate_states: bool
    reached: bool
    errors: bool

    @property
    def samples(self) -> int:
        return sum(map(len, self.fitted))


@dataclass(frozen=True, slots=True, eq=False)
class Motions:
    """Trajectories of a bench's records by a model alike, from which a fit may start; none where none are known."""

    fitted: tuple[Trajectory, ...] = ()
    held: tuple[Trajectory, ...] = ()


NOWHERE = Motions()


@dataclass(frozen=True, slots=True, eq=False)
class RefittedModel:
    """A structure refitted on a bench. motions : on its records; held_energy : of the whitened residuals on held-out
    records, in noise variances; residuals (n,) : on the fitted records; held_segments : the others; held_fit : percent
    fit of each of these."""

    parameters: Parameters
    problem: OutputError
    solution: Solution
    motions: Motions
    held_energy: float
    residuals: tuple[Array, ...]
    held_segments: tuple[SimulatedSegment, ...]
    held_fit: Array

    @property
    def structure(self) -> Structure:
        return self.problem.joint.structure

    @property
    def segments(self) -> list[SimulatedSegment]:
        """The fitted records."""
        return list(map(SimulatedSegment, self.problem.records, self.motions.fitted, self.residuals))

    @property
    def held_residuals(self) -> tuple[Array, ...]:
        """Residuals of the held-out records, (n,) each."""
        return tuple(segment.residual for segment in self.held_segments)

    @property
    def energy(self) -> float:
        """Of the whitened residuals on the fitted records, in noise variances."""
        return 2.0 * self.solution.evaluation.cost

    @property
    def held_fit_percent(self) -> float:
        """Mean fit over the held-out records [%], nan without any."""
        return float(self.held_fit.mean()) if self.held_fit.size else float("nan")

    @property
    def covariance(self) -> Array:
        """Of the unknowns, parameters first, (m, m), the noise as large as the residual shows it."""
        factor = self.solution.factor
        scale = np.maximum(np.linalg.norm(factor, axis=0), 1e-300)
        inverse = np.linalg.pinv(factor / scale, rcond=UNIDENTIFIABLE) / scale[:, None]
        return np.asarray(inverse @ inverse.T * max(1.0, self.energy / sum(map(len, self.residuals))))


def refit(
    model: Structure | Joint,
    starts: Sequence[Parameters],
    bench: EvaluationData,
    near: Motions = NOWHERE,
    *,
    enough: float = 0.0,
    below: float = np.inf,
    careful: bool = False,
    patience: int = PATIENCE,
    most: int = MOST_ITERATIONS,
) -> RefittedModel:
    """Refit all free parameters from the best of `starts`, the boldest first, or the first whose energy is low enough.
    near : motions close by; below : energy that a refit must undercut; careful : the closer to the minimum the less
    misfit is left, and however many windows fail to settle, as the model that is accused deserves; patience : as of
    `simulate`, unless careful; most : iterations.

    Raises NumericsError where the model cannot be simulated, or its energy stays above.
    """
    joint = model if isinstance(model, Joint) else assemble(model, angle=bench.output == "position")
    problem, at = _problem(joint, starts, bench, near.fitted, enough, None if careful else patience)
    misfit = max(0.0, 1.0 - bench.samples / max(2.0 * at.cost, 1e-300))
    finest = careful and misfit < LITTLE
    options = SolveOptions(most, CAREFUL) if finest else SolveOptions(most, max(TOLERANCE, CLOSE * misfit), 1)
    solution = solve(problem, at.unknowns, options, initial=at)
    if 2.0 * solution.evaluation.cost >= below:
        raise NumericsError("the fit is no better than without")
    parameters = problem.parameters.with_values(problem.theta(solution.evaluation.unknowns))
    held = _hold_out(problem, parameters, bench, near.held)
    motions = Motions(solution.evaluation.trajectories, tuple(e.trajectories[0] for e in held))
    fits = [
        fit_percent(measured_output(record, bench.output), observed(t, bench.output))
        for t, record in zip(motions.held, bench.held, strict=True)
    ]
    return RefittedModel(
        parameters,
        problem,
        solution,
        motions,
        2.0 * sum(e.cost for e in held),
        _residuals(motions.fitted, bench.fitted, bench.output),
        tuple(simulated_segment(*pair, bench.output) for pair in zip(bench.held, motions.held, strict=True)),
        np.array(fits),
    )


def _problem(
    joint: Joint,
    starts: Sequence[Parameters],
    bench: EvaluationData,
    near: Sequence[Trajectory],
    enough: float,
    patience: int | None,
) -> tuple[OutputError, Evaluation]:
    """The problem at the start of least cost. Raises NumericsError where none can be simulated."""
    weights, best = np.ones(len(bench.fitted)), list[tuple[OutputError, Evaluation]]()
    for k, start in enumerate(starts):
        one = OutputError(
            joint, start, bench.fitted, bench.output, weights, bench.estimate_states, bench.whiten, patience
        )
        try:
            at = _begin(one, near, best[0][1].cost if best else 0.5 * WILD * enough or np.inf)
            if not best and len(at.residuals) < len(bench.fitted):
                raise NumericsError("the start is far from the records")
        except NumericsError:
            if k == len(starts) - 1 and not best:
                raise
            continue
        if best and at.cost >= best[0][1].cost:
            break
        best = [(one, at)]
        if 2.0 * at.cost <= enough:
            break
    return best[0]


def _begin(problem: OutputError, near: Sequence[Trajectory], most: float = np.inf) -> Evaluation:
    """A problem where its iteration starts: at its parameters, and at motions nearby as far as these are known. most :
    cost that is of interest, as of `OutputError.evaluate`."""
    unknowns, own = problem.start(), len(problem.free_states)
    guesses = []
    for k, (record, known) in enumerate(zip(problem.records, near, strict=False)):
        guess = measured_guess(problem.joint, problem.joint.in_record(problem.parameters.values, record.name), record)
        row = {name: i for i, name in enumerate(known.joint.state_names)}
        for i, name in enumerate(problem.joint.state_names):
            if name in row:
                guess[i] = known.x[row[name]]
        guesses.append(guess)
        first = len(problem.columns) + k * own
        unknowns[first : first + own] = guess[list(problem.free_states), 0]
    return problem.evaluate(np.clip(unknowns, *problem.bounds()), guesses=guesses, max_cost=most)


def _residuals(trajectories: Sequence[Trajectory], records: Sequence[Record], output: Quantity) -> tuple[Array, ...]:
    return tuple(measured_output(r, output) - observed(t, output) for t, r in zip(trajectories, records, strict=True))


def _hold_out(
    problem: OutputError, parameters: Parameters, bench: EvaluationData, near: Sequence[Trajectory]
) -> tuple[Evaluation, ...]:
    """Each held-out record with the parameters held and its own first states."""
    alone = replace(problem, parameters=parameters.all_fixed, weights=np.ones(1))
    held = enumerate(zip(bench.held, bench.whiten_held, strict=True))
    return tuple(
        _with_first_states(replace(alone, records=(record,), whiten=(whiten,)), near[k : k + 1])
        for k, (record, whiten) in held
    )


def _with_first_states(problem: OutputError, near: Sequence[Trajectory]) -> Evaluation:
    """A record with the first states that suit it best."""
    at = _begin(problem, near)
    options = SolveOptions(MOST_ITERATIONS_HELD, TOLERANCE_HELD, max_small_steps=1)
    return solve(problem, at.unknowns, options, initial=at).evaluation


def extended(trial: RefittedModel, effect: str, values: Mapping[str, float]) -> tuple[Structure, Parameters]:
    """The structure with one effect more, and where its refit starts: the trial's values, the effect's as given."""
    structure = trial.structure.extended(effect)
    return structure, carried(trial.parameters, structure, values)


def reduced(trial: RefittedModel, effect: str) -> tuple[Structure, Parameters]:
    """The structure with one effect less, and where its refit starts."""
    structure = trial.structure.without(effect)
    return structure, carried(trial.parameters, structure, {})


def carried(old: Parameters, structure: Structure, values: Mapping[str, float]) -> Parameters:
    """Parameters of a structure alike: values, bounds and freedom of the old by name, over them `values`."""
    declared = assemble(structure).parameters()
    fresh = {k: getattr(declared, k).copy() for k in ("values", "lower", "upper", "free")}
    for k, name in enumerate(declared.names):
        if name in old.names:
            i = old.names.index(name)
            for key, array in fresh.items():
                array[k] = getattr(old, key)[i]
        if name in values:
            fresh["values"][k] = np.clip(values[name], fresh["lower"][k], fresh["upper"][k])
    return replace(declared, **fresh)
