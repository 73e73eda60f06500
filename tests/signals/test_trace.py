"""Traces: short ones whole, long ones by their peaks."""

from __future__ import annotations

import numpy as np

from robotid.signals.trace import MAX_SAMPLES, downsampled


def test_a_short_trace_is_whole() -> None:
    t = np.arange(float(MAX_SAMPLES))
    trace = downsampled(t, np.sin(t), np.cos(t), "rad")
    np.testing.assert_array_equal(trace.t, t)
    np.testing.assert_array_equal(trace.simulated, np.cos(t))


def test_a_long_trace_keeps_every_peak_of_signal_and_error() -> None:
    t = 0.001 * np.arange(1_000_003.0)
    measured, simulated = np.sin(t), np.sin(t)
    measured[[400_001, 700_000]] += 5.0, -6.0
    simulated[[123_456, 400_001]] += 0.3, 5.0
    trace = downsampled(t, measured, simulated, "rad")
    assert MAX_SAMPLES // 4 < len(trace.t) <= MAX_SAMPLES
    assert np.all(np.diff(trace.t) > 0)
    for peak in (400_001, 700_000, 123_456):
        (k,) = np.flatnonzero(trace.t == t[peak])
        assert trace.measured[k] == measured[peak]
        assert trace.simulated[k] == simulated[peak]
    assert trace.t[-1] > t[-300]
