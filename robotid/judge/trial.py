"""A model on trial: refitted as a whole through the whitening of its records, and measured on those held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate.least_squares import Solution, solve
from robotid.estimate.residual import Evaluation, OutputError, observed
from robotid.judge.simulated import measured
from robotid.judge.whitening import Whitening
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.structure import Structure
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Quantity, Record
from robotid.simulate.assemble import assemble
from robotid.simulate.simulate import Trajectory

UNIDENTIFIABLE = 1e-9  # smallest singular value of the scaled Jacobian
PATIENCE = 20  # windows in which LSODA may help
MOST_ITERATIONS, TOLERANCE = 12, 1e-5
MOST_ITERATIONS_HELD, TOLERANCE_HELD = 8, 1e-4


FirstState = Mapping[str, float]
"""A first state by the names of the states."""


@dataclass(frozen=True, slots=True, eq=False)
class Bench:
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
class Trial:
    """A structure refitted on a bench.

    energy, held_energy : of the whitened residuals on fitted and held-out records, in noise variances; trajectories,
    residuals (n,) : on the fitted records, held_* on the others; fit_percent : of the held-out records.
    """

    structure: Structure
    parameters: Parameters
    problem: OutputError
    solution: Solution
    energy: float
    held_energy: float
    trajectories: tuple[Trajectory, ...]
    residuals: tuple[Array, ...]
    held_trajectories: tuple[Trajectory, ...]
    held_residuals: tuple[Array, ...]
    held_fit: Array

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

    @property
    def first_states(self) -> tuple[FirstState, ...]:
        """Of the fitted records."""
        return tuple(map(first_state, self.trajectories))


def first_state(trajectory: Trajectory) -> FirstState:
    """Where a trajectory starts."""
    return dict(zip(trajectory.joint.state_names, trajectory.x[:, 0].tolist(), strict=True))


def try_model(
    structure: Structure,
    starts: Sequence[Parameters],
    bench: Bench,
    states: Sequence[FirstState] = (),
    *,
    enough: float = 0.0,
) -> Trial:
    """Refit all free parameters from the best of `starts`, the boldest first, or the first whose energy is low enough.
    states : guesses of the first state of each fitted record.

    Raises NumericsError where the model cannot be simulated.
    """
    return try_joint(assemble(structure, angle=bench.output == "position"), starts, bench, states, enough=enough)


def try_joint(
    joint: Joint,
    starts: Sequence[Parameters],
    bench: Bench,
    states: Sequence[FirstState] = (),
    *,
    enough: float = 0.0,
    patience: int = PATIENCE,
    most: int = MOST_ITERATIONS,
) -> Trial:
    """The same for a joint as it is. patience : windows of a record in which LSODA may help; most : iterations."""
    problem, at = _problem(joint, starts, bench, states, enough, patience)
    solution = solve(problem, at.unknowns, most=most, tolerance=TOLERANCE, known=at)
    start = problem.parameters
    parameters = start.with_values(problem.theta(solution.evaluation.unknowns))
    trajectories = solution.evaluation.trajectories
    residuals = _residuals(trajectories, bench.fitted, bench.output)
    held = _hold_out(problem, parameters, bench)
    return Trial(
        joint.structure,
        parameters,
        problem,
        solution,
        2.0 * solution.evaluation.cost,
        2.0 * sum(e.cost for e in held),
        trajectories,
        residuals,
        tuple(e.trajectories[0] for e in held),
        _residuals([e.trajectories[0] for e in held], bench.held, bench.output),
        np.array(
            [
                fit_percent(measured(record, bench.output), observed(e.trajectories[0], bench.output))
                for e, record in zip(held, bench.held, strict=True)
            ]
        ),
    )


def _problem(
    joint: Joint,
    starts: Sequence[Parameters],
    bench: Bench,
    states: Sequence[FirstState],
    enough: float,
    patience: int,
) -> tuple[OutputError, Evaluation]:
    """The problem at the start of least cost. Raises NumericsError where none can be simulated."""
    weights, best = np.ones(len(bench.fitted)), list[tuple[OutputError, Evaluation]]()
    for k, start in enumerate(starts):
        one = OutputError(
            joint, start, bench.fitted, bench.output, weights, bench.estimate_states, bench.whiten, patience
        )
        try:
            at = one.evaluate(np.clip(_unknowns(one, states), *one.bounds()))
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


def _unknowns(problem: OutputError, states: Sequence[FirstState]) -> Array:
    """Where the iteration starts: the problem's parameters, and first states as far as they are known."""
    unknowns = problem.start()
    for k, known in enumerate(states):
        for i, row in enumerate(problem.free_states, start=len(problem.columns) + k * len(problem.free_states)):
            unknowns[i] = known.get(problem.joint.state_names[row], unknowns[i])
    return unknowns


def _residuals(trajectories: Sequence[Trajectory], records: Sequence[Record], output: Quantity) -> tuple[Array, ...]:
    return tuple(measured(r, output) - observed(t, output) for t, r in zip(trajectories, records, strict=True))


def _hold_out(problem: OutputError, parameters: Parameters, bench: Bench) -> tuple[Evaluation, ...]:
    """Each held-out record with the parameters held and its own first states."""
    held = replace(parameters, free=np.zeros(len(parameters.names), dtype=bool))
    found = []
    for record, whiten in zip(bench.held, bench.whiten_held, strict=True):
        one = OutputError(
            problem.joint, held, (record,), bench.output, np.ones(1), bench.estimate_states, (whiten,), problem.patience
        )
        if one.free_states:
            found.append(solve(one, one.start(), most=MOST_ITERATIONS_HELD, tolerance=TOLERANCE_HELD).evaluation)
        else:
            found.append(one.evaluate(one.start()))
    return tuple(found)


def extended(trial: Trial, effect: str, values: Mapping[str, float]) -> tuple[Structure, Parameters]:
    """The structure with one effect more, and where its refit starts: the trial's values, the effect's as given."""
    structure = trial.structure.extended(effect)
    return structure, carried(trial.parameters, structure, values)


def reduced(trial: Trial, effect: str) -> tuple[Structure, Parameters]:
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
