"""Output error of a simulated joint against records, eq. (3) of the paper, and its exact Jacobian.

The unknowns are the free parameters, shared by all records, followed by the free initial states of each record in turn.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robotid.errors import ConfigError, NumericsError
from robotid.estimate.first_states import first_state_limits
from robotid.model.array import Array, Index
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.port import Signal
from robotid.signals.derivation import Derivation
from robotid.signals.record import OPERATORS, Quantity, Record, SpeedOrigin
from robotid.simulation.first_guess import initial_state
from robotid.simulation.friction.step import Steps
from robotid.simulation.sensitivities import sensitivities, sensitivity_blocks, wanted_columns
from robotid.simulation.sensors import sensor_columns, sensor_signals
from robotid.simulation.simulate import Start, integrated, simulate_together
from robotid.simulation.trajectory import Trajectory, linearised_together, shared_dynamics

FARTHEST_PREDICTION = 1.0  # root mean square of a predicted change, of the state's own
TRIAL_PATIENCE = 8  # windows that may fail to settle in a trial, however few do close by; near a minimum three do
SENSOR_MARGIN = 2_000  # samples on either side of a block, across which a sensor's delay or operator reaches
MAX_PREDICTION = 5_000_000  # derivatives kept of one record to predict its next trajectory: 40 MB


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Weighted residuals at one point (m,) of the unknowns: one (n,) a record, and the trajectories behind them."""

    unknowns: Array
    residuals: tuple[Array, ...]
    trajectories: tuple[Trajectory, ...]

    @property
    def cost(self) -> float:
        """Half the sum of the squared residuals."""
        return 0.5 * float(sum(r @ r for r in self.residuals))


@dataclass(frozen=True, slots=True, eq=False)
class Jacobian:
    """Derivatives of one record's weighted residual.

    unknowns : (m,) numbers of those that concern the record; values : (m, n); states : (nx, m, n) the derivatives of
    all states to the same unknowns, None where they are too many to keep.
    """

    unknowns: Index
    values: Array
    states: Array | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Linearisation:
    """An evaluation with what its derivatives say.

    factor : (m, m) with factor^T factor = J^T J; gradient : (m,) of the cost; states : of each record, as of
    `Jacobian`.
    """

    evaluation: Evaluation
    factor: Array
    gradient: Array
    states: tuple[Array | None, ...]


@dataclass(frozen=True, slots=True, eq=False)
class OutputError:
    """A least-squares problem over records.

    weights : (records,) that multiply the residuals. estimate_states : whether the first states of every record are
    unknowns, too. whiten : one filter a record, from (..., n) to (..., n), that the residual passes; without any, the
    residual stays as it is. max_failed_windows : as of `simulate`. Raises ConfigError where the joint does not have the
    output.
    """

    joint: Joint
    parameters: Parameters
    records: tuple[Record, ...]
    output: Quantity
    weights: Array
    estimate_states: bool = True
    whiten: tuple[Callable[[Array], Array], ...] = ()
    max_failed_windows: int | None = None

    def __post_init__(self) -> None:
        if self.output == "position" and not self.joint.keeps_angle:
            raise ConfigError("position needs a joint that keeps its angle", where="fit.output")

    @property
    def columns(self) -> tuple[int, ...]:
        """The free parameters, as indices into theta."""
        return tuple(int(k) for k in np.flatnonzero(self.parameters.free))

    @property
    def free_states(self) -> tuple[int, ...]:
        """The states whose first values are estimated, of every record alike; a speed does not show the angle's."""
        if not self.estimate_states:
            return ()
        hidden = [self.joint.motor_angle] if self.output == "speed" and self.joint.keeps_angle else []
        return tuple(k for k in range(self.joint.nx) if k not in hidden)

    @property
    def row(self) -> int:
        """The state that is the output."""
        return self.joint.output_row(self.output)

    def start(self) -> Array:
        """Unknowns at the parameters' values and the measured first states."""
        states = [
            initial_state(self.joint, self.parameters.values, record)[list(self.free_states)] for record in self.records
        ]
        return np.concatenate([self.parameters.values[list(self.columns)], *states])

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the unknowns; those of first states are what their measurement allows."""
        columns, states = list(self.columns), list(self.free_states)
        lower, upper = [self.parameters.lower[columns]], [self.parameters.upper[columns]]
        for record in self.records if states else ():
            least, most = first_state_limits(self.joint, record)
            lower.append(least[states])
            upper.append(most[states])
        return np.concatenate(lower), np.concatenate(upper)

    def theta(self, unknowns: Array) -> Array:
        """All parameters, (p,)."""
        theta = self.parameters.values.copy()
        theta[list(self.columns)] = unknowns[: len(self.columns)]
        return theta

    def first_state(self, unknowns: Array, k: int) -> Array:
        """First state of record k, (nx,)."""
        x0 = initial_state(self.joint, self.theta(unknowns), self.records[k])
        x0[list(self.free_states)] = unknowns[self._states_of(k)]
        return x0

    def _states_of(self, k: int) -> slice:
        first = len(self.columns) + k * len(self.free_states)
        return slice(first, first + len(self.free_states))

    def evaluate(
        self,
        unknowns: Array,
        near: Linearisation | None = None,
        guesses: Sequence[Array] = (),
        *,
        max_cost: float = np.inf,
        trial: bool = False,
    ) -> Evaluation:
        """Simulate all records at unknowns (m,).

        near : a point close by, whose trajectories are carried on to first order as guesses; guesses : of the states of
        each record, (nx, n), where there is none. max_cost : once the cost exceeds it, the other records are left out.
        trial : the point is one of several that could be next, as all are that have one close by: where its simulation
        settles much worse than there, it is not worth the time. Raises NumericsError where a simulation diverges, or
        settles so.
        """
        theta, cost = self.theta(unknowns), 0.0
        residuals, trajectories = [], []
        known = guesses if near is None else [self._predict(k, near, unknowns) for k in range(len(self.records))]
        starts = [Start(self.first_state(unknowns, k), known[k] if known else None) for k in range(len(self.records))]
        limit = self.max_failed_windows
        if limit is None and (trial or near is not None):
            before = () if near is None else near.evaluation.trajectories
            limit = max([TRIAL_PATIENCE, *(t.failed_windows for t in before)])
        found = simulate_together(self.joint, theta, self.records, starts, limit)
        for k, trajectory in enumerate(found):
            residuals.append(self.residual(k, trajectory))
            trajectories.append(trajectory)
            cost += 0.5 * float(residuals[-1] @ residuals[-1])
            if cost > max_cost:
                break
        return Evaluation(unknowns, tuple(residuals), tuple(trajectories))

    def start_of(self, k: int, unknowns: Array, near: Linearisation | None, guess: Array | None = None) -> Start:
        """Where the simulation of record k starts. Arguments as of `evaluate`."""
        return Start(self.first_state(unknowns, k), guess if near is None else self._predict(k, near, unknowns))

    @np.errstate(all="ignore")  # derivatives that are not finite are reported below
    def jacobian(self, at: Evaluation, k: int, steps: Steps | None = None) -> Jacobian:
        """Derivatives of record k's weighted residual. steps : of its trajectory, as of `steps`. Raises NumericsError
        where they are not finite, as where a state begins far beyond its limits."""
        trajectory = at.trajectories[k]
        if not self.predicts(k):
            values = np.empty((len(self.unknowns_of(k)), len(self.records[k])))
            for block, part in self.derivative_blocks(at, k):
                values[:, block] = part
            return Jacobian(self.unknowns_of(k), values)
        seen = output_rows(self.joint, self.output, trajectory.speed_origin)
        rows = range(self.joint.nx)
        inner = sensitivities(trajectory, self.records[k], self.columns, rows, self.free_states, steps=steps)
        outer = output_columns(trajectory, self.output, self.columns, inner[list(seen)])
        return Jacobian(self.unknowns_of(k), self._finite(k, -self.shaped(k, outer)), inner)

    def steps(self, at: Evaluation) -> Sequence[Steps | None]:
        """The steps of all trajectories with what derivatives need of them, where it pays to find them at once."""
        if not all(map(self.predicts, range(len(at.trajectories)))):
            return [None] * len(at.trajectories)
        return self.steps_of(at.trajectories)

    def steps_of(self, trajectories: Sequence[Trajectory]) -> Sequence[Steps | None]:
        """The same of some trajectories of this joint and of its parameters."""
        few = len(trajectories) > 1 and self.joint.is_one_in(record.name for record in self.records)
        among = shared_dynamics(trajectories) if few else None
        if among is None:
            return [None] * len(trajectories)
        wanted = wanted_columns(self.joint, self.columns, self.records[0].name, forces=False)
        return linearised_together(trajectories, wanted, among)

    def predicts(self, k: int) -> bool:
        """Whether record k is short enough to keep the derivatives of all its states."""
        width = len(self.columns) + len(self.free_states)
        return self.joint.nx * width * len(self.records[k]) <= MAX_PREDICTION

    def derivative_blocks(self, at: Evaluation, k: int) -> Iterator[tuple[slice, Array]]:
        """Derivatives of record k's weighted residual, block by block of samples: the block, and (m, its samples).

        In one block where a filter whitens the residual. Raises NumericsError as `jacobian` does.
        """
        trajectory, n = at.trajectories[k], len(self.records[k])
        seen = output_rows(self.joint, self.output, trajectory.speed_origin)
        arguments = (trajectory, self.records[k], self.columns, seen, self.free_states)
        if self.whiten:
            outer = output_columns(trajectory, self.output, self.columns, sensitivities(*arguments))
            yield slice(0, n), self._finite(k, -self.shaped(k, outer))
            return
        first, done = 0, 0  # sample at which the window of derivatives begins, and up to which they are handed on
        window = np.zeros((len(seen), len(self.unknowns_of(k)), 0))
        for block, inner in sensitivity_blocks(*arguments):
            window = np.concatenate([window, inner], axis=2)
            ready = n if block.stop == n else block.stop - SENSOR_MARGIN
            if ready <= done:
                continue
            part = trajectory.part(slice(first, block.stop))
            outer = output_columns(part, self.output, self.columns, window)[:, done - first : ready - first]
            yield slice(done, ready), self._finite(k, -self.shaped(k, outer))
            kept = max(first, ready - SENSOR_MARGIN)
            window, first, done = window[:, :, kept - first :], kept, ready

    def _finite(self, k: int, values: Array) -> Array:
        """Derivatives on record k. Raises NumericsError where one is not finite."""
        if not np.isfinite(values).all():
            what = f"the derivatives on {self.records[k].name} are not finite"
            raise NumericsError(what, hint="check the parameters' guesses and bounds")
        return values

    def residual(self, k: int, trajectory: Trajectory) -> Array:
        """What a trajectory leaves of record k, weighted and whitened, (n,)."""
        return self.shaped(k, measured_output(self.records[k], self.output) - observed(trajectory, self.output))

    def shaped(self, k: int, signals: Array) -> Array:
        """Signals (..., n) of record k, weighted and whitened."""
        return np.asarray(self.weights[k] * (self.whiten[k](signals) if self.whiten else signals))

    def unknowns_of(self, k: int) -> Index:
        """Numbers of the unknowns that concern record k, (m,)."""
        states = self._states_of(k)
        return np.concatenate([np.arange(len(self.columns)), np.arange(states.start, states.stop)])

    def _predict(self, k: int, near: Linearisation, unknowns: Array) -> Array:
        """Record k's trajectory to first order from one nearby, (nx, n); where impacts make the derivatives so large
        that this leads nowhere, the one nearby."""
        x, derivatives = near.evaluation.trajectories[k].x, near.states[k]
        if derivatives is None:
            return x
        step = (unknowns - near.evaluation.unknowns)[self.unknowns_of(k)]
        change = np.einsum("k,xkn->xn", step, derivatives)
        with np.errstate(over="ignore"):  # what is too far for its square to be a number is too far
            far = np.sum(change**2, axis=1) > FARTHEST_PREDICTION**2 * np.sum(x**2, axis=1)
        return x if np.any(far & x.any(axis=1)) else np.asarray(x + change)


def joined_factor(triangles: Sequence[Array], unknowns: Sequence[Index]) -> Array:
    """A factor (m, m) of the Jacobian from those of each record, (m_k, m_k), to its unknowns, (m_k,) numbers: those
    that concern other records, too, then its own.

    Its own unknowns are eliminated first: of many short pieces the factor costs no more than theirs one by one.
    """
    records = np.bincount(np.concatenate(unknowns))
    m, shared = len(records), int(np.sum(records > 1))
    factor, left = np.zeros((m, m)), list[Array]()
    for triangle, numbers in zip(triangles, unknowns, strict=True):
        own = len(numbers) - shared
        eliminated = np.asarray(np.linalg.qr(np.roll(triangle, own, axis=1), mode="r"))
        factor[np.ix_(numbers[shared:], np.roll(numbers, own))] = eliminated[:own]
        left.append(eliminated[own:, own:])
    factor[:shared, :shared] = np.linalg.qr(np.concatenate(left), mode="r")
    return factor


def measured_output(record: Record, output: Quantity) -> Array:
    """The recorded output, (n,)."""
    return record.phi_m if output == "position" else record.dphi_m


def observed(trajectory: Trajectory, output: Quantity) -> Array:
    """The simulated output as its sensor shows it, after the channels on it, (n,)."""
    t = trajectory
    phi_m, dphi_m = sensor_signals(t.joint, t.theta, t.sampling_time, t.phi_m, t.dphi_m, t.speed_origin)
    return phi_m if output == "position" else dphi_m


def output_rows(joint: Joint, output: Quantity, speed_origin: SpeedOrigin = "sensor") -> tuple[int, ...]:
    """The states that the output shows: the angle, also where the speed is derived from it; else the speed, after the
    angle where that distorts it."""
    if output == "position" or (speed_origin in OPERATORS and joint.keeps_angle):
        return (joint.motor_angle,)
    distorted = any(signal is Signal.ANGLE for signal, _ in joint.channels)
    return (joint.motor_angle, joint.motor_speed) if distorted else (joint.motor_speed,)


def state_weights(trajectory: Trajectory, output: Quantity, weights: Array) -> tuple[int, Array]:
    """The state that an output without channels shows, and weights (n,) of the output as weights of that state, (n,):
    those of a speed that is derived from the angle are the angle's."""
    joint, origin = trajectory.joint, trajectory.speed_origin
    if output == "position" or origin not in OPERATORS or not joint.keeps_angle:
        return joint.output_row(output), weights
    return joint.motor_angle, Derivation(origin, trajectory.sampling_time).speed_adjoint(weights)


def output_columns(trajectory: Trajectory, output: Quantity, columns: Sequence[int], inner: Array) -> Array:
    """Derivatives of the observed output, (m, n), theta's columns first. inner : those of the states that it shows,
    (rows, m, n) in the order of `output_rows`."""
    still, derived = np.zeros_like(inner[0]), trajectory.speed_origin in OPERATORS
    if output == "position":
        to_phi, to_dphi = inner[0], still
    elif derived:
        kept = trajectory.joint.keeps_angle
        to_phi, to_dphi = inner[0] if kept else integrated(inner[0], trajectory.sampling_time), still
    else:
        to_phi, to_dphi = inner[0] if len(inner) > 1 else still, inner[-1]
    return sensor_columns(trajectory, columns, to_phi, to_dphi)[output == "speed"]
