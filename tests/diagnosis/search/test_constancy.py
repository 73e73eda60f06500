"""The size of a cause is the same in all parts of the records, or it is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from robotid.diagnosis.scoring.blocked_regression import BlockedRegression, blocked
from robotid.diagnosis.search.constancy import course, varies
from robotid.model.array import Array

N = 4000


def left(size: Array, seed: int = 1) -> BlockedRegression:
    """What is left beside a constant of an effect of this size over time (n,), fitted with size one."""
    rng = np.random.default_rng(seed)
    effect = np.sin(np.arange(N) * 0.05)
    signal = (size - 1.0) * effect + 0.3 * rng.standard_normal(N)
    return blocked(np.stack([np.ones(N), effect]), signal, N / 40)


def test_an_effect_of_one_size_does_not_vary() -> None:
    found = [course(left(np.ones(N), seed)) for seed in range(50)]
    assert not any(varies(one, 1e-3) for one in found)
    assert np.mean([one.p_value for one in found]) == pytest.approx(0.5, abs=0.15)


def test_an_effect_that_comes_and_goes_does() -> None:
    fading = np.linspace(2.0, 0.0, N)
    found = course(left(fading))
    assert varies(found, 1e-3)
    assert found.parts == pytest.approx([1.75, 1.25, 0.75, 0.25], abs=0.1)


def test_an_effect_that_varies_a_little_is_let_pass() -> None:
    """Whatever else the model lacks makes it vary by so much."""
    found = course(left(np.linspace(1.3, 0.7, N)))
    assert found.p_value < 1e-3
    assert not varies(found, 1e-3)


def test_sine_and_cosine_count_together() -> None:
    """One of them may be near zero, and would then vary by many times its size."""
    rng = np.random.default_rng(2)
    t = np.arange(N) * 0.05
    columns = np.stack([np.ones(N), np.sin(t), np.cos(t)])
    blocks = blocked(columns, 0.1 * rng.standard_normal(N), N / 40)
    both = blocks.combined({1: 1.0, 2: 1e-3})
    assert both.moment.shape[1] == 2
    assert both.information.sum(axis=0)[1, 1] == pytest.approx(float(np.sum((np.sin(t) + 1e-3 * np.cos(t)) ** 2)))
    assert not varies(course(both), 1e-3)


def test_a_part_that_knows_nothing_of_an_effect_says_nothing() -> None:
    blocks = left(np.ones(N))
    silent, mute = blocks.information.copy(), blocks.moment.copy()
    silent[-10:], mute[-10:] = 0.0, 1e-20
    found = course(replace(blocks, information=silent, moment=mute))
    assert found.parts[-1] == 1.0
    assert found.spread < 0.1
