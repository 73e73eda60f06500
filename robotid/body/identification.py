"""The body of a robot from the torques of all its axes: base parameters first, then parameters that a body can have.

The base parameters need no start and say how well the structure fits at all, and how loud and how coloured its errors
are; extrapolated to other motions they may mean impossible masses. The consistent parameters weigh the equations by
these errors, and keep near the start where the motions show nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import nan

import numpy as np
from scipy.linalg import qr

from robotid.body.base_parameters import BaseParameters, base_parameters
from robotid.body.chain import PER_LINK, Chain
from robotid.body.consistent import Consistent, LeastSquares, Start, body, is_consistent, minimise, start_weight
from robotid.body.equations import FRICTION, ROTOR, Motion, Structure, columns, stacked, unit_of
from robotid.body.regressor import own_inertia
from robotid.body.results import BaseParameter, BodyParameter, BodyResult, TorqueErrors
from robotid.errors import NumericsError
from robotid.model.array import Array
from robotid.numerals import listed, number

MAX_CONDITION = 1e3  # of base columns scaled to unit norm; beyond, errors of the friction decide the estimate
MAX_PASSES = 10  # in which the weights of the axes settle
ROWS_AN_UNKNOWN = 10  # at random motions
GYRATION = 0.5  # radius of gyration of a link that nothing is known of, in mean lengths of a link
HALVING = 0.5  # mass of such a link against the one before it
LEAST_LENGTH = 0.05  # [m] of such a link
LEAST_MASS = 1e-3  # [kg] of the first link, where the torque shows none
LEAST_GYRATION = 1e-3  # [m] of a link whose given inertia is that of no body
SEEN = 0.5  # share of the start's variance that the data must take away
SIGNIFICANT = 2.0  # standard deviations
SMALLEST = 1e-300  # [Nm] instead of a torque of zero


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What is known beforehand. rotors : inertia of a rotor behind its gear [kg m2] by axis, where it is known;
    mass_factor, given_factor : by which the mass of a link, or the inertia of a rotor, may well differ from a start
    that is a guess, and from one that is given."""

    rotors: Mapping[str, float] = field(default_factory=dict)
    mass_factor: float = 10.0
    given_factor: float = 2.0

    def weights(self, given: Sequence[bool]) -> Array:
        """Of the divergence from each start."""
        return np.array([start_weight(self.given_factor if one else self.mass_factor) for one in given])


@dataclass(frozen=True, slots=True, eq=False)
class Identified:
    """A body. chain : with the estimated inertias; result : for people; unknowns : all, in the order of `symbols`."""

    chain: Chain
    result: BodyResult
    unknowns: Array

    @property
    def links(self) -> Array:
        """Inertial parameters of all links, (10 axes,)."""
        return self.unknowns[: len(PER_LINK) * len(self.chain)]


@dataclass(frozen=True, slots=True, eq=False)
class _Errors:
    """What the base parameters leave. deviation (axes,) [Nm]; correlation (axes,) : samples that count as one."""

    deviation: Array
    correlation: Array

    @property
    def weights(self) -> Array:
        """Of the axes' equations, at which the squared misfit is in units of its variance."""
        return np.asarray(1 / (self.deviation * np.sqrt(self.correlation)))


@dataclass(frozen=True, slots=True, eq=False)
class _Regression:
    """Least squares of the base parameters. seen : positions among them that were estimated; values, covariance : of
    these; unknowns (p,) : with the picked parameters at these values and the others zero."""

    base: BaseParameters
    seen: tuple[int, ...]
    values: Array
    covariance: Array
    condition_number: float
    unknowns: Array
    errors: _Errors


def identify(
    structure: Structure, motions: Sequence[Motion], known: Knowledge, cutoff: Mapping[str, float] | None = None
) -> Identified:
    """The body that moves as recorded. motions : of all records; cutoff [Hz] : by record, for the result.

    Raises NumericsError where no record is fitted, or an axis never moves.
    """
    chain, fitted = structure.chain, [motion for motion in motions if motion.fitted]
    _require_motion(structure, fitted)
    blocks = {motion.name: columns(structure, motion) for motion in motions}
    own = [blocks[motion.name] for motion in fitted]
    regression = _regress(structure, fitted, own)
    consistent, start = _consistent(chain, fitted, own, regression.errors, known)
    links = consistent.x[: len(PER_LINK) * len(chain)].reshape(-1, len(PER_LINK))
    joints = tuple(replace(joint, inertia=own) for joint, own in zip(chain.joints, links, strict=True))
    errors = tuple(
        TorqueErrors(
            motion.name,
            motion.fitted,
            _percent(motion, blocks[motion.name], regression.unknowns),
            _percent(motion, blocks[motion.name], consistent.x),
        )
        for motion in motions
    )
    base, parameters = _base_table(structure, regression), _parameter_table(structure, consistent, start)
    result = BodyResult(
        axes=chain.names,
        base=base,
        condition_number=regression.condition_number,
        parameters=parameters,
        errors=errors,
        cutoff=dict(cutoff or {}),
        remarks=(*_remarks(base, parameters), *_contradicted(chain, parameters, known)),
    )
    return Identified(replace(chain, joints=joints), result, consistent.x)


def _require_motion(structure: Structure, fitted: Sequence[Motion]) -> None:
    if not fitted:
        raise NumericsError("no record has the role estimate", where="robot.body", hint="give one role: estimate")
    for k, name in enumerate(structure.chain.names):
        if all(np.ptp(motion.q[k]) == 0.0 for motion in fitted):
            hint = "record a motion of all axes, or leave out robot.body"
            raise NumericsError(f"axis {name} never moves", where="robot.body", hint=hint)
    rows, unknowns = sum(motion.q.size for motion in fitted), len(structure.symbols)
    if rows < 2 * unknowns:
        what = f"{rows} filtered samples are too few for {unknowns} parameters"
        raise NumericsError(what, where="robot.body", hint="record for longer, or raise robot.body.cutoff")


def _regress(structure: Structure, fitted: Sequence[Motion], blocks: Sequence[Array]) -> _Regression:
    """Base parameters, each axis weighted by its own residual."""
    base = structural_base(structure)
    picked = list(base.picked)
    own = [block[:, picked] for block in blocks]
    deviation = np.maximum(np.std(np.concatenate([motion.torque for motion in fitted], axis=1), axis=1), SMALLEST)
    seen, values = tuple(range(len(picked))), np.zeros(0)
    for _ in range(MAX_PASSES):
        rows, torque = _weighted(fitted, own, 1 / deviation)
        seen = _distinct(rows)
        values = np.linalg.lstsq(*_scaled(rows[:, seen], torque), rcond=None)[0] / np.linalg.norm(rows[:, seen], axis=0)
        unknowns = np.zeros(blocks[0].shape[1])
        unknowns[[picked[k] for k in seen]] = values
        errors = _errors(fitted, blocks, unknowns)
        if np.allclose(errors.deviation, deviation, rtol=1e-3):
            break
        deviation = errors.deviation
    rows, _ = _weighted(fitted, own, errors.weights)
    norms = np.linalg.norm(rows[:, seen], axis=0)
    scaled = rows[:, seen] / norms
    covariance = np.linalg.inv(scaled.T @ scaled) / np.outer(norms, norms)
    return _Regression(base, seen, values, covariance, float(np.linalg.cond(scaled)), unknowns, errors)


def structural_base(structure: Structure) -> BaseParameters:
    """The base parameters of a chain with drives, found at random motions of all axes."""
    random, count = np.random.default_rng(0), len(structure.chain)
    n = ROWS_AN_UNKNOWN * len(structure.symbols) // count + 1
    q, dq, ddq = random.uniform(-np.pi, np.pi, (count, n)), *random.normal(size=(2, count, n))
    motion = Motion("random", q, dq, ddq, np.sign(dq), np.zeros_like(q))
    return base_parameters(stacked([columns(structure, motion)]))


def _distinct(rows: Array) -> tuple[int, ...]:
    """The columns that these rows tell from each other."""
    norms = np.linalg.norm(rows, axis=0)
    acting = np.flatnonzero(norms > 0)
    _, r, order = qr(rows[:, acting] / norms[acting], mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(r))
    return tuple(sorted(acting[order[: int(np.sum(diagonal * MAX_CONDITION > diagonal[0]))]].tolist()))


def _weighted(fitted: Sequence[Motion], blocks: Sequence[Array], weights: Array) -> tuple[Array, Array]:
    """All equations as rows (n, p) and their torques (n,), those of each axis times its weight."""
    rows = stacked([block * weights[:, None, None] for block in blocks])
    return rows, np.concatenate([(motion.torque * weights[:, None]).ravel() for motion in fitted])


def _scaled(rows: Array, torque: Array) -> tuple[Array, Array]:
    return rows / np.linalg.norm(rows, axis=0), torque


def _errors(fitted: Sequence[Motion], blocks: Sequence[Array], unknowns: Array) -> _Errors:
    """The residual of each axis: its deviation, and over how many samples it is one and the same error."""
    residuals = [m.torque - np.einsum("ipn,p->in", block, unknowns) for m, block in zip(fitted, blocks, strict=True)]
    size = np.sqrt(np.mean(np.concatenate([e**2 for e in residuals], axis=1), axis=1))
    floor = 1e-6 * max(float(np.ptp(m.torque)) for m in fitted)
    times = np.array([[_correlation_samples(one) for one in e] for e in residuals])
    lengths = np.array([e.shape[1] for e in residuals], dtype=np.float64)
    return _Errors(np.maximum(size, floor), lengths @ times / lengths.sum())


def _correlation_samples(residual: Array) -> float:
    """Samples of a residual (n,) that tell as much as one of white noise: the sum of its correlation, up to where it
    first vanishes."""
    n = len(residual)
    power = np.abs(np.fft.rfft(residual, 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0:
        return 1.0
    negative = np.flatnonzero(correlation < 0)
    end = int(negative[0]) if len(negative) else n
    return max(1.0, 1 + 2 * float(correlation[1:end].sum() / correlation[0]))


def _consistent(
    chain: Chain, fitted: Sequence[Motion], blocks: Sequence[Array], errors: _Errors, known: Knowledge
) -> tuple[Consistent, Array]:
    """The consistent unknowns, and where the bodies and rotors were expected, nan for the other unknowns."""
    rows, torque = _weighted(fitted, blocks, errors.weights)
    bodies = _expected_bodies(chain, rows, torque)
    rotors = _expected_rotors(chain, bodies, fitted, known)
    start = np.concatenate([bodies.ravel(), rotors, np.full(rows.shape[1] - bodies.size - len(rotors), nan)])
    fixed = np.concatenate([np.repeat([joint.fixed for joint in chain.joints], len(PER_LINK)), np.zeros(len(rotors))])
    fixed = np.concatenate([fixed, np.zeros(len(start) - len(fixed))]).astype(bool)
    torque = torque - rows[:, fixed] @ start[fixed]
    free = rows[:, ~fixed]
    estimated = [not joint.fixed for joint in chain.joints]
    of_links = known.weights([joint.inertia is not None for joint in chain.joints])[estimated]
    of_rotors = known.weights([name in known.rotors for name in chain.names])
    expected = Start(bodies[estimated], rotors, of_links, of_rotors)
    found = minimise(LeastSquares(free.T @ free, free.T @ torque, float(torque @ torque)), expected)
    x, seen, covariance = start.copy(), np.zeros(len(start)), np.zeros((len(start), len(start)))
    x[~fixed], seen[~fixed], covariance[np.ix_(~fixed, ~fixed)] = found.x, found.seen, found.covariance
    return Consistent(x, covariance, seen), start


def _expected_bodies(chain: Chain, rows: Array, torque: Array) -> Array:
    """Ten parameters of each link before anything is known of the torque but its size, (links, 10).

    A link without given inertia is a body about the middle between its axis and the next, half as heavy as the one
    before it; the torque decides how heavy all of them are, beside friction.
    """
    offsets = [joint.offset for joint in chain.joints[1:]] + [np.zeros(3)]
    lengths = [float(np.linalg.norm(offset)) for offset in offsets]
    radius = GYRATION * max(LEAST_LENGTH, float(np.mean(lengths[:-1])) if len(lengths) > 1 else LEAST_LENGTH)
    found = np.zeros((len(chain), len(PER_LINK)))
    unknown = [joint.inertia is None for joint in chain.joints]
    for k, (joint, offset) in enumerate(zip(chain.joints, offsets, strict=True)):
        spread = radius**2 * np.eye(3) + np.outer(offset, offset) / 12
        found[k] = body(HALVING**k, offset / 2, spread) if joint.inertia is None else _possible(joint.inertia)
    if any(unknown):
        known = found * ~np.array(unknown)[:, None]
        links = rows[:, : found.size]
        one = links @ (found - known).ravel()
        beside = rows[:, found.size :]
        table = np.column_stack([one, beside[:, np.linalg.norm(beside, axis=0) > 0]])
        norms = np.linalg.norm(table, axis=0)
        norms[norms == 0] = 1.0
        mass = np.linalg.lstsq(table / norms, torque - links @ known.ravel(), rcond=None)[0][0] / norms[0]
        found[unknown] *= max(float(mass), LEAST_MASS)
    return found


def _possible(inertia: Array) -> Array:
    """Given parameters of a link, with so much added that a body can have them: a point mass has no extent."""
    if is_consistent(inertia):
        return inertia
    mass = max(float(inertia[0]), LEAST_MASS)
    return body(mass, inertia[1:4] / mass, LEAST_GYRATION**2 * np.eye(3))


def _expected_rotors(chain: Chain, bodies: Array, fitted: Sequence[Motion], known: Knowledge) -> Array:
    """Inertias of the rotors behind their gears (axes,): where unknown, that of the axis' own links, for a gear is
    chosen to match both."""
    q, links = np.concatenate([motion.q for motion in fitted], axis=1), bodies.ravel()
    own = [float(own_inertia(chain, links, q, k).mean()) for k in range(len(chain))]
    return np.array([known.rotors.get(name, size) for name, size in zip(chain.names, own, strict=True)])


def _percent(motion: Motion, block: Array, unknowns: Array) -> tuple[float, ...]:
    residual = motion.torque - np.einsum("ipn,p->in", block, unknowns)
    size = np.maximum(np.linalg.norm(motion.torque, axis=1), SMALLEST)
    return tuple((100 * np.linalg.norm(residual, axis=1) / size).tolist())


def _base_table(structure: Structure, regression: _Regression) -> tuple[BaseParameter, ...]:
    every = structure.symbols
    names = regression.base.names(every)
    values = dict(zip(regression.seen, regression.values.tolist(), strict=True))
    deviations = dict(zip(regression.seen, np.sqrt(np.diag(regression.covariance)).tolist(), strict=True))
    return tuple(
        BaseParameter(names[k], values.get(k, nan), unit_of(every[at]), deviations.get(k, nan), k in values)
        for k, at in enumerate(regression.base.picked)
    )


def _parameter_table(structure: Structure, found: Consistent, start: Array) -> tuple[BodyParameter, ...]:
    deviations = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    fixed = {joint.name for joint in structure.chain.joints if joint.fixed}
    return tuple(
        BodyParameter(
            name=name,
            value=float(found.x[k]),
            unit=unit_of(name),
            std=float(deviations[k]),
            start=float(start[k]),
            seen=float(found.seen[k]),
            fixed=name.rpartition(".")[0] in fixed and name.rpartition(".")[2] in PER_LINK,
        )
        for k, name in enumerate(structure.symbols)
    )


def _contradicted(chain: Chain, found: Sequence[BodyParameter], known: Knowledge) -> tuple[str, ...]:
    """Which given inertias of rotors and masses the motions contradict: by more than they may well differ."""
    masses = {f"{joint.name}.m" for joint in chain.joints if joint.inertia is not None and not joint.fixed}
    given = {*masses, *(f"{axis}.{ROTOR}" for axis in known.rotors)}
    beyond = {
        p.name: p.value / p.start
        for p in found
        if p.name in given
        and abs(np.log(p.value / p.start)) > np.log(known.given_factor)
        and abs(p.value - p.start) > SIGNIFICANT * p.std
    }
    if not beyond:
        return ()
    shares = listed([number(share, 2) for share in beyond.values()])
    what = f"these motions contradict what is given: they put {listed(list(beyond))} at {shares} of it"
    return (f"{what}; check the values, the gear ratios and the scale of the torque",)


def _remarks(base: Sequence[BaseParameter], found: Sequence[BodyParameter]) -> tuple[str, ...]:
    """What these motions do not show."""
    remarks = []
    poor = [b.name for b in base if not b.seen]
    if poor:
        remarks.append(f"these motions do not tell {'; '.join(poor)} from other parameters")
    doubtful = [b for b in base if b.seen and abs(b.value) < SIGNIFICANT * b.std]
    if doubtful:
        remarks.append(f"{len(doubtful)} of {len(base)} base parameters are not distinct from zero")
    unseen = [p.name for p in found if p.name.endswith((".m", f".{ROTOR}")) and not p.fixed and p.seen < SEEN]
    if unseen:
        remarks.append(f"{', '.join(unseen)} keep near their start: these motions show little of them alone")
    opposing = FRICTION["viscous"], FRICTION["coulomb"]
    negative = [p.name for p in found if p.name.rpartition(".")[2] in opposing and p.value < 0]
    if negative:
        remarks.append(f"{', '.join(negative)} came out negative, as no friction is")
    return tuple(remarks)
