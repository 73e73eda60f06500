"""Stage init-rigid: inertia and friction of the joint as if it were rigid."""

from __future__ import annotations

from robotid.catalogue import assemble
from robotid.config.schema import Config
from robotid.estimate.rigid import RigidResult, fit_rigid
from robotid.signals.quality import Recordings
from robotid.stages.known_parameters import known_parameters


def init_rigid(settings: Config, recordings: Recordings) -> RigidResult:
    """Step 1 on the records of role estimate and use rigid or both.

    Raises NumericsError where there is none, or where they cannot tell the parameters.
    """
    joint = assemble(settings.structure())
    records = [r for r in recordings.records if r.role == "estimate" and r.use in ("rigid", "both")]
    section = settings.init_rigid
    return fit_rigid(
        joint, known_parameters(settings, joint), records, section.cutoff, section.order, section.min_speed
    )
