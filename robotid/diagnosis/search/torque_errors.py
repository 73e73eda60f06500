"""Errors of the torque for which what a model leaves passes: how large they are, and whether they are all of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.diagnosis.search.state import SearchResult
from robotid.diagnosis.settings import VERDICT
from robotid.estimate.residual import measured_output
from robotid.model.array import Array


def leaves_only_noise(found: SearchResult) -> bool:
    """Whether noise of any colour is all that the last model leaves, and not so much that it hides what is missing."""
    reached = found.coloured is not None and found.coloured.noise_reached
    return reached and found.curve is None and not found.imitated and not is_swamped(found)


def is_swamped(found: SearchResult) -> bool:
    """Whether what the last model leaves on the records of its fit, and the noise of their output does not cause, is so
    much that errors of the torque hide whatever is missing: of the motion, or of the torque itself."""
    if torque_errors(found)[1] > VERDICT.swamped_torque:
        return True
    return _share_of_motion(found) > VERDICT.swamped_share


def lead_astray(found: SearchResult) -> bool:
    """Whether the simulation of the last model is led far from the motion, by errors of the torque, which are most of
    what it leaves, or by what nothing known explains; or although causes were found that explain most of a misfit: what
    they leave may be what they only imitate."""
    unknown = not found.causes and found.curve is None
    imitated = bool(found.causes) and found.remaining_share <= VERDICT.partial_share
    return (unknown or imitated or (leaves_only_noise(found) and prevail(found))) and strays(found)


def strays(found: SearchResult, residuals: Sequence[Array] | None = None) -> bool:
    """Whether a simulation follows another motion than the measured one. residuals : that it leaves on the records of
    the fit, absent: those of the last model."""
    return _share_of_motion(found, residuals) > VERDICT.astray_share


def _share_of_motion(found: SearchResult, residuals: Sequence[Array] | None = None) -> float:
    """What errors of the torque cause of the squared error on the records of the fit, of the variance of the output."""
    caused, _ = _squared_errors(found, residuals)
    measured = [measured_output(one.record, found.last.output) for one in found.last.fitted]
    moved = sum(float(np.var(y)) * len(y) for y in measured)
    return caused / moved if moved > 0.0 else 0.0


def prevail(found: SearchResult) -> bool:
    """Whether errors of the torque cause more of what the last model leaves than the noise of the output does."""
    caused, noise = _squared_errors(found)
    return caused > noise


def passing(found: SearchResult) -> float:
    """Standard deviation of the errors of the torque for which all that the last model leaves passes [Nm], zero where
    it is more than noise, or mostly noise of the output."""
    return torque_errors(found)[0] if leaves_only_noise(found) and prevail(found) else 0.0


def _squared_errors(found: SearchResult, residuals: Sequence[Array] | None = None) -> tuple[float, float]:
    """What errors of the torque cause of the squared error on the records of the fit, and the noise of their output.
    residuals : as of `strays`."""
    left = [one.residual for one in found.last.fitted] if residuals is None else residuals
    caused = output = 0.0
    for segment, residual in zip((found.coloured or found.data).fitted, left, strict=True):
        noise = segment.whitening.output_variance * len(residual)
        caused += max(0.0, float(residual @ residual) - noise)
        output += noise
    return caused, output


def torque_errors(found: SearchResult) -> tuple[float, float]:
    """Standard deviation of the errors of the torque for which what the last model leaves on the records of its fit
    passes [Nm], and which share of the recorded torque's root mean square it is."""
    errors = torque = 0.0
    for segment in (found.coloured or found.data).fitted:
        levels, recorded = segment.whitening.levels, segment.record.tau_m
        errors += (levels.torque + levels.red) * len(recorded)
        torque += float(recorded @ recorded)
    samples = sum(len(segment.record) for segment in found.data.fitted)
    return float(np.sqrt(errors / samples)), float(np.sqrt(errors / torque)) if torque > 0.0 else 0.0
