"""Bode magnitudes beside measured responses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.judged_records import model
from support.paper_joint import SAMPLING_TIME, TRUTH

from robotid.model.linear import linearise
from robotid.signals.frf import Frf
from robotid.validation.bode import bode

FREQUENCY = np.linspace(1.0, 40.0, 60)


def measured(name: str, factor: float, frequency: np.ndarray[tuple[int], np.dtype[np.float64]] = FREQUENCY) -> Frf:
    m = model({})
    response = factor * linearise(m.joint, m.theta).response(2 * np.pi * frequency)
    return Frf(name, frequency, response, 0.01 * np.abs(response))


def test_distance_is_in_decibels():
    m = model({})
    found = bode(m.joint, m.theta, (measured("equal", 1.0), measured("double", 2.0)), SAMPLING_TIME)
    assert found is not None
    assert found.distance["equal"] == pytest.approx(0.0, abs=1e-9)
    assert found.distance["double"] == pytest.approx(20 * np.log10(2))


def test_a_line_without_response_counts_for_nothing():
    m, whole = model({}), measured("double", 2.0)
    silent = replace(whole, response=np.where(np.arange(60) == 30, 0.0, whole.response))
    found = bode(m.joint, m.theta, (silent,), SAMPLING_TIME)
    assert found is not None
    assert found.distance["double"] == pytest.approx(20 * np.log10(2))


def test_frequencies_of_all_responses_once():
    m = model({})
    other = measured("other", 1.0, FREQUENCY[::2] + 0.1)
    found = bode(m.joint, m.theta, (measured("one", 1.0), measured("two", 1.0), other), SAMPLING_TIME)
    assert found is not None
    assert len(found.frequency) == 90
    np.testing.assert_allclose(found.acceleration, 2 * np.pi * found.frequency * found.speed)
    assert found.acceleration[-1] == pytest.approx(1 / TRUTH["motor.inertia.J"], rel=0.1)


def test_nothing_measured_nothing_drawn():
    m = model({})
    assert bode(m.joint, m.theta, (), SAMPLING_TIME) is None
