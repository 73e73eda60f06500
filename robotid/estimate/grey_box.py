"""The third step: nonlinear grey-box identification of everything in the time domain (section 4.3 of the paper)."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate import lifted
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.residual import Evaluation, OutputError, measured_output, observed
from robotid.estimate.result import End, Estimate, FitResult
from robotid.estimate.separately import in_a_row, solve_by_pieces
from robotid.estimate.uncertainty import covariances
from robotid.interrupt import INTERRUPTS, winding_up
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.progress import Iteration
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Quantity, Record

SEED = 0  # of further starts: the same every time
START_SPREAD = 0.5  # standard deviation of the logarithm of their parameters: most within a factor of three
ALIKE = 0.1  # relative spread of the records' noise levels that is not worth another fit
MIN_NOISE = 1e-3  # of the largest noise level: lest a record without noise outweighs all others
HOPELESS = 1e10  # cost over that of no motion at all, beyond which a simulation has nothing to do with its record


@dataclass(frozen=True, slots=True)
class FitOptions:
    """How to fit.

    tolerance : of the cost, relative, as of `SolveOptions`. weights : record name to a factor on the weight that its
    noise gives it. estimate_states : whether first states are estimated or taken as measured. multistart : further
    starts, drawn at random. other_starts : values from which the fit starts where they suit the records better.
    horizon [s] : length of the pieces that are simulated from initial states of their own, None for the whole record.
    choose_horizon : `fit_and_scrutinise` chooses the pieces before it fits, where an open simulation is unstable.
    interruptible : an interrupt from the keyboard ends the fit with the last iterate, not the program. deviations : the
    covariances of the estimates are worked out, which may take longer than the fit; else they are nan.
    """

    output: Quantity = "speed"
    max_iterations: int = 50
    tolerance: float = 1e-6
    weights: Mapping[str, float] = field(default_factory=dict)
    estimate_states: bool = True
    multistart: int = 0
    horizon: float | None = None
    interruptible: bool = False
    other_starts: tuple[Parameters, ...] = ()
    choose_horizon: bool = False
    deviations: bool = True


def fit_model(
    name: str,
    joint: Joint,
    parameters: Parameters,
    records: Sequence[Record],
    options: FitOptions,
    log: Callable[[Iteration], None] | None = None,
) -> FitResult:
    """Fit one joint to a combination of records, from the values of `parameters`; those that are not free stay.

    log : called after every iteration. Raises NumericsError where the records cannot be simulated from any start, and
    where the simulation is so far off that no iteration could bring it near.
    """
    begin = time.perf_counter()
    pieces = [piece for record in records for piece in record.pieces(options.horizon)]
    factors = np.array(
        [options.weights.get(piece.name, options.weights.get(piece.experiment, 1.0)) for piece in pieces]
    )
    problem = OutputError(joint, parameters, tuple(pieces), options.output, factors, options.estimate_states)
    log = _giving_up(problem, log)
    if options.output == "position":
        options = replace(options, other_starts=(*options.other_starts, *_by_speed(problem, options)))
    solution = _best_of(problem, options, log)
    problem, solution = _reweigh(problem, solution, factors, options, log)
    with winding_up() if solution.end is End.INTERRUPTED else nullcontext():
        return _result(name, problem, solution, time.perf_counter() - begin, deviations=options.deviations)


def _giving_up(problem: OutputError, log: Callable[[Iteration], None] | None) -> Callable[[Iteration], None]:
    """A log that ends a hopeless fit with NumericsError."""
    signals = (measured_output(record, problem.output) for record in problem.records)
    still = 0.5 * sum(float(np.sum((w * (y - y.mean())) ** 2)) for w, y in zip(problem.weights, signals, strict=True))

    def watched(one: Iteration) -> None:
        if log is not None:
            log(one)
        if one.cost > HOPELESS * still > 0.0:
            names = ", ".join(dict.fromkeys(record.name for record in problem.records))
            raise NumericsError(
                f"the simulation of {names} is wrong by {np.sqrt(one.cost / still):.0e} times the motion",
                hint="`robotid check` examines signs, units and columns; or give guesses under robot.parameters",
            )

    return watched


def _best_of(problem: OutputError, options: FitOptions, log: Callable[[Iteration], None] | None) -> Solution:
    start, columns = problem.start(), len(problem.columns)
    elsewhere = (np.append(other.values[list(problem.columns)], start[columns:]) for other in options.other_starts)
    initial = _best_start(problem, [start, *elsewhere]) if options.other_starts else None
    if initial is not None:
        start = initial.unknowns
        initial = initial if lifted.fits_in_memory(problem) else None  # a long record is rather simulated once more
    best = _solve(problem, start, options, log, initial)
    rng = np.random.default_rng(SEED)
    for _ in range(options.multistart):
        if best.end is End.INTERRUPTED:
            break
        other = start.copy()
        other[:columns] *= np.exp(START_SPREAD * rng.standard_normal(columns))
        try:
            found = _solve(problem, other, options, log)
        except NumericsError:
            continue
        except INTERRUPTS:
            if not options.interruptible:
                raise
            return replace(best, end=End.INTERRUPTED)
        better = min(best, found, key=lambda solution: solution.evaluation.cost)
        best = replace(better, end=found.end) if found.end is End.INTERRUPTED else better
    return best


def _by_speed(problem: OutputError, options: FitOptions) -> tuple[Parameters, ...]:
    """Parameters that suit the speed: an angle drifts, and its cost has hollows where the speed's has none. None where
    that leads nowhere."""
    try:
        by_speed = replace(problem, output="speed")
        found = _solve(by_speed, by_speed.start(), replace(options, interruptible=False), None)
    except NumericsError:
        return ()
    return (problem.parameters.with_values(problem.theta(found.evaluation.unknowns)),)


def _solve(
    problem: OutputError,
    start: Array,
    options: FitOptions,
    log: Callable[[Iteration], None] | None,
    initial: Evaluation | None = None,
) -> Solution:
    """The solution from a start, where that fits in memory with the first states that suit each piece best."""
    if not (lifted.fits_in_memory(problem) and in_a_row(problem)):
        return _solve_from(problem, start, options, log, initial)

    def solver(at: Evaluation | None) -> Solution:
        return _solve_from(problem, start if at is None else at.unknowns, options, log, at)

    if initial is None:
        with suppress(NumericsError):  # fit and simulation together may settle from where a simulation runs away
            initial = problem.evaluate(np.clip(start, *problem.bounds()))
    return solve_by_pieces(problem, initial, solver, interruptible=options.interruptible)


def _solve_from(
    problem: OutputError,
    start: Array,
    options: FitOptions,
    log: Callable[[Iteration], None] | None,
    initial: Evaluation | None,
) -> Solution:
    rules = SolveOptions(options.max_iterations, options.tolerance, interruptible=options.interruptible)
    if problem.output != "speed" or problem.whiten or not lifted.fits_in_memory(problem):
        # simulating at every iterate is as fast, or all that memory allows
        return solve(problem, start, rules, initial=initial, log=log)
    found = lifted.solve(problem, start, rules, initial=initial, log=log)
    if found.direct or found.end in (End.CONVERGED, End.INTERRUPTED):
        return found
    try:  # a cost with kinks: what simulating at every iterate finds may be lower
        other = solve(problem, start, rules, initial=initial, log=log)
    except NumericsError:
        return found
    except INTERRUPTS:
        if not options.interruptible:
            raise
        return replace(found, end=End.INTERRUPTED)
    better = min(found, other, key=lambda one: one.evaluation.cost)
    return replace(better, end=other.end) if other.end is End.INTERRUPTED else better


def _best_start(problem: OutputError, starts: Sequence[Array]) -> Evaluation | None:
    """The start (m,) from which the records are simulated best, None where they cannot be from any."""
    best: Evaluation | None = None
    for start in starts:
        try:
            at = problem.evaluate(np.clip(start, *problem.bounds()), max_cost=np.inf if best is None else best.cost)
        except NumericsError:
            continue
        best = at if best is None or at.cost < best.cost else best
    return best


def _reweigh(
    problem: OutputError,
    solution: Solution,
    factors: Array,
    options: FitOptions,
    log: Callable[[Iteration], None] | None,
) -> tuple[OutputError, Solution]:
    """Weigh each record by its own residual and fit once more: records of unequal noise or misfit then count alike."""
    sigma = noise_levels(problem, solution)
    if np.ptp(sigma) <= ALIKE * sigma.max() or solution.end is End.INTERRUPTED:
        return problem, solution
    weights = factors * sigma.mean() / np.maximum(sigma, MIN_NOISE * sigma.max())
    reweighed, at = replace(problem, weights=weights), solution.evaluation
    factor = weights / problem.weights
    residuals = tuple(r * f for r, f in zip(at.residuals, factor, strict=True))
    return reweighed, _solve(reweighed, at.unknowns, options, log, replace(at, residuals=residuals))


def noise_levels(problem: OutputError, solution: Solution) -> Array:
    """Standard deviation of the unweighted residual of each piece's record, in the unit of the output, (pieces,)."""
    names = [r.name for r in problem.records]
    square, spare = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
    for name, r, w in zip(names, solution.evaluation.residuals, problem.weights, strict=True):
        square[name] += float(r @ r) / w**2
        spare[name] += len(r) - len(problem.free_states) - len(problem.columns) / len(names)
    return np.array([np.sqrt(square[name] / max(1.0, spare[name])) for name in names])


def _result(name: str, problem: OutputError, solution: Solution, seconds: float, *, deviations: bool) -> FitResult:
    sigma = noise_levels(problem, solution)
    classical, robust, weak = covariances(problem, solution, sigma) if deviations else _unknown(problem)
    unknowns, trajectories = solution.evaluation.unknowns, solution.evaluation.trajectories
    theta = problem.theta(unknowns)
    names = [r.name for r in problem.records]
    measured = {n: [measured_output(r, problem.output) for r in problem.records if r.name == n] for n in names}
    simulated = {
        n: [observed(t, problem.output) for t, m in zip(trajectories, names, strict=True) if m == n] for n in names
    }
    return FitResult(
        name=name,
        records=tuple(measured),
        output=problem.output,
        structure=problem.joint.structure,
        parameters=_estimates(problem, theta, classical, robust, weak),
        covariance=classical,
        covariance_robust=robust,
        initial_states={n: problem.first_state(unknowns, names.index(n)) for n in measured},
        noise_std={n: float(sigma[names.index(n)]) for n in measured},
        fit_percent={n: fit_percent(np.concatenate(measured[n]), np.concatenate(simulated[n])) for n in measured},
        cost=np.array(solution.cost),
        iterations=len(solution.cost) - 1,
        end=solution.end,
        seconds=seconds,
        start=problem.parameters.by_name,
        keeps_angle=problem.joint.keeps_angle,
    )


def _unknown(problem: OutputError) -> tuple[Array, Array, dict[int, str]]:
    """Covariances that were not worked out."""
    p = len(problem.joint.names)
    return np.full((p, p), np.nan), np.full((p, p), np.nan), {}


def _estimates(
    problem: OutputError, theta: Array, classical: Array, robust: Array, weak: Mapping[int, str]
) -> tuple[Estimate, ...]:
    p, estimates = problem.parameters, []
    for k, name in enumerate(p.names):
        fixed = k not in problem.columns
        estimates.append(
            Estimate(
                name=name,
                value=float(theta[k]),
                unit=p.units[k],
                std=float("nan") if fixed else float(np.sqrt(classical[k, k])),
                std_robust=float("nan") if fixed else float(np.sqrt(robust[k, k])),
                lower=float(p.lower[k]),
                upper=float(p.upper[k]),
                fixed=fixed,
                remark="fixed" if fixed else weak.get(k) or _at_bound(theta[k], p.lower[k], p.upper[k]),
            )
        )
    return tuple(estimates)


def _at_bound(value: float, lower: float, upper: float) -> str:
    return "at its lower bound" if value <= lower else "at its upper bound" if value >= upper else ""
