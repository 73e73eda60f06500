"""Stage init-rigid: inertia and friction of the joint as if it were rigid."""

from __future__ import annotations

from robotid.config.schema import Config
from robotid.estimate.identify import StartOptions, initialise_rigid
from robotid.estimate.rigid import RigidResult
from robotid.signals.quality import Recordings


def init_rigid(settings: Config, recordings: Recordings) -> RigidResult:
    """Step 1 on the records of role estimate and use rigid or both.

    Raises NumericsError where there is none, or where they cannot tell the parameters.
    """
    section = settings.init_rigid
    options = StartOptions(section.cutoff, section.order, section.min_speed)
    return initialise_rigid(settings.structure(), settings.robot.known(), recordings.records, options)
