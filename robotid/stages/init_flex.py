"""Stage init-flex: frequency responses, and from them springs, dampers and the inertias on either side."""

from __future__ import annotations

from robotid.catalogue import assemble
from robotid.config.schema import Config
from robotid.estimate.flexible import FlexResult, fit_flexible
from robotid.estimate.rigid import RigidResult
from robotid.signals.quality import Recordings
from robotid.stages.known_parameters import known_parameters


def init_flex(settings: Config, recordings: Recordings, rigid: RigidResult) -> FlexResult:
    """Step 2 on the records of role estimate and use flex or both; empty, with a remark, for a joint that cannot flex.

    Raises NumericsError where step 1 found no inertia or a record is not excited in the band.
    """
    joint = assemble(settings.structure())
    parameters = known_parameters(settings, joint).with_values(rigid.guesses)
    records = [r for r in recordings.records if r.role == "estimate" and r.use in ("flex", "both")]
    return fit_flexible(joint, parameters, rigid, records, settings.init_flex.band, settings.init_flex.window)
