"""What segments of a record say about the parameters of a model, block by block of time.

The residual is whitened by the noise that the model leaves on the records of its fit, of whatever colour, and what the
first states of a segment may take is taken from it. A change of the parameters then shows along their columns. How
uncertain that is, the scatter from block to block tells (the jackknife), whatever the whitening has left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import mannwhitneyu
from scipy.stats import t as student

from robotid.diagnosis.noise.whitening import Segment
from robotid.diagnosis.refit.refitted_model import SegmentFit, Unknowns
from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, blocked, together
from robotid.diagnosis.scoring.projection import beyond
from robotid.diagnosis.scoring.scan import scan
from robotid.model.array import Array

DEPENDENT = 1e-10  # eigenvalue of a scaled covariance below which a direction has no uncertainty to compare by


@dataclass(frozen=True, slots=True, eq=False)
class LogEvidence:
    """The regression of a record's residual on the parameters of a model. lengths : samples of each block, (B,)."""

    blocks: BlockedRegression
    lengths: Array

    @property
    def residual_energy(self) -> Array:
        """What the model leaves, by block, a sample, (B,)."""
        return np.asarray(self.blocks.energy / self.lengths)

    def take(self, columns: Sequence[int]) -> LogEvidence:
        """The evidence on some of the parameters only."""
        return LogEvidence(self.blocks.take(columns), self.lengths)


def evidence_of(
    fits: Sequence[SegmentFit], segments: Sequence[Segment], unknowns: Unknowns, length: float
) -> LogEvidence:
    """The evidence of segments in blocks of about `length` samples. segments : the same, with the filters that whiten
    their noise."""
    parts, lengths = [], []
    for one, segment in zip(fits, segments, strict=True):
        white = segment.whitening(scan(one, unknowns, ()).signals)
        states = white[: len(unknowns.first_states)]
        signals = np.stack([beyond(row, states) for row in white[len(states) :]])
        part = blocked(signals[:-1], signals[-1], length)
        parts.append(part)
        lengths += [len(one.residual) / part.count] * part.count
    return LogEvidence(together(parts), np.array(lengths))


@dataclass(frozen=True, slots=True)
class SingleShift:
    """One parameter as a log asks for it, all others as they are: its change, the standard deviation, and the p-value
    of none."""

    value: float
    std: float
    p_value: float


def single_shift(fitted: LogEvidence, log: LogEvidence, k: int) -> SingleShift:
    """The change of parameter k alone, by a t-test. Uncertain are what the log says, and what the fit knows of all
    parameters, whose errors reach the log along its own columns."""
    alone = log.blocks.take([k])
    total = log.blocks.information.sum(axis=0)
    reach = total[k] / max(total[k, k], np.finfo(np.float64).tiny)
    variance = float(alone.covariance()[0, 0] + reach @ fitted.blocks.covariance() @ reach)
    value, std = float(alone.estimate()[0]), sqrt(variance)
    freedom = min(one.blocks.telling_blocks([k]) for one in (fitted, log)) - 1.0
    if freedom < 1.0 or std == 0.0:
        return SingleShift(value, std, 1.0)
    return SingleShift(value, std, float(2.0 * student.sf(abs(value) / std, freedom)))


def parameters_p_value(fitted: LogEvidence, log: LogEvidence) -> float:
    """p-value of a log having the parameters of the fit: the smaller one of all together and of the best single one,
    corrected for their number."""
    count = len(log.blocks.moment[0])
    single = [count * single_shift(fitted, log, k).p_value for k in range(count)]
    return min(1.0, 2.0 * min([together_p_value(fitted, log), *single]))


def together_p_value(fitted: LogEvidence, log: LogEvidence) -> float:
    """p-value of no parameter being another: Hotelling's test of the difference that a log asks for, with the
    uncertainty of the log and that of the fit itself. One where there are not more blocks than parameters."""
    k = len(log.blocks.moment[0])
    count = min(one.blocks.telling_blocks(range(k)) for one in (fitted, log)) if k else 0.0
    if count <= k + 1:
        return 1.0
    covariance = log.blocks.covariance() + fitted.blocks.covariance()
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(np.float64).tiny))
    variances, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    along = axes.T @ (log.blocks.estimate() / scale)
    kept = variances > DEPENDENT
    wald = float(np.sum(along[kept] ** 2 / variances[kept]))
    k = int(kept.sum())
    return float(fisher.sf(wald * (count - k) / (k * (count - 1)), k, count - k))


def beyond_uncertainty(fitted: LogEvidence, log: LogEvidence) -> Array:
    """What the model leaves of a log, by block, a sample, (B,), with the parameters that suit the log best among those
    that the records of the fit leave possible: the most likely ones, the covariance of the fit their prior, and what
    they cost by that taken off what they explain."""
    usual = max(float(np.mean(fitted.residual_energy)), np.finfo(np.float64).tiny)
    information, moment = log.blocks.information, log.blocks.moment
    if not moment.shape[1]:
        return log.residual_energy
    # C (I C + s)^-1 m = (I + s C^-1)^-1 m, and needs no inverse of a covariance of nothing
    covariance = fitted.blocks.covariance()
    total = information.sum(axis=0) @ covariance + usual * np.eye(moment.shape[1])
    change = covariance @ np.linalg.lstsq(total, moment.sum(axis=0), rcond=None)[0]
    return np.asarray((log.blocks.energy - moment @ change) / log.lengths)


def residual_p_value(fitted: LogEvidence, log: LogEvidence) -> float:
    """p-value of what the model leaves being no larger than on the records of the fit, by the ranks of the blocks'
    energies (Mann & Whitney 1947)."""
    return _louder(log.residual_energy, fitted)


def unforeseen_p_value(fitted: LogEvidence, log: LogEvidence) -> float:
    """The same of what the model leaves beyond the uncertainty of its parameters."""
    return _louder(beyond_uncertainty(fitted, log), fitted)


def _louder(energies: Array, fitted: LogEvidence) -> float:
    return float(mannwhitneyu(energies, fitted.residual_energy, alternative="greater").pvalue)
