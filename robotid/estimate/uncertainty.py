"""How sure the estimates of an output-error fit are.

The classical covariance takes the residual for white. The robust one is that of the noises that make the residual:
where these pass through the motion, and how large they are, is what `noise` finds.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.estimate.covariance import coloured_information, impulse_response, sandwich
from robotid.estimate.least_squares import Solution
from robotid.estimate.noise.averages import expected_levels, likely_levels
from robotid.estimate.noise.floor import torque_floor
from robotid.estimate.noise.information import SeenDerivatives, is_explained, upper_envelope
from robotid.estimate.noise.levels import fit_levels, of_all, telling_of, whitened
from robotid.estimate.noise.lines import Residual
from robotid.estimate.noise.passage import TorquePassage, passed_noise
from robotid.estimate.noise.response import TorqueResponse, torque_response
from robotid.estimate.noise.reversals import reversal_columns
from robotid.estimate.noise.settings import LevelSettings
from robotid.estimate.noise.whitening import NoiseLevels, innovations_filter
from robotid.estimate.residual import Evaluation, OutputError, measured_output
from robotid.estimate.spans import Spans
from robotid.interrupt import check
from robotid.model.array import Array, Index
from robotid.signals.derivation import Derivation
from robotid.simulation.trajectory import Trajectory

INVOLVED = 0.1  # component of an unidentifiable direction from which a parameter is named
ROUNDING = 1e-14  # of a signal's RMS: no simulation is closer to it than that
UNIDENTIFIABLE = 1e-7  # smallest singular value, relative to the largest, of the Jacobian with unit columns
ROUGHLY = LevelSettings(sweeps=1, unlikely=np.inf)
"""For the noise of a filter that only has to make a residual nearly white."""


def covariances(problem: OutputError, solution: Solution, sigma: Array) -> tuple[Array, Array, dict[int, str]]:
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
    inverse, unseen = _inverse(information)
    weak = _unidentifiable(unseen, [problem.joint.names[c] for c in problem.columns])
    columns = np.ix_(list(problem.columns), list(problem.columns))
    classical, robust = np.zeros((2, len(problem.joint.names), len(problem.joint.names)))
    classical[columns] = inverse[:count, :count]
    robust[columns] = sandwich(inverse[:count], middle)
    return classical, robust, {problem.columns[k]: text for k, text in weak.items()}


def _inverse(information: Array) -> tuple[Array, Array]:
    """The inverse of an information (m, m) in the directions that it tells of, and the other directions (m, k), scaled.

    The scale of an unknown of which nothing shows, as of a first state where the motor rests, is infinite: divided by
    next to nothing, what rounding makes of it would be all there is.
    """
    own = np.diag(information)
    scale = np.sqrt(np.where(own > 0.0, own, np.inf))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    seen = values > UNIDENTIFIABLE**2 * values[-1]
    return (vectors[:, seen] / values[seen]) @ vectors[:, seen].T / np.outer(scale, scale), vectors[:, ~seen]


@dataclass(frozen=True, slots=True, eq=False)
class _RecordDerivatives:
    """What covariances need of one record.

    residual (n,) : unweighted; unknowns (m,) : numbers of those that concern it; squared (m, m) : J J' of the
    derivatives over the standard deviation of the residual; sampled : parts of the record that tell of its noise, with
    their derivatives; whole : all of them, None of a long record, whose derivatives are worked out again span by span.
    """

    spans: Spans
    trajectory: Trajectory
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
        return cls(spans, at.trajectories[k], residual, unknowns, squared, tuple(sampled), whole)

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
    parts = [_seen(problem, theta, k, one) for k, one in enumerate(records)]
    every = [part for of_record in parts for part in of_record.residuals]
    seen = [every[k] for k in telling_of(every)]
    likeliest = fit_levels(seen)
    found = [np.zeros_like(one.squared) for one in records]
    by = whitened(seen, likeliest)
    explained = all(
        is_explained(part, level, innovations=own) for part, level, own in zip(seen, likeliest, by, strict=True)
    )
    likely = [
        (share, _of_records(of_all(every, expected_levels(seen, one, by)), records))
        for share, one in likely_levels(seen, likeliest, by)
    ]
    for k, (one, square) in enumerate(zip(records, problem.weights**2, strict=True)):
        for at, values in one.derivatives():
            check()
            shown = SeenDerivatives.of(values, parts[k].response, parts[k].passage.part(at))
            as_noise = np.asarray(np.sum([s * shown.information(levels[k]) for s, levels in likely], axis=0))
            if explained:
                found[k] += square * as_noise
                continue
            h = parts[k].response.sampling_time
            joint = problem.joint.along(problem.records[k])
            impulse = impulse_response(joint, theta, problem.row, h, at.stop - at.start)
            as_shown = coloured_information(values, one.residual[at], impulse)
            found[k] += square * upper_envelope(as_noise, as_shown)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    """What a record shows of its noise: how the torque's passes, and the residuals of the parts that tell of it."""

    response: TorqueResponse
    passage: TorquePassage
    residuals: tuple[Residual, ...]


def _seen(problem: OutputError, theta: Array, k: int, one: _RecordDerivatives) -> _Seen:
    """theta : (p,) parameters of the problem."""
    record = problem.records[k]
    own, derivation = problem.joint.in_record(theta, record.name), Derivation.of(record)
    response = torque_response(problem.joint.along(record), own, record.sampling_time, problem.output, derivation)
    passage = TorquePassage.of(one.trajectory, problem.output, derived=response.derivation is not None)
    passage = passage.kept() if one.whole is not None else passage  # the information is asked of the same steps
    floor, found = torque_floor(record.tau_m, record.dphi_m), []
    for at, derivatives in one.sampled:
        taken = np.concatenate([derivatives, reversal_columns(record, one.trajectory, response, at)])
        part = Residual(one.residual[at], response, taken, most_torque=floor)
        (roughly,) = fit_levels([part], ROUGHLY)
        passed = passed_noise(part, innovations_filter(response, roughly), passage.part(at))
        found.append(replace(part, passed=passed))
    return _Seen(response, passage, tuple(found))


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


def deviations_from_none(apart: Array, covariance: Array) -> float:
    """How many standard deviations parameters (k,) are away from where they vanish, all together. apart : their
    distances; covariance : (k, k)."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    standard = apart / scale
    distance = float(standard @ np.linalg.pinv(covariance / np.outer(scale, scale)) @ standard)
    return float(np.sqrt(max(0.0, distance)))


def deviations_with_shape(
    apart: Array, covariance: Array, robust: Array, sizes: Sequence[int], shape: Sequence[int]
) -> tuple[float, float]:
    """How many robust standard deviations an effect's sizes (k,) are away from where they vanish beside its shape, and
    how many in the shape that was found, if that tells more. The other arguments are those of `in_their_shape`."""
    beside = deviations_from_none(apart, robust[np.ix_(sizes, sizes)])
    return beside, max(beside, deviations_from_none(apart, in_their_shape(covariance, robust, sizes, shape)))


def in_their_shape(covariance: Array, robust: Array, sizes: Sequence[int], shape: Sequence[int]) -> Array:
    """Robust covariance (k, k) of parameters `sizes` with the parameters `shape` where they were found: where an effect
    is as good as nothing its shape may be anything, and is not what its size is uncertain by.

    covariance, robust : (p, p) of all parameters, as white noise would have it, and robust; sizes, shape : numbers of
    parameters.
    """
    scale = np.sqrt(np.maximum(np.diag(covariance)[list(shape)], 1e-300))
    known = covariance[np.ix_(shape, shape)] / np.outer(scale, scale)
    along = covariance[np.ix_(sizes, shape)] / scale @ np.linalg.pinv(known, hermitian=True) / scale
    way = np.concatenate([np.eye(len(sizes)), -along], axis=1)
    at = [*sizes, *shape]
    return np.asarray(way @ robust[np.ix_(at, at)] @ way.T)
