"""Numbers of the tables of records and of the rigid start: written out, and those that the remarks beside them mean."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

import robotid as rid
from robotid.catalogue import assemble
from robotid.estimate.rigid import DISTINCT, fit_rigid
from robotid.model.structure import Structure
from robotid.report.tables import collect, init_rigid, validate
from robotid.signals.quality import Recordings, inspect
from robotid.signals.record import Record

H, N = 0.001, 3000
T = np.arange(N) * H


def record() -> Record:
    """A rigid axis of little viscous friction, whose torque carries noise as slow as the motion."""
    speed = 10 * np.sin(2 * np.pi * 2 * T) + 4 * np.sin(2 * np.pi * 7 * T)
    slow = lfilter([0.02], [1.0, -0.98], np.random.default_rng(1).standard_normal(N))
    torque = 0.01 * np.gradient(speed, H) + 0.0015 * speed + 0.3 * np.sign(speed) + slow
    return Record("log", "estimate", "both", H, torque, np.cumsum(speed) * H, speed)


@pytest.mark.parametrize(("share", "text"), [(1.0, "100"), (0.996, "100"), (0.41, "41"), (0.0, "0")])
def test_a_share_of_all_samples_is_written_out(share: float, text: str) -> None:
    report = replace(inspect(record(), "log.csv"), saturation=share, still=share)
    table = next(t for t in collect.tables(Recordings((record(),), (report,))) if t.title.startswith("Signals"))
    (row,) = table.rows
    assert row[table.columns.index("saturated [%]")] == row[table.columns.index("at rest [%]")] == text


def test_what_is_not_distinct_from_zero_is_so_by_the_deviation_beside_it() -> None:
    """Under white residuals the same value would be distinct."""
    joint = assemble(Structure(("motor.inertia", "motor.viscous", "motor.coulomb")))
    found = fit_rigid(joint, joint.parameters(), [record()])
    viscous = found["motor.viscous.Fv"]
    assert DISTINCT * viscous.std < abs(viscous.value) < DISTINCT * viscous.std_robust
    table = init_rigid.tables(found)[0]
    (row,) = [row for row in table.rows if row[0] == "motor.viscous.Fv"]
    value, deviation = (float(row[table.columns.index(column)]) for column in ("value", "sd"))
    assert "not distinct from zero" in row[-1]
    assert abs(value) < DISTINCT * deviation
    assert not re.search(r"\de\+0\d", " ".join(row))


def test_the_error_of_a_perfect_simulation_is_none() -> None:
    """Rounding has no digits that a person should read."""
    fit = rid.fit(rid.Model(motor=["inertia"]), record())
    found = rid.validate(fit, replace(record(), name="day2"), perturbation=None)
    model = found.models[found.best]
    perfect = replace(model.records["day2"], rmse_speed=4.03e-17, rmse_position=2e-16)
    changed = replace(found, models={found.best: replace(model, records={"day2": perfect})})
    (errors,) = [table for table in validate.tables(changed) if any("RMSE" in column for column in table.columns)]
    (row,) = errors.rows
    assert [row[k] for k, column in enumerate(errors.columns) if "rad" in column or "RMSE" in column] == ["0", "0"]
