"""The noise that residuals are judged by: that of the sensors, and torque errors that nothing known explains."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from robotid.diagnosis.noise.noise_floor import noise_levels, spectrum, whittle
from robotid.diagnosis.noise.whitening import Whitening, whitening
from robotid.diagnosis.scoring.score_test import Scan, unexplained
from robotid.estimate.covariance import ABSORBED
from robotid.model.array import Array
from robotid.signals.record import Quantity

LEAST, CLOSE = 1e-12, 0.1  # of the largest torque variance that is tried; of its logarithm
BLUNT = 0.25  # of the typical output noise: a record that shows less was at rest
UNEXPLAINED = 2.0  # energy over that of noise, beyond which a torque error is assumed that nothing explains
NEARLY, FAR = 0.02, 20.0  # of the misfit, and of noise energies: as close as linear columns come to a large one


def estimate_noise(
    scans: Sequence[Scan], output: Quantity, row: int, freed: Callable[[], Sequence[Array]], *, errors: bool
) -> tuple[tuple[Whitening, ...], bool]:
    """The whitening of every record, and whether the sensors' noise can be reached. row : state that is the output;
    freed : gives what free curves leave, if need be; errors : whether to assume torque errors.

    Where even all candidates and free curves leave more than the sensors' noise, the model lacks what no catalogue has:
    that may count as a white error of the torque, as large as it takes, lest its every detail be explained.
    """
    noise = noise_levels([one.segment for one in scans], output)
    typical = float(np.median([n.output for n in noise]))
    levels = [max(n.output, BLUNT * typical) ** 2 for n in noise]
    torque = noise[0].torque ** 2  # of all
    before = _excess(scans, [one.residual for one in scans], row, levels, torque)
    left: Sequence[Array] = [unexplained(one) for one in scans]
    if _excess(scans, left, row, levels, torque) > UNEXPLAINED:
        left = freed()
    reached = _excess(scans, left, row, levels, torque) <= max(UNEXPLAINED, min(NEARLY * before, FAR))
    if errors and not reached:
        levels, torque = _as_left(scans, left, output, row, levels, torque)
    return _filters(scans, row, levels, torque), reached


def _as_left(
    scans: Sequence[Scan], left: Sequence[Array], output: Quantity, row: int, levels: Sequence[float], torque: float
) -> tuple[list[float], float]:
    """Noises as large as what is left shows them, none smaller than the sensors' own (Whittle 1953)."""
    found = []
    for one, e in zip(scans, left, strict=True):
        seen = spectrum(one.trajectory, e, output)
        both = np.stack([np.ones_like(seen.response), seen.response])
        found.append(whittle(seen.power[ABSORBED:], both[:, ABSORBED:])[0])
    typical = float(np.median([f[0] for f in found]))
    raised = [max(level, float(f[0]), BLUNT**2 * typical) for level, f in zip(levels, found, strict=True)]
    most = max(torque, float(np.median([f[1] for f in found])))
    return raised, _enough(scans, left, row, raised, torque, most)


def _enough(
    scans: Sequence[Scan], left: Sequence[Array], row: int, levels: Sequence[float], torque: float, most: float
) -> float:
    """The variance of the torque error with which what is left has the energy of noise, and no more than most."""
    if _excess(scans, left, row, levels, most) >= 1.0:
        return most
    low, high = np.log(max(torque, LEAST * most)), np.log(most)
    while high - low > CLOSE:
        middle = (low + high) / 2
        enough = _excess(scans, left, row, levels, float(np.exp(middle))) < 1.0
        low, high = (low, middle) if enough else (middle, high)
    return float(np.exp(high))


def _filters(scans: Sequence[Scan], row: int, levels: Sequence[float], torque: float) -> tuple[Whitening, ...]:
    return tuple(
        whitening(t.joint, t.theta, row, t.sampling_time, (level, torque))
        for t, level in zip((one.trajectory for one in scans), levels, strict=True)
    )


def _excess(scans: Sequence[Scan], left: Sequence[Array], row: int, levels: Sequence[float], torque: float) -> float:
    """Energy of what is left, over that of the noise."""
    filters = _filters(scans, row, levels, torque)
    energy = sum(float(np.sum(w(e) ** 2)) for w, e in zip(filters, left, strict=True))
    return energy / sum(map(len, left))
