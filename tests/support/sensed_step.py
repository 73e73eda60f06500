"""A step of a search that adds one effect with prescribed parameters and standard deviations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robotid.catalogue import assemble
from robotid.diagnosis.refit.refitted_model import Unknowns
from robotid.diagnosis.search.acceptance import Step
from support.plain_models import AXIS, plain_data, plain_model


def step_to(effect: str, values: Mapping[str, float], deviations: Mapping[str, float]) -> Step:
    """values, deviations : of the effect's parameters, by symbol; all others are known to 1e-3. The axis is at rest,
    for ten seconds."""
    joint = assemble(AXIS.extended(effect))
    parameters = joint.parameters().with_values({f"{effect}.{key}": value for key, value in values.items()})
    known = {f"{effect}.{key}": value for key, value in deviations.items()}
    factor = np.diag([1.0 / known.get(name, 1e-3) for name in joint.names])
    unknowns = Unknowns("speed", tuple(range(len(joint.names))))
    after = plain_model(1.0, joint=joint, parameters=parameters, unknowns=unknowns, factor=factor)
    before = plain_model(2000.0)
    return Step(before, before, after, plain_data())
