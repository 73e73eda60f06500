"""The torque against the motion, whatever the model: inertia, friction and anything that depends on the position.

    tau = J a + Fv v + Fc sgn v + c0 + c1 x + c2 sin x + c3 cos x

over a low-pass band that all columns pass alike. What the companions of a record can make of it is taken out of the
torque and of all columns first, which leaves the coefficients of the regression on both (Frisch & Waugh 1933). The
position's part stands for gravity and springs that a model may lack. Two numbers do not depend on it: the sign of J,
and the power that friction takes, mean of (Fv v + Fc sgn v) v. Passivity demands that this power is not negative, for a
rigid joint and for a flexible one at every frequency, also where the inertia that shows is negative, between an
antiresonance and a resonance (Ortega et al. 1998).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy

from robotid.model.array import Array
from robotid.signals.differentiate import SAMPLES_A_CUTOFF, ParallelFilter, bandwidth, kept
from robotid.signals.plausibility.companion_torques import companion_torques
from robotid.signals.plausibility.relation import DRY, MASS, SPRING_COLUMNS, TINY, Relation, orthonormal, relate
from robotid.signals.plausibility.settings import CHECK, REGRESSION
from robotid.signals.record import Record

VISCOUS, POSITION = 1, 4


@dataclass(frozen=True, slots=True)
class Determined:
    """A number with its standard deviation, infinite where the record cannot tell it."""

    value: float
    std: float

    @property
    def ratio(self) -> float:
        """Value in standard deviations."""
        if not np.isfinite(self.std) or self.value == 0.0:
            return 0.0
        return float(np.copysign(np.inf, self.value)) if self.std == 0.0 else self.value / self.std


@dataclass(frozen=True, slots=True, eq=False)
class TorqueRegression:
    """The torque of one record on its motion.

    inertia [kg m2], friction_power [W]. left : share of the torque's variance that companions leave, 1 without any;
    relation : whether what they leave belongs to the motion. white : whether successive samples of the torque have
    nothing to do with each other. cutoff [Hz].
    delay [s] : by which the angle is late against the torque as the inertia shows it.
    """

    inertia: Determined
    friction_power: Determined
    left: float
    relation: Relation
    white: bool
    cutoff: float
    delay: Determined

    @property
    def stands_out(self) -> bool:
        """Whether the motion shows a joint, by an inertia or a friction, or explains more than chance does."""
        joint = max(self.inertia.ratio, self.friction_power.ratio) > CHECK.sure
        return joint or self.relation.above_chance > CHECK.lone_chance


def regress_torque(record: Record, turns: float | None) -> tuple[TorqueRegression, list[FilteredMotion]]:
    """Regression of a record's torque, and the record at several cut-offs as the regression takes it. Companions are
    asked where the motion alone leaves most of the torque, or shows no joint and hardly stands out. They count where it
    then stands out more and leave enough samples. turns : as of `FilteredMotion.of`."""
    alone = FilteredMotion.of(replace(record, companions={}), turns)
    found = _regression(record, alone, turns), alone
    if not record.companions or (clearest(alone).share > CHECK.weak and found[0].stands_out):
        return found
    first = max(0, len(record) - REGRESSION.beside_companions) // 2
    beside = FilteredMotion.of(record.piece(first, first + REGRESSION.beside_companions), turns)
    if not clearest(beside).is_determined:  # so many columns explain any torque of so few samples
        return found
    return max(found, (_regression(record, beside, turns), beside), key=lambda one: one[0].relation.above_chance)


def clearest(tried: Sequence[FilteredMotion]) -> FilteredMotion:
    """The cut-off at which the motion explains the torque best."""
    return max(tried, key=lambda one: one.adjusted)


def _relation(tried: Sequence[FilteredMotion], turns: float | None) -> Relation:
    """Whether a torque belongs to a motion. Where its bandwidth leaves too few samples to tell, a higher cut-off does:
    what it lacks there is evidence as well."""
    found, record = relate(tried), tried[0].record
    if found.is_determined:
        return found
    wanted = 2 * REGRESSION.samples_a_column * (len(tried[0].columns) + SPRING_COLUMNS)
    highest = min(wanted / (SAMPLES_A_CUTOFF * record.duration), 0.25 / record.sampling_time)
    return relate([FilteredMotion.at(record, highest, turns)])


def _regression(record: Record, tried: Sequence[FilteredMotion], turns: float | None) -> TorqueRegression:
    best = clearest(tried)
    solution = LeastSquares.of(best.columns, best.torque)
    v = best.speed
    power = np.zeros(len(best.columns))
    power[VISCOUS], power[DRY] = np.mean(v**2), np.mean(np.abs(v))
    mass = np.zeros(len(best.columns))
    mass[MASS] = 1.0
    return TorqueRegression(
        inertia=solution.combination(mass),
        friction_power=solution.combination(power),
        left=best.left,
        relation=_relation(tried, turns),
        white=_white(record.tau_m),
        cutoff=best.cutoff,
        delay=_delay(best, solution),
    )


def cutoffs(record: Record) -> list[float]:
    """Cut-offs to try [Hz]: from the torque's bandwidth down to few periods in the record."""
    highest = bandwidth(record.tau_m, record.sampling_time) or 0.25 / record.sampling_time
    lowest = min(REGRESSION.min_periods / record.duration, highest)
    return [float(cutoff) for cutoff in np.geomspace(highest, lowest, REGRESSION.cutoffs)]


@dataclass(frozen=True, slots=True, eq=False)
class FilteredMotion:
    """A record at one cut-off, all filtered alike.

    spacing : of samples [s]; speed (n,). columns (p, n), torque (n,) and jerk (n,) : without what companions can make
    of them; others (n, k) : an orthonormal basis of that. left : share of the torque's variance that they leave.
    """

    record: Record
    cutoff: float
    spacing: float
    speed: Array
    columns: Array
    torque: Array
    jerk: Array
    others: Array
    left: float

    @classmethod
    def of(cls, record: Record, turns: float | None) -> list[FilteredMotion]:
        """A record at all cut-offs. turns : angle of the arm for one radian of the motor, whose sine and cosine gravity
        follows; None for an axis that slides."""
        return [cls.at(record, cutoff, turns) for cutoff in cutoffs(record)]

    @classmethod
    def at(cls, record: Record, cutoff: float, turns: float | None) -> FilteredMotion:
        parallel, h = ParallelFilter(cutoff), record.sampling_time
        motion = parallel.motion(record.phi_m, h)
        x = motion.position - motion.position.mean()
        rows: list[Callable[[], Array]] = [
            lambda: motion.acceleration,
            lambda: motion.speed,
            lambda: np.sign(motion.speed),
            lambda: np.ones_like(x),
            lambda: x,
        ]
        if turns is not None:
            rows += [lambda: np.sin(turns * motion.position), lambda: np.cos(turns * motion.position)]
        rows += [lambda: record.tau_m, lambda: np.gradient(motion.acceleration, h)]
        # one after the other, so that a long record's signals are not all in memory
        signals = np.array([_thinned(parallel.apply(row(), h)) for row in rows])
        arm = (turns or 1.0) * motion.position
        torques = [_thinned(parallel.apply(one, h)) for one in companion_torques(record, arm)]
        beside = [np.ones(signals.shape[1]), *torques] if torques else []
        others = orthonormal(np.reshape(beside, (-1, signals.shape[1])))
        *columns, torque, jerk = _without(others, signals)
        left = float(np.var(torque)) / max(float(np.var(signals[-2])), TINY)
        samples = range(*kept(len(record), h, cutoff).indices(len(record)))
        spacing = samples.step * _thinning(len(samples)) * h
        return cls(record, cutoff, spacing, signals[VISCOUS], np.array(columns), torque, jerk, others, left)

    @property
    def share(self) -> float:
        """Share of the torque's variance that the columns explain."""
        return explained_share(self.columns, self.torque)

    @property
    def adjusted(self) -> float:
        """The same, corrected for the number of columns."""
        if not self.is_determined:
            return -np.inf
        n, p = len(self.torque) - self.others.shape[1], len(self.columns)
        return float(1.0 - (1.0 - self.share) * n / (n - p))

    @property
    def is_determined(self) -> bool:
        """Whether there are samples enough for the columns and for all that companions may do."""
        return bool(len(self.torque) - self.others.shape[1] >= REGRESSION.samples_a_column * len(self.columns))


def _thinned(signal: Array) -> Array:
    """Every k-th sample of a signal (n,)."""
    return signal[:: _thinning(len(signal))].copy()


def _thinning(samples: int) -> int:
    """The least k of which every k-th leaves REGRESSION.max_samples at most."""
    return -(-samples // REGRESSION.max_samples)


def _without(basis: Array, signals: Array) -> Array:
    """Signals (..., n) less what a basis (n, k) holds of them."""
    return np.asarray(signals - signals @ basis @ basis.T)


def explained_share(columns: Array, torque: Array) -> float:
    """Share of a torque's variance (n,) that columns (p, n), one of them constant, explain."""
    centred = torque - torque.mean()
    whole = float(centred @ centred)
    if whole == 0.0:
        return 0.0
    basis = LeastSquares.basis(columns)[0]
    left = centred - basis @ (basis.T @ centred)
    return max(0.0, 1.0 - float(left @ left) / whole)


@dataclass(frozen=True, slots=True, eq=False)
class LeastSquares:
    """Least squares over the directions that the columns determine, with deviations from the scores of blocks."""

    theta: Array
    covariance: Array
    scale: Array
    unseen: Array
    residual: Array

    @staticmethod
    def basis(columns: Array) -> tuple[Array, Array, Array, Array]:
        """Orthonormal basis (n, k) of what the columns determine; lengths (p,), singular values and directions."""
        scale = np.linalg.norm(columns, axis=1)
        scale = np.where(scale > 0.0, scale, 1.0)
        left, values, directions = scipy.linalg.svd((columns / scale[:, None]).T, full_matrices=False)
        seen = values > REGRESSION.min_direction * max(float(values[0]), TINY)
        return left[:, seen], scale, np.where(seen, values, 0.0), directions

    @classmethod
    def of(cls, columns: Array, torque: Array) -> LeastSquares:
        basis, scale, values, directions = cls.basis(columns)
        seen = values > 0.0
        inverse = directions[seen].T / values[seen]
        theta = inverse @ (basis.T @ torque)
        residual = torque - (columns / scale[:, None]).T @ theta
        scores = basis * residual[:, None]
        edges = np.linspace(0, len(torque), REGRESSION.blocks + 1).astype(int)
        sums = np.array([scores[a:b].sum(axis=0) for a, b in pairwise(edges.tolist())])
        covariance = inverse @ (sums.T @ sums) @ inverse.T
        return cls(theta, covariance, scale, directions[~seen], residual)

    def combination(self, weights: Array) -> Determined:
        """A linear combination of the unknowns, weights (p,)."""
        scaled = weights / self.scale
        size = float(np.linalg.norm(scaled))
        value = float(scaled @ self.theta)
        if size == 0.0 or np.linalg.norm(self.unseen @ scaled) > REGRESSION.max_share * size:
            return Determined(value, np.inf)
        return Determined(value, float(np.sqrt(max(0.0, float(scaled @ self.covariance @ scaled)))))


def _delay(filtered: FilteredMotion, solution: LeastSquares) -> Determined:
    """The delay [s] of the angle against the torque, as the torque of an inertia that follows a later acceleration:
    J a(t + d) = J a + J d da/dt. It is not determined where friction can take its part, so both are free."""
    more = LeastSquares.of(np.vstack([filtered.columns, filtered.jerk]), filtered.torque)
    weights = np.zeros(len(filtered.columns) + 1)
    weights[-1] = 1.0
    inertia = float(solution.theta[MASS] / solution.scale[MASS])
    found = more.combination(weights)
    if inertia == 0.0:
        return Determined(0.0, np.inf)
    return Determined(found.value / inertia, found.std / abs(inertia))


def _white(signal: Array) -> bool:
    """Whether a signal (n,) is uncorrelated from one sample to the next (Bartlett's band at 4 deviations)."""
    centred = signal - signal.mean()
    energy = float(centred @ centred)
    return energy > 0 and bool(abs(float(centred[1:] @ centred[:-1])) < 4.0 * energy / np.sqrt(len(signal)))
