"""A recording of one experiment, in SI units, the same whether measured or simulated."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Final, Literal, overload

import numpy as np
from numpy.typing import ArrayLike

from robotid.display import Displayed
from robotid.errors import ConfigError, InputError
from robotid.model.array import Array
from robotid.model.companion import CompanionKind, Course, SmoothCourse
from robotid.signals.companion import Companion
from robotid.signals.differentiate import backward_difference, central_difference
from robotid.signals.torque_steps import TorqueSteps

SHORTEST_PIECE = 20  # samples
LARGEST = 1e12  # [Nm, rad, rad/s] of what a sensor of a machine shows
SIGNAL: Final = {"shape": ("n",), "finite": True, "largest": LARGEST}
SIGNALS = ("tau_m", "phi_m", "dphi_m", "phi_a", "ref")
"""What a record holds of every sample, where it holds it, companions apart."""

Role = Literal["estimate", "validate"]
Use = Literal["rigid", "flex", "both"]
Quantity = Literal["speed", "position"]
SpeedOrigin = Literal["sensor", "central difference", "backward difference"]
"""Where the speed of a record comes from: a sensor of its own, or the angle by one of two operators."""

OPERATORS: dict[SpeedOrigin, Callable[[Array, float], Array]] = {
    "central difference": central_difference,
    "backward difference": backward_difference,
}
"""From an angle (..., n) and the sampling time to the speed as it is derived, (..., n)."""


@dataclass(frozen=True, slots=True, weakref_slot=True, eq=False, repr=False)
class Record(Displayed):
    """One experiment. All signals are on the motor side unless they end in _a, and (n,).

    tau_m is held from its sample to the next, or is the mean over that interval where torque_steps tell how it changes
    within it, as on the regular grid of a clock that jittered. ref is the controller's reference, of the quantity
    ref_kind names. period [s] is set where the excitation repeats; band [Hz] where it fills a known band. begin [s] :
    time of the first sample, other than zero for a piece of an experiment. experiment : name of the recording, of which
    gaps have left several records. speed_origin : whether dphi_m was measured, or derived from phi_m, and by which
    operator; a simulated speed passes the same one. companions : further recorded signals, by name.
    """

    name: str
    role: Role
    use: Use
    sampling_time: float = field(metadata={"unit": "s", "positive": True})
    tau_m: Array = field(metadata={"unit": "Nm", **SIGNAL})
    phi_m: Array = field(metadata={"unit": "rad", **SIGNAL})
    dphi_m: Array = field(metadata={"unit": "rad/s", **SIGNAL})
    phi_a: Array | None = field(default=None, metadata={"unit": "rad", **SIGNAL})
    ref: Array | None = field(default=None, metadata={"unit": "rad or rad/s", **SIGNAL})
    ref_kind: Quantity | None = None
    period: float | None = field(default=None, metadata={"unit": "s", "positive": True})
    band: tuple[float, float] | None = field(default=None, metadata={"unit": "Hz", "positive": True})
    begin: float = field(default=0.0, metadata={"unit": "s", "finite": True})
    experiment: str = ""
    speed_origin: SpeedOrigin = "sensor"
    companions: dict[str, Companion] = field(default_factory=dict)
    torque_steps: TorqueSteps | None = None

    @classmethod
    def from_arrays(
        cls,
        torque: ArrayLike,
        angle: ArrayLike,
        sampling_time: float,
        *,
        speed: ArrayLike | None = None,
        name: str = "record",
        role: Role = "estimate",
    ) -> Record:
        """A record of signals that are clean and in SI: motor torque (n,) [Nm], motor angle (n,) [rad], motor speed
        (n,) [rad/s], by default the central difference of the angle. sampling_time [s].

        Raises ConfigError where arrays differ in length or are not (n,), or the sampling time is not positive,
        InputError where a value is not a number, or one that no sensor shows; `robotid.read` repairs a few that are no
        numbers, and reads other units.

        >>> import numpy as np
        >>> angle = np.sin(np.arange(0.0, 2.0, 0.01))
        >>> Record.from_arrays(torque=-0.1 * angle, angle=angle, sampling_time=0.01, name="swing")
        <Record: swing (estimate), 200 samples at 100 Hz, 2 s>
        """
        given = {"torque": torque, "angle": angle} | ({} if speed is None else {"speed": speed})
        signals = {key: _checked(key, values) for key, values in given.items()}
        lengths = {key: len(values) for key, values in signals.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{key} {n}" for key, n in lengths.items())
            raise ConfigError(f"the arrays differ in length: {listed}", where=name, hint="give those of one recording")
        if not sampling_time > 0.0:
            what = f"a sampling time of {sampling_time:g} s is not positive"
            raise ConfigError(what, where=name, hint="give the time between two samples in seconds")
        if lengths["angle"] < SHORTEST_PIECE:
            what = f"a record of {lengths['angle']} samples is too short, the least is {SHORTEST_PIECE}"
            raise InputError(what, where=name, hint="record longer")
        origin: SpeedOrigin = "central difference" if speed is None else "sensor"
        derived = central_difference(signals["angle"], sampling_time) if speed is None else signals["speed"]
        sampled = signals["torque"], signals["angle"], derived
        return cls(name, role, "both", float(sampling_time), *sampled, speed_origin=origin)

    def contradictions(self) -> Iterator[str]:
        """What cannot be, as sentences: for a record that was read from a file."""
        first, last = self.begin, self.begin + len(self) * self.sampling_time
        if not (first < first + self.sampling_time and last < last + self.sampling_time):
            yield f"the samples of {self.name} are not one after the other in time"

    def __len__(self) -> int:
        return len(self.tau_m)

    @property
    def t(self) -> Array:
        """Time since the experiment began [s], (n,)."""
        return self.begin + np.arange(len(self), dtype=np.float64) * self.sampling_time

    @property
    def speed_is_derived(self) -> bool:
        """Whether the speed comes from the angle, and holds nothing that the angle does not."""
        return self.speed_origin in OPERATORS

    @property
    def duration(self) -> float:
        """Length of the record [s]."""
        return len(self) * self.sampling_time

    @property
    def courses(self) -> dict[str, Course]:
        """Its companions in time, by name."""
        return {name: one.course(self.sampling_time, self.begin) for name, one in self.companions.items()}

    @property
    def motor_course(self) -> Course:
        """The motor's angle in time."""
        return SmoothCourse(np.stack([self.phi_m, self.dphi_m, 0.0 * self.phi_m]), self.sampling_time, self.begin)

    @property
    def disturbance(self) -> Array | None:
        """The part of tau_m that the controller did not command, such as test pulses, (n,) [Nm]."""
        found = [one.values for one in self.companions.values() if one.kind is CompanionKind.DISTURBANCE]
        return np.sum(found, axis=0) if found else None

    def piece(self, first: int, last: int) -> Record:
        """Samples first .. last - 1 as a record of the same name, no longer periodic; a speed that comes from the angle
        is derived anew."""
        cut = {name: signal[first:last] for name in SIGNALS if (signal := getattr(self, name)) is not None}
        if self.speed_is_derived and len(cut["phi_m"]) > 2:
            cut["dphi_m"] = OPERATORS[self.speed_origin](cut["phi_m"], self.sampling_time)
        companions = {name: one.piece(first, last) for name, one in self.companions.items()}
        begin = self.begin + first * self.sampling_time
        steps = None if self.torque_steps is None else self.torque_steps.take(slice(first, last))
        return replace(self, period=None, begin=begin, companions=companions, torque_steps=steps, **cut)

    def follows(self, other: Record) -> bool:
        """Whether it begins where another piece of the same record ends."""
        between = self.begin - other.begin - other.duration
        return self.name == other.name and abs(between) < 0.5 * self.sampling_time

    def pieces(self, length: float | None) -> tuple[Record, ...]:
        """Consecutive pieces of about this length [s], none shorter than half of it; None: all of it as one. Raises
        ConfigError where that is hardly a sample."""
        if length is None:
            return (self.piece(0, len(self)),)
        if length < SHORTEST_PIECE * self.sampling_time:
            what = f"{length:g} s are fewer than {SHORTEST_PIECE} samples of {self.name}"
            raise ConfigError(what, where="horizon", hint="give a longer one, or none")
        count = max(1, round(self.duration / length))
        edges = np.linspace(0, len(self), count + 1).round().astype(int).tolist()
        return tuple(self.piece(a, b) for a, b in pairwise(edges))

    def divided(self, count: int) -> tuple[Record, ...]:
        """So many consecutive pieces, fewer where these would have too few samples, as those of a piece would."""
        return self.pieces(max(self.duration / count, SHORTEST_PIECE * self.sampling_time))


@overload
def usable_horizon(horizon: float, records: Iterable[Record]) -> float: ...
@overload
def usable_horizon(horizon: float | None, records: Iterable[Record]) -> float | None: ...
def usable_horizon(horizon: float | None, records: Iterable[Record]) -> float | None:
    """A length of pieces [s] that was chosen on some records, so that all of these can be cut by it, too."""
    return horizon and max((horizon, *(SHORTEST_PIECE * record.sampling_time for record in records)))


def _checked(name: str, values: ArrayLike) -> Array:
    """A signal as an array of floats, (n,)."""
    try:
        signal = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ConfigError(f"{name} is no array of numbers", hint="give an array (n,)") from None
    if signal.ndim != 1:
        raise ConfigError(f"{name} is an array of shape {signal.shape}", hint="give an array (n,)")
    bad = ~np.isfinite(signal)
    if bad.any():
        what = (
            f"{name} is not a number in {int(bad.sum())} of {len(signal)} samples, the first is {int(np.argmax(bad))}"
        )
        raise InputError(what, hint="record again, or let robotid.read repair it")
    if (np.abs(signal) > LARGEST).any():
        what = f"{name} reaches {np.abs(signal).max():g}, which no sensor of a machine does"
        raise InputError(what, hint="check its unit")
    return signal
