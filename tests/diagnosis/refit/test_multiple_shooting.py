"""A fit by way of short pieces finds what a fit of whole records slips past."""

from __future__ import annotations

import pytest
from support.small_bench import bench, records

from robotid.diagnosis.refit.multiple_shooting import try_from_pieces
from robotid.diagnosis.refit.refitted_model import extended, refit


def test_strong_cogging_is_found_where_a_fit_of_whole_records_slips_into_another_valley() -> None:
    truth = {"motor.cogging.A": 0.15, "motor.cogging.B": -0.075, "motor.cogging.n": 12.0}
    benched, first = bench(records(truth))
    structure, start = extended(first, "motor.cogging", truth | {"motor.cogging.A": 0.135, "motor.cogging.n": 12.005})
    astray = refit(structure, [start], benched, first.motions)
    found = try_from_pieces(structure, [start], benched, enough=0.0)
    assert found.energy < 0.1 * astray.energy
    assert found.held_energy < 0.2 * astray.held_energy
    assert found.parameters["motor.cogging.n"] == pytest.approx(truth["motor.cogging.n"], abs=0.005)
