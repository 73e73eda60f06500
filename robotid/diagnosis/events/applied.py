"""The torque of a known event, and records from which it is taken."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from robotid.diagnosis.events.settings import EVENTS
from robotid.diagnosis.results import Event
from robotid.model.array import Array
from robotid.signals.record import Record


def without_events(record: Record, events: Iterable[Event]) -> Record:
    """The record as it would drive a machine to which none of its events happens: their torque is added to that of the
    motor, so that a model without them moves as was measured. record : whole, or a piece of one."""
    own = [event for event in events if event.record == record.name]
    return replace(record, tau_m=record.tau_m + sum(event_torque(one, record) for one in own)) if own else record


def event_torque(event: Event, record: Record) -> Array:
    """What an event adds to the torque at the motor [Nm], (n,)."""
    t, h = record.t, record.sampling_time
    if event.kind == "drift":
        course = np.clip((t - event.start) / max(event.end - event.start, h), 0.0, 1.0)
    elif event.gradual:
        course = mean_of_gradual(t, t + h, event.start, event.end)
    else:
        # A sample counts as far as the interval after it lies within the event.
        last = np.inf if event.kind == "step" else event.end
        course = np.clip(np.minimum(t + h, last) - np.maximum(t, event.start), 0.0, h) / h
    return np.asarray(event.torque * course * (-direction(record.dphi_m) if event.friction else 1.0))


def mean_of_gradual(begin: Array, end: Array, start: Array | float, stop: Array | float) -> Array:
    """Mean over intervals from begin to end of a raised cosine of height one that lasts from start to stop."""

    def risen(t: Array) -> Array:
        within = np.clip((t - start) / (stop - start), 0.0, 1.0)
        return np.asarray((within - np.sin(2 * np.pi * within) / (2 * np.pi)) / 2 * (stop - start))

    return np.asarray((risen(end) - risen(begin)) / (end - begin))


def direction(speed: Array) -> Array:
    """Direction of a measured motion, (n,) between -1 and 1: it fades where the speed is next to nothing."""
    largest = float(np.abs(speed).max()) or 1.0
    return np.clip(speed / (EVENTS.standstill * largest), -1.0, 1.0)
