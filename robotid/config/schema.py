"""The whole configuration, section by section, as docs/configuration.md lists it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from robotid.config.plant import ControllerSettings, EncoderSettings, NoiseSettings, PlantSettings
from robotid.config.records import RecordSettings
from robotid.config.robot import Effects, ParameterSettings, RobotSettings
from robotid.config.section import Name, NonNegative, Positive, Section
from robotid.model.structure import Structure

__all__ = [
    "CheckSettings",
    "Config",
    "ControllerSettings",
    "DiagnoseSettings",
    "Effects",
    "EncoderSettings",
    "ExtendSettings",
    "FitSettings",
    "InitFlexSettings",
    "InitRigidSettings",
    "NoiseSettings",
    "ParameterSettings",
    "PlantSettings",
    "RecordSettings",
    "ReportSettings",
    "RobotSettings",
    "ThresholdSettings",
    "ValidateSettings",
]

Count = Annotated[int, Field(gt=0)]


class CheckSettings(Section):
    """Whether the records make sense, which is asked before anything is fitted. accept : names of checks whose fatal
    findings are known to be right, so that a run goes on, such as torque_sign."""

    accept: tuple[str, ...] = ()


class InitRigidSettings(Section):
    """Least squares of eq. (10)-(11). cutoff [Hz] : of the zero-phase low-pass filter, absent: chosen from the
    excitation. order : of the filter. min_speed [rad/s] : slower samples, where the sign of friction is in doubt, are
    left out."""

    cutoff: Positive | None = None
    order: Annotated[int, Field(ge=1, le=10)] = 4
    min_speed: NonNegative = 0.0


class InitFlexSettings(Section):
    """Frequency responses and eq. (12)-(14). band [Hz] : where the responses are read, absent: the excitation's own;
    window [s] : length of a segment, absent: the excitation's period. experiments : names of the records that tell
    several axes apart, in groups of as many records as there are axes, absent: the virtual robot's orthogonal ones."""

    band: tuple[Positive, Positive] | None = None
    window: Positive | None = None
    experiments: tuple[tuple[str, ...], ...] | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.band is not None and not self.band[0] < self.band[1]:
            raise ValueError(f"the band {self.band[0]:g} to {self.band[1]:g} Hz is empty")
        return self


class FitSettings(Section):
    """Output-error fit. max_iterations : most of them. tolerance : share of the cost that another iteration must gain.
    initial_states : found by the fit (free), or as measured (fixed). output : what is compared, absent: the speed, also
    where it is derived from the angle. models : name to the records that it is fitted to, absent: one model of all
    records with role estimate. best : the model that later stages use, by default the last. weights : factor of a
    record on the weight that its noise gives it. multistart : further starts, drawn about the first. fix : dotted names
    of parameters that keep their start. horizon [s] : length of the pieces of a record that are simulated from first
    states of their own, absent: the whole record at once, unless an open simulation fits poorly and is unstable or
    contradicts the torque; auto: pieces over which no error grows far, where any does."""

    output: Literal["speed", "position"] | None = None
    models: Annotated[dict[Name, tuple[str, ...]], Field(min_length=1)] | None = None
    best: str | None = None
    max_iterations: Count = 50
    tolerance: Positive = 1e-6
    weights: dict[str, Positive] = {}
    initial_states: Literal["free", "fixed"] = "free"
    multistart: Annotated[int, Field(ge=0)] = 0
    fix: tuple[str, ...] = ()
    horizon: Positive | Literal["auto"] | None = None

    @property
    def fixed_horizon(self) -> float | None:
        """The length of pieces that is given [s], None where there is none or the data choose it."""
        return None if isinstance(self.horizon, str) else self.horizon


class ThresholdSettings(Section):
    """What the best model must reach; below it `validate` ends with exit code 5. fit_percent : by record, eq. (15)."""

    fit_percent: dict[str, Annotated[float, Field(le=100, allow_inf_nan=False)]] = {}


class ValidateSettings(Section):
    """What a model is worth. perturbation [%] : of each parameter in turn (Table 3). thresholds : what the best model
    must reach. horizon [s] : length of the pieces that are simulated from
    fresh initial states, absent: the whole record at once."""

    perturbation: Annotated[float, Field(gt=0, lt=100)] = 20.0
    thresholds: ThresholdSettings = ThresholdSettings()
    horizon: Positive | None = None


class DiagnoseSettings(Section):
    """How to search for what a model lacks. model : which one, absent: fit.best. significance : level of significance
    of a round of the search, over all of its candidates. min_improvement_sigma : least misfit that a cause must remove
    on validation records, in standard deviations of the noise. max_causes : most causes that are named. max_refits :
    most effects that are refitted in a round. skip : effects out of the question. samples : longer records are sampled
    in pieces. budget [s] : time after which the best answer so far is given, with what was not examined; absent: all
    that it takes."""

    former_keys: ClassVar[Mapping[str, str]] = {
        "level": "significance",
        "worth": "min_improvement_sigma",
        "causes": "max_causes",
        "refits": "max_refits",
    }

    model: str | None = None
    significance: Annotated[float, Field(gt=0, lt=1)] = 1e-3
    min_improvement_sigma: NonNegative = 0.1
    max_causes: Count = 4
    max_refits: Count = 5
    skip: tuple[str, ...] = ()
    samples: Annotated[int, Field(ge=1000)] = 100_000
    budget: Positive | None = None


class ExtendSettings(Section):
    """What to extend the model by. effects : absent, the causes that diagnose named."""

    effects: tuple[str, ...] | None = None


class ReportSettings(Section):
    """The report. title : its heading, absent: the robot's name."""

    title: str | None = None


class Config(Section):
    """A configuration whose sections fit together once `robotid.config.load` has checked it."""

    robot: RobotSettings
    records: Annotated[tuple[RecordSettings, ...], Field(min_length=1)]
    plant: PlantSettings | None = None
    controller: ControllerSettings | None = None
    check: CheckSettings = CheckSettings()
    init_rigid: InitRigidSettings = InitRigidSettings()
    init_flex: InitFlexSettings = InitFlexSettings()
    fit: FitSettings = FitSettings()
    # the section is called `validate`, a name that the base class gave to a method long ago
    validation: ValidateSettings = Field(default=ValidateSettings(), alias="validate")
    diagnose: DiagnoseSettings = DiagnoseSettings()
    extend: ExtendSettings = ExtendSettings()
    report: ReportSettings = ReportSettings()

    def structure(self) -> Structure:
        """The joint to identify."""
        return self.robot.structure()

    def plant_structure(self) -> Structure:
        """The virtual robot's joint, the same in every record."""
        own = self.plant.model if self.plant else None
        return self.robot.structure(self.robot.model if own is None else own)

    def names(self, role: Literal["estimate", "validate"]) -> tuple[str, ...]:
        """Names of the records of a role, further realisations included."""
        return tuple(name for record in self.records if record.role == role for name in record.names)

    @property
    def loop(self) -> ControllerSettings | None:
        """The controller that closed the loop of the records, where it is known."""
        return self.controller or (self.plant.controller if self.plant else None)

    def completed(self) -> Self:
        """With the defaults that depend on other sections filled in: fit.models, fit.best, plant.model and
        init_flex.experiments."""
        models = self.fit.models or {"m1": self.names("estimate")}
        fit = self.fit.model_copy(update={"models": models, "best": self.fit.best or list(models)[-1]})
        plant = self.plant and self.plant.model_copy(update={"model": self.plant.model or self.robot.model})
        flex = self.init_flex.model_copy(update={"experiments": self._experiments()})
        return self.model_copy(update={"fit": fit, "plant": plant, "init_flex": flex})

    def _experiments(self) -> tuple[tuple[str, ...], ...]:
        """Groups of records that tell several axes apart: those given, or the orthogonal ones of the virtual robot."""
        if self.init_flex.experiments is not None:
            return self.init_flex.experiments
        return tuple(
            record.names[k : k + len(record.others) + 1]
            for record in self.records
            if record.excite is not None and record.excite.orthogonal
            if record.role == "estimate" and record.use != "rigid"
            for k in range(0, len(record.names), len(record.others) + 1)
        )
