"""Causes that the search has accepted, judged once more by a fit as the pipeline makes it.

The search weighs a residual by its noise, and sees what is far below the rest of it. A cause that gains nothing in a
fit is not worth a name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotid.diagnosis.results import Cause, Diagnosis, Rejected, Verdict
from robotid.diagnosis.settings import VERDICT
from robotid.diagnosis.verdict import is_partial, without_cause

NOT_CONFIRMED = "a fit does not confirm it: the held-out records gain nothing by it"


def is_idle(cause: Cause) -> bool:
    """Whether a fit with a cause gains nothing on records that it was not fitted to, where there are any."""
    return cause.heldout_gain < VERDICT.least_gain


def without_causes(diagnosis: Diagnosis, idle: Sequence[Cause]) -> Diagnosis:
    """The diagnosis with causes rejected that a fit does not confirm."""
    kept = tuple(cause for cause in diagnosis.causes if cause not in idle)
    left = tuple(Rejected(one.effect, one.explained, one.heldout_gain, NOT_CONFIRMED) for one in idle)
    given = sum(one.explained for one in idle)
    share = min(1.0, diagnosis.remaining_share + given)
    energy = min(diagnosis.misfit**2, diagnosis.remaining**2 + given * diagnosis.misfit**2)
    remaining = diagnosis.misfit if not kept else float(np.sqrt(energy))
    whole = max(1.0 - diagnosis.remaining_share, 1e-300)
    records = {
        name: replace(one, explained_after=one.explained_after * (1.0 - share) / whole)
        for name, one in diagnosis.records.items()
    }
    return replace(
        diagnosis,
        verdict=_verdict(diagnosis, kept, share, remaining),
        causes=kept,
        rejected=(*left, *diagnosis.rejected),
        remaining=remaining,
        remaining_share=share,
        records=records,
    )


def _verdict(diagnosis: Diagnosis, kept: Sequence[Cause], share: float, remaining: float) -> Verdict:
    """In one word, with fewer causes."""
    if diagnosis.verdict == "not explained":
        return "not explained"
    if kept:
        partial = is_partial(share, diagnosis.misfit, remaining, diagnosis.noise_floor)
        return "partly named" if partial else diagnosis.verdict
    return without_cause(
        diagnosis.misfit, diagnosis.noise_floor, shape=diagnosis.shape is not None, events=bool(diagnosis.events)
    )
