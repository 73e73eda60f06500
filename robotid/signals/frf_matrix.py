"""Frequency responses from the torques of several axes to the accelerations of all, from experiments at once.

With as many experiments as axes, Y(k) = G(k) U(k) at every line k, columns by experiment, and G = Y U^-1. The ratio is
the same as that of both regressed on the references, so that noise which the controllers feed back does not bias it.
Means over poses and over redrawn phases are taken of the logarithm, which weighs a resonance as much as a notch
(Wernholt & Moberg 2008, IFAC World Congress; Guillaume, Pintelon & Schoukens 1992, IEEE Trans. Instrum. Meas. 41(6)).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from robotid.errors import NumericsError
from robotid.model.array import Array, Complex
from robotid.signals.frf import Frf, period_spectra
from robotid.signals.record import Record

LARGEST_CONDITION = 1e4  # of the torques of all experiments at a line


@dataclass(frozen=True, slots=True, eq=False)
class FrfMatrix:
    """axes : their names, k of them. response (k, k, n) : complex, from the torque of the second axis [Nm] to the
    acceleration of the first [rad/s2]. std (k, k, n) : of its error, as E|error|^2 = std^2; nan where a single period
    does not tell."""

    axes: tuple[str, ...]
    frequency: Array = field(metadata={"unit": "Hz"})
    response: Complex = field(metadata={"unit": "rad/s2/Nm"})
    std: Array = field(metadata={"unit": "rad/s2/Nm"})

    def free(self, axis: str) -> Frf:
        """The response of an axis to its own torque while no torque acts on the others, whose motors then move."""
        k = self.axes.index(axis)
        return Frf(axis, self.frequency, self.response[k, k], self.std[k, k])

    def alone(self, axis: str) -> Frf:
        """The response of an axis to its own torque while the motors of all others stand, as if it were the only one:
        its notches are the resonances of the arms while all motors stand."""
        k = self.axes.index(axis)
        stiffness = np.linalg.inv(np.moveaxis(self.response, -1, 0))
        response: Complex = np.asarray(1.0 / stiffness[:, k, k], dtype=np.complex128)
        # to first order d(G^-1) = -G^-1 dG G^-1, the errors of the entries independent
        own = np.einsum("ni,ijn,nj->n", np.abs(stiffness[:, k]) ** 2, self.std**2, np.abs(stiffness[:, :, k]) ** 2)
        return Frf(axis, self.frequency, response, np.abs(response) ** 2 * np.sqrt(own))


def estimate_frf_matrix(
    experiments: Sequence[Mapping[str, Record]], band: tuple[float, float] | None = None
) -> FrfMatrix:
    """The responses of all axes from periodic experiments, as many as there are axes.

    experiments : the records of each by axis; band [Hz] : where the lines lie, by default the records' own. The first
    of several periods is left out.
    Raises NumericsError where the experiments do not tell the axes apart.
    """
    axes = tuple(experiments[0])
    if len(experiments) != len(axes):
        what = f"{len(experiments)} experiments cannot tell {len(axes)} axes apart"
        raise NumericsError(what, hint="make as many experiments as axes, with orthogonal phases")
    band = band or experiments[0][axes[0]].band
    found = [[period_spectra(one[axis]) for axis in axes] for one in experiments]
    frequency = found[0][0].frequency
    low, high = (0.0, np.inf) if band is None else band
    lines = np.flatnonzero((frequency >= low * (1 - 1e-6)) & (frequency <= high * (1 + 1e-6)))
    # (lines, axes, experiments, periods)
    torque, acceleration = (
        np.moveaxis(np.array([[getattr(one, name)[:, lines] for one in row] for row in found]), (3, 1, 0, 2), range(4))
        for name in ("torque", "acceleration")
    )
    u, y = torque.mean(axis=-1), acceleration.mean(axis=-1)
    kept = np.linalg.cond(u) < LARGEST_CONDITION
    if np.count_nonzero(kept) < 2:
        what = "the torques of the experiments do not tell the axes apart at any frequency"
        raise NumericsError(what, hint="excite all axes at the same lines, with orthogonal phases")
    u, y, lines = u[kept], y[kept], lines[kept]
    inverse = np.linalg.inv(u)
    response = y @ inverse
    periods = torque.shape[-1]
    left = acceleration[kept] - np.einsum("nij,njep->niep", response, torque[kept])
    noise = left.var(axis=-1, ddof=1) / periods if periods > 1 else np.full(y.shape, np.nan)
    std = np.sqrt(np.einsum("nie,nej->nij", noise, np.abs(inverse) ** 2))
    return FrfMatrix(axes, frequency[lines], np.moveaxis(response, 0, -1), np.moveaxis(std, 0, -1))


def log_mean(matrices: Sequence[FrfMatrix]) -> FrfMatrix:
    """The mean of the logarithm over poses or redrawn phases, all at the same lines. std : by the scatter of several.

    Raises NumericsError where the lines differ.
    """
    first = matrices[0]
    if any(one.axes != first.axes or not np.array_equal(one.frequency, first.frequency) for one in matrices):
        raise NumericsError("responses of other lines or axes have no mean", hint="use one excitation in all poses")
    if len(matrices) == 1:
        return first
    responses = np.array([one.response for one in matrices])
    about = responses.mean(axis=0)
    logarithms = np.log(responses / about)  # of ratios near one, whose phases do not wrap around
    response = about * np.exp(logarithms.mean(axis=0))
    scatter = np.sqrt(logarithms.var(axis=0, ddof=1) / len(matrices))
    return FrfMatrix(first.axes, first.frequency, response, np.abs(response) * scatter)
