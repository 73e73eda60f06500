"""Fitting a model to records: both initialisations where values are missing, and then everything at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal

import numpy as np

from robotid.catalogue import assemble
from robotid.config.suggest import suggest
from robotid.errors import ConfigError
from robotid.estimate.fitted_model import FittedModel, fitted_model
from robotid.estimate.flexible import FlexResult
from robotid.estimate.grey_box import FitOptions
from robotid.estimate.identify import StartOptions, initialise_flexible, initialise_rigid, starting_parameters
from robotid.estimate.result import Estimate, FitResult
from robotid.estimate.rigid import RigidResult
from robotid.estimate.scrutiny import FitTask, scrutinised_fit
from robotid.estimate.sensing import DEFAULT_OUTPUT, joint_for
from robotid.interface.dataset import Dataset, as_dataset
from robotid.interface.hints import in_python_terms
from robotid.interface.model import Model
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.parallel import computing
from robotid.signals.record import Quantity, Record

NAME = "m1"
"""What a model is called that was fitted in Python, as the configuration calls its first one."""


@dataclass(frozen=True, slots=True)
class Options:
    """How a model is fitted.

    output : what is compared, "speed" or "position", None for the speed, also where it is derived from the angle.
    horizon [s] : length of the pieces of a record that are simulated
    from first states of their own, None for whole records, "auto" for what the growth of errors on their motion asks
    for; the fit then has the one that was chosen. max_iterations and tolerance, relative to the cost : where
    the fit ends. weights : by record, a factor on the weight that its noise gives it. estimate_states : whether first
    states are estimated or taken as measured. multistart : further starts, drawn about the first.

    Of the rigid initialisation: cutoff [Hz] and order of its zero-phase filter, cutoff None for one that is chosen from
    the excitation; min_speed [rad/s], below which samples are left out. Of the flexible one: band [Hz] in which
    frequency responses are read, and window [s], the length of a segment, None for those of the excitation.
    """

    output: Quantity | None = None
    horizon: float | Literal["auto"] | None = None
    max_iterations: int = 50
    tolerance: float = 1e-6
    weights: Mapping[str, float] = field(default_factory=dict)
    estimate_states: bool = True
    multistart: int = 0
    cutoff: float | None = None
    order: int = 4
    min_speed: float = 0.0
    band: tuple[float, float] | None = None
    window: float | None = None

    def __post_init__(self) -> None:
        if self.output not in ("speed", "position", None):
            raise ConfigError(f'the output cannot be "{self.output}"', where="Options", hint="speed or position")
        if isinstance(self.horizon, str) and self.horizon != "auto":
            raise ConfigError(f'horizon is "{self.horizon}"', where="Options", hint='give seconds, "auto" or None')
        for name in ("horizon", "cutoff", "window"):
            value = getattr(self, name)
            if not isinstance(value, str | None) and not value > 0:
                raise ConfigError(f"{name} is {value!r}", where="Options", hint="give a positive number, or None")
        if self.band is not None and not (np.shape(self.band) == (2,) and 0 < self.band[0] < self.band[1]):
            raise ConfigError(f"the band is {self.band!r}", where="Options", hint="give (lowest, highest) in Hz")

    @property
    def fit(self) -> FitOptions:
        """Those of the fit."""
        return FitOptions(
            output=self.output or DEFAULT_OUTPUT,
            max_iterations=self.max_iterations,
            tolerance=self.tolerance,
            weights=self.weights,
            estimate_states=self.estimate_states,
            multistart=self.multistart,
            horizon=self.fixed_horizon,
            choose_horizon=self.horizon == "auto",
        )

    @property
    def fixed_horizon(self) -> float | None:
        """The length of pieces [s] where it is given."""
        return None if isinstance(self.horizon, str) else self.horizon

    @property
    def start(self) -> StartOptions:
        """Those of the initialisation."""
        return StartOptions(self.cutoff, self.order, self.min_speed, self.band, self.window)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Fit(FitResult):
    """A fitted model with what it was made from, so that it can be validated, diagnosed and extended.

    Besides what a `FitResult` has: model : its effects and what was known; dataset : the records, those held out
    included; initial : where the fit started; rigid, flex : the initialisations, None where every value was given.
    `fit["motor.inertia.J"]` is an estimate with its value and standard deviations.
    """

    model: Model
    dataset: Dataset
    options: Options
    initial: Parameters
    rigid: RigidResult | None = None
    flex: FlexResult | None = None

    def __getitem__(self, name: str) -> Estimate:
        found = next((p for p in self.parameters if p.name == name), None)
        if found is None:
            names = [p.name for p in self.parameters]
            raise ConfigError(f'the model has no parameter "{name}"', where="Fit", hint=suggest(name, names))
        return found

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name, in SI."""
        return {p.name: p.value for p in self.parameters}

    @property
    def result(self) -> FitResult:
        """What the fit itself found, as an artifact keeps it."""
        return FitResult(**fields_of(self, FitResult))

    @property
    def fitted_model(self) -> FittedModel:
        """The model with its values, ready to be simulated."""
        return fitted_model(self, estimate_states=self.options.estimate_states)


def fields_of(content: Any, kind: type) -> dict[str, Any]:
    """The fields that a result has as one of this kind."""
    return {f.name: getattr(content, f.name) for f in fields(kind)}


def fit(
    model: Model,
    records: Record | Iterable[Record],
    *,
    guesses: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    fixed: Iterable[str] | Mapping[str, float] = (),
    options: Options | None = None,
) -> Fit:
    """Fit a model to records, by the same steps as `robotid fit`.

    The two initialisations, rigid by regression and flexible from frequency responses, find a start for every parameter
    of which no value is known; then the simulation is fitted to the measurement in the time domain.

    records : those of role "estimate" are fitted; those of role "validate" are kept for validation and diagnosis.
    guesses, bounds, fixed : as of `Model.with_known`, by dotted name, in SI.

    Raises ConfigError for what does not fit together, NumericsError where the records cannot tell the parameters, where
    nothing excites the joint, and where the fit does not converge.

    >>> import robotid as rid
    >>> from support.logs import motor_log
    >>> model = rid.Model(motor=["inertia", "viscous", "coulomb"])
    >>> found = rid.fit(model, rid.read(motor_log(), name="log"))
    >>> round(found["motor.inertia.J"].value, 4), found["motor.inertia.J"].unit
    (0.012, 'kg m2')
    """
    data, options = as_dataset(records), options or Options()
    model = model.with_known(guesses, bounds, fixed)
    used = data.of_role("estimate")
    if not len(used):
        has = "there is no record" if not len(data) else "every record has the role validate"
        raise ConfigError(f"{has}, so there is nothing to fit", where="fit", hint='read one with role="estimate"')
    for name in options.weights:
        if name not in data.names:
            raise ConfigError(f'there is no record "{name}"', where="Options, weights", hint=suggest(name, data.names))
    output = options.output or DEFAULT_OUTPUT
    options = replace(options, output=output)
    joint = joint_for(model.structure, output, used)
    with in_python_terms(), computing():
        start = initialise(model, joint, used, options)
        task = FitTask(
            NAME, joint, start.parameters, used.records, options.fit, found=start.found, left_out=start.left_out
        )
        result = scrutinised_fit(task).fit
    return Fit(
        **fields_of(result, FitResult),
        model=model,
        dataset=data,
        options=replace(options, horizon=options.fixed_horizon or result.horizon),
        initial=start.parameters,
        rigid=start.rigid,
        flex=start.flex,
    )


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where a fit starts, and the initialisations that found it. left_out : starts that they do not trust."""

    parameters: Parameters
    rigid: RigidResult | None = None
    flex: FlexResult | None = None
    left_out: tuple[Parameters, ...] = ()

    @property
    def found(self) -> dict[str, float]:
        """What the initialisations found, also of parameters of which a value is known."""
        return {name: value for one in (self.rigid, self.flex) if one for name, value in one.guesses.items()}


def initialise(model: Model, joint: Joint, records: Dataset, options: Options) -> Start:
    """The start of a fit: known values, and where some are missing those that the initialisations find."""
    structure, known = joint.structure, model.knowledge
    own = joint.names[: len(joint.names) - len(structure.changes)]
    if all(name in known and known[name].guess is not None for name in own):
        return Start(starting_parameters(joint, known, {}))
    rigid = initialise_rigid(structure, known, records.records, options.start)
    flex = initialise_flexible(structure, known, records.records, rigid, options.start)
    left_out = tuple(starting_parameters(joint, known, rigid.guesses | one) for one in flex.left_out)
    return Start(starting_parameters(joint, known, rigid.guesses | flex.guesses), rigid, flex, left_out)


def with_more(fit: Fit, records: Dataset) -> Dataset:
    """The records of a fit and further ones, which are held out of it. Raises ConfigError where those of the fit are in
    neither, as of a fit that was saved alone."""
    own = Dataset(tuple(r for r in records if r.name in fit.records and r.name not in fit.dataset.names))
    others = records.only(name for name in records.names if name not in own.names)
    data = fit.dataset + own + others.as_role("validate")
    missing = [name for name in fit.records if name not in data.names]
    if missing:
        what = f"the records of this fit are not here: {', '.join(missing)}"
        raise ConfigError(what, hint="read them again, by these names, and give them as records")
    return data


def extended_fit(before: Fit, result: FitResult, dataset: Dataset) -> Fit:
    """A fit of an extended model with what the fit before it was made from."""
    added = [e for e in result.structure.effects if e not in before.structure.effects]
    model = before.model.with_effects(*added)
    start = assemble(result.structure, angle=result.keeps_angle).parameters()
    values = np.array([before.values.get(n, float(v)) for n, v in zip(start.names, start.values, strict=True)])
    initial = replace(start, values=values)
    return Fit(**fields_of(result, FitResult), model=model, dataset=dataset, options=before.options, initial=initial)
