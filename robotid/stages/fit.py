"""Stage fit: every model of the configuration over its records, from the start that the initialisation found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from robotid.config.schema import Config
from robotid.estimate.flexible import FlexResult
from robotid.estimate.grey_box import FitOptions, fit_model
from robotid.estimate.least_squares import Iteration
from robotid.estimate.result import End, FitResult, Fits
from robotid.estimate.rigid import RigidResult
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters
from robotid.signals.quality import Recordings
from robotid.simulate.assemble import assemble

Log = Callable[[str, Iteration], None]


def fit(settings: Config, recordings: Recordings, rigid: RigidResult, flex: FlexResult, log: Log | None = None) -> Fits:
    """Fit all models. log is called with the model's name at every iteration.

    Raises NumericsError where a model does not converge from this start.
    """
    joint = assemble(settings.structure(), angle=settings.fit.output == "position")
    parameters = start(settings, joint, rigid, flex)
    options = FitOptions(
        output=settings.fit.output,
        most=settings.fit.max_iterations,
        tolerance=settings.fit.tolerance,
        weights=settings.fit.weights,
        estimate_states=settings.fit.initial_states == "free",
        multistart=settings.fit.multistart,
    )
    records = {record.name: record for record in recordings.records}
    models: dict[str, FitResult] = {}
    assert settings.fit.models is not None and settings.fit.best is not None
    for name, members in settings.fit.models.items():
        line = None if log is None else (lambda iteration, name=name: log(name, iteration))
        models[name] = fit_model(name, joint, parameters, [records[m] for m in members], options, line)
        if models[name].end is End.INTERRUPTED:
            break
    best = settings.fit.best if settings.fit.best in models else list(models)[-1]
    return Fits(models, best)


def start(settings: Config, joint: Joint, rigid: RigidResult, flex: FlexResult) -> Parameters:
    """The model m0: declared guesses, over them the initialisation's, over them the configuration's."""
    parameters = joint.parameters()
    found = {name: value for name, value in (rigid.guesses | flex.guesses).items() if name in parameters.names}
    parameters = parameters.with_values(found)
    values, lower, upper = parameters.values.copy(), parameters.lower.copy(), parameters.upper.copy()
    free = parameters.free.copy()
    for name, known in settings.robot.parameters.items():
        k = parameters.names.index(name)
        if known.guess is not None:
            values[k] = known.guess
        if known.bounds is not None:
            lower[k], upper[k] = known.bounds
        free[k] = not known.fixed
    for name in settings.fit.fix:
        free[parameters.names.index(name)] = False
    return replace(parameters, values=np.clip(values, lower, upper), lower=lower, upper=upper, free=free)
