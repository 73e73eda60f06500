"""The factor of a Jacobian of many records, from those of each."""

from __future__ import annotations

import numpy as np
import pytest

from robotid.estimate.residual import joined_factor
from robotid.model.array import Array

SHARED, OWN, SAMPLES = 4, 3, 9


@pytest.mark.parametrize("records", [1, 2, 40])
@pytest.mark.parametrize("own", [0, OWN])
def test_it_holds_what_the_whole_jacobian_does(records: int, own: int) -> None:
    rng = np.random.default_rng(records)
    numbers = [np.r_[:SHARED, SHARED + own * k : SHARED + own * (k + 1)] for k in range(records)]
    jacobian = np.zeros((records * SAMPLES, SHARED + own * records))
    triangles = list[Array]()
    for k, at in enumerate(numbers):
        values = rng.standard_normal((SAMPLES, len(at)))
        jacobian[k * SAMPLES : (k + 1) * SAMPLES, at] = values
        triangles.append(np.asarray(np.linalg.qr(values, mode="r")))
    factor = joined_factor(triangles, numbers)
    assert factor.shape == (jacobian.shape[1],) * 2
    assert factor.T @ factor == pytest.approx(jacobian.T @ jacobian, abs=1e-12)
