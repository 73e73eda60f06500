"""Stage fit: every model of the configuration over its records, from the start that the initialisation found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from robotid.config.schema import Config
from robotid.estimate.flexible import FlexResult
from robotid.estimate.grey_box import FitOptions
from robotid.estimate.identify import starting_parameters
from robotid.estimate.result import End, FitResult, Fits
from robotid.estimate.rigid import RigidResult
from robotid.estimate.scrutiny import FitTask, ScrutinisedFit, scrutinised_fit
from robotid.estimate.sensing import DEFAULT_OUTPUT, joint_for
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.parallel import ahead
from robotid.progress import Log, Step
from robotid.signals.quality import Recordings
from robotid.signals.record import Quantity, Record


def fit(settings: Config, recordings: Recordings, rigid: RigidResult, flex: FlexResult, log: Log | None = None) -> Fits:
    """Fit all models, and a doubtful one with a constant torque besides. log : gets an event for every iteration.

    Raises NumericsError where a model does not converge from this start.
    """
    models: dict[str, FitResult] = {}
    assert settings.fit.models is not None
    assert settings.fit.best is not None
    used = recordings.of(dict.fromkeys(name for members in settings.fit.models.values() for name in members))
    output = settings.fit.output or DEFAULT_OUTPUT
    joint = joint_for(settings.structure(), output, used)
    parameters = start(settings, joint, rigid, flex)
    options = replace(fit_options(settings, output), interruptible=True)
    names = tuple(settings.fit.models)
    items = [(name, recordings.of(members)) for name, members in settings.fit.models.items()]
    samples = sum(len(record) for _, records in items for record in records) // len(items)
    asked_for = [rigid.guesses | one for one in flex.left_out]
    left_out = tuple(starting_parameters(joint, settings.robot.known(), one, settings.fit.fix) for one in asked_for)
    shared = _Common(joint, parameters, options, names, rigid.guesses | flex.guesses, left_out)
    with ahead(_fitted, shared, items, samples=samples, log=log, hands_on_interrupts=True) as found:
        for name, result in zip(names, found, strict=True):
            models[name] = result.fit
            if result.with_offset is not None and result.with_offset.name not in names:
                models[result.with_offset.name] = result.with_offset
            if result.fit.end is End.INTERRUPTED:
                break
    best = settings.fit.best if settings.fit.best in models else list(models)[-1]
    return Fits(models, best)


@dataclass(frozen=True, slots=True, eq=False)
class _Common:
    """What the fits of all models share. names : of the models; found : what the initialisation found; left_out :
    starts that it does not trust."""

    joint: Joint
    parameters: Parameters
    options: FitOptions
    names: tuple[str, ...]
    found: Mapping[str, float]
    left_out: tuple[Parameters, ...]


def _fitted(shared: _Common, item: tuple[str, Sequence[Record]], log: Log | None = None) -> ScrutinisedFit:
    name, records = item
    line = None if log is None else (lambda iteration: log(Step(name, shared.names, iteration)))
    start, left_out = shared.parameters, shared.left_out
    return scrutinised_fit(FitTask(name, shared.joint, start, records, shared.options, line, shared.found, left_out))


def start(settings: Config, joint: Joint, rigid: RigidResult, flex: FlexResult) -> Parameters:
    """The model m0."""
    return starting_parameters(joint, settings.robot.known(), rigid.guesses | flex.guesses, settings.fit.fix)


def fit_options(settings: Config, output: Quantity, horizon: float | None = None) -> FitOptions:
    """How the fit section asks to fit. output : what is compared; horizon [s] : of a fit that chose its pieces, where
    the section has none."""
    section = settings.fit
    return FitOptions(
        output=output,
        max_iterations=section.max_iterations,
        tolerance=section.tolerance,
        weights=section.weights,
        estimate_states=section.initial_states == "free",
        multistart=section.multistart,
        horizon=settings.fit.fixed_horizon or horizon,
        choose_horizon=section.horizon == "auto" and horizon is None,
    )
