"""The tests of a watched log have the distribution that they claim where nothing has changed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from robotid.diagnosis.scoring.blocked_regression import blocked
from robotid.model.array import Array
from robotid.monitoring.evidence import (
    LogEvidence,
    parameters_p_value,
    residual_p_value,
    single_shift,
    together_p_value,
)

SAMPLES, BLOCKS, PARAMETERS = 1000, 20, 3
DRAWS, LEVEL = 120, 0.05
MIXED = np.array([[1.0, 0.0, 0.0], [0.8, 0.6, 0.0], [0.2, -0.3, 0.9]])


def evidence(generator: np.random.Generator, theta: Array, memory: float = 0.0, loud: float = 1.0) -> LogEvidence:
    """A record whose residual asks for parameters theta, beside noise that may have a memory."""
    columns = MIXED @ generator.standard_normal((PARAMETERS, SAMPLES))
    noise = generator.standard_normal(SAMPLES)
    for k in range(1, SAMPLES if memory else 0):
        noise[k] += memory * noise[k - 1]
    part = blocked(columns, theta @ columns + loud * noise, SAMPLES / BLOCKS)
    return LogEvidence(part, np.full(part.count, SAMPLES / part.count))


def pair(seed: int, shift: Array, memory: float = 0.0, loud: float = 1.0) -> tuple[LogEvidence, LogEvidence]:
    """The records of a fit and a log: the fit's own error is a shift that the log asks for."""
    generator = np.random.default_rng(seed)
    fitted = evidence(generator, np.zeros(PARAMETERS), memory)
    error = fitted.blocks.estimate()
    settled = LogEvidence(
        type(fitted.blocks)(
            fitted.blocks.information,
            fitted.blocks.moment - np.einsum("bij,j->bi", fitted.blocks.information, error),
            fitted.blocks.energy,
        ),
        fitted.lengths,
    )
    return settled, evidence(generator, shift - error, memory, loud)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_the_tests_alarm_as_often_as_their_level_where_nothing_has_changed(memory: float) -> None:
    draws = DRAWS if memory == 0.0 else DRAWS // 3
    pairs = [pair(seed, np.zeros(PARAMETERS), memory) for seed in range(draws)]
    together = sum(together_p_value(*one) < LEVEL for one in pairs)
    single = sum(single_shift(*one, 1).p_value < LEVEL for one in pairs)
    either = sum(parameters_p_value(*one) < LEVEL for one in pairs)
    most = binom.ppf(0.999, draws, LEVEL)
    assert max(together, single, either) <= most
    if memory == 0.0:
        louder = sum(residual_p_value(*one) < LEVEL for one in pairs)
        assert binom.ppf(0.001, draws, LEVEL) <= louder <= most
        assert min(together, single) > 0


def test_a_shift_is_found_with_its_size_and_uncertainty() -> None:
    one = pair(1, np.array([0.0, 0.3, 0.0]))
    found = single_shift(*one, 1)
    assert found.value == pytest.approx(0.3, abs=4 * found.std)
    assert found.std < 0.1
    assert parameters_p_value(*one) < 1e-3
    assert together_p_value(*one) < 1e-3


def test_louder_noise_is_a_larger_residual_and_no_change_of_parameters() -> None:
    one = pair(2, np.zeros(PARAMETERS), loud=1.5)
    assert residual_p_value(*one) < 1e-4
    assert parameters_p_value(*one) > LEVEL


def test_too_few_blocks_tell_nothing() -> None:
    generator = np.random.default_rng(3)
    columns = generator.standard_normal((PARAMETERS, 40))
    few = LogEvidence(blocked(columns, 5.0 * columns[0], 20), np.full(2, 20.0))
    assert together_p_value(few, few) == 1.0
