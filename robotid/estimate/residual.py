"""Output error of a simulated joint against records, eq. (3) of the paper, and its exact Jacobian.

The unknowns are the free parameters, shared by all records, followed by the free initial states of each record in turn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from robotid.errors import ConfigError, NumericsError
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.port import Signal
from robotid.signals.record import Quantity, Record
from robotid.simulation.first_guess import initial_state
from robotid.simulation.sensitivities import sensitivities
from robotid.simulation.sensors import shown, shown_columns
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

LARGEST_PREDICTION = 5_000_000  # derivatives kept of one record to predict its next trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Weighted residuals at one point: one (n,) a record, the trajectories behind them, and the cost, half their
    square sum.

    derivatives : record number to those of all states to the unknowns (nx, m, n), where they were worked out.
    """

    unknowns: Array
    residuals: tuple[Array, ...]
    trajectories: tuple[Trajectory, ...]
    derivatives: dict[int, Array] = field(default_factory=dict)

    @property
    def cost(self) -> float:
        return 0.5 * float(sum(r @ r for r in self.residuals))


@dataclass(slots=True, eq=False)
class OutputError:
    """A least-squares problem over records. weights : (records,) that multiply the residuals.

    free_states : which states' first values are estimated, for every record alike. whiten : one filter a record that
    takes (..., n) to (..., n), through which the residual is judged; none, and it is judged as it is. patience : as
    of `simulate`.
    """

    joint: Joint
    parameters: Parameters
    records: tuple[Record, ...]
    output: Quantity
    weights: Array
    estimate_states: bool = True
    whiten: tuple[Callable[[Array], Array], ...] = ()
    patience: int | None = None
    columns: tuple[int, ...] = field(init=False)
    free_states: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        if self.output == "position" and not self.joint.keeps_angle:
            raise ConfigError("position needs a joint that keeps its angle", where="fit.output")
        self.columns = tuple(int(k) for k in np.flatnonzero(self.parameters.free))
        every = range(self.joint.nx)
        seen = every if self.output == "position" else [k for k in every if k != self._angle]
        self.free_states = tuple(seen) if self.estimate_states else ()

    @property
    def _angle(self) -> int:
        return self.joint.speeds.start - 1 if self.joint.keeps_angle else -1

    @property
    def row(self) -> int:
        """The state that is the output."""
        return self._angle if self.output == "position" else self.joint.speeds.start

    def start(self) -> Array:
        """Unknowns at the parameters' values and the measured first states."""
        states = [
            initial_state(self.joint, self.parameters.values, record)[list(self.free_states)] for record in self.records
        ]
        return np.concatenate([self.parameters.values[list(self.columns)], *states])

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the unknowns; initial states have none."""
        free = np.full(len(self.records) * len(self.free_states), np.inf)
        columns = list(self.columns)
        return np.append(self.parameters.lower[columns], -free), np.append(self.parameters.upper[columns], free)

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
        near: Evaluation | None = None,
        guesses: Sequence[Array] = (),
        *,
        most: float = np.inf,
    ) -> Evaluation:
        """Simulate all records. near : an evaluation close by, whose trajectories are the first guess; guesses : of the
        states of each record, (nx, n), where there is none. most : cost that is of interest; once it is exceeded, the
        other records are left out."""
        theta, cost = self.theta(unknowns), 0.0
        residuals, trajectories = [], []
        for k, record in enumerate(self.records):
            guess = guesses[k] if guesses else None
            if near is not None:
                guess = self._predict(k, near, unknowns)
            trajectory = simulate(self.joint, theta, record, self.first_state(unknowns, k), guess, self.patience)
            measured = record.phi_m if self.output == "position" else record.dphi_m
            residuals.append(self._shaped(k, measured - observed(trajectory, self.output)))
            trajectories.append(trajectory)
            cost += 0.5 * float(residuals[-1] @ residuals[-1])
            if cost > most:
                break
        return Evaluation(unknowns, tuple(residuals), tuple(trajectories))

    @np.errstate(all="ignore")  # what is not finite is told below
    def jacobian(self, at: Evaluation, k: int) -> tuple[Array, Array]:
        """Derivatives of record k's weighted residual: the columns concerned (m,), and their values (m, n). Raises
        NumericsError where they are not finite, as where a state begins far beyond what holds it."""
        trajectory = at.trajectories[k]
        nx, width = self.joint.nx, len(self.columns) + len(self.free_states)
        small = nx * width * len(self.records[k]) <= LARGEST_PREDICTION
        seen = output_rows(self.joint, self.output)
        rows = range(nx) if small else seen
        inner = sensitivities(trajectory, self.records[k], self.columns, rows, self.free_states)
        if small:
            at.derivatives[k] = inner
        outer = output_columns(trajectory, self.output, self.columns, inner[list(seen)] if small else inner)
        values = -self._shaped(k, outer)
        if not np.isfinite(values).all():
            what = f"the derivatives on {self.records[k].name} are not finite"
            raise NumericsError(what, hint="check the parameters' guesses and bounds")
        return self._unknowns_of(k), values

    def _shaped(self, k: int, signals: Array) -> Array:
        return np.asarray(self.weights[k] * (self.whiten[k](signals) if self.whiten else signals))

    def _unknowns_of(self, k: int) -> Array:
        states = self._states_of(k)
        return np.concatenate([np.arange(len(self.columns)), np.arange(states.start, states.stop)])

    def _predict(self, k: int, near: Evaluation, unknowns: Array) -> Array:
        """Record k's trajectory to first order from one nearby, (nx, n)."""
        x = near.trajectories[k].x
        if k not in near.derivatives:
            return x
        step = (unknowns - near.unknowns)[self._unknowns_of(k)]
        return np.asarray(x + np.einsum("k,xkn->xn", step, near.derivatives[k]))


def observed(trajectory: Trajectory, output: Quantity) -> Array:
    """The simulated output as its sensor shows it, after the channels on it, (n,)."""
    t = trajectory
    phi_m, dphi_m = shown(t.joint, t.theta, t.sampling_time, t.phi_m, t.dphi_m)
    return phi_m if output == "position" else dphi_m


def output_rows(joint: Joint, output: Quantity) -> tuple[int, ...]:
    """The states that the output shows: the angle, or the speed after the angle where that distorts it."""
    speed = joint.speeds.start
    if output == "position":
        return (speed - 1,)
    return (speed - 1, speed) if any(signal is Signal.ANGLE for signal, _ in joint.channels) else (speed,)


def output_columns(trajectory: Trajectory, output: Quantity, columns: Sequence[int], inner: Array) -> Array:
    """Derivatives of the observed output, (m, n), theta's columns first. inner : those of the states that it shows,
    (rows, m, n) in the order of `output_rows`."""
    still, with_angle = np.zeros_like(inner[0]), output == "position" or len(inner) > 1
    found = shown_columns(
        trajectory, columns, inner[0] if with_angle else still, inner[-1] if output == "speed" else still
    )
    return found[output == "speed"]
