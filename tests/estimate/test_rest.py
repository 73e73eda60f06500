"""Where a motor rests."""

from __future__ import annotations

import numpy as np
from support.small_bench import SAMPLING_TIME, made_along

from robotid.estimate.rest import at_rest


def test_a_pause_is_rest_and_a_reversal_is_not() -> None:
    t = np.arange(2000) * SAMPLING_TIME
    speed = 6.0 * np.sin(2 * np.pi * t)
    (moving, paused) = made_along({"moving": speed, "paused": np.where((t > 1.0) & (t < 2.0), 0.0, speed)})
    assert not at_rest(moving)[100:].any()
    assert at_rest(paused)[700:900].all()
    assert not at_rest(paused)[1100:].any()
