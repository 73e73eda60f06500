"""Promises that every channel keeps, over the registry: a new file is covered at once."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.channels import CHANNELS
from robotid.model.array import Array
from robotid.model.channel import Channel
from robotid.model.companion import Course

H = 5e-4
SAMPLES = 300

RNG = np.random.default_rng(0)


def beside(channel: Channel) -> Channel:
    """A channel beside its companion, where it reads one."""
    if channel.companion is None:
        return channel
    course = Course(np.stack([48.0 + RNG.normal(size=SAMPLES), *np.zeros((2, SAMPLES))]), H)
    return channel.reading("bus").beside({"bus": course})


every_channel = pytest.mark.parametrize("channel", [beside(c) for c in CHANNELS.values()], ids=list(CHANNELS))
every_seed = pytest.mark.parametrize("seed", range(5))


def wandering(seed: int, *shape: int) -> Array:
    rng = np.random.default_rng(seed)
    return np.asarray(np.cumsum(rng.normal(size=(*shape, SAMPLES)), axis=-1) * 0.1)


def values(channel: Channel, seed: int) -> list[float]:
    rng = np.random.default_rng(100 + seed)
    return [float(np.clip((p.guess or 1.0) * rng.uniform(0.4, 2.5), *p.bounds)) for p in channel.parameters]


@every_seed
@every_channel
def test_partials_are_the_derivatives(channel: Channel, seed: int) -> None:
    signal, p = wandering(seed), values(channel, seed)
    declared = channel.partials(signal, H, p)
    assert declared.shape == (len(p), SAMPLES)
    for i, value in enumerate(p):
        step = 1e-5 * abs(value)
        ahead, behind = (channel.apply(signal, H, [*p[:i], value + e, *p[i + 1 :]]) for e in (step, -step))
        exact = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(declared[i], exact, atol=1e-7 * np.max(np.abs(exact)), rtol=0)


@every_seed
@every_channel
def test_push_is_the_derivative_to_the_signal(channel: Channel, seed: int) -> None:
    signal, p = wandering(seed), values(channel, seed)
    columns = wandering(50 + seed, 3)
    pushed = channel.push(columns, signal, H, p)
    assert pushed.shape == columns.shape
    for column, one in zip(columns, pushed, strict=True):
        step = 1e-4
        exact = (channel.apply(signal + step * column, H, p) - channel.apply(signal - step * column, H, p)) / (2 * step)
        np.testing.assert_allclose(one, exact, atol=1e-8 * np.max(np.abs(exact)), rtol=0)


@every_channel
def test_channel_is_none_at_its_null(channel: Channel) -> None:
    signal, p = wandering(0), values(channel, 0)
    nulls = [value if q.null is None else q.null for q, value in zip(channel.parameters, p, strict=True)]
    np.testing.assert_array_equal(channel.apply(signal, H, nulls), signal)
    np.testing.assert_array_equal(channel.push(signal, signal, H, nulls), signal)


@every_channel
def test_missing_channel_can_be_scored_at_its_null(channel: Channel) -> None:
    p = values(channel, 0)
    nulls = [value if q.null is None else q.null for q, value in zip(channel.parameters, p, strict=True)]
    columns = channel.partials(wandering(0), H, nulls)
    for parameter, column in zip(channel.parameters, columns, strict=True):
        if parameter.null is not None:
            assert np.any(column), parameter.symbol


@every_channel
def test_the_future_does_not_act(channel: Channel) -> None:
    signal, p = wandering(0), values(channel, 0)
    other = signal.copy()
    other[200:] += 1.0
    before, after = (channel.apply(u, H, p) for u in (signal, other))
    np.testing.assert_array_equal(before[:200], after[:200])
    assert np.any(before[200:] != after[200:])


@every_channel
def test_the_signal_itself_is_left_alone(channel: Channel) -> None:
    signal, p = wandering(0), values(channel, 0)
    kept = signal.copy()
    channel.apply(signal, H, p)
    channel.push(signal, signal, H, p)
    channel.partials(signal, H, p)
    np.testing.assert_array_equal(signal, kept)
