"""The three steps of the paper in a row: the joint as if it were rigid, what flexes, and then everything at once."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotid.catalogue import assemble
from robotid.estimate.flexible import FlexResult, fit_flexible
from robotid.estimate.responses import ResponseOptions
from robotid.estimate.rigid import RigidResult, fit_rigid
from robotid.model.joint import Joint
from robotid.model.parameters import KnownParameter, Parameters
from robotid.model.structure import Structure
from robotid.signals.differentiate import ParallelFilter
from robotid.signals.record import Record, Use

Known = Mapping[str, KnownParameter]
"""What is known of the parameters beforehand, by dotted name."""


@dataclass(frozen=True, slots=True)
class StartOptions:
    """How steps 1 and 2 find where a fit starts.

    cutoff [Hz] and order of the zero-phase low-pass filter of step 1, cutoff None : chosen from the excitation; samples
    slower than min_speed [rad/s] are left out of step 1. band [Hz] : where frequency responses are read, None : the
    excitation's own. window [s] : length of a segment, None : the excitation's period. experiments : records that tell
    several axes apart, in groups of as many as axes.
    """

    cutoff: float | None = None
    order: int = 4
    min_speed: float = 0.0
    band: tuple[float, float] | None = None
    window: float | None = None
    experiments: tuple[tuple[str, ...], ...] = ()


def initialise_rigid(
    structure: Structure, known: Known, records: Sequence[Record], options: StartOptions
) -> RigidResult:
    """Step 1 on the records of role estimate and use rigid or both.

    Raises NumericsError where there is none, or where they cannot tell the parameters.
    """
    joint = assemble(structure)
    parameters, serving = joint.parameters().with_known(known), _serving(records, "rigid")
    return fit_rigid(joint, parameters, serving, ParallelFilter(options.cutoff, options.order, options.min_speed))


def initialise_flexible(
    structure: Structure, known: Known, records: Sequence[Record], rigid: RigidResult, options: StartOptions
) -> FlexResult:
    """Step 2 on the records of role estimate and use flex or both; empty, with a remark, for a joint that cannot flex.

    Raises NumericsError where step 1 found no inertia or a record is not excited in the band.
    """
    joint = assemble(structure)
    parameters = joint.parameters().with_known(known).with_values(rigid.guesses)
    reading = ResponseOptions(options.band, options.window, options.experiments)
    return fit_flexible(joint, parameters, rigid, _serving(records, "flex"), reading)


def starting_parameters(
    joint: Joint, known: Known, found: Mapping[str, float], fixed: Collection[str] = ()
) -> Parameters:
    """Where step 3 starts, the model m0: declared guesses, over them what steps 1 and 2 found, over them what is known.

    fixed : parameters that are not estimated, besides those that are known to be.
    """
    parameters = joint.parameters().with_known(known)
    values, free = parameters.values.copy(), parameters.free.copy()
    for k, name in enumerate(parameters.names):
        one = known.get(name, KnownParameter())
        if name in found and one.guess is None:
            values[k] = found[name]
        free[k] &= name not in fixed and not one.fixed
    return replace(parameters, values=np.clip(values, parameters.lower, parameters.upper), free=free)


def _serving(records: Sequence[Record], use: Use) -> list[Record]:
    """The records that serve a step."""
    return [r for r in records if r.role == "estimate" and r.use in (use, "both")]
