"""The smoothest input that takes a linear time-varying system along a measured output.

Minimise the squared output errors over their variance, plus the squared steps of the input over theirs, subject to the
system: the fixed-interval smoother (Rauch, Tung & Striebel 1965) of an input that walks at random, written as the
equations of its optimum in states, input and multipliers at all samples at once. They form one banded matrix, for one
LAPACK call (dgbtrf); its determinant gives the marginal likelihood (Bell & Cathey 1993 for the equivalence).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs

from robotid.diagnosis.misfit.settings import MISFIT
from robotid.model.array import Array, blocks

WINDOW = 40_000  # samples solved at once, a few hundred bytes a state each: any number gives the same states
OVERLAP = 1_000  # samples solved twice at the border of two windows, lest there is a seam


@dataclass(frozen=True, slots=True, eq=False)
class Smoothed:
    """States x (nx, n) and input w (n,) of largest probability; evidence : logarithm of the marginal likelihood, up to
    a constant that depends on the data only, minus infinity where these determine no states and no input, which are not
    numbers then."""

    x: Array
    w: Array
    evidence: float


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """x[k+1] = G[k] x[k] + g[k] + b[k] (w[k] + v[k]), y[k] = x[row, k] + e[k].

    G (nx, nx, n - 1), g and b (nx, n - 1), y (n,); output and torque : standard deviations of e and v. first : (nx,)
    first state, known to within its `spread` (nx,); size : of the largest input that is thinkable.
    """

    G: Array
    g: Array
    b: Array
    y: Array
    row: int
    output: float
    torque: float
    first: Array
    spread: Array
    size: float

    def smooth(self, step: float) -> Smoothed:
        """step : standard deviation of the input's change from sample to sample."""
        n = len(self.y)
        if n <= WINDOW + 2 * OVERLAP:
            return self._solve(step)
        x, w, evidence = np.empty((len(self.G), n)), np.empty(n), 0.0
        for at in blocks(n, WINDOW):
            begin = max(0, at.start - OVERLAP)
            part = self._part(begin, min(n, at.stop + OVERLAP), x[:, begin])._solve(step)
            kept = slice(at.start - begin, at.stop - begin)
            x[:, at], w[at] = part.x[:, kept], part.w[kept]
            evidence += part.evidence
        return Smoothed(x, w, evidence)

    def excerpt(self) -> Chain:
        """The part of a long system in which the output moves most, to choose `step` by."""
        length = MISFIT.excerpt
        if len(self.y) <= length:
            return self
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(self.y)))])
        begin = int(np.argmax(way[length:] - way[:-length]))
        return self._part(begin, begin + length, np.zeros(len(self.G)))

    def _part(self, begin: int, end: int, first: Array) -> Chain:
        """Samples begin .. end - 1, from about this state unless they are the first ones."""
        steps = slice(begin, end - 1)
        known = self.first if begin == 0 else first
        G, g, b = self.G[:, :, steps], self.g[:, steps], self.b[:, steps]
        return replace(self, G=G, g=g, b=b, y=self.y[begin:end], first=known)

    def _solve(self, step: float) -> Smoothed:
        """Unknowns sample by sample: states, input, multipliers of the step that follows; all of order one."""
        nx, n = len(self.G), len(self.y)
        k, scale = 2 * nx + 1, self.spread
        rhs = np.zeros((n, k))
        rhs[:, self.row] = scale[self.row] * self.y / self.output**2
        rhs[0, :nx] += self.first / scale
        rhs[:-1, nx + 1 :] = (self.g / scale[:, None]).T
        lu, pivots, singular = dgbtrf(self._matrix(step), k, k, overwrite_ab=True)
        if singular:  # as where the motor rests throughout: no input moves what was measured
            return Smoothed(np.full((nx, n), np.nan), np.full(n, np.nan), -np.inf)
        solved, _ = dgbtrs(lu, k, k, rhs.reshape(-1, 1), pivots, overwrite_b=True)
        z = solved.reshape(n, k)
        x, w, force = z[:, :nx].T * scale[:, None], z[:, nx] * self.size, z[:-1, nx + 1 :].T / scale[:, None]
        cost = float(
            np.sum((self.y - x[self.row]) ** 2) / self.output**2
            + np.sum(np.diff(w) ** 2) / step**2
            + np.sum(((x[:, 0] - self.first) / scale) ** 2)
            + (w[0] / self.size) ** 2
            + self.torque**2 * np.sum(np.einsum("in,in->n", self.b, force) ** 2)
        )
        determinant = float(np.sum(np.log(np.abs(lu[2 * k])))) + 2 * (n - 1) * float(np.log(step / self.size))
        return Smoothed(x, w, -0.5 * (cost + determinant))

    def _matrix(self, step: float) -> Array:
        """The symmetric matrix in LAPACK's banded storage, with room for its factors."""
        nx, n, scale = len(self.G), len(self.y), self.spread
        k, w, force = 2 * nx + 1, nx, nx + 1
        band = np.zeros((3 * k + 1, k * n), order="F")

        def put(i: int, j: int, value: Array) -> None:
            """Entries (i, j) and (j, i) of every sample's block; i or j beyond it reach into the next block."""
            for p, q in {(i, j), (j, i)}:
                band[2 * k + p - q, q::k][: len(value)] = value

        stiff = (self.size / step) ** 2
        put(w, w, np.concatenate([[stiff + 1.0], np.full(n - 2, 2 * stiff), [stiff]]))
        put(w, w + k, np.full(n - 1, -stiff))
        G, b = self.G * scale[None, :, None] / scale[:, None, None], self.b / scale[:, None]
        for i in range(nx):
            known = np.full(n, (scale[i] / self.output) ** 2 if i == self.row else 0.0)
            known[0] += 1.0
            put(i, i, known)
            put(force + i, k + i, np.ones(n - 1))
            put(force + i, w, -self.size * b[i])
            for j in range(nx):
                put(force + i, j, -G[i, j])
            for j in range(i):
                put(force + i, force + j, -(self.torque**2) * b[i] * b[j])
            # After the last sample no step follows: its multipliers are nothing.
            put(force + i, force + i, np.append(-(self.torque**2) * b[i] ** 2, 1.0))
        return band
