"""Whether the motion drives what a cause remembers, or only its first states do.

A cause with states of its own has first values of these in every record. A tool that swings without damping, once it is
set going, is a sine of time: it explains whatever shakes the joint from outside, also on records that it was not fitted
to, and nothing that the joint does moves it.
"""

from __future__ import annotations

import numpy as np

from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import RefittedModel, SegmentFit, segment_fit
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.diagnosis.search.step import Step
from robotid.errors import NumericsError
from robotid.simulation.simulate import simulate


def starts_by_itself(step: Step, criteria: Criteria) -> str | None:
    """A cause must explain something once its memory starts where the motion leaves it."""
    for effect in step.added:
        settled = energy_from_rest(step.after, effect)
        if settled is None:
            continue
        explained, kept = step.before.energy - step.after.energy, step.before.energy - settled
        if kept < ACCEPTANCE.worthless_share * explained:
            share = 100.0 * max(0.0, kept / explained) if explained > 0.0 else 0.0
            return f"is not driven by the motion: started as this leaves it, {share:.0f} % of what it explains are left"
    return None


def energy_from_rest(model: RefittedModel, effect: str) -> float | None:
    """Energy of the whitened residuals on the fitted segments where the memory of an effect starts as long motion would
    leave it, in variances of the noise; None where it has no memory, or cannot be simulated so."""
    rows = memory_of(model, effect)
    if not rows:
        return None
    try:
        return sum(_from_rest(model, one, rows) for one in model.fitted)
    except NumericsError:
        return None


def memory_of(model: RefittedModel, effect: str) -> list[int]:
    """The states that are the memory of an effect."""
    return [k for place in model.joint.placed if place.effect == effect for k in range(place.z.start, place.z.stop)]


def _from_rest(model: RefittedModel, one: SegmentFit, rows: list[int]) -> float:
    joint, theta, first = one.trajectory.joint, one.trajectory.theta, one.trajectory.x[:, :1].copy()
    first[rows] = joint.settled(first, np.sign(first[joint.speeds]), one.trajectory.t[:1], theta)[rows]
    trajectory = simulate(model.joint, model.parameters.values, one.record, first[:, 0], one.trajectory.x)
    return segment_fit(Segment(one.record, one.whitening), trajectory, model.output).energy
