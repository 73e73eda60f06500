"""Stage init-flex: frequency responses, and from them springs, dampers and the inertias on either side."""

from __future__ import annotations

from robotid.config.schema import Config
from robotid.estimate.flexible import FlexResult
from robotid.estimate.identify import StartOptions, initialise_flexible
from robotid.estimate.rigid import RigidResult
from robotid.signals.quality import Recordings


def init_flex(settings: Config, recordings: Recordings, rigid: RigidResult) -> FlexResult:
    """Step 2 on the records of role estimate and use flex or both; empty, with a remark, for a joint that cannot flex.

    Raises NumericsError where step 1 found no inertia or a record is not excited in the band.
    """
    section = settings.init_flex
    options = StartOptions(band=section.band, window=section.window, experiments=section.experiments or ())
    return initialise_flexible(settings.structure(), settings.robot.known(), recordings.records, rigid, options)
