"""Frequency response from torque to acceleration, safe in closed loop.

The reference is the instrument: both torque and acceleration are regressed on it, and the response is the ratio of the
two, so that noise which the controller feeds back does not bias it (Pintelon & Schoukens 2001). Without a reference the
torque itself is the instrument, and that bias is a remark; the mean over periods needs neither.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from robotid.errors import NumericsError
from robotid.model.array import Array, Complex, Index
from robotid.signals.differentiate import bandwidth, central_difference
from robotid.signals.local_polynomial import local_response
from robotid.signals.record import Record

EXCITED = 1e-3  # amplitude of an excited line, relative to the largest in the band
SMALLEST = 1e-100  # [rad/s2/Nm] of any machine
LINES = 400  # most lines that are evaluated
LONGEST_WINDOW = 20.0  # [s] resolution asked of a record that does not repeat
IN_CLOSED_LOOP = "no reference: the response is biased if a controller closed the loop"


@dataclass(frozen=True, slots=True, eq=False)
class Frf:
    """A frequency response at the excited lines.

    response (n,) : complex, from motor torque [Nm] to motor acceleration [rad/s2]. std (n,) : of its error, as
    E|error|^2 = std^2. noise_std (n,) : the part of it that changes from period to period, where periods were compared.
    distortion_std (n,) : what nonlinearity adds to one realisation of the excitation, where several were compared.
    """

    record: str
    frequency: Array = field(metadata={"unit": "Hz", "shape": ("n",), "positive": True})
    response: Complex = field(metadata={"unit": "rad/s2/Nm", "shape": ("n",), "finite": True})
    std: Array = field(metadata={"unit": "rad/s2/Nm", "shape": ("n",), "least": 0.0})
    noise_std: Array | None = field(default=None, metadata={"unit": "rad/s2/Nm", "shape": ("n",), "least": 0.0})
    distortion_std: Array | None = field(default=None, metadata={"unit": "rad/s2/Nm", "shape": ("n",), "least": 0.0})
    remarks: tuple[str, ...] = ()

    def contradictions(self) -> Iterator[str]:
        """What cannot be, as sentences: for a response that was read from a file."""
        size = np.abs(self.response)
        if not size.any() or (size[size > 0.0] < SMALLEST).any():
            yield f"the response of {self.record} is none"

    @property
    def omega(self) -> Array:
        """Frequency [rad/s], (n,)."""
        return 2 * np.pi * self.frequency

    @property
    def speed_response(self) -> Complex:
        """The same from torque to speed [rad/s/Nm], (n,)."""
        return self.response / (1j * self.omega)


@dataclass(frozen=True, slots=True, eq=False)
class Spectra:
    """Complex amplitudes at the lines of one or more stretches of a record, (stretches, lines), and the lines [Hz].

    instrument : see `_instrument`.
    """

    frequency: Array
    torque: Complex
    acceleration: Complex
    instrument: Complex


def estimate_frf(
    record: Record,
    band: tuple[float, float] | None = None,
    window: float | None = None,
    torque: Array | None = None,
    highest: float = np.inf,
) -> Frf:
    """Frequency response of one record.

    band [Hz], absent : the excitation's own, or where the reference (or the torque) has its energy. window [s] :
    resolution of a record that does not repeat. torque (n,) : instead of the record's, say with dry friction taken off.
    highest [Hz] : above which no band that is not given reaches.
    Where two or more periods follow a first one, they are averaged and compared; a single period, or a record that does
    not repeat, is read by local polynomials, which also take out the transient.
    Raises NumericsError where the band holds no excited lines.
    """
    torque = record.tau_m if torque is None else torque
    band = band or record.band or _occupied(record, torque, highest)
    length, count = _stretches(record) if window is None else (len(record), 1)
    spectra = _spectra(record, torque, length, count)
    lines = _excited(spectra, band)
    if len(lines) < 2:
        raise NumericsError(
            f"{len(lines)} excited lines between {band[0]:g} and {band[1]:g} Hz",
            where=record.name,
            hint="widen init_flex.band or excite the joint there",
        )
    periodic = record.period is not None and window is None
    spread = 1 if periodic else max(1, round(record.duration / (window or min(record.duration, LONGEST_WINDOW))))
    if count > 1:
        return _average(record.name, spectra, lines)
    frf = _smooth(record.name, spectra, lines, spread)
    return frf if record.ref is not None else replace(frf, remarks=(*frf.remarks, IN_CLOSED_LOOP))


def period_spectra(record: Record) -> Spectra:
    """The spectra of a record's periods, the first of several left out; of all of it where it does not repeat."""
    return _spectra(record, record.tau_m, *_stretches(record))


def combine(name: str, frfs: tuple[Frf, ...]) -> Frf:
    """Mean of several realisations of one excitation, all at the same lines.

    The scatter between realisations holds noise and distortion; what periods tell of the noise separates the two.
    """
    responses: Complex = np.array([f.response for f in frfs])
    count = len(frfs)
    scatter = responses.var(axis=0, ddof=1)
    noise = np.mean([np.abs(f.std if f.noise_std is None else f.noise_std) ** 2 for f in frfs], axis=0)
    return Frf(
        record=name,
        frequency=frfs[0].frequency,
        response=np.mean(responses, axis=0),
        std=np.sqrt(np.maximum(scatter, noise) / count),
        noise_std=np.sqrt(noise / count),
        distortion_std=np.sqrt(np.maximum(scatter - noise, 0.0)),
        remarks=(f"mean of {count} realisations", *frfs[0].remarks),
    )


def _instrument(record: Record, torque: Array) -> Array:
    """What the loop did not make: the reference's acceleration, or for want of it the torque, (n,)."""
    if record.ref is None:
        return torque
    speed = central_difference(record.ref, record.sampling_time) if record.ref_kind == "position" else record.ref
    return central_difference(speed, record.sampling_time)


def _occupied(record: Record, torque: Array, highest: float) -> tuple[float, float]:
    """Band of the instrument's energy below a frequency [Hz]."""
    lowest = 2 / record.duration
    return lowest, max(4 * lowest, min(highest, bandwidth(_instrument(record, torque), record.sampling_time)))


def _stretches(record: Record) -> tuple[int, int]:
    """Length of a stretch in samples, and how many from the end are used: of periods all but the first."""
    if record.period is None:
        return len(record), 1
    length = round(record.period / record.sampling_time)
    whole = len(record) // length
    return (length, max(1, whole - 1)) if whole else (len(record), 1)


def _spectra(record: Record, torque: Array, length: int, count: int) -> Spectra:
    h, used = record.sampling_time, length * count
    frequency: Array = np.fft.rfftfreq(length, h)[1:].astype(np.float64)
    s = 2j * np.pi * frequency
    u, v, r = (
        np.fft.rfft(signal[-used:].reshape(count, length), axis=1)[:, 1:] / length
        for signal in (torque, record.dphi_m, _instrument(record, torque))
    )
    # The torque is held from sample to sample: in continuous time its amplitude falls and it acts half a sample late.
    hold = (1 - np.exp(-s * h)) / (s * h)
    return Spectra(frequency, u * hold, v * s, r)


def _excited(spectra: Spectra, band: tuple[float, float]) -> Index:
    slack = 1e-6 * band[0]
    inside = (spectra.frequency >= band[0] - slack) & (spectra.frequency <= band[1] + slack)
    amplitude = np.abs(spectra.instrument).mean(axis=0) * inside
    return np.flatnonzero(amplitude > EXCITED * amplitude.max()) if inside.any() else np.zeros(0, dtype=np.intp)


def _average(name: str, spectra: Spectra, lines: Index) -> Frf:
    """Periods averaged; their scatter is the noise. Any reference is the same in all of them, so none is needed."""
    u, y = spectra.torque[:, lines], spectra.acceleration[:, lines]
    response = y.mean(axis=0) / u.mean(axis=0)
    variance = np.var(y - response * u, axis=0, ddof=1) / len(u)
    std = np.sqrt(variance) / np.abs(u.mean(axis=0))
    return Frf(name, spectra.frequency[lines], response, std, noise_std=std, remarks=(f"{len(u)} periods averaged",))


def _smooth(name: str, spectra: Spectra, lines: Index, spread: int) -> Frf:
    """Local polynomials over spread times as many lines as the least."""
    spacing = max(1, int(np.median(np.diff(lines)))) * spread
    at = lines[:: max(1, -(-len(lines) // LINES))]
    response, std = local_response(
        spectra.torque[0], spectra.acceleration[0], spectra.instrument[0], at, (int(lines[0]), int(lines[-1])), spacing
    )
    return Frf(name, spectra.frequency[at], response, std, remarks=("local polynomials over neighbouring lines",))
