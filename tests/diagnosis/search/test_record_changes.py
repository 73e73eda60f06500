"""A change of a validation record must explain it, and its fit must rise with it."""

from __future__ import annotations

from support.tuning.search import best_change


def test_a_change_with_which_the_fit_falls_is_none() -> None:
    rising, falling = best_change(0.5, gain=0.1), best_change(0.5, gain=-0.3)
    assert rising is not None
    assert falling is None
