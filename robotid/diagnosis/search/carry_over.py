"""Whether a cause helps where it was not fitted: a gain counts by its own spread from block to block of time.

A gain above zero proves nothing: of causes that are none, half gain a little on records that they have not seen. The
decrease of the squared error on blocks of time has a mean and a spread, and a cause gains where the one is beyond the
other (Diebold & Mariano 1995).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import combine_pvalues

from robotid.diagnosis.refit.refitted_model import SegmentFit, decrease
from robotid.diagnosis.scoring.blocked_regression import Gain, gain_of
from robotid.diagnosis.search.settings import ACCEPTANCE
from robotid.model.array import Array

LEAST = 1e-300  # p-value whose logarithm is a number


def gain_by_blocks(before: Sequence[SegmentFit], after: Sequence[SegmentFit]) -> Gain:
    """The decrease of the whitened squared error on segments, block by block of time."""
    return gain_of_samples(list(map(decrease, before, after)))


def gain_of_samples(segments: Sequence[Array]) -> Gain:
    """A decrease of the squared error of every sample of segments, (n,) each, block by block of time."""
    samples = sum(map(len, segments))
    parts = [np.array_split(one, max(1, round(ACCEPTANCE.gain_blocks * len(one) / samples))) for one in segments]
    return gain_of(np.array([float(block.sum()) for part in parts for block in part]))


def together(fitted: float, gain: Gain | None, tries: int = 1) -> float:
    """p-value of something being noise: by the records of the fit or, unless these tell nothing of it, by these
    together with what it gains on records that served for no fit (Fisher 1932), whichever is smaller.

    fitted : by the records of the fit; gain : on the others, None without any; tries : of how many that gain is one.
    """
    if gain is None or not proven(gain) or fitted >= ACCEPTANCE.gain_level:
        return fitted
    both = combine_pvalues([max(fitted, LEAST), min(1.0, tries * gain.p_value)], method="fisher")
    return min(fitted, float(both.pvalue))


def proven(gain: Gain) -> bool:
    """Whether a gain is beyond its own spread."""
    return gain.total > 0.0 and gain.p_value < ACCEPTANCE.gain_level
