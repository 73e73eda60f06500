"""The sizes at which effects raise the fit by so little that it counts as nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robotid.diagnosis.scoring.projection import Projected
from robotid.diagnosis.scoring.scan import Scan
from robotid.diagnosis.search.added_signals import added_signals, in_any_proportion
from robotid.estimate.residual import measured_output
from robotid.model.array import Array


def least_gained(scans: Sequence[Scan], projected: Projected, at: Sequence[slice], gain: float) -> Array:
    """The size of each effect, in any proportion of its amplitudes, that lowers the fit of a model without it by a gain
    [% points], on records like those of the fit; infinite where nothing of it is visible. (effects,)

    scans : every segment with all columns; projected : these; at : where the columns of each effect are.
    """
    output = scans[0].unknowns.output
    measured = [measured_output(one.segment.record, output) for one in scans]
    motion = sum(float(np.sum(np.square(y - y.mean()))) for y in measured)
    left = sum(float(np.sum(np.square(one.signals[-1]))) for one in scans)
    parts = added_signals(scans, projected, [(own, in_any_proportion(own)) for own in at])
    added = np.sum([np.einsum("en,en->e", part, part) for part in parts], axis=0)
    visible = np.array([projected.visible_length(own) > 0.0 for own in at])
    further = gain / 100.0 * np.sqrt(motion)  # (sqrt(left) + further)^2 is what is left with the effect
    return np.where(visible, np.sqrt((further + 2.0 * np.sqrt(left)) * further / np.where(visible, added, 1.0)), np.inf)
