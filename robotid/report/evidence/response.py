"""Frequency responses as complex numbers: of models from motor torque to motor speed; and how far the two signals of a
record hang together at each frequency."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from robotid.catalogue import assemble
from robotid.estimate.fitted_model import FittedModel, Simulated
from robotid.estimate.responses import nonlinear_torque
from robotid.model.array import Array, Complex
from robotid.model.linear import channel_response, linearise
from robotid.model.structure import Structure
from robotid.signals.frf import Frf, estimate_frf
from robotid.signals.record import Record
from robotid.validation.bode import bode, magnitude_distance
from robotid.validation.results import Validation

POINTS = 400  # frequencies at which a model is drawn, so that its resonances have their peaks
SEGMENTS = 8  # of a record that does not repeat, each half over the next
MIN_PERIODS = 2  # that are compared: the coherence of one is one whatever it holds


@dataclass(frozen=True, slots=True, eq=False)
class ModelResponse:
    """A model: frequency (n,) [Hz], speed (n,) complex [rad/s/Nm]. distance [dB] : RMS of its ratio to the measured
    responses, uncertain lines counting less. simulated : on the records of the measured responses, one after the other
    with a nan between them, and estimated as these were; else linearised about rest."""

    frequency: Array
    speed: Complex
    distance: float
    simulated: bool = False

    @property
    def acceleration(self) -> Complex:
        """From motor torque to motor acceleration [rad/s2/Nm], (n,)."""
        return np.asarray(2j * np.pi * self.frequency * self.speed)


@dataclass(frozen=True, slots=True, eq=False)
class Coherence:
    """Squared coherence (n,), 0 to 1, of motor torque and motor speed at frequency (n,) [Hz]: the share of the speed's
    power that a linear response to the torque accounts for. averages : stretches of the record that were compared; of
    signals that have nothing in common it is about one over them."""

    frequency: Array
    squared: Array
    averages: int


def model_response(
    structure: Structure, values: Mapping[str, float], frfs: Sequence[Frf], sampling_time: float
) -> ModelResponse:
    """A model over the band of measured responses, at least one. values : of its parameters, by name."""
    joint = assemble(structure)
    theta = np.array([values[name] for name in joint.names])
    lowest, highest = (pick(pick(frf.frequency) for frf in frfs) for pick in (min, max))
    frequency = np.geomspace(lowest, highest, POINTS)
    omega = 2 * np.pi * frequency
    response = linearise(joint, theta).speed_response(omega) * channel_response(joint, theta, omega, sampling_time)
    beside = bode(joint, theta, frfs, sampling_time)
    assert beside is not None
    return ModelResponse(frequency, response, float(np.mean(list(beside.distance.values()))))


def simulated_response(model: FittedModel, runs: Mapping[str, Simulated], frfs: Sequence[Frf]) -> ModelResponse | None:
    """A model as it responds at the amplitudes of the records, where effects that are not linear differ from their
    linearisation; None where it was simulated on none of the records behind the measured responses, or reads a further
    signal, which no frequency response is taken of."""
    if model.joint.reads_companions:
        return None
    frequency, speed, distances = [np.array([np.nan])], [np.array([np.nan + 0j])], list[float]()
    for frf in frfs:
        if (run := runs.get(frf.record)) is None:
            continue
        moved = replace(run.record, dphi_m=run.signal("speed"), phi_m=run.signal("position"))
        torque = moved.tau_m - nonlinear_torque(model.joint, model.parameters, moved)
        found = estimate_frf(moved, (float(frf.frequency[0]), float(frf.frequency[-1])), torque=torque)
        at = np.interp(frf.frequency, found.frequency, np.abs(found.speed_response))
        distances.append(magnitude_distance(at, frf))
        frequency += [found.frequency, np.array([np.nan])]
        speed += [found.speed_response, np.array([np.nan + 0j])]
    if not distances:
        return None
    return ModelResponse(np.concatenate(frequency), np.concatenate(speed), float(np.mean(distances)), simulated=True)


def validated_responses(validation: Validation, sampling_time: float) -> dict[str, ModelResponse]:
    """The model that the fits started from, and the best one, by name; none without measured responses."""
    if not validation.frfs:
        return {}
    names = dict.fromkeys((next(iter(validation.models)), validation.best))
    models = {name: validation.models[name] for name in names}
    return {
        name: model_response(
            one.structure, dict(zip(one.names, one.values.tolist(), strict=True)), validation.frfs, sampling_time
        )
        for name, one in models.items()
    }


def coherence(record: Record, frequency: Array) -> Coherence:
    """Of one record at these frequencies (n,) [Hz]: over its periods where it repeats, the first left out where there
    are enough, else over overlapping stretches (Welch 1967)."""
    h = record.sampling_time
    length = round(record.period / h) if record.period else 0
    whole = len(record) // length if length else 0
    count = whole - 1 if whole > MIN_PERIODS else whole
    if count >= MIN_PERIODS:
        u, y = (np.fft.rfft(s[-count * length :].reshape(count, length)) for s in (record.tau_m, record.dphi_m))
        lines = np.fft.rfftfreq(length, h)
        cross, power = np.abs(np.sum(y * u.conj(), axis=0)) ** 2, np.sum(np.abs(u) ** 2, 0) * np.sum(np.abs(y) ** 2, 0)
        squared = cross / np.maximum(power, np.finfo(float).tiny)
    else:
        size = max(2, 2 * len(record) // (SEGMENTS + 1))
        lines, squared = scipy.signal.coherence(record.tau_m, record.dphi_m, 1 / h, nperseg=size)
        count = SEGMENTS
    return Coherence(frequency, np.interp(frequency, lines, np.nan_to_num(squared)), count)
