"""A model's motion on any record: its parameters fixed, the first states found on that record alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

import numpy as np

from robotid.catalogue import assemble
from robotid.estimate.residual import OutputError, measured_output, observed
from robotid.estimate.result import FitResult
from robotid.estimate.separately import FIRST_STATES, solve_in_a_row
from robotid.model.array import Array
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.model.units import unit_of
from robotid.signals.companion import together
from robotid.signals.record import SIGNALS, Quantity, Record
from robotid.signals.torque_steps import in_a_row
from robotid.simulation.simulate import simulate
from robotid.simulation.trajectory import Trajectory

LONG = 500_000  # samples, from which first states are found on the beginning of a piece
BEGINNING = 100_000  # samples of it: no first state shows for longer


@dataclass(frozen=True, slots=True, eq=False)
class FittedModel:
    """A joint with its values, as it is validated and diagnosed.

    output : what its fit compared. records : those of its fit. first_states : record name to (nx,), where known.
    estimate_states : whether first states are found by least squares or taken as measured. start : values from which
    its fit started, by parameter, where known.
    """

    name: str
    joint: Joint
    parameters: Parameters
    output: Quantity
    records: tuple[str, ...]
    first_states: Mapping[str, Array]
    estimate_states: bool = True
    start: Mapping[str, float] = field(default_factory=dict)

    @property
    def theta(self) -> Array:
        return self.parameters.values

    @property
    def unit(self) -> str:
        """Of the output."""
        return unit_of(self.output, linear=self.joint.structure.linear)


def fitted_model(fit: FitResult, *, estimate_states: bool = True) -> FittedModel:
    """The model that a fit made, its parameters free as they were."""
    joint = assemble(fit.structure, angle=fit.keeps_angle or fit.output == "position")
    estimates = fit.parameters
    parameters = replace(
        joint.parameters(),
        values=np.array([p.value for p in estimates]),
        lower=np.array([p.lower for p in estimates]),
        upper=np.array([p.upper for p in estimates]),
        free=np.array([not p.fixed for p in estimates]),
    )
    first_states = fit.initial_states
    return FittedModel(
        fit.name, joint, parameters, fit.output, fit.records, first_states, estimate_states, start=fit.start
    )


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedSegment:
    """One segment of a record, its simulated motion, and the residual.

    record : the segment itself; trajectory : simulated at its n samples; residual : (n,) measured less simulated
    output, in the unit of the output.
    """

    record: Record
    trajectory: Trajectory
    residual: Array


@dataclass(frozen=True, slots=True, eq=False)
class Simulated:
    """A simulated record: one trajectory a piece, each from first states of its own."""

    record: Record
    pieces: tuple[Record, ...]
    trajectories: tuple[Trajectory, ...]

    @property
    def t(self) -> Array:
        """Time since the experiment began [s], (n,)."""
        return np.concatenate([piece.t for piece in self.pieces])

    def measured(self, quantity: Quantity) -> Array:
        """Measured position or speed, (n,)."""
        return _in_a_row([measured_output(piece, quantity) for piece in self.pieces])

    def signal(self, quantity: Quantity) -> Array:
        """Simulated position or speed as its sensor would show it, (n,)."""
        return _in_a_row([observed(t, quantity) for t in self.trajectories])

    def residual(self, quantity: Quantity) -> Array:
        """What the simulation leaves of the measured position or speed, (n,)."""
        return self.measured(quantity) - self.signal(quantity)

    def segments(self, quantity: Quantity) -> list[SimulatedSegment]:
        """Its pieces one by one, with the residuals of a quantity."""
        return [simulated_segment(*pair, quantity) for pair in zip(self.pieces, self.trajectories, strict=True)]


def _in_a_row(parts: Sequence[Array]) -> Array:
    """Signals one after the other, one alone as it is: that of a long record is large."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def simulated_segment(record: Record, trajectory: Trajectory, quantity: Quantity) -> SimulatedSegment:
    """A record with its simulated motion and the residual of a quantity."""
    return SimulatedSegment(record, trajectory, measured_output(record, quantity) - observed(trajectory, quantity))


def simulate_record(model: FittedModel, record: Record, horizon: float | None = None) -> Simulated:
    """Open-loop simulation of a record from the first states that suit it best.

    horizon [s] : length of the pieces that start afresh, absent: the whole record at once. Raises NumericsError where
    the simulation diverges.
    """
    (found,) = simulate_records(model, [record], horizon)
    return found


def simulate_records(model: FittedModel, records: Sequence[Record], horizon: float | None = None) -> list[Simulated]:
    """Several records as `simulate_record` does each, their simulations made together where that pays."""
    pieces = [record.pieces(horizon) if horizon else (record,) for record in records]
    trajectories = iter(simulate_pieces(model, [piece for own in pieces for piece in own]))
    return [
        Simulated(record, own, tuple(islice(trajectories, len(own))))
        for record, own in zip(records, pieces, strict=True)
    ]


def simulate_pieces(model: FittedModel, pieces: Sequence[Record]) -> list[Trajectory]:
    """Open-loop simulations of pieces of records, each from the first states that suit it best. Raises NumericsError
    where one diverges."""
    if any(len(piece) > LONG for piece in pieces):
        return [_of_long_piece(model, piece) for piece in pieces]
    return _solved(model, pieces, [_start(model, piece) for piece in pieces])


def _of_long_piece(model: FittedModel, piece: Record) -> Trajectory:
    """A piece from the first states that suit its beginning best."""
    if len(piece) <= LONG:
        return _solved(model, [piece], [_start(model, piece)])[0]
    beginning = _solved(model, [piece.piece(0, BEGINNING)], [_start(model, piece)])[0]
    return simulate(model.joint, model.theta, piece, beginning.x[:, 0])


def _start(model: FittedModel, piece: Record) -> Array | None:
    """The first state (nx,) of a piece, where it is known."""
    return model.first_states.get(piece.name) if piece.begin == 0.0 else None


def _solved(model: FittedModel, pieces: Sequence[Record], starts: Sequence[Array | None]) -> list[Trajectory]:
    """Pieces from the first states that suit them best. starts : (nx,) each, None where they are as measured."""
    problems = [_problem(model, piece) for piece in pieces]
    found = solve_in_a_row(
        problems,
        [one.start() if x0 is None else x0[list(one.free_states)] for one, x0 in zip(problems, starts, strict=True)],
        FIRST_STATES,
    )
    return [one.evaluation.trajectories[0] for one in found]


def _problem(model: FittedModel, piece: Record) -> OutputError:
    """The fit of the first states of a piece."""
    fixed = model.parameters.all_fixed
    return OutputError(model.joint, fixed, (piece,), model.output, np.ones(1), model.estimate_states)


def joined(runs: Sequence[Simulated]) -> Simulated:
    """Stretches of one record, one after the other, as one; its time is that of its pieces."""
    if len(runs) == 1:
        return runs[0]
    records = [run.record for run in runs]
    signals: dict[str, Any] = {
        name: np.concatenate([getattr(record, name) for record in records])
        for name in SIGNALS
        if getattr(records[0], name) is not None
    }
    signals["torque_steps"] = in_a_row([(record.torque_steps, len(record)) for record in records])
    signals["companions"] = {
        name: together([record.companions[name] for record in records]) for name in records[0].companions
    }
    pieces = tuple(piece for run in runs for piece in run.pieces)
    return Simulated(replace(records[0], **signals), pieces, tuple(t for run in runs for t in run.trajectories))
