"""What a search finds on records of the small axis of which one differs."""

from __future__ import annotations

from functools import cache

from robotid.diagnosis.search.state import SearchResult
from support.small_bench import QUICK, records, searched


@cache
def one_that_differs() -> SearchResult:
    """Dry friction of half as much again in one record of the fit."""
    return searched(records({}, changed={"motor.coulomb.Fc": 1.5}), QUICK)
