"""The excite block of a record: the reference that the controller follows, by its kind."""

from __future__ import annotations

import json
from math import ceil, floor, inf, lcm
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, TypeAdapter, model_validator

from robotid.config.section import NonNegative, Positive, Section

WHOLE = 1e-6  # how far from a whole number of samples, or of lines, a number may round
LONGEST = 50_000_000  # samples
DEFAULT_CREST_FACTOR = 1.5

Count = Annotated[int, Field(gt=0)]
Table = tuple[tuple[Positive, NonNegative], ...]


class LimitsSettings(Section):
    """What the joint may do on the motor side, not checked where absent. A sliding axis reads m, N.

    speed [rad/s] : largest. acceleration [rad/s2] : largest. position [rad] : largest, counted from where a speed
    reference starts. torque [Nm] : largest, of the rigid joint.
    """

    speed: Positive | None = None
    acceleration: Positive | None = None
    position: Positive | None = None
    torque: Positive | None = None


class TrianglePart(Section):
    """Rises from zero. kind : of the wave. amplitude [rad/s or rad] : largest value. period [s] : of the wave."""

    kind: Literal["triangle"]
    amplitude: Positive
    period: Positive


class SquarePart(Section):
    """Starts high. kind : of the wave. amplitude [rad/s or rad] : largest value. period [s] : of the wave. rise [s] :
    time of a reversal, which then is a ramp, and the first half of one is the start."""

    kind: Literal["square"]
    amplitude: Positive
    period: Positive
    rise: NonNegative = 0.0

    @model_validator(mode="after")
    def _rises_in_time(self) -> Self:
        if self.rise > self.period / 2:
            raise ValueError(f"a rise of {self.rise:g} s does not fit into half the period of {self.period:g} s")
        return self


class MultisinePart(Section):
    """Sum of the sines at the multiples of 1 / period within a band.

    kind : of the wave. period [s] : after which it repeats. band [Hz] : lowest and highest frequency, absent: the range
    of the spectrum. spectrum : flat, or amplitudes as [[Hz, rad/s or rad], ...], linear in between. peak [rad/s or rad]
    : largest value, over all realisations; a spectrum without peak is taken as it stands. crest_factor : at most this,
    by optimised phases; null for random ones. seed : of the phases.
    """

    kind: Literal["multisine"]
    period: Positive
    band: tuple[Positive, Positive] | None = None
    spectrum: Annotated[
        Annotated[Literal["flat"], Tag("word")] | Annotated[Table, Tag("table"), Field(min_length=2)],
        Discriminator(lambda found: "word" if isinstance(found, str) else "table"),
    ] = "flat"
    peak: Positive | None = None
    crest_factor: Annotated[float, Field(gt=1, allow_inf_nan=False)] | None = DEFAULT_CREST_FACTOR
    seed: Annotated[int, Field(ge=0)] = 1

    @model_validator(mode="after")
    def _spectrum_given(self) -> Self:
        if self.spectrum == "flat":
            for key, given in (("band", self.band), ("peak", self.peak)):
                if given is None:
                    raise ValueError(f"a multisine with a flat spectrum needs {key}")
            return self
        frequencies = [frequency for frequency, _ in self.table]
        if sorted(set(frequencies)) != frequencies:
            raise ValueError("the frequencies of a spectrum must increase")
        if self.band is not None and not frequencies[0] <= self.band[0] < self.band[1] <= frequencies[-1]:
            raise ValueError(f"the band must lie within the spectrum's {frequencies[0]:g} to {frequencies[-1]:g} Hz")
        return self

    @model_validator(mode="after")
    def _lines_given(self) -> Self:
        low, high = self.edges
        if low > high:
            raise ValueError(f"the band {low:g} to {high:g} Hz is empty")
        if not self.lines:
            spacing = f"1 / period = {1 / self.period:g} Hz"
            raise ValueError(f"no multiple of {spacing} lies in the band {low:g} to {high:g} Hz; lengthen the period")
        if self.spectrum != "flat" and not any(amplitude for _, amplitude in self.table):
            raise ValueError("every amplitude of the spectrum is zero")
        return self

    @property
    def table(self) -> Table:
        """The spectrum as (frequency [Hz], amplitude) pairs."""
        low, high = self.band or (0.0, inf)
        return ((low, 1.0), (high, 1.0)) if self.spectrum == "flat" else self.spectrum

    @property
    def edges(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz] that may be excited."""
        return self.band or (self.table[0][0], self.table[-1][0])

    @property
    def lines(self) -> range:
        """The excited multiples of 1 / period."""
        low, high = self.edges
        return range(ceil(low * self.period - WHOLE), floor(high * self.period + WHOLE) + 1)


Part = Annotated[TrianglePart | SquarePart | MultisinePart, Field(discriminator="kind")]


class ExperimentSettings(Section):
    """How a reference is played.

    sampling_time [s] : of the reference and the record. duration [s] : of the reference, absent: one period. periods :
    as many instead of a duration. quantity : what it prescribes, speed [rad/s] or position [rad]. realisations : of a
    multisine's phases, one reference each. orthogonal : the multisines of all axes are, over as many realisations as
    there are axes, which then tell the axes apart at every frequency. limits : what the joint may do.
    """

    sampling_time: Positive
    duration: Positive | None = None
    periods: Count | None = None
    quantity: Literal["speed", "position"] = "speed"
    realisations: Count = 1
    orthogonal: bool = False
    limits: LimitsSettings = LimitsSettings()

    @model_validator(mode="after")
    def _fits_the_samples(self) -> Self:
        if self.duration is not None and self.periods is not None:
            raise ValueError("give duration or periods, not both")
        for part in self.parts:
            self._whole(part.period, "period")
        if self.duration is not None:
            self._whole(self.duration, "duration")
        if self.samples > LONGEST:
            raise ValueError(f"the reference would have {self.samples:,} samples, at most {LONGEST:,} are made")
        multisines = [part for part in self.parts if isinstance(part, MultisinePart)]
        for part in multisines:
            self._holds(part)
        if self.realisations > 1 and not multisines:
            raise ValueError("only a multisine has realisations")
        return self

    def _whole(self, time: float, what: str) -> None:
        h = self.sampling_time
        if time / h > LONGEST:
            raise ValueError(f"the {what} {time:g} s is more than {LONGEST:,} samples of {h:g} s")
        count = max(1, round(time / h))
        if abs(time / h - count) > WHOLE:
            near = f"{count} samples are {count * h:.10g} s"
            raise ValueError(f"the {what} {time:g} s is not a whole number of samples of {h:g} s; {near}")

    def _holds(self, part: MultisinePart) -> None:
        period = self.in_samples(part.period)
        if 2 * part.lines[-1] >= period:
            nyquist, top = 0.5 / self.sampling_time, part.edges[1]
            raise ValueError(f"the band ends at {top:g} Hz, not below half the sampling frequency, {nyquist:g} Hz")
        if self.samples < period:
            raise ValueError(f"{self.duration:g} s are shorter than the multisine's period of {part.period:g} s")

    @property
    def parts(self) -> tuple[TrianglePart | SquarePart | MultisinePart, ...]:
        """What is superposed."""
        return (self,) if isinstance(self, TrianglePart | SquarePart | MultisinePart) else ()

    @property
    def excited_lines(self) -> frozenset[float]:
        """Frequencies [Hz] of all multisines."""
        sines = [part for part in self.parts if isinstance(part, MultisinePart)]
        return frozenset(round(line / part.period, 9) for part in sines for line in part.lines)

    def in_samples(self, time: float) -> int:
        """A time [s] as a number of samples."""
        return round(time / self.sampling_time)

    @property
    def common_period(self) -> int:
        """Samples after which all parts repeat."""
        return lcm(*(self.in_samples(part.period) for part in self.parts))

    @property
    def samples(self) -> int:
        """Length of the reference."""
        return (self.periods or 1) * self.common_period if self.duration is None else self.in_samples(self.duration)


class TriangleSettings(ExperimentSettings, TrianglePart):
    """A triangle wave."""


class SquareSettings(ExperimentSettings, SquarePart):
    """A square wave."""


class MultisineSettings(ExperimentSettings, MultisinePart):
    """A multisine."""


class SumSettings(ExperimentSettings):
    """Several waves superposed, all at the sum's sampling time and over its duration. kind : of the wave. of : waves
    without a sampling time of their own."""

    kind: Literal["sum"]
    of: Annotated[tuple[Part, ...], Field(min_length=1)]

    @property
    def parts(self) -> tuple[TrianglePart | SquarePart | MultisinePart, ...]:
        """What is superposed."""
        return self.of


ExcitationSettings = Annotated[
    TriangleSettings | SquareSettings | MultisineSettings | SumSettings, Field(discriminator="kind")
]


def excitation(block: dict[str, Any]) -> ExperimentSettings:
    """The settings that an `excite` block means."""
    adapter: TypeAdapter[ExperimentSettings] = TypeAdapter(ExcitationSettings)
    return adapter.validate_json(json.dumps(block))  # where lists may be tuples, as in a file
