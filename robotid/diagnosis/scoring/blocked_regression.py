"""Least squares whose errors are known only to be alike within blocks of time: what an amplitude is worth, honestly.

A recorded torque carries errors of unknown colour, and so does every residual. Its whitening is an estimate, and a test
that believes it takes a slow error for a cause. Here the samples are cut into blocks longer than the memory of the
errors, and every block is left out once: the scatter of the estimates so found (the jackknife; Efron & Stein 1981; as a
cluster-robust covariance: Bell & McCaffrey 2002, CR3) is their uncertainty whatever the colour, the errors that they
make on the block left out are those on data that they have not seen, and an amplitude that drifts from block to block
belongs to an imitator (Nyblom 1989; Hansen 1992).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import f as fisher
from scipy.stats import t as student
from scipy.stats import wilcoxon

from robotid.model.array import Array

DEPENDENT = 1e-12  # relative eigenvalue of the scaled information from which a direction is not determined
CONSTANCY = np.array([[0.34730, 0.10], [0.46136, 0.05], [0.58061, 0.025], [0.74346, 0.01], [1.16786, 0.001]])
"""Statistic and p-value of the constancy of one parameter: the integral of a squared Brownian bridge (Anderson and
Darling 1952, table 1)."""


@dataclass(frozen=True, slots=True, eq=False)
class Gain:
    """What regressors explain of blocks that did not serve to fit them.

    blocks : (B,) decrease of the squared error on each; total : their sum; p_value : one-sided, of no decrease.
    """

    blocks: Array
    p_value: float

    @property
    def total(self) -> float:
        """Decrease of the squared error over all blocks."""
        return float(self.blocks.sum())

    @property
    def telling_blocks(self) -> float:
        """How many blocks tell of it: all where it is as large on each, fewer where few hold most of it."""
        size = np.abs(self.blocks)
        return float(size.sum() ** 2 / max(float(size @ size), 1e-300))

    @property
    def by_its_mean(self) -> float:
        """One-sided p-value of no decrease by its mean over the blocks that tell of it (Vuong 1989): blunter than ranks
        where few hold most of it. One where no more than one tells."""
        free = self.telling_blocks - 1.0
        if free <= 0.0:
            return 1.0
        spread = float(np.std(self.blocks, ddof=1)) * np.sqrt(len(self.blocks))
        return float(student.sf(self.total / max(spread, 1e-300), free))


def gain_of(decrease: Array) -> Gain:
    """A decrease of the squared error on each block (B,), with the p-value of its being as often an increase.

    By the signed ranks (Wilcoxon 1945): what a cause gains is large on blocks where it acts and small on others, and a
    mean over so skewed a distribution would hide a gain on all of them.
    """
    if not decrease.any():
        return Gain(decrease, 1.0)
    return Gain(decrease, float(wilcoxon(decrease, alternative="greater").pvalue))


@dataclass(frozen=True, slots=True, eq=False)
class BlockedRegression:
    """A linear regression y = X' theta + e, kept block by block.

    information : (B, m, m) X X' of each block; moment : (B, m) X y; energy : (B,) y' y.
    """

    information: Array
    moment: Array
    energy: Array

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.energy)

    def take(self, columns: Sequence[int]) -> BlockedRegression:
        """The regression on some of the regressors only."""
        at = list(columns)
        return BlockedRegression(self.information[:, at][:, :, at], self.moment[:, at], self.energy)

    def combined(self, sizes: Mapping[int, float]) -> BlockedRegression:
        """The regression with the regressors `sizes`, by number, as one in these proportions, which is the last."""
        m = self.moment.shape[1]
        others = [k for k in range(m) if k not in sizes]
        way = np.zeros((m, len(others) + 1))
        way[others, range(len(others))] = 1.0
        way[list(sizes), -1] = list(sizes.values())
        return BlockedRegression(way.T @ self.information @ way, self.moment @ way, self.energy)

    def estimate(self) -> Array:
        """Least-squares estimate of all blocks together, (m,)."""
        return solved(self.information.sum(axis=0), self.moment.sum(axis=0))

    def left_out(self) -> Array:
        """The estimate from all blocks but one, for each block, (B, m)."""
        information, moment = self.information.sum(axis=0), self.moment.sum(axis=0)
        pairs = zip(self.information, self.moment, strict=True)
        return np.stack([solved(information - own, moment - part) for own, part in pairs])

    def covariance(self) -> Array:
        """Jackknife covariance of the estimate, (m, m), robust to any correlation within a block."""
        apart = self.left_out() - self.estimate()
        return np.asarray((self.count - 1) / self.count * apart.T @ apart)

    def energy_of(self, at: Sequence[int]) -> float:
        """Squared error that the regressors `at` explain beside the others, in all blocks together."""
        information, moment = self.information.sum(axis=0), self.moment.sum(axis=0)
        others = [k for k in range(len(moment)) if k not in set(at)]
        few = solved(information[np.ix_(others, others)], moment[others]) if others else np.zeros(0)
        return float(moment @ self.estimate() - moment[others] @ few)

    def significance(self, at: Sequence[int]) -> float:
        """p-value of the regressors `at` being absent, by the jackknife's covariance (an F-test).

        One where there are not more blocks than regressors to test.
        """
        k, count = len(at), self.telling_blocks(at)
        if count <= k + 1:
            return 1.0
        statistic = wald(self.estimate()[list(at)], self.covariance()[np.ix_(at, at)])
        return float(fisher.sf(statistic * (count - k) / (k * (count - 1)), k, count - k))

    def least_wald(self, at: Sequence[int], level: float) -> float:
        """Wald statistic of the regressors `at` that is significant at just this level, as of `significance`."""
        k, count = len(at), self.telling_blocks(at)
        return float(fisher.isf(level, k, count - k)) * k * (count - 1) / (count - k)

    def telling_blocks(self, at: Sequence[int]) -> float:
        """How many blocks tell of the regressors `at`: all where each knows as much, fewer where few know most."""
        own = np.einsum("bii->bi", self.information)[:, list(at)]
        share = (own / np.maximum(own.sum(axis=0), 1e-300)).mean(axis=1)
        return float(share.sum() ** 2 / max(float(share @ share), 1e-300))

    def gain(self, at: Sequence[int]) -> Gain:
        """What the regressors `at` explain of each block by the estimate from all the others.

        The decrease counts by its own spread from block to block (Diebold & Mariano 1995).
        """
        others = [k for k in range(self.moment.shape[1]) if k not in set(at)]
        decrease = self.take(others)._errors_left_out() - self._errors_left_out()
        return gain_of(np.asarray(decrease))

    def constancy(self, k: int) -> float:
        """p-value of regressor k having the same amplitude in all blocks, in their order (Hansen 1992).

        Between the rows of the table the logarithm of p is interpolated, beyond them it is extrapolated.
        """
        own, _ = self.scores_of(k)
        variance = float(own @ own)
        if variance == 0.0:
            return 1.0
        statistic = float(np.sum(np.cumsum(own) ** 2) / (self.count * variance))
        logs = np.log(CONSTANCY[:, 1])
        slope = (logs[-1] - logs[-2]) / (CONSTANCY[-1, 0] - CONSTANCY[-2, 0])
        if statistic > CONSTANCY[-1, 0]:
            return float(np.exp(logs[-1] + slope * (statistic - CONSTANCY[-1, 0])))
        return float(np.exp(np.interp(statistic, np.append(0.0, CONSTANCY[:, 0]), np.append(0.0, logs))))

    def scores_of(self, k: int) -> tuple[Array, Array]:
        """What each block asks regressor k to be more than all together do, and what it knows of it, (B,) each; the
        other regressors allowed for."""
        theta, m = self.estimate(), self.moment.shape[1]
        scores = self.moment - np.einsum("bij,j->bi", self.information, theta)
        way = np.zeros(m)
        way[k] = 1.0
        others = [j for j in range(m) if j != k]
        if others:
            total = self.information.sum(axis=0)
            way[others] = -solved(total[np.ix_(others, others)], total[others, k])
        return scores @ way, np.einsum("i,bij,j->b", way, self.information, way)

    def _errors_left_out(self) -> Array:
        """Squared error of each block with the estimate from all the others, (B,)."""
        if not self.moment.shape[1]:
            return self.energy
        theta = self.left_out()
        quadratic = np.einsum("bi,bij,bj->b", theta, self.information, theta)
        return np.asarray(self.energy - 2.0 * np.einsum("bi,bi->b", theta, self.moment) + quadratic)


def blocked(columns: Array, signal: Array, length: float) -> BlockedRegression:
    """A regression cut into blocks of about `length` samples. columns (m, n), signal (n,)."""
    parts = _blocks(len(signal), length)
    return BlockedRegression(
        np.stack([columns[:, at] @ columns[:, at].T for at in parts]),
        np.stack([columns[:, at] @ signal[at] for at in parts]),
        np.array([float(signal[at] @ signal[at]) for at in parts]),
    )


def blocked_beside(basis: Array, signals: Array, length: float, negligible: float) -> BlockedRegression:
    """The regression of the last of signals (m + 1, n) on the others, less what all of them have along an orthonormal
    basis (n, s): block by block, lest signals are copied that do not stay in a processor's cache.

    negligible : length, relative to the one before, up to which what is left of a signal is rounding, and nothing.
    """
    along, before, products = signals @ basis, np.zeros(len(signals)), []
    for at in _blocks(len(basis), length):
        before += np.einsum("mn,mn->m", signals[:, at], signals[:, at])
        left = along @ basis[at].T
        np.subtract(signals[:, at], left, out=left)
        products.append(left @ left.T)
    found = np.stack(products)
    kept = np.einsum("bmm->m", found) > negligible**2 * before
    found *= np.outer(kept, kept)
    return BlockedRegression(found[:, :-1, :-1], found[:, :-1, -1], found[:, -1, -1])


def _blocks(n: int, length: float) -> list[slice]:
    """n samples in blocks of about this length."""
    count = max(1, round(n / length))
    edges = np.linspace(0, n, count + 1).round().astype(int)
    return [slice(a, b) for a, b in pairwise(edges.tolist())]


def together(parts: Sequence[BlockedRegression]) -> BlockedRegression:
    """Several records' blocks, one after the other, with the same regressors."""
    return BlockedRegression(
        np.concatenate([one.information for one in parts]),
        np.concatenate([one.moment for one in parts]),
        np.concatenate([one.energy for one in parts]),
    )


def wald(sizes: Array, covariance: Array) -> float:
    """Squared distance of sizes (k,) from nothing in deviations of their covariance (k, k)."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    return float(sizes / scale @ np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True) @ (sizes / scale))


def solved(information: Array, moment: Array) -> Array:
    """The solution of least norm of normal equations whose unknowns are of unlike size. information (m, m), moment
    (m,) or (m, k)."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    scaled = information / np.outer(scale, scale)
    inverse = np.linalg.pinv(scaled, rcond=DEPENDENT, hermitian=True)
    return np.asarray((inverse @ (moment.T / scale).T).T / scale).T
