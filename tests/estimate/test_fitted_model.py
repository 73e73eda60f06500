"""First states of a record that the fit never saw."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.judged_records import clean_records, model

from robotid.errors import ConfigError
from robotid.estimate.fitted_model import simulate_record
from robotid.signals.metrics import fit_percent


def test_first_states_are_found_on_the_record_itself():
    record = clean_records()[1].piece(1000, 3000)  # amid motion: twisted, and the arm not rigid
    asked = replace(model({}), first_states={}, estimate_states=True)
    guessed = simulate_record(replace(asked, estimate_states=False), record)
    found = simulate_record(asked, record)
    assert fit_percent(record.dphi_m, guessed.signal("speed")) < 99
    assert fit_percent(record.dphi_m, found.signal("speed")) == pytest.approx(100, abs=1e-3)


def test_pieces_start_afresh():
    record = clean_records()[0]
    wrong = replace(model({"motor.viscous.Fv": 0.02}), estimate_states=True)
    whole, pieces = simulate_record(wrong, record), simulate_record(wrong, record, horizon=0.5)
    assert [len(piece) for piece in pieces.pieces] == [1000, 1000, 1000]
    assert pieces.signal("speed").shape == record.dphi_m.shape
    error = [np.linalg.norm(s.signal("speed") - record.dphi_m) for s in (whole, pieces)]
    assert error[1] < 0.5 * error[0]


def test_pieces_of_hardly_a_sample_are_refused():
    with pytest.raises(ConfigError, match=r"^horizon: 0\.001 s are fewer than 20 samples of small; give a longer one"):
        simulate_record(model({}), clean_records()[0], horizon=1e-3)


def test_parameters_stay_as_they_are():
    held = simulate_record(replace(model({}), estimate_states=True), clean_records()[0])
    np.testing.assert_array_equal(held.trajectories[0].theta, model({}).theta)
