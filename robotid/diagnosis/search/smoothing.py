"""Whether a delay does more than smooth the noise of the torque.

A logged torque that is noisy drives a simulation with its noise. Whatever is late by a part of an interval averages
neighbouring samples, and less of that noise arrives: the simulation gains, on every record, by a delay that no machine
has. Once the noise has been taken out of the torque, by a filter that shifts nothing in time, such a delay is gone, and
one of the machine is still there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from robotid.catalogue import is_late
from robotid.diagnosis.criteria import Criteria
from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.search.physical_sense import amplitudes
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.signals.white_floor import WithoutFloor

if TYPE_CHECKING:
    from robotid.diagnosis.search.step import Step


def is_smoothing(step: Step, criteria: Criteria) -> str | None:
    """A delay must be there when the noise of the torque is not; one that was larger beside that noise, by more than
    half an interval, for within an interval nobody knows how a log holds its torque."""
    late = list(_delays(step.added))
    if not late:
        return None
    fitted = tuple(map(_quiet, step.data.fitted))
    smooth = step.refitted_to(fitted, step.after.parameters, step.after.trajectories)
    if smooth is None:
        return None
    half = 0.5 * max(one.record.sampling_time for one in step.data.fitted)
    for effect in late:
        ((k, left),), (found,) = amplitudes(smooth, effect).items(), amplitudes(step.after, effect).values()
        std = float(np.sqrt(max(0.0, smooth.covariance[k, k])))
        smooths = found - left > ACCEPTANCE.amplitude_sigma * std
        if left < ACCEPTANCE.amplitude_sigma * std or (smooths and left < half):
            sizes = f"{1e3 * left:.2g} ms of {1e3 * found:.2g} ms"
            return f"smooths the noise of the torque: without that, {sizes} are left"
    return None


def _delays(effects: tuple[str, ...]) -> Iterator[str]:
    """Those of the effects that make a signal late."""
    for effect in effects:
        if is_late(effect):
            yield effect


def _quiet(one: Segment) -> Segment:
    """A segment driven by what stands out of its torque's noise."""
    torque = one.record.tau_m
    smooth = WithoutFloor.of(torque, one.whitening.levels.torque)(torque)
    return Segment(replace(one.record, tau_m=smooth), one.whitening)
