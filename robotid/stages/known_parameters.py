"""What the configuration knows of the parameters before anything is estimated."""

from __future__ import annotations

from dataclasses import replace

from robotid.config.schema import Config
from robotid.model.joint import Joint
from robotid.model.parameters import Parameters


def known_parameters(settings: Config, joint: Joint) -> Parameters:
    """Declared values and bounds, over them the configuration's. Held is what is fixed to a value it gives: a parameter
    fixed without a guess keeps what the initialisation finds."""
    declared = joint.parameters()
    values, free = declared.values.copy(), declared.free.copy()
    lower, upper = declared.lower.copy(), declared.upper.copy()
    for name, known in settings.robot.parameters.items():
        k = declared.names.index(name)
        if known.guess is not None:
            values[k] = known.guess
            free[k] = not known.fixed
        if known.bounds is not None:
            lower[k], upper[k] = known.bounds
    return replace(declared, values=values, lower=lower, upper=upper, free=free)
