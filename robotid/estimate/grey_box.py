"""The third step: nonlinear grey-box identification of everything in the time domain (section 4.3 of the paper)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.estimate import lifted
from robotid.estimate.covariance import coloured_information, impulse_response
from robotid.estimate.least_squares import Solution, SolveOptions, solve
from robotid.estimate.noise.information import is_explained, noise_information, upper_envelope
from robotid.estimate.noise.levels import Residual, expected_levels, fit_levels, likely_levels, torque_floor
from robotid.estimate.noise.response import torque_response
from robotid.estimate.noise.whitening import NoiseLevels
from robotid.estimate.residual import Evaluation, OutputError, measured_output, observed
from robotid.estimate.result import End, Estimate, FitResult
from robotid.estimate.spans import Spans
from robotid.interrupt import Interrupted, check, winding_up
from robotid.model.array import Array, Index
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.progress import Iteration
from robotid.signals.derivation import Derivation
from robotid.signals.metrics import fit_percent
from robotid.signals.record import Quantity, Record

INTERRUPTS = (Interrupted, KeyboardInterrupt)
SEED = 0  # of further starts: the same every time
START_SPREAD = 0.5  # standard deviation of the logarithm of their parameters: most within a factor of three
ALIKE = 0.1  # relative spread of the records' noise levels that is not worth another fit
MIN_NOISE = 1e-3  # of the largest noise level: lest a record without noise outweighs all others
INVOLVED = 0.1  # component of an unidentifiable direction from which a parameter is named
ROUNDING = 1e-14  # of a signal's RMS: no simulation is closer to it than that
HOPELESS = 1e10  # cost over that of no motion at all, beyond which a simulation has nothing to do with its record
UNIDENTIFIABLE = 1e-7  # smallest singular value, relative to the largest, of the Jacobian with unit columns


@dataclass(frozen=True, slots=True)
class FitOptions:
    """How to fit.

    tolerance : of the cost, relative, as of `SolveOptions`. weights : record name to a factor on the weight that its
    noise gives it. estimate_states : whether first states are estimated or taken as measured. multistart : further
    starts, drawn at random. other_starts : values from which the fit starts where they suit the records better.
    horizon [s] : length of the pieces that are simulated from initial states of their own, None for the whole record.
    choose_horizon : `fit_and_scrutinise` chooses the pieces before it fits, where an open simulation is unstable.
    interruptible : an interrupt from the keyboard ends the fit with the last iterate, not the program.
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
        return _result(name, problem, solution, time.perf_counter() - begin)


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


def _result(name: str, problem: OutputError, solution: Solution, seconds: float) -> FitResult:
    sigma = noise_levels(problem, solution)
    classical, robust, weak = _covariances(problem, solution, sigma)
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
        start=dict(zip(problem.parameters.names, problem.parameters.values.tolist(), strict=True)),
        keeps_angle=problem.joint.keeps_angle,
    )


def _covariances(problem: OutputError, solution: Solution, sigma: Array) -> tuple[Array, Array, dict[int, str]]:
    """Classical and robust covariance of all parameters (p, p) each, zero where fixed, and what is unidentifiable."""
    m, count = len(solution.evaluation.unknowns), len(problem.columns)
    information, middle = np.zeros((m, m)), np.zeros((m, m))
    theta = problem.theta(solution.evaluation.unknowns)
    # residuals of nothing but rounding have that as their noise
    sigma = np.maximum(sigma, [_rounding(measured_output(r, problem.output)) for r in problem.records])
    deviations = sigma * problem.weights
    records = [_RecordDerivatives.of(problem, solution.evaluation, k, sd) for k, sd in enumerate(deviations)]
    middles = _noise_information(problem, theta, records)
    for one, sd, own in zip(records, deviations, middles, strict=True):
        block = np.ix_(one.unknowns, one.unknowns)
        information[block] += one.squared
        middle[block] += own / sd**4
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    seen = values > UNIDENTIFIABLE**2 * values[-1]
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T / np.outer(scale, scale)
    weak = _unidentifiable(vectors[:, ~seen], [problem.joint.names[c] for c in problem.columns])
    columns = np.ix_(list(problem.columns), list(problem.columns))
    classical, robust = np.zeros((2, len(problem.joint.names), len(problem.joint.names)))
    classical[columns] = inverse[:count, :count]
    robust[columns] = (inverse @ middle @ inverse)[:count, :count]
    return classical, robust, {problem.columns[k]: text for k, text in weak.items()}


@dataclass(frozen=True, slots=True, eq=False)
class _RecordDerivatives:
    """What covariances need of one record.

    residual (n,) : unweighted; unknowns (m,) : numbers of those that concern it; squared (m, m) : J J' of the
    derivatives over the standard deviation of the residual; sampled : parts of the record that tell of its noise, with
    their derivatives; whole : all of them, None of a long record, whose derivatives are worked out again span by span.
    """

    spans: Spans
    residual: Array
    unknowns: Index
    squared: Array
    sampled: tuple[tuple[slice, Array], ...]
    whole: Array | None

    @classmethod
    def of(cls, problem: OutputError, at: Evaluation, k: int, deviation: float) -> _RecordDerivatives:
        """deviation : standard deviation of the weighted residual."""
        spans = Spans.of(problem, at, k)
        unknowns, residual = problem.unknowns_of(k), at.residuals[k] / problem.weights[k]
        parts = {part.start: part for part in spans.sampled()}
        squared, sampled, values = np.zeros((len(unknowns), len(unknowns))), [], np.zeros((len(unknowns), 0))
        for span, values in spans.derivatives():
            check()
            scaled = values / deviation
            squared += scaled @ scaled.T
            if span.start in parts:
                part = parts[span.start]
                sampled.append((part, values if part == span else values[:, : part.stop - part.start].copy()))
        whole = values if len(spans.cuts) == 1 else None
        return cls(spans, residual, unknowns, squared, tuple(sampled), whole)

    def derivatives(self) -> Iterator[tuple[slice, Array]]:
        """Each span with its weighted derivatives, (m, its samples)."""
        if self.whole is None:
            yield from self.spans.derivatives()
        else:
            yield self.spans.cuts[0], self.whole


def _noise_information(problem: OutputError, theta: Array, records: Sequence[_RecordDerivatives]) -> list[Array]:
    """J R J' of every record, weighted by its square, R the covariance of its residual.

    By the noises of output and torque where these explain the residual, averaged over what they may be. Else an
    autoregression besides counts, too, in every direction the larger: what is not explained makes no interval shorter.
    """
    least = [_rounding(measured_output(record, problem.output)) for record in problem.records]
    if all(np.abs(one.residual).max() <= level for one, level in zip(records, least, strict=True)):
        return [np.zeros_like(one.squared) for one in records]
    seen, responses = [], []
    for record, one in zip(problem.records, records, strict=True):
        own = problem.joint.in_record(theta, record.name)
        joint, derivation = problem.joint.along(record), Derivation.of(record)
        responses.append(torque_response(joint, own, record.sampling_time, problem.output, derivation))
        floor = torque_floor(record.tau_m, record.dphi_m)
        seen += [Residual(one.residual[at], responses[-1], J, most_torque=floor) for at, J in one.sampled]
    likeliest = fit_levels(seen)
    found = [np.zeros_like(one.squared) for one in records]
    explained = all(is_explained(part, level) for part, level in zip(seen, likeliest, strict=True))
    likely = [(s, _of_records(expected_levels(seen, one), records)) for s, one in likely_levels(seen, likeliest)]
    for k, (one, square) in enumerate(zip(records, problem.weights**2, strict=True)):
        for at, values in one.derivatives():
            check()
            parts = [share * noise_information(values, responses[k], levels[k]) for share, levels in likely]
            as_noise = np.asarray(np.sum(parts, axis=0))
            if explained:
                found[k] += square * as_noise
                continue
            h = responses[k].sampling_time
            joint = problem.joint.along(problem.records[k])
            impulse = impulse_response(joint, theta, problem.row, h, at.stop - at.start)
            as_shown = coloured_information(values, one.residual[at], impulse)
            found[k] += square * upper_envelope(as_noise, as_shown)
    return found


def _of_records(levels: Sequence[NoiseLevels], records: Sequence[_RecordDerivatives]) -> list[NoiseLevels]:
    """Levels of records from those of their sampled parts, which have the torque's noise in common."""
    found, left = [], list(levels)
    for one in records:
        own, left = left[: len(one.sampled)], left[len(one.sampled) :]
        found.append(own[0] if len(own) == 1 else replace(own[0], output=float(np.mean([part.output for part in own]))))
    return found


def _rounding(signal: Array) -> float:
    """What no simulation of a signal (n,) comes closer to it than."""
    return ROUNDING * (float(np.sqrt(np.mean(signal**2))) or 1.0)


def _unidentifiable(directions: Array, names: Sequence[str]) -> dict[int, str]:
    """Unidentifiable directions (m, k) by name: unknown k to a remark. Of several it is their plane that counts, not
    which directions happen to span it."""
    remarks: dict[int, str] = {}
    shared = np.abs(directions @ directions.T) > INVOLVED**2
    for k in (k for k in range(len(names)) if shared[k, k]):
        others = [name for j, name in enumerate(names) if j != k and shared[j, j] and shared[k, j]]
        remarks[k] = "unidentifiable" + (f" together with {', '.join(others)}" if others else " on these records")
    return remarks


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
