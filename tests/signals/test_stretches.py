"""Long records are looked at in stretches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.estimate.fitted_model import Simulated, joined
from robotid.signals.record import Record
from robotid.signals.stretches import MAX_STRETCHES, stretches


def counted(n: int, period: float | None = None) -> Record:
    samples = np.arange(n, dtype=np.float64)
    return Record("long", "estimate", "both", 0.01, samples, samples, samples, period=period)


def test_a_record_that_is_short_enough_stays_whole() -> None:
    record = counted(1000)
    assert stretches(record, 1000) == (record,)


def test_stretches_reach_from_the_beginning_to_the_end_and_do_not_overlap() -> None:
    found = stretches(counted(10_000), 1000)
    taken = np.concatenate([s.phi_m for s in found])
    assert len(found) == MAX_STRETCHES
    assert (taken[0], taken[-1], len(taken)) == (0, 9999, 1000)
    assert np.all(np.diff(taken) > 0)
    assert all(s.t[0] == pytest.approx(0.01 * s.phi_m[0]) for s in found)


@pytest.mark.parametrize(("samples", "count"), [(1000, 2), (2400, MAX_STRETCHES), (450, 1)])
def test_a_stretch_holds_a_period_where_the_samples_allow_it(samples: int, count: int) -> None:
    found = stretches(counted(10_000, period=4.0), samples)
    assert len(found) == count
    assert sum(map(len, found)) <= samples
    assert all(len(s) >= 400 for s in found)


def test_joined_stretches_keep_their_times() -> None:
    parts = stretches(counted(10_000), 1000)
    whole = joined([Simulated(part, (part,), ()) for part in parts])
    np.testing.assert_array_equal(whole.t, np.concatenate([part.t for part in parts]))
    np.testing.assert_array_equal(whole.measured("speed"), np.concatenate([part.dphi_m for part in parts]))
    assert whole.record.phi_a is None
    alone = Simulated(replace(parts[0], phi_a=None), (parts[0],), ())
    assert joined([alone]) is alone
