"""The spectrum of what a model leaves of a record, before and after its extension, beside that of the noise alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotid.diagnosis.noise.noise_floor import noise_levels
from robotid.diagnosis.noise.spectrum import segment_spectrum
from robotid.errors import NumericsError
from robotid.estimate.fitted_model import Simulated, SimulatedSegment
from robotid.model.array import Array
from robotid.signals.record import Quantity

BINS_A_DECADE = 12  # over which a periodogram is averaged, so that two spectra can be distinguished
MIN_LINES = 3  # frequencies in a bin: a mean of fewer scatters by more than it tells


@dataclass(frozen=True, slots=True, eq=False)
class ResidualSpectra:
    """Amplitude densities at `frequency` (m,) [Hz], (m,) each, in the unit of the output over root hertz.

    before, after : of what a model and its extension leave, after None where there is none. noise : of the noise of the
    output and of the recorded torque together, at the levels that the diagnosis takes them to have.
    """

    frequency: Array
    before: Array
    after: Array | None
    noise: Array


def residual_spectra(before: Simulated, after: Simulated | None, output: Quantity) -> ResidualSpectra:
    """The spectra of one record; the noise as it shows in what is left last.

    Raises NumericsError where what is left is nothing but rounding, which has no spectrum.
    """
    shown = [_density(run, output) for run in (before, *([] if after is None else [after]))]
    if any(density.max(initial=0.0) < np.finfo(float).tiny for _, density in shown):
        raise NumericsError("what is left of the record is nothing but rounding")
    frequency, noise = shown[-1][0], _noise(before if after is None else after, output)
    bins = _bins(frequency)
    centre, first, last, floor = (_mean(signal, bins) for signal in (frequency, shown[0][1], shown[-1][1], noise))
    return ResidualSpectra(centre, np.sqrt(first), None if after is None else np.sqrt(last), np.sqrt(floor))


def _density(run: Simulated, output: Quantity) -> tuple[Array, Array]:
    """Frequencies [Hz] and power density of the residual there, without that of its mean."""
    residual = run.residual(output)
    n, h = len(residual), run.record.sampling_time
    taper = np.hanning(n + 2)[1:-1]
    power = np.abs(np.fft.rfft(taper * (residual - residual.mean()))) ** 2 / np.sum(taper**2)
    return np.asarray(np.fft.rfftfreq(n, h)[1:], dtype=np.float64), 2 * h * power[1:]


def _noise(run: Simulated, output: Quantity) -> Array:
    """Power density of the noise at the same frequencies."""
    first, residual = run.segments(output)[0], run.residual(output)
    levels = noise_levels(run.segments(output), output)
    seen = segment_spectrum(SimulatedSegment(run.record, first.trajectory, residual), output)
    own, torque = (np.mean([getattr(one, name) ** 2 for one in levels]) for name in ("output", "torque"))
    density = np.array([own, torque]) @ seen.shapes
    return np.asarray(2 * run.record.sampling_time * (density if seen.weight is None else seen.weight * density))[1:]


def _bins(frequency: Array) -> list[slice]:
    """Neighbouring frequencies, bins that grow by a factor, and hold a few at least."""
    found, at, factor = list[slice](), 0, 10 ** (1 / BINS_A_DECADE)
    while at < len(frequency):
        stop = max(at + MIN_LINES, int(np.searchsorted(frequency, frequency[at] * factor)))
        found.append(slice(at, min(stop, len(frequency))))
        at = stop
    return found


def _mean(values: Array, bins: list[slice]) -> Array:
    return np.array([values[part].mean() for part in bins])
