"""What a refit comes to on records that are simulated in pieces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_bench import begun, records

from robotid.diagnosis.refit.refitted_model import SegmentFit
from robotid.signals.metrics import fit_percent


def held_still(one: SegmentFit) -> SegmentFit:
    """A piece in which the measured motor hardly moves."""
    still = replace(one.record, dphi_m=one.residual + 1e-9 * np.arange(len(one.record)))
    return replace(one, record=still, fit_percent=-1e12)


def test_pieces_of_a_record_count_together_lest_a_rest_decides() -> None:
    model = begun(records({})).model
    (whole,) = model.validation
    cut = [slice(0, 700), slice(700, 1400), slice(1400, len(whole.record))]
    pieces = [replace(whole, record=whole.record.piece(a.start, a.stop), residual=whole.residual[a]) for a in cut]
    in_pieces = replace(model, validation=tuple(pieces))
    assert in_pieces.validation_fit_percent == pytest.approx(whole.fit_percent)
    resting = replace(model, validation=(*pieces[:2], held_still(pieces[2])))
    speed = np.concatenate([one.record.dphi_m for one in resting.validation])
    assert resting.validation_fit_percent == pytest.approx(fit_percent(speed, speed - whole.residual))
    assert resting.validation_fit_percent > 90.0


def test_records_count_alike() -> None:
    model = begun(records({})).model
    (one,) = model.validation
    other = replace(one, record=replace(one.record, name="other"), fit_percent=one.fit_percent - 10.0)
    both = replace(model, validation=(one, other))
    assert both.validation_fit_percent == pytest.approx(one.fit_percent - 5.0)
