"""Table 3 on a model that is exact, and on one that is not."""

from __future__ import annotations

import numpy as np
import pytest
from support.judged_records import clean_records, model
from support.paper_joint import TRUTH

from robotid.estimate.fitted_model import simulate_record
from robotid.signals.metrics import fit_percent
from robotid.validation import perturbation
from robotid.validation.perturbation import perturb

RECORD = clean_records()[0]


def test_every_change_of_the_truth_loses():
    table = perturb(model({}), simulate_record(model({}), RECORD), 20.0)
    assert set(table.names) == set(TRUTH)
    assert (table.plus <= 0).all()
    assert (table.minus <= 0).all()
    lost = dict(zip(table.names, table.plus, strict=True))
    assert lost["motor.coulomb.Fc"] < lost["gear.damper.d"] < lost["gear.cubic_spring.k3"]


def test_towards_the_truth_gains_and_away_from_it_loses():
    wrong = model({"motor.coulomb.Fc": 0.8 * TRUTH["motor.coulomb.Fc"]})
    table = perturb(wrong, simulate_record(wrong, RECORD), 20.0)
    at = table.names.index("motor.coulomb.Fc")
    assert table.plus[at] > 5
    assert table.minus[at] < -5


def test_an_entry_is_the_loss_of_fit_with_that_parameter_changed():
    table = perturb(model({}), simulate_record(model({}), RECORD), 20.0)
    at, truth = table.names.index("motor.coulomb.Fc"), TRUTH["motor.coulomb.Fc"]
    for factor, entry in ((1.2, table.plus[at]), (0.8, table.minus[at])):
        changed = simulate_record(model({"motor.coulomb.Fc": factor * truth}), RECORD)
        assert entry == pytest.approx(fit_percent(RECORD.dphi_m, changed.signal("speed")) - 100.0, abs=1e-3)


def test_no_perturbation_changes_nothing():
    table = perturb(model({}), simulate_record(model({}), RECORD), 0.0)
    np.testing.assert_allclose([table.plus, table.minus], 0.0, atol=1e-6)


def test_a_parameter_of_zero_has_no_percent():
    assert "gear.damper.d" not in perturb(model({"gear.damper.d": 0.0}), simulate_record(model({}), RECORD), 1.0).names


def test_pieces_and_prediction_give_the_same_table(monkeypatch: pytest.MonkeyPatch):
    simulated = simulate_record(model({}), RECORD)
    predicted = perturb(model({}), simulated, 20.0)
    monkeypatch.setattr(perturbation, "LARGEST_PREDICTION", 0)
    plain = perturb(model({}), simulated, 20.0)
    np.testing.assert_allclose(plain.plus, predicted.plus, atol=1e-3)
    np.testing.assert_allclose(plain.minus, predicted.minus, atol=1e-3)
